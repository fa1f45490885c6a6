//! Functions that leave the program: C of `bksim code --part dynamics` against C that CasADi writes of the same
//! functions, derived there from the energies and the constraints.
//!
//! ```text
//! terms          t, q, v -> M, f, G, γ      M v̇ + Gᵀ λ = f, G v̇ = −γ
//! accelerations  t, q, v -> v̇, λ
//! ```
//!
//! Both take the parameters at each call. Both are compiled with the same flags and must agree at all points before
//! they are timed.

use std::path::{Path, PathBuf};

use bksim::analysis::{ExportedFunction, Part, exported};
use bksim_sim::Mechanism;
use serde_json::{Map, Value, json};

use super::evaluation::{Expected, N_POINTS, ROUNDS};
use super::systems::noise;
use crate::context::Context;
use crate::error::BenchError;
use crate::models;
use crate::peers::{self, Workbench, native};
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::Samples;

/// Both compilers' flags.
const FLAGS: [&str; 1] = ["-O3"];
/// Our functions, with CasADi's ways to them.
const FUNCTIONS: [(&str, &[&str]); 2] =
    [("terms", &["terms"]), ("accelerations", &["accelerations, QR", "accelerations, LDL"])];

/// A mechanism with its coordinates in the order of `peers/machines_casadi.py`, and a pose.
struct Machine {
    name: &'static str,
    text: String,
    pose: Vec<(String, f64)>,
}

/// A program for one function.
struct Program {
    /// `bksim`, or the way of CasADi.
    name: &'static str,
    n_operations: u64,
    source_bytes: usize,
    /// The size of the object file, and the program; `None` without a compiler.
    compiled: Option<(u64, PathBuf)>,
    /// All rounds.
    samples: Samples,
}

impl Program {
    fn object_bytes(&self) -> Option<u64> {
        self.compiled.as_ref().map(|(bytes, _)| *bytes)
    }
}

fn machines() -> Vec<Machine> {
    let machine = |name, text: &str, pose: &[(&str, f64)]| Machine {
        name,
        text: text.to_owned(),
        pose: pose.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
    };
    let slider_crank = machine(
        "slider_crank",
        include_str!("../../../../examples/slider-crank/model.toml"),
        &[("theta1", 0.4), ("x2", 2.4), ("y2", 0.2), ("theta2", -0.13), ("x3", 3.9)],
    );
    let five_link = machine(
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
    );
    let links = [("q1", 0.3), ("q2", -0.4), ("q3", 0.5), ("q4", 0.2)];
    vec![slider_crank, five_link, machine("chain", &models::chain(links.len()), &links)]
}

/// Measures all mechanisms.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("generated", "generated C: size, and CPU time of a call");
    let bench = Workbench::new()?;
    let mut table =
        Table::new(["", "by", "operations", "source, kB", "object, kB", "a call", "ratio"]);
    for machine in machines() {
        let mut numbers = Map::new();
        for (function, rows) in measured(context, &bench, &machine, &mut report.notes)? {
            let best = |row: &Program| row.samples.minimum();
            let ours = rows.first().map_or(f64::NAN, best);
            let theirs = rows.iter().skip(1).map(best).fold(f64::NAN, f64::min);
            for row in &rows {
                table.push([
                    format!("{}, {function}", machine.name),
                    row.name.to_owned(),
                    row.n_operations.to_string(),
                    format!("{:.1}", row.source_bytes as f64 / 1e3),
                    row.object_bytes().map_or("-".to_owned(), |n| format!("{:.1}", n as f64 / 1e3)),
                    seconds(best(row)),
                    ratio(best(row) / ours),
                ]);
                let all = json!({
                    "operations": row.n_operations, "source_bytes": row.source_bytes,
                    "object_bytes": row.object_bytes(), "min_s": best(row),
                    "median_s": row.samples.median(),
                });
                numbers.insert(format!("{function}, {}", row.name), all);
            }
            let what = format!("{}, {function}: ours over CasADi's faster", machine.name);
            report.checks.push(Check::at_most(what, ours / theirs, 1.0));
        }
        report.numbers.insert(machine.name.to_owned(), Value::Object(numbers));
    }
    report.tables.push(table);
    report.notes.sort();
    report.notes.dedup();
    Ok(report)
}

