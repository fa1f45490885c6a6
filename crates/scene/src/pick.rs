//! Picking: the place of a body under a pixel.

use bksim_sim::pose::Pose;

use crate::geometry::{Point, distance_from_edges, is_inside};
use crate::{Attached, Camera, Form, Scene, Shape};

/// A place of a body under a pixel.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Picked {
    /// In the frame of the body.
    pub at: Attached,
    /// In the world, m.
    pub world: [f64; 3],
}

impl Scene {
    /// The uppermost shape of a body that moves which covers a pixel, or has an edge within `reach` pixels of it.
    pub fn pick(
        &self,
        camera: &Camera,
        poses: &[Pose],
        pixel: [f64; 2],
        reach: f64,
    ) -> Option<Picked> {
        let shapes = self.shapes.iter().rev().filter(|shape| shape.body != 0);
        shapes.into_iter().find_map(|shape| {
            let pose = poses.get(shape.body)?;
            let middle = middle_if_covered(camera, shape, pose, pixel, reach)?;
            let world = camera.unproject_like(pixel, pose.place(middle));
            let at = Attached { body: shape.body, position: local(pose, world) };
            Some(Picked { at, world })
        })
    }
}

/// The middle of a shape that is under a pixel, in the frame of its body.
fn middle_if_covered(
    camera: &Camera,
    shape: &Shape,
    pose: &Pose,
    pixel: Point,
    reach: f64,
) -> Option<[f64; 3]> {
    let seen = |points: &[[f64; 3]]| -> Vec<Point> {
        let seen = points.iter().map(|p| camera.project(pose.place(*p)));
        seen.map(|[x, y, _]| [x, y]).collect()
    };
    let is_near =
        |line: &[Point]| line.windows(2).any(|edge| distance_from_edges(pixel, edge) <= reach);
    let (is_covered, points): (bool, Vec<[f64; 3]>) = match &shape.form {
        Form::Region(rings) => {
            let all: Vec<Vec<Point>> = rings.iter().map(|ring| seen(ring)).collect();
            let is_at_edge = all.iter().any(|ring| distance_from_edges(pixel, ring) <= reach);
            (is_at_edge || is_inside(pixel, &all), rings.first()?.clone())
        }
        Form::Line { points, is_closed: true } => {
            (distance_from_edges(pixel, &seen(points)) <= reach, points.clone())
        }
        Form::Line { points, is_closed: false } => (is_near(&seen(points)), points.clone()),
        Form::Rod { ends, radius } => {
            let away = distance_from_edges(pixel, &seen(ends));
            (away <= reach.max(radius * camera.scale), ends.to_vec())
        }
        Form::Solid(solid) => {
            let corners = seen(&solid.corners);
            let covers = |face: &Vec<usize>| {
                let ring = face.iter().map(|&corner| corners[corner]).collect();
                is_inside(pixel, &[ring])
            };
            (solid.faces.iter().any(covers), solid.corners.clone())
        }
        Form::Section { .. } => return None,
    };
    let n = points.len().max(1) as f64;
    is_covered.then(|| std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n))
}

/// A place of the world in the frame of a body.
fn local(pose: &Pose, world: [f64; 3]) -> [f64; 3] {
    let d: [f64; 3] = std::array::from_fn(|i| world[i] - pose.origin[i]);
    std::array::from_fn(|j| (0..3).map(|i| pose.r_world_from_body[i][j] * d[i]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Role;

    #[test]
    fn bodies_are_found_at_their_lines_and_in_their_regions() {
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let role = Role::Body(0);
        let region = Shape { body: 1, role, form: Form::Region(vec![square.to_vec()]) };
        let rod = Form::Rod { ends: [[-1.0, 0.0, 0.0], [-1.0, 1.0, 0.0]], radius: 0.1 };
        let shapes = vec![region, Shape { body: 2, role, form: rod }];
        let scene = Scene { shapes, ..Scene::default() };
        let camera = Camera { scale: 100.0, ..Camera::planar([400.0, 400.0]) };
        let mut poses = [Pose::default(); 3];
        let found = |poses: &[Pose], x, y| scene.pick(&camera, poses, [x, y], 8.0);
        let inside = found(&poses, 250.0, 150.0).expect("the square");
        assert_eq!((inside.at.body, inside.at.position), (1, [0.5, 0.5, 0.0]));
        assert_eq!(found(&poses, 109.0, 150.0).map(|picked| picked.at.body), Some(2));
        assert_eq!(found(&poses, 150.0, 150.0), None);
        // In the frame of a body that has turned by a quarter.
        poses[1].r_world_from_body = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let turned = found(&poses, 150.0, 175.0).expect("the square");
        let [x, y, _] = turned.at.position;
        assert!((x - 0.25).hypot(y - 0.5) < 1e-12, "{turned:?}");
    }
}
