//! [`Duty`]: the efforts of an actuator over its speed, beside the curve of a motor.

use crate::error::AnalysisError;

/// The largest effort of a motor over its speed, alike in all four quadrants; straight between its points, nothing beyond.
#[derive(Clone, PartialEq, Debug)]
pub struct MotorCurve {
    /// Name of the actuator: of a joint, or of a drive.
    pub name: String,
    /// Speed, rad/s or m/s, and effort, N m or N; by ascending speed.
    points: Vec<[f64; 2]>,
}

/// Operating points of an actuator beside a motor's curve.
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
    /// A curve through points of speed and effort, SI.
    ///
    /// # Errors
    /// [`AnalysisError::BadRange`] for fewer than two points, speeds that do not ascend from zero or above, and efforts
    /// below zero.
    pub fn new(name: &str, points: Vec<[f64; 2]>) -> Result<Self, AnalysisError> {
        let ascends = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let is_whole = points.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
        if points.len() < 2 || !ascends || !is_whole {
            let text = format!("the motor's curve of {name}");
            return Err(AnalysisError::BadRange { text, unit: String::new() });
        }
        Ok(Self { name: name.to_owned(), points })
    }

    /// Its points: speed and effort.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// The largest effort at a speed of either sign.
    pub fn at(&self, speed: f64) -> f64 {
        let speed = speed.abs();
        let next = self.points.partition_point(|point| point[0] < speed);
        match (next.checked_sub(1).map(|k| self.points[k]), self.points.get(next)) {
            (_, None) => 0.0,
            (None, Some(first)) => first[1],
            (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (speed - a[0]) / (b[0] - a[0]),
        }
    }
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
        assert!(MotorCurve::new("A", vec![[0.0, 4.0]]).is_err());
        assert!(MotorCurve::new("A", vec![[1.0, 4.0], [1.0, 3.0]]).is_err());
    }
}
