//! Bytes that no honest writer made: an answer in bounded time and memory, and no panic.

use crate::common::{header, write_samples};
use bksim_log::{Contents, Log, LogError, LogReader, LogWriter, Selection, Survey, export::to_csv};
use mcap::{
    MAGIC,
    sans_io::linear_reader::{LinearReadEvent, LinearReader},
};

const N_MUTATIONS: u32 = 20_000;

fn honest() -> Result<Vec<u8>, LogError> {
    let (header, topic, energy) = header();
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    write_samples(&mut writer, (topic, energy), 90..110)?;
    writer.finish(&crate::common::end())
}

/// The records of a log, with their opcodes and lengths, chunks taken apart; no checksum left.
fn bare_records(log: &[u8]) -> Vec<u8> {
    let mut reader = LinearReader::new();
    let mut rest = log;
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event.expect("an honest log") {
            LinearReadEvent::ReadRequest(n_bytes) => {
                let n_read = n_bytes.min(rest.len());
                reader.insert(n_bytes)[..n_read].copy_from_slice(&rest[..n_read]);
                reader.notify_read(n_read);
                rest = &rest[n_read..];
            }
            LinearReadEvent::Record { opcode: mcap::records::op::DATA_END, .. } => break,
            LinearReadEvent::Record { opcode, data } => records.extend(record(opcode, data)),
        }
    }
    records
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

/// A chunk as it stands in a file, with a checksum of zero, which says "none".
fn chunk(records: &[u8], size: u64, compression: &str) -> Vec<u8> {
    let body = [
        &[0; 16],
        &size.to_le_bytes()[..],
        &[0; 4],
        &u32::try_from(compression.len()).expect("a short name").to_le_bytes(),
        compression.as_bytes(),
        &(records.len() as u64).to_le_bytes(),
        records,
    ];
    record(mcap::records::op::CHUNK, &body.concat())
}

/// xorshift64: the same mutations in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 % bound as u64).expect("less than a usize")
    }
}

fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    for _ in 0..=dice.below(3) {
        let length = bytes.len();
        if length < 16 {
            return;
        }
        let at = dice.below(length - 8);
        let end = at + dice.below(40).min(length - at);
        match dice.below(7) {
            0 => bytes[at] ^= 1 << dice.below(8),
            1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][dice.below(5)],
            2 => {
                let lengths = [0, 3, 4, u64::from(u32::MAX), 1 << 26, 1 << 40, u64::MAX];
                bytes[at..at + 8].copy_from_slice(&lengths[dice.below(7)].to_le_bytes());
            }
            3 => bytes.truncate(at),
            4 => drop(bytes.drain(at..end)),
            5 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            // Lengths are small numbers: one more or one less is the most telling lie.
            _ => bytes[at] = bytes[at].wrapping_add([1, 0xff][dice.below(2)]),
        }
    }
}

#[test]
fn mutated_logs_are_read_or_refused() -> Result<(), LogError> {
    let honest = honest()?;
    let bare = bare_records(&honest);
    let bases =
        [honest, [MAGIC, &bare].concat(), [MAGIC, &chunk(&bare, bare.len() as u64, "")].concat()];
    let mut dice = Dice(0x9e37_79b9_7f4a_7c15);
    let (mut n_read, mut n_refused, mut n_listed) = (0, 0, 0);
    for round in 0..N_MUTATIONS {
        let mut bytes = bases[round as usize % bases.len()].clone();
        mutate(&mut bytes, &mut dice);
        let survey = Survey::read(&bytes[..]);
        n_listed += u32::from(Contents::read(&bytes[..]).is_ok());
        let Ok(log) = LogReader::open(&bytes[..]) else {
            assert!(survey.is_err(), "round {round}");
            n_refused += 1;
            continue;
        };
        let all = Selection::all(log.header());
        match to_csv(log, &all, std::io::sink()) {
            Ok(_) => n_read += 1,
            Err(_) => n_refused += 1,
        }
    }
    // A mutation loop that no longer reaches the deep parts would prove nothing.
    assert!(n_read > 1_000 && n_refused > 1_000, "{n_read} read, {n_refused} refused");
    assert!(n_listed > 1_000, "{n_listed} listed");
    if let Some(peak) = peak_memory() {
        assert!(peak < 512 << 20, "{peak} bytes of memory");
    }
    Ok(())
}

/// Most memory this process ever had in use, bytes, where the system knows.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? << 10)
}

#[track_caller]
fn assert_refused(bytes: &[u8], expected: &str) {
    let error = Log::read(bytes).expect_err("hostile").to_string();
    assert!(error.contains(expected), "{error}");
}

