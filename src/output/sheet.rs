//! Sheet of a case before its run: the JSON of `ripstop check`.

use std::num::NonZero;
use std::thread;

use serde_json::{Value, json};

use super::checks::case_warnings;
use super::summary::areal_density;
use crate::case::{Case, Field, Layer};
use crate::run::{Sample, Simulation};

/// Time of an element-step of what symmetry leaves, on one thread [µs]: of one ply, twice what a core of a Zen 5 takes; of packs as twelve
/// plies that tear took on a slower core, two thirds of it for contact between them.
const ELEMENT_STEP: [f64; 2] = [0.1, 0.6];

/// Numbers of a case that are held against a data sheet, those of its run, and every field.
pub fn sheet(case: &Case, simulation: &Simulation<f64>) -> Value {
    let energy = case.projectile.as_ref().map(|p| 0.5 * p.mass * p.velocity * p.velocity);
    json!({
        "file": case.path.display().to_string(),
        "title": case.title,
        "fabrics": case.layers().iter().map(fabric).collect::<Vec<_>>(),
        "areal_density_kg_m2": areal_density(case),
        "impact_energy_j": energy,
        "run": the_run(case, simulation),
        "fields": case.fields.iter().map(field).collect::<Vec<_>>(),
        "notes": case.notes,
        "warnings": case_warnings(case),
    })
}

fn fabric(layer: &Layer) -> Value {
    let fabric = &layer.fabric;
    let mut one = json!({
        "name": fabric.name, "plies": layer.plies, "areal_density_g_m2": 1e3 * fabric.areal_density,
    });
    for (name, yarn) in [("warp", &fabric.warp), ("weft", &fabric.weft)].into_iter().filter(|(_, yarn)| yarn.present) {
        let load = yarn.breaking_strain().map(|strain| strain * yarn.modulus * yarn.area(fabric.fibre_density));
        one[name] = json!({ "breaking_load_n": load, "wave_speed_m_s": (yarn.modulus / fabric.fibre_density).sqrt() });
    }
    one
}

fn field(field: &Field) -> Value {
    json!({
        "pointer": field.pointer, "value": field.value, "unit": field.unit, "origin": field.origin.word(),
        "source": field.source, "assumed": field.assumed,
    })
}

/// Time step, size and memory of the run.
fn the_run(case: &Case, simulation: &Simulation<f64>) -> Value {
    let (model, state) = (&simulation.model, &simulation.state);
    let steps = (case.solver.end_time / model.dt).ceil() as u64 + 1;
    let rows = (case.solver.end_time / case.output.history_interval).ceil() + 1.0;
    let numbers = (state.nodes.data.len() + state.elements.data.len()) * size_of::<f64>();
    json!({
        "critical_time_step_us": 1e6 * model.bound.critical_step, "set_by": model.bound.set_by,
        "time_step_us": 1e6 * model.dt, "steps": steps, "elements": model.whole_elements(),
        "run_time_s": run_time(model.plies.len(), model.elements(), steps as f64),
        "memory_bytes": numbers as f64 + rows * size_of::<Sample>() as f64,
    })
}

/// Time of an element-step of a pack of so many plies [µs].
pub fn element_step(plies: usize) -> f64 {
    ELEMENT_STEP[usize::from(plies > 1)]
}

/// Run time of so many steps of a pack on all threads, at most [s].
pub fn run_time(plies: usize, elements: usize, steps: f64) -> f64 {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    1e-6 * element_step(plies) * elements as f64 * steps / threads as f64
}
