//! A run in its drawing: paths, envelopes, hodographs, reactions, ghosts.
//!
//! ```text
//! BK_TRACE_PATHS       the curve of each chosen point
//! BK_TRACE_ENVELOPE    the boundary of the region that each body sweeps
//! BK_TRACE_HODOGRAPH   the velocity of each chosen point as a curve, with its scale
//! BK_TRACE_REACTIONS   the forces in the joints at some times, with their scale
//! BK_TRACE_GHOSTS      the outlines of the bodies at some times
//! BK_TRACE_CURVES      curves of the whole motion: ways of points, with all that the run leaves out
//! BK_TRACE_CENTRODES   fixed and moving centrodes, these where the bodies are as drawn
//! BK_TRACE_REGIONS     swept regions and workspaces
//! ```

use bksim_analysis::union;
use bksim_sim::pose::PlanarPose;

use super::canvas::Mark;
use super::graft::Addition;
use super::symbol::arrow;
use crate::compose::Frame;
use crate::geometry::{Path, Point};

const PATHS: &str = "BK_TRACE_PATHS";
const ENVELOPE: &str = "BK_TRACE_ENVELOPE";
const HODOGRAPH: &str = "BK_TRACE_HODOGRAPH";
const REACTIONS: &str = "BK_TRACE_REACTIONS";
const GHOSTS: &str = "BK_TRACE_GHOSTS";

const CURVES: &str = "BK_TRACE_CURVES";
const CENTRODES: &str = "BK_TRACE_CENTRODES";
const REGIONS: &str = "BK_TRACE_REGIONS";

/// Layers with their colours.
const LAYERS: [(&str, u8); 8] = [
    (PATHS, 1),
    (ENVELOPE, 4),
    (HODOGRAPH, 6),
    (REACTIONS, 3),
    (GHOSTS, 8),
    (CURVES, 5),
    (CENTRODES, 30),
    (REGIONS, 94),
];

/// More corners than this does no curve need.
const MOST_CORNERS: usize = 2000;
/// Positions of a body whose union is taken.
const MOST_POSITIONS: usize = 240;

/// A body of the drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct BodyShape {
    /// Number of the body in the run, the ground 0.
    pub body_idx: usize,
    /// Curves in world axes, drawing units.
    pub paths: Vec<Path>,
    /// Frame as drawn.
    pub frame: Frame,
}

/// A point whose motion is drawn.
#[derive(Clone, PartialEq, Debug)]
pub struct Traced {
    /// Name as written: `rod.B`.
    pub name: String,
    /// Number of its body in the run.
    pub body_idx: usize,
    /// In the frame of the body, m.
    pub at: Point,
}

/// A joint's forces over the run.
#[derive(Clone, PartialEq, Debug)]
pub struct Reaction {
    /// Name of the reaction.
    pub name: String,
    /// Number of its second body, and its point there, m.
    pub body_idx: usize,
    /// In the frame of the second body, m.
    pub at: Point,
    /// On the second body in world axes, N, at each sample.
    pub force: Vec<Point>,
}

/// A curve of the whole motion.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionCurve {
    /// Name of the motion curve, written next to it.
    pub name: String,
    /// Kind of the motion curve, which chooses the layer.
    pub kind: CurveKind,
    /// Number of the body in whose frame it stands, the ground 0.
    pub body_idx: usize,
    /// Pieces in that frame, m.
    pub pieces: Vec<Vec<Point>>,
    /// True if each piece comes back to where it began.
    pub is_closed: bool,
}

/// Kind of a curve of the whole motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CurveKind {
    /// The way of a point.
    Way,
    /// Where an instant centre goes.
    Centrode,
    /// The boundary of a region.
    Region,
}

/// A run, sampled.
#[derive(Clone, PartialEq, Debug)]
pub struct Course {
    /// s, ascending.
    pub times: Vec<f64>,
    /// Of every body at each sample, the ground first.
    pub poses: Vec<Vec<PlanarPose>>,
    /// Points to be drawn.
    pub points: Vec<Traced>,
    /// Joints whose forces are drawn.
    pub reactions: Vec<Reaction>,
    /// Curves of the whole motion, which are drawn in any case.
    pub curves: Vec<MotionCurve>,
}

