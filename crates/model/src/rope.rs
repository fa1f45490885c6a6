//! Ropes over pulleys, from one end to the other.

use std::ops::Range;

use bksim_expr::Expr;

use crate::body::Anchor;
use crate::diagnostic::Span;

/// A rope without mass in the plane, over pulleys and through eyes, with ends at points or on drums.
#[derive(Clone, Debug)]
pub struct Rope {
    /// Name as written.
    pub name: String,
    /// Ends of the rope and what it goes over, in its own order; a span leads from each to the next.
    pub nodes: Vec<RopeNode>,
    /// The parts between places that it does not slip over; each has one pull.
    pub sections: Vec<RopeSection>,
    /// Length at the start, if the author stated it; of an elastic rope without load.
    pub length: Option<Expr>,
    /// Position of the name.
    pub span: Span,
}

/// Motion of a rope along what it touches.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RopeGrip {
    /// None, as of an end, and of a pulley that the rope takes with it.
    Holds,
    /// It slides over a pulley or post.
    Slips,
}

/// An end of a rope, or something that it goes over.
#[derive(Clone, Copy, Debug)]
pub struct RopeNode {
    /// The point, or the centre of a pulley or drum.
    pub center: Anchor,
    /// Radius, m: positive where the rope turns left around it, below zero where it turns right; zero of a point.
    pub radius: Expr,
    /// True if the rope turns left around it.
    pub is_left: bool,
    /// The rope against the surface that it touches.
    pub grip: RopeGrip,
    /// Turn of the rope about a pulley, rad, on and on from the start: an expression of signals. The rope touches where
    /// this is not below zero.
    pub turn: Option<Expr>,
    /// True if the author states the whole turns about it.
    pub is_counted: bool,
    /// True if the rope leaves it where the turn is below zero, else it is held to it.
    pub leaves: bool,
}

/// A part of a rope with one pull.
#[derive(Clone, Debug)]
pub struct RopeSection {
    /// Name of its pull: that of the rope, with a number where there are several.
    pub name: String,
    /// Spans of the section, each by the node that it leads from.
    pub spans: Range<usize>,
    /// Excess of the way over the section's own length, m: an expression of signals.
    pub excess: Expr,
    /// Pull of an elastic rope, N: an expression of signals.
    pub pull: Option<Expr>,
}
