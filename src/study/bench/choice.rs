//! The ways to run a case that a user can choose from.

use crate::case::Case;
use crate::run::{Precision, Skips};

/// Courant numbers to choose from [-].
const COURANT: [f64; 4] = [0.95, 0.9, 0.8, 0.5];
/// Crossovers along each side of an element to choose from.
const MESH: [u32; 3] = [1, 2, 4];

/// What computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    /// All threads.
    Cpu,
    /// The graphics processor.
    Gpu,
}

/// One way to run a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// What is different, in words.
    pub name: String,
    /// What computes.
    pub processor: Processor,
    /// In which numbers.
    pub precision: Precision,
    /// What is left out.
    pub skips: Skips,
    /// Changes of the case.
    pub sets: Vec<String>,
    /// Crossovers along each side of an element, where they change.
    pub mesh: Option<u32>,
}

impl Configuration {
    /// The case as it is, on the processor in f64.
    pub(crate) fn default_of(case: &Case) -> Self {
        let (courant, mesh) = (case.solver.courant, case.pack.crossovers_per_element);
        let graded = if case.pack.grading.is_some() { " graded" } else { "" };
        Self {
            name: format!("default: f64, Courant {courant}, mesh {mesh}{graded}"),
            processor: Processor::Cpu,
            precision: Precision::F64,
            skips: Skips::default(),
            sets: Vec::new(),
            mesh: None,
        }
    }

    fn named(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }

    fn single(self) -> Self {
        Self { precision: Precision::F32, ..self }
    }

    fn courant(mut self, courant: f64) -> Self {
        self.sets.push(format!("/solver/courant={courant}"));
        self
    }

    fn mesh(mut self, crossovers: u32) -> Self {
        self.sets.push(format!("/pack/crossovers_per_element={crossovers}"));
        Self { mesh: Some(crossovers), ..self }
    }

    fn grading(mut self, word: &str) -> Self {
        self.sets.push(format!("/pack/mesh_grading={word}"));
        self
    }
}

/// Every choice for a case: one thing changed at a time, then what promises most together.
pub fn choices(case: &Case, gpu: bool) -> Vec<Configuration> {
    let default = Configuration::default_of(case);
    let with = || default.clone();
    let other_courant = |courant: &f64| *courant != case.solver.courant;
    let other_mesh = |mesh: &u32| *mesh != case.pack.crossovers_per_element;
    let mut all = vec![with(), with().named("f32").single()];
    for courant in COURANT.into_iter().filter(other_courant) {
        all.push(with().named(&format!("Courant {courant}")).courant(courant));
    }
    for mesh in MESH.into_iter().filter(other_mesh) {
        all.push(with().named(&format!("mesh {mesh}")).mesh(mesh));
    }
    let gradable = case.pack.grading.is_none() && case.projectile.is_some();
    if gradable {
        all.push(with().named("graded").grading("graded"));
    } else if case.pack.grading.is_some() {
        all.push(with().named("not graded").grading("none"));
    }
    all.push(Configuration { skips: Skips::WHOLE, ..with().named("no symmetry") });
    all.push(Configuration { skips: Skips::NONE, ..with().named("no skip") });
    let fast = COURANT[0];
    if other_courant(&fast) {
        all.push(with().named(&format!("f32, Courant {fast}")).single().courant(fast));
    }
    if other_mesh(&2) {
        all.push(with().named("f32, mesh 2").single().mesh(2));
    }
    if gradable {
        all.push(with().named("f32, graded").single().grading("graded"));
    }
    if gpu {
        all.push(Configuration { processor: Processor::Gpu, ..with().named("gpu f32").single() });
    }
    all
}

/// Whether the mesh of a choice covers the same cloth: whole elements where the case has whole crossovers.
///
/// # Errors
/// Says what does not divide.
pub fn fits(case: &Case, choice: &Configuration) -> Result<(), String> {
    let Some(mesh) = choice.mesh else { return Ok(()) };
    for layer in case.layers().iter() {
        for (count, along) in [(layer.columns, "warp"), (layer.rows, "weft")] {
            let crossovers =
                count * case.pack.crossovers_per_element as usize / case.pack.elements_per_crossover as usize;
            if !crossovers.is_multiple_of(mesh as usize) {
                return Err(format!("{crossovers} crossovers along the {along} do not divide by {mesh}"));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "choice_tests.rs"]
mod tests;
