//! Chains of rods on spherical joints, in both kinds of coordinates, next to Pinocchio, MuJoCo and Exudyn.
//!
//! A chain of the length and mass one, straight and level at first, turns about the vertical and falls. Measured is the
//! place of its free end.

use bksim::model::CoordinatePolicy;
use serde_json::json;

use crate::error::BenchError;
use crate::peers::Context;
use crate::race::{Case, Peer, compare};
use crate::report::Report;

/// The longest chain in relative coordinates: M is full, and each entry is a formula.
const LARGEST_RELATIVE: usize = 100;

const PEERS: [Peer; 3] = [
    Peer { name: "Pinocchio, DOP853", script: "balls_pinocchio", sizes: &[1e-4, 1e-6, 1e-8] },
    Peer { name: "MuJoCo, RK4", script: "balls_mujoco", sizes: &[2e-3, 1e-3, 5e-4, 2e-4] },
    Peer {
        name: "Exudyn, generalised alpha",
        script: "balls_exudyn",
        sizes: &[5e-3, 2e-3, 1e-3, 5e-4],
    },
];

/// Compares all chains.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let sizes: &[usize] = if context.effort.is_quick { &[3] } else { &[10, 100, 1000] };
    let cases: Vec<Case> = sizes.iter().map(|&n| case(n)).collect();
    let mut report = Report::new("balls", "Chains of spherical joints");
    compare(&cases, context, &mut report)?;
    let note = "chains beyond 100 in relative coordinates are not derived: M is full";
    report.notes.push(note.to_owned());
    Ok(report)
}

/// The chain of `n` rods; of long ones, which have fast motions, a part of the motion.
fn case(n: usize) -> Case {
    let (t_end, finest, tolerances): (f64, f64, &[f64]) = match n {
        0..=10 => (0.5, 1e-11, &[1e-3, 1e-4, 1e-6, 1e-8]),
        11..=100 => (0.1, 1e-9, &[1e-3, 1e-5, 1e-7]),
        _ => (0.01, 1e-7, &[1e-4]),
    };
    let mut policies = vec![CoordinatePolicy::Relative, CoordinatePolicy::Absolute];
    policies.retain(|&policy| n <= LARGEST_RELATIVE || policy == CoordinatePolicy::Absolute);
    let (along, across) = moments(n);
    Case {
        name: n.to_string(),
        text: chain(n),
        measured: ["x", "y", "z"].map(|axis| format!("b{n}.E.{axis}")).to_vec(),
        t_end,
        level: 1e-4,
        policies,
        tolerances,
        finest,
        peers: &PEERS,
        request: json!({ "n": n, "along": along, "across": across }),
    }
}

/// The chain of `n` rods; x leads from the wall to its free end.
fn chain(n: usize) -> String {
    let (length, mass) = (1.0 / n as f64, 1.0 / n as f64);
    let (along, across) = moments(n);
    let half = 0.5 * length;
    let mut text = "space = \"spatial\"\n[loads.gravity]\ntype = \"gravity\"\n\
                    acceleration = [0, 0, -9.81]\n"
        .to_owned();
    let (mut joints, mut initial) = (String::new(), "[initial]\n".to_owned());
    for i in 1..=n {
        let from = if i == 1 { "ground".to_owned() } else { format!("b{}.E", i - 1) };
        text.extend([format!(
            "[bodies.b{i}]\nmass = {mass:?}\ninertia = [{along:?}, {across:?}, {across:?}]\n\
             points = {{ O = [-{half:?}, 0, 0], E = [{half:?}, 0, 0] }}\n"
        )]);
        joints.extend([format!(
            "[joints.j{i}]\ntype = \"spherical\"\nbetween = [\"{from}\", \"b{i}.O\"]\n"
        )]);
        let spin = u8::from(i == 1);
        initial.extend([format!(
            "j{i} = {{ angle1 = 0, angle2 = 0, angle3 = 0, rate1 = 0, rate2 = 0, rate3 = {spin} }}\n"
        )]);
    }
    text + &joints + &initial
}

/// Moments of inertia of a rod along itself and across, kg m².
fn moments(n: usize) -> (f64, f64) {
    let size = (1.0 / n as f64).powi(3);
    (0.02 * size, size / 12.0)
}
