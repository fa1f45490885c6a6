//! Evaluation of residual and Jacobian at one point: our evaluators against C and other systems.
//!
//! The functions are defined in [`systems`](super::systems). All programs visit the same points in
//! turn, and must agree on all outputs there before they are timed. Parameters are constants for
//! the C programs and for Symbolica, and set once for ours.

use std::path::Path;

use bksim_expr::{Jit, LaneRunner, Runner, Tape};
use serde_json::{Map, Value, json};

use super::andrews;
use super::systems::{Outputs, System};
use crate::context::Context;
use crate::error::BenchError;
use crate::peers::{self, Peers, Workbench, native};
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{Effort, Samples, median, repeat, repeat_short};

/// Number of points that single evaluations visit in turn.
pub(super) const N_POINTS: usize = 16;
/// Number of points of a batch.
const N_BATCH: usize = 1000;
/// Number of calls in one sample of a peer.
const N_CALLS: usize = 20_000;
/// Number of samples of a peer in one round.
const N_SAMPLES: usize = 10;
/// Short rounds for each round of the other suites: nanoseconds are the noisiest.
pub(super) const ROUNDS: usize = 5;
/// Goal of the time of the JIT over that of hand-written C.
const C_RATIO_GOAL: f64 = 1.25;
/// Goal of the throughput of batches over that of single points.
const BATCH_GOAL: f64 = 3.0;
/// Largest relative difference between programs; sums of large terms cancel in some outputs.
const TOLERANCE: f64 = 1e-10;

/// Our evaluators, in the order of the table.
const OURS: [&str; 3] = ["interpreter", "batch of 1000", "JIT"];
/// Sine and cosine called one by one: by default, the compiler combines both calls.
const C_APART: &str = "C -O3, sin and cos apart";
/// Sine and cosine of one angle by one call.
const C_TOGETHER: &str = "C -O3, sin and cos together";
/// Sines and cosines of all angles in SIMD lanes. The compiler takes its vector functions only
/// where it may ignore errno, rounding modes and the order of sums.
const C_VECTOR: &str = "C -O3, vector sine";
/// C that CasADi generates.
const CASADI: &str = "CasADi's C -O3";
/// Machine code of Symbolica.
const SYMBOLICA: &str = "Symbolica's JIT";

/// The hand-written programs and their flags.
const BY_HAND: [(&str, &[&str]); 3] = [
    (C_APART, &["-O3", "-fno-builtin-sin", "-fno-builtin-cos"]),
    (C_TOGETHER, &["-O3"]),
    (C_VECTOR, &["-O3", "-march=native", "-ffast-math", "-DVECTOR_SINE"]),
];

/// Measurements of one mechanism: times of one evaluation by program.
struct Measured {
    times: Vec<(&'static str, Vec<Samples>)>,
    compile: Samples,
    n_operations: usize,
    n_outputs: usize,
}

impl Measured {
    /// Adds the samples of a round.
    fn push(&mut self, program: &'static str, samples: Samples) {
        match self.times.iter_mut().find(|(name, _)| *name == program) {
            Some((_, rounds)) => rounds.push(samples),
            None => self.times.push((program, vec![samples])),
        }
    }

    /// The samples of all rounds; none for a missing program.
    fn rounds(&self, program: &str) -> &[Samples] {
        self.times.iter().find(|(name, _)| *name == program).map_or(&[], |(_, rounds)| rounds)
    }

    /// The fastest run of all rounds, s; NaN without one.
    fn best(&self, program: &str) -> f64 {
        self.rounds(program).iter().map(Samples::minimum).fold(f64::NAN, f64::min)
    }

