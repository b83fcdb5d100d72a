//! States to compare kernels on: random and at the edges of what a run meets.

pub(crate) mod packs;
pub(crate) mod struck;

use ripstop::case::{Case, Compression, Crossover, Edge, Grading, HitPlace, LinesFrom, Variability, YarnStrength};
use ripstop::kernels::element_force::{BROKEN, field as element};
use ripstop::kernels::node_update::field as node;
use ripstop::model::Model;
use ripstop::solver::active_region::ActiveRegion;
use ripstop::solver::state::State;

use packs::Group;

use crate::support::patch::{self, affine};
use crate::support::{CROSSOVERS, Random, SOLVER_LAWS};

/// A state, and which kernels have something to do in it.
pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) model: Model<f32>,
    pub(crate) state: State<f32>,
    /// Whether elements are evaluated; contact scenes bring random forces instead.
    pub(crate) elements: bool,
    /// Whether its plies meet.
    pub(crate) pack: bool,
    /// Whether a free projectile meets held nodes.
    pub(crate) held: bool,
    /// Largest speed [m/s].
    pub(crate) speed: f64,
}

/// Every shape of a projectile, and packs under one.
pub(crate) fn contact_scenes() -> Vec<Scene> {
    struck::scenes().into_iter().chain(struck::pack_scenes()).chain(struck::rim_scenes()).collect()
}

/// Uniform deformations (where the unit vectors along warp and weft go) and the noise added to them [element lengths];
/// every ply has its own: at rest, taut, breaking, compressed, sheared, sheared into locking, folded, collapsed.
const DEFORMATIONS: [([f64; 3], [f64; 3], f64); 8] = [
    ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1e-3),
    ([1.025, 0.0, 0.01], [0.01, 1.015, 0.0], 0.004),
    ([1.045, 0.0, 0.0], [0.0, 1.035, 0.1], 0.02),
    ([0.92, 0.0, 0.1], [0.0, 0.9, 0.0], 0.02),
    ([1.0, 0.1, 0.0], [0.15, 1.0, 0.0], 0.02),
    ([0.95, -0.2, 0.0], [-0.6, 0.8, 0.0], 0.02),
    ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.4),
    ([0.2, 0.0, 0.0], [0.1, 0.25, 0.0], 0.02),
];

/// Every law, rigid and compressible, with the other terms in turn.
pub(crate) fn element_scenes() -> Vec<Scene> {
    let mut out = Vec::new();
    for (n, law) in SOLVER_LAWS.into_iter().chain(SOLVER_LAWS).enumerate() {
        for (c, compression) in CROSSOVERS.into_iter().enumerate() {
            let at = 2 * n + c;
            let mut case = patch::case(7, 5);
            case.fabric.crossover = Crossover { law, compression, gap: 0.0, ..case.fabric.crossover };
            if at % 3 == 1 {
                case.fabric.shear = None;
            }
            if n % 2 == 1 {
                case.solver.hourglass = 0.0;
            }
            if n >= 2 {
                swap_yarns(&mut case);
            }
            let edges = [Edge::Free, Edge::Clamped, Edge::Roller, Edge::Free];
            case.pack.edges.left = edges[at % 4];
            case.pack.edges.right = edges[(at + 1) % 4];
            case.pack.edges.bottom = edges[(at + 2) % 4];
            case.pack.edges.top = edges[(at + at / 4) % 4];
            case.pack.plies = DEFORMATIONS.len() as u32;
            let step = if at == 2 || at == 4 { 0 } else { 17 };
            let name = format!("{law:?}, {}{}", ["rigid", "compressible"][c], ["", ", yarns exchanged"][n / 2]);
            out.push(deformed(name, case, step, at as u64));
        }
    }
    out.extend(special_scenes());
    out
}

fn graded_pack(size: [usize; 2], groups: &[Group]) -> Case {
    let mut case = packs::case(size, groups);
    grade(&mut case, [-2e-3, 3e-3], 4.0);
    case
}

