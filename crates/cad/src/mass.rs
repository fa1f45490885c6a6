//! Mass properties of outlines: area, perimeter, centroid and second moments of area.
//!
//! ```text
//! A = ∫ dA    S = ∫ p dA    J = ∫ p pᵀ dA
//! ```
//!
//! The moments are those of the paths, taken first about the middle of the outline and then about its
//! centroid, so that outlines far from the origin lose no digits.

use crate::geometry::Point;
use crate::geometry::moments::Moments;
use crate::geometry::vector::norm;
use crate::outline::{Outline, OutlineError};

/// Properties of the area inside an outline, in powers of the drawing unit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AreaProperties {
    /// Of the material: holes are taken off.
    pub area: f64,
    /// Length of all loops, those of holes too.
    pub perimeter: f64,
    /// In the axes of the drawing.
    pub centroid: Point,
    /// ∫ y² dA about the centroid.
    pub ixx: f64,
    /// ∫ x² dA about the centroid.
    pub iyy: f64,
    /// ∫ x y dA about the centroid.
    pub ixy: f64,
    /// ∫ (x² + y²) dA about the centroid.
    pub polar: f64,
}

/// A plate of even thickness, in SI units.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PlateProperties {
    /// kg.
    pub mass: f64,
    /// Centre of mass, m, in the axes of the drawing.
    pub com: Point,
    /// Moment of inertia about the centre of mass, about the normal of the plane, kg m².
    pub inertia: f64,
}

impl AreaProperties {
    /// Of the material inside `outline`.
    ///
    /// # Errors
    /// [`OutlineError::NoArea`] when there is none.
    pub fn of(outline: &Outline) -> Result<Self, OutlineError> {
        let about = |reference: Point| -> Moments {
            let parts = outline.loops.iter().map(|part| Moments::of_path(&part.path, reference));
            parts.fold(Moments::default(), Moments::plus)
        };
        let bounds = outline.bounds();
        let no_area = || OutlineError::NoArea { at: bounds.min, entities: outline.entities() };

        // About the middle first; what is left of the first moments then is small.
        let middle = bounds.centre();
        let coarse = about(middle);
        let shift = coarse.centroid().ok_or_else(no_area)?;
        let reference = [middle[0] + shift[0], middle[1] + shift[1]];
        let fine = about(reference);
        let rest = fine.centroid().ok_or_else(no_area)?;
        if norm(rest) > bounds.diagonal() {
            return Err(no_area());
        }
        let [xx, xy, yy] = fine.about_centroid();
        Ok(Self {
            area: fine.area,
            perimeter: outline.loops.iter().map(|part| part.path.length()).sum(),
            centroid: [reference[0] + rest[0], reference[1] + rest[1]],
            ixx: yy,
            iyy: xx,
            ixy: xy,
            polar: xx + yy,
        })
    }

    /// A plate of this area: `metres` is the drawing unit in metres, `density` in kg/m³,
    /// `thickness` in m.
    pub fn plate(&self, metres: f64, density: f64, thickness: f64) -> PlateProperties {
        let per_area = density * thickness;
        PlateProperties {
            mass: per_area * self.area * metres.powi(2),
            com: self.centroid.map(|x| x * metres),
            inertia: per_area * self.polar * metres.powi(4),
        }
    }
}
