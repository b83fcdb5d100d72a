//! Runs the parts of two steps on both backends from the same state, and compares everything they leave behind.

use nalgebra::Vector3;
use ripstop::gpu::Device;
use ripstop::gpu::buffers::Name;
use ripstop::gpu::layout::{self, BODY_WORDS, STATUS_WORDS, SUMS, StepInfo, status, sum};
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::{Stage, Stepper};
use ripstop::kernels::element_force::field as element;
use ripstop::kernels::node_update::field as node;
use ripstop::ledger::Ledger;
use ripstop::outcome;
use ripstop::state::State;
use ripstop::step::{self, FailureEvent, StepTotals};

use super::scenes::{Scene, force_scale};
use super::tolerances::Seen;
use crate::gpu::harness::Outcome;

/// What is compared: what one kernel leaves behind, with the kernels that must run before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Elements,
    Nodes,
    Contact,
    Ledger,
}

impl Part {
    pub(crate) const ALL: [Self; 4] = [Self::Elements, Self::Nodes, Self::Contact, Self::Ledger];

    /// Whether a scene has it.
    fn is_in(self, scene: &Scene) -> bool {
        match self {
            Self::Elements => scene.elements,
            Self::Contact => scene.model.projectile.is_some(),
            Self::Nodes | Self::Ledger => true,
        }
    }

    /// Whether it runs a kernel.
    fn needs(self, kernel: &Kernel) -> bool {
        match self {
            Self::Elements => kernel.name == "element_force",
            Self::Nodes => kernel.name == "node_update",
            Self::Contact => kernel.name == "node_update" || kernel.name == "projectile_contact",
            Self::Ledger => true,
        }
    }
}

/// A kernel's source without what its entry point does: drivers take long to compile what will not run.
fn idle(kernel: &Kernel) -> String {
    let own = kernel.sources[0];
    let head = &own[..own.find("@compute").unwrap_or(own.len())];
    let rest = kernel.sources[1..].concat();
    format!("{head}@compute @workgroup_size(64) fn {}() {{}}\n{rest}", kernel.name)
}

/// Steps compared: the second shows whether sums go on and warm starts are used.
const STEPS: u64 = 2;

/// A scene on both backends.
struct Pair<'a> {
    scene: &'a Scene,
    gpu: Stepper<'a>,
    cpu: step::Stepper<f32>,
    ledger: Ledger,
    totals: StepTotals,
    /// The processor's state.
    expected: State<f32>,
    failures: Vec<FailureEvent>,
    evaluations: f64,
    penetration: f64,
}

impl<'a> Pair<'a> {
    fn new(device: &'a Device, scene: &'a Scene, source: &dyn Fn(&Kernel) -> String) -> Result<Self, String> {
        let gpu = Stepper::with_sources(device, &scene.case, &scene.model, source).map_err(|e| e.to_string())?;
        Ok(Self {
            scene,
            gpu,
            cpu: step::Stepper::new(&scene.model),
            ledger: Ledger::default(),
            totals: StepTotals::default(),
            expected: scene.state.clone(),
            failures: Vec::new(),
            evaluations: 0.0,
            penetration: 0.0,
        })
    }

    /// Both backends begin again from the scene's state.
    fn begin(&mut self) {
        let model = &self.scene.model;
        self.gpu.upload(model, &self.scene.state);
        self.cpu = step::Stepper::new(model);
        self.ledger = Ledger::default();
        self.expected = self.scene.state.clone();
        self.failures.clear();
        (self.evaluations, self.penetration) = (0.0, 0.0);
    }

    /// One step of some stages on both.
    fn advance(&mut self, stages: &[Stage], slot: Option<u32>) -> Result<(), String> {
        let model = &self.scene.model;
        let info = self.gpu.whole_step(self.expected.step, slot, STEPS as u32);
        self.gpu.run_stages(&info, stages).map_err(|e| e.to_string())?;
        let sample = slot.is_some();
        self.totals = StepTotals::default();
        for stage in stages {
            let (state, ledger, totals) = (&mut self.expected, &mut self.ledger, &mut self.totals);
            match stage {
                Stage::Elements => {
                    self.cpu.elements(model, state, ledger, totals, sample);
                    self.failures.extend(self.cpu.failures.iter().copied());
                    self.evaluations += totals.iterations;
                }
                Stage::Nodes => self.cpu.nodes(model, state, ledger, totals, sample),
                Stage::Projectile => self.cpu.projectile(model, state, ledger, totals, sample),
                Stage::Ledger => {}
            }
        }
        self.penetration = self.penetration.max(self.totals.penetration);
        self.expected.step += 1;
        Ok(())
    }

