//! [`Draft`]: a text under change, by splices that leave all other bytes as they are.

use std::ops::Range;

use bksim_model::file::{NAMED, SECTIONS};

use crate::edit::EditError;
use crate::places::Places;
use crate::scan::{Kind, Place};

/// A text under change.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    pub(crate) text: String,
}

impl Draft {
    pub(crate) fn new(text: &str) -> Self {
        Self { text: text.to_owned() }
    }

    /// The places of the text as it is now.
    ///
    /// # Errors
    /// [`EditError::Unreadable`] where it is not TOML.
    pub(crate) fn places(&self) -> Result<Places<'_>, EditError> {
        Places::of_whole(&self.text).ok_or(EditError::Unreadable)
    }

    fn splice(&mut self, range: Range<usize>, new: &str) {
        self.text.replace_range(range, new);
    }

    /// The line ending of the text.
    fn newline(&self) -> &'static str {
        if self.text.contains("\r\n") { "\r\n" } else { "\n" }
    }

    /// Replaces the value at a path by `value`, TOML already.
    ///
    /// # Errors
    /// [`EditError::Missing`] where there is none.
    pub(crate) fn replace(&mut self, path: &[&str], value: &str) -> Result<(), EditError> {
        let places = self.places()?;
        let place = places.find(path).filter(|place| place.kind != Kind::Header);
        let span = place.ok_or_else(|| EditError::missing(path))?.span.clone();
        self.splice(span, value);
        Ok(())
    }

    /// Puts a value at a path, new or in place of another one; tables on the way are made.
    ///
    /// # Errors
    /// [`EditError`] where something on the way is no table.
    pub(crate) fn set(&mut self, path: &[&str], value: &str) -> Result<(), EditError> {
        let places = self.places()?;
        if places.find(path).is_some() {
            return self.replace(path, value);
        }
        let (&key, table) = path.split_last().ok_or_else(|| EditError::missing(path))?;
        if let Some(place) = places.find(table).cloned() {
            return self.add_key(&place, key, value);
        }
        match table {
            [] => {
                let line = format!("{} = {value}{}", written_key(key), self.newline());
                self.splice(0..0, &line);
                Ok(())
            }
            // Keys by dots, `A.angle = 1`, have no table of their own.
            [.., _] if places.below(table).next().is_some() => {
                let below: Vec<&Place> = places.below(table).collect();
                let last = below.iter().max_by_key(|place| place.span.end);
                let Some(end) = last.map(|place| places.line_end(place.span.end)) else {
                    return Err(EditError::missing(path));
                };
                // Only a section made of headers alone has none of its own.
                if table.len() == 1 {
                    return self.add_table(table, &[(key.to_owned(), value.to_owned())]);
                }
                let keys: Vec<String> = path[1..].iter().map(|key| written_key(key)).collect();
                let line = format!("{} = {value}{}", keys.join("."), self.newline());
                self.splice(end..end, &line);
                Ok(())
            }
            [_] | [_, _] if is_headed(table) => {
                self.add_table(table, &[(key.to_owned(), value.to_owned())])
            }
            [head @ .., name] => {
                let inline = format!("{{ {} = {value} }}", written_key(key));
                let path = [head, &[*name][..]].concat();
                self.set(&path, &inline)
            }
        }
    }

    /// Adds a key at the end of a table.
    fn add_key(&mut self, table: &Place, key: &str, value: &str) -> Result<(), EditError> {
        let places = self.places()?;
        let pair = format!("{} = {value}", written_key(key));
        match table.kind {
            Kind::Header => {
                let end = places.line_end(places.end_of_table(table));
                let ends = self.text[..end].ends_with('\n');
                let newline = self.newline();
                let line = format!("{}{pair}{newline}", if ends { "" } else { newline });
                self.splice(end..end, &line);
            }
            Kind::Inline => {
                let path: Vec<&str> = table.path.iter().map(String::as_str).collect();
                let last = places.below(&path).skip(1).map(|place| place.span.end).max();
                let (at, text) = match last {
                    Some(end) => (end, format!(", {pair}")),
                    None => (table.span.start + 1, format!(" {pair} ")),
                };
                self.splice(at..at, &text);
            }
            Kind::Array | Kind::Text | Kind::Bare => {
                return Err(EditError::NoTable { path: table.path.join(".") });
            }
        }
        Ok(())
    }

    /// Adds a table with its keys, behind those of its section, or where its section belongs.
    ///
    /// # Errors
    /// [`EditError::NoTable`] where the section is written in braces.
    pub(crate) fn add_table(
        &mut self,
        path: &[&str],
        pairs: &[(String, String)],
    ) -> Result<(), EditError> {
        let places = self.places()?;
        if let Some(place) = places.find(&path[..1]).filter(|place| place.kind != Kind::Header) {
            return Err(EditError::NoTable { path: place.path.join(".") });
        }
        let rank = |section: &str| SECTIONS.iter().position(|known| *known == section);
        let own = rank(path[0]).unwrap_or(SECTIONS.len());
        let before = |place: &&Place| {
            let section = place.path.first().map_or("", String::as_str);
            rank(section).unwrap_or(SECTIONS.len()) <= own
        };
        let last = places.all.iter().filter(before).map(|place| place.span.end).max();
        // Keys of the root stand above all tables.
        let root = places.all.iter().find(|place| place.kind == Kind::Header);
        let first_header = root.map_or(self.text.len(), |place| place.span.start);
        let at = match last {
            Some(end) => places.line_end(end),
            None => places.line_start(first_header),
        };
        let newline = self.newline();
        let keys: Vec<String> = path.iter().map(|key| written_key(key)).collect();
        let mut table = format!("[{}]{newline}", keys.join("."));
        for (key, value) in pairs {
            table.extend([&written_key(key), " = ", value, newline]);
        }
        let is_empty = self.text[..at].trim().is_empty();
        let breaks = if is_empty || self.text[..at].ends_with('\n') { "" } else { newline };
        let gap = if is_empty { "" } else { newline };
        let after = if self.text[at..].trim().is_empty() || is_blank(&self.text[at..]) {
            ""
        } else {
            newline
        };
        self.splice(at..at, &format!("{breaks}{gap}{table}{after}"));
        Ok(())
    }

    /// Takes out a value with its key, or a table with all that is in it and the comment right above it.
    ///
    /// # Errors
    /// [`EditError::Missing`] where there is nothing.
    pub(crate) fn remove(&mut self, path: &[&str]) -> Result<(), EditError> {
        let places = self.places()?;
        let Some(place) = places.find(path).cloned() else {
            return self.remove_dotted(path);
        };
        if place.kind == Kind::Header {
            return self.remove_table(path);
        }
        let Some((start, idx)) = place.first_key() else {
            return Err(EditError::missing(path));
        };
        let parent = places.find(&path[..idx]);
        let range = match parent.map(|parent| parent.kind) {
            Some(Kind::Inline) => {
                self.pair_in_braces(&places, &path[..=idx], start..place.span.end)
            }
            _ => places.line_start(start)..places.line_end(place.span.end),
        };
        self.splice(range, "");
        Ok(())
    }

    /// A pair between braces with the comma that goes with it.
    fn pair_in_braces(
        &self,
        places: &Places<'_>,
        path: &[&str],
        pair: Range<usize>,
    ) -> Range<usize> {
        let before = self.text[..pair.start].trim_end();
        let after = &self.text[pair.end..];
        if before.ends_with(',') {
            return before.len() - 1..pair.end;
        }
        let trimmed = after.trim_start();
        let table = places.find(&path[..path.len() - 1]);
        if trimmed.starts_with(',') {
            let comma = pair.end + (after.len() - trimmed.len()) + 1;
            let next = &self.text[comma..];
            return pair.start..comma + (next.len() - next.trim_start().len());
        }
        table.map_or(pair, |table| table.span.start + 1..table.span.end - 1)
    }

    /// Takes out all keys by dots below a path: `A.angle = 1`.
    fn remove_dotted(&mut self, path: &[&str]) -> Result<(), EditError> {
        loop {
            let places = self.places()?;
            let found = places.below(path).find(|place| !place.keys.is_empty());
            let Some(place) = found.cloned() else { break };
            if place.kind == Kind::Header {
                let path: Vec<&str> = place.path.iter().map(String::as_str).collect();
                self.remove_table(&path)?;
            } else {
                let range = places.line_start(place.span.start)..places.line_end(place.span.end);
                self.splice(range, "");
            }
            if self.places()?.below(path).next().is_none() {
                return Ok(());
            }
        }
        Err(EditError::missing(path))
    }

    fn remove_table(&mut self, path: &[&str]) -> Result<(), EditError> {
        loop {
            let places = self.places()?;
            let table = places.below(path).find(|place| place.kind == Kind::Header);
            let Some(table) = table else { return Ok(()) };
            let mut start = places.line_start(table.span.start);
            let end = places.line_end(places.end_of_table(table));
            // The comment right above is about this table.
            while start > 0 {
                let line = places.line_start(start - 1);
                if !self.text[line..start].trim_start().starts_with('#') {
                    break;
                }
                start = line;
            }
            let follows = is_blank(&self.text[end..]) || self.text[end..].is_empty();
            if follows && start > 0 {
                let line = places.line_start(start - 1);
                if self.text[line..start].trim().is_empty() {
                    start = line;
                }
            }
            self.splice(start..end, "");
        }
    }
}

