//! Values without a position: parameters, start, options and the name, in a column next to the drawing.

use bksim_model::Measure;
use toml_edit::{Item, TableLike};

use super::texts::{all, entries, text, words};
use super::units::{Dimension, KEYS, dimension};
use super::{SHEET_LAYER, Sketch, Unwritten, Values, kind, no_place};
use crate::kind::Kind;

impl Sketch<'_> {
    /// Writes all sheets, from the top of the drawing down, right of it; then the view of it.
    pub(super) fn sheet(&mut self) -> Result<(), Unwritten> {
        const PITCH: f64 = 1.2;
        let [low, high] = self.positions.extent();
        let sheets = self.sheets()?;
        let left = high[0] + 3.0 * self.size;
        let mut y = high[1];
        for (kind, values) in sheets {
            let at = [left, y];
            self.insert(kind, SHEET_LAYER, [at, [left + 1.0, y]], values)?;
            y -= PITCH * self.size;
        }
        let seen = [
            [low[0] - 6.0 * self.size, y.min(low[1] - 2.0 * self.size)],
            [left + 6.0 * self.size, high[1] + 2.0 * self.size],
        ];
        self.canvas.view(seen, seen);
        Ok(())
    }

    fn sheets(&self) -> Result<Vec<(&'static Kind, Values)>, Unwritten> {
        let mut sheets = vec![];
        let model = self.model_values();
        if !model.is_empty() {
            sheets.push((kind("model"), model));
        }
        for (name, item) in entries(self.document, "parameters") {
            let unwritten = || no_place("the value", &format!("the parameter `{name}`"));
            let value = item.as_value().map(text).ok_or_else(unwritten)?;
            sheets.push((kind("parameter"), vec![("name", name.to_owned()), ("value", value)]));
        }
        sheets.extend(self.named_sheets()?);
        for (name, item) in entries(self.document, "initial") {
            for values in self.initial(name, item)? {
                sheets.push((kind("initial"), values));
            }
        }
        if let Some(table) = self.document.get("solve").and_then(Item::as_table_like) {
            let values = self.keys_of("solve", "`[solve]`", table)?;
            if !values.is_empty() {
                sheets.push((kind("solve"), values));
            }
        }
        sheets.extend(self.io_sheet()?);
        Ok(sheets)
    }

    /// Name, policy of coordinates and units of bare numbers.
    fn model_values(&self) -> Values {
        let top = self.document.as_table();
        let stated = ["name", "coordinates"].map(|key| (key, words(top, key)));
        let units = self.document.get("units").and_then(Item::as_table_like);
        let units = KEYS.map(|(key, _)| (key, units.and_then(|table| words(table, key))));
        let all = stated.into_iter().chain(units);
        all.filter_map(|(key, words)| Some((key, words?))).collect()
    }

    /// One entry of `[initial]`: stated values and guesses, as inserts of their own.
    fn initial(&self, name: &str, item: &Item) -> Result<Vec<Values>, Unwritten> {
        let named = || vec![("name", name.to_owned())];
        let owner = format!("the start of `{name}`");
        let Some(table) = item.as_table_like() else {
            let mut values = named();
            values.extend(item.as_value().map(|value| ("value", text(value))));
            return Ok(vec![values]);
        };
        let mut both = Vec::new();
        let mut stated = named();
        stated.extend(self.keys_of("initial", &owner, table)?);
        if stated.len() > 1 {
            both.push(stated);
        }
        if let Some(guess) = table.get("guess") {
            let mut values = named();
            match guess.as_table_like() {
                Some(table) => values.extend(self.keys_of("initial", &owner, table)?),
                None => values.extend(guess.as_value().map(|value| ("value", text(value)))),
            }
            for (key, words) in values.iter_mut().skip(1) {
                self.replace_guess(name, key, words);
            }
            values.push(("guess", "true".to_owned()));
            both.push(values);
        }
        Ok(both)
    }

    /// Replaces the guess of a position by its value at the start: the drawing shows it, and with any
    /// other guess the start would move on from there.
    fn replace_guess(&self, name: &str, key: &str, words: &mut String) {
        let full = if key == "value" { name.to_owned() } else { format!("{name}.{key}") };
        let mut guesses = self.model.initial.iter().filter(|initial| initial.is_guess);
        let Some(guess) = guesses.find(|initial| initial.name == full) else { return };
        let near = self.positions.number(guess.value).unwrap_or_default();
        let Some(found) = self.positions.found(guess.measure, near) else { return };
        let slides = match guess.measure {
            Measure::JointPosition(joint, 0) => self.slides(joint, Some("position")),
            Measure::PointPosition(..) => true,
            _ => false,
        };
        *words = format!("{found} {}", if slides { "m" } else { "rad" });
    }

    /// The values of a table whose keys are those of a kind.
    fn keys_of(&self, of: &str, owner: &str, table: &dyn TableLike) -> Result<Values, Unwritten> {
        let kind = kind(of);
        let mut values = Values::new();
        for (key, item) in all(table) {
            if key == "guess" {
                continue;
            }
            let unwritten = || no_place(&format!("`{key}`"), owner);
            let known = kind.keys.iter().find(|known| **known == key);
            let &known = known.ok_or_else(unwritten)?;
            let words = item.as_value().map(text).ok_or_else(unwritten)?;
            let dimension = match (of, key) {
                ("solve", "every") if words == "step" => Dimension::Open,
                _ => dimension(of, key, false),
            };
            values.push((known, self.units.complete(words, dimension)));
        }
        Ok(values)
    }
}