/// Plies of which one fabric's elements are shorter than the failure length, the other's longer.
fn over_length(mut case: Case) -> Case {
    case.solver.failure_length = 1.8e-3;
    case
}

/// Elements that are narrower than the yarns.
fn narrow(case: &mut Case) {
    case.pack.element_length_x *= 0.5;
    case.pack.element_length_y *= 0.4;
}

/// A shot whose yarns differ in strength, by a lot, along their length and from each other.
fn strength() -> Variability {
    Variability {
        seed: 7,
        shot: Some(3),
        hit: HitPlace::Aimed,
        velocity: None,
        obliquity: None,
        yaw: None,
        modulus: None,
        crimp: None,
        yarn_strength: Some(YarnStrength { shape: 4.0, gauge_length: 1e-3, yarn_shape: Some(6.0) }),
    }
}

/// One law, with something unusual about the mesh or the fabric.
fn special_scenes() -> Vec<Scene> {
    let plies = DEFORMATIONS.len() as u32;
    let special = |name: &str, columns: usize, rows: usize, change: &dyn Fn(&mut Case)| {
        let mut case = patch::case(columns, rows);
        change(&mut case);
        deformed(name.to_owned(), case, 3, 100 + columns as u64)
    };
    let groups = [Group::turned(0), Group::coarse(90), Group::turned(30), Group::coarse(0)];
    vec![
        deformed("plies of two fabrics".to_owned(), packs::case([7, 6], &groups), 3, 200),
        special("only a part reached", 7, 6, &|case| case.pack.plies = plies),
        deformed("the first step of a part".to_owned(), patch::case(7, 6), 0, 201),
        special(WITHOUT_VISCOSITY, 7, 5, &|case| case.pack.plies = plies),
        special(SOFT, 23, 19, &soften),
        special("graded", 13, 26, &|case| {
            case.pack.plies = plies;
            grade(case, [3e-3, -2e-3], 4.0);
            case.pack.edges.left = Edge::Roller;
            case.pack.edges.top = Edge::Clamped;
        }),
        special("graded, more lines than fit into a row of their table", 2600, 1, &|case| grade(case, [0.0; 2], 1.2)),
        deformed("graded plies of two fabrics".to_owned(), graded_pack([20, 17], &groups), 3, 202),
        special("failure over a length", 13, 9, &|case| {
            case.pack.plies = plies;
            narrow(case);
            case.solver.failure_length = 3.3e-3;
        }),
        one_sided(special("a yarn strained on one side", 17, 13, &|case| {
            case.pack.plies = plies;
            case.pack.element_length_x *= 0.25;
            case.pack.element_length_y *= 0.2;
            case.solver.failure_length = 0.7e-3;
        })),
        special("failure over a length, graded", 13, 26, &|case| {
            case.pack.plies = plies;
            narrow(case);
            case.solver.failure_length = 2.1e-3;
            grade_from(case, [3e-3, -2e-3], 4.0, LinesFrom::Hit);
        }),
        deformed("failure over a length, two fabrics".to_owned(), over_length(graded_pack([20, 17], &groups)), 4, 203),
        special("pieces of yarn of different strength", 13, 9, &|case| {
            case.pack.plies = plies;
            case.variability = Some(strength());
        }),
        special("pieces of yarn of different strength, over a length", 13, 26, &|case| {
            case.pack.plies = plies;
            narrow(case);
            case.solver.failure_length = 2.1e-3;
            grade_from(case, [3e-3, -2e-3], 4.0, LinesFrom::Hit);
            case.variability = Some(strength());
        }),
        special("one element", 1, 1, &|case| case.pack.plies = plies),
        special("several workgroups of the ledger", 33, 35, &|case| {
            case.pack.edges.left = Edge::Roller;
            case.pack.edges.bottom = Edge::Clamped;
        }),
        special("warp alone, one row", 70, 1, &|case| {
            case.pack.plies = plies;
            case.fabric.weft.present = false;
            case.fabric.weft.crimp = 0.0;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.right = Edge::Clamped;
            case.pack.edges.bottom = Edge::Roller;
        }),
        special("yarns that do not touch and do not break, one column", 1, 70, &|case| {
            case.pack.plies = plies;
            case.fabric.crossover.gap = 1e-3;
            case.fabric.warp.failure_strain = 1.0;
            case.fabric.weft.failure_strain = 1.0;
        }),
    ]
}

