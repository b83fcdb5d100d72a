//! Projectile contact: the laws of a strike, whatever the mesh, step or shape, in shots and in random scenes.
//!
//! Promises: no node passes into the projectile (sideways behind a sharp rim, by less than is stated); contact never pulls.
//! Red when: a sign of an impulse is wrong, the target of the common velocity misses the gap, friction exceeds μN, impulses on the
//! body differ from those on the nodes.

mod plies;

use nalgebra::Vector3;
use ripstop::case::{Motion, Rotation};
use ripstop::physics::projectile_body::Body;
use ripstop::physics::rigid_body::{MirrorPlanes, RigidBody};
use ripstop::run::{Precision, Run};
use ripstop::solver::contact::edge_contact::{EdgeConstraint, EdgeContact, SHARED};
use ripstop::solver::contact::projectile_contact::{ContactPoint, ContactTotals, resolve};

use crate::support::{Random, builtin, closes, near, run, run_as};

/// The paper's shot on a small ply that never breaks, at 144 m/s.
fn unbroken(more: &[&str], precision: Precision) -> Run {
    let sets = [
        "/projectile/velocity_m_s=144",
        "/fabric/warp/failure_strain=1",
        "/fabric/weft/failure_strain=1",
        "/pack/width_mm=50.8",
        "/pack/height_mm=50.8",
        "/solver/end_time_us=30",
        "/solver/run_until=end_time",
        "/output/profile_times_us=[]",
        "/expect=[]",
    ];
    run_as(&builtin("cases/s720-1ply-155.json", &[&sets[..], more].concat()), precision, 2)
}

#[test]
fn contact_at_the_rim_closes_the_balance_and_meets_held_nodes() {
    const RIM: &str = "/solver/contact_sampling=edges";
    let end = |run: &Run, error: f64| {
        closes(run, [error; 2]);
        run.history.last().unwrap().projectile_velocity
    };
    let [part, whole, oblique] = [
        &[RIM][..],
        &[RIM, "/solver/symmetry=\"none\""],
        &[RIM, "/projectile/obliquity_deg=20", "/projectile/azimuth_deg=30"],
    ]
    .map(|sets| unbroken(sets, Precision::F64));
    assert_eq!((part.planes.copies(), whole.planes.copies()), (4, 1));
    let [quarter, all] = [&part, &whole].map(|run| end(run, 1e-9));
    assert!((quarter - all).abs() < 1e-9 * (144.0 - all), "{quarter} {all}");
    end(&oblique, 1e-9);
    // It takes more from the projectile than nodes alone do: the face is as wide as it is.
    assert!(all < end(&unbroken(&[], Precision::F64), 1e-9) - 0.2);
    // The face is wider than the ply: its rim crosses edges of elements between two held nodes, and between a held and a free one.
    let small = [RIM, "/pack/width_mm=3.81", "/pack/height_mm=6.35", "/projectile/friction=0.3"];
    for more in [&[][..], &["/projectile/offset_mm=[0.3,-2]", "/projectile/obliquity_deg=10"]] {
        for (precision, error) in [(Precision::F64, 1e-9), (Precision::F32, 5e-3)] {
            // It lands on the clamps, or turns about those that it meets.
            let left = end(&unbroken(&[&small[..], more].concat(), precision), error);
            assert!(left.abs() < 15.0, "the clamps stop it: {left} m/s");
        }
    }
    // A drive and the clamps hold both sides of such a point: neither gives way, and the fabric inside is pushed all the same.
    let drive = ["/projectile/motion=prescribed", "/solver/end_time_us=3"];
    let driven = unbroken(&[&small[..], &drive].concat(), Precision::F64);
    let last = driven.history.last().unwrap();
    assert!(driven.energy_error < 1e-9 && last.deflection > 0.99 * last.projectile_displacement, "{}", last.deflection);
}

