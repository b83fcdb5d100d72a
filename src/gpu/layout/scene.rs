//! Constants of a batch, its ply types, plies, grid lines and shots, and of a step, as the shaders read them.

use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;

use super::{Field, shared};
use crate::case::{Edge, Edges};
use crate::gpu::buffers::Sizes;
use crate::model::layup::{shoulder, unbroken_cells};
use crate::model::mesh::Mesh;
use crate::model::ply_type::PlyType;
use crate::model::{Model, unit_cell};
use crate::physics::kinematics::ElementConstants;
use crate::physics::ply_contact;
use crate::physics::projectile_shape::CORNERS;
use crate::physics::rigid_body::{Cut, RigidBody};
use crate::physics::yarn_law::{Curve, RAMPS};

/// Bytes between the constants of two ply types.
pub(crate) const SCENE_STRIDE: u64 = 512;
/// Bytes between the tables of two ply types: energy of the law, then curves of the yarns, to the alignment every device grants.
pub(crate) const LAW_STRIDE: u64 = 6656;
/// Bytes between the uniforms of two steps: the alignment every device grants.
pub(crate) const STEP_STRIDE: u64 = 256;
/// Most plies there are.
pub(crate) const PLIES: usize = 64;
/// Most shots in a batch: their constants fill a uniform of the size that every device grants.
pub const SHOTS: u64 = 2048;
/// Numbers of a grid line.
pub const LINE_NUMBERS: usize = size_of::<Line>() / size_of::<f32>();
/// Speed of any node over the largest at the start, at most: all the energy in one place.
const SPEED_MARGIN: f64 = 4.0;

shared! {
    /// Constants of the shots of a batch and of one of their ply types.
    Scene {
        columns: u32, rows: u32, elements: u32, nodes: u32, shot_elements: u32, shot_nodes: u32, plies: u32,
        ply_type: u32,
        stiffness: [f32; 2], half_span: [f32; 2], crimp: [f32; 2], failure_strain: [f32; 2], slack: [f32; 2],
        gradient: [f32; 2], membrane: [f32; 2], half_length: [f32; 2], hourglass: [f32; 2], viscosity: [f32; 2],
        viscous_length: [f32; 2], failure_reach: [f32; 2],
        height_sum: f32, compression_a: f32, compression_b: f32, compression_offset: f32,
        compression_uncompressed: f32, compression_per_b: f32, min_stiffness: f32, roundoff_tolerance: f32,
        tolerance: f32, shear_g1: f32, shear_rise: f32, shear_gamma1: f32, shear_ramp: f32, shear_slope: f32,
        per_steep: f32,
        rate_c: f32, rate_power: f32, rate_most: f32, mode_share: f32, cells: f32, area: f32,
        dt: f32, body_radius: f32, body_bounding_radius: f32, body_nose: f32,
        body_back: f32, body_shoulder: f32, body_prescribed: u32, body_bar: u32, friction: f32, ply_friction: f32, rim_depth: f32,
        profile_radius: f32, profile_count: u32, profile_flat: u32, profile_arc: f32, chisel: u32, chisel_half: f32,
        chisel_sine: f32, chisel_cosine: f32, chisel_slope: f32, chisel_corner: f32, points: u32, groups: u32,
        body_held: u32, mirror: u32, constraints: u32, lines: u32, body_inertia: [f32; 3], body_mass: f32,
        profile: [[f32; 4]; CORNERS],
    }

    /// One step.
    Step { index: u32, slot: u32, since: u32, kick: f32, span: f32 }

    /// Constants of one shot of a batch.
    Shot { impact: [f32; 3], impulse_unit: f32, travel: f32, number: u32, pad: [u32; 2] }

    /// One ply.
    Ply {
        rows: u32, columns: u32, ply_type: u32, present: u32, origin: [f32; 2], length: [f32; 2], cosine: f32,
        sine: f32, z: f32, depth: f32, touching: f32, thickness: f32, mass: f32, inverse_mass: f32,
        held: u32, span: u32, longest: f32, shares: u32, clay_gap: f32,
        clay_rate: f32, clay_gain: f32, pad: u32,
    }

    /// One grid line.
    Line {
        place: f32, width: f32, per_width: f32, share: f32, yarn_first: f32, yarn_end: f32, breaking_first: f32,
        breaking_end: f32,
    }
}

