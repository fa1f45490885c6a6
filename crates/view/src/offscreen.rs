//! [`Canvas`]: pictures without a window, by the best adapter there is: a graphics card, or a
//! software adapter such as Mesa's.

use bksim_scene::Color;
use egui_wgpu::{RendererOptions, ScreenDescriptor};

use crate::renderer::{Counts, Frame, SceneRenderer};
use crate::words::{color32, paint_words};

/// A picture as bytes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Image {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Red, green, blue, opacity of every pixel, row after row from the top; sRGB, colours not
    /// multiplied by opacity.
    pub rgba: Vec<u8>,
}

/// Error of a canvas.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CanvasError {
    /// There is neither a graphics card nor a software adapter.
    #[error("there is no graphics adapter, not even a software one")]
    NoAdapter,
    /// The adapter gives no device.
    #[error("the graphics adapter `{name}` cannot be used: {why}")]
    NoDevice {
        /// Name of the adapter.
        name: String,
        /// Message of the adapter.
        why: String,
    },
    /// The picture is larger than the adapter allows.
    #[error("a picture of {}x{} pixels is larger than the adapter's {largest}x{largest}", size[0], size[1])]
    TooLarge {
        /// Requested width and height.
        size: [u32; 2],
        /// Largest width and height.
        largest: u32,
    },
    /// The adapter stopped.
    #[error("the graphics adapter stopped: {0}")]
    Lost(String),
}

impl CanvasError {
    /// Remedy for the error.
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::NoAdapter | Self::NoDevice { .. } | Self::Lost(_) => Some(INSTALL),
            Self::TooLarge { .. } => Some("ask for a smaller picture"),
        }
    }
}

/// Instructions to install an adapter that draws without a graphics card.
pub const INSTALL: &str = if cfg!(target_os = "windows") {
    "install the graphics driver; Windows 10 and later bring a software adapter (WARP) with DirectX 12"
} else if cfg!(target_os = "macos") {
    "macOS brings Metal with every Mac that runs version 10.14 or later; there is no software adapter"
} else {
    "install Mesa's software adapter: `apt install mesa-vulkan-drivers` on Debian and Ubuntu, \
     `dnf install mesa-vulkan-drivers` on Fedora, `pacman -S vulkan-swrast` on Arch"
};

/// Format of the texture: the colours are stored as they are, without conversion from linear light.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Draws pictures of one size.
pub struct Canvas {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: String,
    size: [u32; 2],
    pixels_per_point: f32,
    texture: wgpu::Texture,
    bytes: wgpu::Buffer,
    scene: SceneRenderer,
    words: egui::Context,
    word_renderer: egui_wgpu::Renderer,
}

impl Canvas {
    /// A canvas of `size` pixels, `pixels_per_point` of them for each pixel of a camera.
    ///
    /// # Errors
    /// [`CanvasError`], with [`CanvasError::help`] on what to install.
    pub fn new(size: [u32; 2], pixels_per_point: f32) -> Result<Self, CanvasError> {
        pollster::block_on(Self::open(size.map(|n| n.max(1)), pixels_per_point))
    }