/// Elements grow away from a place in the pack to so many times the finest.
fn grade(case: &mut Case, hit: [f64; 2], coarsest: f64) {
    grade_from(case, hit, coarsest, LinesFrom::Edges);
}

/// Likewise, with lines counted from that place or from the edges.
fn grade_from(case: &mut Case, hit: [f64; 2], coarsest: f64, lines_from: LinesFrom) {
    let grading =
        Some(Grading { hit, way: [0.0; 2], fine: [1e-3; 2], growth_ratio: 1.6, max_size: coarsest, lines_from });
    case.pack.grading = grading;
    case.pack.layup.iter_mut().for_each(|layer| layer.grading = grading);
}

/// Exchanges the fabric's yarns, so that the other one is the unknown of the unit cell.
fn swap_yarns(case: &mut Case) {
    std::mem::swap(&mut case.fabric.warp.modulus, &mut case.fabric.weft.modulus);
    std::mem::swap(&mut case.fabric.warp.linear_density, &mut case.fabric.weft.linear_density);
}

/// A scene of elements whose yarns have no shock viscosity, and no fields for it.
const WITHOUT_VISCOSITY: &str = "no shock viscosity";

/// The one scene of cells whose crossover hardly resists at first touch: there a rounding of a strain is a height. It decides whether a yarn
/// is taut, and only a taut yarn has shock viscosity: here none has.
const SOFT: &str = "soft at first touch";

/// Its only deformation: strains of up to a hundred thousandth.
const BARELY: ([f64; 3], [f64; 3], f64) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1e-5);

/// A weft of much crimp, and a compression that stiffens from next to nothing. Whether Newton's steps end there a rounding decides.
fn soften(case: &mut Case) {
    (case.fabric.warp.crimp, case.fabric.weft.crimp) = (0.06, 0.179);
    case.fabric.crossover.compression = Some(Compression { a: 2.262e-4, b: 2e-5 });
}

/// Plies deformed each in its own way; yarns, warm starts and last forces at random.
fn deformed(name: String, mut case: Case, step: u64, seed: u64) -> Scene {
    if name != WITHOUT_VISCOSITY && name != SOFT {
        case.solver.shock_viscosity = 0.3;
    }
    let model = Model::<f32>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    state.step = step;
    let mut random = Random(seed);
    let speed = 30.0;
    for ply in 0..model.grid.plies {
        let ply_type = model.ply_type(ply);
        let mesh = &ply_type.mesh;
        let (f1, f2, noise) = match model.grid.plies {
            _ if name == SOFT => BARELY,
            1 => DEFORMATIONS[2],
            _ => DEFORMATIONS[ply % DEFORMATIONS.len()],
        };
        for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
            let uniform = affine(f1, f2, mesh.reference(row, column));
            let at = model.grid.first_node_row(ply) + row;
            for a in 0..3 {
                let u = uniform[a] + noise * mesh.length[a % 2] * random.between(-1.0, 1.0);
                state.nodes.set(at, node::DISPLACEMENT + a, column, u as f32);
                let free = ply_type.row_mass(row).inverse[a][column] > 0.0;
                let v = if free { random.between(-speed, speed) } else { 0.0 };
                state.nodes.set(at, node::VELOCITY + a, column, v as f32);
            }
        }
    }
    state.reach_everything(&model);
    kill(&model, &mut state, &mut random, 0.1);
    // Roundings of masses are measured by the largest speed, which forces must not exceed in a step.
    random_elements(&model, &mut state, &mut random, if model.features().graded { 0.05 } else { 0.5 });
    if name.contains("part") {
        state.active.fill(ActiveRegion { rows: 2..4, columns: 1..5 });
    }
    Scene { name, model, state, elements: true, pack: false, held: false, speed }
}

