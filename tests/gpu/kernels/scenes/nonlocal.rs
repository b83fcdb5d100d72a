//! Yarns near their failure strain, some above it and some below, judged by what lies around them.

use ripstop::case::{Case, Edge, FailureMeasure};
use ripstop::kernels::element_force::{BREAKING, field as element};
use ripstop::kernels::node_update::field as node;
use ripstop::lanes::Vectors;
use ripstop::ledger::Ledger;
use ripstop::model::Model;
use ripstop::reach::Reach;
use ripstop::state::State;
use ripstop::step::{Context, Stepper};

use super::packs::{self, Group};
use super::{Scene, element_places, kill, random_elements};
use crate::support::Random;
use crate::support::patch::{self, affine};

/// Windows of whole and half elements, of small parts of them, over a mirror plane, of plies with different limits; a row that bears alone.
pub(crate) fn scenes() -> Vec<Scene> {
    let make = |name: &str, size: [usize; 2], change: &dyn Fn(&mut Case)| {
        let mut case = patch::case(size[0], size[1]);
        case.pack.plies = 4;
        change(&mut case);
        taut(name, case)
    };
    vec![
        make("nonlocal", [13, 11], &|case| case.fabric.weft.failure_strain = 0.03),
        make("nonlocal, two elements per crossover", [17, 15], &|case| case.pack.elements_per_crossover = 2),
        make("nonlocal, three crossovers per element", [9, 10], &|case| case.pack.crossovers_per_element = 3),
        make("nonlocal, five crossovers per element", [9, 10], &|case| case.pack.crossovers_per_element = 5),
        make("nonlocal, warp alone", [13, 11], &|case| {
            case.fabric.weft.present = false;
            case.fabric.weft.crimp = 0.0;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.right = Edge::Clamped;
        }),
        make("nonlocal, one row bears all", [13, 11], &|_| {}),
        make("nonlocal, only a part reached", [13, 11], &|_| {}),
        make("nonlocal, a quarter", [14, 12], &|_| {}),
        taut("nonlocal, plies of two fabrics", pack([13, 11], &[Group::turned(0), Group::coarse(90)])),
        taut(
            "nonlocal, a part of turned plies",
            pack([14, 12], &[Group::turned(0), Group::turned(90), Group::turned(180)]),
        ),
    ]
}

/// A pack whose second group of plies breaks earlier.
fn pack(size: [usize; 2], groups: &[Group]) -> Case {
    let mut case = packs::case(size, groups);
    let fabric = &mut case.pack.layup[1].fabric;
    (fabric.warp.failure_strain, fabric.weft.failure_strain) = (0.03, 0.025);
    case
}

