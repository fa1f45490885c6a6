//! Search for the assembly nearest to the guesses, from many shapes.
//!
//! Each part of the mechanism, see [`super::parts`], is led from shape after shape first to where
//! its rows and its guesses hold, then, where they do not all, down to the rows alone, with the
//! guesses weighing ever less. All parts go at once, so that a row of many mechanisms takes as many
//! evaluations as one.

use super::Closing;
use super::equations::{Equations, Numbers};
use super::parts::{Part, parts};
use super::scale::wrapped;
use super::sequence::Sequence;
use super::walk::Walk;
use super::ways::{End, Goal, Outcome, Ways};
use super::weighted::Weighted;
use crate::evaluator::Evaluator;
use crate::linear::rows::SparseRows;

/// Rows hold below this, in units of the mechanism and radians.
pub(super) const HOLDS: f64 = 1e-9;
/// Guesses hold below this.
pub(super) const GUESS_HOLDS: f64 = 1e-7;
/// Coordinates of one assembly agree to this.
const SAME: f64 = 1e-4;
/// Shapes that a part is led from at most, and multiplications that it may take.
const MAX_SHAPES: usize = 96;
const MAX_WORK: usize = 1_000_000_000;

/// Assembly of a part.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    /// Coordinates of the candidate, in the order of the part.
    pub(super) q: Vec<f64>,
    /// How far the guesses are, in units of the mechanism and radians.
    pub(super) distance: f64,
    /// How many shapes have led here.
    n_met: usize,
}

/// All of a search that does not change.
pub(super) struct Ground<'a> {
    pub(super) t: f64,
    /// Initial values that hold, and those that are guesses.
    pub(super) stated: &'a [usize],
    pub(super) guesses: &'a [usize],
    /// Coordinates that are stated themselves: they stay.
    pub(super) is_fixed: Vec<bool>,
    weight_of_row: Vec<f64>,
    is_angle: Vec<bool>,
    is_turn: Vec<bool>,
    /// First coordinates of quaternions, and a position that each is on the side of.
    quaternions: Vec<usize>,
    reference: Vec<f64>,
    /// Coordinates that are guessed themselves: every shape has them as guessed.
    is_guessed: Vec<bool>,
    unit_of_column: Vec<f64>,
    pub(super) parts: Vec<Part>,
    /// Which slopes the rows have, fixed coordinates included.
    gradients: SparseRows,
    /// Initial values that hold, then those that are guesses.
    which: Vec<usize>,
}

/// Result for one part.
#[derive(Debug)]
pub(super) struct Found {
    /// Assemblies, the nearest to the guesses first.
    pub(super) candidates: Vec<Candidate>,
    ways: Ways,
}

/// A part on its way from a shape.
struct Going<'a> {
    part: &'a Part,
    /// Place in what is found.
    i: usize,
    /// True if rows hold the part, and its guesses: it stays where it is.
    is_held: bool,
    /// Where it has come to so far.
    ends: Vec<End>,
    /// Once it comes where another way has been.
    outcome: Option<Outcome>,
}