/// One step of the host loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInfo {
    /// Counted from 0.
    pub index: u64,
    /// Slot of its sample; `None` where it has none.
    pub slot: Option<u32>,
    /// Steps since the last sample.
    pub since: u32,
    /// Time step [s].
    pub dt: f64,
}

/// Uniform of a step: at the start velocities take half a step.
pub fn step(info: &StepInfo) -> Step {
    let first = info.index == 0;
    Step {
        index: info.index as u32,
        slot: info.slot.unwrap_or(super::NONE),
        since: info.since,
        kick: (if first { 0.5 * info.dt } else { info.dt }) as f32,
        span: (if first { 0.0 } else { info.dt }) as f32,
    }
}

fn single<const N: usize>(numbers: [f64; N]) -> [f32; N] {
    numbers.map(|x| x as f32)
}

/// Constants of the shots of a batch and of one of their ply types, with the room there is in the buffers.
pub fn scene(model: &Model<f32>, ply_type: usize, sizes: &Sizes) -> Scene {
    let grid = &model.grid;
    let mirror = model.mirror.0.into_iter().enumerate().map(|(axis, plane)| u32::from(plane) << axis).sum();
    let scene = Scene {
        columns: grid.columns as u32,
        rows: grid.rows as u32,
        elements: (sizes.shots * sizes.elements) as u32,
        nodes: (sizes.shots * sizes.nodes) as u32,
        lines: sizes.lines_at() as u32,
        shot_elements: sizes.elements as u32,
        shot_nodes: sizes.nodes as u32,
        plies: grid.plies as u32,
        ply_type: ply_type as u32,
        ply_friction: model.ply_friction as f32,
        dt: model.dt as f32,
        friction: model.friction as f32,
        points: sizes.points as u32,
        groups: sizes.groups as u32,
        constraints: sizes.constraints as u32,
        mirror,
        ..element(&model.ply_types[ply_type])
    };
    match &model.projectile {
        Some(body) => projectile(scene, body),
        // Without a projectile its numbers are never read; ones keep quotients finite.
        None => Scene { body_mass: 1.0, body_inertia: [1.0; 3], body_bounding_radius: 1.0, profile_count: 1, ..scene },
    }
}

/// Constants of the elements of a ply type.
fn element(ply_type: &PlyType<f32>) -> Scene {
    let c: ElementConstants<f32> = ply_type.constants();
    let yarns = &c.cell.yarn;
    Scene {
        stiffness: yarns.each_ref().map(|yarn| yarn.stiffness),
        half_span: yarns.each_ref().map(|yarn| yarn.half_span),
        crimp: yarns.each_ref().map(|yarn| yarn.crimp),
        failure_strain: yarns.each_ref().map(|yarn| yarn.failure_strain),
        slack: yarns.each_ref().map(|yarn| yarn.slack_slope),
        height_sum: c.cell.height_sum,
        compression_a: c.cell.compression[0],
        compression_b: c.cell.compression[1],
        compression_offset: c.cell.compression[2],
        compression_uncompressed: c.cell.uncompressed_limit,
        compression_per_b: c.cell.per_b,
        min_stiffness: c.cell.min_stiffness,
        roundoff_tolerance: c.cell.roundoff_tolerance,
        tolerance: c.cell.tolerance,
        shear_g1: c.shear.g1,
        shear_rise: c.shear.rise,
        shear_gamma1: c.shear.gamma1,
        shear_ramp: c.shear.ramp,
        shear_slope: c.shear.slope,
        gradient: c.gradient,
        membrane: c.membrane,
        half_length: c.half_length,
        hourglass: c.hourglass,
        viscosity: c.viscosity,
        viscous_length: c.viscous_length,
        per_steep: c.per_steep,
        rate_c: c.rate.map_or(0.0, |rate| rate.c),
        rate_power: c.rate.map_or(0.0, |rate| rate.power as f32),
        rate_most: c.rate.map_or(0.0, |rate| rate.most),
        mode_share: c.mode_share,
        failure_reach: single(ply_type.failure_reach.along),
        cells: c.cells,
        area: c.area,
        ..Scene::default()
    }
}