    fn read(&self, name: Name) -> Result<Vec<u32>, String> {
        self.gpu.read(name).map_err(|e| e.to_string())
    }

    fn read_floats(&self, name: Name) -> Result<Vec<f64>, String> {
        Ok(self.read(name)?.into_iter().map(|word| f64::from(f32::from_bits(word))).collect())
    }

    fn download(&self) -> Result<State<f32>, String> {
        let mut got = self.scene.state.clone();
        self.gpu.download(&self.scene.model, &mut got).map_err(|e| e.to_string())?;
        Ok(got)
    }

    /// The name of a quantity in the table.
    fn kind(&self, free: &'static str, held: &'static str) -> &'static str {
        if self.scene.held { held } else { free }
    }

    /// Energy of an element whose yarns are about to break [J].
    fn energy_scale(&self) -> f64 {
        let model = &self.scene.model;
        let yarn = |i: usize| {
            let y = &model.cell.yarn[i];
            y.stiffness * 0.035 * 0.035 * y.half_span
        };
        model.element.cells * (yarn(0) + yarn(1))
    }
}

/// Largest differences of a scene in some parts.
pub(crate) fn differences(
    device: &Device,
    scene: &Scene,
    parts: &[Part],
    source: &dyn Fn(&Kernel) -> String,
) -> Result<Seen, String> {
    let parts: Vec<Part> = parts.iter().copied().filter(|part| part.is_in(scene)).collect();
    let runs = |kernel: &Kernel| {
        let idle = kernel.name == "element_force" && !scene.elements;
        !idle && parts.iter().any(|part| part.needs(kernel))
    };
    let sources = |kernel: &Kernel| if runs(kernel) { source(kernel) } else { idle(kernel) };
    let mut pair = Pair::new(device, scene, &sources)?;
    let mut seen = Seen::default();
    for part in parts {
        match part {
            Part::Elements => elements(&mut pair, &mut seen)?,
            Part::Nodes => nodes(&mut pair, &mut seen)?,
            Part::Contact => contact(&mut pair, &mut seen)?,
            Part::Ledger => ledger(&mut pair, &mut seen)?,
        }
    }
    Ok(seen)
}

fn elements(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    pair.advance(&[Stage::Elements], None)?;
    let first_status = pair.read(Name::Status)?;
    seen.see(
        "residual",
        residual(&first_status),
        pair.totals.max_residual,
        force_scale(&pair.scene.model),
        String::new,
    );
    seen.see("counters", first_status[status::ERODED].into(), pair.totals.eroded as f64, 1.0, || "eroded".into());
    compare_elements(pair, seen)?;
    let first_unconverged = pair.totals.unconverged;
    pair.advance(&[Stage::Elements], Some(0))?;
    compare_elements(pair, seen)?;
    let words = pair.read(Name::Status)?;
    let unconverged = (first_unconverged + pair.totals.unconverged) as f64;
    seen.see("counters", words[status::UNCONVERGED].into(), unconverged, 1.0, || "unconverged".into());
    seen.see("counters", words[status::BAD_STEP].into(), u32::MAX.into(), 1.0, || "bad step".into());
    compare_failures(pair, seen, &words)?;
    let flags = pair.read(Name::Flags)?;
    let evaluations: u32 = flags.iter().map(|word| word >> 8).sum();
    seen.see("evaluations", evaluations.into(), pair.evaluations, pair.evaluations.max(1.0), || "sum".into());
    compare_accounts(pair, seen)
}

fn residual(words: &[u32]) -> f64 {
    f32::from_bits(words[status::RESIDUAL]).into()
}

