//! Schemas: one protobuf message per topic, described by a `FileDescriptorSet` built at run time.
//!
//! ```text
//! package bksim;
//! message State {          // topic /state
//!   double t = 1;          // s
//!   double angle = 2;      // one per signal, in order
//! }
//! ```
//!
//! Reading goes the other way with the wire format alone: a descriptor decoded into generated types
//! takes a hundred times its bytes in memory, which hostile files would ask for.

use prost::Message as _;
use prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
    field_descriptor_proto::{Label, Type},
};

use crate::{
    Field, Topic,
    wire::{Fields, Malformed, Value},
};

/// Field number of the time, in samples.
pub(crate) const T_NUMBER: u32 = 1;
/// Name of the schema of `/log`, which Foxglove has published.
pub(crate) const LOG: &str = "foxglove.Log";
const PACKAGE: &str = "bksim";

/// Name of the schema of `/motion`.
pub(crate) const MOTION_SCHEMA: &str = "bksim.Motion";

/// Field numbers of `bksim.Motion`, whose time is field 1; arrays are packed, as proto3 has them.
pub(crate) mod motion_number {
    pub(crate) const T_END: u32 = 2;
    pub(crate) const VALUES: u32 = 3;
    pub(crate) const MODES: u32 = 4;
    pub(crate) const DEPENDENT: u32 = 5;
}

/// Protobuf field number of a signal by its index; 19000 to 19999 belong to protobuf itself.
pub(crate) fn field_number(field_idx: usize) -> u32 {
    let field_idx =
        u32::try_from(field_idx).expect("a topic that fits into a record has few fields");
    let number = field_idx + T_NUMBER + 1;
    if number < 19_000 { number } else { number + 1_000 }
}

/// The message name of a topic, in camel case: `/solver_steps` gives `SolverSteps`.
pub(crate) fn message_name(topic_name: &str) -> String {
    let mut name = String::new();
    for word in topic_name.split(['/', '_']) {
        let mut letters = word.chars();
        name.extend(letters.next().map(|letter| letter.to_ascii_uppercase()));
        name.push_str(letters.as_str());
    }
    // A digit in front is a legal segment end, `/_1`, but no legal message name.
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("M{name}") }
}

/// The full message name, which MCAP calls the schema name.
pub(crate) fn schema_name(topic_name: &str) -> String {
    format!("{PACKAGE}.{}", message_name(topic_name))
}

/// True if a schema is one of bksim's own; all others are for other programs.
pub(crate) fn is_own(schema_name: &str) -> bool {
    schema_name.strip_prefix(PACKAGE).is_some_and(|rest| rest.starts_with('.'))
}

/// Serialised `FileDescriptorSet` of a topic.
pub(crate) fn descriptor_set(topic: &Topic) -> Vec<u8> {
    let signal = |(field_idx, field): (usize, &Field)| {
        scalar(&field.name, field_number(field_idx), Type::Double)
    };
    let message = DescriptorProto {
        name: Some(message_name(&topic.name)),
        field: std::iter::once(scalar("t", T_NUMBER, Type::Double))
            .chain(topic.fields.iter().enumerate().map(signal))
            .collect(),
        ..DescriptorProto::default()
    };
    let name = format!("bksim/{}.proto", message_name(&topic.name));
    FileDescriptorSet { file: vec![proto_file(&name, PACKAGE, message)] }.encode_to_vec()
}

/// Serialised `FileDescriptorSet` of `bksim.Motion`.
pub(crate) fn motion_descriptor_set() -> Vec<u8> {
    let repeated = |name, number, r#type| FieldDescriptorProto {
        label: Some(Label::Repeated as i32),
        ..scalar(name, number, r#type)
    };
    let motion = DescriptorProto {
        name: Some("Motion".into()),
        field: vec![
            scalar("t", T_NUMBER, Type::Double),
            scalar("t_end", motion_number::T_END, Type::Double),
            repeated("values", motion_number::VALUES, Type::Double),
            repeated("modes", motion_number::MODES, Type::Double),
            repeated("dependent", motion_number::DEPENDENT, Type::Fixed32),
        ],
        ..DescriptorProto::default()
    };
    FileDescriptorSet { file: vec![proto_file("bksim/Motion.proto", PACKAGE, motion)] }
        .encode_to_vec()
}

