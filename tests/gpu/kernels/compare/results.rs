//! Forces, heights, life and failures of the elements, and the sums of the energy balance after whole steps.

use nalgebra::Vector3;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::sum::{self, SUMS};
use ripstop::gpu::layout::{self, BODY_WORDS, BodyRecord, STATUS_WORDS, status};
use ripstop::gpu::stepper::Stage;
use ripstop::run::outcome;
use ripstop::solver::FailureEvent;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::state::State;

use super::{CONTACT, Outcome, Pair, STEPS, Scales, motion};
use crate::gpu::kernels::scenes::element_places;

impl Pair<'_> {
    /// Heights, life, strains and viscous forces of every element.
    pub(super) fn compare_elements(&mut self, got: &State<f32>) {
        let (model, expected) = (&self.scene.model, &self.expected);
        let Scales { failure_strain, viscous_force, height, .. } = self.scales;
        for [_, row, column] in element_places(model) {
            let number = |state: &State<f32>, field| f64::from(state.elements.get(row, field, column + 1));
            for field in element::HEIGHT..expected.elements.fields {
                let (quantity, scale) = match field {
                    // From one state: half of what whole runs may differ by.
                    element::HEIGHT..element::ALIVE => ("yarn height", 0.5 * height),
                    element::ALIVE..element::COUNT => ("yarn alive", 1.0),
                    _ if field >= expected.elements.fields - element::STRAIN => {
                        ("strain", failure_strain + number(expected, field).abs())
                    }
                    field if field < element::COUNT + element::VISCOUS => ("viscous force", viscous_force),
                    _ => ("rate of strain", 1.0),
                };
                let numbers = [number(got, field), number(expected, field), scale];
                let place = || format!("step {}, row {row}, column {column}, field {field}", expected.step - 1);
                self.seen.see("sweep", quantity, numbers, place);
            }
        }
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
        self.see("sweep", "failures", [f64::from(u8::from(!same)), 0.0, 1.0], || {
            format!("{} for {}", got.len(), expected.len())
        });
        for yarn in 0..2 {
            let broken = expected.iter().filter(|e| e.0[2] == yarn as u32).count();
            self.count("counters", words[status::FAILED + yarn], broken as f64, "broken");
        }
        for (g, (place, strain)) in got.iter().zip(&expected).filter(|_| same) {
            // A yarn that has grown slack in the step in which it breaks has no strain.
            let numbers = [f64::from(f32::from_bits(g[3])).max(0.0), *strain, self.scales.failure_strain + strain];
            self.see("sweep", "failure strain", numbers, || format!("{place:?}"));
        }
        Ok(())
    }

    pub(super) fn elements(&mut self) -> Outcome {
        let words = self.read(BufferId::Status)?;
        self.count("counters", words[status::UNCONVERGED], self.counts[1], "unconverged");
        self.count("counters", words[status::BAD_STEP], u32::MAX.into(), "bad step");
        self.compare_failures(&words)?;
        let tiles = self.read(BufferId::Tiles)?;
        let evaluations =
            tiles.chunks_exact(sum::TILE_SUMS).map(|tile| f64::from(f32::from_bits(tile[sum::EVALUATIONS]))).sum();
        self.see("sweep", "evaluations", [evaluations, self.counts[0], self.counts[0].max(1.0)], || "sum".into());
        let scale = self.scales.force * self.scene.model.dt;
        for (got, expected) in self.supports()?.into_iter().zip(self.balance.support) {
            self.see("sweep", "support", [got, expected, scale + expected.abs()], String::new);
        }
        Ok(())
    }
}

