//! The state: everything that varies during a run.

use std::ops::Range;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::case::{Case, CaseError};
use crate::model::mesh::Mesh;
use crate::model::ply_type::PlyType;
use crate::model::{Model, layup};
use crate::num::scalar::Scalar;
use crate::num::simd::Aligned;
use crate::physics::rigid_body::RigidBody;
use crate::solver::element_force::BROKEN;
use crate::solver::element_totals::field as element;
use crate::solver::node_update::field as node;

/// Rows of numbers: all fields of a row lie together, so that a row is one mutable slice for one thread.
///
/// Shape (rows, fields, stride); rows run over (shot, ply, row).
#[derive(Clone, Debug, PartialEq)]
pub struct Rows<S> {
    /// The numbers.
    pub data: Aligned<S>,
    /// Fields per row.
    pub fields: usize,
    /// Numbers per field.
    pub stride: usize,
}

impl<S: Scalar> Rows<S> {
    /// Zeros. In every field `first` is where vectors begin.
    pub fn new(rows: usize, fields: usize, stride: usize, first: usize) -> Self {
        Self { data: Aligned::zeros(rows * fields * stride, first), fields, stride }
    }

    /// Numbers per row.
    pub(crate) fn row_length(&self) -> usize {
        self.fields * self.stride
    }

    /// One row, all fields.
    pub fn row(&self, row: usize) -> &[S] {
        &self.data[row * self.row_length()..(row + 1) * self.row_length()]
    }

    /// One row, all fields.
    pub fn row_mut(&mut self, row: usize) -> &mut [S] {
        let length = self.row_length();
        &mut self.data[row * length..(row + 1) * length]
    }

    /// One number.
    pub fn get(&self, row: usize, field: usize, at: usize) -> S {
        self.row(row)[field * self.stride + at]
    }

    /// One number.
    pub fn set(&mut self, row: usize, field: usize, at: usize, value: S) {
        let index = field * self.stride + at;
        self.row_mut(row)[index] = value;
    }
}

/// The fields of one row.
pub fn split<S, const F: usize>(row: &[S], stride: usize) -> [&[S]; F] {
    std::array::from_fn(|f| &row[f * stride..(f + 1) * stride])
}

/// The fields of one row, writable.
pub fn split_mut<S, const F: usize>(row: &mut [S], stride: usize) -> [&mut [S]; F] {
    let mut rest = row;
    std::array::from_fn(|_| {
        let (field, others) = std::mem::take(&mut rest).split_at_mut(stride);
        rest = others;
        field
    })
}

/// Rectangle of nodes of a ply that may have moved or move; it grows by one ring a step.
///
/// A node feels only its own elements, and they only their corners, so motion spreads by at most one ring of nodes a
/// step; contact adds what it touches. Everything outside is exactly at rest, to the last bit, and leaving it out
/// changes nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveRegion {
    /// Rows of nodes.
    pub rows: Range<usize>,
    /// Columns of nodes.
    pub columns: Range<usize>,
}

impl ActiveRegion {
    /// Everything may have moved.
    pub fn whole(mesh: &Mesh) -> Self {
        Self { rows: 0..mesh.rows + 1, columns: 0..mesh.columns + 1 }
    }

    /// Whether nothing has moved.
    pub fn is_nothing(&self) -> bool {
        self.rows.is_empty() || self.columns.is_empty()
    }

    /// Takes a node in.
    pub fn activate(&mut self, row: usize, column: usize) {
        *self = self.union(&Self { rows: row..row + 1, columns: column..column + 1 });
    }

    /// The smallest rectangle around both.
    #[must_use]
    pub(crate) fn union(&self, other: &Self) -> Self {
        if self.is_nothing() {
            return other.clone();
        }
        if other.is_nothing() {
            return self.clone();
        }
        let join = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self { rows: join(&self.rows, &other.rows), columns: join(&self.columns, &other.columns) }
    }

    /// With `rings` more nodes on every side, within the ply.
    #[must_use]
    pub fn grown(&self, rings: usize, mesh: &Mesh) -> Self {
        if self.is_nothing() {
            return Self::default();
        }
        let grow = |r: &Range<usize>, last: usize| r.start.saturating_sub(rings)..(r.end + rings).min(last + 1);
        Self { rows: grow(&self.rows, mesh.rows), columns: grow(&self.columns, mesh.columns) }
    }

