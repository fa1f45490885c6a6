//! Solids for the page: corners to five digits, and meshes that are too large made coarser.
//!
//! A mesh is made coarser by clusters: corners in one cell of a grid become one, the mean of them, and faces that lose a
//! corner vanish. Source: J. Rossignac, P. Borrel, *Multi-resolution 3D approximations for rendering complex scenes*, in:
//! Modeling in Computer Graphics (1993) 455.

use std::collections::BTreeMap;

use bksim_scene::{Form, Scene, Solid};

/// Corners and faces of a solid, as the page has them.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct PageSolid {
    /// m, in its body's frame.
    pub(crate) corners: Vec<[f64; 3]>,
    pub(crate) faces: Vec<Vec<usize>>,
    /// Cells along its longest side; none of a solid that is whole.
    n_cells: Option<u32>,
}

/// Bytes of one coordinate and of one corner of a face, with the commas.
const BYTES: [usize; 2] = [8, 6];
/// Cells along the longest side of a mesh that is made coarser for the first time, and the fewest.
const N_CELLS: [u32; 2] = [128, 8];

/// The solids among the shapes of a scene, none of other shapes, in at most `budget` bytes; with a remark where meshes
/// were made coarser.
pub(crate) fn take(scene: &Scene, budget: usize) -> (Vec<Option<PageSolid>>, Option<String>) {
    let whole = |form: &Form| match form {
        Form::Solid(solid) => Some(PageSolid::whole(solid)),
        _ => None,
    };
    let mut solids: Vec<Option<PageSolid>> =
        scene.shapes.iter().map(|shape| whole(&shape.form)).collect();
    let n_faces = |solids: &[Option<PageSolid>]| -> usize {
        solids.iter().flatten().map(|solid| solid.faces.len()).sum()
    };
    let all = n_faces(&solids);
    // The largest one first, until all fit or none can be coarser.
    while solids.iter().flatten().map(PageSolid::bytes).sum::<usize>() > budget {
        let can_be_coarser = |(_, solid): &(usize, &PageSolid)| solid.next_cells().is_some();
        let found = solids.iter().enumerate().filter_map(|(k, solid)| Some((k, solid.as_ref()?)));
        let largest =
            found.filter(can_be_coarser).max_by_key(|(k, solid)| (solid.bytes(), usize::MAX - k));
        let Some((largest, n_cells)) =
            largest.and_then(|(k, solid)| Some((k, solid.next_cells()?)))
        else {
            break;
        };
        if let Form::Solid(solid) = &scene.shapes[largest].form {
            solids[largest] = Some(PageSolid::whole(solid).clustered(n_cells));
        }
    }
    let kept = n_faces(&solids);
    let remark = (kept < all).then(|| {
        format!(
            "Large meshes are drawn coarser here: {kept} of {all} faces; the log and the window have all."
        )
    });
    (solids, remark)
}

impl PageSolid {
    fn whole(solid: &Solid) -> Self {
        let faces = solid.faces.clone();
        Self { corners: rounded(&solid.corners), faces, n_cells: None }
    }

    fn bytes(&self) -> usize {
        let n_indices: usize = self.faces.iter().map(Vec::len).sum();
        3 * BYTES[0] * self.corners.len() + BYTES[1] * n_indices
    }

    /// The next coarser grid.
    fn next_cells(&self) -> Option<u32> {
        match self.n_cells {
            None => Some(N_CELLS[0]),
            Some(n) => Some(n * 3 / 4).filter(|&n| n >= N_CELLS[1]),
        }
    }

    /// Solid with one corner in each cell of a grid.
    fn clustered(&self, n_cells: u32) -> Self {
        let (low, size) = extent(&self.corners);
        let cell = size / f64::from(n_cells);
        #[expect(clippy::cast_possible_truncation, reason = "a cell's number")]
        let cell_of = |p: &[f64; 3]| [0, 1, 2].map(|i| ((p[i] - low[i]) / cell).floor() as i64);
        let mut number_of: BTreeMap<[i64; 3], usize> = BTreeMap::new();
        let mut sums: Vec<([f64; 3], f64)> = Vec::new();
        let mut of_corner = Vec::with_capacity(self.corners.len());
        for corner in &self.corners {
            let number = *number_of.entry(cell_of(corner)).or_insert_with(|| {
                sums.push(([0.0; 3], 0.0));
                sums.len() - 1
            });
            let (sum, n) = &mut sums[number];
            sum.iter_mut().zip(corner).for_each(|(sum, x)| *sum += x);
            *n += 1.0;
            of_corner.push(number);
        }
        let faces = self.faces.iter().map(|face| {
            let mut ring: Vec<usize> = face.iter().map(|&corner| of_corner[corner]).collect();
            ring.dedup();
            if ring.first() == ring.last() {
                ring.pop();
            }
            ring
        });
        let corners: Vec<[f64; 3]> = sums.iter().map(|(sum, n)| sum.map(|x| x / n)).collect();
        let faces = faces.filter(|ring| ring.len() > 2).collect();
        Self { corners: rounded(&corners), faces, n_cells: Some(n_cells) }
    }
}

/// The least coordinates of some points, and their largest extent along an axis; a metre where they are one point.
fn extent(points: &[[f64; 3]]) -> ([f64; 3], f64) {
    let bound = |fold: fn(f64, f64) -> f64, first: f64| {
        [0, 1, 2].map(|i| points.iter().map(|p| p[i]).fold(first, fold))
    };
    let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
    let size = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
    (low, if size > 0.0 { size } else { 1.0 })
}

/// Points to a part of their extent that no screen shows: decimals, so that they are short as text.
fn rounded(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (_, size) = extent(points);
    #[expect(clippy::cast_possible_truncation, reason = "the exponent of a length")]
    let decimals = 5 - size.log10().floor() as i32;
    let unit = 10f64.powi(decimals);
    points.iter().map(|p| p.map(|x| (x * unit).round() / unit)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of 2 n² triangles.
    fn sphere(n: usize) -> PageSolid {
        use std::f64::consts::PI;
        let at = |i: usize, j: usize| {
            let (polar, around) = (PI * i as f64 / n as f64, 2.0 * PI * j as f64 / n as f64);
            [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()]
        };
        let mut corners = Vec::new();
        let mut faces = Vec::new();
        for i in 0..=n {
            corners.extend((0..n).map(|j| at(i, j)));
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let (next, a, b) = ((j + 1) % n, i * n, (i + 1) * n);
            faces.push(vec![a + j, b + j, b + next]);
            faces.push(vec![a + j, b + next, a + next]);
        }
        PageSolid { corners, faces, n_cells: None }
    }

    #[test]
    fn a_clustered_sphere_stays_a_sphere_of_fewer_faces() {
        let fine = sphere(100);
        let coarse = fine.clustered(16);
        assert!(coarse.faces.len() < fine.faces.len() / 4, "{} faces", coarse.faces.len());
        assert!(coarse.faces.len() > 300, "{} faces", coarse.faces.len());
        for corner in &coarse.corners {
            let radius = corner.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((radius - 1.0).abs() < 0.02, "{radius}");
        }
        assert!(coarse.faces.iter().flatten().all(|&corner| corner < coarse.corners.len()));
    }
}
