//! [`Document`]: the text of a model with its history.

use crate::apply::edited;
use crate::edit::{Deed, Edit, EditError};

/// The text of a model, with every change to be undone.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Document {
    text: String,
    past: Vec<Change>,
    future: Vec<Change>,
}

/// One difference of two texts: the old words of a place, and the new ones.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Change {
    at: usize,
    old: String,
    new: String,
    /// Whether the next edit of the same subject goes with it: [`subject`].
    open: Option<String>,
}

impl Change {
    /// The shortest one that leads from one text to another.
    fn between(old: &str, new: &str, open: Option<String>) -> Self {
        let mut at = old.bytes().zip(new.bytes()).take_while(|(a, b)| a == b).count();
        while !(old.is_char_boundary(at) && new.is_char_boundary(at)) {
            at -= 1;
        }
        let (a, b) = (&old[at..], &new[at..]);
        let mut tail = a.bytes().rev().zip(b.bytes().rev()).take_while(|(a, b)| a == b).count();
        while !(a.is_char_boundary(a.len() - tail) && b.is_char_boundary(b.len() - tail)) {
            tail -= 1;
        }
        let (old, new) = (a[..a.len() - tail].to_owned(), b[..b.len() - tail].to_owned());
        Self { at, old, new, open }
    }

    fn undo(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.new.len(), &self.old);
    }

    fn redo(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.old.len(), &self.new);
    }
}

/// The subject of an edit that a moving hand makes many times.
fn subject(edit: &Edit) -> Option<String> {
    match edit {
        Edit::Set { path, .. } => Some(format!("set {path}")),
        Edit::Move { point, .. } => Some(format!("move {point}")),
        Edit::Group { names, to: Deed::Move(_) } => Some(format!("move {}", names.join(" "))),
        Edit::Several { edits } => {
            let all: Option<Vec<String>> = edits.iter().map(subject).collect();
            all.map(|all| all.join(", "))
        }
        _ => None,
    }
}

impl Document {
    /// A text without a history.
    pub fn new(text: &str) -> Self {
        Self { text: text.to_owned(), past: Vec::new(), future: Vec::new() }
    }

    /// The text as it is now.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Makes an edit, which can be undone by itself.
    ///
    /// # Errors
    /// [`EditError`]; the text is then as it was.
    pub fn apply(&mut self, edit: &Edit) -> Result<(), EditError> {
        let new = edited(&self.text, edit)?;
        self.take(new, None);
        Ok(())
    }

    /// Applies an edit of a subject that earlier edits are about, as a slider makes them ([`Document::apply`]): each takes
    /// the place of the one before, and all are undone together.
    ///
    /// # Errors
    /// [`EditError`]; the text is then as it was.
    pub fn apply_moving(&mut self, edit: &Edit) -> Result<(), EditError> {
        let subject = subject(edit);
        let is_same = self.future.is_empty()
            && subject.is_some()
            && self.past.last().is_some_and(|last| last.open == subject);
        // The hand moves what was there when it began.
        let mut before = self.text.clone();
        if let Some(last) = self.past.last().filter(|_| is_same) {
            last.undo(&mut before);
        }
        let new = edited(&before, edit)?;
        if is_same {
            self.past.pop();
            self.text = before;
        }
        self.take(new, subject);
        Ok(())
    }

    /// Ends a series of [`Document::apply_moving`]: the next one is undone by itself.
    pub fn settle(&mut self) {
        if let Some(last) = self.past.last_mut() {
            last.open = None;
        }
    }

    fn take(&mut self, new: String, open: Option<String>) {
        if new == self.text {
            return;
        }
        self.past.push(Change::between(&self.text, &new, open));
        self.future.clear();
        self.text = new;
    }

    /// Whether there is something to undo, and to redo.
    pub fn can_undo_and_redo(&self) -> [bool; 2] {
        [!self.past.is_empty(), !self.future.is_empty()]
    }

    /// Takes the last edit back; false where there is none.
    pub fn undo(&mut self) -> bool {
        let Some(mut change) = self.past.pop() else { return false };
        change.undo(&mut self.text);
        change.open = None;
        self.future.push(change);
        true
    }

    /// Makes the edit that was taken back last; false where there is none.
    pub fn redo(&mut self) -> bool {
        let Some(change) = self.future.pop() else { return false };
        change.redo(&mut self.text);
        self.past.push(change);
        true
    }
}
