//! Runs of one mechanism at several sets of values, whose explicit steps are taken together.
//!
//! Every run goes its own way, with steps of its own size, events and samples: only the arithmetic of the steps that
//! are tried next is done at once, one run in each lane of the registers. The bits are those of single runs.

use bksim_dae::StepSpan;
use bksim_expr::widest_lanes;

use super::observer::Observer;
use super::problem::Problem;
use super::progress::{Run, StepOutcome};
use super::summary::{Failure, Summary};
use crate::compiled::CompiledSystem;
use crate::whole_step::{LaneSteps, WholeStep};

/// Runs that are taken together, at most: the lanes of this machine.
pub fn ensemble_size() -> usize {
    widest_lanes()
}

/// Integrates up to [`ensemble_size`] problems from their starts, each with its observer, as [`run`](super::run()) does one; `stop` is
/// asked after every step. Results are in the order of the problems.
///
/// # Panics
/// When there are more problems than that.
pub fn run_together<O: Observer>(
    problems: &[Problem<'_>],
    observers: &mut [O],
    stop: &dyn Fn() -> bool,
) -> Vec<Result<Summary, Box<Failure>>> {
    assert!(problems.len() <= ensemble_size(), "{} runs in lanes", problems.len());
    let mut members: Vec<Option<Run<'_>>> = Vec::with_capacity(problems.len());
    for (&problem, observer) in problems.iter().zip(&mut *observers) {
        members.push(Some(Run::begin(problem, observer)));
    }
    let system = problems.first().map(|problem| problem.compiled);
    // Those of different mechanisms have no steps in common.
    let is_one = |system: &&CompiledSystem| {
        problems.iter().all(|problem| std::ptr::eq(problem.compiled, *system))
    };
    let step = system.filter(is_one).and_then(|system| system.step.as_deref());
    let mut outcomes: Vec<_> = problems.iter().map(|_| None).collect();
    let mut lanes = None;
    while members.iter().any(Option::is_some) {
        if let Some(step) = step {
            take_steps(step, &mut members, &mut lanes);
        }
        // Each passes its step to the end, and tries others by itself where that one is rejected.
        for ((member, observer), outcome) in
            members.iter_mut().zip(&mut *observers).zip(&mut outcomes)
        {
            let Some(run) = member else { continue };
            let stepped = run.step(observer, stop);
            if !matches!(stepped, Ok(StepOutcome::Ongoing)) {
                *outcome = member.take().map(|run| stepped.map(|_| run.finish(observer)));
            }
        }
    }
    outcomes.into_iter().map(|outcome| outcome.expect("a run that has gone has ended")).collect()
}

/// Takes the pending steps of the members in lanes, if there are several.
fn take_steps(step: &WholeStep, members: &mut [Option<Run<'_>>], lanes: &mut Option<LaneSteps>) {
    let pending = |member: &Option<Run<'_>>| member.as_ref()?.pending().map(|step| step.span);
    let spans: Vec<Option<StepSpan>> = members.iter().map(pending).collect();
    if spans.iter().flatten().count() < 2 {
        return;
    }
    for (lane, member) in members.iter().enumerate() {
        let Some(pending) = member.as_ref().and_then(Run::pending) else { continue };
        if lanes.is_none() {
            *lanes = LaneSteps::new(step, pending.parameters);
        }
        let Some(lanes) = lanes else { return };
        lanes.set(step, lane, pending);
    }
    let Some(lanes) = lanes else { return };
    lanes.take(step);
    for (lane, (member, span)) in members.iter_mut().zip(spans).enumerate() {
        if let (Some(run), Some(span)) = (member, span)
            && let Some(room) = run.room_for(span)
        {
            lanes.results_into(lane, room);
        }
    }
}
