//! Fortran's RADAU5 and DOP853 and SUNDIALS' IDA, on the hand-written C of `native/precision`, and heyoka on the same
//! equations in Python.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::curve::{Counters, Curve, Point, digits};
use super::problem::Problem;
use crate::error::BenchError;
use crate::peers::{Absent, Peers, Workbench, native, program};
use crate::timing::Effort;

/// One of the other solvers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Solver {
    /// RADAU5, index 2, exact Jacobian, eliminated velocity rows.
    Radau5,
    /// DOP853 on the multiplier system.
    Dop853,
    /// IDA, index 1.
    Ida,
    /// heyoka's Taylor series of the multiplier system.
    Heyoka,
}

impl Solver {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Radau5, Self::Dop853, Self::Ida, Self::Heyoka];

    /// Name in the report.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Radau5 => "RADAU5",
            Self::Dop853 => "DOP853",
            Self::Ida => "IDA",
            Self::Heyoka => "heyoka",
        }
    }
}

/// A solver with one problem, compiled where its equations are C.
#[derive(Debug)]
pub(crate) struct Compiled {
    solver: Solver,
    path: PathBuf,
}

impl Compiled {
    /// Compiles a solver's driver with the equations of `problem`.
    pub(crate) fn new(
        solver: Solver,
        problem: &Problem,
        peers: &Peers,
        bench: &Workbench,
    ) -> Result<Self, Absent> {
        let source = problem.definition.source;
        let path = bench.file(&format!("{solver:?}-{source}"));
        let name = format!("-DPROBLEM=\"{source}\"");
        let mut flags = vec!["-std=gnu11", "-O3", "-march=native", name.as_str()];
        let driver = |file: &str| native("precision").join(file);
        match solver {
            Solver::Radau5 => {
                let library = peers.r_library("deSolve")?;
                peers.compile(&[&driver("radau5.c"), Path::new(&library)], &flags, &[], &path)?;
            }
            Solver::Ida => {
                let libraries = ["-l:libsundials_ida.so.6", "-l:libsundials_nvecserial.so.6"];
                peers.compile(&[&driver("ida.c")], &flags, &libraries, &path)?;
            }
            Solver::Dop853 => {
                flags.extend(["-shared", "-fPIC"]);
                peers.compile(&[&driver("dop853.c")], &flags, &[], &path)?;
            }
            Solver::Heyoka => (),
        }
        Ok(Self { solver, path })
    }

    /// Runs all `tolerances`.
    pub(crate) fn curve(
        &self,
        problem: &Problem,
        tolerances: &[f64],
        peers: &Peers,
        effort: Effort,
    ) -> Result<Curve, Absent> {
        let request = json!({
            "problem": problem.definition.name, "library": self.path, "t_end": problem.t_end,
            "q": problem.start.q, "v": problem.start.v, "tolerances": tolerances,
            "n_max": effort.max_runs, "enough_s": effort.enough_s,
        });
        let rows = match self.solver {
            Solver::Dop853 => peers.python("dop853", &request)?,
            Solver::Heyoka => peers.python("heyoka_precision", &request)?,
            Solver::Radau5 | Solver::Ida => {
                let output = program(&self.path, &input(problem, tolerances, effort))?;
                serde_json::from_str(&output).map_err(|error| error.to_string())?
            }
        };
        let rows = rows.as_array().ok_or("it printed no list")?;
        let points = rows.iter().map(|row| point(problem, row)).collect();
        Ok(Curve { name: self.solver.name(), points })
    }
}

/// The input of a driver; see `driver.h`.
fn input(problem: &Problem, tolerances: &[f64], effort: Effort) -> String {
    let start = &problem.start;
    let values = [problem.t_end].into_iter().chain(start.q.iter().copied());
    let values = values.chain(start.v.iter().copied()).chain(start.a.iter().copied());
    let values = values.chain(start.lambda.iter().copied());
    let text = |values: &mut dyn Iterator<Item = f64>| {
        values.map(|value| format!("{value:?}")).collect::<Vec<_>>().join(" ")
    };
    let start = text(&mut { values });
    let tolerances = text(&mut tolerances.iter().copied());
    format!("{start}\n{} {}\n{tolerances}\n", effort.max_runs, effort.enough_s)
}

/// A run from the output of a driver.
fn point(problem: &Problem, row: &Value) -> Point {
    let vector = |name: &str| -> Vec<f64> {
        let entries = row[name].as_array().map(Vec::as_slice).unwrap_or_default();
        entries.iter().map(|entry| entry.as_f64().unwrap_or(f64::NAN)).collect()
    };
    let count =
        |name: &str| row[name].as_u64().map_or(0, |n| usize::try_from(n).unwrap_or(usize::MAX));
    let reference = &problem.reference;
    let found = [("q", &reference.q), ("v", &reference.v), ("lambda", &reference.lambda)];
    let is_reached = row["reached"] == Value::Bool(true);
    let digits_of = |(name, reference): (&str, &Vec<f64>)| {
        if is_reached { digits(&vector(name), reference) } else { f64::NAN }
    };
    Point {
        tolerance: row["tolerance"].as_f64().unwrap_or(f64::NAN),
        digits: found.map(digits_of),
        seconds: row["seconds"].as_f64().unwrap_or(f64::NAN),
        counters: Counters {
            n_step: count("n_step"),
            n_reject: count("n_reject"),
            n_residual: count("n_residual"),
            n_jacobian: count("n_jacobian"),
            n_factor: count("n_factor"),
        },
    }
}

/// Checks that the results of a solver converge to the reference: its best run has six digits of
/// the positions. Otherwise it solves something else, and its times mean nothing.
pub(crate) fn verify(problem: &Problem, curve: &Curve, effort: Effort) -> Result<(), BenchError> {
    const NEEDED: f64 = 6.0;
    // A quick run stops at loose tolerances.
    if effort.is_quick {
        return Ok(());
    }
    let best = curve.points.iter().map(|point| point.digits[0]).fold(f64::NAN, f64::max);
    if best >= NEEDED {
        return Ok(());
    }
    Err(BenchError::Disagreement {
        who: curve.name.to_owned(),
        what: format!("correct digits of {}, best run", problem.definition.name),
        found: best,
        expected: NEEDED,
    })
}
