//! A patch of elements that a test moves by hand and asks for forces and energies.

use ripstop::case::{self, Case, Grading, LinesFrom};
use ripstop::model::Model;
use ripstop::num::scalar::Scalar;
use ripstop::solver;
use ripstop::solver::element_force::element_force;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::element_totals::{ElementRow, ElementTotals};
use ripstop::solver::node_update::field as node;
use ripstop::solver::node_update::{Neighbours, gather};
use ripstop::solver::state::{State, split, split_mut};
use serde_json::{Value, json};

pub(crate) type Vector = [f64; 3];

/// A fabric in which warp and weft differ in everything: a swap of the two cannot go unseen. Yarns are counted per inch, its thickness in mm.
pub(crate) fn fabric(name: &str, counts: [u32; 2], thickness: f64, areal_density: f64) -> Value {
    let yarn = |denier: u32, modulus: u32, count: u32, crimp: f64| {
        json!({"linear_density_denier": denier, "modulus_gpa": modulus, "failure_strain": 0.035,
            "count_per_inch": count, "crimp": crimp})
    };
    json!({
        "name": name, "fibre_density_kg_m3": 1440, "areal_density_g_m2": areal_density, "thickness_mm": thickness,
        "warp": yarn(1420, 96, counts[0], 0.0218), "weft": yarn(1100, 80, counts[1], 0.0139),
        "crossover": {"law": "variational", "gap_mm": 0, "compression": {"a_mm": 0.10, "b_mm_n13": 0.10}},
        "shear": {"g1_mpa": 10, "g2_mpa": 1000, "gamma1": 0.35, "gamma2": 0.6},
    })
}

/// A free patch of such a fabric.
pub(crate) fn case(columns: usize, rows: usize) -> Case {
    let document = json!({
        "title": "patch",
        "fabric": fabric("unequal", [20, 15], 0.3, 255.2),
        "pack": {"width_mm": columns as f64 * 25.4 / 20.0, "height_mm": rows as f64 * 25.4 / 15.0, "edges": "free"},
        "solver": {"end_time_us": 10, "hourglass": 0.05, "contact_sampling": "nodes", "shock_viscosity": 0},
    });
    let case = case::from_str("patch.json", &document.to_string(), &[]).unwrap();
    assert_eq!((case.pack.mesh.count[0], case.pack.mesh.count[1]), (columns, rows));
    case
}

/// The patch of a case with elements that grow from a place beside its middle.
pub(crate) fn graded(mut case: Case) -> Case {
    let (hit, lines_from) = ([2e-3, -1e-3], LinesFrom::Hit);
    let grading = Grading { hit, way: [0.0; 2], fine: [1e-3; 2], growth_ratio: 1.4, max_size: 3.0, lines_from };
    case.pack.mesh.grading = Some(grading);
    case
}

/// Removes what is not asked for: trellis shear, hourglass stiffness.
pub(crate) fn bare(mut case: Case) -> Case {
    case.fabric.shear = None;
    case.solver.hourglass = 0.0;
    case
}

/// Model and state of a patch.
pub(crate) struct Patch<S: Scalar> {
    pub(crate) model: Model<S>,
    pub(crate) state: State<S>,
}

impl<S: Scalar> Patch<S> {
    pub(crate) fn new(case: &Case) -> Self {
        let model = Model::new(case).unwrap();
        let state = State::new(case, &model);
        Self { model, state }
    }

