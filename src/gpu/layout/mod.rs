//! Layouts that the host and the shaders share: uniforms, the projectile, failures, counters and sums.
//!
//! A struct here has the name, the fields and the offsets of a struct in the shaders, which documents the fields. A test compares both.

mod scene;

use bytemuck::{Pod, Zeroable};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::physics::rigid_body::RigidBody;
pub use scene::*;

/// Field of a struct that the shaders have too.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Name in Rust. A field that is an array may be several fields in the shaders, such as `_x`, `_y`, `_z`.
    pub name: &'static str,
    /// Type in Rust.
    pub kind: &'static str,
    /// First byte.
    pub offset: usize,
    /// Size [bytes].
    pub size: usize,
}

/// Structs as the shaders declare them, with a list of their fields.
macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
        #[repr(C)]
        #[allow(missing_docs, reason = "the shaders document the fields")]
        pub struct $name {
            $(pub $field: $kind),*
        }

        impl $name {
            /// Fields in order.
            pub const FIELDS: &'static [Field] = &[$(Field {
                name: stringify!($field),
                kind: stringify!($kind),
                offset: std::mem::offset_of!($name, $field),
                size: size_of::<$kind>(),
            }),*];
        }
    )*};
}
pub(crate) use shared;

/// Name, fields and size [bytes] of every shared struct.
pub const LAYOUTS: [(&str, &[Field], usize); 7] = [
    ("Scene", Scene::FIELDS, size_of::<Scene>()),
    ("Step", Step::FIELDS, size_of::<Step>()),
    ("Shot", Shot::FIELDS, size_of::<Shot>()),
    ("Ply", Ply::FIELDS, size_of::<Ply>()),
    ("Line", Line::FIELDS, size_of::<Line>()),
    ("Body", Body::FIELDS, size_of::<Body>()),
    ("Event", Event::FIELDS, size_of::<Event>()),
];

/// Invocations per workgroup of the kernels over elements and nodes.
pub const GROUP: u32 = 64;
/// Invocations of a workgroup of contact with the projectile: where few nodes may touch, and where many may. Every device has as many.
pub const CONTACT_GROUPS: [u32; 2] = [64, 256];
/// Number for none: no step with a number that is not finite, no place, no ply.
pub const NONE: u32 = u32::MAX;
/// Elements of a tile that a workgroup computes: a row and a column more than it owns.
pub const INVOCATIONS: u32 = 256;
/// Slots in which the state lies by turns.
pub(crate) const STATE_SLOTS: u64 = 2;
/// Fields of a node in a slot: displacement, velocity.
pub(crate) const NODE_FIELDS: u64 = 6;
/// Energies of a node in contact between plies.
pub(crate) const CONTACT_WORK_FIELDS: u64 = 5;
/// Fields of an element whose strength varies: failure strains of warp and weft over the fabric's.
pub(crate) const STRENGTH_FIELDS: u64 = 2;
/// Words of a contact between plies.
pub const CONTACT_WORDS: u64 = 8;
/// Fields of the impulses of contact between plies.
pub const IMPULSE_FIELDS: u64 = 6;
/// Words of the active region of a ply.
pub(crate) const REACH_WORDS: u64 = 4;
/// Words of a node near the projectile.
pub const POINT_WORDS: u64 = 32;
/// Numbers of every 32 nodes in the marks of the nodes near the projectile.
pub const MARKS: u32 = 5;
/// Words of a place where the projectile may touch.
pub const TOUCH_WORDS: u64 = 32;
/// Entries of a row of the equations of points that share nodes that there is room for in the mean of a ply. Measured: 6 at most, under a face
/// of 20 mm, in a torn ply and in packs.
pub const MATRIX_ROW: u32 = 32;
/// Words of what the search finds on a ply.
pub const FOUND_WORDS: u32 = 30;
/// Words of a failure event.
pub const EVENT_WORDS: u64 = size_of::<Event>() as u64 / 4;
/// Words of the counters.
pub const STATUS_WORDS: usize = 14;
/// Words of the projectile.
pub const BODY_WORDS: usize = size_of::<Body>() / 4;

