//! Group 0, which all kernels bind: scene, step, plies, grid lines, law and shots.

use super::Device;
use super::buffers::Sizes;
use super::layout::{
    self, LAW_STRIDE, LINE_TEXELS, LINE_WORDS, LINES_ACROSS, PLIES, PLY_WORDS, SCENE_STRIDE, SHOT_WORDS, SHOTS,
    STEP_BYTES, STEP_STRIDE,
};
use super::stepper::BATCH;
use crate::model::Model;

const UNIFORM: wgpu::BufferUsages = wgpu::BufferUsages::UNIFORM;

/// The group, and of what it binds the part that changes from batch to batch.
pub(super) struct Common {
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) group: wgpu::BindGroup,
    /// The steps of a batch.
    pub(super) steps: wgpu::Buffer,
    /// Constants of the shots that run.
    pub(super) shots: wgpu::Buffer,
}

impl Common {
    /// Writes all but steps and shots.
    pub(super) fn new(device: &Device, model: &Model<f32>, sizes: &Sizes) -> Self {
        let ply_types = 0..model.ply_types.len();
        let scene = device.buffer("scene", SCENE_STRIDE * ply_types.len() as u64, UNIFORM);
        for ply_type in ply_types {
            let block = layout::scene(model, ply_type, sizes).words();
            device.queue.write_buffer(&scene, SCENE_STRIDE * ply_type as u64, bytemuck::cast_slice(&block));
        }
        let law = device.buffer("law", LAW_STRIDE * model.ply_types.len() as u64, UNIFORM);
        for (at, ply_type) in model.ply_types.iter().enumerate() {
            let words = layout::law_energy(ply_type);
            device.queue.write_buffer(&law, LAW_STRIDE * at as u64, bytemuck::cast_slice(&words));
        }
        let plies = device.buffer("plies", 4 * (PLIES * PLY_WORDS) as u64, UNIFORM);
        let words: Vec<u32> = layout::plies(model).iter().flat_map(|ply| ply.words()).collect();
        device.queue.write_buffer(&plies, 0, bytemuck::cast_slice(&words));
        let lines = grid_lines(device, model);
        let steps = device.buffer("steps", STEP_STRIDE * BATCH as u64, UNIFORM);
        let shots = device.buffer("shots", 4 * SHOTS * SHOT_WORDS, UNIFORM);
        let layout = layout_of(&device.inner);
        let group = device.inner.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene and step"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: part(&scene, SCENE_STRIDE) },
                wgpu::BindGroupEntry { binding: 1, resource: part(&steps, STEP_BYTES) },
                wgpu::BindGroupEntry { binding: 2, resource: plies.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&lines) },
                wgpu::BindGroupEntry { binding: 4, resource: part(&law, LAW_STRIDE) },
                wgpu::BindGroupEntry { binding: 5, resource: shots.as_entire_binding() },
            ],
        });
        Self { layout, group, steps, shots }
    }
}

/// Layout of group 0: the constants of a ply type and the step at dynamic offsets, the plies, their grid lines, and what the law of a ply type
/// makes of energy, at a dynamic offset, and the shots that run.
fn layout_of(gpu: &wgpu::Device) -> wgpu::BindGroupLayout {
    let uniform = |binding: u32, dynamic: bool, size: u64| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: dynamic,
            min_binding_size: wgpu::BufferSize::new(size),
        },
        count: None,
    };
    let texture = |binding: u32| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    };
    gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene and step"),
        entries: &[
            uniform(0, true, SCENE_STRIDE),
            uniform(1, true, STEP_BYTES),
            uniform(2, false, 0),
            texture(3),
            uniform(4, true, LAW_STRIDE),
            uniform(5, false, 4 * SHOTS * SHOT_WORDS),
        ],
    })
}

/// The grid lines, of which each has its texels.
fn grid_lines(device: &Device, model: &Model<f32>) -> wgpu::TextureView {
    let words = layout::lines(model);
    let lines = words.len() / LINE_WORDS;
    let across = lines.min(LINES_ACROSS);
    let (width, height) = ((LINE_TEXELS * across) as u32, (lines / across) as u32);
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
    let bytes_per_row = Some((4 * LINE_WORDS * across) as u32);
    let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    device.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&words), rows, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The first bytes of a buffer, to be moved by a dynamic offset.
fn part(buffer: &wgpu::Buffer, size: u64) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size: wgpu::BufferSize::new(size) })
}
