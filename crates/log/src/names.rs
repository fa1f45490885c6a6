//! Rules for names: every one can be written and found again.

use std::collections::BTreeSet;

use crate::{Header, LogError, Topic, schema, topics};

/// Checks the names of a header.
pub(crate) fn check(header: &Header) -> Result<(), LogError> {
    if !is_identifier(&header.model_format) {
        return Err(bad_name("model format", &header.model_format));
    }
    // Different topics may still share one message name: `/a_b` and `/a/b` are both `AB`.
    let mut messages = BTreeSet::new();
    for topic in &header.topics {
        let Some(segments) = topic.name.strip_prefix('/') else {
            return Err(bad_name("topic", &topic.name));
        };
        if !segments.split('/').all(is_identifier) {
            return Err(bad_name("topic", &topic.name));
        }
        if topics::is_reserved(&topic.name) || !messages.insert(schema::message_name(&topic.name)) {
            return Err(duplicate("topic", &topic.name));
        }
        check_field_names(topic)?;
    }
    Ok(())
}

fn check_field_names(topic: &Topic) -> Result<(), LogError> {
    let mut names = BTreeSet::from(["t"]);
    for field in &topic.fields {
        if !is_identifier(&field.name) {
            return Err(bad_name("field", &field.name));
        }
        // Tables print them in their first line.
        if field.unit.contains(char::is_control) {
            return Err(bad_name("unit", &field.unit));
        }
        if !names.insert(&field.name) {
            return Err(duplicate("field", &topic.column_name(field)));
        }
    }
    Ok(())
}

/// Protobuf allows ASCII letters, digits and `_` in names, and no digit in front.
fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn bad_name(what: &'static str, name: &str) -> LogError {
    LogError::BadName { what, name: name.into() }
}

fn duplicate(what: &'static str, name: &str) -> LogError {
    LogError::DuplicateName { what, name: name.into() }
}
