//! Pulleys and posts that a rope leaves, and comes to again: its way is the shorter one beside them.
//!
//! ```text
//! β = σ (∠(e₋, e₊)₀ + ∠(e₊₀, e₊) − ∠(e₋₀, e₋))       turn of the rope about the post, σ = ±1 its sense
//! w = s₋ + |r| β + s₊ where β ≥ 0, else s               s of the straight span that leaves the post out
//! ```
//!
//! Where β is zero both ways are of one length, and so are their rates, so that nothing is hit as the rope comes to the
//! post. β is counted from a start around the post, so that a string may wind on; from one beside it, where β₀ < 0,
//! β = σ ∠(e₋, e₊).

use bksim_expr::{Expr, Function};

use super::belts::{Strand, Twin, Wheel};
use super::codes;
use super::reader::{Fields, Reader};
use crate::diagnostic::Diagnostic;

/// A node that the rope may leave, between its neighbours.
pub(super) struct Beside<'a> {
    /// The wheel before the node, that of the node, and the one after it.
    pub(super) wheels: [&'a Wheel; 3],
    /// True if the rope turns left around the node.
    pub(super) is_left: bool,
}

impl Reader<'_> {
    /// True of a pulley with `leaves = true`; a rope leaves neither its ends nor a pulley that turns with it.
    pub(super) fn rope_leaves(
        &mut self,
        own: &Fields<'_>,
        (is_end, holds): (bool, bool),
    ) -> Option<bool> {
        let Some(node) = own.get("leaves") else { return Some(false) };
        if !self.flag(node, &own.what("leaves"))? {
            return Some(false);
        }
        let (label, help) = if is_end {
            ("the rope ends here", "remove `leaves`: a drum winds the rope on as long as it turns")
        } else if !own.has("turn") {
            ("a rope goes through an eye", "write the side on which it touches, `turn = \"left\"`")
        } else if holds {
            (
                "the rope turns this pulley",
                "write `slips = true`, of a rope that slides over it without friction",
            )
        } else if own.has("mu") {
            ("the rope rubs here", "remove `mu`: the friction is that of a rope that stays")
        } else {
            return Some(true);
        };
        let message = format!("{} has `leaves` at a place that a rope does not leave", own.owner);
        let fault = Diagnostic::error(codes::NOT_LEFT, message);
        self.report(fault.at(own.location(&["leaves"]), label).help(help));
        None
    }

    /// Refuses two nodes in a row that the rope may leave, and friction next to them: `marks` are whether each may be left
    /// and whether it rubs.
    pub(super) fn check_leaves(&mut self, marks: &[(bool, bool)], fields: &Fields<'_>) -> bool {
        let in_a_row = marks.windows(2).any(|pair| pair[0].0 && pair[1].0);
        let rubs = marks.iter().any(|mark| mark.1) && marks.iter().any(|mark| mark.0);
        if !in_a_row && !rubs {
            return true;
        }
        let (message, help) = if in_a_row {
            (
                format!("{} may leave two places in a row", fields.owner),
                "remove `leaves` of one of them: of the ways beside both it is not known which is the right one",
            )
        } else {
            (
                format!("{} rubs, and leaves what it goes over", fields.owner),
                "remove `mu`, or `leaves`",
            )
        };
        let fault = Diagnostic::error(codes::NOT_LEFT, message);
        self.report(fault.at(fields.location(&["over"]), "here").help(help));
        false
    }

    /// Makes two spans and the arc between them one piece, which is all in the first span: its length with that of the arc,
    /// and what it has gained. Returns the turn β.
    pub(super) fn leave(&self, beside: &Beside<'_>, spans: [&mut Strand; 2]) -> Expr {
        let pool = &self.pool;
        let [from, post, to] = beside.wheels;
        let [before, after] = spans;
        let direct = self.strand(from, to);
        let signed = |turn: Expr| if beside.is_left { turn } else { pool.neg(turn) };
        let first = signed(self.turn_between(before.direction.first, after.direction.first));
        // Counted on from a start around the post; a rope that begins beside it may come to it from half a turn away on
        // either side.
        let counted = self.turn_about(beside.is_left, [before, after], first);
        let between = signed(self.turn_between(before.direction.now, after.direction.now));
        let touches = |turn: Expr| {
            pool.call(Function::Ge, &[turn, pool.zero()]).expect("a comparison has two operands")
        };
        let turn = Twin { now: pool.select(touches(first), counted, between), first };

        // The ways around the post and beside it, from a start around it, even where it begins beside it.
        let radius = signed(post.radius);
        let around = |of: fn(&Twin<Expr>) -> Expr| {
            let arc = pool.mul(radius, of(&turn));
            pool.sum([of(&before.length), arc, of(&after.length)])
        };
        let way = Twin { now: around(|twin| twin.now), first: around(|twin| twin.first) };
        // What is wound on at either side where the direction is another one.
        let wound = |wheel: &Wheel, strand: &Strand| {
            let turn = self.turn_between(strand.direction.first, direct.direction.first);
            pool.mul(wheel.radius, turn)
        };
        let offset = pool.sum([
            pool.sub(direct.length.first, way.first),
            wound(from, before),
            pool.neg(wound(to, after)),
        ]);
        let touches = Twin { now: touches(turn.now), first: touches(turn.first) };
        // The spans count by how far they have turned since the start, within half a turn.
        let whole_turns = pool.mul(radius, pool.sub(turn.now, counted));
        let of_both = pool.sum([before.gain, after.gain, whole_turns]);
        let gain = pool.select(touches.now, of_both, pool.add(direct.gain, offset));
        let at_first = pool.select(touches.first, pool.zero(), offset);

        let choose = |around: Twin<Expr>, beside: Twin<Expr>| Twin {
            now: pool.select(touches.now, around.now, beside.now),
            first: pool.select(touches.first, around.first, beside.first),
        };
        let part = |direction: &Twin<[Expr; 2]>, i: usize| Twin {
            now: direction.now[i],
            first: direction.first[i],
        };
        let direction = |strand: &Strand| {
            let [x, y] =
                [0, 1].map(|i| choose(part(&strand.direction, i), part(&direct.direction, i)));
            Twin { now: [x.now, y.now], first: [x.first, y.first] }
        };
        let none = Twin { now: pool.zero(), first: pool.zero() };
        let directions = [direction(before), direction(after)];
        *before = Strand {
            length: choose(way, direct.length),
            direction: directions[0],
            gain: pool.sub(gain, at_first),
        };
        *after = Strand { length: none, direction: directions[1], gain: pool.zero() };
        turn.now
    }

    /// The turn β between two spans, which is `first` at the start.
    pub(super) fn turn_about(
        &self,
        is_left: bool,
        [before, after]: [&Strand; 2],
        first: Expr,
    ) -> Expr {
        let pool = &self.pool;
        let turned =
            |strand: &Strand| self.turn_between(strand.direction.first, strand.direction.now);
        let since = pool.sub(turned(after), turned(before));
        pool.add(first, if is_left { since } else { pool.neg(since) })
    }

    /// The angle from one direction to another, within ±180°.
    fn turn_between(&self, from: [Expr; 2], to: [Expr; 2]) -> Expr {
        if from == to {
            return self.pool.zero();
        }
        let [cross, dot] = self.between_directions(from, to);
        self.angle_of(cross, dot)
    }
}