/// Adds the constants of the projectile.
fn projectile(scene: Scene, body: &RigidBody) -> Scene {
    let (shape, nose) = (&body.body.profile, nose(body));
    let rear = shape.corner[..shape.count].iter().map(|c| c[1]).fold(f64::MAX, f64::min) - shape.radius;
    let scene = Scene {
        body_mass: body.mass as f32,
        body_inertia: single(body.body.inertia),
        body_radius: body.body.radius as f32,
        body_bounding_radius: body.body.bounding_radius as f32,
        body_nose: nose as f32,
        body_back: (rear - nose) as f32,
        body_shoulder: (shoulder(body) - nose) as f32,
        body_prescribed: body.prescribed.into(),
        body_bar: shape.bar.into(),
        rim_depth: body.rim_depth as f32,
        profile_radius: shape.radius as f32,
        profile_count: shape.count as u32,
        profile_flat: shape.is_flat().into(),
        profile_arc: shape.arc as f32,
        body_held: body_held(body),
        profile: std::array::from_fn(|i| {
            let (corner, normal) = (shape.corner[i], shape.normal[i]);
            single([corner[0], corner[1] - nose, normal[0], normal[1]])
        }),
        ..scene
    };
    let Some(chisel) = shape.chisel else { return scene };
    Scene {
        chisel: 1,
        chisel_half: chisel.half as f32,
        chisel_sine: chisel.sine as f32,
        chisel_cosine: chisel.cosine as f32,
        chisel_slope: chisel.slope as f32,
        chisel_corner: chisel.corner as f32,
        ..scene
    }
}

/// Directions that mirror planes hold: of velocity, of turning, a bit each; every turning of a locked body.
fn body_held(body: &RigidBody) -> u32 {
    let [moves, turns] = if body.locked { [body.freedom[0], Default::default()] } else { body.freedom };
    moves.iter().chain(&turns).enumerate().filter(|(_, free)| **free == 0.0).map(|(bit, _)| 1_u32 << bit).sum()
}

/// Distance from the centre of mass to the tip of the nose along the axis [m]: the device measures gaps from there.
pub(super) fn nose(body: &RigidBody) -> f64 {
    let profile = &body.body.profile;
    profile.corner[..profile.count].iter().map(|c| c[1]).fold(f64::MIN, f64::max) + profile.radius
}

/// Energy made by the unit-cell law of a ply type: first place and places per stretch of warp and weft, then the table; and the ramps of its
/// yarns: start and rise of the warp, start and rise of the weft.
pub fn law_energy(ply_type: &PlyType<f32>) -> Vec<f32> {
    let mut numbers = vec![0.0; LAW_STRIDE as usize / 4];
    if let Some(table) = &ply_type.law_energy {
        let head = table.low.iter().chain(&table.per_stretch);
        numbers.iter_mut().zip(head.chain(&table.values)).for_each(|(number, value)| *number = *value as f32);
    }
    let ramps = numbers[4 + unit_cell::PLACES * unit_cell::PLACES..].as_chunks_mut::<4>().0;
    for (index, ramp) in ramps.iter_mut().enumerate().take(RAMPS) {
        // A linear yarn beside one that is not has one ramp.
        let of = |curve: &Curve| {
            if curve.count == 0 && index == 0 { [0.0, 1.0] } else { [curve.start[index], curve.rise[index]] }
        };
        let [warp, weft] = [0, 1].map(|yarn: usize| of(&ply_type.cell.yarn[yarn].curve));
        *ramp = single([warp[0], warp[1], weft[0], weft[1]]);
    }
    numbers
}

/// Origin of the device's coordinates, in the axes of the pack [m]: the middle of the finest elements. Single precision rounds a position by
/// its size: 30 mm from there by 2e-9 m, which contact would close within a step by 0.05 m/s. Shots on the same meshes have the same origin,
/// so that they can be computed together.
pub fn device_origin(model: &Model<f32>) -> Vector3<f64> {
    let mesh = &model.ply_type(0).mesh;
    if !mesh.is_graded() {
        return Vector3::zeros();
    }
    let [x, y] = mesh.middle_of_finest();
    mesh.to_pack([x, y, 0.0]).into()
}

