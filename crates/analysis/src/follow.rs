//! [`follow`]: a curve through the values of its last unknown, past dead points if that is wanted.

use nalgebra::DVector;

use crate::curve::{Curve, Equations, Point};

/// A stretch of a curve between two points, its length, and how far of it is gone.
pub(crate) type Stretch<'f, E> = &'f mut dyn FnMut(&mut Curve<E>, (&Point, &Point), [f64; 2]);
/// A position at a target, and the direction in which it is reached.
pub(crate) type Target<'f, E> =
    &'f mut dyn FnMut(&mut Curve<E>, (&DVector<f64>, &DVector<f64>), f64);

/// Follows a curve from `z`, whose last unknown, the parameter, is zero there, through all `targets`, ascending; with `through`
/// also past dead points, until the parameter is back at an end of the range or the curve closes. Gives
/// the value of the parameter where it could go no further before the last target.
pub(crate) fn follow<E: Equations>(
    curve: &mut Curve<E>,
    z: DVector<f64>,
    targets: &[f64],
    through: bool,
    stretch: Stretch<'_, E>,
    target: Target<'_, E>,
) -> Option<f64> {
    const MOST_STEPS: usize = 100_000;
    let n = z.len() - 1;
    let parameter = DVector::from_fn(n + 1, |i, _| f64::from(u8::from(i == n)));
    let last = targets.last().copied().unwrap_or(0.0);
    let Some(mut from) = curve.first_point(z) else {
        return Some(0.0);
    };
    let first = from.clone();
    // The index of the target ahead, and whether the parameter grows.
    let (mut ahead, mut grows) = (0, true);
    let mut stopped = None;
    let reached = |s: f64, value: f64, grows: bool| if grows { s >= value } else { s <= value };
    if targets.first() == Some(&0.0) {
        let mut z = from.z.clone();
        if curve.equations.first_direction().is_none() {
            curve.correct(&mut z, &parameter);
        }
        target(curve, (&z, &from.tangent), 0.0);
        ahead = 1;
    }
    let mut ds = 0.02;
    for _ in 0..MOST_STEPS {
        if ahead >= targets.len() {
            return stopped;
        }
        let Some((mut to, whole)) = curve.step(&from, &mut ds) else {
            return Some(stopped.unwrap_or(from.z[n]));
        };
        // A dead point ends the step.
        let mut length = whole;
        let beyond = to.clone();
        let turns_back = (to.tangent[n] > 0.0) != grows;
        if turns_back {
            let signs = (from.tangent[n], to.tangent[n]);
            if let Some(dead) = curve.root(&from, length, signs, &mut |_, p| p.tangent[n]) {
                length = from.tangent.dot(&(&dead.z - &from.z));
                to = dead;
            }
        }
        // Targets that were passed.
        let mut next = Some(ahead);
        while let Some(k) =
            next.filter(|&k| k < targets.len() && reached(to.z[n], targets[k], grows))
        {
            let value = targets[k];
            let z = at_parameter(curve, (&from, &to), length, value, &parameter);
            target(curve, (&z, &from.tangent), value);
            next = if grows { Some(k + 1) } else { k.checked_sub(1) };
        }
        stretch(curve, (&from, &beyond), [whole, length]);
        if through && !grows && next.is_none() {
            return stopped;
        }
        ahead = next.unwrap_or(0);
        if turns_back {
            if !(through && to.z[n] <= last) {
                return Some(stopped.unwrap_or(to.z[n]));
            }
            stopped = stopped.or(Some(to.z[n]));
            grows = !grows;
            // The same values once more, the other way.
            ahead =
                if grows { ahead + usize::from(next.is_some()) } else { ahead.saturating_sub(1) };
            if grows {
                ahead = targets.iter().position(|&s| s > to.z[n]).unwrap_or(targets.len());
            }
            if let Some(next) = curve.along(&to, ds.min(1e-3)) {
                to = next;
            }
        }
        from = to;
        if through && (&from.z - &first.z).norm() < 1e-9 {
            return stopped;
        }
    }
    stopped
}

/// The position at a value of the parameter within a step.
fn at_parameter<E: Equations>(
    curve: &mut Curve<E>,
    (from, to): (&Point, &Point),
    length: f64,
    value: f64,
    parameter: &DVector<f64>,
) -> DVector<f64> {
    let n = from.z.len() - 1;
    // Where a cubic through both ends has this value, in the unknown `i`.
    let cubic = |c: f64, i: usize| {
        let (c2, c3) = (c * c, c * c * c);
        from.z[i] * (2.0 * c3 - 3.0 * c2 + 1.0)
            + from.tangent[i] * (length * (c3 - 2.0 * c2 + c))
            + to.z[i] * (3.0 * c2 - 2.0 * c3)
            + to.tangent[i] * (length * (c3 - c2))
    };
    let (mut a, mut b) = (0.0, 1.0);
    let rises = to.z[n] >= from.z[n];
    for _ in 0..40 {
        let c = 0.5 * (a + b);
        if (cubic(c, n) < value) == rises { a = c } else { b = c }
    }
    let guess = DVector::from_fn(n + 1, |i, _| cubic(0.5 * (a + b), i));
    let mut z = guess.clone();
    z[n] = value;
    let kept = curve.correct(&mut z, parameter);
    if kept.is_some_and(|first| first < 0.1 * length.max(1e-6)) {
        return z;
    }
    // At a dead point itself the parameter cannot be held.
    let (low, high) = (from.z[n] - value, to.z[n] - value);
    curve.root(from, length, (low, high), &mut |_, p| p.z[n] - value).map_or(guess, |point| point.z)
}