/// The programs of each function of a machine, ours first.
fn measured(
    context: &Context,
    bench: &Workbench,
    machine: &Machine,
    notes: &mut Vec<String>,
) -> Result<Vec<(&'static str, Vec<Program>)>, BenchError> {
    // Our functions, and the places of the peer's coordinates among ours.
    let mechanism = Mechanism::derive(models::model(&machine.text, machine.name)?, Vec::new());
    let refused = || BenchError::Data("a mechanism that has no equations");
    let mechanism = mechanism.map_err(|_| refused())?;
    let functions = exported(&mechanism, Part::Dynamics, &[]).map_err(|_| refused())?;
    let coordinates = mechanism.system.coordinates();
    let place = |(name, _): &(String, f64)| coordinates.iter().position(|c| c.name == *name);
    let order: Option<Vec<usize>> = machine.pose.iter().map(place).collect();
    let order = order.ok_or(BenchError::Data("coordinates of the model"))?;
    let names = mechanism.model.parameters.iter().map(|parameter| parameter.name.clone());
    let request = json!({
        "name": machine.name, "order": order, "nc": mechanism.system.constraints.len(),
        "parameters": names.collect::<Vec<_>>(),
    });
    let theirs = context.peers.python("generated_casadi", &request);
    if let Err(absent) = &theirs {
        notes.push(format!("CasADi: {absent}"));
    }

    let mut all = Vec::new();
    for (name, ways) in FUNCTIONS {
        let own = functions.iter().find(|f| f.signature.name.ends_with(&format!("_{name}")));
        let own = own.ok_or(BenchError::Data("a function of the mechanism"))?;
        let expected = Expected::new(&own.tape, own.parameters.clone(), points(machine, &order));
        let builder = Builder { context, bench, parameters: &own.parameters };
        let mut programs = vec![builder.ours(own, notes)?];
        if let Ok(found) = &theirs {
            for way in ways {
                programs.push(builder.casadi(way, &found["functions"][way], notes)?);
            }
        }
        for _ in 0..context.effort.rounds * ROUNDS {
            for Program { name, compiled, samples, .. } in &mut programs {
                let Some((_, path)) = compiled else { continue };
                match peers::program(path, &expected.request()) {
                    Ok(text) => samples.extend(&expected.checked(name, &text)?),
                    Err(absent) => notes.push(format!("{name}: {absent}")),
                }
            }
        }
        all.push((name, programs));
    }
    Ok(all)
}

/// States around the pose, at time zero, in our order.
fn points(machine: &Machine, order: &[usize]) -> Vec<f64> {
    let mut noise = noise();
    let mut points = Vec::new();
    for _ in 0..N_POINTS {
        let mut q = vec![0.0; order.len()];
        for ((_, value), &place) in machine.pose.iter().zip(order) {
            q[place] = value + 0.2 * noise();
        }
        points.push(0.0);
        points.extend(q);
        points.extend(order.iter().map(|_| 4.0 * noise()));
    }
    points
}

/// Compiles the functions of one machine.
struct Builder<'a> {
    context: &'a Context,
    bench: &'a Workbench,
    parameters: &'a [f64],
}

impl Builder<'_> {
    /// Our function.
    fn ours(
        &self,
        function: &ExportedFunction,
        notes: &mut Vec<String>,
    ) -> Result<Program, BenchError> {
        let program = function.tape.program(&function.signature);
        let program = program.map_err(|_| BenchError::Data("a signature made for its tape"))?;
        let (name, code) = (program.identifier(), program.to_c());
        self.bench.write(&format!("{name}.h"), &code.header)?;
        let adapter = format!(
            "#include \"{name}.h\"\nvoid evaluate(const double *inputs, double *outputs) {{\n    \
             static const double parameters[] = {{{}}};\n    {name}(inputs, parameters, outputs);\n}}\n",
            self.numbers()
        );
        let sources = (code.source.as_str(), adapter.as_str());
        self.compiled("bksim", function.tape.operation_count() as u64, sources, notes)
    }

    /// A function that CasADi wrote.
    fn casadi(
        &self,
        way: &'static str,
        found: &Value,
        notes: &mut Vec<String>,
    ) -> Result<Program, BenchError> {
        let source = found["source"].as_str().ok_or(BenchError::Data("CasADi's source"))?;
        let n_operations = found["n_instructions"].as_u64().unwrap_or_default();
        let adapter = format!(
            "int casadi_f(const double **arg, double **res, long long *iw, double *w, int mem);\n\
             void evaluate(const double *inputs, double *outputs) {{\n    \
             static const double parameters[] = {{{}}};\n    static double w[65536];\n    \
             static long long iw[65536];\n    const double *arg[16] = {{inputs, parameters}};\n    \
             double *res[16] = {{outputs}};\n    casadi_f(arg, res, iw, w, 0);\n}}\n",
            self.numbers()
        );
        self.compiled(way, n_operations, (source, &adapter), notes)
    }

    fn numbers(&self) -> String {
        let numbers: Vec<String> = self.parameters.iter().map(|x| format!("{x:?}")).collect();
        numbers.join(", ")
    }

    /// A program of a function and what calls it; the object file is of the function alone.
    fn compiled(
        &self,
        name: &'static str,
        n_operations: u64,
        (source, adapter): (&str, &str),
        notes: &mut Vec<String>,
    ) -> Result<Program, BenchError> {
        let stem = name.replace(", ", "_");
        let file = self.bench.write(&format!("{stem}.c"), source)?;
        let caller = self.bench.write(&format!("{stem}_adapter.c"), adapter)?;
        let (object, path) = (self.bench.file(&format!("{stem}.o")), self.bench.file(&stem));
        let compile = |sources: &[&Path], flags: &[&str], target: &Path| {
            self.context.peers.compile(sources, flags, &[], target)
        };
        let built = compile(&[&file], &[&FLAGS[..], &["-c"]].concat(), &object)
            .and_then(|()| compile(&[&file, &caller, &native("harness.c")], &FLAGS, &path));
        let compiled = match built {
            Ok(()) => {
                let written = std::fs::metadata(&object);
                Some((written.map_err(|error| BenchError::io(&object, error))?.len(), path))
            }
            Err(absent) => {
                notes.push(format!("{name}: {absent}"));
                None
            }
        };
        let (source_bytes, samples) = (source.len(), Samples::default());
        Ok(Program { name, n_operations, source_bytes, compiled, samples })
    }
}
