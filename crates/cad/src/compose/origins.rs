//! Where every value of a composed text comes from: the sidecar, or an entity.
//!
//! Values are known by their path in the text, `bodies.crank.mass`.

use std::collections::BTreeMap;
use std::ops::Range;

use toml_edit::{Document, Item, Key, TableLike};

use super::spelling::Spellings;
use crate::drawing::Location;

/// Where a range of a composed text comes from.
#[derive(Clone, PartialEq, Debug)]
pub enum Origin {
    /// Words in the sidecar, the model file next to the drawing.
    Sidecar(Range<usize>),
    /// An entity of the drawing.
    Drawing(Location),
    /// Neither: composing made it.
    Composed,
}

/// A key or a value of a text.
#[derive(Clone, Debug)]
struct KeyOrValue {
    path: Vec<String>,
    is_key: bool,
    span: Range<usize>,
}

/// Where every value of a text comes from.
#[derive(Clone, Debug, Default)]
pub(super) struct Origins {
    text: Vec<KeyOrValue>,
    sidecar: BTreeMap<(Vec<String>, bool), Range<usize>>,
    drawing: BTreeMap<Vec<String>, Location>,
}

impl Origins {
    /// Of a composed text, of the sidecar, and of the values that the drawing gave.
    pub(super) fn new(
        text: &str,
        sidecar: &str,
        drawing: BTreeMap<Vec<String>, Location>,
        spellings: &Spellings,
    ) -> Self {
        let spelled = |piece: KeyOrValue| ((spellings.path(&piece.path), piece.is_key), piece.span);
        let sidecar = pieces(sidecar).into_iter().map(spelled).collect();
        let drawing = drawing.into_iter().map(|(path, at)| (spellings.path(&path), at)).collect();
        Self { text: pieces(text), sidecar, drawing }
    }

    /// Where a range of the composed text comes from.
    pub(super) fn find(&self, span: &Range<usize>) -> Origin {
        let holds =
            |piece: &&KeyOrValue| piece.span.start <= span.start && span.end <= piece.span.end;
        let found = self.text.iter().filter(holds).min_by_key(|piece| piece.span.len());
        let Some(piece) = found else { return Origin::Composed };
        if let Some(known) = self.sidecar.get(&(piece.path.clone(), piece.is_key)) {
            // The words are the same unless a table was added to; then the whole of it is meant.
            let is_same = known.len() == piece.span.len();
            let shift = |at: usize| known.start + (at - piece.span.start);
            return Origin::Sidecar(if is_same {
                shift(span.start)..shift(span.end)
            } else {
                known.clone()
            });
        }
        let mut path = piece.path.as_slice();
        loop {
            if let Some(location) = self.drawing.get(path) {
                return Origin::Drawing(location.clone());
            }
            match path {
                [] => return Origin::Composed,
                [before @ .., _] => path = before,
            }
        }
    }
}

/// All keys and values of a text; none where it is no TOML.
fn pieces(text: &str) -> Vec<KeyOrValue> {
    let mut found = Vec::new();
    let Ok(document) = Document::parse(text) else { return found };
    let mut waiting: Vec<(Vec<String>, &dyn TableLike)> = vec![(Vec::new(), document.as_table())];
    while let Some((path, table)) = waiting.pop() {
        for (name, item) in table.iter() {
            let mut inner = path.clone();
            inner.push(name.to_owned());
            if let Some(span) = table.key(name).and_then(Key::span) {
                found.push(KeyOrValue { path: inner.clone(), is_key: true, span });
            }
            if let Some(span) = item.span() {
                found.push(KeyOrValue { path: inner.clone(), is_key: false, span });
            }
            if let Some(table) = item.as_table_like() {
                waiting.push((inner, table));
            } else if let Item::ArrayOfTables(tables) = item {
                waiting.extend(tables.iter().map(|table| (inner.clone(), table as &dyn TableLike)));
            }
        }
    }
    found
}
