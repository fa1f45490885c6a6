//! The protobuf wire format, as far as logs need it.
//!
//! A message is a run of fields, each a varint `number << 3 | wire type` and a value. Writing a
//! sample of doubles and walking a descriptor by hand takes less code than a generated type, and
//! keeps memory in proportion to the bytes read, whatever they claim.
//! Source: protobuf documentation, "Encoding".

/// A field value by its wire type; its meaning depends on the schema.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Value<'a> {
    /// Integers, booleans, enumerations.
    Varint(u64),
    /// Doubles and fixed 64-bit integers, little endian.
    Fixed64(u64),
    /// Texts, bytes, messages inside messages.
    Bytes(&'a [u8]),
    /// Floats and fixed 32-bit integers.
    Fixed32,
}

/// The bytes are no protobuf message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Malformed;

/// Iterates over the fields of one message; stops after the first error.
pub(crate) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    pub(crate) fn new(message: &'a [u8]) -> Fields<'a> {
        Fields(message)
    }

    fn field(&mut self) -> Option<(u64, Value<'a>)> {
        let tag = self.varint()?;
        let value = match tag & 7 {
            0 => Value::Varint(self.varint()?),
            1 => {
                let (bytes, rest) = self.0.split_first_chunk::<8>()?;
                self.0 = rest;
                Value::Fixed64(u64::from_le_bytes(*bytes))
            }
            2 => {
                let length = usize::try_from(self.varint()?).ok()?;
                let (bytes, rest) = self.0.split_at_checked(length)?;
                self.0 = rest;
                Value::Bytes(bytes)
            }
            5 => {
                (_, self.0) = self.0.split_first_chunk::<4>()?;
                Value::Fixed32
            }
            _ => return None,
        };
        Some((tag >> 3, value))
    }

    /// Seven bits per byte, the lowest first; the top bit says that more follow.
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.0.split_first()?;
            self.0 = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<(u64, Value<'a>), Malformed>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let field = self.field().ok_or(Malformed);
        if field.is_err() {
            self.0 = &[];
        }
        Some(field)
    }
}

/// Appends a double.
pub(crate) fn put_f64(message: &mut Vec<u8>, number: u32, value: f64) {
    put_varint(message, u64::from(number) << 3 | 1);
    message.extend_from_slice(&value.to_bits().to_le_bytes());
}

/// Appends a packed array of doubles; nothing when it is empty.
pub(crate) fn put_f64s(message: &mut Vec<u8>, number: u32, values: &[f64]) {
    put_packed(message, number, values.iter().map(|value| value.to_bits().to_le_bytes()));
}

/// Appends a packed array of fixed 32-bit integers; nothing when it is empty.
pub(crate) fn put_u32s(message: &mut Vec<u8>, number: u32, values: &[u32]) {
    put_packed(message, number, values.iter().map(|value| value.to_le_bytes()));
}

fn put_packed<const N: usize>(
    message: &mut Vec<u8>,
    number: u32,
    values: impl ExactSizeIterator<Item = [u8; N]>,
) {
    if values.len() > 0 {
        put_varint(message, u64::from(number) << 3 | 2);
        put_varint(message, (values.len() * N) as u64);
        message.extend(values.flatten());
    }
}

/// The doubles of a packed array.
pub(crate) fn f64s(bytes: &[u8]) -> Result<impl Iterator<Item = f64>, Malformed> {
    let (values, rest) = bytes.as_chunks::<8>();
    let value = |bytes: &[u8; 8]| f64::from_le_bytes(*bytes);
    if rest.is_empty() { Ok(values.iter().map(value)) } else { Err(Malformed) }
}

/// The fixed 32-bit integers of a packed array.
pub(crate) fn u32s(bytes: &[u8]) -> Result<impl Iterator<Item = u32>, Malformed> {
    let (values, rest) = bytes.as_chunks::<4>();
    let value = |bytes: &[u8; 4]| u32::from_le_bytes(*bytes);
    if rest.is_empty() { Ok(values.iter().map(value)) } else { Err(Malformed) }
}

fn put_varint(message: &mut Vec<u8>, mut value: u64) {
    loop {
        let [low, ..] = value.to_le_bytes();
        value >>= 7;
        if value == 0 {
            return message.push(low);
        }
        message.push(low | 0x80);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_come_back_as_they_were_put() {
        let mut message = Vec::new();
        put_f64(&mut message, 1, -0.0);
        // As other writers put them: a number of two bytes with the largest integer, the largest
        // number with a text.
        message.extend([0x80, 0x01]);
        message.extend([[0xff; 9].as_slice(), &[0x01]].concat());
        message.extend([0xfa, 0xff, 0xff, 0xff, 0x0f, 4]);
        message.extend(b"text");
        let fields: Vec<_> = Fields::new(&message).collect::<Result<_, _>>().expect("well formed");
        assert_eq!(
            fields,
            [
                (1, Value::Fixed64((-0.0f64).to_bits())),
                (16, Value::Varint(u64::MAX)),
                (536_870_911, Value::Bytes(b"text")),
            ]
        );
    }

    #[test]
    fn a_cut_message_is_malformed_and_ends_the_iteration() {
        let mut message = Vec::new();
        put_f64(&mut message, 1, 2.5);
        for length in 1..message.len() {
            let fields: Vec<_> = Fields::new(&message[..length]).collect();
            assert_eq!(fields, [Err(Malformed)], "{length} bytes");
        }
        // Eleven bytes of continuation and a wire type that protobuf retired.
        assert_eq!(Fields::new(&[0xff; 11]).last(), Some(Err(Malformed)));
        assert_eq!(Fields::new(&[0x0b]).last(), Some(Err(Malformed)));
    }
}