/// Forces, heights and life of every element.
fn compare_elements(pair: &Pair<'_>, seen: &mut Seen) -> Outcome {
    let (model, expected, got) = (&pair.scene.model, &pair.expected, pair.download()?);
    let (force, height) = (force_scale(model), model.cell.height_sum.max(model.cell.yarn[0].half_span));
    for row in 0..model.grid.element_rows() {
        for column in 0..model.grid.columns {
            let number = |state: &State<f32>, field| f64::from(state.elements.get(row, field, column + 1));
            let size = |first: usize| force + Vector3::from([0, 1, 2].map(|a| number(expected, first + a))).norm();
            for field in 0..element::COUNT {
                let (quantity, scale) = match field {
                    0..element::HOURGLASS => ("force", size(field / 3 * 3)),
                    element::HOURGLASS..element::HEIGHT => ("hourglass", size(element::HOURGLASS)),
                    element::HEIGHT..element::ALIVE => ("height", height),
                    _ => ("alive", 1.0),
                };
                let place = || format!("step {}, row {row}, column {column}, field {field}", expected.step - 1);
                seen.see(quantity, number(&got, field), number(expected, field), scale, place);
            }
        }
    }
    Ok(())
}

fn compare_failures(pair: &Pair<'_>, seen: &mut Seen, words: &[u32]) -> Outcome {
    let grid = &pair.scene.model.grid;
    let count = words[status::EVENTS] as usize;
    let raw = pair.read(Name::Events)?;
    let mut got: Vec<&[u32]> = raw.chunks_exact(4).take(count).collect();
    got.sort();
    let place = |f: &FailureEvent| {
        [f.step as u32, ((f.ply as usize * grid.rows + f.j as usize) * grid.columns) as u32 + f.i, u32::from(f.yarn)]
    };
    let expected: Vec<_> = pair.failures.iter().map(|f| (place(f), f.strain)).collect();
    let same = got.len() == expected.len() && got.iter().zip(&expected).all(|(g, e)| g[..3] == e.0);
    seen.see("failures", f64::from(u8::from(!same)), 0.0, 1.0, || format!("{} for {}", got.len(), expected.len()));
    for yarn in 0..2 {
        let broken = expected.iter().filter(|e| e.0[2] == yarn as u32).count();
        seen.see("counters", words[status::FAILED + yarn].into(), broken as f64, 1.0, || format!("failed, {yarn}"));
    }
    for (g, e) in got.iter().zip(&expected).filter(|_| same) {
        let strain = f64::from(f32::from_bits(g[3]));
        seen.see("failure strain", strain, e.1, 0.035, || format!("{:?}", e.0));
    }
    Ok(())
}

fn compare_accounts(pair: &Pair<'_>, seen: &mut Seen) -> Outcome {
    let accounts = pair.read_floats(Name::Accounts)?;
    let count = pair.scene.model.grid.elements();
    let field = |n: usize| accounts[n * count..(n + 1) * count].iter().copied();
    let add = |n: usize| field(n).sum::<f64>();
    let most = |n: usize| field(n).fold(0.0, f64::max);
    let sums = [add(0), add(1), add(2), add(3), add(4), most(5), most(6)];
    compare_sums(pair, seen, sums, "accounts");
    Ok(())
}

/// Work, released membrane and hourglass energy, stored and hourglass energy, tension, deflection.
fn compare_sums(pair: &Pair<'_>, seen: &mut Seen, got: [f64; 7], place: &str) {
    let balance = pair.ledger.balance();
    let energy = pair.energy_scale();
    let expected = [
        ("work", pair.ledger.work, energy),
        ("released", pair.ledger.released[0], energy),
        ("released", pair.ledger.released[1], energy),
        ("stored", balance.stored, energy),
        ("stored", balance.hourglass, energy),
        ("tension", balance.max_tension, force_scale(&pair.scene.model)),
        ("deflection", pair.cpu.max_deflection(), pair.scene.model.grid.length[0]),
    ];
    for (n, (quantity, value, scale)) in expected.into_iter().enumerate() {
        seen.see(quantity, got[n], value, scale + value.abs(), || format!("{place} {n}"));
    }
}

