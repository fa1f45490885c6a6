//! Freedoms of what was found: velocities of plane bodies against the conditions of their joints.
//!
//! ```text
//! freedoms = 3 n − rank J
//! ```
//!
//! A row of `J` is a condition on the velocities `(vx, vy, ω l)` of all bodies at the drawn pose, scaled to length one;
//! `l` is the size of the drawing. Conditions that are equal but for the drawing's own error count once.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::sub;
use nalgebra::DMatrix;

use super::joint::{Joint, Kind, On};
use super::pieces::turned;

/// Freedoms with singular values below `loose` taken as zero.
pub(super) fn freedoms(joints: &[Joint], n_bodies: usize, size: f64, loose: f64) -> i64 {
    let rows = rows(joints, n_bodies, size);
    let n = 3 * n_bodies;
    let all = i64::try_from(n).unwrap_or(i64::MAX);
    if rows.is_empty() || n == 0 {
        return all;
    }
    let matrix = DMatrix::from_fn(rows.len(), n, |r, c| rows[r][c]);
    let rank = matrix.singular_values().iter().filter(|value| **value > loose).count();
    all - i64::try_from(rank).unwrap_or(0)
}

fn rows(joints: &[Joint], n_bodies: usize, size: f64) -> Vec<Vec<f64>> {
    let origin = joints.first().map_or([0.0; 2], |joint| joint.at);
    let mut rows = Vec::new();
    // The velocity of a body's point along a direction.
    let put = |row: &mut Vec<f64>, on: On, at: Point, along: Point, sign: f64| {
        if let On::Body(body) = on {
            let arm = turned(sub(at, origin));
            row[3 * body] += sign * along[0];
            row[3 * body + 1] += sign * along[1];
            row[3 * body + 2] += sign * (arm[0] * along[0] + arm[1] * along[1]) / size;
        }
    };
    for joint in joints {
        let at = joint.at;
        let mut relative = |first: On, second: On, along: Point| {
            let mut row = vec![0.0; 3 * n_bodies];
            put(&mut row, first, at, along, -1.0);
            put(&mut row, second, at, along, 1.0);
            rows.push(row);
        };
        match &joint.kind {
            Kind::Pin => {
                for other in &joint.on[1..] {
                    relative(joint.on[0], *other, [1.0, 0.0]);
                    relative(joint.on[0], *other, [0.0, 1.0]);
                }
            }
            Kind::Slot { axis } => relative(joint.on[0], joint.on[1], turned(*axis)),
            Kind::Slide { axis } => {
                relative(joint.on[0], joint.on[1], turned(*axis));
                let mut row = vec![0.0; 3 * n_bodies];
                for (on, sign) in [(joint.on[0], -1.0), (joint.on[1], 1.0)] {
                    if let On::Body(body) = on {
                        row[3 * body + 2] = sign;
                    }
                }
                rows.push(row);
            }
            Kind::Gear { .. } => {
                // Pitch circles roll: across the line of centres, which the point of contact is on.
                let centre = joint_centre(joints, joint);
                relative(joint.on[0], joint.on[1], turned(super::pieces::unit(sub(at, centre))));
            }
            Kind::Rack { axis, .. } => relative(joint.on[0], joint.on[1], *axis),
            Kind::Cam { normal, .. } => relative(joint.on[0], joint.on[1], *normal),
        }
    }
    for row in &mut rows {
        let norm = row.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm > 0.0 {
            for x in row {
                *x /= norm;
            }
        }
    }
    rows
}

/// Where the first wheel of a gear has its pin: of its pins, that at the distance of its radius.
pub(super) fn joint_centre(joints: &[Joint], gear: &Joint) -> Point {
    let Kind::Gear { radii, .. } = gear.kind else { return gear.at };
    let away = |joint: &&Joint| {
        (bksim_cad::geometry::vector::distance(joint.at, gear.at) - radii[0]).abs()
    };
    let pins =
        joints.iter().filter(|joint| joint.kind == Kind::Pin && joint.on.contains(&gear.on[0]));
    pins.min_by(|a, b| away(a).total_cmp(&away(b))).map_or(gear.at, |joint| joint.at)
}
