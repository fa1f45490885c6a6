//! [`SceneRenderer`]: scenes on the graphics card, in a window's render pass or in one of our own.
//!
//! Everything is a primitive: a triangle, a segment of a line, which the vertex shader widens to a
//! constant number of pixels, or a rod, which is equally many metres wide in every view. Primitives
//! of bodies lie in the frames of their bodies and are uploaded once per scene and theme; a frame
//! brings one placement per body and the primitives that change (springs, trails, arrows):
//!
//! ```text
//! primitives: fixed | moving      storage buffers, in the order in which they are painted
//! placements: x_pixels_from_body  per layer and body; a layer is the mechanism or one of its ghosts
//! runs: (layer, primitives) …     one draw call each
//! ```
//!
//! So a planar mechanism is painted by one call, or by three with springs between the shapes below
//! and above them, and nothing that stays is sent twice. In space the order of painting changes
//! with the motion: the primitives are sorted by the depth of their shapes, and that order is sent
//! when it changes. Translucent areas blend correctly in both. Edges are made smooth in the
//! fragment shader: the owner of the render pass needs neither multisampling nor a depth buffer.
//!
//! Points are `f64` until the camera's centre is subtracted, then `f32`.

mod fixed;
mod frame;
mod gpu;
mod line;
mod mesh;
mod primitive;

use std::sync::Arc;

use bksim::sim::pose::Pose;
use bksim_scene::{Camera, Extras, Item, Scene, Theme};

use self::fixed::Fixed;
use self::frame::Drawing;
use self::gpu::Gpu;

/// The picture of one instant: poses, additions, camera and colours.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Poses of the bodies, the ground first.
    pub poses: &'a [Pose],
    /// Additions to the mechanism; labels become [`SceneRenderer::words`].
    pub extras: &'a Extras,
    /// The camera; its pixels are points of `pixels_per_point` pixels each.
    pub camera: &'a Camera,
    /// The colours.
    pub theme: &'a Theme,
    /// Pixels of the target per pixel of the camera: 2 on a display of twice the usual density.
    pub pixels_per_point: f32,
}

/// Amount of work of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counts {
    /// Draw calls: none for an empty frame, one for a planar mechanism without additions.
    pub n_draws: usize,
    /// Triangles, segments and rods painted, those of ghosts too.
    pub n_primitives: usize,
    /// Bytes sent to the graphics card for it.
    pub n_bytes: usize,
}

/// Paints scenes. Cheap to keep, expensive to make: that compiles the shader.
#[derive(Debug)]
pub struct SceneRenderer {
    gpu: Gpu,
    scene: Arc<Scene>,
    theme: Theme,
    fixed: Fixed,
    drawing: Drawing,
}

impl SceneRenderer {
    /// A renderer into targets of this format, without multisampling and depth buffer.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, format: wgpu::TextureFormat) -> Self {
        let gpu = Gpu::new(device, queue, format);
        let (scene, theme) = (Arc::new(Scene::default()), Theme::LIGHT);
        Self { gpu, fixed: Fixed::of(&scene, &theme), scene, theme, drawing: Drawing::default() }
    }

    /// Takes another scene and sends its shapes to the graphics card.
    pub fn set_scene(&mut self, scene: Arc<Scene>, theme: &Theme) {
        self.fixed = Fixed::of(&scene, theme);
        self.gpu.set_fixed(&mut self.fixed);
        self.drawing.set_scene(&scene);
        (self.scene, self.theme) = (scene, *theme);
    }

    /// Takes a scene in the colours that it has, if it is another one than before.
    pub fn follow(&mut self, scene: &Arc<Scene>) {
        if !Arc::ptr_eq(scene, &self.scene) {
            let theme = self.theme;
            self.set_scene(Arc::clone(scene), &theme);
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Sends a frame to the graphics card; [`SceneRenderer::paint`] shows it.
    pub fn prepare(&mut self, frame: &Frame<'_>) -> Counts {
        if *frame.theme != self.theme {
            self.set_scene(Arc::clone(&self.scene), frame.theme);
        }
        self.drawing.compose(&self.scene, &self.fixed, frame);
        self.gpu.set_frame(&self.drawing)
    }

    /// The words of the frame, for [`crate::words::paint_words`].
    pub fn words(&self) -> &[Item] {
        &self.drawing.words
    }

    /// Paints the frame into the viewport of `pass`, which the camera's picture fills. It paints no
    /// background.
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.gpu.paint(pass);
    }
}