    /// Rows and columns of the elements that have a corner in it.
    pub fn elements(&self, mesh: &Mesh) -> [Range<usize>; 2] {
        if self.is_nothing() {
            return [0..0, 0..0];
        }
        let span = |r: &Range<usize>, count: usize| r.start.saturating_sub(1)..r.end.min(count);
        [span(&self.rows, mesh.rows), span(&self.columns, mesh.columns)]
    }

    /// The nodes of another ply that lie over it or within `slack` [m] of that, by their reference positions.
    #[must_use]
    pub(crate) fn seen_from(&self, own: &Mesh, other: &Mesh, slack: f64) -> Self {
        if self.is_nothing() {
            return Self::default();
        }
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for row in [self.rows.start, self.rows.end - 1] {
            for column in [self.columns.start, self.columns.end - 1] {
                let [x, y] = own.reference(row, column);
                let [x, y, _] = other.to_ply(own.to_pack([x, y, 0.0]));
                for (a, at) in [x, y].into_iter().enumerate() {
                    low[a] = low[a].min(at);
                    high[a] = high[a].max(at);
                }
            }
        }
        let slack = slack + 1.5 * own.longest();
        let span = |a: usize| other.lines_between(a, [low[a] - slack, high[a] + slack]);
        Self { rows: span(1), columns: span(0) }
    }
}

/// State of a run. Nodes and elements are in the axes of their ply.
#[derive(Clone, Debug)]
pub struct State<S> {
    /// Displacement [m] and velocity [m/s] of the nodes, shape (plies·(rows + 1), 6, node stride); one more field with clay behind the pack.
    pub nodes: Rows<S>,
    /// Forces, heights and life of the elements, shape (plies·rows, 17, element stride); two more fields with viscous forces, two
    /// where stress depends on the rate of strain, and two of strains.
    pub elements: Rows<S>,
    /// Nodes of each ply that may have moved.
    pub active: Vec<ActiveRegion>,
    /// Element (row·columns + column) of the ply in front, and of the ply behind, that a node is over or was last, and
    /// [`layup::PENETRATING`] where it is too close to it;
    /// shape (plies, 2, (rows + 1)·(columns + 1)), empty for a single ply.
    pub over: Vec<u32>,
    /// The projectile.
    pub body: Option<RigidBody>,
    /// Steps done.
    pub step: u64,
}

impl<S: Scalar> State<S> {
    /// The state before the first step.
    pub fn new(case: &Case, model: &Model<S>) -> Self {
        let grid = &model.grid;
        let mut nodes =
            Rows::new(grid.node_rows(), node::COUNT + usize::from(model.backing.is_some()), grid.node_stride, 0);
        let features = model.features();
        let viscous = if features.viscous { element::VISCOUS } else { 0 };
        let rate = if features.rate { element::RATE } else { 0 };
        let fields = element::COUNT + viscous + rate + element::STRAIN;
        let mut elements = Rows::new(grid.element_rows(), fields, grid.element_stride, 1);
        let mut reach = Vec::with_capacity(grid.plies);
        for ply in 0..grid.plies {
            let ply_type = model.ply_type(ply);
            let mesh = &ply_type.mesh;
            for (row, column) in ply_type.nodes() {
                let (at, mass) = (grid.first_node_row(ply) + row, ply_type.row_mass(row));
                let x = mesh.reference(row, column);
                let z = initial_deflection(case, mesh, x);
                let start = [x[0] * ply_type.initial.stretch[0], x[1] * ply_type.initial.stretch[1], z];
                for a in 0..3 {
                    nodes.set(at, node::DISPLACEMENT + a, column, S::splat(start[a]));
                    let free = mass.inverse[a][column].to_f64() > 0.0;
                    let speed = if free { ply_type.initial_velocity[a] } else { 0.0 };
                    nodes.set(at, node::VELOCITY + a, column, S::splat(speed));
                }
            }
            for row in 0..mesh.rows {
                let at = grid.first_element_row(ply) + row;
                for column in 1..=mesh.columns {
                    for yarn in 0..2 {
                        let alive = f64::from(ply_type.present[yarn] && mesh.is_present(row, column - 1));
                        elements.set(at, element::ALIVE + yarn, column, S::splat(alive));
                        elements.set(at, element::HEIGHT + yarn, column, S::splat(ply_type.initial.height[yarn]));
                        if !mesh.is_present(row, column - 1) {
                            elements.set(at, fields - element::STRAIN + yarn, column, S::splat(BROKEN));
                        }
                    }
                }
            }
            reach.push(if model.at_rest { ActiveRegion::default() } else { ActiveRegion::whole(mesh) });
        }
        let over = layup::over_at_rest(model);
        Self { nodes, elements, active: reach, over, body: model.projectile.clone(), step: 0 }
    }

