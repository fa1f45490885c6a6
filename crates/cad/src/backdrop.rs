//! [`Backdrop`]: the lines of a drawing as polygons, m, to draw a mechanism over.

use std::f64::consts::TAU;

use crate::drawing::{LengthUnit, Shape};
use crate::geometry::{Curve, Path, Point};
use crate::model::{Refused, sheet};

/// Parts of the diagonal of a drawing by which a polygon may leave its curve.
const PARTS: f64 = 4000.0;

/// Part of a turn by which that of a closed curve may be off.
const ROUNDING: f64 = 1e-9;

/// The lines of a drawing.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Backdrop {
    /// Corners of a polygon for each path, m.
    pub lines: Vec<Vec<Point>>,
    /// Places that are worth meeting: ends of curves and centres of arcs, m.
    pub places: Vec<Point>,
}

impl Backdrop {
    /// The lines of the layers that are shown, without marks of bksim and texts.
    ///
    /// # Errors
    /// [`Refused`] when it is no drawing that can be read.
    pub fn read(bytes: Vec<u8>, unit: Option<LengthUnit>) -> Result<Self, Refused> {
        let sheet = sheet(bytes, unit)?;
        let [low, high] = sheet.drawing.extent;
        let tolerance = ((high[0] - low[0]).hypot(high[1] - low[1]) / PARTS).max(f64::MIN_POSITIVE);
        let metres = |point: Point| point.map(|x| x * sheet.drawing.unit.metres);
        let mut found = Self::default();
        for entity in &sheet.drawing.entities {
            let paths: &[Path] = match &entity.shape {
                Shape::Path(path) => std::slice::from_ref(path),
                Shape::Paths(paths) | Shape::Hatch(paths) => paths,
                _ => continue,
            };
            if sheet.hidden_layers.contains(&entity.location.layer) {
                continue;
            }
            for path in paths {
                found.lines.push(path.flattened(tolerance).into_iter().map(metres).collect());
                let places = path.curves.iter().flat_map(places).map(metres);
                found.places.extend(places);
            }
        }
        found.places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        found.places.dedup();
        Ok(found)
    }
}

/// Ends of a curve, or the centre of one that is round.
fn places(curve: &Curve) -> Vec<Point> {
    let ends = [curve.start_point(), curve.end_point()];
    match curve {
        Curve::Arc { centre, sweep, .. } | Curve::Ellipse { centre, sweep, .. } => {
            let is_whole = sweep.abs() > TAU * (1.0 - ROUNDING);
            [&[*centre][..], if is_whole { &[] } else { &ends }].concat()
        }
        _ => ends.to_vec(),
    }
}