#[test]
fn claims_of_size_are_not_believed() {
    let huge = |opcode: u8, length: u64| [MAGIC, &[opcode], &length.to_le_bytes()].concat();
    assert_refused(&huge(5, u64::MAX), "exceeds limit");
    // Within the limit, but not there: no more memory is asked for than bytes arrive.
    assert_refused(&huge(5, 60 << 20), "the model is missing");
    let bomb = [MAGIC, &chunk(&[0; 40], 1 << 62, "zstd")].concat();
    assert_refused(&bomb, "the limit is 67108864");
    let odd = [MAGIC, &chunk(&[0; 40], 40, "lzma")].concat();
    assert_refused(&odd, "unknown compression `lzma`");
}

#[test]
fn a_record_longer_than_its_chunk_is_refused() {
    let long = [&[0x80][..], &1_000_u64.to_le_bytes(), &[0; 8]].concat();
    assert_refused(
        &[MAGIC, &chunk(&long, long.len() as u64, "")].concat(),
        "longer than its chunk",
    );
}

#[test]
fn an_attachment_without_room_for_its_checksum_is_refused() {
    // Times, two empty texts, no data; then four bytes of checksum are missing.
    for n_missing in 1..=4 {
        let body = [0; 16 + 8 + 8 + 4];
        let cut = record(mcap::records::op::ATTACHMENT, &body[..body.len() - n_missing]);
        assert_refused(&[MAGIC, &cut].concat(), "shorter than it says");
    }
}

#[test]
fn other_files_are_called_by_their_name() {
    assert_refused(b"t,x\n0,1\n", "not an MCAP file");
    assert_refused(MAGIC, "holds no bksim run: the model is missing");
    assert_refused(b"", "holds no bksim run");
}

/// A schema and a channel of MCAP, as bytes.
fn schema(id: u16, name: &str, encoding: &str, data: &[u8]) -> Vec<u8> {
    let text = |text: &str| prefixed(text.as_bytes());
    let body = [&id.to_le_bytes()[..], &text(name), &text(encoding), &prefixed(data)].concat();
    record(mcap::records::op::SCHEMA, &body)
}

fn channel(id: u16, schema_id: u16, topic: &str) -> Vec<u8> {
    let text = |text: &str| prefixed(text.as_bytes());
    let ids = [id.to_le_bytes(), schema_id.to_le_bytes()].concat();
    let body = [&ids[..], &text(topic), &text("json"), &prefixed(&[])].concat();
    record(mcap::records::op::CHANNEL, &body)
}

fn prefixed(bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).expect("a short text");
    [&length.to_le_bytes()[..], bytes].concat()
}

#[test]
fn channels_of_other_programs_are_passed_over() -> Result<(), LogError> {
    let honest = honest()?;
    let bare = bare_records(&honest);
    // Before the first message, as bksim's own channels are.
    let mut offset = 0;
    while bare[offset] != mcap::records::op::MESSAGE {
        let length = bare[offset + 1..].first_chunk::<8>().expect("a whole record");
        offset += 9 + usize::try_from(u64::from_le_bytes(*length)).expect("a length");
    }
    let with = |records: &[u8]| [MAGIC, &bare[..offset], records, &bare[offset..]].concat();
    // A message is its channel, a number, two times and bytes that are nobody's protobuf.
    let message = |id: u16| {
        record(mcap::records::op::MESSAGE, &[&id.to_le_bytes()[..], &[0; 20], &[0xff; 7]].concat())
    };
    let foreign = [
        schema(900, "other.Thing", "protobuf", &[0xff; 9]),
        schema(901, "other.Note", "jsonschema", b"{}"),
        channel(910, 900, "/state"),
        channel(911, 901, "/log"),
        channel(912, 0, "/plain"),
        message(910),
        message(911),
        message(912),
        message(913),
    ];
    // As text: some of the samples are no numbers, which equal nothing.
    let read = |bytes: &[u8]| Log::read(bytes).map(|log| format!("{log:?}"));
    assert_eq!(read(&with(&foreign.concat()))?, read(&[MAGIC, &bare].concat())?);
    // Its own must be whole, and every reference must lead somewhere.
    assert_refused(&with(&schema_and_channel("bksim.Thing")), "the schema of `/thing`");
    assert_refused(&with(&channel(910, 77, "/thing")), "`/thing` has no schema");
    Ok(())
}

fn schema_and_channel(name: &str) -> Vec<u8> {
    [schema(900, name, "protobuf", &[0xff; 9]), channel(910, 900, "/thing")].concat()
}
