//! [`Border`]: a closed path that answers quickly what is inside of it and how far it is.

use super::boxes::{BoxTree, Part};
use crate::geometry::vector::distance;
use crate::geometry::{Bounds, Curve, Path, Pen, Point};

/// A closed path with a tree of boxes over its curves.
pub(super) struct Border<'a> {
    pub(super) path: &'a Path,
    pub(super) bounds: Bounds,
    tree: BoxTree,
}

impl<'a> Border<'a> {
    pub(super) fn of(path: &'a Path) -> Self {
        let boxes: Vec<Bounds> = path.curves.iter().map(Curve::bounds).collect();
        let bounds = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        Self { path, bounds, tree: BoxTree::in_order(&boxes) }
    }

    pub(super) fn start(&self) -> Point {
        self.path.start_point().unwrap_or([f64::NAN; 2])
    }

    /// Winding number as of [`Path::winding`], passing over stretches whose box does not contain the point: those may
    /// be replaced by their chords.
    pub(super) fn contains(&self, point: Point) -> bool {
        if !self.bounds.contains(point) {
            return false;
        }
        let mut pen = Pen::new(point);
        let curves = &self.path.curves;
        self.tree.descend(
            |bounds| bounds.contains(point),
            |part| match part {
                Part::Leaf(i) => pen.follow(&curves[i]),
                Part::Passed { first, last } => {
                    pen.line_to(curves[first].start_point());
                    pen.line_to(curves[last].end_point());
                }
            },
        );
        pen.close() != 0
    }

    pub(super) fn distance(&self, point: Point) -> f64 {
        self.tree.nearest(point, |i| self.path.curves[i].distance(point))
    }

    /// True if a point lies within `tolerance` of the path.
    pub(super) fn is_near(&self, point: Point, tolerance: f64) -> bool {
        distance(self.start(), point) <= tolerance || self.distance(point) <= tolerance
    }
}
