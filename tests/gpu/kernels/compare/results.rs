//! Forces, heights, life and failures of the elements, and the sums of the energy balance after whole steps.

use nalgebra::Vector3;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{self, BODY_WORDS, BodyRecord, STATUS_WORDS, SUMS, status, sum};
use ripstop::gpu::stepper::Stage;
use ripstop::run::outcome;
use ripstop::solver::FailureEvent;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::state::State;

use super::{CONTACT, Outcome, Pair, STEPS, Scales, motion, node_places};

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

/// Sums that begin anew after a sample.
const ANEW: [usize; 12] = [
    sum::VISCOUS,
    sum::WORK,
    sum::RELEASED,
    sum::RELEASED_HOURGLASS,
    sum::EVALUATIONS,
    sum::SOLVED,
    sum::SUPPORT,
    sum::SUPPORT + 1,
    sum::SUPPORT + 2,
    sum::PLY_LOSS,
    sum::PLY_RUBBED,
    sum::PLY_SEPARATION_WORK,
];

/// One of the sums, over the workgroups.
fn add(sums: &[u32], which: usize) -> f64 {
    sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which]))).sum()
}

impl Pair<'_> {
    /// Sums and body of a sample.
    fn sample(&self, slot: usize) -> Result<(Vec<u32>, Vec<u32>), String> {
        let (mut words, size) = (self.read(BufferId::Samples)?, self.gpu.sizes.sample_words());
        words.drain(..slot * size);
        words.truncate(size);
        let rest = words.split_off(size - BODY_WORDS - STATUS_WORDS);
        Ok((words, rest))
    }

    fn body(&self, rest: &[u32]) -> Option<BodyRecord> {
        let start = self.scene.model.projectile.as_ref()?;
        Some(layout::read_body(&rest[..BODY_WORDS], start, &layout::device_origin(&self.scene.model)))
    }

    /// Everything that the second step leaves in its sample, and what a second balance straight after it begins anew.
    pub(super) fn energy_balance(&mut self) -> Outcome {
        let (sums, rest) = self.sample(1)?;
        self.compare_energies(&sums);
        self.compare_motion(&sums);
        let body = self.body(&rest).filter(|_| !self.scene.pack);
        let (kernel, quantity, scale) = match (&body, self.scene.pack) {
            (Some(_), _) => (CONTACT, "impulse", self.scales.impulse),
            (None, true) => ("ply_contact", "support", self.scales.node_momentum),
            (None, false) => ("energy_balance", "support", self.scales.force * self.scene.model.dt),
        };
        for a in 0..3 {
            let got = add(&sums, sum::SUPPORT + a) + body.as_ref().map_or(0.0, |body| body.support[a]);
            let expected = self.balance.support[a];
            self.see(kernel, quantity, [got, expected, scale + expected.abs()], || format!("balance {a}"));
        }
        if body.is_some() {
            let body = self.expected.body.clone().ok_or("no projectile")?;
            // Each ply has as many workgroups, one after the other.
            let count = self.scene.model.plies.len();
            for (ply, sums) in sums.chunks_exact(sums.len() / count).enumerate() {
                let covered = outcome::covered(&self.scene.model, &self.expected, &body, ply);
                let numbers = [(add(sums, sum::COVERED) > 0.5).into(), covered.into(), 1.0];
                self.see("energy_balance", "covered", numbers, || format!("ply {ply}"));
            }
        }
        let status = self.read(BufferId::Status)?;
        self.count("counters", u8::from(rest[BODY_WORDS..] != status[..STATUS_WORDS]), 0.0, "copy");
        let info = self.gpu.whole_step(self.expected.step, Some(0), 0);
        self.gpu.run_stages(&info, &[Stage::EnergyBalance]).map_err(|e| e.to_string())?;
        let (sums, rest) = self.sample(0)?;
        for which in ANEW {
            let left: f64 = sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which])).abs()).sum();
            self.count("cleared", left, 0.0, &format!("sum {which}"));
        }
        if let Some(body) = self.body(&rest) {
            let left: f64 = body.impulse.iter().chain(&body.support).chain(&body.energy).map(|x| x.abs()).sum();
            self.count("cleared", left, 0.0, "body");
            let numbers = [body.penetration, self.penetration[0], self.scales.length[0]];
            self.see(CONTACT, "penetration", numbers, || "kept".into());
        }
        Ok(())
    }

    /// Work, released and stored energies, largest numbers, evaluations and losses between plies.
    fn compare_energies(&mut self, sums: &[u32]) {
        let most =
            |which: usize| sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which]))).fold(0.0, f64::max);
        let (own, balance) = (&self.balance, self.balance.balance());
        let deflection = own.plies.iter().map(|ply| ply.deflection).fold(0.0, f64::max);
        // The work that contact between plies adds to that of the membrane has its own sum on the device.
        let work = if self.scene.elements { own.work } else { 0.0 };
        let Scales { energy, force, length, node_momentum, speed, .. } = self.scales;
        let of_plies = node_momentum * speed;
        let lost = add(sums, sum::PLY_LOSS) - add(sums, sum::PLY_RUBBED);
        let all = [
            ("energy_balance", "work", add(sums, sum::WORK), work, energy),
            ("energy_balance", "released energy", add(sums, sum::RELEASED), own.released[0], energy),
            ("energy_balance", "released energy", add(sums, sum::RELEASED_HOURGLASS), own.released[1], energy),
            ("energy_balance", "stored energy", add(sums, sum::STORED), balance.stored, energy),
            ("energy_balance", "stored energy", add(sums, sum::HOURGLASS_NOW), balance.hourglass, energy),
            ("energy_balance", "work", add(sums, sum::VISCOUS), own.viscous, energy),
            ("energy_balance", "law energy", add(sums, sum::LAW), balance.law, energy),
            ("energy_balance", "tension", most(sum::TENSION), balance.max_tension, force),
            ("energy_balance", "deflection", most(sum::DEFLECTION), deflection, length[0]),
            ("energy_balance", "load", most(sum::LOAD), balance.max_load, 1.0),
            ("ply_contact", "energy", lost, own.contact, of_plies),
            ("ply_contact", "energy", add(sums, sum::PLY_SEPARATION_WORK), own.separation, of_plies),
            ("ply_contact", "energy", add(sums, sum::PLY_RUBBED), own.friction, of_plies),
        ];
        for (n, (kernel, quantity, got, expected, scale)) in all.into_iter().enumerate() {
            if self.scene.pack || kernel != "ply_contact" {
                self.see(kernel, quantity, [got, expected, scale + expected.abs()], || format!("balance {n}"));
            }
        }
    }

    /// Kinetic energies, momentum and largest speed from the processor's state after the step; evaluations; cells with both yarns left,
    /// once for every step since the last balance.
    fn compare_motion(&mut self, sums: &[u32]) {
        let (model, state) = (&self.scene.model, &self.expected);
        let (mut kinetic, mut momentum, mut scale, mut square) = (0.0, Vector3::zeros(), 0.0, 0.0_f64);
        for place in node_places(model) {
            let (m, v) = motion(model, state, place);
            kinetic += 0.5 * m * v.norm_squared();
            momentum += m * v;
            scale += m * v.norm();
            square = square.max(v.norm_squared());
        }
        let whole = |ply: usize| {
            let mesh = &model.ply_type(ply).mesh;
            let first = model.grid.first_element_row(ply);
            let all = (0..mesh.rows).flat_map(move |row| (0..mesh.columns).map(move |column| (first + row, column)));
            all.filter(|(row, column)| (0..2).all(|yarn| state.alive(*row, *column, yarn))).count()
        };
        let left = (0..model.grid.plies).map(whole).sum::<usize>();
        let fastest = sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[sum::FASTEST]))).fold(0.0, f64::max);
        let (now, energy) = (self.balance.balance().kinetic, kinetic + self.scales.kinetic);
        self.see("energy_balance", "kinetic energy", [add(sums, sum::KINETIC), kinetic, energy], String::new);
        self.see("energy_balance", "kinetic energy", [add(sums, sum::KINETIC_NOW), now, energy], || "now".into());
        self.see("energy_balance", "largest square of speed", [fastest, square, square], String::new);
        for a in 0..3 {
            let numbers = [add(sums, sum::MOMENTUM + a), momentum[a], scale];
            self.see("energy_balance", "momentum", numbers, || format!("direction {a}"));
        }
        let evaluations = [add(sums, sum::EVALUATIONS), self.counts[0], self.counts[0].max(1.0)];
        self.see("element_force", "evaluations", evaluations, || "energy_balance".into());
        self.count("counters", add(sums, sum::SOLVED), (STEPS as usize * left) as f64, "solved");
    }
}