impl<'a> Ground<'a> {
    /// `q` is any position, with the values of fixed coordinates; of the constraint rows, those
    /// `released` are guesses.
    pub(super) fn new(
        closing: &mut Closing<'_>,
        evaluator: &mut Evaluator<'_>,
        t: f64,
        (stated, guesses): (&'a [usize], &'a [usize]),
        released: &[usize],
        q: &[f64],
    ) -> Self {
        let units = &closing.of.units;
        let size = units.longest_link(closing.parameters);
        let (n_senses, initial) = (closing.of.joint_of_sense.len(), stated.iter().chain(guesses));
        let all = |rows: &[bool], of_sense: bool, initials: &[bool]| -> Vec<bool> {
            let senses = std::iter::repeat_n(of_sense, n_senses);
            let initials = initial.clone().map(|&k| initials[k]);
            rows.iter().copied().chain(senses).chain(initials).collect()
        };
        let is_angle = all(&units.is_row_angle, true, &units.is_initial_angle);
        let is_length = all(&units.is_row_length, false, &units.is_initial_length);
        let weight = |&is_length: &bool| if is_length { 1.0 / size } else { 1.0 };
        let unit = |&is_length: &bool| if is_length { size } else { 1.0 };
        let mut ground = Self {
            t,
            stated,
            guesses,
            is_fixed: closing.fixed(stated, released),
            is_guessed: closing.own_coordinates(guesses),
            is_turn: units.is_turn.clone(),
            quaternions: units.quaternions.clone(),
            reference: q.to_vec(),
            weight_of_row: is_length.iter().map(weight).collect(),
            unit_of_column: units.is_length.iter().map(unit).collect(),
            is_angle,
            parts: Vec::new(),
            gradients: SparseRows::new(q.len()),
            which: [stated, guesses].concat(),
        };
        ground.gradients = ground.slopes(closing, evaluator, q);
        let first_guess = ground.is_angle.len() - guesses.len();
        let rows = 0..ground.is_angle.len();
        let is_wish: Vec<bool> =
            rows.map(|row| row >= first_guess || released.contains(&row)).collect();
        ground.parts = parts(&ground.gradients, &ground.is_fixed, &is_wish);
        ground
    }

    /// The slopes of the rows of [`Self::at`], with their columns.
    fn slopes(
        &self,
        closing: &mut Closing<'_>,
        evaluator: &mut Evaluator<'_>,
        q: &[f64],
    ) -> SparseRows {
        let mut rows = Equations::new(q.len());
        evaluator.constraints(self.t, q).add_to(&mut rows);
        closing.add_sense_rows(self.t, q, &mut rows);
        closing.add_rows(&self.which, (self.t, q, q), &mut rows);
        rows.gradients
    }

    /// The rows of constraints, senses, stated values and guesses; angles modulo 2π.
    pub(super) fn at(
        &self,
        closing: &mut Closing<'_>,
        evaluator: &mut Evaluator<'_>,
        q: &[f64],
    ) -> Numbers {
        let mut at = Numbers::default();
        self.write_at(closing, evaluator, q, &mut at);
        at
    }

    /// Writes [`Self::at`] into the room of other numbers.
    fn write_at(
        &self,
        closing: &mut Closing<'_>,
        evaluator: &mut Evaluator<'_>,
        q: &[f64],
        at: &mut Numbers,
    ) {
        at.clear();
        evaluator.constraints(self.t, q).add_numbers_to(at);
        closing.add_sense_numbers((self.t, q), at);
        closing.add_numbers(&self.which, (self.t, q), at);
        for (value, is_angle) in at.values.iter_mut().zip(&self.is_angle) {
            if *is_angle {
                *value = wrapped(*value);
            }
        }
    }

    /// Room for the walks of a part.
    fn walk_of(&self, part: &Part) -> Walk {
        let units = (self.weight_of_row.as_slice(), self.unit_of_column.as_slice());
        Walk::new(Weighted::of(part, &self.gradients, units), part.columns.len())
    }

