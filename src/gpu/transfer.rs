//! Transfer of states to the device and back.

use std::ops::Range;

use futures_channel::oneshot;

use super::DeviceError;
use super::buffers::BufferId;
use super::layout::{self, REACH_WORDS, STATE_SLOTS, STATUS_WORDS, cell, status};
use super::stepper::DeviceStepper;
use crate::model::Model;
use crate::model::layup::SIDES;
use crate::solver::element_totals::field as element;
use crate::solver::node_update::field as node;
use crate::solver::state::{ActiveRegion, Rows, State};

/// Buffers that begin at zero with a state.
const CLEARED: [BufferId; 7] = [
    BufferId::Tiles,
    BufferId::ContactWork,
    BufferId::Supports,
    BufferId::Candidates,
    BufferId::Contacts,
    BufferId::Shares,
    BufferId::Impulses,
];

impl DeviceStepper<'_> {
    pub(crate) fn buffer(&self, name: BufferId) -> &wgpu::Buffer {
        &self.buffers[name as usize]
    }

    /// Words of all shots.
    pub(crate) fn write(&self, name: BufferId, words: &[u32]) {
        self.device.queue.write_buffer(self.buffer(name), 0, bytemuck::cast_slice(words));
    }

    /// Words of one shot, field by field.
    fn write_shot(&self, name: BufferId, shot: usize, words: &[u32]) {
        for (part, [at, _]) in words.chunks(self.sizes.shape(name)[1] as usize).zip(self.places(name, shot)) {
            self.device.queue.write_buffer(self.buffer(name), at, bytemuck::cast_slice(part));
        }
    }

    /// Offset and size of every field of a shot in a buffer [bytes].
    fn places(&self, name: BufferId, shot: usize) -> impl Iterator<Item = [u64; 2]> + use<> {
        let ([fields, count], shots) = (self.sizes.shape(name), self.sizes.shots);
        (0..fields).map(move |field| [4 * (field * shots + shot as u64) * count, 4 * count])
    }

    /// Puts the state of a single shot on the device, with sums and energy accumulators at zero.
    pub fn upload(&mut self, model: &Model<f32>, state: &State<f32>) {
        self.clear_shots();
        self.upload_shot(0, model, state);
        self.set_running(vec![0]);
    }

    /// Clears of all shots what [`Self::upload_shot`] does not write.
    pub(crate) fn clear_shots(&mut self) {
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        CLEARED.iter().for_each(|id| encoder.clear_buffer(self.buffer(*id), 0, None));
        self.device.queue.submit([encoder.finish()]);
    }

    /// Puts the state of a shot on cleared buffers of the device.
    pub(crate) fn upload_shot(&mut self, shot: usize, model: &Model<f32>, state: &State<f32>) {
        let plane = |fields| planes(&state.nodes, fields, 0, self.grid.columns + 1);
        let mut nodes = plane(0..node::COUNT).repeat(STATE_SLOTS as usize);
        nodes.extend(plane(node::COUNT..state.nodes.fields));
        nodes.resize((self.sizes.node_fields * self.sizes.nodes) as usize, 0.0);
        self.write_shot(BufferId::Nodes, shot, bytemuck::cast_slice(&nodes));
        self.write_shot(BufferId::Cells, shot, &self.cells(model, &state.elements));
        let mut counters = vec![0; STATUS_WORDS];
        counters[status::BAD_STEP] = layout::NONE;
        counters[status::AT_LIMIT] = state.step as u32;
        counters[status::HOLES] = state.holes(model) as u32;
        counters.extend(state.active.iter().flat_map(reach_words));
        self.write_shot(BufferId::Status, shot, &counters);
        if !state.over.is_empty() {
            self.write_shot(BufferId::Over, shot, &transposed(&state.over, model.plies.len(), model.nodes_per_ply()));
        }
        if let (Some(body), Some(start)) = (&state.body, &model.projectile) {
            let body = layout::body(body, &start.velocity, &layout::device_origin(model));
            self.write_shot(BufferId::Body, shot, bytemuck::cast_slice(bytemuck::bytes_of(&body)));
        }
        self.constants[shot] = layout::shot(model, shot);
        self.events_read[shot] = 0;
    }

    /// Waits until everything that was put on the device is there.
    ///
    /// # Errors
    /// When the device was lost.
    pub(crate) fn flush(&self) -> Result<(), DeviceError> {
        self.device.queue.submit([]);
        self.device.wait(None)
    }

    /// Cells for both slots, without a predictor; and the strengths of their yarns, where those vary.
    fn cells(&self, model: &Model<f32>, elements: &Rows<f32>) -> Vec<u32> {
        let (columns, count) = (self.grid.columns, self.sizes.elements as usize);
        let fields = |fields: Range<usize>| planes(elements, fields, 1, columns);
        let (alive, heights) = (fields(element::ALIVE..element::COUNT), fields(element::HEIGHT..element::ALIVE));
        let mut words = vec![0; cell::DRAG * count];
        for at in 0..count {
            let sum = self.height_sum(model, at).max(f64::MIN_POSITIVE);
            let parts = [0, 1].map(|yarn| {
                let height = f64::from(heights[yarn * count + at]) / sum;
                let steps = (height.clamp(0.0, 1.0) * cell::HEIGHT_STEPS as f64).round() as u64;
                u64::from(alive[yarn * count + at] > 0.5) << yarn | steps << (2 + 24 * yarn)
            });
            let yarns = parts[0] | parts[1];
            (words[at], words[count + at]) = (yarns as u32, (yarns >> 32) as u32);
        }
        let mut put = |numbers: Vec<f32>| words.extend(numbers.into_iter().map(f32::to_bits));
        put(match self.features.viscous {
            true => fields(element::COUNT..element::COUNT + element::VISCOUS),
            false => vec![0.0; element::VISCOUS * count],
        });
        put(fields(elements.fields - element::STRAIN..elements.fields));
        let mut words = words.repeat(STATE_SLOTS as usize);
        if let Some(strength) = &model.strength {
            let rows = self.grid.element_rows();
            let places = (0..2 * rows).flat_map(|at| (0..columns).map(move |column| (at % rows, at / rows, column)));
            words.extend(places.map(|(row, yarn, column)| (strength.factor(row, yarn, column) as f32).to_bits()));
        }
        if self.features.rate {
            let strains = elements.fields - element::STRAIN;
            let overstress = fields(strains - element::RATE..strains);
            words.extend(overstress.repeat(STATE_SLOTS as usize).into_iter().map(f32::to_bits));
        }
        words
    }

    /// Sum of the heights of warp and weft in an element, by its number in storage [m].
    fn height_sum(&self, model: &Model<f32>, element: usize) -> f64 {
        model.ply_type(self.grid.element_row(element / self.grid.columns).0).cell.height_sum
    }

    /// Reads the state of a shot back after the steps that it says are done; of the projectile what moves.
    ///
    /// # Errors
    /// When the device was lost.
    pub async fn download(&self, shot: usize, model: &Model<f32>, state: &mut State<f32>) -> Result<(), DeviceError> {
        let strains = state.elements.fields - element::STRAIN;
        let (columns, slot) = (self.grid.columns, (state.step as usize + 1) % STATE_SLOTS as usize);
        let names = [BufferId::Nodes, BufferId::Cells, BufferId::Status, BufferId::Over, BufferId::Body];
        let [nodes, cells, counters, over, body] = self.read_shot(names, shot).await?;
        for (slot, fields) in [(slot, 0..node::COUNT), (STATE_SLOTS as usize, node::COUNT..state.nodes.fields)] {
            let words = &nodes[slot * node::COUNT * self.sizes.nodes as usize..];
            set_planes(&mut state.nodes, fields, 0, columns + 1, bytemuck::cast_slice(words));
        }
        let count = self.sizes.elements as usize;
        let field = |number: usize| &cells[(slot * cell::CELL_FIELDS + number) * count..];
        let mut set = |fields: Range<usize>, numbers: &[f32]| {
            set_planes(&mut state.elements, fields, 1, columns, numbers);
        };
        let yarn = |bit: u32| field(cell::YARNS)[..count].iter().map(move |word| (word & bit).min(1) as f32);
        set(element::ALIVE..element::COUNT, &yarn(1).chain(yarn(2)).collect::<Vec<_>>());
        let (low, high) = (field(cell::YARNS), field(cell::YARNS + 1));
        let height = |at: usize, yarn: usize| {
            let word = u64::from(low[at]) | u64::from(high[at]) << 32;
            let steps = (word >> (2 + 24 * yarn)) as usize & cell::HEIGHT_STEPS;
            (steps as f64 * self.height_sum(model, at) / cell::HEIGHT_STEPS as f64) as f32
        };
        let heights: Vec<f32> = (0..2 * count).map(|at| height(at % count, at / count)).collect();
        set(element::HEIGHT..element::ALIVE, &heights);
        let viscous = element::COUNT..strains.min(element::COUNT + element::VISCOUS);
        set(viscous, bytemuck::cast_slice(field(cell::DRAG)));
        if self.features.rate {
            let from_end = (STATE_SLOTS as usize - slot) * cell::RATE_FIELDS * count;
            set(strains - element::RATE..strains, bytemuck::cast_slice(&cells[cells.len() - from_end..]));
        }
        set(strains..strains + element::STRAIN, bytemuck::cast_slice(field(cell::STRAIN)));
        state.active = counters[status::REACH..].chunks_exact(REACH_WORDS as usize).map(reach_from).collect();
        if !state.over.is_empty() {
            state.over = transposed(&over, SIDES, model.nodes_per_ply());
        }
        let start = model.projectile.as_ref();
        state.body = start.map(|start| layout::read_body(&body, start, &layout::device_origin(model)).body);
        Ok(())
    }

    /// Words of one shot of some buffers, fetched together.
    async fn read_shot<const N: usize>(&self, names: [BufferId; N], shot: usize) -> Result<[Vec<u32>; N], DeviceError> {
        let copies: Vec<(BufferId, [u64; 2])> =
            names.iter().flat_map(|name| self.places(*name, shot).map(|place| (*name, place))).collect();
        let words = self.read_copies(&copies).await?;
        let mut rest = words.as_slice();
        Ok(names.map(|name| {
            let [fields, count] = self.sizes.shape(name);
            let (own, later) = rest.split_at((fields * count) as usize);
            rest = later;
            own.to_vec()
        }))
    }

    /// All words of a buffer.
    ///
    /// # Errors
    /// When the device was lost.
    pub async fn read(&self, name: BufferId) -> Result<Vec<u32>, DeviceError> {
        self.read_part(name, 0, self.sizes.bytes(name)).await
    }

    pub(crate) async fn read_part(&self, name: BufferId, offset: u64, size: u64) -> Result<Vec<u32>, DeviceError> {
        self.read_copies(&[(name, [offset, size])]).await
    }

    /// Words of parts of buffers, by offset and size [bytes], one after another.
    async fn read_copies(&self, parts: &[(BufferId, [u64; 2])]) -> Result<Vec<u32>, DeviceError> {
        let size = parts.iter().map(|(_, [_, size])| size).sum();
        let staging = self.device.buffer("read", size, wgpu::BufferUsages::MAP_READ);
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut to = 0;
        for (id, [offset, size]) in parts {
            encoder.copy_buffer_to_buffer(self.buffer(*id), *offset, &staging, to, *size);
            to += size;
        }
        self.device.queue.submit([encoder.finish()]);
        self.fetch(&staging, size, None).await
    }

    /// Words of a mappable buffer, once a submission (or everything) is done. In a browser nothing may block: there the future is done later.
    pub(crate) async fn fetch(
        &self,
        staging: &wgpu::Buffer,
        size: u64,
        after: Option<wgpu::SubmissionIndex>,
    ) -> Result<Vec<u32>, DeviceError> {
        let (sender, mapped) = oneshot::channel();
        staging.map_async(wgpu::MapMode::Read, 0..size, move |result| {
            // The receiver is gone where the wait below fails.
            sender.send(result).ok();
        });
        self.device.wait(after)?;
        let failed = |reason: String| self.device.lost(reason);
        // Another thread that waits for the same device may be the one that reports, a moment later.
        mapped.await.map_err(|e| failed(e.to_string()))?.map_err(|e| failed(e.to_string()))?;
        let words = {
            let view = staging.get_mapped_range(0..size).map_err(|e| failed(e.to_string()))?;
            bytemuck::pod_collect_to_vec::<u8, u32>(&view)
        };
        staging.unmap();
        Ok(words)
    }
}

