//! Positions on the constraints with what is stated: the direct way, and the search where that does
//! not close, or moves guesses.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::equations::Numbers;
use super::parts::Part;
use super::scale::{whole_turns, wrapped};
use super::search::{Candidate, GUESS_HOLDS, Ground, HOLDS, search};
use super::turns::{AngleRow, turn, turns};
use super::{CLOSURE_TOLERANCE, Closing, Closure, size};
use crate::evaluator::Evaluator;
use crate::linear::rows::{length, shortest_solution};
use crate::multiplier::largest;
use crate::start_error::{Conflict, Gap, Rival, StartError};
use bksim_model::JointId;

/// Part by which another assembly must be nearer to the guesses than the one that the direct way
/// leads to.
const NEARER: f64 = 1e-3;
/// Assemblies differ by more than this in a coordinate, in radians and longest links.
const APART: f64 = 1e-3;
/// Ratio of distances from the guesses up to which another assembly might be the one that was meant.
const NEARLY_AS_NEAR: f64 = 1.5;

impl Closing<'_> {
    /// Positions on the constraints with what is stated: with straight beams where that closes.
    pub(crate) fn close_positions(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
    ) -> Result<(Vec<f64>, Vec<Rival>), StartError> {
        if !self.of.shapes[0].is_empty() {
            self.is_unbent = true;
            let found = self.close(evaluator, t);
            self.is_unbent = false;
            if found.is_ok() {
                return found;
            }
        }
        self.close(evaluator, t)
    }

    fn close(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
    ) -> Result<(Vec<f64>, Vec<Rival>), StartError> {
        let all = self.select(|i| !i.measure.is_velocity());
        let stated = self.select(|i| !i.measure.is_velocity() && !i.is_guess);
        let guesses = self.select(|i| !i.measure.is_velocity() && i.is_guess);

        // From the shape that the tree gives, towards everything the author said about positions,
        // then onto the constraints, holding what was stated.
        let mut q = self.first_guess(t);
        self.descend(evaluator, &all, false, t, &mut q);
        let guess = q.clone();
        let left = self.descend(evaluator, &stated, true, t, &mut q);
        if q.iter().any(|value| !value.is_finite()) || !left.is_finite() {
            return Err(StartError::NotFinite { q, v: Vec::new() });
        }
        let is_closed = left <= CLOSURE_TOLERANCE * size(&q) && self.is_aligned(t, &q);
        // Guesses are wishes: without them, if they lead nowhere.
        let wishes: &[&[usize]] = if guesses.is_empty() { &[&[]] } else { &[&guesses, &[]] };
        let found = wishes
            .iter()
            .find_map(|wishes| self.nearest(evaluator, t, (&stated, wishes), &q, is_closed));
        if let Some((mut q, rivals)) = found {
            drop_rounding(&mut q);
            self.hold(&stated, &mut q);
            return Ok((q, rivals));
        }
        Err(self.what_stays_open(evaluator, t, &stated, &guess))
    }

    /// The cause that keeps the mechanism open: the stated values, the drives, or the joints themselves.
    fn what_stays_open(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        stated: &[usize],
        guess: &[f64],
    ) -> StartError {
        let mut free = guess.to_vec();
        let open = self.descend(evaluator, &[], true, t, &mut free);
        let is_closed = open <= CLOSURE_TOLERANCE * size(&free) && self.is_aligned(t, &free);
        let can_close = is_closed || self.nearest(evaluator, t, (&[], &[]), &free, false).is_some();
        if !can_close {
            return match self.reach_of_drives(evaluator, t) {
                Some(drives) => StartError::DrivesOutOfReach { drives },
                None => self.cannot_close(evaluator, t, free),
            };
        }
        let conflicts = stated
            .iter()
            .map(|&k| {
                let others: Vec<usize> = stated.iter().copied().filter(|&o| o != k).collect();
                let mut q = guess.to_vec();
                let open = self.descend(evaluator, &others, true, t, &mut q);
                let is_closed = open <= CLOSURE_TOLERANCE * size(&q) && self.is_aligned(t, &q);
                let nearest = self.nearest(evaluator, t, (&others, &[k]), &q, is_closed);
                let found = |(q, _): (Vec<f64>, _)| {
                    let zero = vec![0.0; q.len()];
                    self.rows(&[k], t, &q, &zero).values[0] + self.stated[k]
                };
                let consistent = nearest.map(found).map(|value| self.by_written_turn(k, value));
                let written = self.written[k];
                let differs = |value: &f64| (value - written).abs() > GUESS_HOLDS;
                Conflict { initial_idx: k, stated: written, consistent: consistent.filter(differs) }
            })
            .collect();
        StartError::StatedPositions { conflicts }
    }

    /// A value of a measure by the turn that its initial value was written with.
    fn by_written_turn(&self, k: usize, value: f64) -> f64 {
        let off = value - self.written[k];
        if self.of.units.is_initial_angle[k] { self.written[k] + wrapped(off) } else { value }
    }

    /// True if the axes of cut joints point the same way, and not opposite ways.
    fn is_aligned(&mut self, t: f64, q: &[f64]) -> bool {
        self.of.joint_of_sense.is_empty()
            || self.sense_rows(t, q).values.iter().all(|missing| *missing < 1.0)
    }

    /// True where axes of a cut joint point opposite ways whatever the coordinates are: no part of the mechanism to be
    /// searched has them.
    fn is_opposite_by_form(&mut self, t: f64, q: &[f64]) -> bool {
        let senses = self.sense_rows(t, q);
        let rows = senses.values.iter().enumerate();
        rows.into_iter()
            .any(|(row, missing)| *missing >= 1.0 && senses.gradients.row(row).is_empty())
    }

    /// The assembly nearest to the guesses with what is stated: `direct` where its guesses hold or
    /// none is nearer.
    fn nearest(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (stated, guesses): (&[usize], &[usize]),
        direct: &[f64],
        is_closed: bool,
    ) -> Option<(Vec<f64>, Vec<Rival>)> {
        if !is_closed && self.is_opposite_by_form(t, direct) {
            return None;
        }
        let reference = self.reference(evaluator, stated, t);
        let ground = Ground::new(self, evaluator, t, (stated, guesses), &[], &reference);
        let at = ground.at(self, evaluator, direct);
        let is_open = |&i: &usize| {
            let part = &ground.parts[i];
            !(is_closed || ground.open(part, &at) <= HOLDS)
                || ground.distance(part, &at) > GUESS_HOLDS
        };
        let which: Vec<usize> = (0..ground.parts.len()).filter(is_open).collect();
        let known = |&i: &usize| -> Vec<Candidate> {
            let found = is_closed.then(|| ground.taken(&ground.parts[i], &at, direct));
            found.into_iter().collect()
        };
        let known: Vec<Vec<Candidate>> = which.iter().map(known).collect();
        let found = search(self, evaluator, &ground, &which, &reference, known.clone());

        // The best of each part; the direct way's own unless another is nearer.
        let mut q = if is_closed { direct.to_vec() } else { reference.clone() };
        if !is_closed {
            for i in (0..ground.parts.len()).filter(|i| !which.contains(i)) {
                ground.parts[i].columns.iter().for_each(|&column| q[column] = direct[column]);
            }
        }
        let mut is_new = !is_closed;
        for ((&i, known), found) in which.iter().zip(&known).zip(&found) {
            let best = found.candidates.first()?;
            let is_nearer =
                known.first().is_none_or(|known| best.distance < (1.0 - NEARER) * known.distance);
            if is_nearer {
                is_new = true;
                let part = &ground.parts[i];
                part.columns.iter().zip(&best.q).for_each(|(&column, value)| q[column] = *value);
            }
        }
        if is_new {
            for (column, is_turn) in self.of.units.is_turn.iter().enumerate() {
                if *is_turn && !ground.is_fixed[column] {
                    q[column] -= TAU * whole_turns(q[column] - reference[column]);
                }
            }
        }
        let has_turned = self.set_turns(evaluator, &ground, &mut q);
        if is_new || has_turned {
            q = self.polish(evaluator, &ground, q)?;
        }
        let rivals = which.iter().zip(&found).filter_map(|(&i, found)| {
            self.rival(evaluator, &ground, &ground.parts[i], &found.candidates, &q)
        });
        let mut rivals: Vec<Rival> = rivals.collect();
        let images = self.mirror_images(evaluator, &ground, (&reference, &q));
        rivals.extend(images);
        Some((q, rivals))
    }

    /// The assembly of a part that is nearly as near to the guesses as the one in `q`.
    fn rival(
        &mut self,
        evaluator: &mut Evaluator,
        ground: &Ground<'_>,
        part: &Part,
        candidates: &[Candidate],
        q: &[f64],
    ) -> Option<Rival> {
        let here = ground.at(self, evaluator, q);
        let distance = ground.distance(part, &here);
        let own = ground.taken(part, &here, q);
        let is_other = |other: &&Candidate| {
            !ground.is_same(part, other, &own) && !ground.is_near(part, other, &own)
        };
        let other = candidates.iter().find(is_other)?;
        let ratio = other.distance / distance;
        if distance <= GUESS_HOLDS || ratio > NEARLY_AS_NEAR {
            return None;
        }

        // The guess that differs most.
        let mut there = q.to_vec();
        part.columns.iter().zip(&other.q).for_each(|(&column, value)| there[column] = *value);
        let there = ground.at(self, evaluator, &there);
        let first_guess = here.values.len() - ground.guesses.len();
        let apart = |row: usize| (here.values[row] - there.values[row]).abs();
        let guesses = part.wishes.iter().copied().filter(|&row| row >= first_guess);
        let row = guesses.max_by(|&a, &b| apart(a).total_cmp(&apart(b)))?;
        // What the guesses do not tell apart is as much at one place of a free motion as at another.
        if apart(row) <= GUESS_HOLDS {
            return None;
        }
        let initial_idx = ground.guesses[row - first_guess];
        let found = self.stated[initial_idx] + there.values[row];
        Some(Rival::Guessed { initial_idx, found, ratio })
    }

    /// The assemblies of parts without guesses that mirror those in `q` at the first shape.
    fn mirror_images(
        &mut self,
        evaluator: &mut Evaluator,
        ground: &Ground<'_>,
        (reference, q): (&[f64], &[f64]),
    ) -> Vec<Rival> {
        // Parts share no rows: all are mirrored at once.
        let is_unguessed = |part: &&Part| part.wishes.is_empty() && !part.rows.is_empty();
        let parts = || ground.parts.iter().filter(is_unguessed);
        let mut image = q.to_vec();
        for &column in parts().flat_map(|part| &part.columns) {
            image[column] = 2.0 * reference[column] - q[column];
        }
        let at = ground.at(self, evaluator, &image);
        let longest = self.longest_link();
        // A whole turn away is the same shape.
        let apart = |column: usize| {
            let by = image[column] - q[column];
            if self.of.units.is_turn[column] { wrapped(by).abs() } else { (by / longest).abs() }
        };
        let rival = |part: &Part| {
            let columns = part.columns.iter().copied();
            let column = columns.max_by(|&a, &b| apart(a).total_cmp(&apart(b)))?;
            let is_another = ground.open(part, &at) <= HOLDS && apart(column) > APART;
            is_another.then(|| Rival::Unguessed { column, found: image[column] })
        };
        parts().filter_map(rival).collect()
    }

    /// The positions of the drives nearest to those at the start where the mechanism closes without
    /// them, if it does.
    fn reach_of_drives(&mut self, evaluator: &mut Evaluator, t: f64) -> Option<Vec<(usize, f64)>> {
        let released: Vec<usize> = self.of.drives.iter().map(|&(row, _)| row).collect();
        if released.is_empty() {
            return None;
        }
        let reference = self.reference(evaluator, &[], t);
        let ground = Ground::new(self, evaluator, t, (&[], &[]), &released, &reference);
        let which: Vec<usize> = (0..ground.parts.len()).collect();
        let none = vec![Vec::new(); which.len()];
        let found = search(self, evaluator, &ground, &which, &reference, none);
        let mut q = reference;
        for (part, found) in ground.parts.iter().zip(&found) {
            let best = found.candidates.first()?;
            part.columns.iter().zip(&best.q).for_each(|(&column, value)| q[column] = *value);
        }
        let at = ground.at(self, evaluator, &q);
        // A row is where the drive puts its joint less where the joint is.
        Some(self.of.drives.iter().map(|&(row, drive)| (drive, -at.values[row])).collect())
    }

    /// The first guess with what is stated of coordinates themselves.
    fn reference(&mut self, evaluator: &mut Evaluator, stated: &[usize], t: f64) -> Vec<f64> {
        let mut q = self.first_guess(t);
        self.hold(stated, &mut q);
        let at = evaluator.constraints(t, &q);
        let (values, rows) = (at.value.to_vec(), at.jacobian_rows());
        for &(row, column) in &self.of.driven {
            if let Some(&(_, slope)) = rows.row(row).iter().find(|(i, _)| *i == column) {
                q[column] -= values[row] / slope;
            }
        }
        q
    }

    /// Gives every angle the turn that the author wrote, as far as one position can; the others are
    /// held where they are from now on. Whether anything was turned.
    fn set_turns(&mut self, evaluator: &mut Evaluator, ground: &Ground<'_>, q: &mut [f64]) -> bool {
        let which = [ground.stated, ground.guesses].concat();
        let at = self.position_rows(evaluator, &which, true, ground.t, q);
        let units = &self.of.units;
        let n_constraints = units.is_row_angle.len();
        let is_angle = |row: usize| match row.checked_sub(n_constraints) {
            None => units.is_row_angle[row],
            Some(k) => units.is_initial_angle[which[k]],
        };
        // Sums of angles; what a fixed coordinate adds cannot be turned.
        let mut rows = Vec::new();
        let mut initial_of_row = Vec::new();
        for row in (0..at.values.len()).filter(|&row| is_angle(row)) {
            let entries = at.gradients.row(row).iter();
            let slopes: Vec<(usize, f64)> =
                entries.copied().filter(|(i, g)| !ground.is_fixed[*i] && *g != 0.0).collect();
            let is_sum = |(i, g): &(usize, f64)| units.is_turn[*i] && (g.abs() - 1.0).abs() < 1e-9;
            let is_guess = row >= n_constraints + ground.stated.len();
            if slopes.iter().all(is_sum) && !(is_guess && wrapped(at.values[row]).abs() > 1.0) {
                rows.push(AngleRow { slopes, value: at.values[row] });
                initial_of_row.push(row.checked_sub(n_constraints).map(|k| which[k]));
            }
        }
        let (found, kept) = turns(&rows, q.len());
        turn(q, &found);
        for (row, n_turns) in kept {
            if let Some(k) = initial_of_row[row] {
                self.stated[k] += TAU * n_turns;
            }
        }
        found.iter().any(|n| *n != 0.0)
    }

    /// Closes a position that is all but closed; guesses that hold go on doing so.
    fn polish(
        &mut self,
        evaluator: &mut Evaluator,
        ground: &Ground<'_>,
        mut q: Vec<f64>,
    ) -> Option<Vec<f64>> {
        let zero = vec![0.0; q.len()];
        let off = self.rows(ground.guesses, ground.t, &q, &zero).values;
        let held =
            ground.guesses.iter().zip(off).filter(|(_, off)| off.abs() <= 10.0 * GUESS_HOLDS);
        let held: Vec<usize> = ground.stated.iter().copied().chain(held.map(|(&k, _)| k)).collect();
        let mut with_guesses = q.clone();
        let open = self.descend(evaluator, &held, true, ground.t, &mut with_guesses);
        if open <= CLOSURE_TOLERANCE * size(&with_guesses) {
            q = with_guesses;
        } else {
            let open = self.descend(evaluator, ground.stated, true, ground.t, &mut q);
            if open.is_nan() || open > CLOSURE_TOLERANCE * size(&q) {
                return None;
            }
        }
        Some(q)
    }

    /// Gives coordinates that are stated what is stated, to the last digit.
    fn hold(&self, stated: &[usize], q: &mut [f64]) {
        for &k in stated {
            if let Some(column) = self.of.own[k] {
                q[column] = self.stated[k];
            }
        }
    }

    /// Positions of a tree without cuts at the joint values the author gave, read off in the
    /// coordinates of the system's own tree.
    fn first_guess(&self, t: f64) -> Vec<f64> {
        let Closure { guess, given, .. } = self.of;
        let values = given.iter().map(|given| given.map_or(0.0, |k| self.stated[k]));
        let inputs: Vec<f64> = std::iter::once(t).chain(values).collect();
        let mut q = vec![0.0; guess.n_outputs()];
        guess.evaluate(&mut guess.workspace(self.parameters), &inputs, &mut q);
        q
    }

    /// Damped Gauss–Newton on the chosen measures and, if asked, the constraints; returns what is
    /// left of the largest row.
    fn descend(
        &mut self,
        evaluator: &mut Evaluator,
        which: &[usize],
        with_constraints: bool,
        t: f64,
        q: &mut Vec<f64>,
    ) -> f64 {
        const MAX_STEPS: usize = 200;
        let mut rows = self.position_rows(evaluator, which, with_constraints, t, q);
        let (mut trial, mut next) = (q.clone(), Numbers::default());
        for _ in 0..MAX_STEPS {
            let norm = length(&rows.values);
            if !(norm > 0.0 && norm.is_finite()) {
                break;
            }
            if self.is_unbent {
                rows.gradients.clear_columns(&self.of.shapes[0]);
            }
            let step = shortest_solution(&rows.gradients, &rows.values);
            let mut damping = 1.0;
            let improved = loop {
                let all = trial.iter_mut().zip(&*q).zip(&step);
                all.for_each(|((trial, q), s)| *trial = q - damping * s);
                // Shorter steps would lead nowhere, too.
                if trial == *q {
                    break false;
                }
                let what = (which, with_constraints);
                self.write_position_numbers(evaluator, what, (t, &trial), &mut next);
                let reached = length(&next.values);
                if reached < norm * (1.0 - 1e-4 * damping) {
                    std::mem::swap(q, &mut trial);
                    std::mem::swap(&mut rows.values, &mut next.values);
                    rows.gradients.set_values(&next.slopes);
                    break true;
                }
                damping *= 0.5;
                if damping < 1e-6 {
                    break false;
                }
            };
            if !improved {
                break;
            }
        }
        largest(&rows.values)
    }

    fn cannot_close(&mut self, evaluator: &mut Evaluator, t: f64, q: Vec<f64>) -> StartError {
        let open = evaluator.constraints(t, &q).value;
        // The rows of each joint, distances and angles apart; one row alone keeps its sign.
        let mut rows_of: BTreeMap<JointId, [Vec<f64>; 2]> = BTreeMap::new();
        let rows = self.of.gap_of_joint.iter().zip(&self.of.units.is_row_angle);
        for ((joint, &is_angle), &value) in rows.zip(open) {
            let Some(joint) = *joint else { continue };
            rows_of.entry(joint).or_default()[usize::from(is_angle)].push(value);
        }
        let gap = |(joint, [distances, sines]): (JointId, [Vec<f64>; 2])| {
            let distance = match distances.as_slice() {
                [only] => *only,
                all => length(all),
            };
            Gap { joint, distance, angle: length(&sines).min(1.0).asin() }
        };
        let open = |gap: &Gap| gap.distance.abs().max(gap.angle);
        let mut gaps: Vec<Gap> = rows_of.into_iter().map(gap).collect();
        // The sines of half a turn are zero.
        let missing = self.sense_rows(t, &q).values;
        for (joint, missing) in self.of.joint_of_sense.iter().zip(missing) {
            if missing < 1.0 {
                continue;
            }
            let angle = (1.0 - missing).clamp(-1.0, 1.0).acos();
            match gaps.iter_mut().find(|gap| gap.joint == *joint) {
                Some(gap) => gap.angle = angle,
                // All its rows hold by form.
                None => gaps.push(Gap { joint: *joint, distance: 0.0, angle }),
            }
        }
        gaps.retain(|gap| open(gap) > CLOSURE_TOLERANCE * size(&q));
        gaps.sort_by(|a, b| open(b).total_cmp(&open(a)));
        StartError::CannotClose { gaps, q }
    }
}

/// Replaces what rounding has left of a zero by zero, so that a crank held at 0 starts at 0.
fn drop_rounding(q: &mut [f64]) {
    let rounding = 0.1 * f64::EPSILON * size(q);
    q.iter_mut().filter(|value| value.abs() < rounding).for_each(|value| *value = 0.0);
}
