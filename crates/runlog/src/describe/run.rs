//! The course of a run: its end, methods, events, work and residuals.

use bksim_mbs::constraint::Source;
use bksim_sim::run::{Integrator, Reason, Summary};
use serde_json::{Value, json};

use super::events::events;
use super::uniqueness::uniqueness;
use bksim_sim::Mechanism;

/// End, methods, events, work, residuals and energy balance.
pub fn summary(mechanism: &Mechanism, summary: &Summary) -> Value {
    let Summary { t, n_samples, stats, position_residual, velocity_residual, energy, .. } = summary;
    let relative = if energy.scale > 0.0 { energy.worst_error / energy.scale } else { 0.0 };
    let promised = summary.promised_drift(&mechanism.model.solve);
    json!({
            "end": { "reached": summary.reached_end, "t": t },
            "samples": n_samples,
            "methods": summary.methods.iter().map(|change| json!({
                "t": change.t,
                "method": method_word(change.method),
                "reason": reason_words(change.reason),
            })).collect::<Vec<_>>(),
            "singular_poses": summary.singular_poses.iter().map(|pose| json!({
                "t": pose.t,
                "rank": pose.rank,
                "names": sources(mechanism, &pose.rows),
            })).collect::<Vec<_>>(),
            "uniqueness": uniqueness(mechanism, &summary.uniqueness),
            "events": events(mechanism, &summary.changes),
            "steps": {
                "n_step": stats.n_step, "n_accept": stats.n_accept, "n_reject": stats.n_reject,
                "n_newton_failed": stats.n_newton_failed, "n_newton": stats.n_newton,
                "n_residual": stats.n_residual, "n_jacobian": stats.n_jacobian,
                "n_factor": stats.n_factor, "n_solve": stats.n_solve,
            },
            "residual": {
                "position": position_residual[1], "velocity": velocity_residual[1],
                "position_before_projection": position_residual[0],
                "velocity_before_projection": velocity_residual[0],
                "promised_position": promised[0], "promised_velocity": promised[1],
            },
            "energy": {
                "initial": energy.initial, "last": energy.last, "work": energy.work,
                "impacts": energy.impacts,
                "worst_error": energy.worst_error, "scale": energy.scale,
                "relative_error": relative,
                "promised_error": summary.promised_energy_error(&mechanism.model.solve),
            },
    })
}

/// The summary of a run that its log holds as text; `None` where there is none.
///
/// Logs of earlier versions call the work of impacts `blows`; it is handed out by today's name.
pub fn logged_summary(details: &str) -> Option<Value> {
    let mut summary: Value = serde_json::from_str(details).ok().filter(Value::is_object)?;
    if let Some(energy) = summary.get_mut("energy").and_then(Value::as_object_mut)
        && let Some(work) = energy.remove("blows")
    {
        energy.insert("impacts".to_owned(), work);
    }
    Some(summary)
}

/// Names of the joints, couplings, drives and loads of some constraint rows, each once.
pub fn sources<'a>(mechanism: &'a Mechanism, rows: &[usize]) -> Vec<&'a str> {
    let Mechanism { model, system, .. } = mechanism;
    let mut names: Vec<&str> = Vec::new();
    for &row in rows {
        let name = match system.constraints[row].source {
            Source::Joint(joint) => &model.joints[joint.0].name,
            Source::Quaternion(body) => &model.bodies[body.0].name,
            Source::Coupling(coupling) => &model.couplings[coupling.0].name,
            Source::Drive(drive) => &model.drives[drive.0].name,
            Source::Stop(load) | Source::Friction(load) => &model.loads[load.0].name,
        };
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

/// The word of an integrator.
pub fn method_word(method: Integrator) -> &'static str {
    match method {
        Integrator::Explicit => "explicit",
        Integrator::Radau => "radau",
    }
}

/// Why a method is used, in a few words.
pub fn reason_words(reason: Reason) -> &'static str {
    match reason {
        Reason::Asked => "as asked",
        Reason::Cheapest => "least work while the motion is not stiff",
        Reason::Stiff => "the motion is stiff",
        Reason::Slow => "explicit steps would be far too many",
        Reason::NoGain => "Radau IIA needs nearly as many steps",
        Reason::OtherFailed => "the other method cannot go on here",
        Reason::SingularPose => "past the singular pose ahead",
        Reason::Regular => "behind the singular pose",
        Reason::Relaxed => "the motion is no longer stiff",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_of_any_version_name_the_work_of_impacts_alike() {
        for word in ["blows", "impacts"] {
            let text = format!(r#"{{"energy": {{"work": 1.0, "{word}": -2.5}}}}"#);
            let expected = json!({ "energy": { "work": 1.0, "impacts": -2.5 } });
            assert_eq!(logged_summary(&text), Some(expected), "{word}");
        }
        assert_eq!(logged_summary(r#"{"events": []}"#), Some(json!({ "events": [] })));
        assert_eq!(logged_summary("[1]"), None);
        assert_eq!(logged_summary(""), None);
    }
}
