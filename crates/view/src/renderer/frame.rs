//! [`Drawing`]: the contents of one frame, in the order of painting.

use std::ops::Range;

use bksim::sim::pose::Pose;
use bksim_scene::{Extras, Form, HalfSpace, Item, Scene, SeenFace, Stroke, picture};
use bytemuck::{Pod, Zeroable};

use super::Frame;
use super::fixed::{Builder, Fixed, middle, middles};
use super::primitive::{Primitive, count, single};

/// The map from the frame of a body to pixels of the target.
#[derive(Clone, Copy, PartialEq, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Placement {
    /// Row of x, pixels: three factors for a point of the body, and x of the anchor.
    x: [f32; 4],
    /// Row of y, pixels, downwards.
    y: [f32; 4],
}

/// The mechanism, or a ghost of it.
#[derive(Clone, Copy, PartialEq, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Layer {
    first_placement: u32,
    opacity: f32,
}

/// Values that all primitives of a frame share.
#[derive(Clone, Copy, PartialEq, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Globals {
    /// Width and height, pixels.
    size: [f32; 2],
    pixels_per_point: f32,
    n_fixed: u32,
    /// Whether indices of runs count [`Drawing::order`], and not primitives themselves.
    is_ordered: u32,
    /// Scale of the radii of rods.
    pixels_per_metre: f32,
}

/// Primitives that are painted one after the other, by one draw call.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Run {
    pub(super) layer: u32,
    /// Indices of primitives, first all fixed and then all moving ones; in space, indices into
    /// [`Drawing::order`].
    pub(super) indices: Range<u32>,
}

/// A scene whose shapes have primitives.
struct Shapes<'a> {
    scene: &'a Scene,
    /// By shape, the indices of its primitives.
    ranges: &'a [Range<u32>],
    /// By shape, the middle of its points in the frame of its body, m.
    middles: &'a [[f64; 3]],
}

/// The data of one frame for the graphics card. Buffers are kept from frame to frame.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Drawing {
    pub(super) globals: Globals,
    pub(super) placements: Vec<Placement>,
    pub(super) layers: Vec<Layer>,
    pub(super) moving: Vec<Primitive>,
    /// Draw calls, from the back to the front.
    pub(super) runs: Vec<Run>,
    /// In space, primitives by their depth; empty in a plane, where the scene's order is that of
    /// painting.
    pub(super) order: Vec<u32>,
    /// Words, in points: they are not made of primitives.
    pub(super) words: Vec<Item>,
    /// Parts of the mechanism, by their depth, m towards the eye.
    parts: Vec<(f64, Range<u32>)>,
    /// The scene without shapes and spans: a picture of it has only arrows and names.
    bare: Scene,
}

/// Vertices of a primitive: two triangles.
pub(super) const VERTICES: u32 = 6;

/// Opacity of a ghost, as in pictures of [`bksim_scene::picture`].
const GHOST: f32 = 0.22;

impl Drawing {
    /// Takes another scene.
    pub(super) fn set_scene(&mut self, scene: &Scene) {
        self.bare = scene.without_drawing();
    }

    /// Composes a frame: ghosts, trails, the mechanism, arrows, from the back to the front.
    pub(super) fn compose(&mut self, scene: &Scene, fixed: &Fixed, frame: &Frame<'_>) {
        let size = frame.camera.size.map(|x| single(x) * frame.pixels_per_point);
        self.globals = Globals {
            size,
            pixels_per_point: frame.pixels_per_point,
            n_fixed: count(fixed.primitives.len()),
            is_ordered: u32::from(!scene.is_planar),
            pixels_per_metre: single(frame.camera.scale) * frame.pixels_per_point,
        };
        self.placements.clear();
        self.layers.clear();
        self.moving.clear();
        self.runs.clear();
        self.order.clear();
        self.words.clear();

        let [_, _, eye] = frame.camera.r_view_from_world;
        let half = scene.half(frame.extras.section, eye);
        let cut = half.map(|half| frame.extras.cut(&half));
        let extras = cut.as_ref().unwrap_or(frame.extras);
        let frame = &Frame { extras, ..*frame };
        let layer = self.add_layer(fixed, frame, frame.poses, 1.0);
        for poses in &frame.extras.ghosts {
            let ghost = self.add_layer(fixed, frame, poses, GHOST);
            self.cut_mechanism(scene, fixed, &Frame { poses, ..*frame }, half, ghost);
        }
        let Extras { trails, arrows, has_labels, legend, words, .. } = extras;
        if !trails.is_empty() {
            let world = world(fixed, frame);
            for (color, points) in trails {
                let stroke = Stroke { color: *color, width: frame.theme.sizes.trail };
                let range = self.moved(world, |to| to.fading(points, stroke));
                self.paint(range, layer);
            }
        }
        self.cut_mechanism(scene, fixed, frame, half, layer);
        if !arrows.is_empty() || *has_labels || !words.is_empty() {
            let (arrows, has_labels, legend) = (arrows.clone(), *has_labels, legend.clone());
            let (section, words) = (extras.section, words.clone());
            let extras = Extras { arrows, has_labels, legend, section, words, ..Extras::default() };
            self.overlay(fixed, frame, &extras, layer);
        }
    }