/// The parts of a run that are drawn.
#[derive(Clone, PartialEq, Debug)]
pub struct Selection {
    /// Paths of the points.
    pub paths: bool,
    /// Envelopes of the bodies.
    pub envelope: bool,
    /// Hodographs of the points.
    pub hodograph: bool,
    /// Numbers of the samples at which reactions are drawn.
    pub reactions: Vec<usize>,
    /// Numbers of the samples at which bodies are drawn.
    pub ghosts: Vec<usize>,
}

/// Draws a run; `per_metre` is the number of drawing units in a metre.
pub fn trace(
    course: &Course,
    shapes: &[BodyShape],
    selection: &Selection,
    per_metre: f64,
) -> Addition {
    let mut tracing = Tracing { course, shapes, per_metre, size: 0.0, marks: Vec::new() };
    let extent = tracing.extent();
    tracing.size = (extent[1][0] - extent[0][0]).hypot(extent[1][1] - extent[0][1]) / 40.0;
    if selection.paths {
        tracing.paths();
    }
    if selection.envelope {
        tracing.envelopes();
    }
    if selection.hodograph {
        tracing.hodographs(extent);
    }
    tracing.curves();
    tracing.reactions(&selection.reactions, extent);
    tracing.ghosts(&selection.ghosts);
    let is_used = |(layer, _): &(&str, u8)| tracing.marks.iter().any(|(of, _)| of == layer);
    Addition { layers: LAYERS.into_iter().filter(is_used).collect(), marks: tracing.marks }
}

/// A number in three digits: a label is read, not calculated with.
fn brief(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().expect("a printed number can be read");
    rounded.to_string()
}

/// `n` samples at even intervals of time, the first and the last among them.
pub fn even_samples(times: &[f64], n: usize) -> Vec<usize> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Vec::new() };
    let at = |i: usize| first + (last - first) * i as f64 / (n.max(2) - 1) as f64;
    let mut samples: Vec<usize> = (0..n).map(|i| nearest_sample(times, at(i))).collect();
    samples.dedup();
    samples
}