    /// The ratio of the fastest runs, which is steadier than ratios within rounds: some samples of
    /// a millisecond find the machine undisturbed.
    fn ratio(&self, a: &str, b: &str) -> f64 {
        self.best(a) / self.best(b)
    }
}

/// The mechanisms of the suite.
fn systems() -> Result<Vec<System>, BenchError> {
    let slider_crank = System::assembled(
        "slider_crank",
        include_str!("../../../../examples/slider-crank/model.toml"),
        &[("theta1", 0.4), ("x2", 2.4), ("y2", 0.2), ("theta2", -0.13), ("x3", 3.9)],
    )?;
    let five_link = System::assembled(
        "five_link",
        include_str!("../../../../examples/five-link/model.toml"),
        &[
            ("ti1", 0.3),
            ("x2", 73.0),
            ("y2", 3.7),
            ("ti2", -0.07),
            ("x3", 123.0),
            ("x4", 86.0),
            ("y4", 2.0),
            ("ti4", -9.3),
            ("ti5", 1.6),
        ],
    )?;
    Ok(vec![slider_crank, five_link, andrews::system()?])
}

/// Measures all mechanisms.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("evaluation", "residual and Jacobian, CPU time of one point");
    let bench = Workbench::new()?;
    let mut measured = Vec::new();
    for system in systems()? {
        let found = measure(context, &bench, &system, &mut report.notes)?;
        measured.push((system.name, found));
    }

    // A column for each mechanism: sizes, times, ratios, and the cost of compiling.
    let names = measured.iter().map(|(name, _)| (*name).to_owned());
    let mut table = Table::new(std::iter::once(String::new()).chain(names.clone()));
    let mut row = |label: &str, cell: &dyn Fn(&Measured) -> String| {
        let cells = measured.iter().map(|(_, found)| cell(found));
        table.push(std::iter::once(label.to_owned()).chain(cells));
    };
    row("operations", &|found| found.n_operations.to_string());
    row("outputs", &|found| found.n_outputs.to_string());
    let peers = [C_APART, C_TOGETHER, C_VECTOR, CASADI, SYMBOLICA];
    for program in OURS.into_iter().chain(peers) {
        row(program, &|found| seconds(found.best(program)));
    }
    for peer in peers {
        row(&format!("JIT / {peer}"), &|found| ratio(found.ratio("JIT", peer)));
    }
    row("JIT compile time", &|found| seconds(found.compile.minimum()));
    row("evaluations that pay it back", &|found| {
        let saved = found.best("interpreter") - found.best("JIT");
        ratio((found.compile.minimum() / saved).ceil())
    });
    report.tables.push(table);

    // The goals and numbers of each mechanism.
    for (name, found) in &measured {
        for (peer, bound) in
            [(C_APART, C_RATIO_GOAL), (C_TOGETHER, C_RATIO_GOAL), (CASADI, 1.0), (SYMBOLICA, 1.0)]
        {
            let what = format!("{name}: JIT over {peer}");
            report.checks.push(Check::at_most(what, found.ratio("JIT", peer), bound));
        }
        for single in ["interpreter", "JIT"] {
            let what = format!("{name}: throughput of batches over the {single}'s");
            let found = found.ratio(single, "batch of 1000");
            report.checks.push(Check::at_least(what, found, BATCH_GOAL));
        }
        report.numbers.insert((*name).to_owned(), numbers(found));
    }
    // A missing peer is noted once.
    report.notes.sort();
    report.notes.dedup();
    Ok(report)
}

/// All numbers of a mechanism.
fn numbers(found: &Measured) -> Value {
    let times: Map<String, Value> = found
        .times
        .iter()
        .map(|(program, rounds)| {
            let medians: Vec<f64> = rounds.iter().map(Samples::median).collect();
            let value = json!({ "min_s": found.best(program), "median_s": median(&medians) });
            ((*program).to_owned(), value)
        })
        .collect();
    json!({
        "times": times, "compile_s": found.compile.minimum(), "n_operations": found.n_operations,
        "n_outputs": found.n_outputs,
    })
}

