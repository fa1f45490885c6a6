//! Pulleys and posts that a rope leaves, and comes to again: its way is the shorter one beside them.
//!
//! ```text
//! β = σ (∠(e₋, e₊)₀ + ψ₊ − ψ₋)                       turn of the rope about the post, σ = ±1 its sense
//! w = s₋ + |r| β + s₊ where β ≥ 0, else s               s of the straight span that leaves the post out
//! ```
//!
//! Where β is zero both ways are of one length, and so are their rates, so that nothing is hit as the rope comes to the
//! post. ψ are the angles by which the spans have turned since the start, so that a string may wind on for any number of
//! turns.

use bksim_expr::{Expr, Function};

use super::belts::{Strand, Twin, Wheel};
use super::codes;
use super::reader::{Fields, Reader};
use super::tree::Value;
use super::units::Quantity;
use super::value::Scope;
use crate::diagnostic::Diagnostic;

/// A node that the rope may leave, between its neighbours.
pub(super) struct Beside<'a> {
    /// Name of the rope.
    pub(super) owner: &'a str,
    /// The wheel before the node, that of the node, and the one after it.
    pub(super) wheels: [&'a Wheel; 3],
    /// True if the rope turns left around the node.
    pub(super) is_left: bool,
    /// Whole turns about the node at the start, where they are stated.
    pub(super) whole_turns: Option<Expr>,
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

    /// Whole turns about a pulley, `Some(None)` where they are not stated.
    #[expect(clippy::option_option, reason = "at fault, not stated, or stated")]
    pub(super) fn whole_turns(
        &mut self,
        own: &Fields<'_>,
        has_no_arc: bool,
    ) -> Option<Option<Expr>> {
        let Some(node) = own.get("whole_turns") else { return Some(None) };
        let what = own.what("whole_turns");
        if has_no_arc {
            let message =
                format!("{} has `whole_turns` where the rope goes around nothing", own.owner);
            self.report(
                Diagnostic::error(codes::KEY_CONFLICT, message)
                    .at(own.location(&["whole_turns"]), "an end, or an eye without a radius")
                    .help("remove it, or write it of a pulley or post between the ends"),
            );
            return None;
        }
        if let Value::Number { value, .. } = node.value
            && value >= 0.0
            && value.fract() == 0.0
        {
            let count = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
            return Some(Some(count.expr));
        }
        let help = "write for example `whole_turns = 2`; the part of a turn follows from the ends of the rope";
        self.wrong_kind(node, &what, "a whole number", &node.value, help);
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
    pub(super) fn leave(&mut self, beside: &Beside<'_>, spans: [&mut Strand; 2]) -> Expr {
        let [from, post, to] = beside.wheels;
        let [before, after] = spans;
        let is_wound = [from, to].iter().any(|wheel| !self.pool.is_zero(wheel.radius));
        let direct = self.strand(beside.owner, [from, to], is_wound);
        let pool = &self.pool;
        let signed = |turn: Expr| if beside.is_left { turn } else { pool.neg(turn) };
        let least = signed(self.turn_between(before.direction.first, after.direction.first));
        let first = self.with_whole_turns(least, beside.whole_turns);
        let counted = self.turn_about(beside.is_left, [before, after], first);
        let touches = |turn: Expr| {
            pool.call(Function::Ge, &[turn, pool.zero()]).expect("a comparison has two operands")
        };
        let turn = Twin { now: counted, first };

        // The ways around the post and beside it, from a start around it, even where it begins beside it.
        let radius = signed(post.radius);
        let around = |of: fn(&Twin<Expr>) -> Expr| {
            let arc = pool.mul(radius, of(&turn));
            pool.sum([of(&before.length), arc, of(&after.length)])
        };
        let way = Twin { now: around(|twin| twin.now), first: around(|twin| twin.first) };
        // Angles from the spans of the start to the straight one: where β is zero all three have one direction.
        let apart = self.turn_between(before.direction.first, direct.direction.first);
        let apart = [apart, pool.sub(apart, signed(first))];
        let offset = pool.sum([
            pool.sub(direct.length.first, way.first),
            pool.mul(from.radius, apart[0]),
            pool.neg(pool.mul(to.radius, apart[1])),
        ]);
        let touches = Twin { now: touches(turn.now), first: touches(turn.first) };
        let of_both = pool.add(before.gain, after.gain);
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
        // Against the direction of the start, whichever way the rope took there.
        let turned = |strand: &Strand, apart: Expr| {
            let now = pool.select(touches.now, strand.turn, pool.add(direct.turn, apart));
            pool.sub(now, pool.select(touches.first, pool.zero(), apart))
        };
        let [turned_before, turned_after] = [turned(before, apart[0]), turned(after, apart[1])];
        *before = Strand {
            length: choose(way, direct.length),
            direction: directions[0],
            turn: turned_before,
            gain: pool.sub(gain, at_first),
        };
        *after = Strand {
            length: none,
            direction: directions[1],
            turn: turned_after,
            gain: pool.zero(),
        };
        turn.now
    }

    /// A turn at the start with the whole turns that are stated.
    pub(super) fn with_whole_turns(&self, turn: Expr, whole_turns: Option<Expr>) -> Expr {
        let Some(count) = whole_turns else { return turn };
        let pool = &self.pool;
        pool.sum([turn, pool.mul(pool.int(2.into()), pool.mul(pool.pi(), count))])
    }

    /// The turn β between two spans, which is `first` at the start.
    pub(super) fn turn_about(
        &self,
        is_left: bool,
        [before, after]: [&Strand; 2],
        first: Expr,
    ) -> Expr {
        let pool = &self.pool;
        let since = pool.sub(after.turn, before.turn);
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
