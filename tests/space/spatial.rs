//! The flyball governor against equations in three coordinates, derived by hand.
//!
//! Both arms start alike, so they stay alike, and nothing turns the whole about its axis: with the
//! angle φ of the spindle, β of the arms below the horizon and the height s of the slider,
//!
//! ```text
//! J(β) φ′ = L
//! K β″ = ½ J′(β) φ′² + 2 g (m/2 + M) l cos β − 2 F ∂r/∂β
//! m_s s″ = −m_s g − 2 F ∂r/∂s
//! F = k (r − r₀) + c r′
//! ```
//!
//! with the length r of the springs. The method of Runge and Kutta of order 4 integrates them here. What
//! the dampers settle decays with 2 c (∂r/∂s)²/m_s, at most 27 000/s: steps of 40 µs are stable with it.

use std::f64::consts::PI;

use crate::support::{Within, at, close, coordinate, derive, example, solve};

const G: f64 = 9.81;
/// Length of spindle and arms, their width, the slider's edge, m.
const L: f64 = 1.0;
const W: f64 = 0.01;
const D: f64 = 0.1;
/// An arm, a ball, the slider, kg.
const ARM: f64 = 0.3;
const BALL: f64 = 5.0;
const SLIDER: f64 = 3.0;
/// Moments of a bar about its axis and across, kg m².
const ALONG: f64 = ARM * W * W / 6.0;
const ACROSS: f64 = ARM * (L * L + W * W) / 12.0;
/// N/m, N s/m, m.
const K: f64 = 8e5;
const C: f64 = 4e4;
const R0: f64 = 0.5;
/// Times that are compared, s.
const TIMES: [f64; 5] = [0.5, 1.0, 2.0, 5.0, 10.0];
/// Of the steps, s.
const STEP: f64 = 4e-5;

/// Moment of inertia about the spindle, and its derivative by β.
fn inertia(beta: f64) -> [f64; 2] {
    let (sin, cos) = beta.sin_cos();
    let [middle, end] = [0.5 * D + 0.5 * L * cos, 0.5 * D + L * cos];
    let turning = ALONG * sin * sin + ACROSS * cos * cos;
    let fixed = ALONG + SLIDER * D * D / 6.0;
    let whole = fixed + 2.0 * (ARM * middle * middle + turning + BALL * end * end);
    let slope = -ARM * middle * L * sin - 2.0 * BALL * end * L * sin;
    [whole, 2.0 * (slope + 2.0 * (ALONG - ACROSS) * sin * cos)]
}

/// Rates of φ, β, s, β′, s′ at an angular momentum.
fn rates(momentum: f64, [_, beta, s, beta_dot, s_dot]: [f64; 5]) -> [f64; 5] {
    let [whole, slope] = inertia(beta);
    let (sin, cos) = beta.sin_cos();
    let phi_dot = momentum / whole;
    let (across, up) = (0.5 * L * cos, L - 0.5 * L * sin - s);
    let r = across.hypot(up);
    let [by_beta, by_s] = [-0.5 * L * (across * sin + up * cos) / r, -up / r];
    let force = K * (r - R0) + C * (by_beta * beta_dot + by_s * s_dot);
    let weight = 2.0 * G * (0.5 * ARM + BALL) * L * cos;
    let turned = 0.5 * slope * phi_dot * phi_dot + weight - 2.0 * force * by_beta;
    let arms = 2.0 * (0.25 * ARM * L * L + ACROSS + BALL * L * L);
    [phi_dot, beta_dot, s_dot, turned / arms, -G - 2.0 * force * by_s / SLIDER]
}

/// φ, β, s, β′, s′ at the times.
fn reference() -> Vec<[f64; 5]> {
    let mut y = [0.0, PI / 6.0, 0.5, 0.0, 0.0];
    let momentum = inertia(y[1])[0] * 2.0 * PI;
    let mut found = Vec::new();
    let mut n_done = 0.0;
    for t in TIMES {
        let n = (t / STEP).round();
        while n_done < n {
            let moved = |h: f64, k: [f64; 5]| std::array::from_fn(|i| y[i] + h * k[i]);
            let a = rates(momentum, y);
            let b = rates(momentum, moved(0.5 * STEP, a));
            let c = rates(momentum, moved(0.5 * STEP, b));
            let d = rates(momentum, moved(STEP, c));
            y = std::array::from_fn(|i| {
                y[i] + STEP / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i])
            });
            n_done += 1.0;
        }
        found.push(y);
    }
    found
}

#[test]
fn the_governor_moves_as_its_equations_in_three_coordinates_say() {
    let mechanism = derive(example("governor"));
    let motion = solve(&mechanism);
    // The relative tolerance of the run.
    let within = Within { relative: 1e-8, absolute: 1e-8 };
    let places = ["phi", "beta1", "beta2", "s"].map(|name| coordinate(&mechanism, name));
    for (t, [phi, beta, s, beta_dot, s_dot]) in TIMES.into_iter().zip(reference()) {
        let sample = at(&motion, t);
        let expected = [[phi, f64::NAN], [beta, beta_dot], [beta, beta_dot], [s, s_dot]];
        for (place, [value, rate]) in places.into_iter().zip(expected) {
            let name = &mechanism.compiled.coordinates[place].name;
            close(&format!("{name} at {t} s"), sample.q[place], value, within);
            if !rate.is_nan() {
                close(&format!("rate of {name} at {t} s"), sample.v[place], rate, within);
            }
        }
    }
}
