//! Cost of a case of a sweep against its integration, and the gain by two threads.
//!
//! Slider-cranks with other lengths and torques, each one a case of one sweep. The same cases are
//! first integrated one after the other from starts found before: a sweep adds to that the values,
//! the start, the outputs and the table.

use std::time::Instant;

use bksim::dae::Control;
use bksim::sim::run::Sample;
use bksim::{Mechanism, Simulation};
use bksim_sweep::{Axis, Design, Existing, Monitor, Plan, Request, Study, SweepError, write};
use serde_json::json;

use crate::error::BenchError;
use crate::peers::Context;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{cpu_time, median};

const MODEL: &str = include_str!("../../../examples/slider-crank/model.toml");

/// End of each run, s.
const T_END: f64 = 0.5;

/// Times of a round, per case.
#[derive(Clone, Copy, Default)]
struct Round {
    /// CPU time, s: integration alone, with the start, the sweep in memory, the sweep as a table.
    cpu: [f64; 4],
    /// Wall time of the table with one thread and with two, s.
    wall: [f64; 2],
    /// CPU time of the table with two threads, s.
    cpu_of_two: f64,
    /// Wall time of starts and integrations alone, with one thread and with two that share nothing, s.
    apart: [f64; 2],
}

/// Measures the suite.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    // Rounds of all measurements.
    let side = if context.effort.is_quick { 4 } else { 100 };
    let study = study(side)?;
    let n_cases = study.n_cases();
    let mut rounds = Vec::new();
    for _ in 0..context.effort.rounds {
        rounds.push(round(&study)?);
    }

    // Medians of the rounds as a table.
    let mut report =
        Report::new("sweep", "sweeps: slider-cranks of other lengths and torques, 0.5 s");
    let all = |of: fn(&Round) -> f64| median(&rounds.iter().map(of).collect::<Vec<_>>());
    let alone = all(|r| r.cpu[0]);
    let mut table = Table::new(["per case", "CPU time", "over the integration"]);
    let rows = [
        ("integration", all(|r| r.cpu[0]), 1.0),
        ("start and integration", all(|r| r.cpu[1]), all(|r| r.cpu[1] / r.cpu[0])),
        ("sweep, one thread", all(|r| r.cpu[2]), all(|r| r.cpu[2] / r.cpu[0])),
        ("sweep into a table, one thread", all(|r| r.cpu[3]), all(|r| r.cpu[3] / r.cpu[0])),
        (
            "sweep into a table, two threads",
            all(|r| r.cpu_of_two),
            all(|r| r.cpu_of_two / r.cpu[0]),
        ),
    ];
    for (what, time, relative) in rows {
        table.push([what.to_owned(), seconds(time), ratio(relative)]);
    }
    report.tables.push(table);

    // The goals: of the table, of two threads, and of two threads relative to the machine's best.
    let over = all(|r| r.cpu[3] / r.cpu[1]);
    let extra = all(|r| r.cpu_of_two / r.cpu[3]);
    let efficiency = all(|r| r.wall[0] / (2.0 * r.wall[1]));
    report.checks.push(Check::at_most("table over start and integration", over, 1.05));
    report.checks.push(Check::at_most("CPU time of two threads over one", extra, 1.1));
    report.checks.push(Check::at_least(
        "wall time of one thread over twice that of two",
        efficiency,
        0.9,
    ));
    let machine = all(|r| r.apart[0] / (2.0 * r.apart[1]));
    report.checks.push(Check::at_least(
        "the same over that of two threads that share nothing",
        all(|r| r.wall[0] / r.wall[1] * r.apart[1] / r.apart[0]),
        0.9,
    ));

    // Notes and numbers.
    report.notes.push(format!(
        "two threads that share nothing reach {machine:.2} of twice the speed of one on this machine"
    ));
    report.numbers.insert("efficiency_of_machine".into(), json!(machine));
    report
        .notes
        .push(format!("{n_cases} cases; the wall times mean something on an idle machine alone"));
    report.numbers.insert("integration_s".into(), json!(alone));
    report.numbers.insert("table_over_solve".into(), json!(over));
    report.numbers.insert("cpu_two_over_one".into(), json!(extra));
    report.numbers.insert("efficiency".into(), json!(efficiency));
    Ok(report)
}

/// A sweep of `side` lengths and as many torques.
fn study(side: u64) -> Result<Study, BenchError> {
    let axis = |name: &str, text: String| Axis::parse(name, &text).map(Option::into_iter);
    let plan = axis("l1", format!("0.8:1.2:{side}")).and_then(|l1| {
        let axes = l1.chain(axis("q1", format!("40:60 N m:{side}"))?).collect();
        Plan::new(axes, Design::Grid)
    });
    let plan = plan.map_err(|fault| refused(&fault.message))?;
    let mut request = Request::new(MODEL, "slider-crank", plan);
    request.outputs = ["max(reactions.B.fx)", "final(theta1)"].map(str::to_owned).to_vec();
    request.changes.t_end = Some(T_END);
    Study::prepare(request).map_err(|rejected| refused(&rejected.to_string()))
}