fn proto_file(name: &str, package: &str, message: DescriptorProto) -> FileDescriptorProto {
    FileDescriptorProto {
        name: Some(name.into()),
        package: Some(package.into()),
        message_type: vec![message],
        syntax: Some("proto3".into()),
        ..FileDescriptorProto::default()
    }
}

fn scalar(name: &str, number: u32, r#type: Type) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        // Spelled out: derived JSON names of `a_b` and `aB` would collide.
        json_name: Some(name.into()),
        number: Some(
            i32::try_from(number).expect("a topic that fits into a record has few fields"),
        ),
        label: Some(Label::Optional as i32),
        r#type: Some(r#type as i32),
        ..FieldDescriptorProto::default()
    }
}

/// The doubles of one message: the field number of `t`, then name and number of each signal.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) t_number: Option<u64>,
    pub(crate) signals: Vec<(String, u64)>,
}

/// Finds message `schema_name` in a serialised `FileDescriptorSet` and lists its doubles.
///
/// `Ok(None)`: the set is sound, but has no such message.
pub(crate) fn layout(set: &[u8], schema_name: &str) -> Result<Option<Layout>, Malformed> {
    // Field numbers of descriptor.proto: FileDescriptorSet.file = 1, FileDescriptorProto.package =
    // 2 and .message_type = 4, DescriptorProto.name = 1.
    for file in messages(set, 1) {
        let file = file?;
        let package = text(file, 2)?;
        for message in messages(file, 4) {
            let message = message?;
            let name = text(message, 1)?;
            let is_meant = match package {
                "" => name == schema_name,
                _ => schema_name.split_once('.').is_some_and(|_| {
                    schema_name.strip_prefix(package).and_then(|rest| rest.strip_prefix('.'))
                        == Some(name)
                }),
            };
            if is_meant {
                return message_layout(message).map(Some);
            }
        }
    }
    Ok(None)
}

fn message_layout(message: &[u8]) -> Result<Layout, Malformed> {
    let mut layout = Layout::default();
    // DescriptorProto.field = 2; FieldDescriptorProto.name = 1, .number = 3, .type = 5.
    for field in messages(message, 2) {
        let field = field?;
        if integer(field, 5)? != Some(Type::Double as u64) {
            continue;
        }
        let number = integer(field, 3)?.ok_or(Malformed)?;
        match text(field, 1)? {
            "t" => layout.t_number = Some(number),
            name => layout.signals.push((name.to_owned(), number)),
        }
    }
    Ok(layout)
}

fn messages(bytes: &[u8], field_number: u64) -> impl Iterator<Item = Result<&[u8], Malformed>> {
    Fields::new(bytes).filter_map(move |field| match field {
        Ok((number, Value::Bytes(message))) if number == field_number => Some(Ok(message)),
        Ok(_) => None,
        Err(error) => Some(Err(error)),
    })
}

fn text(bytes: &[u8], field_number: u64) -> Result<&str, Malformed> {
    match messages(bytes, field_number).next() {
        Some(text) => std::str::from_utf8(text?).map_err(|_| Malformed),
        None => Ok(""),
    }
}

fn integer(bytes: &[u8], field_number: u64) -> Result<Option<u64>, Malformed> {
    for field in Fields::new(bytes) {
        match field? {
            (number, Value::Varint(value)) if number == field_number => return Ok(Some(value)),
            _ => (),
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic() -> Topic {
        Topic::new("/joint/elbow_1", ["a_b", "aB"].map(|name| Field::new(name, "", "")))
    }

    #[test]
    fn the_layout_read_is_the_layout_written() {
        let set = descriptor_set(&topic());
        let signals = vec![("a_b".to_owned(), 2), ("aB".to_owned(), 3)];
        let expected = Layout { t_number: Some(1), signals };
        assert_eq!(schema_name("/joint/elbow_1"), "bksim.JointElbow1");
        assert_eq!(layout(&set, "bksim.JointElbow1"), Ok(Some(expected)));
        assert_eq!(layout(&set, "bksim.Joint"), Ok(None));
        assert_eq!(layout(&set[..set.len() - 1], "bksim.JointElbow1"), Err(Malformed));
    }

    #[test]
    fn generated_types_decode_the_descriptors() {
        let set = FileDescriptorSet::decode(&descriptor_set(&topic())[..]).expect("valid");
        assert_eq!(set.file[0].message_type[0].field.len(), 3);
    }

    #[test]
    fn field_numbers_jump_over_the_reserved_range() {
        assert_eq!([0, 18_997, 18_998].map(field_number), [2, 18_999, 20_000]);
    }
}
