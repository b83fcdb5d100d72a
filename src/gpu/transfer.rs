//! State to the device and back.

use std::ops::Range;
use std::sync::mpsc;
use std::time::Duration;

use super::DeviceError;
use super::buffers::BufferId;
use super::layout::{self, REACH_WORDS, STATUS_WORDS, status};
use super::stepper::DeviceStepper;
use crate::kernels::element_force::field as element;
use crate::kernels::node_update::field as node;
use crate::model::{Model, over::SIDES};
use crate::solver::active_region::ActiveRegion;
use crate::solver::state::{Rows, State};

/// A device that has done its work and does not say so in that time will not.
const SOON: Duration = Duration::from_secs(10);

impl DeviceStepper<'_> {
    pub(crate) fn buffer(&self, name: BufferId) -> &wgpu::Buffer {
        &self.buffers[name as usize]
    }

    pub(crate) fn write(&self, name: BufferId, words: &[u32]) {
        self.device.queue.write_buffer(self.buffer(name), 0, bytemuck::cast_slice(words));
    }

    /// Puts a state on the device and forgets everything counted so far.
    pub fn upload(&mut self, model: &Model<f32>, state: &State<f32>) {
        self.upload_but_accounts(model, state);
        self.clear(&[BufferId::Accounts]);
    }

    /// The same, but energies and work of the elements stay.
    pub(crate) fn upload_but_accounts(&mut self, model: &Model<f32>, state: &State<f32>) {
        let columns = self.grid.columns;
        let nodes = planes(&state.nodes, 0..node::COUNT, 0, columns + 1);
        self.write(BufferId::Nodes, bytemuck::cast_slice(&nodes));
        let forces = planes(&state.elements, element::FORCES, 1, columns);
        self.write(BufferId::Forces, bytemuck::cast_slice(&forces));
        let heights = planes(&state.elements, element::PREDICTOR..element::ALIVE, 1, columns);
        self.write(BufferId::Heights, bytemuck::cast_slice(&heights));
        let alive = planes(&state.elements, element::ALIVE..element::COUNT, 1, columns);
        let (warp, weft) = alive.split_at(self.sizes.elements as usize);
        let flag = |(warp, weft): (&f32, &f32)| u32::from(*warp > 0.5) + 2 * u32::from(*weft > 0.5);
        self.write(BufferId::Flags, &warp.iter().zip(weft).map(flag).collect::<Vec<_>>());
        if self.sizes.yarn_fields > 0 {
            self.write(BufferId::Yarns, bytemuck::cast_slice(&self.yarns(model, &state.elements)));
        }
        let mut counters = vec![0; STATUS_WORDS];
        counters[status::BAD_STEP] = layout::NONE;
        counters.extend(state.active.iter().flat_map(reach_words));
        self.write(BufferId::Status, &counters);
        if !state.over.is_empty() {
            self.write(BufferId::Over, &by_side(&state.over, model.nodes_per_ply()));
        }
        if let (Some(body), Some(start)) = (&state.body, &model.projectile) {
            self.write(BufferId::Body, &layout::body(body, &start.velocity));
        }
        self.clear(&[
            BufferId::Supports,
            BufferId::Candidates,
            BufferId::Contacts,
            BufferId::Shares,
            BufferId::Impulses,
        ]);
        self.events_read = 0;
    }

    /// Viscous forces and strains of the yarns, strains as those of both of the last steps; and their strengths, where those vary.
    fn yarns(&self, model: &Model<f32>, elements: &Rows<f32>) -> Vec<f32> {
        let fields = |first: usize, count: usize| planes(elements, first..first + count, 1, self.grid.columns);
        let strains = elements.fields - element::STRAIN;
        let mut yarns = match self.terms.viscous {
            true => fields(element::COUNT, element::VISCOUS),
            false => vec![0.0; 2 * self.sizes.elements as usize],
        };
        if self.terms.windows {
            (0..2).for_each(|_| yarns.extend(fields(strains, element::STRAIN)));
        }
        if let Some(strength) = &model.strength {
            for yarn in 0..2 {
                let places = (0..self.grid.element_rows())
                    .flat_map(|row| (0..self.grid.columns).map(move |column| [row, column]));
                yarns.extend(places.map(|[row, column]| strength.factor(row, yarn, column) as f32));
            }
        }
        yarns
    }

    fn clear(&self, names: &[BufferId]) {
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for name in names {
            encoder.clear_buffer(self.buffer(*name), 0, None);
        }
        self.device.queue.submit([encoder.finish()]);
    }

    /// Reads the state back, but the strains that failure is judged by; of the projectile what moves.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn download(&self, model: &Model<f32>, state: &mut State<f32>) -> Result<(), DeviceError> {
        let columns = self.grid.columns;
        let floats = |name| self.read(name).map(|words| words.into_iter().map(f32::from_bits).collect::<Vec<_>>());
        set_planes(&mut state.nodes, 0..node::COUNT, 0, columns + 1, &floats(BufferId::Nodes)?);
        set_planes(&mut state.elements, element::FORCES, 1, columns, &floats(BufferId::Forces)?);
        set_planes(&mut state.elements, element::PREDICTOR..element::ALIVE, 1, columns, &floats(BufferId::Heights)?);
        let flags = self.read(BufferId::Flags)?;
        let alive: Vec<f32> =
            [1, 2].iter().flat_map(|bit| flags.iter().map(move |f| f32::from(u8::from(f & bit != 0)))).collect();
        if self.terms.viscous {
            let yarns = floats(BufferId::Yarns)?;
            set_planes(&mut state.elements, element::COUNT..element::COUNT + element::VISCOUS, 1, columns, &yarns);
        }
        set_planes(&mut state.elements, element::ALIVE..element::COUNT, 1, columns, &alive);
        let status = self.read(BufferId::Status)?;
        state.active = status[status::REACH..].chunks_exact(REACH_WORDS as usize).map(reach_from).collect();
        if !state.over.is_empty() {
            state.over = by_ply(&self.read(BufferId::Over)?, model.nodes_per_ply());
        }
        if let Some(start) = &model.projectile {
            state.body = Some(layout::read_body(&self.read(BufferId::Body)?, start).body);
        }
        Ok(())
    }

    /// All words of a buffer.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn read(&self, name: BufferId) -> Result<Vec<u32>, DeviceError> {
        self.read_part(name, 0, self.sizes.bytes(name))
    }

    /// The words of the first sample.
    pub(crate) fn read_sample(&self) -> Result<Vec<u32>, DeviceError> {
        self.read_part(BufferId::Samples, 0, 4 * self.sizes.sample_words() as u64)
    }

    pub(crate) fn read_part(&self, name: BufferId, offset: u64, size: u64) -> Result<Vec<u32>, DeviceError> {
        self.read_buffer(self.buffer(name), offset, size)
    }

    pub(crate) fn read_buffer(&self, from: &wgpu::Buffer, offset: u64, size: u64) -> Result<Vec<u32>, DeviceError> {
        let staging = self.device.inner.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(from, offset, &staging, 0, size);
        self.device.queue.submit([encoder.finish()]);
        self.fetch(&staging, size, None)
    }

    /// Words of a mappable buffer, once a submission (or everything) is done.
    pub(crate) fn fetch(
        &self,
        staging: &wgpu::Buffer,
        size: u64,
        after: Option<wgpu::SubmissionIndex>,
    ) -> Result<Vec<u32>, DeviceError> {
        let (tell, told) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, 0..size, move |result| {
            // The receiver lives until the wait below is over.
            tell.send(result).ok();
        });
        self.device.wait(after)?;
        let failed = |reason: String| self.device.lost(reason);
        // Another thread that waits for the same device may be the one that tells, a moment later.
        told.recv_timeout(SOON).map_err(|e| failed(e.to_string()))?.map_err(|e| failed(e.to_string()))?;
        let words = {
            let view = staging.get_mapped_range(0..size).map_err(|e| failed(e.to_string()))?;
            bytemuck::pod_collect_to_vec::<u8, u32>(&view)
        };
        staging.unmap();
        Ok(words)
    }
}