/// Times all programs on one mechanism, round by round.
fn measure(
    context: &Context,
    bench: &Workbench,
    system: &System,
    notes: &mut Vec<String>,
) -> Result<Measured, BenchError> {
    // The functions, their values at all points, and the time to compile them.
    let outputs = system.outputs();
    let tape = system.tape(&outputs)?;
    let points = system.points(N_POINTS);
    let expected = Expected::new(&tape, system.parameter_values(), points);
    let one_lane = |tape| LaneRunner::<1>::new(tape, Jit::On);
    let compile = repeat(context.effort, || one_lane(tape.clone()), |runner| runner.has_code());
    let mut found = Measured {
        times: Vec::new(),
        compile,
        n_operations: tape.operation_count(),
        n_outputs: outputs.all.len(),
    };

    // Short rounds of ours and of the C programs.
    let programs = compiled(&context.peers, bench, system, &outputs, notes)?;
    for round in 0..context.effort.rounds * ROUNDS {
        ours(short(context.effort), &tape, &expected, &mut found)?;
        for (program, path) in &programs {
            match peers::program(path, &expected.request()) {
                Ok(text) => found.push(program, expected.checked(program, &text)?),
                Err(absent) => notes.push(format!("{program}: {absent}")),
            }
        }
        // Symbolica compiles for seconds: it takes part in every fifth round.
        if round % ROUNDS > 0 {
            continue;
        }
        let mut request = system.to_json(&outputs);
        request["points"] = json!(expected.points);
        request["n_calls"] = json!(N_CALLS);
        request["n_samples"] = json!(N_SAMPLES);
        match context.peers.python("evaluation_symbolica", &request) {
            Ok(value) => {
                found.push(SYMBOLICA, expected.checked("Symbolica", &value.to_string())?);
            }
            Err(absent) => notes.push(format!("{SYMBOLICA}: {absent}")),
        }
    }
    Ok(found)
}

/// The effort of one short round.
fn short(effort: Effort) -> Effort {
    Effort { enough_s: effort.enough_s / 10.0, ..effort }
}

/// Times our own evaluators.
fn ours(
    effort: Effort,
    tape: &Tape,
    expected: &Expected,
    found: &mut Measured,
) -> Result<(), BenchError> {
    // The interpreter.
    let mut out = vec![0.0; tape.n_outputs()];
    let mut workspace = tape.workspace(&expected.parameters);
    let mut points = expected.points.chunks_exact(tape.n_inputs()).cycle();
    let samples = repeat_short(effort, |n| {
        for point in points.by_ref().take(n) {
            tape.evaluate(&mut workspace, point, &mut out);
        }
    });
    found.push("interpreter", samples);

    // Machine code, where there is any for the processor.
    let runner = Runner::new(tape.clone(), Jit::On);
    let mut values = Vec::new();
    for point in expected.points.chunks_exact(tape.n_inputs()) {
        runner.evaluate(&mut workspace, point, &mut out);
        values.extend_from_slice(&out);
    }
    expected.check("machine code", &values)?;
    if runner.is_compiled() {
        let samples = repeat_short(effort, |n| {
            for point in points.by_ref().take(n) {
                runner.evaluate(&mut workspace, point, &mut out);
            }
        });
        found.push("JIT", samples);
    }

    // A batch takes all values of an input together.
    let n_points = expected.points.len() / tape.n_inputs();
    let value = |i: usize, p: usize| expected.points[(p % n_points) * tape.n_inputs() + i];
    let inputs: Vec<f64> =
        (0..tape.n_inputs()).flat_map(|i| (0..N_BATCH).map(move |p| value(i, p))).collect();
    let mut batch = tape.batch(&expected.parameters);
    let mut out = vec![0.0; N_BATCH * tape.n_outputs()];
    batch.evaluate(N_BATCH, &inputs, &mut out);
    let of_point = |p: usize| (0..tape.n_outputs()).map(move |i| (p, i));
    let values: Vec<f64> =
        (0..n_points).flat_map(of_point).map(|(p, i)| out[i * N_BATCH + p]).collect();
    expected.check("batch", &values)?;
    let samples = repeat_short(effort, |n| {
        (0..n).for_each(|_| batch.evaluate(N_BATCH, &inputs, &mut out));
    });
    found.push("batch of 1000", samples.divided(N_BATCH));
    Ok(())
}