/// True if a text begins with an empty line.
fn is_blank(text: &str) -> bool {
    text.split_inclusive('\n').next().is_some_and(|line| line.trim().is_empty())
}

/// Sections and their elements have headers; what is below is in braces.
fn is_headed(table: &[&str]) -> bool {
    match table {
        [section] => SECTIONS.contains(section),
        [section, _] => !["parameters", "outputs"].contains(section) && NAMED.contains(section),
        _ => false,
    }
}

/// A key as it is written: bare, or in quotes.
pub(crate) fn written_key(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if !key.is_empty() && key.chars().all(is_bare) {
        return key.to_owned();
    }
    written_text(key)
}

/// A text in quotes.
pub(crate) fn written_text(text: &str) -> String {
    toml_edit::Value::from(text).to_string().trim().to_owned()
}

/// Typed text as TOML: numbers, lists and what is in quotes stay, all else becomes a text.
pub(crate) fn typed(text: &str) -> String {
    let text = text.trim();
    let is_single = !text.contains(['\n', '\r']);
    match text.parse::<toml_edit::Value>() {
        Ok(toml_edit::Value::Datetime(_)) | Err(_) => written_text(text),
        Ok(_) if is_single => text.to_owned(),
        Ok(value) => value.to_string().trim().to_owned(),
    }
}