/// Fields of rows as planes, shape (fields, rows·columns); column c is stored at c + `first`.
fn planes(rows: &Rows<f32>, fields: Range<usize>, first: usize, columns: usize) -> Vec<f32> {
    let count = rows.data.len() / rows.row_length();
    let mut out = Vec::with_capacity(fields.len() * count * columns);
    for field in fields {
        for row in 0..count {
            let at = field * rows.stride + first;
            out.extend_from_slice(&rows.row(row)[at..at + columns]);
        }
    }
    out
}

/// The inverse of [`planes`].
fn set_planes(rows: &mut Rows<f32>, fields: Range<usize>, first: usize, columns: usize, planes: &[f32]) {
    let count = rows.data.len() / rows.row_length();
    let mut parts = planes.chunks_exact(columns);
    for field in fields {
        for row in 0..count {
            let at = field * rows.stride + first;
            if let Some(part) = parts.next() {
                rows.row_mut(row)[at..at + columns].copy_from_slice(part);
            }
        }
    }
}

/// What may have moved of a ply as the shaders hold it; of nothing, a first beyond every end.
fn reach_words(reach: &ActiveRegion) -> [u32; 4] {
    if reach.is_nothing() {
        return [layout::NONE, 0, layout::NONE, 0];
    }
    [reach.rows.start, reach.rows.end, reach.columns.start, reach.columns.end].map(|at| at as u32)
}

fn reach_from(words: &[u32]) -> ActiveRegion {
    let [rows, columns] = [0, 2].map(|at| words[at] as usize..words[at + 1] as usize);
    if rows.is_empty() { ActiveRegion::nothing() } else { ActiveRegion { rows, columns } }
}

/// From shape (plies, sides, nodes) to (sides, plies, nodes).
fn by_side(over: &[u32], nodes: usize) -> Vec<u32> {
    (0..SIDES).flat_map(|side| over.chunks(nodes).skip(side).step_by(SIDES).flatten().copied()).collect()
}

/// From shape (sides, plies, nodes) to (plies, sides, nodes).
fn by_ply(over: &[u32], nodes: usize) -> Vec<u32> {
    let plies = over.len() / (SIDES * nodes);
    let part = |at: usize| &over[at * nodes..(at + 1) * nodes];
    (0..plies).flat_map(|ply| (0..SIDES).flat_map(move |side| part(side * plies + ply))).copied().collect()
}