/// Every ply stretched to about its limits, with noise; some yarns are broken and some about to break.
fn taut(name: &str, mut case: Case) -> Scene {
    case.pack.failure = FailureMeasure::Nonlocal;
    let part = name.contains("quarter") || name.contains("a part of");
    let model = if part { Model::<f32>::part(&case) } else { Model::new(&case) }.unwrap();
    assert_eq!(model.planes.copies(), if part { 4 } else { 1 }, "{name}");
    let mut state = State::new(&case, &model);
    state.step = 9;
    let mut random = Random(300 + name.len() as u64);
    let speed = 30.0;
    let at_limits = stretches_at_limit(&case, &model);
    // Beside a mirror plane strains reach the limit, or fall below it, within what images count for.
    let far = |place: f64| if part { place.abs() - 2.0 } else { place };
    for ply in 0..model.grid.plies {
        let sheet = model.sheet(ply);
        let mesh = &sheet.mesh;
        let at_limit = at_limits[ply];
        for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
            let x = mesh.reference(row, column);
            let [along, across] = [x[0] / mesh.size(0, 0)[0], x[1] / mesh.size(0, 0)[1]];
            // More on one side of the ply than on the other, in another direction in every ply.
            let tilt = 0.002 * (far(along) * [1.0, -1.0][ply % 2] + far(across) * [1.0, -1.0][ply / 2 % 2]);
            // Warp beside the row that bears all has less than its limit, on the mean over both too.
            let more = match row {
                _ if !name.contains("bears all") => 0.0,
                4 | 5 => 0.65 * sheet.cell.yarn[0].failure_strain,
                _ => -0.85 * sheet.cell.yarn[0].failure_strain,
            };
            let uniform = affine([at_limit[0] + tilt + more, 0.0, 0.0], [0.0, at_limit[1] - tilt, 0.0], x);
            let at = model.grid.first_node_row(ply) + row;
            for a in 0..3 {
                let u = uniform[a] + 0.015 * mesh.length[a % 2] * random.between(-1.0, 1.0);
                state.nodes.set(at, node::DISPLACEMENT + a, column, u as f32);
                let free = sheet.row_mass(row).inverse[a][column] > 0.0;
                let v = if free { random.between(-speed, speed) } else { 0.0 };
                state.nodes.set(at, node::VELOCITY + a, column, v as f32);
            }
        }
    }
    state.reach_everything(&model);
    kill(&model, &mut state, &mut random, 0.02);
    random_elements(&model, &mut state, &mut random, 0.5);
    if name.contains("only a part") {
        state.reach.fill(Reach { rows: 2..7, columns: 1..8 });
    }
    mark(&model, &mut state, &mut random);
    Scene { name: name.to_owned(), model, state, elements: true, pack: false, held: false, speed }
}

/// Strains of the last step, which those of this one replace where anything moves, and yarns that break by them.
fn mark(model: &Model<f32>, state: &mut State<f32>, random: &mut Random) {
    for [ply, row, column] in element_places(model) {
        let [rows, columns] = state.reach[ply].elements(&model.sheet(ply).mesh);
        let moved = rows.contains(&(row - model.grid.first_element_row(ply))) && columns.contains(&column);
        for yarn in 0..2 {
            let limit = model.sheet(ply).cell.yarn[yarn].failure_strain;
            state.elements.set(row, element::COUNT + yarn, column + 1, (limit * random.between(0.5, 0.95)) as f32);
            if moved && state.alive(row, column, yarn) && random.between(0.0, 1.0) < 0.02 {
                state.elements.set(row, element::ALIVE + yarn, column + 1, BREAKING as f32);
            }
        }
    }
}

/// Stretches along warp and weft, by ply, at which both yarns are at their limits.
fn stretches_at_limit(case: &Case, model: &Model<f32>) -> Vec<[f64; 2]> {
    let limits: Vec<[f64; 2]> =
        model.plies.iter().map(|ply| model.sheets[ply.sheet].cell.yarn.map(|yarn| yarn.failure_strain)).collect();
    let mut stretches = vec![[1.0; 2]; limits.len()];
    for _ in 0..100 {
        let mut state = State::new(case, model);
        state.reach_everything(model);
        for (ply, stretch) in stretches.iter().enumerate() {
            let mesh = &model.sheet(ply).mesh;
            for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
                let x = mesh.reference(row, column);
                let at = model.grid.first_node_row(ply) + row;
                for a in 0..2 {
                    state.nodes.set(at, node::DISPLACEMENT + a, column, ((stretch[a] - 1.0) * x[a]) as f32);
                }
            }
        }
        let mut ledger = Ledger::default();
        Stepper::with_vectors(model, Vectors::None).elements(&mut Context::new(model, &mut state, &mut ledger, false));
        for (ply, stretch) in stretches.iter_mut().enumerate() {
            let row = model.grid.first_element_row(ply);
            for yarn in (0..2).filter(|yarn| model.sheet(ply).present[*yarn]) {
                stretch[yarn] +=
                    0.5 * (limits[ply][yarn] - f64::from(state.elements.get(row, element::COUNT + yarn, 1)));
            }
        }
    }
    stretches
}