/// The sample nearest to a time.
pub fn nearest_sample(times: &[f64], t: f64) -> usize {
    let off = |idx: &usize| (times[*idx] - t).abs();
    (0..times.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
}

/// The drawing of a run as far as it has come.
struct Tracing<'a> {
    course: &'a Course,
    shapes: &'a [BodyShape],
    per_metre: f64,
    /// Of arrow heads and letters, drawing units.
    size: f64,
    marks: Vec<(&'static str, Mark)>,
}

impl Tracing<'_> {
    fn drawn(&self, [x, y]: Point) -> Point {
        [self.per_metre * x, self.per_metre * y]
    }

    fn draw(&mut self, layer: &'static str, mark: Mark) {
        self.marks.push((layer, mark));
    }

    /// About `most` samples, the last one among them.
    fn thinned(&self, most: usize) -> Vec<usize> {
        let n = self.course.times.len();
        let stride = n.div_ceil(most).max(1);
        let mut samples: Vec<usize> = (0..n).step_by(stride).collect();
        if samples.last().is_some_and(|&last| last + 1 < n) {
            samples.push(n - 1);
        }
        samples
    }

    /// Lower left and upper right corner of the shapes and the paths.
    fn extent(&self) -> [Point; 2] {
        let mut extent = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let mut reach = |p: Point| {
            for i in 0..2 {
                extent[0][i] = extent[0][i].min(p[i]);
                extent[1][i] = extent[1][i].max(p[i]);
            }
        };
        for path in self.shapes.iter().flat_map(|shape| &shape.paths) {
            path.flattened(1.0).into_iter().for_each(&mut reach);
        }
        for point in &self.course.points {
            self.path(point).into_iter().for_each(&mut reach);
        }
        if extent[0][0] <= extent[1][0] { extent } else { [[0.0; 2], [1.0; 2]] }
    }

    fn path(&self, point: &Traced) -> Vec<Point> {
        let samples = self.thinned(MOST_CORNERS);
        let at = |idx: &usize| self.drawn(self.course.poses[*idx][point.body_idx].place(point.at));
        samples.iter().map(at).collect()
    }

    fn paths(&mut self) {
        for point in &self.course.points {
            let path = self.path(point);
            self.draw(PATHS, Mark::chain(&path, false));
            if let Some(&[x, y]) = path.first() {
                let at = [x + 0.4 * self.size, y + 0.4 * self.size];
                self.draw(PATHS, Mark::text(at, 0.7 * self.size, point.name.clone()));
            }
        }
    }

    /// The closed outlines of a body in its frame, as polygons.
    fn polygons(&self, shape: &BodyShape) -> Vec<Vec<Point>> {
        let tolerance = 1e-2 * self.size;
        let closed = shape.paths.iter().filter(|path| path.is_closed);
        let inward = |p: Point| shape.frame.point_inward(p);
        closed.map(|path| path.flattened(tolerance).into_iter().map(inward).collect()).collect()
    }

    /// A polygon in the frame of a body, at a sample.
    fn placed(&self, body_idx: usize, sample: usize, polygon: &[Point]) -> Vec<Point> {
        let pose = &self.course.poses[sample][body_idx];
        let drawn =
            |&[x, y]: &Point| self.drawn(pose.place([x / self.per_metre, y / self.per_metre]));
        polygon.iter().map(drawn).collect()
    }

    fn envelopes(&mut self) {
        let samples = self.thinned(MOST_POSITIONS);
        for shape in self.shapes.iter().filter(|shape| shape.body_idx > 0) {
            let polygons = self.polygons(shape);
            let swept: Vec<Vec<Point>> = samples
                .iter()
                .flat_map(|&sample| polygons.iter().map(move |polygon| (sample, polygon)))
                .map(|(sample, polygon)| self.placed(shape.body_idx, sample, polygon))
                .collect();
            if swept.is_empty() {
                continue;
            }
            for boundary in union(&swept) {
                self.draw(ENVELOPE, Mark::chain(&boundary, true));
            }
        }
    }

    /// Curves of the whole motion; those of moving bodies where these are at the first sample.
    fn curves(&mut self) {
        for curve in &self.course.curves {
            let layer = match curve.kind {
                CurveKind::Way => CURVES,
                CurveKind::Centrode => CENTRODES,
                CurveKind::Region => REGIONS,
            };
            let Some(pose) = self.course.poses.first().and_then(|of| of.get(curve.body_idx)) else {
                continue;
            };
            for piece in &curve.pieces {
                let drawn: Vec<Point> = piece.iter().map(|p| self.drawn(pose.place(*p))).collect();
                self.marks.push((layer, Mark::chain(&drawn, curve.is_closed)));
            }
            let first = curve.pieces.first().and_then(|piece| piece.first());
            if let Some(first) = first {
                let [x, y] = self.drawn(pose.place(*first));
                let at = [x + 0.4 * self.size, y + 0.4 * self.size];
                self.marks.push((layer, Mark::text(at, 0.7 * self.size, curve.name.clone())));
            }
        }
    }

    fn ghosts(&mut self, samples: &[usize]) {
        for &sample in samples {
            for shape in self.shapes.iter().filter(|shape| shape.body_idx > 0) {
                for polygon in self.polygons(shape) {
                    let placed = self.placed(shape.body_idx, sample, &polygon);
                    self.draw(GHOSTS, Mark::chain(&placed, true));
                }
            }
        }
    }

    /// One velocity plane per point, in a row below the drawing; all to one scale.
    fn hodographs(&mut self, [low, high]: [Point; 2]) {
        let samples = self.thinned(MOST_CORNERS);
        let velocities: Vec<(String, Vec<Point>)> = self
            .course
            .points
            .iter()
            .map(|point| {
                let of =
                    |&idx: &usize| self.course.poses[idx][point.body_idx].velocity_of(point.at);
                (point.name.clone(), samples.iter().map(of).collect())
            })
            .collect();
        let all = velocities.iter().flat_map(|(_, curve)| curve);
        let fastest = all.fold(0.0, |most: f64, [x, y]| most.max(x.hypot(*y)));
        if fastest == 0.0 {
            return;
        }
        let room = (high[0] - low[0]).max(high[1] - low[1]) / 5.0;
        let per_unit = round_scale(fastest / room);
        let reach = fastest / per_unit;
        for (idx, (name, curve)) in velocities.into_iter().enumerate() {
            let pole =
                [low[0] + reach + 2.6 * reach * idx as f64, low[1] - 1.6 * reach - 4.0 * self.size];
            let end = |[x, y]: &Point| [pole[0] + x / per_unit, pole[1] + y / per_unit];
            let curve: Vec<Point> = curve.iter().map(end).collect();
            let axes = [
                Mark::Line([pole[0] - reach, pole[1]], [pole[0] + reach, pole[1]]),
                Mark::Line([pole[0], pole[1] - reach], [pole[0], pole[1] + reach]),
            ];
            for axis in axes {
                self.draw(HODOGRAPH, axis);
            }
            self.draw(HODOGRAPH, Mark::chain(&curve, false));
            let (x, y) = (pole[0] - reach, pole[1] - reach - 1.2 * self.size);
            let title = format!("velocity of {name}");
            self.draw(HODOGRAPH, Mark::text([x, y], 0.7 * self.size, title));
            let scale = format!("1 unit = {per_unit} m/s");
            let below = [x, y - 1.1 * self.size];
            self.draw(HODOGRAPH, Mark::text(below, 0.7 * self.size, scale));
        }
    }

    /// Forces on the second bodies, as arrows where the joints are.
    fn reactions(&mut self, samples: &[usize], [low, high]: [Point; 2]) {
        let reactions = &self.course.reactions;
        let chosen = |reaction: &Reaction| samples.iter().map(|&i| reaction.force[i]).collect();
        let forces: Vec<Vec<Point>> = reactions.iter().map(chosen).collect();
        let strongest =
            forces.iter().flatten().fold(0.0, |most: f64, [x, y]| most.max(x.hypot(*y)));
        if strongest == 0.0 {
            return;
        }
        let room = (high[0] - low[0]).hypot(high[1] - low[1]) / 6.0;
        let per_unit = round_scale(strongest / room);
        for (reaction, forces) in reactions.iter().zip(forces) {
            for (&sample, [x, y]) in samples.iter().zip(forces) {
                let at = self.course.poses[sample][reaction.body_idx].place(reaction.at);
                let from = self.drawn(at);
                let to = [from[0] + x / per_unit, from[1] + y / per_unit];
                for mark in arrow(from, to, 0.8 * self.size) {
                    self.draw(REACTIONS, mark);
                }
                let t = self.course.times[sample];
                let force = brief(x.hypot(y));
                let words = format!("{} {force} N, {} s", reaction.name, brief(t));
                let next_to_head = [to[0] + 0.2 * self.size, to[1] + 0.2 * self.size];
                self.draw(REACTIONS, Mark::text(next_to_head, 0.4 * self.size, words));
            }
        }
        let words = format!("forces in joints on their second bodies: 1 unit = {per_unit} N");
        let above = [low[0], high[1] + 2.0 * self.size];
        self.draw(REACTIONS, Mark::text(above, 0.7 * self.size, words));
    }
}

/// The next larger number of the series 1, 2, 5, 10, …
fn round_scale(scale: f64) -> f64 {
    let decade = 10_f64.powf(scale.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let step = steps.into_iter().find(|step| step * decade >= scale * (1.0 - 1e-9));
    // 10⁻³ times 2 is not 0.002 to the last digit; its text is.
    let rounded = step.unwrap_or(10.0) * decade;
    format!("{rounded:.3e}").parse().expect("a printed number can be read")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round_and_leave_no_arrow_too_long() {
        for (scale, round) in [(0.0021, 0.005), (1.0, 1.0), (19.0, 20.0), (7e3, 1e4), (0.2, 0.2)] {
            assert_eq!(round_scale(scale), round);
        }
    }

    #[test]
    fn even_samples_begin_and_end_with_the_run() {
        let times: Vec<f64> = (0..=100).map(|i| 0.02 * f64::from(i)).collect();
        assert_eq!(even_samples(&times, 5), [0, 25, 50, 75, 100]);
        assert_eq!(nearest_sample(&times, 0.509), 25);
    }
}