/// Mass of an inner node of the finest elements [kg].
fn node_mass(ply_type: &PlyType<f32>) -> f64 {
    ply_type.areal_density * ply_type.mesh.length[0] * ply_type.mesh.length[1]
}

/// The plies, the struck one first.
pub fn plies(model: &Model<f32>) -> Vec<Ply> {
    let (from, is_framed) = (device_origin(model), model.features().frame);
    let ply = |at: usize| {
        let (own, ply_type) = (&model.plies[at], model.ply_type(at));
        let (mesh, mass) = (&ply_type.mesh, node_mass(ply_type));
        // Plies that touch at rest do so exactly, whatever their places round to.
        let apart = model.plies.get(at + 1).map_or(0.0, |next| next.z as f32 - own.z as f32);
        let [x, y, _] = mesh.to_ply(from.into());
        let [clay_gap, clay_rate, clay_gain] = single(model.clay(at).unwrap_or_default());
        Ply {
            rows: mesh.rows as u32,
            columns: mesh.columns as u32,
            ply_type: own.ply_type as u32,
            present: u32::from(ply_type.present[0]) + 2 * u32::from(ply_type.present[1]),
            origin: single([mesh.origin[0] - x, mesh.origin[1] - y]),
            length: single(mesh.length),
            cosine: mesh.rotation[0] as f32,
            sine: mesh.rotation[1] as f32,
            z: own.z as f32,
            depth: own.depth as f32,
            touching: (own.touching as f32).min(apart),
            thickness: own.thickness as f32,
            mass: mass as f32,
            inverse_mass: (1.0 / mass) as f32,
            held: constrained(&ply_type.edges) | cut_sides(mesh) << 12,
            span: model.projectile.as_ref().map_or(0, |body| unbroken_cells(mesh, body) as u32),
            longest: mesh.longest() as f32,
            shares: if is_framed { (grid_numbers(model) + own.ply_type * frame_numbers(model)) as u32 } else { 0 },
            clay_gap,
            clay_rate,
            clay_gain,
            pad: 0,
        }
    };
    (0..model.plies.len()).map(ply).collect()
}

/// Constrained directions of the sides, three bits each: left, right, bottom, top.
fn constrained(edges: &Edges) -> u32 {
    let side = |edge: Edge, roller: u32| match edge {
        Edge::Clamped => 7,
        Edge::Roller => roller,
        Edge::Free => 0,
    };
    side(edges.left, 1) | side(edges.right, 1) << 3 | side(edges.bottom, 2) << 6 | side(edges.top, 2) << 9
}

/// Sides that mirror planes cut: left, right, bottom, top, a bit each.
fn cut_sides(mesh: &Mesh) -> u32 {
    let [x, y] = mesh.cut.map(|cut| match cut {
        Cut::Nowhere => 0,
        Cut::First => 1,
        Cut::Last => 2,
    });
    x | y << 2
}

/// A grid line across the X (0) or Y (1) of a ply of a ply type, with one more behind the last. `from`: origin of the device's coordinates,
/// in the axes of the pack [m].
pub fn line(ply_type: &PlyType<f32>, from: &Vector3<f64>, axis: usize, line: usize) -> Line {
    let mesh = &ply_type.mesh;
    let last = [mesh.columns, mesh.rows][axis];
    let element = line.min(last - 1);
    let from = mesh.to_ply((*from).into())[axis];
    let place = |line: usize| mesh.reference(line * axis, line * (1 - axis))[axis] - from;
    let width = mesh.widths(element * axis, element * (1 - axis))[axis];
    let yarn = mesh.side_by_side(axis, element, ply_type.failure_reach.breadth[1 - axis]);
    let breaking = &ply_type.windows[axis].breaking[element];
    Line {
        place: (if line > last { place(last) + width * mesh.length[axis] } else { place(line) }) as f32,
        width: width as f32,
        per_width: (1.0 / width) as f32,
        share: if line > last { 0.0 } else { mesh.lines[axis].share(line) as f32 },
        yarn_first: yarn.start as f32,
        yarn_end: yarn.end as f32,
        breaking_first: breaking.start as f32,
        breaking_end: breaking.end as f32,
    }
}