/// Sums that begin anew after a sample.
const ANEW: [usize; 15] = [
    sum::CLAY_WORK,
    sum::LAW_RELEASED,
    sum::HALF_STEP,
    sum::VISCOUS_WORK,
    sum::WORK,
    sum::RELEASED,
    sum::RELEASED_HOURGLASS,
    sum::EVALUATIONS,
    sum::SOLVED,
    sum::SUPPORT,
    sum::SUPPORT + 1,
    sum::SUPPORT + 2,
    sum::PLY_LOSS,
    sum::PLY_FRICTION_WORK,
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
        let body = self.body(&rest).filter(|_| !self.scene.pack);
        let work = body.as_ref().map_or([0.0; 2], |body| body.work);
        self.compare_energies(&sums, work);
        self.compare_motion(&sums, work[1]);
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
    fn compare_energies(&mut self, sums: &[u32], of_body: [f64; 2]) {
        let most =
            |which: usize| sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which]))).fold(0.0, f64::max);
        let (own, balance) = (&self.balance, self.balance.balance());
        let deflection = own.plies.iter().map(|ply| ply.deflection).fold(0.0, f64::max);
        let half_step = add(sums, sum::HALF_STEP);
        let work = add(sums, sum::WORK) - half_step + of_body[0] - of_body[1];
        let law = add(sums, sum::LAW_MADE) + add(sums, sum::LAW_RELEASED);
        let Scales { energy, force, length, node_momentum, speed, .. } = self.scales;
        let of_plies = node_momentum * speed;
        // Contact takes the force on a node from the difference of its velocities.
        let exchanged = if self.scene.elements { 0.0 } else { of_plies };
        let lost = add(sums, sum::PLY_LOSS) - add(sums, sum::PLY_FRICTION_WORK);
        let all = [
            // The work that contact between plies adds to that of the membrane has its own sum on the device.
            ("energy_balance", "work", work, own.work - own.separation, energy + exchanged),
            ("energy_balance", "released energy", add(sums, sum::RELEASED), own.released[0], energy),
            ("energy_balance", "released energy", add(sums, sum::RELEASED_HOURGLASS), own.released[1], energy),
            ("energy_balance", "stored energy", add(sums, sum::STORED), balance.stored, energy),
            ("energy_balance", "stored energy", add(sums, sum::HOURGLASS_NOW), balance.hourglass, energy),
            ("energy_balance", "work", add(sums, sum::VISCOUS_WORK), own.viscous, energy),
            ("energy_balance", "work", add(sums, sum::CLAY_WORK), own.backing, energy),
            ("energy_balance", "deflection", most(sum::CLAY_DEPTH), balance.crater, length[0]),
            ("energy_balance", "law energy", law, balance.law, energy),
            ("energy_balance", "tension", most(sum::TENSION), balance.max_tension, force),
            ("energy_balance", "deflection", most(sum::DEFLECTION), deflection, length[0]),
            ("energy_balance", "load", most(sum::LOAD), balance.max_load, 1.0),
            ("ply_contact", "energy", lost, own.contact, of_plies),
            ("ply_contact", "energy", add(sums, sum::PLY_SEPARATION_WORK), own.separation, of_plies),
            ("ply_contact", "energy", add(sums, sum::PLY_FRICTION_WORK), own.friction, of_plies),
        ];
        for (n, (kernel, quantity, got, expected, scale)) in all.into_iter().enumerate() {
            let compared = match kernel {
                "ply_contact" => self.scene.pack,
                _ => self.scene.elements || quantity == "work" && n == 0,
            };
            if compared {
                self.see(kernel, quantity, [got, expected, scale + expected.abs()], || format!("balance {n}"));
            }
        }
    }

    /// Kinetic energies, momentum and largest speed from the processor's state after the step; evaluations; cells with both yarns left,
    /// once for every step since the last balance.
    fn compare_motion(&mut self, sums: &[u32], half_of_body: f64) {
        let (model, state) = (&self.scene.model, &self.expected);
        let (mut kinetic, mut momentum, mut scale, mut square) = (0.0, Vector3::zeros(), 0.0, 0.0_f64);
        for place in model.node_places() {
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
        let kinetic_now = add(sums, sum::KINETIC) + add(sums, sum::HALF_STEP) + half_of_body;
        self.see("energy_balance", "kinetic energy", [add(sums, sum::KINETIC), kinetic, energy], String::new);
        self.see("energy_balance", "kinetic energy", [kinetic_now, now, energy], || "now".into());
        let size = if self.scene.elements { square } else { square.sqrt() * self.scales.closing[0] };
        self.see("energy_balance", "largest square of speed", [fastest, square, size], String::new);
        for a in 0..3 {
            let numbers = [add(sums, sum::MOMENTUM + a), momentum[a], scale];
            self.see("energy_balance", "momentum", numbers, || format!("direction {a}"));
        }
        if !self.scene.elements {
            return; // weak yarns
        }
        let evaluations = [add(sums, sum::EVALUATIONS), self.counts[0], self.counts[0].max(1.0)];
        self.see("sweep", "evaluations", evaluations, || "energy_balance".into());
        self.count("counters", add(sums, sum::SOLVED), (STEPS as usize * left) as f64, "solved");
    }
}
