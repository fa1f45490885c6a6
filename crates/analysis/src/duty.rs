//! [`Duty`]: the efforts of an actuator over its speed, next to the curve of a motor.

use bksim_model::{FunctionPiece, Model};

use crate::error::AnalysisError;

/// An effort below zero by less is none, N m or N: the end of a spline that leads to zero.
const ROUNDING: f64 = 1e-12;

/// The largest effort of a motor over its speed, alike in all four quadrants; nothing beyond its last point.
#[derive(Clone, PartialEq, Debug)]
pub struct MotorCurve {
    /// Name of the actuator: of a joint, or of a drive.
    pub name: String,
    /// SI units of speed and effort, empty for numbers without one: those of a table of the model.
    units: Option<[String; 2]>,
    /// Speed, rad/s or m/s, and effort, N m or N; by ascending speed.
    points: Vec<[f64; 2]>,
    /// Effort by speed from the first point on.
    pieces: Vec<FunctionPiece>,
}

/// Operating points of an actuator next to a motor's curve.
#[derive(Clone, PartialEq, Debug)]
pub struct Duty {
    /// The curve.
    pub curve: MotorCurve,
    /// Units of speed and effort.
    pub units: [String; 2],
    /// By time: t, speed, effort, and the effort that the curve has at that speed.
    pub points: Vec<[f64; 4]>,
}

impl MotorCurve {
    /// A curve through points of speed and effort, SI, straight between them.
    ///
    /// # Errors
    /// [`AnalysisError::BadCurve`] for fewer than two points, speeds that do not ascend from zero or above, and efforts
    /// below zero.
    pub fn new(name: &str, points: Vec<[f64; 2]>) -> Result<Self, AnalysisError> {
        let straight = |pair: &[[f64; 2]]| {
            let ([x, y], [to, end]) = (pair[0], pair[1]);
            FunctionPiece {
                ranges: vec![[x, to]],
                origin: vec![x],
                terms: vec![([0, 0], y), ([1, 0], (end - y) / (to - x))],
                sine: None,
            }
        };
        let pieces = points.windows(2).map(straight).collect();
        Self { name: name.to_owned(), units: None, points, pieces }.checked()
    }

    /// The curve of a table of `model`.
    ///
    /// # Errors
    /// [`AnalysisError::UnknownTable`] where no table of one argument has this name, and as [`MotorCurve::new`].
    pub fn of_table(model: &Model, name: &str, table: &str) -> Result<Self, AnalysisError> {
        let unknown = || AnalysisError::UnknownTable {
            name: table.to_owned(),
            known: model.measured.iter().map(|known| known.name.clone()).collect(),
        };
        let table = model.measured.iter().find(|known| known.name == table).ok_or_else(unknown)?;
        // Pieces beyond the rows have no end.
        let is_within = |piece: &&FunctionPiece| piece.ranges[0].iter().all(|x| x.is_finite());
        let within = || table.pieces.iter().filter(is_within);
        let end = |piece: &FunctionPiece| [piece.ranges[0][1], value(piece, piece.ranges[0][1])];
        let rows =
            within().map(|piece| piece.terms[0].1).chain(within().next_back().map(|p| end(p)[1]));
        let is_negative = rows.into_iter().any(|effort| effort < -ROUNDING);
        let points = within().flat_map(drawn).chain(within().next_back().map(end));
        let points = points.map(|[x, y]| [x, if is_negative { y } else { y.max(0.0) }]).collect();
        let (units, pieces) = (Some(table.units.clone()), table.pieces.clone());
        Self { name: name.to_owned(), units, points, pieces }.checked()
    }

    fn checked(self) -> Result<Self, AnalysisError> {
        let ascends = self.points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let is_whole = self.points.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
        if self.points.len() < 2 || !ascends || !is_whole {
            return Err(AnalysisError::BadCurve { name: self.name });
        }
        Ok(self)
    }

    /// Points of the motor curve, speed and effort: straight lines between them draw it.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// The largest effort at a speed of either sign.
    pub fn at(&self, speed: f64) -> f64 {
        let speed = speed.abs().max(self.pieces[0].ranges[0][0]);
        let holds = |piece: &&FunctionPiece| speed <= piece.ranges[0][1];
        self.pieces.iter().find(holds).map_or(0.0, |piece| value(piece, speed).max(0.0))
    }

    /// Refuses an actuator whose speed and effort have other units than the columns of a table.
    pub(crate) fn check_units(&self, turns: bool) -> Result<(), AnalysisError> {
        let expected = if turns { ["1/s", "N m"] } else { ["m/s", "N"] };
        let Some(units) = &self.units else { return Ok(()) };
        let is_known = |(unit, expected): (&String, &str)| unit.is_empty() || unit == expected;
        if units.iter().zip(expected).all(is_known) {
            return Ok(());
        }
        let (name, units) = (self.name.clone(), units.clone());
        Err(AnalysisError::CurveUnits { name, units, turns })
    }
}

/// The value of a piece, of one argument.
fn value(piece: &FunctionPiece, x: f64) -> f64 {
    let distance = x - piece.origin[0];
    piece.terms.iter().rev().fold(0.0, |sum, (_, c)| sum * distance + c)
}

/// Points of a piece without its last, near enough to each other to be joined by straight lines; none of one without end.
fn drawn(piece: &FunctionPiece) -> Vec<[f64; 2]> {
    /// Lines in place of one that bends.
    const N_LINES: u32 = 16;
    let [from, to] = piece.ranges[0];
    if !(from.is_finite() && to.is_finite()) {
        return Vec::new();
    }
    let n =
        if piece.terms.iter().any(|(power, c)| power[0] > 1 && *c != 0.0) { N_LINES } else { 1 };
    let at = |k: u32| from + (to - from) * f64::from(k) / f64::from(n);
    (0..n).map(|k| [at(k), value(piece, at(k))]).collect()
}

impl Duty {
    /// Points whose effort is larger than the curve's.
    pub fn outside(&self) -> impl Iterator<Item = &[f64; 4]> {
        self.points.iter().filter(|[_, _, effort, limit]| effort.abs() > *limit)
    }

    /// The point that takes the largest part of the curve's effort.
    pub fn worst(&self) -> Option<&[f64; 4]> {
        let share = |[_, _, effort, limit]: &[f64; 4]| {
            if *effort == 0.0 { 0.0 } else { effort.abs() / limit }
        };
        self.points.iter().max_by(|a, b| share(a).total_cmp(&share(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_straight_between_its_points_and_nothing_beyond() {
        let curve =
            MotorCurve::new("A", vec![[0.0, 4.0], [100.0, 4.0], [200.0, 1.0]]).expect("a curve");
        for (speed, effort) in [(-50.0, 4.0), (150.0, 2.5), (200.0, 1.0), (201.0, 0.0)] {
            assert_eq!(curve.at(speed), effort, "at {speed}");
        }
        assert_eq!(curve.at(100.0), 4.0);
        assert!(MotorCurve::new("A", vec![[0.0, 4.0]]).is_err());
        assert!(MotorCurve::new("A", vec![[1.0, 4.0], [1.0, 3.0]]).is_err());
    }
}
