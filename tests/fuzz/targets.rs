//! Readers that take bytes from outside, with honest inputs to damage.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use bksim::cad::model::{ModelOptions, sheet};
use bksim::dae::Control;
use bksim::expr::Pool;
use bksim::log::{Contents, LogReader, Survey};
use bksim::model::Model;
use bksim::model::diagnostic::Span;
use bksim::model::file::{Limits, Reading, Source, decode, expand, read};
use bksim::record::Recorder;
use bksim::sim::run::{RunCheckpoint, Sample};
use bksim::{Mechanism, Simulation};

use crate::damage::NUMBERS;

/// A reader under attack.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    /// Part of all inputs.
    pub(crate) share: u64,
    pub(crate) seeds: fn() -> Vec<Vec<u8>>,
    /// Words to put in the place of others; none for binary inputs.
    pub(crate) words: &'static [&'static str],
    /// Whether it was accepted.
    pub(crate) feed: fn(&[u8]) -> bool,
}

pub(crate) const TARGETS: &[Target] = &[
    Target { name: "expressions", share: 555, seeds: expressions, words: WORDS, feed: expression },
    Target {
        name: "models",
        share: 150,
        seeds: models,
        words: NUMBERS,
        feed: |b| model(b).is_some(),
    },
    Target { name: "parts", share: 30, seeds: parts, words: PART_WORDS, feed: part },
    Target { name: "runs", share: 20, seeds: models, words: NUMBERS, feed: run },
    Target { name: "drawings", share: 8, seeds: drawings, words: NUMBERS, feed: drawing },
    Target {
        name: "logs",
        share: 150,
        seeds: || vec![recorded().0.clone()],
        words: &[],
        feed: log,
    },
    Target { name: "checkpoints", share: 87, seeds: checkpoints, words: &[], feed: checkpoint },
];

/// Words of expressions.
const WORDS: &[&str] = &[
    "0", "1e999", "-1", "1e-320", "1e308", "0.5", "2", "^", "^^", "-", "(", ")", "sin", "atan2",
    "exp(", "log", "abs", "max", ",", "x", "y", "pi", "1/0", "sqrt", "ω", " ", "e", "*", "/",
];

/// Words of models with parts.
const PART_WORDS: &[&str] = &[
    "0",
    "-1",
    "2.5",
    "1e999",
    "use",
    "count",
    "first",
    "file",
    "part",
    "on",
    "with",
    "from",
    "{i}",
    "{i+1}",
    "{i-9}",
    "{",
    "}",
    "\"",
    "a.toml",
    "b.csv",
    "bksim:pid",
    "pid",
    "ground",
    "ground.O",
    "arm",
    "arm.tip",
    "[",
    "]",
    ",",
    ";",
    "\t",
    "=",
    "\n",
    "é",
    "parameters",
    "bodies",
    "tables",
    "points",
    "r",
    "1 m",
];

/// Between the files of one input.
const NEXT_FILE: &str = "\n=== next file ===\n";

fn place(relative: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(relative)
}

/// Files below a folder with this ending, in the order of their names.
fn files(folder: &str, ending: &str) -> Vec<Vec<u8>> {
    let mut open = vec![place(folder)];
    let mut paths = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|found| found == ending) {
                paths.push(path);
            }
        }
    }
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("a file")).collect()
}

