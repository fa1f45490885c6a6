//! The plane cut along curves into cells, each of which a point reaches as a whole or not at all.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::slice::FloatSlice;

use crate::region::doubled_area;

type Place = [f64; 2];

/// Distance within which the end of a curve belongs to another one, longest links: chords leave their curve by less.
const JOINS: f64 = 3e-4;
/// Radius of cells that are left out, longest links: curves on each other leave such between their chords.
const SLIVER: f64 = 1e-4;
/// Lines of the plane along which the middle of a cell is looked for.
const N_LINES: usize = 24;

/// A cell of the plane: its outer ring, then its holes.
pub(super) struct Cell {
    pub(super) rings: Vec<Vec<Place>>,
    /// A place far from its boundary, and how far.
    pub(super) middle: Place,
    pub(super) radius: f64,
}

/// The cells that curves enclose, those too thin to hold a place left out.
pub(super) fn cells(ways: &[Vec<Place>], size: f64) -> Vec<Cell> {
    let ways = joined(ways, size);
    let all = || ways.iter().flatten();
    let low = [0, 1].map(|i| all().fold(f64::INFINITY, |a, p| a.min(p[i])) - size);
    let high = [0, 1].map(|i| all().fold(f64::NEG_INFINITY, |a, p| a.max(p[i])) + size);
    if !low.iter().chain(&high).all(|x| x.is_finite()) {
        return Vec::new();
    }
    let plane = vec![low, [high[0], low[1]], high, [low[0], high[1]]];
    let found = plane.slice_by_as::<i64>(&ways, FillRule::NonZero);
    let cell = |rings: Vec<Vec<Place>>| {
        let (middle, radius) = middle(&rings)?;
        (radius > SLIVER * size).then_some(Cell { rings, middle, radius })
    };
    // What the frame of the plane bounds is out of reach.
    let is_outside = |rings: &Vec<Vec<Place>>| {
        rings
            .iter()
            .flatten()
            .any(|p| (0..2).any(|i| p[i] < low[i] + 0.5 * size || p[i] > high[i] - 0.5 * size))
    };
    found.into_iter().filter(|rings| !is_outside(rings)).filter_map(cell).collect()
}

/// The boundary of cells together: closed curves, the region on their left.
pub(super) fn boundary(cells: &[Cell], size: f64) -> Vec<Vec<Place>> {
    let shapes: Vec<Vec<Vec<Place>>> = cells.iter().map(|cell| cell.rings.clone()).collect();
    let rings = shapes.simplify_shape_as::<i64>(FillRule::NonZero).into_iter().flatten();
    // Between curves on each other.
    let is_sliver = |ring: &Vec<Place>| {
        let round: f64 = sides(ring).map(|[a, b]| length([b[0] - a[0], b[1] - a[1]])).sum();
        doubled_area(ring).abs() <= SLIVER * size * round
    };
    let closed = |mut ring: Vec<Place>| {
        ring.extend(ring.first().copied());
        ring
    };
    rings.filter(|ring| !is_sliver(ring)).map(closed).collect()
}

impl Cell {
    /// True if a place lies in the cell, a part of its radius away from its boundary.
    pub(super) fn holds(&self, p: Place, part: f64) -> bool {
        is_inside(&self.rings, p) && distance(&self.rings, p) >= part * self.radius
    }

    /// True if a place lies in the cell or on its boundary.
    pub(super) fn has(&self, p: Place) -> bool {
        is_inside(&self.rings, p)
    }
}

/// Curves with the ends of each as points of those that they end on.
fn joined(ways: &[Vec<Place>], size: f64) -> Vec<Vec<Place>> {
    let near = JOINS * size;
    let mut all = ways.to_vec();
    for (of, way) in ways.iter().enumerate() {
        let [Some(&first), Some(&last)] = [way.first(), way.last()] else { continue };
        let is_closed = way.len() > 2 && length([last[0] - first[0], last[1] - first[1]]) <= near;
        if is_closed {
            all[of].push(first);
            continue;
        }
        for end in [first, last] {
            for (_, other) in all.iter_mut().enumerate().filter(|(k, _)| *k != of) {
                let nearest = (1..other.len())
                    .map(|i| (i, to_side([other[i - 1], other[i]], end)))
                    .min_by(|a, b| a.1.total_cmp(&b.1));
                if let Some((i, off)) = nearest
                    && off <= near
                {
                    other.insert(i, end);
                }
            }
        }
    }
    all
}

fn length(v: Place) -> f64 {
    v[0].hypot(v[1])
}

fn sides(ring: &[Place]) -> impl Iterator<Item = [Place; 2]> + '_ {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// Distance from a place to a line between two.
fn to_side([a, b]: [Place; 2], p: Place) -> f64 {
    let (u, d) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = u[0] * u[0] + u[1] * u[1];
    let share = if square > 0.0 { (d[0] * u[0] + d[1] * u[1]) / square } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    length([d[0] - share * u[0], d[1] - share * u[1]])
}

fn distance(rings: &[Vec<Place>], p: Place) -> f64 {
    rings
        .iter()
        .flat_map(|ring| sides(ring))
        .map(|side| to_side(side, p))
        .fold(f64::INFINITY, f64::min)
}

fn is_inside(rings: &[Vec<Place>], p: Place) -> bool {
    let crosses = |[a, b]: &[Place; 2]| {
        (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    rings.iter().flat_map(|ring| sides(ring)).filter(crosses).count() % 2 == 1
}

/// A place far from the boundary of a region, and how far: the best of the middles of lines across it.
fn middle(rings: &[Vec<Place>]) -> Option<(Place, f64)> {
    let mut best: Option<(Place, f64)> = None;
    for axis in [0, 1] {
        let along = 1 - axis;
        let values = || rings.iter().flatten().map(|p| p[axis]);
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        for k in 0..N_LINES {
            let at = low + (high - low) * (k as f64 + 0.5) / N_LINES as f64;
            let mut met: Vec<f64> = rings
                .iter()
                .flat_map(|ring| sides(ring))
                .filter(|[a, b]| (a[axis] > at) != (b[axis] > at))
                .map(|[a, b]| {
                    a[along] + (at - a[axis]) / (b[axis] - a[axis]) * (b[along] - a[along])
                })
                .collect();
            met.sort_by(f64::total_cmp);
            for pair in met.chunks_exact(2) {
                let mut p = [0.0; 2];
                (p[axis], p[along]) = (at, 0.5 * (pair[0] + pair[1]));
                let radius = distance(rings, p);
                if best.is_none_or(|(_, known)| radius > known) {
                    best = Some((p, radius));
                }
            }
        }
    }
    best
}