    /// Adds the part of the mechanism in a half of space, all of it if none is given. What is cut changes with the
    /// motion: all its primitives are made again.
    fn cut_mechanism(
        &mut self,
        scene: &Scene,
        fixed: &Fixed,
        frame: &Frame<'_>,
        half: Option<HalfSpace>,
        layer: u32,
    ) {
        let Some(half) = half else {
            let shapes = Shapes { scene, ranges: &fixed.ranges, middles: &fixed.middles };
            self.mechanism(&shapes, fixed, frame, layer);
            return;
        };
        let [_, _, eye] = frame.camera.r_view_from_world;
        let cut = scene.cut(&half, frame.poses, eye);
        let made = cut.shapes.iter().map(|shape| {
            let anchor = fixed.anchors.get(shape.body).copied().unwrap_or_default();
            self.moved((count(shape.body), anchor), |to| to.shape(shape, frame.theme))
        });
        let ranges: Vec<Range<u32>> = made.collect();
        let shapes = Shapes { scene: &cut, ranges: &ranges, middles: &middles(&cut) };
        self.mechanism(&shapes, fixed, frame, layer);
    }

    /// Adds shapes and spans from back to front: in the scene's order with spans below the shapes
    /// [in front](bksim_scene::Role::is_in_front), in space by depth.
    fn mechanism(&mut self, shapes: &Shapes<'_>, fixed: &Fixed, frame: &Frame<'_>, layer: u32) {
        let (&Shapes { scene, ranges, middles }, poses) = (shapes, frame.poses);
        if scene.is_planar {
            // The buffer of fixed primitives has this order; solids stand between them in it.
            let mut solids = Vec::new();
            self.solids(scene, fixed, frame, |_, shape, range| {
                solids.push((ranges[shape].start, range));
            });
            let mut done = 0;
            for (first, range) in solids {
                let first = first.min(fixed.n_back);
                self.paint(done..first, layer);
                self.paint(range, layer);
                done = first;
            }
            self.paint(done..fixed.n_back, layer);
            self.spans(scene, fixed, frame, |drawing, _, range| drawing.paint(range, layer));
            self.paint(fixed.n_back..self.globals.n_fixed, layer);
            return;
        }
        let depth = |p: [f64; 3]| frame.camera.project(p)[2];
        let own = scene.shapes.iter().zip(middles).map(|(shape, &middle)| {
            poses.get(shape.body).map_or(f64::NEG_INFINITY, |pose| depth(pose.place(middle)))
        });
        let view = &frame.camera.r_view_from_world;
        let depths = scene.depths(&own.collect::<Vec<_>>(), poses, view);
        let mut parts = std::mem::take(&mut self.parts);
        parts.clear();
        parts.extend(depths.iter().copied().zip(ranges.iter().cloned()));
        self.solids(scene, fixed, frame, |_, shape, range| {
            parts.push((depths[shape], range));
        });
        self.spans(scene, fixed, frame, |_, points, range| {
            parts.push((depth(middle(points)), range));
        });
        parts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        for (_, range) in &parts {
            self.paint(range.clone(), layer);
        }
        self.parts = parts;
    }

    /// Adds the primitives of solids as the camera sees them, and passes the index of the shape and the
    /// indices of its primitives to `add`.
    fn solids(
        &mut self,
        scene: &Scene,
        fixed: &Fixed,
        frame: &Frame<'_>,
        mut add: impl FnMut(&mut Self, usize, Range<u32>),
    ) {
        let world = world(fixed, frame);
        for (idx, shape) in scene.shapes.iter().enumerate() {
            let (Form::Solid(solid), Some(pose)) = (&shape.form, frame.poses.get(shape.body))
            else {
                continue;
            };
            let paint = frame.theme.paint(shape.role);
            let faces = solid.seen(|p| pose.place(p), frame.camera);
            let range = self.moved(world, |to| {
                for SeenFace { ring, shade, edges } in faces {
                    to.region(&[ring], paint.shaded(shade), None);
                    for edge in edges {
                        if let Some(stroke) = paint.stroke {
                            to.line(&edge, false, stroke);
                        }
                    }
                }
            });
            add(self, idx, range);
        }
    }