/// Numbers by name, which the shaders have too.
macro_rules! numbers {
    ($($(#[$doc:meta])* $module:ident { $($name:ident = $value:literal),* $(,)? })*) => {$(
        $(#[$doc])*
        #[allow(missing_docs, reason = "the shaders document the numbers")]
        pub mod $module {
            $(pub const $name: usize = $value;)*
        }
    )*};
}

numbers! {
    /// Words of `status`; active regions of the plies begin at the last.
    status {
        BAD_STEP = 0, EVENTS = 1, FAILED = 2, ERODED = 4, UNCONVERGED = 5, RESIDUAL = 6, OVERFLOW = 7, COMPUTED = 8,
        PLY_DEPTH = 10, OVERFLOW_EDGES = 11, AT_LIMIT = 12, HOLES = 13, REACH = 14,
    }

    /// Fields of an element in a slot, and steps of a height to the sum of both.
    cell { YARNS = 0, DRAG = 3, STRAIN = 5, CELL_FIELDS = 7, RATE_FIELDS = 2, HEIGHT_STEPS = 0xff_ffff }

    /// Numbers of a node of a ply with clay behind it, after its vectors.
    clay { CRATER = 0, TAKEN = 1, INTO_CLAY = 2, CLAY_FIELDS = 3 }

    /// Sums of the energy balance. Those of a tile come first.
    sum {
        WORK = 0, VISCOUS_WORK = 1, EVALUATIONS = 2, RELEASED = 3, RELEASED_HOURGLASS = 4, LAW_RELEASED = 5,
        HALF_STEP = 6, STORED = 7, HOURGLASS_NOW = 8, LAW_MADE = 9, SOLVED = 10, DEFLECTION = 11, TENSION = 12,
        LOAD = 13, TILE_SUMS = 14, KINETIC = 14, FASTEST = 15, MOMENTUM = 16, SUPPORT = 19, COVERED = 22, PLY_LOSS = 23,
        PLY_FRICTION_WORK = 24, PLY_SEPARATION_WORK = 25, CLAY_WORK = 26, CLAY_DEPTH = 27, SUMS = 28,
    }
}

shared! {
    /// Yarn failure.
    Event { step: u32, element: u32, yarn: u32, strain: f32 }

    /// Projectile.
    Body {
        coarse: [i32; 4], fine: [i32; 4], change: [f32; 4], orientation: [f32; 4], angular_momentum: [f32; 4],
        velocity: [f32; 4], turning: [f32; 4], coarse_before: [i32; 4], fine_before: [i32; 4], change_before: [f32; 4],
        impulse: [f32; 4], support: [f32; 4], energy: [f32; 4], nose_coarse: [i32; 4], nose_fine: [i32; 4],
    }
}

/// Fine steps of a position per metre.
pub const FIXED_POINT_SCALE: f64 = (1_u64 << 34) as f64;

/// Coarse and fine part of a position [m].
fn fixed(position: &Vector3<f64>) -> [[i32; 4]; 2] {
    let mut parts = [[0; 4]; 2];
    for a in 0..3 {
        let steps = (position[a] * FIXED_POINT_SCALE).round() as i64;
        (parts[0][a], parts[1][a]) = ((steps >> 24) as i32, (steps & 0xff_ffff) as i32);
    }
    parts
}

fn metres(coarse: [i32; 4], fine: [i32; 4]) -> Vector3<f64> {
    let steps = |a: usize| (i64::from(coarse[a]) << 24) + i64::from(fine[a]);
    Vector3::from([0, 1, 2].map(|a| steps(a) as f64 / FIXED_POINT_SCALE))
}

/// Projectile for the shaders. `impact`: its velocity at the start [m/s]; `origin`: of the device's coordinates [m].
pub fn body(body: &RigidBody, impact: &Vector3<f64>, origin: &Vector3<f64>) -> Body {
    let vector = |v: &Vector3<f64>, w: f64| [v.x, v.y, v.z, w].map(|x| x as f32);
    let (q, position) = (body.orientation, body.position - origin);
    let tip = position + q.transform_vector(&Vector3::new(0.0, 0.0, nose(body)));
    let ([coarse, fine], [nose_coarse, nose_fine]) = (fixed(&position), fixed(&tip));
    let change = vector(&(body.velocity - impact), 0.0);
    Body {
        coarse,
        fine,
        change,
        orientation: [q.i, q.j, q.k, q.w].map(|x| x as f32),
        angular_momentum: vector(&body.angular_momentum, 0.0),
        velocity: vector(&body.velocity, body.speed_bound()),
        turning: vector(&body.angular_velocity(), 0.0),
        coarse_before: coarse,
        fine_before: fine,
        change_before: change,
        nose_coarse,
        nose_fine,
        ..Body::default()
    }
}

/// Projectile after a step, and its sums since the last sample.
#[derive(Clone, Debug)]
pub struct BodyRecord {
    /// After the step.
    pub body: RigidBody,
    /// Velocity [m/s] and position [m] before.
    pub before: (Vector3<f64>, Vector3<f64>),
    /// Impulse on it since the last sample [N·s].
    pub impulse: [f64; 3],
    /// Work on the elements by the velocities that contact changed, since then and in the last half step [J].
    pub work: [f64; 2],
    /// Impulse of supports and drive through contact since then [N·s].
    pub support: [f64; 3],
    /// Lost to contact, to friction, work of the drive since then [J].
    pub energy: [f64; 3],
    /// Deepest node so far [m].
    pub penetration: f64,
}

/// Reads the words of a [`Body`]; what never changes comes from `start`, the projectile before its first step. `origin`: of the device's
/// coordinates [m].
pub fn read_body(words: &[u32], start: &RigidBody, origin: &Vector3<f64>) -> BodyRecord {
    let own: &Body = bytemuck::from_bytes(bytemuck::cast_slice(&words[..BODY_WORDS]));
    let vector = |v: [f32; 4]| Vector3::new(v[0], v[1], v[2]).cast::<f64>();
    let [i, j, k, w] = own.orientation.map(f64::from);
    BodyRecord {
        body: RigidBody {
            position: origin + metres(own.coarse, own.fine),
            velocity: start.velocity + vector(own.change),
            orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)),
            angular_momentum: vector(own.angular_momentum),
            ..start.clone()
        },
        before: (start.velocity + vector(own.change_before), origin + metres(own.coarse_before, own.fine_before)),
        impulse: vector(own.impulse).into(),
        work: [own.impulse[3], own.support[3]].map(f64::from),
        support: vector(own.support).into(),
        energy: vector(own.energy).into(),
        penetration: f64::from(own.energy[3]),
    }
}

/// Sums of the workgroups of one sample, shape (plies, groups of a ply, [`sum::SUMS`]).
#[derive(Clone, Copy)]
pub struct WorkgroupSums<'a>(pub &'a [u32]);

impl WorkgroupSums<'_> {
    /// Sums of one ply of `plies`.
    pub fn ply(&self, ply: usize, plies: usize) -> Self {
        let words = self.0.len() / plies;
        Self(&self.0[ply * words..(ply + 1) * words])
    }

    fn parts(&self, which: usize) -> impl Iterator<Item = f64> {
        self.0.chunks_exact(sum::SUMS).map(move |group| f64::from(f32::from_bits(group[which])))
    }

    /// Sum over the workgroups, in order.
    pub fn add(&self, which: usize) -> f64 {
        self.parts(which).sum()
    }

    /// Largest over the workgroups.
    pub fn largest(&self, which: usize) -> f64 {
        self.parts(which).fold(0.0, f64::max)
    }
}
