//! Trajectories against reference solutions of at least thirteen correct digits.
//!
//! Both mechanisms amplify errors as they tumble, so that the digits at a time are compared with
//! the digits the tolerance promises there, and the horizon of each comparison is stated.

use crate::support::{
    at, brief, coordinate, derive, example, fitted_order, path, solve, weighted_error,
};
use bksim::sim::run::Sample;
use bksim::{Mechanism, Motion};
use serde_json::Value;

/// A reference solution, its columns in the order of the mechanism's own state.
struct Reference {
    rows: Vec<Sample>,
}

impl Reference {
    fn read(mechanism: &Mechanism, name: &str) -> Self {
        let file = path("tests/data").join(format!("{name}.json"));
        let text = std::fs::read_to_string(file).expect("the reference is there");
        let data: Value = serde_json::from_str(&text).expect("the reference is JSON");
        let words = |key: &str| -> Vec<String> {
            let list = data[key].as_array().expect("a list");
            list.iter().map(|word| word.as_str().expect("a name").to_owned()).collect()
        };
        let columns: Vec<usize> =
            words("coordinates").iter().map(|name| coordinate(mechanism, name)).collect();
        let multipliers = words("multipliers");
        let known: Vec<&str> =
            mechanism.compiled.multipliers.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(multipliers, known, "constraints are in another order");
        let row = |row: &Value| {
            let numbers = |key: &str| -> Vec<f64> {
                let list = row[key].as_array().expect("a list");
                list.iter().map(|x| x.as_f64().expect("a number")).collect()
            };
            let sorted = |key: &str| {
                let mut sorted = vec![0.0; columns.len()];
                columns.iter().zip(numbers(key)).for_each(|(&column, x)| sorted[column] = x);
                sorted
            };
            Sample {
                t: row["t"].as_f64().expect("a time"),
                q: sorted("q"),
                v: sorted("v"),
                a: sorted("a"),
                lambda: numbers("lambda"),
                ..Sample::default()
            }
        };
        Self { rows: data["rows"].as_array().expect("rows").iter().map(row).collect() }
    }

    /// Worst errors of q, v, a and λ over the rows up to `t_end`, relative to the size of each.
    fn errors(&self, motion: &Motion, t_end: f64) -> [f64; 4] {
        let mut worst = [0.0; 4];
        for row in self.rows.iter().filter(|row| row.t <= t_end) {
            let found = at(motion, row.t);
            let pairs = [
                (&found.q, &row.q),
                (&found.v, &row.v),
                (&found.a, &row.a),
                (&found.lambda, &row.lambda),
            ];
            for (worst, (found, expected)) in worst.iter_mut().zip(pairs) {
                *worst = f64::max(*worst, weighted_error(found, expected));
            }
        }
        worst
    }
}

/// The motion of an example to `t_end` at a tolerance.
fn motion(name: &str, rtol: f64, t_end: f64) -> (Mechanism, Motion) {
    let mut model = example(name);
    model.solve.rtol = rtol;
    model.solve.atol = rtol;
    model.solve.t_end = t_end;
    model.solve.every = Some(0.1);
    let mechanism = derive(model);
    let motion = solve(&mechanism);
    (mechanism, motion)
}

const MECHANISMS: [(&str, f64); 2] = [("slider-crank", 5.0), ("five-link", 50.0)];

/// How many times the tolerance the global error of q, v, a and λ may be: the step's error is kept
/// below the tolerance, the mechanism amplifies it, and each differentiation in time multiplies it
/// by the mechanism's frequency (the slider-crank turns at 15 rad/s at the end; the five-link's dyad
/// snaps through six times, each time with accelerations far above the rest).
const PROMISE: [f64; 4] = [10.0, 100.0, 100.0, 100.0];

/// Worst errors of q, v, a and λ of a run.
fn errors(name: &str, rtol: f64, t_end: f64) -> [f64; 4] {
    let (mechanism, motion) = motion(name, rtol, t_end);
    Reference::read(&mechanism, name).errors(&motion, t_end)
}

#[test]
fn positions_velocities_accelerations_and_multipliers_have_the_digits_of_the_tolerance() {
    for (name, t_end) in MECHANISMS {
        let mut before = [f64::INFINITY; 4];
        for rtol in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
            let errors = errors(name, rtol, t_end);
            let all = brief(&errors);
            for (k, what) in ["q", "v", "a", "λ"].iter().enumerate() {
                // Far too small an error would mean that the tolerance is not what is paid for.
                let promised = 1e-3 * rtol..PROMISE[k] * rtol;
                let error = errors[k];
                assert!(
                    promised.contains(&error),
                    "{name}: {what} is off by {error:.1e} at rtol {rtol:.0e}; q v a λ: {all}"
                );
                assert!(
                    error < before[k] / 3.0,
                    "{name}: {what} is off by {error:.1e} at rtol {rtol:.0e}, {:.1e} at ten times it",
                    before[k]
                );
            }
            before = errors;
        }
    }
}

#[test]
fn halving_the_tolerance_about_halves_the_error() {
    for (name, t_end) in [("slider-crank", 5.0), ("five-link", 10.0)] {
        // One halving alone is a matter of luck; over a ladder of twelve it is not.
        let ladder: Vec<f64> = (0..12).map(|k| 1e-5 * 0.5_f64.powi(k)).collect();
        let worst = |&rtol: &f64| errors(name, rtol, t_end).into_iter().fold(0.0, f64::max);
        let errors: Vec<f64> = ladder.iter().map(worst).collect();
        let slope = fitted_order(&ladder, &errors);
        assert!((0.6..1.5).contains(&slope), "{name}: slope {slope:.2} of {}", brief(&errors));
    }
}

#[test]
fn the_worst_constraint_residual_stays_far_below_the_tolerance() {
    for (name, t_end) in MECHANISMS {
        let (_, motion) = motion(name, 1e-7, t_end);
        let [position, velocity] =
            [motion.summary.position_residual[0], motion.summary.velocity_residual[0]];
        assert!(position < 1e-6, "{name}: position constraints drift to {position:.1e} m");
        assert!(velocity < 1e-5, "{name}: velocity constraints drift to {velocity:.1e} m/s");
    }
}
