//! Pipelines: kernels compiled for a scene, with the uniforms that all of them bind in group 0 and the buffers of each in group 1.

use bytemuck::Pod;

use super::Device;
use super::buffers::Sizes;
use super::layout::{self, LAW_STRIDE, LINE_TEXELS, LINES_ACROSS, Line, PLIES, Ply, SCENE_STRIDE, SHOTS, STEP_STRIDE};
use super::shader::{Access, Kernel};
use super::stepper::BATCH;
use crate::model::Model;

/// Compiled kernels that a device keeps at most: scenes of eight that share most of them.
const KEPT: usize = 256;
const UNIFORM: wgpu::BufferUsages = wgpu::BufferUsages::UNIFORM;

/// Group 0: constants of a ply type, step, plies, grid lines, energy of a law, and shots.
pub(super) struct Common {
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) group: wgpu::BindGroup,
    /// Steps of a batch.
    pub(super) steps: wgpu::Buffer,
    /// Constants of the shots that run.
    pub(super) shots: wgpu::Buffer,
}

/// Bytes of values that begin at multiples of a stride.
pub(super) fn strided<T: Pod>(stride: u64, values: impl Iterator<Item = T>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (count, value) in (1..).zip(values) {
        bytes.extend_from_slice(bytemuck::bytes_of(&value));
        bytes.resize(count * stride as usize, 0);
    }
    bytes
}

impl Common {
    /// Writes all but steps and shots.
    pub(super) fn new(device: &Device, model: &Model<f32>, sizes: &Sizes) -> Self {
        let uniform = |label: &str, size: u64, bytes: &[u8]| {
            let buffer = device.buffer(label, size, UNIFORM);
            device.queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let ply_types = model.ply_types.len() as u64;
        let scenes = (0..model.ply_types.len()).map(|ply_type| layout::scene(model, ply_type, sizes));
        let laws: Vec<f32> = model.ply_types.iter().flat_map(layout::law_energy).collect();
        let scene = uniform("scene", SCENE_STRIDE * ply_types, &strided(SCENE_STRIDE, scenes));
        let law = uniform("law", LAW_STRIDE * ply_types, bytemuck::cast_slice(&laws));
        let plies = uniform("plies", (PLIES * size_of::<Ply>()) as u64, bytemuck::cast_slice(&layout::plies(model)));
        let lines = grid_lines(device, &layout::lines(model));
        let steps = device.buffer("steps", STEP_STRIDE * BATCH as u64, UNIFORM);
        let shots = device.buffer("shots", SHOTS * size_of::<layout::Shot>() as u64, UNIFORM);
        let step_bytes = size_of::<layout::Step>() as u64;
        let layout = common_layout(&device.inner, step_bytes);
        let group = device.inner.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene and step"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: part(&scene, SCENE_STRIDE) },
                wgpu::BindGroupEntry { binding: 1, resource: part(&steps, step_bytes) },
                wgpu::BindGroupEntry { binding: 2, resource: plies.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&lines) },
                wgpu::BindGroupEntry { binding: 4, resource: part(&law, LAW_STRIDE) },
                wgpu::BindGroupEntry { binding: 5, resource: shots.as_entire_binding() },
            ],
        });
        Self { layout, group, steps, shots }
    }
}

/// First bytes of a buffer, to be moved by a dynamic offset.
fn part(buffer: &wgpu::Buffer, size: u64) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size: wgpu::BufferSize::new(size) })
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}

/// Layout of group 0. Constants of a ply type, step and law are bound at dynamic offsets.
fn common_layout(gpu: &wgpu::Device, step_bytes: u64) -> wgpu::BindGroupLayout {
    let uniform = |binding: u32, dynamic: bool, size: u64| {
        let ty = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: dynamic,
            min_binding_size: wgpu::BufferSize::new(size),
        };
        entry(binding, ty)
    };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene and step"),
        entries: &[
            uniform(0, true, SCENE_STRIDE),
            uniform(1, true, step_bytes),
            uniform(2, false, 0),
            entry(3, texture),
            uniform(4, true, LAW_STRIDE),
            uniform(5, false, SHOTS * size_of::<layout::Shot>() as u64),
        ],
    })
}

/// Texture of the grid lines: kernels already bind the eight storage buffers that every device has.
fn grid_lines(device: &Device, lines: &[Line]) -> wgpu::TextureView {
    let across = lines.len().min(LINES_ACROSS);
    let (width, height) = ((LINE_TEXELS * across) as u32, (lines.len() / across) as u32);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = device.inner.create_texture(&wgpu::TextureDescriptor {
        label: Some("grid lines"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes_per_row = Some((size_of::<Line>() * across) as u32);
    let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    device.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(lines), rows, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A compiled kernel with the buffers it binds.
pub(super) struct Pipeline {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
}

impl Pipeline {
    /// Compiles a kernel with values of its overridable constants, or takes what the device has compiled before, and binds its buffers.
    pub(super) fn new(
        device: &Device,
        kernel: &Kernel,
        source: String,
        common: &wgpu::BindGroupLayout,
        buffers: &[wgpu::Buffer],
        constants: &[(&str, f64)],
    ) -> Self {
        let gpu = &device.inner;
        let (label, bindings) = (Some(kernel.name), kernel.bindings.iter().zip(0..));
        let storage = |((_, access), binding): (&(_, Access), u32)| {
            let ty = wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: *access == Access::Read },
                has_dynamic_offset: false,
                min_binding_size: None,
            };
            entry(binding, ty)
        };
        let entries: Vec<_> = bindings.clone().map(storage).collect();
        let layout = gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let bound = |((id, _), binding): (&(super::buffers::BufferId, _), u32)| wgpu::BindGroupEntry {
            binding,
            resource: buffers[*id as usize].as_entire_binding(),
        };
        let entries: Vec<_> = bindings.map(bound).collect();
        let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor { label, layout: &layout, entries: &entries });
        let used: Vec<(&str, f64)> =
            constants.iter().filter(|(name, _)| kernel.constants.contains(name)).copied().collect();
        let compile = |source: &str| {
            let source = wgpu::ShaderSource::Wgsl(source.into());
            let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
            let pipeline_layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label,
                bind_group_layouts: &[Some(common), Some(&layout)],
                immediate_size: 0,
            });
            gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label,
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(kernel.name),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &used, ..Default::default() },
                cache: None,
            })
        };
        let values = used.iter().map(|(_, value)| value.to_bits()).collect();
        let mut compiled = device.compiled();
        if compiled.len() >= KEPT {
            compiled.clear();
        }
        let known = compiled.entry((source, values));
        let pipeline = known.or_insert_with_key(|(source, _)| compile(source)).clone();
        Self { pipeline, group }
    }
}