fn nodes(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    for _ in 0..STEPS {
        pair.advance(&[Stage::Nodes], Some(0))?;
    }
    let length = pair.scene.model.grid.length[0];
    compare_nodes(pair, seen, [("displacement", length), ("velocity", pair.scene.speed)])?;
    let supports = pair.read_floats(Name::Supports)?;
    let scale = force_scale(&pair.scene.model) * pair.scene.model.dt;
    for a in 0..3 {
        let got: f64 = supports.iter().skip(a).step_by(3).sum();
        let expected = pair.ledger.support[a];
        seen.see("support", got, expected, scale + expected.abs(), || format!("direction {a}"));
    }
    if pair.scene.elements {
        // Every held direction of a node that something pulls at has its own place.
        let used = supports.iter().filter(|impulse| **impulse != 0.0).count();
        seen.see("counters", used as f64, held_directions(pair) as f64, 1.0, || "supports".into());
    }
    Ok(())
}

/// Held directions of nodes with a standing element.
fn held_directions(pair: &Pair<'_>) -> usize {
    let (model, state) = (&pair.scene.model, &pair.scene.state);
    let mut count = 0;
    for row in 0..model.grid.node_rows() {
        let inverse = &model.row_mass(model.grid.node_row(row).1).inverse;
        let standing = (0..=model.grid.columns).filter(|column| step::node_stands(&model.grid, state, row, *column));
        count += standing.map(|column| inverse.iter().filter(|of| of[column] == 0.0).count()).sum::<usize>();
    }
    count
}

/// Displacement and velocity of every node, by the names of the quantities and their scales.
fn compare_nodes(pair: &Pair<'_>, seen: &mut Seen, kinds: [(&'static str, f64); 2]) -> Outcome {
    let (model, expected, got) = (&pair.scene.model, &pair.expected, pair.download()?);
    for row in 0..model.grid.node_rows() {
        for column in 0..=model.grid.columns {
            for field in 0..node::COUNT {
                let number = |state: &State<f32>| f64::from(state.nodes.get(row, field, column));
                let (quantity, scale) = kinds[field / 3];
                let place = || format!("row {row}, column {column}, field {field}");
                seen.see(quantity, number(&got), number(expected), scale, place);
            }
        }
    }
    Ok(())
}

fn contact(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    let mut before = pair.expected.body.clone();
    for _ in 0..STEPS {
        before = pair.expected.body.clone();
        pair.advance(&[Stage::Nodes, Stage::Projectile], None)?;
    }
    let way = pair.scene.speed * pair.scene.model.dt;
    compare_nodes(
        pair,
        seen,
        [
            (pair.kind("contact displacement", "contact displacement, held"), way),
            (pair.kind("contact velocity", "contact velocity, held"), pair.scene.speed),
        ],
    )?;
    let marks = pair.read(Name::Candidates)?;
    seen.see("cleared", marks.iter().map(|w| w.count_ones()).sum::<u32>().into(), 0.0, 1.0, || "candidates".into());
    let words = pair.read(Name::Body)?;
    let start = pair.scene.model.projectile.as_ref().ok_or("no projectile")?;
    let record = layout::read_body(&words, start);
    let before = before.ok_or("no projectile")?;
    for a in 0..3 {
        let (velocity, position) = record.before;
        seen.see(
            pair.kind("body velocity", "body velocity, held"),
            velocity[a],
            before.velocity[a],
            pair.scene.speed,
            || format!("before, {a}"),
        );
        seen.see(pair.kind("body position", "body position, held"), position[a], before.position[a], way, || {
            format!("before, {a}")
        });
    }
    compare_body(pair, seen, &record)
}

