//! Trellis shear as it is measured: picture frame and bias extension, held against what their geometry says.
//!
//! The frame's sides and the grips are nodes that are moved. All others find their place by the steps of the program itself, slowed
//! down until nothing moves. The force is what those nodes are held with. Always in double precision on the processor.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

use serde_json::json;

use super::{Expected, Prediction, PredictionRun};
use crate::case::{self, Case};
use crate::kernels::element_force::field as element;
use crate::kernels::node_update::{Neighbours, field as node, gather};
use crate::model::{Mesh, Model};
use crate::run::Progress;
use crate::solver::Stepper;
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::state::{State, split};
use crate::study::verify::scenes;

/// S-720 without crimp, so that no yarn gets longer but by its own strain.
const BASE: &str = "strip-uncrimped-155";
/// What both tests set.
const SETS: [&str; 7] = [
    "/expect=[]",
    "/projectile=null",
    "/fabric/warp/count_per_inch=20",
    "/pack/crossovers_per_element=1",
    "/pack/edges=free",
    "/output/profile_times_us=[]",
    r#"/fabric/shear={"thickness_mm":0.3,"g1_mpa":10,"g2_mpa":1000,"gamma1":0.35,"gamma2":0.6}"#,
];

/// Torque of trellis shear per reference area [N/m]: thickness times the integral of the modulus of (25) over the angle, by hand.
fn torque(angle: f64) -> f64 {
    let (thickness, first, second, begins, ends) = (3e-4, 1e7, 1e9, 0.35, 0.6);
    let into = (angle - begins).clamp(0.0, ends - begins);
    let past = (angle - ends).max(0.0);
    thickness * (first * angle + (second - first) * (0.5 * into * into / (ends - begins) + past))
}

/// Steps in which the nodes that are held move from one angle to the next.
const MOVING: u64 = 2000;
/// Steps in which everything else comes to rest after it.
const RESTING: u64 = 8000;
/// Part of its velocity that a node loses in a step [-].
const DRAG: f64 = 2e-3;

/// A test: a piece of fabric of which some nodes are moved.
struct Test {
    group: &'static str,
    formula: &'static str,
    because: &'static str,
    /// Why it does not hold, where that is known.
    known_difference: &'static str,
    /// Allowed difference over what is expected [-].
    tolerance: f64,
    /// Elements along each side of the mesh.
    cells: usize,
    /// Whether the element with this middle is part of the piece; in element lengths from the middle of the mesh.
    is_fabric: fn([f64; 2]) -> bool,
    /// Whether a node at this place is moved.
    is_held: fn([f64; 2]) -> bool,
    /// Where it goes at this angle: displacement in element lengths.
    goes: fn([f64; 2], f64) -> [f64; 2],
    /// Force at this angle, for elements of this length [N].
    expected: fn(f64, f64) -> f64,
    angles: [f64; 3],
}

/// Side of the frame, in elements.
const SIDE: f64 = 20.0;
/// Half the width and half the length of the strip, in half diagonals of an element.
const HALF_WIDTH: f64 = 14.0;
const HALF_LENGTH: f64 = 30.0;

const FRAME: Test = Test {
    group: "Picture frame of 25.4 mm, uncrimped S-720",
    formula: "closed form: picture frame, F = L C_s(g)/sin(pi/4 - g/2), C_s from (25)",
    because: "the shear is even: what is left is the rest of the motion",
    known_difference: "",
    tolerance: 1e-3,
    cells: SIDE as usize,
    is_fabric: |_| true,
    is_held: |[x, y]| x.abs().max(y.abs()) > 0.5 * SIDE - 0.25,
    goes: |[x, y], angle| {
        // Sides at 45° to the line of pull turn towards it, each by half the angle.
        let half = 0.5 * angle;
        let [along, across] = [half.cos(), half.sin()];
        [(along - 1.0) * x + across * y, across * x + (along - 1.0) * y]
    },
    expected: |angle, length| SIDE * length * torque(angle) / (FRAC_PI_4 - 0.5 * angle).sin(),
    angles: [0.2, 0.35, 0.5],
};