/// One row of elements of each yarn strained to about twice what breaks it, the others hardly.
fn one_sided(mut scene: Scene) -> Scene {
    let (model, mut random) = (&scene.model, Random(79));
    let first = scene.state.elements.fields - element::STRAIN;
    for [ply, row, column] in element_places(model) {
        for (yarn, across) in [row - model.grid.first_element_row(ply), column].into_iter().enumerate() {
            let over = if across % 4 == 1 { random.between(1.5, 2.8) } else { random.between(0.0, 0.6) };
            if scene.state.alive(row, column, yarn) {
                let strain = model.ply_type(ply).cell.yarn[yarn].failure_strain * over;
                scene.state.elements.set(row, first + yarn, column + 1, strain as f32);
            }
        }
    }
    scene
}

/// Ply, row of the storage and column of every element.
fn element_places(model: &Model<f32>) -> Vec<[usize; 3]> {
    let of_ply = |ply: usize| {
        let mesh = &model.ply_type(ply).mesh;
        let first = model.grid.first_element_row(ply);
        (0..mesh.rows).flat_map(move |row| (0..mesh.columns).map(move |column| [ply, first + row, column]))
    };
    (0..model.grid.plies).flat_map(of_ply).collect()
}

/// Fails yarns: each with that probability, and as often both of an element.
fn kill(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, share: f64) {
    for [_, row, column] in element_places(model) {
        let [one, both] = [(); 2].map(|()| random.between(0.0, 1.0));
        for yarn in 0..2 {
            let mine = one < share * (yarn + 1) as f64 && share * yarn as f64 <= one;
            if mine || both < share {
                state.elements.set(row, element::ALIVE + yarn, column + 1, 0.0);
            }
        }
    }
}

/// Warm starts beyond both ends of their range, and forces up to `share` of what breaks a yarn; eroded elements have none,
/// nor have those that nothing has reached.
fn random_elements(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, share: f64) {
    let most = share * force_scale(model);
    let modes = model.ply_types[0].element.hourglass[0] > 0.0;
    let (mut drags, mut strains) = (Random(77), Random(78));
    for [ply, row, column] in element_places(model) {
        let [rows, columns] = state.active[ply].elements(&model.ply_type(ply).mesh);
        let reached = rows.contains(&(row - model.grid.first_element_row(ply))) && columns.contains(&column);
        let stands = if reached && state.is_intact(row, column) { 1.0 } else { 0.0 };
        let at = column + 1;
        for field in element::FORCES {
            let there = stands * if field < element::HOURGLASS || modes { 1.0 } else { 0.0 };
            state.elements.set(row, field, at, (there * random.between(-most, most)) as f32);
        }
        for viscous in 0..if model.features().viscous { element::VISCOUS } else { 0 } {
            let force = stands * 0.1 * most / model.ply_types[0].element.membrane[viscous];
            state.elements.set(row, element::COUNT + viscous, at, (drags.between(-1.0, 1.0) * force) as f32);
        }
        // From slack to as far beyond failure as a step strains a yarn.
        for yarn in 0..2 {
            let limit = model.ply_type(ply).cell.yarn[yarn].failure_strain;
            let strain = match reached && state.alive(row, column, yarn) {
                true => limit * strains.between(0.5, 1.4),
                false => BROKEN,
            };
            let first = state.elements.fields - element::STRAIN;
            state.elements.set(row, first + yarn, at, strain as f32);
        }
        for yarn in 0..2 {
            let height = model.ply_types[0].cell.height_sum * random.between(-0.2, 1.2);
            state.elements.set(row, element::HEIGHT + yarn, at, (stands * height) as f32);
        }
    }
}

/// Force of an element whose stronger yarn is about to break [N].
fn force_scale(model: &Model<f32>) -> f64 {
    let ply_type = &model.ply_types[0];
    let yarn = |i: usize| ply_type.cell.yarn[i].stiffness * 0.035 * ply_type.element.membrane[i];
    yarn(0).max(yarn(1))
}
