//! Depths in which shapes are painted in space: what is nearer to the eye hides what is behind it.
//!
//! Without perspective, of two convex shapes on the two sides of a plane the one on the side of the eye
//! is painted later, wherever their middles are. The faces of solids are the planes that are tried
//! (M. E. Newell, R. G. Newell and T. L. Sancha, *A solution to the hidden surface problem*, 1972).

use bksim_sim::pose::Pose;

use crate::geometry::{dot3, sub3, unit3};
use crate::{Form, Scene, Shape};

/// Solids above which they are painted by their middles alone: pairs grow with the square.
const MOST_SOLIDS: usize = 300;
/// Shapes may overlap by this part of a pin's radius and count as apart.
const OVERLAP: f64 = 0.3;

/// A shape in the world: all points within `radius` of the hull of `points`.
struct Placed {
    points: Vec<[f64; 3]>,
    radius: f64,
    /// Unit normals of its faces.
    normals: Vec<[f64; 3]>,
    is_solid: bool,
}

impl Placed {
    fn of(shape: &Shape, pose: &Pose) -> Self {
        let place = |points: &[[f64; 3]]| points.iter().map(|&p| pose.place(p)).collect::<Vec<_>>();
        let (points, radius, is_solid) = match &shape.form {
            Form::Region(rings) | Form::Section { rings, .. } => {
                (place(&rings.concat()), 0.0, false)
            }
            Form::Line { points, .. } => (place(points), 0.0, false),
            Form::Rod { ends, radius } => (place(ends), *radius, false),
            Form::Solid(solid) => (place(&solid.corners), 0.0, true),
        };
        let normals = match &shape.form {
            Form::Solid(solid) => solid.normals().map(|n| pose.turn(n)).collect(),
            _ => Vec::new(),
        };
        Self { points, radius, normals, is_solid }
    }

    /// Smallest and largest position along a direction.
    fn range(&self, n: [f64; 3]) -> [f64; 2] {
        let along = self.points.iter().map(|&p| dot3(n, p));
        let [low, high] = along
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        [low - self.radius, high + self.radius]
    }

    fn middle(&self) -> [f64; 3] {
        let n = self.points.len().max(1) as f64;
        std::array::from_fn(|i| self.points.iter().map(|p| p[i]).sum::<f64>() / n)
    }
}

/// The order of two shapes: `true` where the first is behind the second, `false` where it is in front, `None`
/// where neither hides the other or no plane tells.
fn is_behind(a: &Placed, b: &Placed, view: &[[f64; 3]; 3], overlap: f64) -> Option<bool> {
    let [right, up, eye] = *view;
    let is_apart = |n: [f64; 3]| {
        let ([low_a, high_a], [low_b, high_b]) = (a.range(n), b.range(n));
        high_a <= low_b || high_b <= low_a
    };
    if is_apart(right) || is_apart(up) {
        return None;
    }
    // The direction in which they are farthest apart, pointing from the first to the second.
    let between = unit3(sub3(b.middle(), a.middle()));
    let backwards = b.normals.iter().map(|&n| n.map(|x| -x));
    let tried = a.normals.iter().copied().chain(backwards).chain(between);
    let depth = [eye, eye.map(|x| -x)];
    let gap = |n: [f64; 3]| b.range(n)[0] - a.range(n)[1];
    let (gap, n) = tried
        .chain(depth)
        .map(|n| (gap(n), n))
        .max_by(|(one, _), (other, _)| one.total_cmp(other))?;
    let towards_eye = dot3(n, eye);
    (gap >= -overlap && towards_eye.abs() > 1e-6).then_some(towards_eye > 0.0)
}

impl Scene {
    /// Depths in which shapes are painted in space, m towards the eye, from the depths of their
    /// middles (`own`, by shape), the poses of the bodies and the rotation from the world to the view.
    /// Solids lie behind what they cannot hide, cut faces in front of all but signs. Signs lie in front of their own middle, and of the whole
    /// rod or solid that they are on, whose middle may be far away.
    pub fn depths(&self, own: &[f64], poses: &[Pose], view: &[[f64; 3]; 3]) -> Vec<f64> {
        let shapes = || self.shapes.iter().enumerate();
        let mut depths = own.to_vec();
        let n_solids = shapes().filter(|(_, shape)| matches!(shape.form, Form::Solid(_))).count();
        if (1..=MOST_SOLIDS).contains(&n_solids) {
            self.sort_solids(&mut depths, poses, view);
        }

        let is_face = |shape: &Shape| matches!(shape.form, Form::Section { .. });
        let behind = shapes().filter(|(_, shape)| !shape.role.is_in_front() && !is_face(shape));
        let front = behind.map(|(idx, _)| depths[idx]).fold(f64::NEG_INFINITY, f64::max);
        for (idx, _) in shapes().filter(|(_, shape)| is_face(shape)) {
            depths[idx] = front + self.pin;
        }

        let mut rods = vec![f64::NEG_INFINITY; self.bodies.len()];
        for (idx, shape) in shapes() {
            let is_round =
                matches!(shape.form, Form::Rod { .. } | Form::Solid(_) | Form::Section { .. });
            let is_rod = is_round && !shape.role.is_in_front();
            if let Some(rod) = rods.get_mut(shape.body).filter(|_| is_rod) {
                *rod = rod.max(depths[idx]);
            }
        }
        for (idx, shape) in shapes().filter(|(_, shape)| shape.role.is_in_front()) {
            let rod = rods.get(shape.body).copied().unwrap_or(own[idx]);
            depths[idx] = own[idx].max(rod) + self.pin;
        }
        depths
    }

    /// Raises the depths of shapes above those of the shapes that they hide.
    fn sort_solids(&self, depths: &mut [f64], poses: &[Pose], view: &[[f64; 3]; 3]) {
        let placed: Vec<(usize, Placed)> = (self.shapes.iter().enumerate())
            .filter(|(_, shape)| !shape.role.is_in_front())
            .filter(|(_, shape)| !matches!(shape.form, Form::Section { .. }))
            .filter_map(|(idx, shape)| Some((idx, Placed::of(shape, poses.get(shape.body)?))))
            .collect();
        // Which shapes are behind which.
        let n = placed.len();
        let mut before = vec![Vec::new(); n];
        let mut n_behind = vec![0_usize; n];
        for i in 0..n {
            for j in i + 1..n {
                let (a, b) = (&placed[i].1, &placed[j].1);
                if !(a.is_solid || b.is_solid) {
                    continue;
                }
                let Some(is_behind) = is_behind(a, b, view, OVERLAP * self.pin) else { continue };
                let (far, near) = if is_behind { (i, j) } else { (j, i) };
                before[far].push(near);
                n_behind[near] += 1;
            }
        }
        // From the back to the front; of a circle of shapes, that one first whose middle is farthest.
        let mut left: Vec<usize> = (0..n).collect();
        while !left.is_empty() {
            let depth = |&at: &usize| depths[placed[at].0];
            let first = |a: &usize, b: &usize| depth(a).total_cmp(&depth(b));
            let free = left.iter().copied().filter(|&at| n_behind[at] == 0).min_by(first);
            let Some(next) = free.or_else(|| left.iter().copied().min_by(first)) else { return };
            left.retain(|&at| at != next);
            let own = depths[placed[next].0];
            for &near in &before[next] {
                n_behind[near] = n_behind[near].saturating_sub(1);
                if left.contains(&near) {
                    let depth = &mut depths[placed[near].0];
                    *depth = depth.max(own + 1e-6 * self.pin);
                }
            }
        }
    }
}