const BIAS: Test = Test {
    group: "Bias extension of 54 x 25 mm, uncrimped S-720",
    formula: "closed form: bias extension, F (H - W)(cos(g/2) - sin(g/2)) = W (2H - 3W) C_s(g) + W^2 C_s(g/2), C_s from (25)",
    because: "the edges of the strip are steps of whole elements, 28 half diagonals wide",
    known_difference: "yarns resist neither compression nor bending in their plane: at the corners of the grips they fold, where the closed \
                       form has them straight; an hourglass coefficient of 0.3 instead of 0.001 stiffens that and leaves 8 to 10 %",
    tolerance: 0.02,
    cells: 48,
    is_fabric: |middle| {
        let [along, across] = diagonal(middle);
        // Of the elements that an edge halves, every other one.
        let edge = (across.abs() - HALF_WIDTH).abs() < 0.25;
        let every_other = (0.5 * (along + HALF_LENGTH)).floor() as i64 % 2 == 0;
        along.abs() < HALF_LENGTH - 0.25 && (across.abs() < HALF_WIDTH - 0.25 || (edge && every_other))
    },
    is_held: |place| {
        let [along, across] = diagonal(place);
        along.abs() > HALF_LENGTH - 0.25 && across.abs() < HALF_WIDTH + 0.25
    },
    goes: |place, angle| {
        let [along, _] = diagonal(place);
        // Half of (H − W)(cos γ/2 + sin γ/2 − 1), in half diagonals.
        let longer = (HALF_LENGTH - HALF_WIDTH) * ((0.5 * angle).cos() + (0.5 * angle).sin() - 1.0);
        [0.5 * longer * along.signum(); 2]
    },
    expected: |angle, length| {
        let [w, h] = [HALF_WIDTH, HALF_LENGTH].map(|half| 2.0 * half * length * FRAC_1_SQRT_2);
        let sheared = w * (2.0 * h - 3.0 * w) * torque(angle) + w * w * torque(0.5 * angle);
        sheared / ((h - w) * ((0.5 * angle).cos() - (0.5 * angle).sin()))
    },
    angles: [0.1, 0.2, 0.3],
};

/// Place along and across the line of pull, a diagonal of the mesh, in half diagonals of an element.
fn diagonal([x, y]: [f64; 2]) -> [f64; 2] {
    [x + y, y - x]
}

/// A piece of fabric in the course of a test.
struct Piece<'a> {
    test: &'a Test,
    model: Model<f64>,
    state: State<f64>,
    stepper: Stepper<f64>,
    ledger: EnergyBalance,
    /// Row, column and place of every node that is held.
    held: Vec<(usize, usize, [f64; 2])>,
}

/// Place of a node in element lengths from the middle of the mesh.
fn place(mesh: &Mesh, row: usize, column: usize) -> [f64; 2] {
    let [x, y] = mesh.reference(row, column);
    let [width, height] = mesh.size(row.min(mesh.rows - 1), column.min(mesh.columns - 1));
    [x / width, y / height]
}