    async fn open(size: [u32; 2], pixels_per_point: f32) -> Result<Self, CanvasError> {
        // The adapter, and a device with all that it allows.
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = adapter(&instance).await.ok_or(CanvasError::NoAdapter)?;
        let name = adapter.get_info().name;
        let limits = adapter.limits();
        let largest = limits.max_texture_dimension_2d;
        if size.iter().any(|&n| n > largest) {
            return Err(CanvasError::TooLarge { size, largest });
        }
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: limits, ..wgpu::DeviceDescriptor::default() };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|e| CanvasError::NoDevice { name: name.clone(), why: e.to_string() })?;

        // The texture that is drawn on, and the buffer that its pixels are read from.
        let label = Some("canvas");
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label,
            size: extent(size),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let bytes = device.create_buffer(&wgpu::BufferDescriptor {
            label,
            size: u64::from(row_bytes(size)) * u64::from(size[1]),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });

        // The renderers of the scene and of the words.
        let scene = SceneRenderer::new(&device, &queue, FORMAT);
        let word_renderer = egui_wgpu::Renderer::new(&device, FORMAT, RendererOptions::PREDICTABLE);
        let words = egui::Context::default();
        Ok(Self {
            device,
            queue,
            adapter: name,
            size,
            pixels_per_point,
            texture,
            bytes,
            scene,
            words,
            word_renderer,
        })
    }

    /// Name of the adapter, such as `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Width and height in points, the pixels of a camera.
    pub fn points(&self) -> [f64; 2] {
        self.size.map(|n| f64::from(n) / f64::from(self.pixels_per_point))
    }

    /// The renderer, which takes the scene.
    pub fn scene_mut(&mut self) -> &mut SceneRenderer {
        &mut self.scene
    }

    /// Draws a frame and its words over a background, transparent if there is none. The density of the
    /// frame is that of the canvas.
    ///
    /// # Errors
    /// [`CanvasError::Lost`] when the adapter stops.
    pub fn draw(
        &mut self,
        frame: &Frame<'_>,
        background: Option<Color>,
    ) -> Result<(Image, Counts), CanvasError> {
        let pixels_per_point = self.pixels_per_point;
        let counts = self.scene.prepare(&Frame { pixels_per_point, ..*frame });
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let triangles = self.set_words(&mut encoder);
        self.render(&mut encoder, background, &triangles);
        let image = self.read(encoder)?;
        Ok((image, counts))
    }

    /// Words as triangles; sends the letters they need to the graphics card.
    fn set_words(&mut self, encoder: &mut wgpu::CommandEncoder) -> Vec<egui::ClippedPrimitive> {
        let [width, height] = self.size.map(|n| n as f32 / self.pixels_per_point);
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height));
        let mut input = egui::RawInput { screen_rect: Some(rect), ..egui::RawInput::default() };
        let viewport = input.viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(self.pixels_per_point);
        let mut output = self.words.run_ui(input, |ui| {
            paint_words(&ui.ctx().debug_painter(), egui::Pos2::ZERO, self.scene.words());
        });
        // All letters are on one texture; nothing else is drawn.
        let letters = egui::TextureId::default();
        for delta in output.textures_delta.set.remove(&letters).into_iter().flatten() {
            self.word_renderer.update_texture(&self.device, &self.queue, letters, &delta);
        }
        output.textures_delta.clear();
        let triangles = self.words.tessellate(output.shapes, output.pixels_per_point);
        let screen = self.screen();
        self.word_renderer.update_buffers(&self.device, &self.queue, encoder, &triangles, &screen);
        triangles
    }

    fn screen(&self) -> ScreenDescriptor {
        ScreenDescriptor { size_in_pixels: self.size, pixels_per_point: self.pixels_per_point }
    }

    fn render(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        background: Option<Color>,
        words: &[egui::ClippedPrimitive],
    ) {
        let view = self.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let [r, g, b, a] = background.map_or([0; 4], |color| color32(color).to_array());
        let [r, g, b, a] = [r, g, b, a].map(|x| f64::from(x) / 255.0);
        let attachment = wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
                store: wgpu::StoreOp::Store,
            },
        };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(attachment)],
            ..wgpu::RenderPassDescriptor::default()
        });
        let mut pass = pass.forget_lifetime();
        self.scene.paint(&mut pass);
        self.word_renderer.render(&mut pass, words, &self.screen());
    }

    /// Waits for the picture and copies it from the graphics card.
    fn read(&self, mut encoder: wgpu::CommandEncoder) -> Result<Image, CanvasError> {
        let lost = |e: &dyn std::fmt::Display| CanvasError::Lost(e.to_string());
        let size = self.size;
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes(size)),
            rows_per_image: None,
        };
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.bytes, layout },
            extent(size),
        );
        self.queue.submit([encoder.finish()]);
        let (sender, mapping) = std::sync::mpsc::channel();
        self.bytes.map_async(wgpu::MapMode::Read, .., move |result| drop(sender.send(result)));
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| lost(&e))?;
        mapping.recv().map_err(|e| lost(&e))?.map_err(|e| lost(&e))?;
        let mapped = self.bytes.get_mapped_range(..).map_err(|e| lost(&e))?;
        let mut rgba = Vec::with_capacity(4 * size[0] as usize * size[1] as usize);
        for row in mapped.chunks_exact(row_bytes(size) as usize) {
            rgba.extend_from_slice(&row[..4 * size[0] as usize]);
        }
        drop(mapped);
        self.bytes.unmap();
        rgba.as_chunks_mut().0.iter_mut().for_each(divide);
        Ok(Image { size, rgba })
    }
}

/// The best adapter: a graphics card if there is one, else a software adapter.
async fn adapter(instance: &wgpu::Instance) -> Option<wgpu::Adapter> {
    let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    let adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
    adapters.into_iter().min_by_key(rank)
}

fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}

/// Bytes of a row in the buffer, a multiple of the alignment of copies.
fn row_bytes([width, _]: [u32; 2]) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Divides the colour of a pixel by its opacity.
fn divide(pixel: &mut [u8; 4]) {
    let alpha = u32::from(pixel[3]);
    if alpha == 0 || alpha == 255 {
        return;
    }
    for channel in &mut pixel[..3] {
        let divided = (u32::from(*channel) * 255 + alpha / 2) / alpha;
        // Rounding may leave a channel brighter than its opacity allows.
        *channel = u8::try_from(divided).unwrap_or(u8::MAX);
    }
}
