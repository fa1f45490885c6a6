//! Outlines: closed paths made of the lines and arcs of a drawing, and which of them are holes.
//!
//! ```text
//! strokes → chain → closed and open chains, snaps → nest → Outline
//! ```
//!
//! Ends that meet within the tolerance are joined; a loop inside an odd number of others is a hole.
//! Both work on the curves as they are, not on polygons of them.

mod apart;
mod border;
mod boxes;
mod chain;
mod contact;
mod error;
mod nest;

pub use apart::{Apart, Doubled, chain_apart, doubled};
pub use chain::{Chain, Chains, Snap, chain};
pub use error::{OpenEnd, OutlineError};
pub use nest::nest;

use crate::geometry::{Bounds, Path, Point, signed_area};

/// A path of the drawing and where it comes from.
#[derive(Clone, PartialEq, Debug)]
pub struct Stroke {
    /// Curves of the stroke.
    pub path: Path,
    /// The index of its entity; only passed on.
    pub entity: usize,
}

/// One closed path of an outline.
#[derive(Clone, PartialEq, Debug)]
pub struct Loop {
    /// Counter-clockwise around material, clockwise around a hole.
    pub path: Path,
    /// True if the material is outside.
    pub is_hole: bool,
    /// The entities it is made of, in the order of the path.
    pub entities: Vec<usize>,
}

/// An area: loops around material and loops around holes in it, none crossing another.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outline {
    /// In the order of their first strokes.
    pub loops: Vec<Loop>,
}

impl Outline {
    /// The outline that all strokes together make, and what was snapped for it.
    ///
    /// # Errors
    /// Those of [`chain`] and [`nest`], and [`OutlineError::Open`] for ends that meet no other.
    pub fn of(strokes: &[Stroke], tolerance: f64) -> Result<(Self, Vec<Snap>), OutlineError> {
        let chains = chain(strokes, tolerance)?;
        if let Some(open) = chains.open_error() {
            return Err(open);
        }
        Ok((nest(&chains.closed, tolerance)?, chains.snaps))
    }

    /// The outline around a point: the smallest closed chain that contains it and the ones directly
    /// inside that as holes; `None` when no chain contains the point.
    ///
    /// # Errors
    /// Those of [`nest`] among these chains.
    pub fn around(
        closed: &[Chain],
        point: Point,
        tolerance: f64,
    ) -> Result<Option<Self>, OutlineError> {
        let outer = surrounding(closed, point).into_iter().next();
        outer.map(|outer| Self::inside(closed, outer, tolerance)).transpose()
    }

    /// The outline that one of the chains is the border of, with the ones directly inside that as
    /// holes.
    ///
    /// # Errors
    /// Those of [`nest`] among these chains.
    pub fn inside(closed: &[Chain], outer: usize, tolerance: f64) -> Result<Self, OutlineError> {
        let border = &closed[outer];
        let inside = closed.iter().enumerate().filter(|&(chain_idx, chain)| {
            let Some(start) = chain.path.start_point() else { return false };
            chain_idx != outer
                && border.path.bounds().contains(start)
                && border.path.winding(start) != 0
                && signed_area(&chain.path).abs() < signed_area(&border.path).abs()
        });
        let inside = inside.map(|(_, chain)| chain);
        let chosen: Vec<Chain> = std::iter::once(border).chain(inside).cloned().collect();
        let (outline, depths) = nest::nest_with_depths(&chosen, tolerance)?;
        let parts = outline.loops.into_iter().zip(depths);
        let loops = parts.filter(|(_, depth)| *depth <= 1).map(|(part, _)| part).collect();
        Ok(Self { loops })
    }

    /// True if the point is in the material; on the border it is either.
    pub fn contains(&self, point: Point) -> bool {
        self.loops.iter().map(|part| part.path.winding(point)).sum::<i32>() > 0
    }

    /// Whether the point is in the material or in one of its holes.
    pub fn outer_contains(&self, point: Point) -> bool {
        let mut outer = self.loops.iter().filter(|part| !part.is_hole);
        outer.any(|part| part.path.winding(point) != 0)
    }

    /// Distance from the point to the nearest point of a loop; infinite without loops.
    pub fn distance(&self, point: Point) -> f64 {
        self.loops.iter().map(|part| part.path.distance(point)).fold(f64::INFINITY, f64::min)
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Bounds {
        self.loops.iter().map(|part| part.path.bounds()).fold(Bounds::EMPTY, Bounds::union)
    }

    /// The entities of all loops.
    pub fn entities(&self) -> Vec<usize> {
        self.loops.iter().flat_map(|part| part.entities.iter().copied()).collect()
    }
}

/// The closed chains around a point, the smallest first.
pub fn surrounding(closed: &[Chain], point: Point) -> Vec<usize> {
    let mut around: Vec<(f64, usize)> = closed
        .iter()
        .enumerate()
        .filter(|(_, chain)| chain.path.bounds().contains(point) && chain.path.winding(point) != 0)
        .map(|(chain_idx, chain)| (signed_area(&chain.path).abs(), chain_idx))
        .collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    around.into_iter().map(|(_, chain_idx)| chain_idx).collect()
}