impl<'a> Piece<'a> {
    fn new(test: &'a Test, case: &Case) -> Result<Self, String> {
        let model = Model::<f64>::new(case).map_err(|error| error.to_string())?;
        let mut state = State::new(case, &model);
        state.reach_everything(&model);
        let mesh = &model.ply_type(0).mesh;
        let nodes = (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column)));
        let held = nodes.map(|(row, column)| (row, column, place(mesh, row, column)));
        let held = held.filter(|(_, _, at)| (test.is_held)(*at)).collect();
        for row in 0..mesh.rows {
            for column in 0..mesh.columns {
                let [x, y] = place(mesh, row, column);
                if !(test.is_fabric)([x + 0.5, y + 0.5]) {
                    (0..2).for_each(|yarn| state.elements.set(row, element::ALIVE + yarn, column + 1, 0.0));
                }
            }
        }
        Ok(Self { test, stepper: Stepper::new(&model), model, state, ledger: EnergyBalance::default(), held })
    }

    /// Length of an element [m].
    fn length(&self) -> f64 {
        self.model.ply_type(0).mesh.size(0, 0)[0]
    }

    /// One step, at whose end the held nodes are where they are at this angle, and the others have lost a part of their velocity.
    fn step(&mut self, angle: f64) {
        self.stepper.step(&self.model, &mut self.state, &mut self.ledger, false);
        for row in 0..self.model.grid.node_rows() {
            let stride = self.state.nodes.stride;
            let velocities = &mut self.state.nodes.row_mut(row)[node::VELOCITY * stride..];
            velocities.iter_mut().for_each(|velocity| *velocity *= 1.0 - DRAG);
        }
        let length = self.length();
        for &(row, column, at) in &self.held {
            let [x, y] = (self.test.goes)(at, angle);
            for (axis, moved) in [x * length, y * length, 0.0].into_iter().enumerate() {
                self.state.nodes.set(row, node::DISPLACEMENT + axis, column, moved);
                self.state.nodes.set(row, node::VELOCITY + axis, column, 0.0);
            }
        }
    }

    /// Force along the line of pull [N]: the work of what holds the nodes over the way of one end, for a small angle more.
    fn force(&self, angle: f64) -> f64 {
        const MORE: f64 = 1e-6;
        let elements = &self.state.elements;
        let nothing = vec![0.0; element::FORCES.end * elements.stride];
        let rows = self.model.grid.rows;
        let mut work = 0.0;
        for &(row, column, at) in &self.held {
            let below = if row > 0 { elements.row(row - 1) } else { &nothing };
            let above = if row < rows { elements.row(row) } else { &nothing };
            let around = Neighbours { below: split(below, elements.stride), above: split(above, elements.stride) };
            let force = gather(0.0, &around, column);
            let [before, after] = [angle - MORE, angle + MORE].map(|angle| (self.test.goes)(at, angle));
            work -= (force[0] * (after[0] - before[0]) + force[1] * (after[1] - before[1])) * self.length();
        }
        work / self.way(angle - MORE, angle + MORE)
    }

    /// How much further apart the two ends of the line of pull are at one angle than at another [m].
    fn way(&self, before: f64, after: f64) -> f64 {
        let end = |angle: f64| {
            let ends = self.held.iter().map(|&(_, _, at)| {
                let [x, y] = (self.test.goes)(at, angle);
                diagonal([at[0] + x, at[1] + y])[0]
            });
            ends.fold(0.0, f64::max)
        };
        2.0 * (end(after) - end(before)) * FRAC_1_SQRT_2 * self.length()
    }
}

/// Adds a row for each angle of each test; none of an interrupted one.
pub(super) fn add(table: &mut PredictionRun<'_>) {
    for test in [FRAME, BIAS] {
        let rows = measure(&test, table);
        table.take(test.group, rows);
    }
}

/// The rows of a test.
fn measure(test: &Test, table: &mut PredictionRun<'_>) -> Result<Vec<Prediction>, String> {
    let side = 1.27 * test.cells as f64;
    let size = [format!("/pack/width_mm={side}"), format!("/pack/height_mm={side}")];
    let sets: Vec<String> = SETS.iter().map(ToString::to_string).chain(size).collect();
    let case = case::from_str(BASE, scenes::text(BASE), &sets).map_err(|error| error.to_string())?;
    let mut piece = Piece::new(test, &case)?;
    let (mut rows, mut last) = (Vec::new(), 0.0);
    let steps = test.angles.len() as u64 * (MOVING + RESTING);
    for angle in test.angles {
        for step in 0..MOVING + RESTING {
            let part = (step as f64 / MOVING as f64).min(1.0);
            piece.step(last + part * (angle - last));
            if step % 1000 == 0 {
                (table.progress)(test.group, &piece.progress(steps));
            }
            if table.interrupted() {
                return Ok(Vec::new());
            }
        }
        last = angle;
        let expected = (test.expected)(angle, piece.length());
        let expected = Expected::Number {
            text: format!("{expected:.3}"),
            value: expected,
            tolerance: test.tolerance * expected,
            because: test.because,
        };
        let name = format!("force at a shear angle of {angle} [N]");
        let row = Prediction::judged(test.group, &name, expected, json!(piece.force(angle)), test.formula);
        rows.push(row.known(test.known_difference));
    }
    Ok(rows)
}

impl Piece<'_> {
    fn progress(&self, steps: u64) -> Progress {
        let dt = self.model.dt;
        Progress {
            time: self.state.step as f64 * dt,
            end_time: steps as f64 * dt,
            velocity: 0.0,
            failed: 0,
            steps: self.state.step,
            elements: self.model.elements(),
        }
    }
}
