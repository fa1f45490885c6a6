//! Outermost points of a mechanism over a run.

use bksim::playback::Playback;
use bksim_scene::{Attached, CordPlace, Scene};

/// Number of instants of a run that are examined, both ends included.
pub(super) const INSTANTS: usize = 61;

/// The instant of an index, s.
pub(super) fn instant([first, last]: [f64; 2], idx: usize) -> f64 {
    first + (last - first) * idx as f64 / (INSTANTS - 1) as f64
}

/// The outermost points of every body, at instants over the run.
pub(super) fn over_run(playback: &mut Playback, scene: &Scene) -> Vec<[f64; 3]> {
    let outermost = outermost(scene);
    let mut points = Vec::new();
    for poses in playback.poses_over_run(INSTANTS) {
        for (pose, of_body) in poses.iter().zip(&outermost) {
            points.extend(of_body.iter().map(|&p| pose.place(p)));
        }
    }
    points
}

/// By body, the points that lie farthest in some direction.
fn outermost(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
    let mut of_body: Vec<Vec<[f64; 3]>> = vec![Vec::new(); scene.bodies.len()];
    let mut add = |body: usize, points: &[[f64; 3]]| {
        if let Some(known) = of_body.get_mut(body) {
            known.extend(points.iter().filter(|p| p.iter().all(|x| x.is_finite())));
        }
    };
    for shape in &scene.shapes {
        add(shape.body, &shape.form.reach());
    }
    scene.spans.iter().flat_map(|span| span.ends).for_each(|end| add(end.body, &[end.position]));
    for place in scene.cords.iter().flat_map(|cord| &cord.places) {
        let CordPlace { at: Attached { body, position: [x, y, z] }, radius: r, .. } = *place;
        add(body, &[[x - r, y, z], [x + r, y, z], [x, y - r, z], [x, y + r, z]]);
    }
    of_body.iter().map(|points| farthest(points)).collect()
}

/// The farthest points in the directions to the middles, edges and corners of a cube, and in those
/// halfway between them in the plane.
fn farthest(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let steps = [-1.0, 0.0, 1.0];
    let cube = steps.iter().flat_map(|&x| steps.iter().map(move |&y| (x, y)));
    let cube = cube.flat_map(|(x, y)| steps.iter().map(move |&z| [x, y, z]));
    let (sin, cos) = std::f64::consts::FRAC_PI_8.sin_cos();
    let between = [[cos, sin], [sin, cos], [-sin, cos], [-cos, sin]];
    let between = between.iter().flat_map(|&[x, y]| [[x, y, 0.0], [-x, -y, 0.0]]);
    let mut found: Vec<usize> = Vec::new();
    for d in cube.filter(|d| *d != [0.0; 3]).chain(between) {
        let along = |p: &[f64; 3]| d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
        let far = points.iter().enumerate().max_by(|(_, a), (_, b)| along(a).total_cmp(&along(b)));
        found.extend(far.map(|(idx, _)| idx));
    }
    found.sort_unstable();
    found.dedup();
    found.into_iter().map(|idx| points[idx]).collect()
}