    /// Lets everything count as moving, so that nothing is left out.
    pub fn reach_everything(&mut self, model: &Model<S>) {
        self.active = (0..model.grid.plies).map(|ply| ActiveRegion::whole(&model.ply_type(ply).mesh)).collect();
    }

    /// Displacement of a node [m].
    pub fn displacement(&self, row: usize, column: usize) -> [f64; 3] {
        [0, 1, 2].map(|a| self.nodes.get(row, node::DISPLACEMENT + a, column).to_f64())
    }

    /// Velocity of a node [m/s].
    pub fn velocity(&self, row: usize, column: usize) -> [f64; 3] {
        [0, 1, 2].map(|a| self.nodes.get(row, node::VELOCITY + a, column).to_f64())
    }

    /// Whether a yarn (0 warp, 1 weft) of an element carries load.
    #[inline]
    pub fn alive(&self, row: usize, column: usize, yarn: usize) -> bool {
        self.elements.get(row, element::ALIVE + yarn, column + 1).to_f64() > 0.5
    }

    /// Whether an element still has every yarn its fabric has.
    pub fn is_undamaged(&self, ply_type: &PlyType<S>, row: usize, column: usize) -> bool {
        (0..2).all(|yarn| !ply_type.present[yarn] || self.alive(row, column, yarn))
    }

    /// Elements without a yarn that carries load.
    pub fn holes(&self, model: &Model<S>) -> usize {
        let plies = (0..model.plies.len()).map(|ply| (model.grid.first_element_row(ply), &model.ply_type(ply).mesh));
        let rows = plies.flat_map(|(first, mesh)| (first..first + mesh.rows).map(|row| (row, mesh.columns)));
        rows.map(|(row, columns)| (0..columns).filter(|column| !self.is_intact(row, *column)).count()).sum()
    }

    /// Whether any yarn of an element carries load.
    #[inline]
    pub fn is_intact(&self, row: usize, column: usize) -> bool {
        self.alive(row, column, 0) || self.alive(row, column, 1)
    }
}

/// Initial sine deflection at a reference point [m].
fn initial_deflection(case: &Case, mesh: &Mesh, x: [f64; 2]) -> f64 {
    let Some(d) = case.pack.initial_deflection else { return 0.0 };
    let [width, height] = mesh.whole_size();
    let wave = |count: u32, at: f64, length: f64| match count {
        0 => 1.0,
        n => (f64::from(n) * std::f64::consts::PI * (at / length + 0.5)).sin(),
    };
    d.amplitude * wave(d.warp_half_waves, x[0], width) * wave(d.weft_half_waves, x[1], height)
}

/// Model and state of a case: of the whole, or of the part that its mirror planes leave.
///
/// # Errors
/// When the case cannot become a model, or the projectile starts inside the fabric.
pub(crate) fn set_up<S: Scalar>(case: &Case, symmetry: bool) -> Result<(Model<S>, State<S>), CaseError> {
    let model = if symmetry { Model::<S>::part(case)? } else { Model::<S>::new(case)? };
    let state = State::new(case, &model);
    check_start(&model, &state)?;
    Ok((model, state))
}

/// Least energy that an error is measured against, over what rounding makes of the energy of a scene at rest [-].
const MEASURABLE: f64 = 1e3;