    /// Largest row of a part that must hold, in its unit.
    pub(super) fn open(&self, part: &Part, at: &Numbers) -> f64 {
        let size = |&row: &usize| (self.weight_of_row[row] * at.values[row]).abs();
        // A value that is not finite holds nothing.
        part.rows.iter().map(size).fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) })
    }

    /// How far the guesses of a part are.
    pub(super) fn distance(&self, part: &Part, at: &Numbers) -> f64 {
        let square = |&row: &usize| (self.weight_of_row[row] * at.values[row]).powi(2);
        part.wishes.iter().map(square).sum::<f64>().sqrt()
    }

    /// The assembly of `part` in the position `q`, if its rows hold there.
    fn candidate(&self, part: &Part, at: &Numbers, q: &[f64]) -> Option<Candidate> {
        (self.open(part, at) <= HOLDS).then(|| self.taken(part, at, q))
    }

    /// The part as it is in the position `q`.
    pub(super) fn taken(&self, part: &Part, at: &Numbers, q: &[f64]) -> Candidate {
        let distance = self.distance(part, at);
        let mut q = q.to_vec();
        self.take_sides(&mut q);
        let q = part.columns.iter().map(|&column| q[column]).collect();
        Candidate { q, distance, n_met: 1 }
    }

    /// Of the two quaternions of each rotation, takes that on the side of the reference.
    fn take_sides(&self, q: &mut [f64]) {
        for &first in &self.quaternions {
            let parts = first..first + 4;
            let cosine: f64 = parts.clone().map(|i| q[i] * self.reference[i]).sum();
            if cosine < 0.0 {
                q[parts].iter_mut().for_each(|part| *part = -*part);
            }
        }
    }

    /// True if two assemblies are one.
    pub(super) fn is_same(&self, part: &Part, a: &Candidate, b: &Candidate) -> bool {
        let mut pairs = part.columns.iter().zip(a.q.iter().zip(&b.q));
        pairs.all(|(&column, (a, b))| self.agrees(column, *a, *b))
    }

    /// True if two assemblies of a part that can move are places of one motion: so near each other that no other
    /// way to close lies between.
    pub(super) fn is_near(&self, part: &Part, a: &Candidate, b: &Candidate) -> bool {
        const NEAR: f64 = 0.02;
        let is_free = part.rows.len() < part.columns.len();
        let mut pairs = part.columns.iter().zip(a.q.iter().zip(&b.q));
        is_free
            && pairs.all(|(&column, (a, b))| {
                let apart = (a - b) / self.unit_of_column[column];
                let turned = if self.is_turn[column] { wrapped(apart) } else { apart };
                turned.abs() <= NEAR
            })
    }

    /// True where a part with the coordinates `known` is as in the position `q`.
    fn is_at(&self, part: &Part, known: &[f64], q: &[f64]) -> bool {
        let mut columns = part.columns.iter().zip(known);
        columns.all(|(&column, known)| self.agrees(column, *known, q[column]))
    }

    fn agrees(&self, column: usize, a: f64, b: f64) -> bool {
        let apart = (a - b) / self.unit_of_column[column];
        // Turns are counted only where there may be some.
        if apart.abs() <= SAME || !self.is_turn[column] {
            return apart.abs() <= SAME;
        }
        wrapped(apart).abs() <= SAME
    }

    /// Shapes that a part of this size is led from.
    fn n_shapes(part: &Part) -> usize {
        const STEPS: usize = 60;
        let n = part.columns.len().max(1);
        (MAX_WORK / (STEPS * n * n * (n + 4))).min(MAX_SHAPES)
    }
}