/// The projectile and what contact did to it.
fn compare_body(pair: &Pair<'_>, seen: &mut Seen, got: &layout::BodyRecord) -> Outcome {
    let Some(expected) = &pair.expected.body else { return Ok(()) };
    let scene = pair.scene;
    let (speed, reach) = (scene.speed, expected.body.reach);
    let mass = f64::from(scene.model.row_mass(1).mass[1]);
    let (impulse, energy) = (mass * speed, mass * speed * speed);
    let ledger = &pair.ledger;
    let supports = pair.read_floats(Name::Supports)?;
    for a in 0..3 {
        let place = || format!("direction {a}");
        let velocity = speed * (mass / expected.mass).min(1.0);
        seen.see(
            pair.kind("body velocity", "body velocity, held"),
            got.body.velocity[a],
            expected.velocity[a],
            velocity,
            place,
        );
        seen.see(
            pair.kind("body position", "body position, held"),
            got.body.position[a],
            expected.position[a],
            speed * scene.model.dt,
            place,
        );
        let spin = [got.body.angular_momentum[a], expected.angular_momentum[a]];
        seen.see("angular momentum", spin[0], spin[1], impulse * reach + spin[1].abs(), place);
        let given = -ledger.contact_impulse[a];
        seen.see(pair.kind("impulse", "impulse, held"), got.impulse[a], given, impulse + given.abs(), place);
        let fabric: f64 = supports.iter().skip(a).step_by(3).sum();
        let held = ledger.support[a];
        seen.see(pair.kind("impulse", "impulse, held"), fabric + got.support[a], held, impulse + held.abs(), || {
            format!("support {a}")
        });
    }
    for (n, value) in [ledger.contact, ledger.friction, ledger.external].into_iter().enumerate() {
        seen.see(
            pair.kind("contact energy", "contact energy, held"),
            got.energy[n],
            value,
            energy + value.abs(),
            || format!("energy {n}"),
        );
    }
    seen.see("penetration", got.penetration, pair.penetration, scene.model.grid.length[0], String::new);
    let turn = got.body.orientation.coords - expected.orientation.coords;
    seen.see("orientation", turn.norm(), 0.0, 1.0, String::new);
    Ok(())
}

fn ledger(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    let mut stages = vec![Stage::Nodes, Stage::Projectile, Stage::Ledger];
    if pair.scene.elements {
        stages.insert(0, Stage::Elements);
    }
    pair.advance(&stages, None)?;
    pair.advance(&stages, Some(1))?;
    let (words, per_sample) = (pair.read(Name::Samples)?, pair.gpu.sizes().sample_words());
    let (sums, rest) = words[per_sample..2 * per_sample].split_at(per_sample - BODY_WORDS - STATUS_WORDS);
    let numbers = |which: usize| sums.chunks_exact(SUMS).map(move |s| f64::from(f32::from_bits(s[which])));
    let add = |which: usize| numbers(which).sum::<f64>();
    let most = |which: usize| numbers(which).fold(0.0, f64::max);
    let same = [sum::WORK, sum::RELEASED, sum::RELEASED_HOURGLASS, sum::STORED, sum::HOURGLASS_NOW].map(add);
    let got = [same[0], same[1], same[2], same[3], same[4], most(sum::TENSION), most(sum::DEFLECTION)];
    compare_sums(pair, seen, got, "ledger");
    seen.see("evaluations", add(sum::EVALUATIONS), pair.evaluations, pair.evaluations.max(1.0), || "ledger".into());
    compare_motion(pair, seen, add, most(sum::FASTEST));
    compare_counts(pair, seen, add);
    if let Some(start) = &pair.scene.model.projectile {
        let record = layout::read_body(&rest[..BODY_WORDS], start);
        // The supports of the fabric are sums of the ledger now.
        for a in 0..3 {
            let got = record.support[a] + add(sum::SUPPORT + a);
            let impulse = f64::from(pair.scene.model.row_mass(1).mass[1]) * pair.scene.speed;
            let expected = pair.ledger.support[a];
            seen.see(pair.kind("impulse", "impulse, held"), got, expected, impulse + expected.abs(), || {
                format!("ledger {a}")
            });
        }
        let body = pair.expected.body.as_ref().ok_or("no projectile")?;
        let covered = outcome::covered(&pair.scene.model, &pair.expected, body);
        seen.see("covered", (add(sum::COVERED) > 0.5).into(), covered.into(), 1.0, String::new);
    }
    seen.see("counters", f64::from(u8::from(rest[BODY_WORDS..] != pair.read(Name::Status)?[..])), 0.0, 1.0, || {
        "copy".into()
    });
    anew(pair, seen)
}

