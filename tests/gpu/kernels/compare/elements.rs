//! Forces, heights, life and failures of the elements.

use nalgebra::Vector3;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::status;
use ripstop::solver::FailureEvent;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::state::State;

use super::{Outcome, Pair, Scales};

/// Cells of a scene that may need the safeguarded iteration on one backend alone.
const SAFEGUARDED_ON_ONE: usize = 1;

impl Pair<'_> {
    /// Forces, heights and life of every element.
    pub(super) fn compare_elements(&mut self, got: &State<f32>) -> Outcome {
        let (model, expected) = (&self.scene.model, self.expected.clone());
        let Scales { force, height, failure_strain, viscous_force, .. } = self.scales;
        let predictor = element::PREDICTOR..element::HEIGHT;
        let mut safeguarded_on_one = 0;
        for (row, column) in
            (0..model.grid.element_rows()).flat_map(|row| (0..model.grid.columns).map(move |column| (row, column)))
        {
            let number = |state: &State<f32>, field| f64::from(state.elements.get(row, field, column + 1));
            // A rounding decides whether Newton's steps end, or the safeguarded iteration, which predicts nothing.
            let predicts = |state: &State<f32>| predictor.clone().any(|field| number(state, field) != 0.0);
            let on_one = predicts(got) != predicts(&expected);
            safeguarded_on_one += usize::from(on_one);
            let size = |first: usize| force + Vector3::from([0, 1, 2].map(|a| number(&expected, first + a))).norm();
            for field in (0..expected.elements.fields).filter(|field| !on_one || !predictor.contains(field)) {
                let (quantity, scale) = match field {
                    0..element::HOURGLASS => ("membrane force", size(field / 3 * 3)),
                    element::HOURGLASS..element::PREDICTOR => ("hourglass force", size(element::HOURGLASS)),
                    // The second half is not lengths but shares.
                    _ if predictor.contains(&field) => {
                        ("predicted height", if field < element::PREDICTOR + 2 { height } else { 1.0 })
                    }
                    // From one state: half of what whole runs may differ by.
                    element::HEIGHT..element::ALIVE => ("yarn height", 0.5 * height),
                    element::ALIVE..element::COUNT => ("yarn alive", 1.0),
                    _ if field >= expected.elements.fields - element::STRAIN => {
                        ("strain", failure_strain + number(&expected, field).abs())
                    }
                    _ => ("viscous force", viscous_force),
                };
                let numbers = [number(got, field), number(&expected, field), scale];
                let place = || format!("step {}, row {row}, column {column}, field {field}", expected.step - 1);
                self.seen.see("element_force", quantity, numbers, place);
            }
        }
        let few = safeguarded_on_one <= SAFEGUARDED_ON_ONE;
        few.then_some(()).ok_or_else(|| format!("{safeguarded_on_one} cells are safeguarded on one backend alone"))
    }

    /// Failures in the order of their places.
    pub(super) fn compare_failures(&mut self, words: &[u32]) -> Outcome {
        let (grid, raw) = (self.scene.model.grid, self.read(BufferId::Events)?);
        let mut got: Vec<&[u32]> = raw.chunks_exact(4).take(words[status::EVENTS] as usize).collect();
        got.sort();
        let place = |f: &FailureEvent| {
            let row = f.ply as usize * grid.rows + f.j as usize;
            [f.step as u32, (row * grid.columns) as u32 + f.i, u32::from(f.yarn)]
        };
        let expected: Vec<_> = self.failures.iter().map(|f| (place(f), f.strain.max(0.0))).collect();
        let same = got.len() == expected.len() && got.iter().zip(&expected).all(|(g, e)| g[..3] == e.0);
        self.see("element_force", "failures", [f64::from(u8::from(!same)), 0.0, 1.0], || {
            format!("{} for {}", got.len(), expected.len())
        });
        for yarn in 0..2 {
            let broken = expected.iter().filter(|e| e.0[2] == yarn as u32).count();
            self.count("counters", words[status::FAILED + yarn], broken as f64, "failed");
        }
        for (g, (place, strain)) in got.iter().zip(&expected).filter(|_| same) {
            // A yarn that has grown slack in the step in which it breaks has no strain.
            let numbers = [f64::from(f32::from_bits(g[3])).max(0.0), *strain, self.scales.failure_strain + strain];
            self.see("element_force", "failure strain", numbers, || format!("{place:?}"));
        }
        Ok(())
    }

    pub(super) fn elements(&mut self) -> Outcome {
        let words = self.read(BufferId::Status)?;
        self.count("counters", words[status::UNCONVERGED], self.counts[1], "unconverged");
        self.count("counters", words[status::BAD_STEP], u32::MAX.into(), "bad step");
        self.compare_failures(&words)?;
        let evaluations: u32 = self.read(BufferId::Flags)?.iter().map(|word| word >> 8).sum();
        let numbers = [evaluations.into(), self.counts[0], self.counts[0].max(1.0)];
        self.see("element_force", "evaluations", numbers, || "sum".into());
        Ok(())
    }
}