/// Looks for assemblies of the parts `which`, near `reference` first; `known` are those found before.
pub(super) fn search(
    closing: &mut Closing<'_>,
    evaluator: &mut Evaluator<'_>,
    ground: &Ground<'_>,
    which: &[usize],
    reference: &[f64],
    known: Vec<Vec<Candidate>>,
) -> Vec<Found> {
    let known = known.into_iter().zip(which).map(|(candidates, &part)| {
        let mut ways = Ways::default();
        for (place, candidate) in candidates.iter().enumerate() {
            ways.add(
                vec![End { goal: Goal::Assembly, q: candidate.q.clone() }],
                Outcome(Some(place)),
            );
        }
        (Found { candidates, ways }, Sequence::new(ground.parts[part].columns.len()))
    });
    let (mut found, sequences): (Vec<Found>, Vec<Sequence>) = known.unzip();
    let mut q = reference.to_vec();
    let mut room = Room {
        at: Numbers::default(),
        next: Numbers::default(),
        trial: q.clone(),
        walks: which.iter().map(|_| None).collect(),
    };
    let mut going: Vec<Going> = Vec::with_capacity(which.len());
    for k in 0..MAX_SHAPES {
        // The parts that go on, each in its next shape.
        let all = which.iter().enumerate().map(|(i, &part)| Going {
            part: &ground.parts[part],
            i,
            is_held: false,
            ends: Vec::new(),
            outcome: None,
        });
        going.extend(all.filter(|Going { part, i, .. }| {
            k < Ground::n_shapes(part) && !is_enough(&found[*i], part, k)
        }));
        if going.is_empty() {
            break;
        }
        for Going { part, i, .. } in &going {
            shape(ground, part, (k, &sequences[*i]), reference, &mut q);
        }

        ground.write_at(closing, evaluator, &q, &mut room.at);
        let goals: &[Goal] = if leads_by_guesses(k) { &Goal::BY_GUESSES } else { &Goal::BY_ROWS };
        for &goal in goals {
            for Going { part, is_held, .. } in &mut going {
                *is_held = ground.distance(part, &room.at) <= GUESS_HOLDS
                    && ground.open(part, &room.at) <= HOLDS;
            }
            if going.iter().any(|going| !going.is_held) {
                walk(closing, evaluator, ground, (&found, &mut going), goal, (&mut q, &mut room));
            }
            for going in &mut going {
                found[going.i].note_end(ground, going, goal, (&room.at, &q));
            }
            let is_known = |going: &mut Going| going.outcome.is_some();
            for Going { i, ends, outcome, .. } in going.extract_if(.., is_known) {
                found[i].meet_again(ends, outcome.unwrap_or(Outcome(None)));
            }
        }
        for Going { part, i, ends, .. } in going.drain(..) {
            let place = ground
                .candidate(part, &room.at, &q)
                .map(|candidate| found[i].add(ground, part, candidate));
            found[i].ways.add(ends, Outcome(place));
        }
    }
    for found in &mut found {
        found.candidates.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    }
    found
}

impl Found {
    /// Takes note of where a part has come to, and of where that is known to lead.
    fn note_end(
        &self,
        ground: &Ground<'_>,
        going: &mut Going<'_>,
        goal: Goal,
        (at, q): (&Numbers, &[f64]),
    ) {
        if going.outcome.is_none() {
            let here = ground.taken(going.part, at, q).q;
            let agrees = |(&column, (a, b)): (&usize, (&f64, &f64))| ground.agrees(column, *a, *b);
            let is_here =
                |known: &[f64]| going.part.columns.iter().zip(known.iter().zip(&here)).all(agrees);
            going.outcome = self.ways.from(goal, is_here);
            if going.outcome.is_none() {
                going.ends.push(End { goal, q: here });
            }
        }
    }

    /// Takes note that a way has come where another has been: its assembly is met again.
    fn meet_again(&mut self, ends: Vec<End>, outcome: Outcome) {
        if let Outcome(Some(place)) = outcome {
            self.candidates[place].n_met += 1;
        }
        self.ways.add(ends, outcome);
    }

    /// Keeps a candidate, each once; returns where.
    fn add(&mut self, ground: &Ground<'_>, part: &Part, candidate: Candidate) -> usize {
        let known = self.candidates.iter().position(|c| ground.is_same(part, c, &candidate));
        if let Some(place) = known {
            self.candidates[place].n_met += 1;
            return place;
        }
        self.candidates.push(candidate);
        self.candidates.len() - 1
    }
}

/// True if more shapes would hardly lead to a nearer assembly.
fn is_enough(found: &Found, part: &Part, n_shapes: usize) -> bool {
    const MIN_SHAPES: usize = 12;
    const MIN_MET: usize = 3;
    if found.candidates.is_empty() {
        return false;
    }
    part.wishes.is_empty()
        || found.candidates.iter().any(|c| c.distance <= GUESS_HOLDS)
        || (n_shapes >= MIN_SHAPES + 2 * part.columns.len()
            && found.candidates.iter().all(|c| c.n_met >= MIN_MET))
}