/// Places of a plane, shape (fields, rows·columns), in the numbers of rows; column c is stored at c + `first`.
fn plane_parts(
    rows: &Rows<f32>,
    fields: Range<usize>,
    first: usize,
    columns: usize,
) -> impl Iterator<Item = Range<usize>> + use<> {
    let (length, stride, count) = (rows.row_length(), rows.stride, rows.data.len() / rows.row_length());
    let at = move |field: usize, row: usize| row * length + field * stride + first;
    fields.flat_map(move |field| (0..count).map(move |row| at(field, row)..at(field, row) + columns))
}

fn planes(rows: &Rows<f32>, fields: Range<usize>, first: usize, columns: usize) -> Vec<f32> {
    plane_parts(rows, fields, first, columns).flat_map(|part| rows.data[part].iter().copied()).collect()
}

fn set_planes(rows: &mut Rows<f32>, fields: Range<usize>, first: usize, columns: usize, planes: &[f32]) {
    for (part, numbers) in plane_parts(rows, fields, first, columns).zip(planes.chunks_exact(columns)) {
        rows.data[part].copy_from_slice(numbers);
    }
}

/// Active region of a ply for the shaders; an empty one has a first row beyond every end.
fn reach_words(reach: &ActiveRegion) -> [u32; 4] {
    if reach.is_nothing() {
        return [layout::NONE, 0, layout::NONE, 0];
    }
    [reach.rows.start, reach.rows.end, reach.columns.start, reach.columns.end].map(|at| at as u32)
}

fn reach_from(words: &[u32]) -> ActiveRegion {
    let [rows, columns] = [0, 2].map(|at| words[at] as usize..words[at + 1] as usize);
    if rows.is_empty() { ActiveRegion::default() } else { ActiveRegion { rows, columns } }
}

/// From shape (`outer`, inner, nodes) to (inner, `outer`, nodes).
fn transposed(over: &[u32], outer: usize, nodes: usize) -> Vec<u32> {
    let inner = over.len() / (outer * nodes);
    let parts = (0..inner).flat_map(|i| (0..outer).map(move |o| (o * inner + i) * nodes));
    parts.flat_map(|at| over[at..at + nodes].iter().copied()).collect()
}