fn refused(message: &str) -> BenchError {
    BenchError::Model { name: "slider-crank".to_owned(), message: message.to_owned() }
}

fn swept(error: &SweepError) -> BenchError {
    refused(&error.to_string())
}

/// Measures one round.
fn round(study: &Study) -> Result<Round, BenchError> {
    // Integrations alone.
    let n_cases = study.n_cases();
    #[expect(clippy::cast_precision_loss, reason = "ten thousand")]
    let per_case = |seconds: f64| seconds / n_cases as f64;
    let mut round = Round::default();
    [round.cpu[0], round.cpu[1]] = Alone::prepare(study)?.measure(study, 0, 1)?.map(per_case);
    round.apart = [apart(study, 1)?, apart(study, 2)?];

    // The sweep in memory.
    let begun = cpu_time();
    let rows = study.rows(0..n_cases, 1, &Monitor::default()).map_err(|e| swept(&e))?;
    round.cpu[2] = per_case(cpu_time() - begun);
    let n_done = rows.iter().flatten().filter(|row| row.ending.fault().is_none()).count() as u64;
    if n_done != n_cases {
        return Err(BenchError::Data("a slider-crank of the sweep does not run"));
    }

    // The sweep as a table.
    let name = format!("bksim-bench-sweep-{}.parquet", std::process::id());
    let path = std::env::temp_dir().join(name);
    let mut cpu = [0.0; 2];
    for (idx, n_jobs) in [1, 2].into_iter().enumerate() {
        let (begun, wall) = (cpu_time(), Instant::now());
        let written = write(study, &path, Existing::Replace, n_jobs, &Monitor::default());
        written.map_err(|e| swept(&e))?;
        cpu[idx] = per_case(cpu_time() - begun);
        round.wall[idx] = per_case(wall.elapsed().as_secs_f64());
    }
    [round.cpu[3], round.cpu_of_two] = cpu;
    std::fs::remove_file(&path).map_err(|source| BenchError::io(&path, source))?;
    Ok(round)
}

/// Wall time of all starts and integrations by threads that share nothing, s.
fn apart(study: &Study, n_threads: u64) -> Result<f64, BenchError> {
    let prepared: Result<Vec<Alone>, BenchError> =
        (0..n_threads).map(|_| Alone::prepare(study)).collect();
    let prepared = prepared?;
    let begun = Instant::now();
    std::thread::scope(|scope| {
        let work = |(first, alone): (u64, Alone)| {
            scope.spawn(move || alone.measure(study, first, n_threads).map(drop))
        };
        let threads: Vec<_> = (0..).zip(prepared).map(work).collect();
        for thread in threads {
            thread.join().map_err(|_| BenchError::Data("a thread ends"))??;
        }
        Ok(begun.elapsed().as_secs_f64())
    })
}

/// A compiled slider-crank, which a thread has to itself.
struct Alone {
    simulation: Simulation,
    /// Indices of the varied parameters.
    varied: Vec<usize>,
}

impl Alone {
    fn prepare(study: &Study) -> Result<Self, BenchError> {
        let rejected = |rejected: bksim::Rejected| refused(&rejected.to_string());
        let mut mechanism = Mechanism::from_toml(MODEL, "slider-crank").map_err(rejected)?;
        mechanism.model.solve.t_end = T_END;
        let simulation = mechanism.simulation().map_err(rejected)?;
        let index = |name: &str| mechanism.model.parameters.iter().position(|p| p.name == name);
        let columns = study.input_columns();
        let varied: Option<Vec<usize>> = columns.iter().map(|column| index(&column.name)).collect();
        let varied = varied.ok_or(BenchError::Data("a parameter of the slider-crank"))?;
        Ok(Self { simulation, varied })
    }

    /// CPU time of the integrations of every `stride`-th case, and of starts and integrations.
    fn measure(&self, study: &Study, first: u64, stride: u64) -> Result<[f64; 2], BenchError> {
        let Self { simulation, varied } = self;
        let mut simulation = simulation.clone();
        let mut numbers = vec![0.0; varied.len()];
        let mut parameters = simulation.parameters().to_vec();
        let (mut starting, mut running) = (0.0, 0.0);
        let stride = usize::try_from(stride).expect("a stride is a number of threads");
        for case in (first..study.n_cases()).step_by(stride) {
            study.plan().case(case, &mut numbers);
            for (&parameter_idx, &number) in varied.iter().zip(&numbers) {
                parameters[parameter_idx] = number;
            }
            let begun = cpu_time();
            simulation.set_parameters(&parameters);
            let start = simulation
                .start()
                .map_err(|_| BenchError::Data("a slider-crank does not start"))?;
            let started = cpu_time();
            let mut nobody = |_: &Sample| Control::Continue;
            simulation
                .run(&start, &mut nobody, &|| false)
                .map_err(|_| BenchError::Data("a slider-crank does not run"))?;
            starting += started - begun;
            running += cpu_time() - started;
        }
        Ok([running, starting + running])
    }
}
