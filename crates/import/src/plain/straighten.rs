//! Lengths that are meant to be equal: a mechanism that moves only thanks to them must have them exactly.
//!
//! Vectors between pins of one body and those of another that agree within the drawing's error are made equal, the
//! pins moved as little as possible: points are projected onto one condition after the other until all hold.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{along, distance, norm, sub};

use super::Found;
use super::joint::{Kind, On};
use super::mobility::freedoms;

/// Most conditions that are tried.
const MAX_CONDITIONS: usize = 4000;

/// Most sweeps over them.
const SWEEPS: usize = 2000;

pub(super) fn straighten(found: &mut Found) {
    let n = found.bodies.all.len();
    let strict = |found: &Found| freedoms(&found.joints, n, found.size, 1e-7);
    if strict(found) == found.freedoms(&[]) {
        return;
    }
    let before: Vec<Point> = found.joints.iter().map(|joint| joint.at).collect();
    let after = equalised(found, &before);
    for (joint, at) in found.joints.iter_mut().zip(&after) {
        joint.at = *at;
    }
    let is_kept = strict(found) == found.freedoms(&[]);
    for ((joint, old), new) in found.joints.iter_mut().zip(&before).zip(&after) {
        if !is_kept {
            joint.at = *old;
            continue;
        }
        for pin in found.pins.iter_mut().filter(|pin| pin.at == *old) {
            pin.at = *new;
        }
    }
}

/// The points after all conditions that hold nearly are made to hold.
fn equalised(found: &Found, before: &[Point]) -> Vec<Point> {
    let mut spans: Vec<(On, usize, usize)> = Vec::new();
    let bodies = (0..found.bodies.all.len()).map(On::Body).chain([On::Ground]);
    for on in bodies {
        let own = |idx: &usize| {
            found.joints[*idx].kind == Kind::Pin && found.joints[*idx].on.contains(&on)
        };
        let pins: Vec<usize> = (0..found.joints.len()).filter(own).collect();
        for (k, &p) in pins.iter().enumerate() {
            spans.extend(pins[k + 1..].iter().map(|&q| (on, p, q)));
        }
    }
    let near = 4.0 * found.pieces.miss;
    let mut conditions: Vec<[usize; 4]> = Vec::new();
    for (k, &(first, p, q)) in spans.iter().enumerate() {
        for &(second, r, s) in &spans[k + 1..] {
            let v = sub(before[q], before[p]);
            if first == second || norm(v) < 2.0 * near || conditions.len() > MAX_CONDITIONS {
                continue;
            }
            for (r, s) in [(r, s), (s, r)] {
                if distance(v, sub(before[s], before[r])) < near {
                    conditions.push([p, q, r, s]);
                }
            }
        }
    }
    let mut at = before.to_vec();
    for _ in 0..SWEEPS {
        let mut largest = 0.0_f64;
        for &[p, q, r, s] in &conditions {
            let off = sub(sub(at[q], at[p]), sub(at[s], at[r]));
            largest = largest.max(norm(off));
            // Shares of the four points; one that stands on both sides takes its part of each.
            for (idx, share) in [(q, -0.25), (p, 0.25), (s, 0.25), (r, -0.25)] {
                at[idx] = along(at[idx], share, off);
            }
        }
        if largest < 1e-13 * found.size {
            break;
        }
    }
    at
}
