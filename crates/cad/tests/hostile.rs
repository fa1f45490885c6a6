//! Damaged drawings by the thousand: each is opened or answered, in bounded time and memory.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use acadrust::{DwgWriter, DxfReader};
use bksim_cad::open::{OpenOptions, open};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Drawings to be damaged; those of the old format are the smallest.
const DRAWINGS: [&str; 6] =
    ["R12.dxf", "R12_binary.dxf", "R2000.dxf", "R2010.dxf", "R2010_binary.dxf", "R2018.dxf"];

const N_DXF: u64 = 20_000;
const N_DWG: u64 = 600;

/// One damaged drawing takes some milliseconds; this is a hang.
const PATIENCE: Duration = Duration::from_secs(20);

/// Address space beyond that of the process at its start; a larger demand ends the process.
const MEMORY: u64 = 512 << 20;

/// Values that readers stumble over.
const WORDS: [&str; 16] = [
    "nan",
    "1e999",
    "-1",
    "2147483647",
    "-2147483648",
    "4294967295",
    "9999999999999999999",
    "",
    "FFFFFFFFFFFFFFFF",
    "0",
    "2456789.99999999999",
    "1e308",
    "ENDSEC",
    "EOF",
    "SECTION",
    "}",
];

/// xorshift64*: Vigna, *An experimental exploration of Marsaglia's xorshift generators* (2016).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % (end.max(1) as u64)).expect("below a usize")
    }
}