/// Kinetic energies, momentum and supports from the processor's state after the step.
fn compare_motion(pair: &Pair<'_>, seen: &mut Seen, add: impl Fn(usize) -> f64, fastest: f64) {
    let (model, state) = (&pair.scene.model, &pair.expected);
    let (mut kinetic, mut momentum, mut scale, mut square) = (0.0, Vector3::zeros(), 0.0, 0.0_f64);
    for row in 0..model.grid.node_rows() {
        let mass = &model.row_mass(model.grid.node_row(row).1).mass;
        for column in 0..=model.grid.columns {
            let (m, v) = (f64::from(mass[column]), Vector3::from(state.velocity(row, column)));
            kinetic += 0.5 * m * v.norm_squared();
            momentum += m * v;
            scale += m * v.norm();
            square = square.max(v.norm_squared());
        }
    }
    let balance = pair.ledger.balance();
    seen.see("kinetic", add(sum::KINETIC), kinetic, kinetic, String::new);
    seen.see("kinetic now", add(sum::KINETIC_NOW), balance.kinetic, kinetic, String::new);
    seen.see("fastest", fastest, square, square, String::new);
    for a in 0..3 {
        seen.see("momentum", add(sum::MOMENTUM + a), momentum[a], scale, || format!("direction {a}"));
    }
    if model.projectile.is_none() {
        let scale = force_scale(model) * model.dt;
        for a in 0..3 {
            let expected = pair.ledger.support[a];
            seen.see("support", add(sum::SUPPORT + a), expected, scale + expected.abs(), || format!("ledger {a}"));
        }
    }
}

/// Cells with both yarns left, once for every step since the last ledger.
fn compare_counts(pair: &Pair<'_>, seen: &mut Seen, add: impl Fn(usize) -> f64) {
    let grid = &pair.scene.model.grid;
    let whole = |row: usize| (0..grid.columns).filter(move |c| (0..2).all(|yarn| pair.expected.alive(row, *c, yarn)));
    let left = (0..grid.element_rows()).map(|row| whole(row).count()).sum::<usize>();
    seen.see("counters", add(sum::SOLVED), (STEPS as usize * left) as f64, 1.0, || "solved".into());
}

/// A second ledger straight after the first finds that everything that adds up began anew.
fn anew(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    let info = pair.gpu.whole_step(pair.expected.step, Some(0), 0);
    pair.gpu.run_stages(&info, &[Stage::Ledger]).map_err(|e| e.to_string())?;
    let words = pair.read(Name::Samples)?;
    let per_sample = pair.gpu.sizes().sample_words();
    let (sums, body) = words[..per_sample].split_at(per_sample - BODY_WORDS - STATUS_WORDS);
    for which in [0, 1, 2, sum::EVALUATIONS, sum::SOLVED, sum::SUPPORT, sum::SUPPORT + 1, sum::SUPPORT + 2] {
        let left = sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which])).abs()).sum();
        seen.see("cleared", left, 0.0, 1.0, || format!("sum {which}"));
    }
    if let Some(start) = &pair.scene.model.projectile {
        let record = layout::read_body(&body[..BODY_WORDS], start);
        let left: f64 = record.impulse.iter().chain(&record.support).chain(&record.energy).map(|x| x.abs()).sum();
        seen.see("cleared", left, 0.0, 1.0, || "body".into());
        seen.see("penetration", record.penetration, pair.penetration, pair.scene.model.grid.length[0], || {
            "kept".into()
        });
    }
    Ok(())
}

/// A number that is not finite stops everything after its step, on the spot.
pub(crate) fn bad_step(device: &Device) -> Outcome {
    let scene = super::scenes::contact_scenes().swap_remove(0);
    let mut pair = Pair::new(device, &scene, &Kernel::source)?;
    let mut spoilt = scene.state.clone();
    spoilt.nodes.set(3, node::VELOCITY + 1, 2, f32::NAN);
    pair.gpu.upload(&scene.model, &spoilt);
    let index = scene.state.step;
    let whole = |index| StepInfo { index, ..pair.gpu.whole_step(0, None, 1) };
    let infos = [index, index + 1].map(whole);
    let info = |at: u64| infos[(at - index) as usize];
    let all = [Stage::Elements, Stage::Nodes, Stage::Projectile];
    pair.gpu.run_stages(&info(index), &all).map_err(|e| e.to_string())?;
    let names = [Name::Nodes, Name::Forces, Name::Heights, Name::Flags, Name::Accounts, Name::Body, Name::Supports];
    let everything = |pair: &Pair<'_>| names.map(|name| pair.read(name));
    if u64::from(pair.read(Name::Status)?[status::BAD_STEP]) != index {
        return Err("a velocity that is no number goes unnoticed".into());
    }
    let before = everything(&pair);
    pair.gpu.run_stages(&info(index + 1), &all).map_err(|e| e.to_string())?;
    if everything(&pair) == before { Ok(()) } else { Err("the steps after a bad one change something".into()) }
}