/// The peers that could be compiled.
fn compiled(
    peers: &Peers,
    bench: &Workbench,
    system: &System,
    outputs: &Outputs,
    notes: &mut Vec<String>,
) -> Result<Vec<(&'static str, std::path::PathBuf)>, BenchError> {
    let source = native(&format!("{}.c", system.name));
    let harness = native("harness.c");
    let mut programs = Vec::new();
    let mut compile = |program: &'static str, sources: &[&Path], flags: &[&str]| {
        let target = bench.file(&format!("{}_{}", system.name, programs.len()));
        match peers.compile(sources, flags, &[], &target) {
            Ok(()) => programs.push((program, target)),
            Err(absent) => notes.push(format!("{program}: {absent}")),
        }
    };
    for (program, flags) in BY_HAND {
        compile(program, &[&source, &harness], flags);
    }
    match peers.python("evaluation_casadi", &system.to_json(outputs)) {
        Ok(value) => {
            let text = value["source"].as_str().ok_or(BenchError::Data("CasADi's source"))?;
            let path = bench.write(&format!("{}_casadi.c", system.name), text)?;
            let adapter = native("casadi_adapter.c");
            compile(CASADI, &[&path, &adapter, &harness], &["-O3"]);
        }
        Err(absent) => notes.push(format!("{CASADI}: {absent}")),
    }
    Ok(programs)
}

/// The points, and the right values there.
pub(super) struct Expected {
    parameters: Vec<f64>,
    points: Vec<f64>,
    values: Vec<f64>,
    n_inputs: usize,
    n_outputs: usize,
}

impl Expected {
    pub(super) fn new(tape: &Tape, parameters: Vec<f64>, points: Vec<f64>) -> Self {
        let mut workspace = tape.workspace(&parameters);
        let mut out = vec![0.0; tape.n_outputs()];
        let mut values = Vec::new();
        for point in points.chunks_exact(tape.n_inputs()) {
            tape.evaluate(&mut workspace, point, &mut out);
            values.extend_from_slice(&out);
        }
        let (n_inputs, n_outputs) = (tape.n_inputs(), tape.n_outputs());
        Self { parameters, points, values, n_inputs, n_outputs }
    }

    /// The input of `native/harness.c`.
    pub(super) fn request(&self) -> String {
        let Self { n_inputs, n_outputs, .. } = self;
        let n_points = self.points.len() / n_inputs;
        let mut text = format!("{n_inputs} {n_outputs} {n_points} {N_SAMPLES} {N_CALLS}");
        for value in &self.points {
            text.push(' ');
            text.push_str(&value.to_string());
        }
        text
    }

    /// The samples of a program, after a check of its outputs.
    pub(super) fn checked(&self, program: &str, text: &str) -> Result<Samples, BenchError> {
        let value: Value =
            serde_json::from_str(text).map_err(|_| BenchError::Data("output of a peer"))?;
        let list = |key: &str| -> Vec<f64> {
            value[key].as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
        };
        self.check(program, &list("outputs"))?;
        Ok(Samples::new(list("samples")))
    }

    /// Compares the outputs at all points with ours, relative to the largest value of the same
    /// output at any point, because terms may cancel at one.
    fn check(&self, program: &str, found: &[f64]) -> Result<(), BenchError> {
        if found.len() != self.values.len() {
            return Err(BenchError::Data("number of outputs of a peer"));
        }
        let mut scale = vec![0.0_f64; self.n_outputs];
        for (at, value) in self.values.iter().enumerate() {
            let scale = &mut scale[at % self.n_outputs];
            *scale = scale.max(value.abs());
        }
        for (at, (&found, &expected)) in found.iter().zip(&self.values).enumerate() {
            let (point, output) = (at / self.n_outputs, at % self.n_outputs);
            let is_equal = (found - expected).abs() <= TOLERANCE * scale[output].max(1e-9);
            if !is_equal {
                let (who, what) = (program.to_owned(), format!("output {output}, point {point}"));
                return Err(BenchError::Disagreement { who, what, found, expected });
            }
        }
        Ok(())
    }
}