    /// Adds the primitives of spans and ropes, and passes their points and indices to `add`.
    fn spans(
        &mut self,
        scene: &Scene,
        fixed: &Fixed,
        frame: &Frame<'_>,
        mut add: impl FnMut(&mut Self, &[[f64; 3]], Range<u32>),
    ) {
        let world = world(fixed, frame);
        let [_, _, eye] = frame.camera.r_view_from_world;
        let stretched = scene.stretched(frame.poses, eye).into_iter();
        for (role, points) in stretched.flat_map(|it| it.lines) {
            let Some(stroke) = frame.theme.paint(role).stroke else { continue };
            let range = self.moved(world, |to| to.line(&points, false, stroke));
            add(self, &points, range);
        }
    }

    /// Adds a layer with placements of all bodies, of the world, and of the picture.
    fn add_layer(&mut self, fixed: &Fixed, frame: &Frame<'_>, poses: &[Pose], opacity: f32) -> u32 {
        let layer = Layer { first_placement: count(self.placements.len()), opacity };
        let of_body = |(body, &anchor): (usize, &[f64; 3])| {
            let pose = poses.get(body).copied().unwrap_or_default();
            placement(frame, &pose, anchor)
        };
        self.placements.extend(fixed.anchors.iter().enumerate().map(of_body));
        self.placements.push(placement(frame, &Pose::default(), frame.camera.centre));
        let density = frame.pixels_per_point;
        let picture = Placement { x: [density, 0.0, 0.0, 0.0], y: [0.0, density, 0.0, 0.0] };
        self.placements.push(picture);
        self.layers.push(layer);
        count(self.layers.len() - 1)
    }

    /// Adds arrows and names, as in a picture of the scene.
    fn overlay(&mut self, fixed: &Fixed, frame: &Frame<'_>, extras: &Extras, layer: u32) {
        let overlay = picture(&self.bare, frame.poses, extras, frame.camera, frame.theme);
        let plane = (count(fixed.anchors.len() + 1), [0.0; 3]);
        let raised = |[x, y]: [f32; 2]| [f64::from(x), f64::from(y), 0.0];
        let ring = |points: &Vec<[f32; 2]>| points.iter().map(|&p| raised(p)).collect::<Vec<_>>();
        for item in overlay.items {
            let range = match &item {
                Item::Region { rings, fill } => {
                    let rings: Vec<_> = rings.iter().map(ring).collect();
                    self.moved(plane, |to| to.region(&rings, Some(*fill), None))
                }
                Item::Line { points, is_closed, stroke } => {
                    self.moved(plane, |to| to.line(&ring(points), *is_closed, *stroke))
                }
                Item::Text { .. } => {
                    self.words.push(item);
                    continue;
                }
            };
            self.paint(range, layer);
        }
    }

    /// Appends primitives to the order of painting.
    fn paint(&mut self, primitives: Range<u32>, layer: u32) {
        let indices = if self.globals.is_ordered == 0 {
            primitives
        } else {
            let first = count(self.order.len());
            self.order.extend(primitives);
            first..count(self.order.len())
        };
        // Vertices have 32-bit numbers: primitives beyond those are left out.
        if indices.is_empty() || indices.end > u32::MAX / VERTICES {
            return;
        }
        match self.runs.last_mut() {
            Some(last) if last.layer == layer && last.indices.end == indices.start => {
                last.indices.end = indices.end;
            }
            _ => self.runs.push(Run { layer, indices }),
        }
    }

    /// Adds moving primitives relative to an anchor, in the world or in the picture; returns their
    /// indices.
    fn moved(
        &mut self,
        (body, anchor): (u32, [f64; 3]),
        draw: impl FnOnce(&mut Builder<'_>),
    ) -> Range<u32> {
        let index = |n: usize| self.globals.n_fixed.saturating_add(count(n));
        let first = index(self.moving.len());
        draw(&mut Builder { primitives: &mut self.moving, body, anchor });
        first..index(self.moving.len())
    }
}

/// The index of the world's placement, after those of all bodies, and the point that is subtracted
/// from points of the world, m.
fn world(fixed: &Fixed, frame: &Frame<'_>) -> (u32, [f64; 3]) {
    (count(fixed.anchors.len()), frame.camera.centre)
}

/// The placement of a body.
fn placement(frame: &Frame<'_>, pose: &Pose, anchor: [f64; 3]) -> Placement {
    let camera = frame.camera;
    let density = f64::from(frame.pixels_per_point);
    let [x, y, _] = camera.project(pose.place(anchor));
    let row = |row: [f64; 3], sign: f64| -> [f64; 3] {
        std::array::from_fn(|axis| {
            let turned: f64 = (0..3).map(|i| row[i] * pose.r_world_from_body[i][axis]).sum();
            sign * density * camera.scale * turned
        })
    };
    let [right, up, _] = camera.r_view_from_world;
    let with = |[a, b, c]: [f64; 3], d: f64| [a, b, c, density * d].map(single);
    Placement { x: with(row(right, 1.0), x), y: with(row(up, -1.0), y) }
}