    /// Rows and columns of nodes in order.
    pub(crate) fn nodes(&self) -> Vec<(usize, usize)> {
        let (rows, columns) = (self.model.grid.rows, self.model.grid.columns);
        (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))).collect()
    }

    /// Reference positions of the nodes [m].
    pub(crate) fn reference(&self) -> Vec<[f64; 2]> {
        self.nodes().into_iter().map(|(row, column)| self.model.ply_types[0].mesh.reference(row, column)).collect()
    }

    fn write(&mut self, field: usize, at: usize, value: Vector) {
        let (row, column) = self.nodes()[at];
        for a in [0, 1, 2] {
            self.state.nodes.set(row, field + a, column, S::splat(value[a]));
        }
    }

    /// Moves every node by a displacement that depends on its reference position [m].
    pub(crate) fn displace(&mut self, field: impl Fn([f64; 2]) -> Vector) {
        for (at, x) in self.reference().into_iter().enumerate() {
            self.write(node::DISPLACEMENT, at, field(x));
        }
    }

    /// Deforms uniformly: F1 and F2 are where the unit vectors along warp and weft go.
    pub(crate) fn deform(&mut self, f1: Vector, f2: Vector) {
        self.displace(|x| affine(f1, f2, x));
    }

    pub(crate) fn set_displacements(&mut self, displacements: &[Vector]) {
        for (at, u) in displacements.iter().enumerate() {
            self.write(node::DISPLACEMENT, at, *u);
        }
    }

    pub(crate) fn set_velocities(&mut self, velocities: &[Vector]) {
        for (at, v) in velocities.iter().enumerate() {
            self.write(node::VELOCITY, at, *v);
        }
    }

    /// Marks a yarn (0 warp, 1 weft) of an element as failed.
    pub(crate) fn kill(&mut self, row: usize, column: usize, yarn: usize) {
        self.state.elements.set(row, element::ALIVE + yarn, column + 1, S::splat(0.0));
    }

    /// Evaluates every element, with energies, `dt` [s] after the last evaluation, and adds up. What these positions strain too much breaks.
    pub(crate) fn evaluate(&mut self, dt: f64) -> Sums {
        let mut strained = self.state.clone();
        rows(&self.model, &mut strained, dt);
        solver::failure::evaluate_failure(&self.model, &mut strained, None);
        for [_, row, column] in self.model.element_places() {
            for field in [element::ALIVE, element::ALIVE + 1] {
                self.state.elements.set(row, field, column + 1, strained.elements.get(row, field, column + 1));
            }
        }
        let mut sums = Sums::default();
        for (row, t) in rows(&self.model, &mut self.state, dt).into_iter().enumerate() {
            assert_eq!(t.unconverged, 0);
            sums.stored += t.stored;
            sums.hourglass += t.hourglass;
            sums.released[0] += t.released[0];
            sums.released[1] += t.released[1];
            sums.max_deflection = sums.max_deflection.max(t.max_deflection);
            sums.failures.extend(t.failures.iter().map(|f| (row, f.i as usize, f.yarn, f.strain)));
        }
        [sums.max_tension, _] = solver::failure::yarn_loads(&self.model, &self.state, None);
        sums
    }

    /// Force of the elements on every node [N].
    pub(crate) fn forces(&self) -> Vec<Vector> {
        let elements = &self.state.elements;
        let nothing = vec![S::splat(0.0); element::FORCES.end * elements.stride];
        let rows = self.model.grid.rows;
        let force = |(row, column): (usize, usize)| {
            let below = if row > 0 { elements.row(row - 1) } else { &nothing };
            let above = if row < rows { elements.row(row) } else { &nothing };
            let around = Neighbours { below: split(below, elements.stride), above: split(above, elements.stride) };
            gather(S::splat(0.0), &around, column).map(|f| f.to_f64())
        };
        self.nodes().into_iter().map(force).collect()
    }

    /// Forces on the nodes after a fresh evaluation [N].
    pub(crate) fn solve(&mut self) -> (Vec<Vector>, Sums) {
        let sums = self.evaluate(0.0);
        (self.forces(), sums)
    }
}

/// Sums over a patch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sums {
    pub(crate) stored: f64,
    pub(crate) hourglass: f64,
    pub(crate) released: [f64; 2],
    pub(crate) max_tension: f64,
    pub(crate) max_deflection: f64,
    /// Element row and column, yarn, strain.
    pub(crate) failures: Vec<(usize, usize, u8, f64)>,
}

/// Displacement of a reference point under the uniform deformation that takes the axes to F1 and F2.
pub(crate) fn affine(f1: Vector, f2: Vector, x: [f64; 2]) -> Vector {
    [(f1[0] - 1.0) * x[0] + f2[0] * x[1], f1[1] * x[0] + (f2[1] - 1.0) * x[1], f1[2] * x[0] + f2[2] * x[1]]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Largest difference of two fields of forces over the largest force.
pub(crate) fn difference(got: &[Vector], expected: &[Vector]) -> f64 {
    let largest = expected.iter().map(|f| length(*f)).fold(0.0, f64::max);
    assert!(largest > 0.0 && got.len() == expected.len());
    let apart = |(a, b): (&Vector, &Vector)| length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    got.iter().zip(expected).map(apart).fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m }) / largest
}

/// Evaluates every row of elements of a patch.
fn rows<S: Scalar>(model: &Model<S>, state: &mut State<S>, dt: f64) -> Vec<ElementTotals> {
    let ply_type = model.ply_type(0);
    let (nodes, elements) = (&state.nodes, &mut state.elements);
    let (columns, stride) = (model.grid.columns, elements.stride);
    let mut all = vec![ElementTotals::default(); model.grid.rows];
    for (row, totals) in all.iter_mut().enumerate() {
        let (element, strain) = elements.row_mut(row).split_at_mut(element::COUNT * stride);
        let (element, strain) = (split_mut(element, stride), split_mut(strain, stride));
        let mut storage = ElementRow {
            below: split(nodes.row(row), nodes.stride),
            above: split(nodes.row(row + 1), nodes.stride),
            element,
            viscous: None,
            rate: None,
            strain,
            law_energy: None,
            height: ply_type.mesh.widths(row, 0)[1],
            width: &ply_type.columns.width,
            per_width: &ply_type.columns.per_width,
            ahead: [0; 2],
            range: 0..columns,
            dt,
            sample: true,
        };
        element_force(&ply_type.constants::<S>(), ply_type.has_shear, &mut storage, totals);
    }
    all
}
