//! Curves that points follow, laws of motion, and the cams that move followers by them.

use bksim_expr::{Expr, Pool, SymbolId};

use crate::diagnostic::Span;
use crate::ids::{LawId, Vector};

/// A curve in the frame of a point of a body, by a parameter.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name as written.
    pub name: String,
    /// The parameter, a pure number.
    pub parameter: SymbolId,
    /// The point at each value of the parameter, m.
    pub position: Vector,
    /// The values between which it is drawn.
    pub range: [Expr; 2],
    /// The profile of a cam comes from one.
    pub cam: Option<Cam>,
}

impl Curve {
    /// The path of the centre of the roller that the curve is the profile for.
    pub fn pitch(&self, pool: &Pool) -> Option<Vector> {
        let cam = self.cam.as_ref().filter(|cam| cam.roller.is_some())?;
        Some(cam.pitch.map(|e| pool.substitute(e, &[(cam.base, cam.base_circle)])))
    }
}

/// A law of motion of the follower of a cam.
#[derive(Clone, Debug)]
pub struct CamLaw {
    /// Name as written.
    pub name: String,
    /// The angle of the cam, rad.
    pub angle: SymbolId,
    /// The lift at each angle of the written turns, m or rad.
    pub lift: Expr,
    /// The lift is an angle.
    pub is_angle: bool,
    /// One after the other, of one turn of the law.
    pub segments: Vec<LawSegment>,
}

/// A part of a law: a rise, a return below zero, or a dwell.
#[derive(Clone, Debug)]
pub struct LawSegment {
    /// Angle at its beginning, rad.
    pub from: f64,
    /// rad.
    pub over: f64,
    /// m or rad.
    pub rise: f64,
    /// The word of its law; `None` of a dwell.
    pub law: Option<&'static str>,
    /// Angles at which its formula changes, from its beginning on, rad.
    pub borders: Vec<f64>,
}

/// The follower of a cam.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FollowerKind {
    /// A point.
    Knife,
    /// A circle about a point.
    Roller,
    /// A straight line.
    Flat,
}

/// The making of a profile, in the frame of the cam by the parameter of the curve, which is the angle of the cam.
#[derive(Clone, Debug)]
pub struct Cam {
    /// The law of the follower.
    pub law: LawId,
    /// Follower of the cam.
    pub kind: FollowerKind,
    /// Stands for the radius of the base circle in `pitch` and `travel`, m.
    pub base: SymbolId,
    /// The radius of the base circle as written, m.
    pub base_circle: Expr,
    /// The radius of the roller, m.
    pub roller: Option<Expr>,
    /// The path of the follower's point; of a flat face the profile.
    pub pitch: Vector,
    /// Unit vector along which the lift moves the point; of a flat face its normal.
    pub travel: Vector,
    /// The sense in which the cam turns.
    pub is_clockwise: bool,
    /// Position of the radius of the base circle.
    pub span: Span,
}