fn read(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/drawings").join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The drawing without its styles, views and objects, which no mechanism needs: a mutation then
/// hits what does.
fn without_boilerplate(bytes: Vec<u8>) -> Vec<u8> {
    let Ok(text) = String::from_utf8(bytes.clone()) else { return bytes };
    let Some((tables, rest)) = text.split_once("  0\nSECTION\n  2\nBLOCKS\n") else { return bytes };
    let entities = rest.split("  0\nSECTION\n  2\nOBJECTS\n").next().unwrap_or(rest);
    let header = "  0\nSECTION\n  2\nHEADER\n  9\n$ACADVER\n  1\n";
    let version = tables.split("$ACADVER\n  1\n").nth(1).and_then(|it| it.lines().next());
    let version = version.unwrap_or("AC1015");
    let units = "  9\n$INSUNITS\n 70\n4\n  0\nENDSEC\n  0\nSECTION\n  2\nBLOCKS\n";
    let end = if entities.ends_with("EOF\n") { "" } else { "  0\nEOF\n" };
    format!("{header}{version}\n{units}{entities}{end}").into_bytes()
}

/// One to four changes of the bytes or the lines.
fn damage(bytes: &[u8], others: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let is_text = bytes.starts_with(b" ") || bytes.starts_with(b"0");
        match random.below(if is_text { 10 } else { 5 }) {
            0 => flip(&mut bytes, random),
            1 => {
                let at = random.below(bytes.len());
                if random.below(4) == 0 { bytes.truncate(at) } else { flip(&mut bytes, random) }
            }
            2 => {
                let (from, to) = stretch(bytes.len(), random);
                bytes.drain(from..to);
            }
            3 => {
                let (from, to) = stretch(bytes.len(), random);
                let copy = bytes[from..to].to_vec();
                let at = random.below(bytes.len());
                bytes.splice(at..at, copy);
            }
            4 => {
                let other = &others[random.below(others.len())];
                let (from, to) = stretch(other.len(), random);
                let at = random.below(bytes.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            kind => damage_lines(&mut bytes, kind, random),
        }
    }
    bytes
}

fn flip(bytes: &mut [u8], random: &mut Random) {
    if !bytes.is_empty() {
        let at = random.below(bytes.len());
        bytes[at] ^= 1 << random.below(8);
    }
}

fn stretch(len: usize, random: &mut Random) -> (usize, usize) {
    let from = random.below(len);
    let longest = if random.below(8) == 0 { 2000 } else { 12 };
    (from, (from + random.below(longest)).min(len))
}

/// Damage that keeps the pairs of lines, so that it gets past the first check.
fn damage_lines(bytes: &mut Vec<u8>, kind: usize, random: &mut Random) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut lines: Vec<&str> = text.split('\n').collect();
    let n_pairs = lines.len() / 2;
    if n_pairs < 2 {
        return;
    }
    let pair = 2 * random.below(n_pairs);
    let other = 2 * random.below(n_pairs);
    match kind {
        5 | 6 => lines[pair + 1] = WORDS[random.below(WORDS.len())],
        7 => lines[pair] = lines[other],
        8 => {
            let n = 2 * (1 + random.below(30)).min(n_pairs - pair / 2);
            let copy = lines[pair..pair + n].to_vec();
            lines.splice(other..other, copy);
        }
        _ => {
            let n = 2 * (1 + random.below(10)).min(n_pairs - pair / 2);
            lines.drain(pair..pair + n);
        }
    }
    *bytes = lines.join("\n").into_bytes();
}

/// How many drawings were opened, in spite of all, and how many rejected.
#[derive(Default)]
struct Tally {
    n_opened: AtomicUsize,
    n_rejected: AtomicUsize,
    /// The mutation each worker is at, for the message about a hang.
    at: [AtomicU64; 2],
}

fn attack(seeds: &[Vec<u8>], n: u64, worker: u64, tally: &Tally, done: &dyn Fn()) {
    let options = OpenOptions { unit: bksim_cad::units::by_name("mm"), ..OpenOptions::default() };
    for number in (worker..n).step_by(2) {
        tally.at[usize::try_from(worker).expect("0 or 1")].store(number, Ordering::Relaxed);
        let mut random =
            Random(0x9E37_79B9_7F4A_7C15 ^ (number + 1).wrapping_mul(0xD134_2543_DE82_EF95));
        let seed = &seeds[random.below(seeds.len())];
        let bytes = damage(seed, seeds, &mut random);
        match open(bytes, &options) {
            Ok(_) => tally.n_opened.fetch_add(1, Ordering::Relaxed),
            Err(faults) => {
                assert!(!faults.is_empty(), "mutation {number} is rejected without a reason");
                tally.n_rejected.fetch_add(1, Ordering::Relaxed)
            }
        };
        if number % 64 < 2 {
            done();
        }
    }
}

/// Runs `n` mutations on two threads under a watchdog; returns how many opened and were rejected.
fn survive(seeds: &[Vec<u8>], n: u64) -> (usize, usize) {
    let tally = Tally::default();
    let (sender, receiver) = channel();
    std::thread::scope(|scope| {
        for worker in 0..2 {
            let (tally, sender) = (&tally, sender.clone());
            scope.spawn(move || {
                attack(seeds, n, worker, tally, &|| sender.send(()).expect("a watchdog"));
            });
        }
        drop(sender);
        loop {
            match receiver.recv_timeout(PATIENCE) {
                Ok(()) => (),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {
                    let at = tally.at.each_ref().map(|it| it.load(Ordering::Relaxed));
                    eprintln!("no progress for {PATIENCE:?} at the mutations {at:?}");
                    // A thread that hangs cannot be joined.
                    std::process::abort();
                }
            }
        }
    });
    (tally.n_opened.into_inner(), tally.n_rejected.into_inner())
}

/// Times the usual number of drawings, by `BKSIM_FUZZ_DRAWINGS`.
fn factor() -> u64 {
    std::env::var("BKSIM_FUZZ_DRAWINGS").ok().and_then(|n| n.parse().ok()).unwrap_or(1)
}

/// Bounds the address space: an allocation beyond it fails, and with it the process.
fn bound_memory() {
    let status = fs::read_to_string("/proc/self/status").expect("the state of this process");
    let size = status.lines().find_map(|line| line.strip_prefix("VmSize:")).expect("its size");
    let kibibytes: u64 = size.trim().trim_end_matches(" kB").parse().expect("a number");
    // Two threads with their arenas (64 MiB each, reserved, not used) are not the drawing's.
    let limit = kibibytes * 1024 + MEMORY + (4 << 26);
    let maximum = getrlimit(Resource::As).maximum;
    setrlimit(Resource::As, Rlimit { current: Some(limit), maximum }).expect("a limit");
}

#[test]
fn no_damage_to_a_drawing_crashes_hangs_or_exhausts_the_memory() {
    bound_memory();
    let seeds: Vec<Vec<u8>> =
        DRAWINGS.into_iter().map(|it| without_boilerplate(read(it))).collect();
    let (n_opened, n_rejected) = survive(&seeds, factor() * N_DXF);
    // Mutations that are all rejected at the door, or all harmless, would prove nothing.
    assert!(n_opened > 2000 && n_rejected > 2000, "{n_opened} opened, {n_rejected} rejected");

    let reader = DxfReader::from_reader(Cursor::new(read("R2010.dxf"))).expect("a reader");
    let mut document = reader.read().expect("a drawing");
    let versions = [acadrust::types::DxfVersion::AC1015, acadrust::types::DxfVersion::AC1024];
    let dwg = versions.map(|version| {
        document.version = version;
        DwgWriter::write_to_vec(&document).expect("a DWG")
    });
    let (n_opened, n_rejected) = survive(&dwg, factor() * N_DWG);
    assert!(n_opened > 50 && n_rejected > 50, "DWG: {n_opened} opened, {n_rejected} rejected");
}