fn expressions() -> Vec<Vec<u8>> {
    let texts = [
        "sin(a)*cos(b) + cos(a)*sin(b)",
        "sqrt(x^2 + y^2)/(1 + exp(-k*t)) - atan2(y, x)",
        "max(0, k*(x - gap))^1.5 + min(a, b, c)",
        "((((a + b)*c - d)/e)^2 - 1e-3)*tanh(v/0.01)",
        "-x^-2^y + 3.25e+10*sign(v)*abs(w) - log(1 + u^2)",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

fn expression(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let pool = Pool::new();
    let Ok(parsed) = pool.parse(&text) else { return false };
    if let Some(&by) = pool.symbols_of(parsed).first() {
        let _ = pool.diff(parsed, by);
    }
    // What is printed reads back as the same. Numbers of too many digits are shortened once, by which operands may
    // change places.
    let mut printed = pool.to_text(parsed);
    for is_short in [false, true] {
        let Ok(again) = pool.parse(&printed) else { break };
        let next = pool.to_text(again);
        assert!(next == printed || !is_short, "{text}: `{printed}` reads as `{next}`");
        printed = next;
    }
    true
}

fn models() -> Vec<Vec<u8>> {
    [files("examples", "toml"), files("tests/fixtures", "toml")].concat()
}

fn model(bytes: &[u8]) -> Option<Model> {
    let text = decode(bytes).ok()?;
    let source = Source::new(text, "damaged");
    let Reading { model, diagnostics } = read(&source);
    assert!(model.is_some() || !diagnostics.is_empty(), "rejected without a reason");
    model
}

/// A model, a part and rows.
fn parts() -> Vec<Vec<u8>> {
    let model = "[parameters]\nr = \"2 m\"\n[bodies.arm]\ncount = 2\nmass = \"{i} kg\"\n\
                 points = { tip = [\"r\", 0], P = [1, 0] }\n[joints.A]\ncount = 2\ntype = \"revolute\"\n\
                 between = [\"ground\", \"arm{i}\"]\n[use.left]\ncount = 2\nfile = \"a.toml\"\n\
                 on = \"arm{i}.tip\"\nwith = { r = \"r/2\", s = \"3\" }\n[use.right]\npart = \"pid\"\n\
                 [use.last]\npart = \"gas-spring\"\nwith = { lid = \"arm1\", hinge = \"A1\" }\n";
    let part = "[parameters]\nr = \"1 m\"\n[ground]\npoints = { O = [\"r\", 0] }\n[signals.s]\nvalue = \"2*r/(1 m)\"\n\
                [bodies.rod]\nmass = \"1 kg\"\ninertia = \"1 kg*r^2\"\n\
                [joints.J]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"rod\"]\ncoordinate = \"q\"\n\
                [tables.k]\nfile = \"b.csv\"\n[loads.L]\ntype = \"torque\"\njoint = \"J\"\nvalue = \"s*k(q)\"\n";
    let rows = "angle [rad]; torque [N m]\n-1e3; 0\n0; 0,5\n1e3; 2\n";
    vec![[model, part, rows].join(NEXT_FILE).into_bytes()]
}

fn part(bytes: &[u8]) -> bool {
    let Ok(text) = decode(bytes) else { return false };
    let files: Vec<&str> = text.split(NEXT_FILE).collect();
    let mut open = |name: &str| match name {
        "a.toml" => files.get(1).map(|&text| text.into()).ok_or_else(String::new),
        "b.csv" => files.get(2).map(|&text| text.into()).ok_or_else(String::new),
        _ => Err("is not there".to_owned()),
    };
    let Some(whole) = expand("model.toml", files[0], Limits::default(), &mut open) else {
        return false;
    };
    let text_at = |(file_idx, span): (usize, Span)| {
        let text = &whole.files[file_idx].text;
        assert!(text.get(span.clone()).is_some(), "{span:?} in {text}");
    };
    for label in whole.faults.iter().flat_map(|fault| &fault.labels) {
        text_at(whole.source(&label.span));
    }
    // Whatever is said of the whole has a place in one of its files.
    let Reading { model, diagnostics } = read(&Source::new(&whole.text, "damaged"));
    let labels = diagnostics.iter().flat_map(|fault| &fault.labels);
    labels.filter_map(|label| whole.origin(&label.span)).for_each(text_at);
    assert!(model.is_some() || !diagnostics.is_empty(), "rejected without a reason");
    model.is_some() && whole.faults.is_empty()
}

/// Steps, and samples, that a damaged model may take.
const STEPS: u32 = 40;
const SAMPLES: u32 = 400;

fn run(bytes: &[u8]) -> bool {
    let derived = model(bytes).map(|model| Mechanism::derive(model, Vec::new()));
    let Some(Ok(mechanism)) = derived else { return false };
    let Ok(simulation) = mechanism.simulation() else { return false };
    let Ok(start) = simulation.start() else { return false };
    let left = Cell::new(STEPS);
    let stop = || left.replace(left.get().saturating_sub(1)) == 0;
    let mut n_seen = 0;
    let mut look = |_: &Sample| {
        n_seen += 1;
        if n_seen < SAMPLES { Control::Continue } else { Control::Stop }
    };
    match simulation.run(&start, &mut look, &stop) {
        Ok(_) => true,
        Err(failure) => {
            assert!(!simulation.diagnose(&failure).message.is_empty());
            false
        }
    }
}

fn drawings() -> Vec<Vec<u8>> {
    [files("crates/cad/tests/drawings", "dxf"), files("examples/four-bar", "dxf")].concat()
}

fn drawing(bytes: &[u8]) -> bool {
    let Ok(sheet) = sheet(bytes.to_vec(), None) else { return false };
    let composition = sheet.compose(ModelOptions::default());
    let _ = model(composition.text.as_bytes());
    true
}

/// The log of a run that was stopped, and the state that it goes on from.
fn recorded() -> &'static (Vec<u8>, Vec<u8>) {
    static RECORDED: OnceLock<(Vec<u8>, Vec<u8>)> = OnceLock::new();
    RECORDED.get_or_init(|| {
        let simulation = bouncing();
        let start = simulation.start().expect("a start");
        let recorder = Recorder::create(Vec::new(), simulation, "", &start, &[]);
        let mut log = recorder.expect("a log");
        let mut n = 0;
        let mut keep = |sample: &Sample| {
            log.write(sample).expect("written");
            n += 1;
            if n == 60 { Control::Stop } else { Control::Continue }
        };
        let summary = simulation.run(&start, &mut keep, &|| false).expect("a run");
        let state = summary.checkpoint.as_ref().expect("it was stopped").to_bytes();
        let outcome = bksim::log::Outcome::Stopped;
        let log = log.finish(&summary, outcome, "interrupted").expect("a log");
        (log, state)
    })
}

fn bouncing() -> &'static Simulation {
    static BOUNCING: OnceLock<Simulation> = OnceLock::new();
    BOUNCING.get_or_init(|| {
        let text = fs::read_to_string(place("tests/fixtures/bouncing-ball.toml")).expect("a model");
        let mechanism = Mechanism::from_toml(&text, "ball").expect("a model");
        mechanism.simulation().expect("equations")
    })
}

fn log(bytes: &[u8]) -> bool {
    let _ = Contents::read(bytes);
    let _ = Survey::read(bytes);
    let Ok(mut log) = LogReader::open(bytes) else { return false };
    while let Ok(Some(_)) = log.next_record() {}
    log.end().is_some()
}

fn checkpoints() -> Vec<Vec<u8>> {
    vec![recorded().1.clone()]
}

/// Feeds a checkpoint whose checksum somebody has made to fit.
fn checkpoint(bytes: &[u8]) -> bool {
    assert!(RunCheckpoint::from_bytes(bytes).is_err() || *bytes == recorded().1);
    let mut forged = bytes.to_vec();
    let Some(end) = forged.len().checked_sub(4) else { return false };
    let checksum = crc32fast::hash(&forged[..end]);
    forged[end..].copy_from_slice(&checksum.to_le_bytes());
    let Ok(saved) = RunCheckpoint::from_bytes(&forged) else { return false };
    let simulation = bouncing();
    let start = simulation.start().expect("a start");
    let mut once = |_: &Sample| Control::Stop;
    simulation.resume(&start, &saved, &mut once, &|| true).is_ok()
}
