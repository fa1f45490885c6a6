//! The pipeline and buffers on the graphics card.

use std::borrow::Cow;

use bytemuck::NoUninit;
use wgpu::{BufferBindingType, BufferUsages, ShaderStages};

use super::Counts;
use super::fixed::Fixed;
use super::frame::{Drawing, Globals, Layer, Placement, Run, VERTICES};
use super::primitive::{Primitive, count};

/// The shader, one file per primitive.
const SHADER: &str = concat!(
    include_str!("shader.wgsl"),
    include_str!("mesh.wgsl"),
    include_str!("line.wgsl"),
    include_str!("rod.wgsl")
);

/// Pipeline, buffers, and the draw calls of the last frame.
#[derive(Debug)]
pub(super) struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    globals: Growing,
    fixed: Growing,
    moving: Growing,
    placements: Growing,
    layers: Growing,
    order: Growing,
    /// Contents of the buffer `order`.
    last_order: Vec<u32>,
    /// `None` after a buffer has been replaced.
    bindings: Option<wgpu::BindGroup>,
    runs: Vec<Run>,
}

/// A buffer that is replaced by one of at least twice the size when it is too small.
#[derive(Debug)]
struct Growing {
    buffer: wgpu::Buffer,
    usage: BufferUsages,
}

impl Growing {
    fn new(device: &wgpu::Device, usage: BufferUsages, size: usize) -> Self {
        let usage = usage | BufferUsages::COPY_DST;
        Self { buffer: buffer(device, usage, size as u64), usage }
    }

    /// Writes items, as many as the card can hold; returns whether the buffer was replaced.
    fn write<T: NoUninit>(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        items: &[T],
    ) -> bool {
        let limit = device.limits().max_storage_buffer_binding_size;
        let capacity = usize::try_from(limit).unwrap_or(usize::MAX) / size_of::<T>();
        let bytes: &[u8] = bytemuck::cast_slice(&items[..items.len().min(capacity)]);
        let n_bytes = bytes.len() as u64;
        let is_small = n_bytes > self.buffer.size();
        if is_small {
            let size = n_bytes.next_power_of_two().min(limit).max(n_bytes);
            self.buffer = buffer(device, self.usage, size);
        }
        if !bytes.is_empty() {
            queue.write_buffer(&self.buffer, 0, bytes);
        }
        is_small
    }
}

fn buffer(device: &wgpu::Device, usage: BufferUsages, size: u64) -> wgpu::Buffer {
    let label = Some("scene");
    device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
}

impl Gpu {
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: wgpu::TextureFormat,
    ) -> Self {
        let layout = bind_group_layout(device);
        let storage = |item: usize| Growing::new(device, BufferUsages::STORAGE, 64 * item);
        Self {
            pipeline: pipeline(device, &layout, format),
            globals: Growing::new(device, BufferUsages::UNIFORM, size_of::<Globals>()),
            fixed: storage(size_of::<Primitive>()),
            moving: storage(size_of::<Primitive>()),
            placements: storage(size_of::<Placement>()),
            layers: storage(size_of::<Layer>()),
            order: storage(size_of::<u32>()),
            last_order: Vec::new(),
            bindings: None,
            runs: Vec::new(),
            device: device.clone(),
            queue: queue.clone(),
            layout,
        }
    }

    /// Sends the primitives on bodies; those that the card cannot hold are left out.
    pub(super) fn set_fixed(&mut self, fixed: &mut Fixed) {
        let limit = self.device.limits().max_storage_buffer_binding_size;
        let capacity = usize::try_from(limit).unwrap_or(usize::MAX) / size_of::<Primitive>();
        if fixed.primitives.len() > capacity {
            fixed.primitives.truncate(capacity);
            for range in &mut fixed.ranges {
                range.end = range.end.min(count(capacity));
                range.start = range.start.min(range.end);
            }
            fixed.n_back = fixed.n_back.min(count(capacity));
        }
        if self.fixed.write(&self.device, &self.queue, &fixed.primitives) {
            self.bindings = None;
        }
        self.runs.clear();
    }

    /// Sends the data that changes from frame to frame.
    pub(super) fn set_frame(&mut self, drawing: &Drawing) -> Counts {
        let Drawing { globals, placements, layers, moving, order, runs, .. } = drawing;
        let (device, queue) = (&self.device, &self.queue);
        // The order of depths mostly stays the same from frame to frame.
        let is_reordered = *order != self.last_order;
        let is_new = [
            self.globals.write(device, queue, &[*globals]),
            self.moving.write(device, queue, moving),
            self.placements.write(device, queue, placements),
            self.layers.write(device, queue, layers),
            is_reordered && self.order.write(device, queue, order),
        ];
        if is_reordered {
            self.last_order.clone_from(order);
        }
        if self.bindings.is_none() || is_new.contains(&true) {
            self.bindings = Some(self.bind());
        }
        self.runs.clone_from(runs);
        let n_bytes = size_of_val(globals)
            + size_of_val(&placements[..])
            + size_of_val(&layers[..])
            + size_of_val(&moving[..])
            + if is_reordered { size_of_val(&order[..]) } else { 0 };
        let n_primitives = runs.iter().map(|run| run.indices.len()).sum();
        Counts { n_draws: runs.len(), n_primitives, n_bytes }
    }

    fn bind(&self) -> wgpu::BindGroup {
        let buffers =
            [&self.globals, &self.fixed, &self.moving, &self.placements, &self.layers, &self.order];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
            .iter()
            .enumerate()
            .map(|(idx, growing)| wgpu::BindGroupEntry {
                binding: count(idx),
                resource: growing.buffer.as_entire_binding(),
            })
            .collect();
        let label = Some("scene");
        let layout = &self.layout;
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout,
            entries: &entries,
        })
    }

    pub(super) fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some(bindings) = &self.bindings else { return };
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bindings, &[]);
        for Run { layer, indices } in &self.runs {
            // Not an instance per primitive: few vertices each leave most of a graphics card idle.
            pass.draw(VERTICES * indices.start..VERTICES * indices.end, *layer..layer + 1);
        }
    }
}

/// Six buffers: globals, fixed primitives, moving primitives, placements, layers, order.
fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let storage = BufferBindingType::Storage { read_only: true };
    let types = [BufferBindingType::Uniform, storage, storage, storage, storage, storage];
    let entries: Vec<wgpu::BindGroupLayoutEntry> = types
        .into_iter()
        .enumerate()
        .map(|(idx, ty)| wgpu::BindGroupLayoutEntry {
            binding: count(idx),
            visibility: ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let label = Some("scene");
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries })
}

/// The render pipeline of all primitives, for targets of a format.
fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    // The shader and its buffers.
    let label = Some("scene");
    let source = wgpu::ShaderSource::Wgsl(Cow::Borrowed(SHADER));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });

    // Linear light for targets that convert to sRGB themselves, premultiplied blending.
    let constants = [("is_linear", f64::from(u8::from(format.is_srgb())))];
    let options = wgpu::PipelineCompilationOptions {
        constants: &constants,
        ..wgpu::PipelineCompilationOptions::default()
    };
    let target = wgpu::ColorTargetState {
        format,
        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    };

    // Vertices come from storage buffers alone.
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: options,
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}
