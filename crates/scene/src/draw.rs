//! From a scene and the poses of its bodies to a picture.

use bksim_mbs::pose::Pose;

use crate::{Align, Camera, Color, Form, Item, Picture, Scene, Stroke, Theme};

/// What is drawn beside the mechanism.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Extras {
    /// Ways of points through the world, the oldest first.
    pub trails: Vec<(Color, Vec<[f64; 3]>)>,
    /// Arrows from a point of the world along a vector of it, both m.
    pub arrows: Vec<(Color, [f64; 3], [f64; 3])>,
    /// Whether markers have their names beside them.
    pub has_labels: bool,
    /// Poses at other instants, drawn faintly behind.
    pub ghosts: Vec<Vec<Pose>>,
}

/// What `camera` sees of `scene` when its bodies are at `poses`.
pub fn picture(
    scene: &Scene,
    poses: &[Pose],
    extras: &Extras,
    camera: &Camera,
    theme: &Theme,
) -> Picture {
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    let pixel = |p: [f64; 3]| {
        let [x, y, _] = camera.project(p);
        [x as f32, y as f32]
    };
    let mut items = Vec::new();
    for (color, points) in &extras.trails {
        let stroke = Stroke { color: *color, width: 1.5 };
        let points = points.iter().map(|&p| pixel(p)).collect();
        items.push(Item::Line { points, is_closed: false, stroke });
    }
    for shape in &scene.shapes {
        let Some(pose) = poses.get(shape.body) else { continue };
        let paint = theme.paint(shape.role);
        let placed = |ring: &Vec<[f64; 3]>| -> Vec<[f32; 2]> {
            ring.iter().map(|&p| pixel(pose.place(p))).collect()
        };
        let (rings, is_closed) = match &shape.form {
            Form::Region(rings) => (rings.iter().map(placed).collect(), true),
            Form::Line { points, is_closed } => (vec![placed(points)], *is_closed),
        };
        if let (Some(fill), Form::Region(_)) = (paint.fill, &shape.form) {
            items.push(Item::Region { rings: rings.clone(), fill });
        }
        if let Some(stroke) = paint.stroke {
            items.extend(rings.into_iter().map(|points| Item::Line { points, is_closed, stroke }));
        }
    }
    if extras.has_labels {
        for marker in &scene.markers {
            let Some(pose) = poses.get(marker.at.body) else { continue };
            let [x, y] = pixel(pose.place(marker.at.position));
            let (text, color) = (marker.name.clone(), theme.text);
            let at = [x + 8.0, y - 8.0];
            items.push(Item::Text { at, align: Align::Start, text, size: 13.0, color });
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    let size = camera.size.map(|x| x as f32);
    Picture { size, background: Some(theme.background), items }
}