/// Sphere, cone and ogive: nothing gets in, but for the second-order turn of the body within a step (1 µm), and for friction, which follows
/// the normal impulses (0.1 µm). Flat and chisel nose: half a thickness sideways behind its sharp rim before failure.
#[test]
fn nothing_passes_into_the_projectile() {
    let shapes = [
        (r#""shape":"sphere","diameter_mm":8,"mass_g":2,"velocity_m_s":250,"friction":0"#, 1e-9),
        (r#""shape":"sphere","diameter_mm":8,"mass_g":2,"velocity_m_s":250"#, 1e-7),
        (r#""shape":"sphere","diameter_mm":8,"mass_g":0.01,"velocity_m_s":1000,"obliquity_deg":40,"friction":0"#, 1e-9),
        (r#""shape":"sphere","diameter_mm":8,"mass_g":0.01,"velocity_m_s":1000,"obliquity_deg":40"#, 1e-7),
        (
            r#""shape":"cone","diameter_mm":9,"length_mm":12,"nose_length_mm":8,"edge_radius_mm":0,"mass_g":2,"velocity_m_s":250"#,
            1e-6,
        ),
        (r#""shape":"ogive","diameter_mm":9,"length_mm":12,"nose_length_mm":8,"mass_g":2,"velocity_m_s":250"#, 1e-6),
        (r#""shape":"fragment","diameter_mm":8,"length_mm":12,"mass_g":2,"velocity_m_s":150,"roll_deg":20"#, 0.15e-3),
        (r#""shape":"cylinder","diameter_mm":8,"length_mm":12,"mass_g":2,"velocity_m_s":150"#, 0.15e-3),
    ];
    for (shape, allowed) in shapes {
        let projectile = format!("/projectile={{{shape}}}");
        let run = run(&builtin("cases/verify/mirror.json", &[&projectile, "/solver/end_time_us=30"]));
        assert!(run.max_penetration <= allowed, "{shape}: {} m", run.max_penetration);
        assert!(run.history.iter().any(|s| s.contact_force > 10.0), "{shape}: it never touched");
        closes(&run, [1e-9; 2]);
    }
}

/// Takes a point out of contact.
fn release(p: &mut ContactPoint) {
    (p.active, p.normal_impulse, p.friction_impulse) = (false, 0.0, Vector3::zeros());
}

fn point(normal: [f64; 3], inverse: [f64; 3]) -> ContactPoint {
    ContactPoint {
        normal: normal.into(),
        inverse: inverse.into(),
        mass: 1.0,
        part: 1.0,
        effective_mass: 1.0,
        active: true,
        ..ContactPoint::default()
    }
}

/// Length of the step [s].
const DT: f64 = 1e-7;

/// A body, nodes near its nose, and points of its rim on edges between some of the nodes, all at random.
struct Scene {
    start: RigidBody,
    body: RigidBody,
    /// Before the step.
    given: Vec<ContactPoint>,
    points: Vec<ContactPoint>,
    rim: EdgeContact,
    totals: ContactTotals,
}

fn random_body(numbers: &mut Random, kind: usize) -> RigidBody {
    let mut p = builtin("cases/verify/first-drop.json", &["/projectile/diameter_mm=6", "/projectile/length_mm=9"])
        .projectile
        .unwrap();
    (p.velocity, p.mass, p.edge_radius, p.axial_inertia, p.standoff) = (155.0, 3e-3, 0.0, None, 0.0);
    p.angular_velocity = [0, 1, 2].map(|_| 4e3 * numbers.between(-1.0, 1.0));
    (p.obliquity, p.azimuth, p.yaw) =
        (0.4 * numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0), 0.3 * numbers.between(-1.0, 1.0));
    match kind {
        1 => p.rotation = Rotation::Locked,
        2 => p.motion = Motion::Prescribed,
        // On a mirror plane a body stands upright.
        3 | 4 => (p.obliquity, p.yaw) = (0.0, 0.0),
        _ => {}
    }
    let body = RigidBody::new(&p, Body::new(&p).unwrap(), 0.0);
    match kind {
        3 => body.part(MirrorPlanes([true, false])),
        4 => body.part(MirrorPlanes([true, true])),
        _ => body,
    }
}

fn random_point(numbers: &mut Random, body: &RigidBody, friction: f64, may_be_held: bool) -> ContactPoint {
    let normal = Vector3::new(0.3 * numbers.between(-1.0, 1.0), 0.3 * numbers.between(-1.0, 1.0), 1.0).normalize();
    // Nodes of 1 to 7 µg; one in four is held, or can move along one or two axes alone.
    let mass = (4.0 + 3.0 * numbers.between(-1.0, 1.0)) * 1e-6;
    let held = if may_be_held && numbers.between(-1.0, 1.0) > 0.5 {
        [0, 1, 2].map(|_| numbers.between(-1.0, 1.0) > -0.3)
    } else {
        [false; 3]
    };
    let inverse = held.map(|held| if held { 0.0 } else { 1.0 / mass });
    let free = Vector3::from([0, 1, 2].map(|a| if held[a] { 0.0 } else { 60.0 * numbers.between(-1.0, 1.0) }));
    let mut p = point([0.0; 3], inverse);
    (p.normal, p.free, p.before, p.mass, p.friction, p.active) = (normal, free, free, mass, friction, false);
    p.arm = Vector3::new(3e-3 * numbers.between(-1.0, 1.0), 3e-3 * numbers.between(-1.0, 1.0), 5e-3);
    p.signed_distance = 1e-6 * numbers.between(-1.0, 1.0);
    p.free.z += if held[2] { 0.0 } else { body.velocity.z };
    p.before = p.free;
    p.set_effective_mass(body.mass);
    p
}

impl Scene {
    fn new(numbers: &mut Random, kind: usize, friction: f64, constraints: bool, held: bool) -> Self {
        let body = random_body(numbers, kind);
        let mut points: Vec<_> = (0..7).map(|_| random_point(numbers, &body, friction, held)).collect();
        points[6].ply = 1;
        let mut rim = EdgeContact::default();
        // The second and the third share a node, the last lies on another ply's edge.
        for nodes in if constraints { vec![[0, 1], [1, 2], [3, 4]] } else { Vec::new() } {
            let weight = 0.5 + 0.45 * numbers.between(-1.0, 1.0);
            rim.constraints.push(EdgeConstraint { nodes, weights: [weight, 1.0 - weight] });
            let mut p = random_point(numbers, &body, friction, held);
            p.ply = usize::from(nodes[0] == 3);
            p.shared = true;
            p.before = rim.constraints[rim.constraints.len() - 1].between(|node| points[node].free);
            for node in nodes {
                points[node].shared = true;
                points[node].ply = p.ply;
            }
            points.push(p);
        }
        let (start, given) = (body.clone(), points.clone());
        let mut out = Self { start, body, given, points, rim, totals: ContactTotals::default() };
        out.totals = resolve(&mut out.body, &mut out.points, &mut out.rim, DT);
        out
    }

    fn nodes(&self) -> &[ContactPoint] {
        &self.points[..self.points.len() - self.rim.constraints.len()]
    }

    /// Motion of a point along its normal under a unit impulse [1/kg], and that compliance which shared nodes add.
    fn along(&self, at: usize) -> [f64; 2] {
        let of_node = |node: usize| {
            let p = &self.points[node];
            p.inverse.component_mul(&self.points[at].normal).dot(&self.points[at].normal)
        };
        let parts = match at.checked_sub(self.nodes().len()) {
            Some(constraint) => self.rim.constraints[constraint].ends().collect(),
            None => vec![(at, 1.0)],
        };
        let along = parts.iter().map(|(node, weight)| weight * weight * of_node(*node)).sum();
        [along, if self.points[at].shared { SHARED * along } else { 0.0 }]
    }

    /// Along the normal, of a point over the surface of the body [m/s].
    fn approach(&self, at: usize) -> f64 {
        let p = &self.points[at];
        let velocity = match at.checked_sub(self.nodes().len()) {
            Some(constraint) => self.rim.constraints[constraint].between(|node| self.points[node].velocity()),
            None => p.velocity(),
        };
        (velocity - self.body.twist().at(&p.arm)).dot(&p.normal)
    }

    /// The scene before friction acts: what the normal impulses alone do.
    fn before_friction(&self) -> (RigidBody, Vec<ContactPoint>) {
        let (mut body, mut points) = (self.start.clone(), self.points.clone());
        let [moves, turns] = body.freedom;
        let (nodes, crossings) = points.split_at_mut(self.nodes().len());
        nodes.iter_mut().for_each(|p| (p.friction_impulse, p.edge_impulse) = (Vector3::zeros(), Vector3::zeros()));
        for (p, constraint) in crossings.iter().zip(&self.rim.constraints) {
            let push = p.normal * p.normal_impulse;
            constraint.ends().for_each(|(node, weight)| nodes[node].edge_impulse += push * weight);
        }
        for p in self.points.iter().filter(|_| !self.start.prescribed) {
            let push = p.normal * p.normal_impulse;
            body.velocity -= push.component_mul(&moves) / body.mass;
            if !body.locked {
                body.angular_momentum -= p.arm.cross(&push).component_mul(&turns);
            }
        }
        (body, points)
    }

    /// Kinetic energy of nodes and body [J]; `after` the step.
    fn energy(&self, after: bool) -> f64 {
        let of_node = |p: &ContactPoint| {
            let velocity = if after { p.velocity() } else { p.free };
            0.5 * p.mass * velocity.norm_squared()
        };
        let body = if after { &self.body } else { &self.start };
        self.nodes().iter().map(of_node).sum::<f64>() + body.kinetic_energy()
    }
}

/// The scenes: every kind of body, with and without friction and points of the rim.
fn scenes(seed: u64, count: usize, mut see: impl FnMut(Scene, usize)) {
    let mut numbers = Random(seed);
    for at in 0..count {
        let (kind, friction, constraints) = (at % 5, [0.0, 0.3][at / 5 % 2], at / 10 % 2 == 1);
        see(Scene::new(&mut numbers, kind, friction, constraints, true), kind);
    }
}

#[test]
fn points_push_and_keep_up_with_the_body_or_are_left_alone() {
    // These conditions have one solution: the equations are those of a least of a convex function.
    let (mut pushing, mut left) = (0, 0);
    scenes(21, 2000, |mut scene, kind| {
        let dragged = scene.points.iter().filter(|p| !p.active).any(|p| p.friction_impulse != Vector3::zeros());
        assert!(!dragged, "{kind}: what does not push is not dragged");
        (scene.body, scene.points) = scene.before_friction();
        for (at, p) in scene.points.iter().enumerate() {
            let limit = -p.signed_distance.max(0.0) / DT;
            let [along, shared] = scene.along(at);
            // What can hardly move has a mass of a thousand bodies, or of a thousand of its own.
            let least = 1.0 / (1e3 * scene.start.mass.max(p.mass));
            let give = along.max(least) - along + shared;
            let off = scene.approach(at) + give * p.normal_impulse - limit;
            if p.active {
                pushing += 1;
                assert!(p.normal_impulse >= 0.0, "{kind} {at}: {p:?}");
                assert!(off.abs() < 1e-6, "{kind} {at}: {off} of {limit}: {p:?}");
            } else {
                left += 1;
                assert!(p.normal_impulse == 0.0, "{p:?}");
                assert!(off > -1e-6, "{kind} {at}: {off}: {p:?}");
            }
        }
    });
    assert!(pushing > 3000 && left > 3000, "{pushing} {left}");
}

#[test]
fn a_wrong_guess_of_what_pushes_changes_nothing() {
    let (mut numbers, mut wrong) = (Random(26), 0);
    scenes(27, 1000, |scene, kind| {
        for share in [-0.5, 0.0, 1.0] {
            let (mut body, mut points, mut rim) = (scene.start.clone(), scene.given.clone(), scene.rim.clone());
            points.iter_mut().for_each(|p| p.was_idle = numbers.between(-1.0, 1.0) < share);
            wrong += points.iter().zip(&scene.points).filter(|(guess, p)| guess.was_idle && p.active).count();
            resolve(&mut body, &mut points, &mut rim, DT);
            for (found, p) in points.iter().zip(&scene.points) {
                assert_eq!(found.active, p.active, "{kind}: {found:?} {p:?}");
                let off = (found.impulse() - p.impulse()).norm();
                assert!(off <= 1e-9 * p.impulse().norm() + 1e-15, "{kind}: {off} {p:?}");
            }
            assert!((body.velocity - scene.body.velocity).norm() < 1e-9, "{kind}: {}", body.velocity);
        }
    });
    assert!(wrong > 3000, "{wrong}");
}

#[test]
fn what_nodes_and_body_lose_is_what_is_booked() {
    scenes(22, 1000, |scene, kind| {
        let totals = &scene.totals;
        let lost = scene.energy(false) - scene.energy(true);
        let booked = totals.dissipation + totals.friction - totals.external;
        // The last change of friction that counts as none, a billionth of it, has reached neither the body nor the ends of edges.
        let sum = |of: fn(&ContactPoint) -> f64| scene.points.iter().map(of).sum::<f64>();
        let small = 1e-13 * sum(|p| p.impulse().norm()) + 1e-9 * sum(|p| p.friction_impulse.norm()) + 1e-16;
        let fastest = 300.0;
        assert!((lost - booked).abs() < fastest * small + 1e-12 * scene.energy(false), "{kind}: {lost} {booked}");
        assert!(totals.dissipation > -1e-15 && totals.dissipation + totals.friction > -1e-15, "{totals:?}");
        if kind == 2 {
            let of = |body: &RigidBody| (body.velocity, body.angular_momentum);
            return assert_eq!(of(&scene.body), of(&scene.start));
        }
        assert_eq!(totals.external, 0.0);
        let change = (scene.body.velocity - scene.start.velocity) * scene.start.mass;
        let turn = scene.body.angular_momentum - scene.start.angular_momentum;
        let [moves, turns] = scene.start.freedom;
        let impulse = Vector3::from(totals.impulse);
        assert!((change - impulse.component_mul(&moves)).norm() < small, "{kind}: {change} {impulse}");
        let torque: Vector3<f64> = scene.points.iter().map(|p| -p.arm.cross(&p.impulse())).sum();
        let expected = if scene.start.locked { Vector3::zeros() } else { torque.component_mul(&turns) };
        assert!((turn - expected).norm() < 0.01 * small, "{kind}: {turn} {expected}");
        // What the body gives and no node takes went into the supports.
        let taken = |p: &ContactPoint| Vector3::from([0, 1, 2].map(|a| p.mass * (p.velocity() - p.free)[a]));
        let left = impulse + scene.nodes().iter().map(taken).sum::<Vector3<f64>>();
        assert!((left - Vector3::from(totals.support)).norm() < small, "{kind}: {left} {totals:?}");
    });
}

#[test]
fn friction_stops_a_node_or_drags_it_with_all_that_it_has() {
    let (mut sticking, mut sliding) = (0, 0);
    let mut numbers = Random(23);
    for (at, kind) in (0..5).cycle().take(1000).enumerate() {
        let friction = [0.3, 3.0][at % 2];
        let scene = Scene::new(&mut numbers, kind, friction, false, false);
        for p in scene.points.iter().filter(|p| p.active && p.normal_impulse > 1e-6) {
            let slide = p.velocity() - scene.body.twist().at(&p.arm);
            let slide = slide - p.normal * slide.dot(&p.normal);
            let most = friction * p.normal_impulse;
            let drag = p.friction_impulse;
            assert!(drag.norm() <= most * (1.0 + 1e-6) && drag.dot(&p.normal).abs() <= 1e-12 * most, "{kind}: {p:?}");
            if slide.norm() > 1e-2 {
                sliding += 1;
                let along = drag.dot(&slide) / (most * slide.norm());
                assert!((along + 1.0).abs() < 1e-3, "{kind}: {along}: {p:?}");
            } else {
                sticking += 1;
            }
        }
    }
    assert!(sticking > 200 && sliding > 200, "{sticking} {sliding}");
}

#[test]
fn friction_of_heavy_nodes_throws_no_light_body() {
    let mut numbers = Random(29);
    for at in 0..5000 {
        let mut scene = Scene::new(&mut numbers, 0, 2.0, false, false);
        // The body's lengths and speeds, and a thousandth of its mass or more.
        let share = 10_f64.powi(at % 4 - 3);
        let body = &mut scene.start;
        body.mass *= share;
        body.body.inertia = body.body.inertia.map(|moment| moment * share);
        body.angular_momentum *= share;
        for p in &mut scene.points {
            release(p);
            p.set_effective_mass(body.mass);
        }
        scene.body = scene.start.clone();
        scene.totals = resolve(&mut scene.body, &mut scene.points, &mut scene.rim, DT);
        let [before, after] = [false, true].map(|after| scene.energy(after));
        assert!(after <= before * (1.0 + 1e-12), "{share}: {before} J became {after} J");
        // What is booked is what was lost. Friction that met a slide before the last normal impulses may push a little after them.
        let ContactTotals { friction, dissipation, .. } = scene.totals;
        let unbooked = before - after - friction - dissipation;
        assert!(unbooked.abs() < 1e-11 * before, "{share}: {unbooked} of {before} J, {:?}", scene.totals);
        assert!(friction >= -1e-3 * before, "{share}: {:?} of {before} J", scene.totals);
    }
}

#[test]
fn points_that_ask_the_same_of_a_node_share_its_mass() {
    let body = random_body(&mut Random(5), 0);
    let mut points: Vec<_> = (0..3).map(|_| random_point(&mut Random(1), &body, 0.0, false)).collect();
    for (p, mass) in points.iter_mut().zip([2.0, 4.0, 5.0]) {
        (p.mass, p.inverse) = (mass, Vector3::repeat(1.0 / mass));
    }
    let mut rim = EdgeContact::default();
    rim.constraints.push(EdgeConstraint { nodes: [0, 1], weights: [0.75, 0.25] });
    let mut alone = points.clone();
    alone.push(point([0.0, 0.0, 1.0], [0.0; 3]));
    rim.share_masses(&mut alone, body.mass);
    // Σ w²/m.
    near(alone[3].inverse.x, 0.5625 / 2.0 + 0.0625 / 4.0, 1e-15);
    assert_eq!(alone[3].inverse.z, alone[3].inverse.x);
    assert!((alone[3].mass * alone[3].inverse.x - 1.0).abs() < 1e-15);
    assert!((alone[3].effective_mass * alone[3].inverse.x - 1.0).abs() < 1e-15);
    // A second point there has as much, and each half of it; of a third node it has none.
    rim.constraints.push(rim.constraints[0]);
    let mut two = points.clone();
    two.extend([point([0.0, 0.0, 1.0], [0.0; 3]), point([0.0, 0.0, 1.0], [0.0; 3])]);
    rim.share_masses(&mut two, body.mass);
    for at in [3, 4] {
        assert!((two[at].inverse.x - 2.0 * alone[3].inverse.x).abs() < 1e-15, "{:?}", two[at]);
    }
    // In half a scene a point that is whole has an image beside a node of which a half is there.
    rim.constraints[1] = EdgeConstraint { nodes: [1, 2], weights: [0.5, 0.5] };
    two[3].part = 0.5;
    rim.share_masses(&mut two, body.mass);
    let first = 0.75 * (0.75 * 0.5) / 0.5 / 2.0 + 0.25 * (0.25 * 0.5 + 0.5) / 0.5 / 4.0;
    let second = 0.5 * (0.25 * 0.5 + 0.5) / 4.0 + 0.5 * 0.5 / 5.0;
    assert!((two[3].inverse.y - first).abs() < 1e-15 && (two[4].inverse.y - second).abs() < 1e-15, "{two:?}");
    // Between held nodes nothing moves it, and its mass is as if they were free.
    for p in &mut two[..3] {
        p.inverse = Vector3::zeros();
    }
    rim.share_masses(&mut two, body.mass);
    assert!(two[3].inverse == Vector3::zeros() && (two[3].mass * first - 1.0).abs() < 1e-14, "{:?}", two[3]);
    assert_eq!(two[4].effective_mass, 1e3 * two[4].mass.max(body.mass));
}

#[test]
fn nothing_of_a_step_stays_for_the_next_in_which_nothing_pushes() {
    let mut scene = Scene::new(&mut Random(7), 0, 0.0, true, false);
    assert!(scene.points.iter().any(|p| p.active && p.shared), "nothing of the rim pushes");
    for p in &mut scene.points {
        release(p);
        (p.signed_distance, p.edge_impulse) = (1.0, Vector3::zeros());
    }
    let before = scene.body.clone();
    let totals = resolve(&mut scene.body, &mut scene.points, &mut scene.rim, DT);
    assert!(scene.points.iter().all(|p| p.impulse() == Vector3::zeros()), "{totals:?}");
    assert_eq!(scene.body.velocity, before.velocity);
}