/// True if shape `k` starts with the guesses as guessed.
fn leads_by_guesses(k: usize) -> bool {
    k.is_multiple_of(2)
}

/// Shape `k` of a part: its reference, then shapes all around.
fn shape(
    ground: &Ground<'_>,
    part: &Part,
    (k, sequence): (usize, &Sequence),
    reference: &[f64],
    q: &mut [f64],
) {
    const FULL: f64 = std::f64::consts::TAU;
    for (&column, offset) in part.columns.iter().zip(sequence.point(k)) {
        // A part of a quaternion takes all its values.
        let is_quaternion = ground.quaternions.iter().any(|&i| (i..i + 4).contains(&column));
        let reach = match (ground.is_guessed[column] && leads_by_guesses(k), ground.is_turn[column])
        {
            (true, _) => 0.0,
            (false, true) => FULL,
            (false, false) if is_quaternion => 2.0,
            (false, false) => 3.0 * ground.unit_of_column[column],
        };
        q[column] = reference[column] + reach * offset;
    }
}

/// Room of walks.
struct Room {
    /// The rows where the parts are, and at the end of the step that is tried.
    at: Numbers,
    next: Numbers,
    trial: Vec<f64>,
    /// Of each part that is searched, once it goes.
    walks: Vec<Option<Walk>>,
}

/// Leads the parts down from `q`, but for those that are held, and leaves the rows at its end; parts that come where it is
/// known how they go on are left before it.
fn walk(
    closing: &mut Closing<'_>,
    evaluator: &mut Evaluator<'_>,
    ground: &Ground<'_>,
    (found, going): (&[Found], &mut [Going<'_>]),
    goal: Goal,
    (q, room): (&mut [f64], &mut Room),
) {
    const MAX_STEPS: usize = 60;
    // Longer steps may land anywhere.
    const SHORT: f64 = 0.1;
    let wish_weight = goal.wish_weight();
    let Room { at, next, trial, walks } = room;
    for Going { part, i, .. } in going.iter().filter(|going| !going.is_held) {
        walks[*i].get_or_insert_with(|| ground.walk_of(part)).begin(at, wish_weight);
    }
    let mut is_current = true;
    for _ in 0..MAX_STEPS {
        trial.copy_from_slice(q);
        let mut n_tried = 0;
        for going in going.iter_mut().filter(|going| !going.is_held) {
            let (part, Some(walk)) = (going.part, &mut walks[going.i]) else { continue };
            let Some(step) = walk.next_step() else { continue };
            for (&column, step) in part.columns.iter().zip(step) {
                trial[column] -= ground.unit_of_column[column] * step;
            }
            if step.iter().all(|step| step.abs() <= SHORT) {
                let is_there = |known: &[f64]| ground.is_at(part, known, trial);
                going.outcome = found[going.i].ways.from(goal, is_there);
            }
            if going.outcome.is_some() {
                walk.end();
                part.columns.iter().for_each(|&column| trial[column] = q[column]);
            } else {
                n_tried += 1;
            }
        }
        if n_tried == 0 {
            break;
        }
        ground.write_at(closing, evaluator, trial, next);
        let mut n_taken = 0;
        for going in going.iter().filter(|going| !going.is_held) {
            if walks[going.i].as_mut().is_some_and(|walk| walk.judge(next)) {
                n_taken += 1;
                going.part.columns.iter().for_each(|&column| q[column] = trial[column]);
            }
        }
        // Steps of some parts alone lead where no rows are known.
        if n_taken == n_tried {
            std::mem::swap(at, next);
            is_current = true;
        } else {
            is_current &= n_taken == 0;
        }
    }
    if !is_current {
        ground.write_at(closing, evaluator, q, at);
    }
}