/// Energy, momentum and mass that a scene starts with, for the scale of errors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Kinetic energy, at least what rounding can be measured against [J].
    pub energy: f64,
    /// The fabric's part of it [J].
    pub fabric_energy: f64,
    /// Least energy that an error is measured against [J].
    pub measurable: f64,
    /// Momentum [kg·m/s].
    pub momentum: Vector3<f64>,
    /// Mass of the fabric [kg].
    pub fabric_mass: f64,
}

/// Energy, momentum and fabric that the scene starts with.
pub(crate) fn given<S: Scalar>(model: &Model<S>, state: &State<S>) -> Given {
    let mut energy = 0.0;
    let mut momentum = Vector3::zeros();
    for [ply, row, column] in model.node_places() {
        let ply_type = model.ply_type(ply);
        let velocity = state.velocity(model.grid.first_node_row(ply) + row, column);
        let v = Vector3::from(ply_type.mesh.to_pack(velocity));
        let m = ply_type.row_mass(row).mass[column].to_f64();
        energy += 0.5 * m * v.norm_squared();
        momentum += v * m;
    }
    let fabric_energy = energy;
    if let Some(body) = state.body.as_ref() {
        energy += body.own_energy();
        momentum += body.velocity * if body.prescribed { 0.0 } else { body.mass };
    }
    let measurable = MEASURABLE * rounding(model, state.body.as_ref());
    let energy = energy.max(measurable);
    Given { energy, fabric_energy, measurable, momentum, fabric_mass: model.fabric_mass() }
}

/// Rounding of the energy of a scene at rest [J].
fn rounding<S: Scalar>(model: &Model<S>, body: Option<&RigidBody>) -> f64 {
    let body = body.map_or(0.0, |body| {
        let moves = if body.prescribed { 0.0 } else { body.translation() };
        f64::EPSILON * moves + S::EPSILON * body.rotational_energy()
    });
    model.rounding() + body
}

/// Initial penetration is an input error, not something contact may repair.
fn check_start<S: Scalar>(model: &Model<S>, state: &State<S>) -> Result<(), CaseError> {
    let Some(body) = &state.body else { return Ok(()) };
    let depths = model.node_places().map(|place| -body.gap(&node_position(model, state, place)).0);
    let deepest = depths.fold(0.0, f64::max);
    // Room for rounding of a touching start in the state's precision.
    let rounding = 16.0 * S::EPSILON * (body.body.bounding_radius + body.position.norm());
    if deepest > rounding {
        let found = format!("a start {:.6} mm inside it", deepest * 1e3);
        return Err(CaseError::at("/projectile", "a start outside the fabric", found)
            .help("raise /projectile/standoff_mm or lower /pack/initial_deflection"));
    }
    Ok(())
}

/// Whether any element around a node still carries load; debris no longer touches anything.
#[inline]
pub fn node_stands<S: Scalar>(model: &Model<S>, state: &State<S>, [ply, row, column]: [usize; 3]) -> bool {
    let first = model.grid.first_element_row(ply);
    model.ply_type(ply).mesh.around(row, column).any(|[r, c]| state.is_intact(first + r, c))
}

/// Position of a node in the axes of the pack [m].
pub fn node_position<S: Scalar>(model: &Model<S>, state: &State<S>, place: [usize; 3]) -> Vector3<f64> {
    let [ply, row, column] = place;
    let mesh = &model.ply_type(ply).mesh;
    let u = state.displacement(model.grid.first_node_row(ply) + row, column);
    Vector3::from(model.reference(ply, row, column)) + Vector3::from(mesh.to_pack(u))
}

/// Positions of a row's nodes in the axes of the ply [m]: faster than [`node_position`] of each.
pub(crate) fn row_positions<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    ply: usize,
    row: usize,
) -> impl Iterator<Item = [f64; 3]> {
    let mesh = &model.ply_type(ply).mesh;
    let depth = model.plies[ply].z;
    let [u, v, w]: [&[S]; 3] = split(state.nodes.row(model.grid.first_node_row(ply) + row), state.nodes.stride);
    (0..=mesh.columns).map(move |column| {
        let [x, y] = mesh.reference(row, column);
        [x + u[column].to_f64(), y + v[column].to_f64(), depth + w[column].to_f64()]
    })
}