/// Grid lines, shape (ply types, axes, room for the longest axis, 8); then what frames say of nodes.
pub fn lines(model: &Model<f32>) -> Vec<f32> {
    let room = lines_room(model);
    let (mut out, from) = (Vec::new(), device_origin(model));
    for ply_type in &model.ply_types {
        for (axis, elements) in [ply_type.mesh.columns, ply_type.mesh.rows].into_iter().enumerate() {
            let end = out.len() + room;
            out.extend((0..elements + 2).map(|at| line(ply_type, &from, axis, at)));
            out.resize(end, Line::default());
        }
    }
    let mut numbers = bytemuck::cast_slice(&out).to_vec();
    if model.features().frame {
        numbers.extend(model.ply_types.iter().flat_map(|ply_type| frame(model, ply_type)));
    }
    numbers
}

/// Room for the lines across an axis of a ply type.
fn lines_room(model: &Model<f32>) -> usize {
    model.grid.columns.max(model.grid.rows) + 2
}

/// Numbers of the grid lines, without what frames say of nodes.
fn grid_numbers(model: &Model<f32>) -> usize {
    LINE_NUMBERS * 2 * model.ply_types.len() * lines_room(model)
}

/// Numbers that frames say of the nodes of a ply type.
fn frame_numbers(model: &Model<f32>) -> usize {
    if model.features().frame { 2 * model.nodes_per_ply() } else { 0 }
}

/// Numbers of [`lines`].
pub(crate) fn line_numbers(model: &Model<f32>) -> usize {
    grid_numbers(model) + model.ply_types.len() * frame_numbers(model)
}

/// Shares of the nodes of a ply type in the mass of an inner node of the finest elements, negative or 0 where they are held, then 1 for the
/// elements that are there; shape (2, rows + 1, columns + 1) of the storage.
fn frame(model: &Model<f32>, ply_type: &PlyType<f32>) -> Vec<f32> {
    let (mesh, across) = (&ply_type.mesh, model.grid.columns + 1);
    let mut numbers = vec![0.0; frame_numbers(model)];
    for (row, column) in ply_type.nodes() {
        let share = f64::from(ply_type.row_mass(row).mass[column]) / node_mass(ply_type);
        let at = row * across + column;
        numbers[at] = if ply_type.is_clamped(row, column) { -share } else { share } as f32;
        let is_element = row < mesh.rows && column < mesh.columns;
        numbers[model.nodes_per_ply() + at] = f32::from(u8::from(is_element && mesh.is_present(row, column)));
    }
    numbers
}

/// Constants of a shot with that place in storage.
pub fn shot(model: &Model<f32>, number: usize) -> Shot {
    let impact = model.projectile.as_ref().map_or_else(Vector3::zeros, |body| body.velocity);
    Shot {
        impact: single(impact.into()),
        impulse_unit: impulse_unit(model) as f32,
        travel: (model.dt * SPEED_MARGIN * start_speed(model)) as f32,
        number: number as u32,
        pad: [0; 2],
    }
}

/// Unit of counted impulses between plies [N·s]: sums are whole numbers of 32 bits, with room for eight times the largest speed at the start,
/// and for driving nodes out of other plies, which does not depend on any speed. Light touches of many corners may add up to a few times
/// that. In a graded mesh nodes of larger elements count in larger units.
fn impulse_unit(model: &Model<f32>) -> f64 {
    let heaviest = model.ply_types.iter().map(node_mass).fold(0.0, f64::max);
    heaviest * (8.0 * start_speed(model) + 4.0 * ply_contact::FASTEST) / f64::from(1_u32 << 31)
}

/// Largest speed at the start [m/s], or 1 where nothing moves yet.
fn start_speed(model: &Model<f32>) -> f64 {
    let fabric =
        model.ply_types.iter().map(|ply_type| Vector3::from(ply_type.initial_velocity).norm()).fold(0.0, f64::max);
    let speed = fabric.max(model.projectile.as_ref().map_or(0.0, RigidBody::speed_bound));
    if speed > 0.0 { speed } else { 1.0 }
}
