//! Pipelines: a kernel compiled for a scene, with the buffers it binds.

use super::shader::{Access, Kernel};

/// A pipeline with what it binds.
pub(crate) struct Program {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) group: wgpu::BindGroup,
}

/// Compiles a kernel with values of its overridable constants, and binds its buffers.
pub(crate) fn program(
    gpu: &wgpu::Device,
    kernel: &Kernel,
    module: &wgpu::ShaderModule,
    common: &wgpu::BindGroupLayout,
    buffers: &[wgpu::Buffer],
    constants: &[(&str, f64)],
) -> Program {
    let bindings = kernel.bindings.iter().zip(0..);
    let entries: Vec<_> = bindings
        .clone()
        .map(|((_, access), binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: *access == Access::Read },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    let layout =
        gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(kernel.name), entries: &entries });
    let entries: Vec<_> = bindings
        .map(|((name, _), binding)| wgpu::BindGroupEntry {
            binding,
            resource: buffers[*name as usize].as_entire_binding(),
        })
        .collect();
    let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(kernel.name),
        layout: &layout,
        entries: &entries,
    });
    let pipeline_layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(kernel.name),
        bind_group_layouts: &[Some(common), Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(kernel.name),
        layout: Some(&pipeline_layout),
        module,
        entry_point: Some(kernel.name),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    });
    Program { pipeline, group }
}
