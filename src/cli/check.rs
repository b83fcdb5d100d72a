//! Commands that run nothing: `ripstop check`, `info`, `schema`, `completions`, `explain` and `crossover`.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::thread;

use clap::{Args, CommandFactory, ValueEnum};
use clap_complete::Shell;
use ripstop::case::{self, Case, Edge, Edges, Fabric};
use ripstop::gpu;
use ripstop::model::Model;
use ripstop::model::unit_cell::{self, CurveLaw, CurvePoint};
use ripstop::num::simd::Vectors;
use ripstop::output::checks::case_warnings;
use ripstop::output::number::{bytes, grouped, short, us};
use ripstop::output::warnings::assumed_fields;
use ripstop::output::{self, behind, held, symmetry};
use ripstop::run::{Simulation, Skips};
use serde_json::{Map, Value, json};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use super::arguments::{Arguments, Stretches, read};
use super::run::warnings;
use super::terminal::{self, Align, CommandFailure, TextTable, part};

/// Points in one grid of stretches at most.
const MAX_POINTS: usize = 1_000_000;
/// Columns of the sketch of a pack.
const SKETCH: usize = 24;
/// `ripstop check`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop check shot.json --set /pack/plies=8
  ripstop check shot.json --json | jq '.fabrics[0].warp.breaking_load_n'")]
pub(crate) struct CheckArguments {
    /// Case files
    #[arg(value_name = "CASE.json", required = true)]
    cases: Vec<PathBuf>,
    /// Change of every case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    sets: Vec<String>,
    /// Every field: read, default or derived, with its source
    #[arg(long)]
    all: bool,
    /// Print JSON instead of text, an object for each case, with every field
    #[arg(long)]
    json: bool,
}

/// `ripstop crossover`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop crossover cases/s720-1ply-155.json --warp-stretch 1:1.05:26 --weft-stretch 1
  ripstop crossover shot.json --warp-stretch 1.01 --weft-stretch 1 --law kawabata --json")]
pub(crate) struct CrossoverArguments {
    /// Case file; only its fabric matters
    #[arg(value_name = "CASE.json")]
    case: PathBuf,
    /// Fabric stretch along warp: one value, or first:last:count
    #[arg(long, value_name = "A[:B:N]")]
    warp_stretch: Stretches,
    /// Fabric stretch along weft: one value, or first:last:count
    #[arg(long, value_name = "C[:D:N]")]
    weft_stretch: Stretches,
    /// Unit-cell law [default: the case's]
    #[arg(long, value_enum)]
    law: Option<CurveLaw>,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    sets: Vec<String>,
    /// Print JSON, every digit
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print CSV, every digit
    #[arg(long)]
    csv: bool,
}

/// Reports every case; fails if any of them is refused.
pub(crate) fn check(arguments: &CheckArguments) -> Result<(), CommandFailure> {
    let mut failures = Vec::new();
    for path in &arguments.cases {
        match read(path, &arguments.sets).map_err(Into::into).and_then(|case| Ok((sheet(&case)?, case))) {
            Ok(((_, value), _)) if arguments.json => terminal::print_raw(&format!("{value:#}\n"))?,
            Ok(((text, _), case)) => {
                // The title stands above already.
                let every_field = || case::report(&case).replacen(&case.title, "", 1);
                let fields = if arguments.all { every_field() } else { assumed(&case) };
                let notes = part("notes", &case.notes.join("\n"));
                let warnings = part("warnings", &warnings(&case_warnings(&case)));
                terminal::print_within(
                    terminal::PAGE,
                    &format!("{}\n{text}{fields}{notes}{warnings}", path.display()),
                )?;
            }
            Err(failure) => failures.push(failure),
        }
    }
    failures.into_iter().reduce(CommandFailure::and).map_or(Ok(()), Err)
}

/// Numbers of a case that are held against a data sheet, and of its run: as text, and as JSON with every field.
fn sheet(case: &Case) -> Result<(String, Value), CommandFailure> {
    let simulation = Simulation::<f64>::with_skips(case, Skips::default());
    let simulation = simulation.map_err(|error| error.in_file(&case.path.display().to_string()))?;
    let value = output::sheet(case, &simulation);
    let digits = |value: &Value, count| short(value.as_f64().unwrap_or_default(), count);
    let layers = case.layers();
    let mut rows = TextTable::pairs::<String>([]);
    for (layer, one) in layers.iter().zip(value["fabrics"].as_array().into_iter().flatten()) {
        let fabric = &layer.fabric;
        let [areal, thickness] = [digits(&one["areal_density_g_m2"], 4), short(1e3 * fabric.thickness, 4)];
        rows.row(["fabric".to_owned(), format!("{}: a ply of {areal} g/m², {thickness} mm thick", fabric.name)]);
        for (name, yarn) in
            [("warp", &fabric.warp), ("weft", &fabric.weft)].into_iter().filter(|(_, yarn)| yarn.present)
        {
            let [dtex, count] = [1e7 * yarn.linear_density, 1e-2 * yarn.count].map(|number| short(number, 4));
            let breaks = one[name]["breaking_load_n"].as_f64().map_or_else(
                || "never breaks".to_owned(),
                |load| {
                    let tenacity = short(1e-6 * load / yarn.linear_density, 3);
                    format!("breaks at {} N ({tenacity} N/tex)", short(load, 3))
                },
            );
            let wave_speed = digits(&one[name]["wave_speed_m_s"], 4);
            rows.row([format!("  {name}"), format!("{dtex} dtex, {count}/cm, {breaks}, wave {wave_speed} m/s")]);
        }
    }
    let [width, height] = extent(case);
    let plies: u32 = layers.iter().map(|layer| layer.plies).sum();
    let plies = if plies == 1 { "1 ply".to_owned() } else { format!("{plies} plies") };
    let size = [width, height].map(|side| short(1e3 * side, 4)).join(" × ");
    let pack = digits(&value["areal_density_kg_m2"], 4);
    rows.row(["pack".to_owned(), format!("{plies}, {size} mm, {pack} kg/m²")]);
    if let Some(projectile) = &case.projectile {
        let [mass, velocity] = [1e3 * projectile.mass, projectile.velocity].map(|n| short(n, 4));
        let (diameter, energy) = (short(1e3 * projectile.shape.diameter(), 4), digits(&value["impact_energy_j"], 4));
        let body = format!("{diameter} mm wide, {mass} g, {velocity} m/s: impact energy {energy} J");
        rows.row(["projectile".to_owned(), body]);
    }
    let cost = the_run(case, &simulation, &value["run"]).to_string();
    let text = format!("{}\n\n{rows}\n{}{}", case.title, sketch(case, [width, height]), part("the run", &cost));
    Ok((text, value))
}

/// Width and height of the pack as it is meshed [m].
fn extent(case: &Case) -> [f64; 2] {
    let mesh = case.pack.mesh;
    [0, 1].map(|axis| mesh.count[axis] as f64 * mesh.length[axis])
}

/// Sketch of the pack as the projectile sees it, with its sides and the place of the hit.
fn sketch(case: &Case, [width, height]: [f64; 2]) -> String {
    // Letters are about twice as high as wide.
    let rows = (SKETCH as f64 * 0.5 * height / width).round().clamp(3.0, SKETCH as f64 / 2.0) as usize;
    let Edges { left, right, bottom, top, .. } = case.pack.edges;
    let [lying, standing] = [["═", "─", "┄"], ["║", "│", "┆"]];
    let side = |edge: Edge| lying[edge as usize].repeat(SKETCH);
    let hit = case.projectile.as_ref().map(|projectile| {
        let [x, y] = projectile.offset;
        let place = |share: f64, count: usize| (((0.5 + share) * count as f64) as usize).min(count - 1);
        [place(x / width, SKETCH), place(-y / height, rows)]
    });
    let mut out = format!("  +{}+\n", side(top));
    for row in 0..rows {
        let cell = |column: usize| if hit == Some([column, row]) { "●" } else { " " };
        let cells: String = (0..SKETCH).map(cell).collect();
        out += &format!("  {}{cells}{}\n", standing[left as usize], standing[right as usize]);
    }
    out += &format!("  +{}+\n", side(bottom));
    let all = [left, right, bottom, top];
    let kinds = [(Edge::Clamped, "═ clamped"), (Edge::Free, "─ free"), (Edge::Roller, "┄ roller")];
    let mut words: Vec<String> =
        kinds.into_iter().filter(|(edge, _)| all.contains(edge)).map(|(_, words)| words.to_owned()).collect();
    words.extend(case.projectile.as_ref().map(|projectile| {
        let [x, y] = projectile.offset.map(|offset| short(1e3 * offset, 4));
        let angle = short(projectile.obliquity.to_degrees(), 3);
        format!("● hit at [{x}, {y}] mm, {angle}° from the normal")
    }));
    out + &format!("  {}\n", words.join("   ")) + "  warp →, weft ↑, seen from the back face\n"
}

/// Fields that are assumed, under their sources.
fn assumed(case: &Case) -> String {
    let mut sources: Vec<(&str, Vec<String>)> = Vec::new();
    for field in assumed_fields(case) {
        let (source, words) = (field.source.trim_start_matches("assumed: "), field.with_unit());
        let words = format!("{} = {words}", field.pointer);
        match sources.iter_mut().find(|(known, _)| *known == source) {
            Some((_, fields)) => fields.push(words),
            None => sources.push((source, vec![words])),
        }
    }
    let title =
        format!("assumed, {} of {} fields (--all: every field)", assumed_fields(case).count(), case.fields.len());
    let groups = sources.iter().map(|(source, fields)| format!("{source}\n  {}\n", fields.join(", ")));
    part(&title, &groups.collect::<String>())
}

/// Time step, size and memory of the run.
fn the_run(case: &Case, simulation: &Simulation<f64>, numbers: &Value) -> TextTable {
    let (model, number) = (&simulation.model, |name: &str| numbers[name].as_f64().unwrap_or_default());
    let [steps, elements] = ["steps", "elements"].map(|name| numbers[name].as_u64().unwrap_or_default());
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let (seconds, each) = (short(number("run_time_s"), 2), output::element_step(model.plies.len()));
    TextTable::pairs([
        ("critical time step", format!("{}, set by: {}", us(model.bound.critical_step), model.bound.set_by)),
        ("time step", format!("{}, {} steps at most", us(model.dt), grouped(steps))),
        ("elements", format!("{}: {}", grouped(elements), symmetry(model.planes))),
        ("element-steps", format!("{} at most", grouped(elements.saturating_mul(steps)))),
        ("held", held(case)),
        ("behind the pack", behind(case)),
        ("run time", format!("{seconds} s at most, at {each} µs an element-step, threads: {threads}")),
        ("memory", format!("{} of state and history", bytes(number("memory_bytes")))),
    ])
}

/// Prints adapters and memory of this machine, and what a case needs of them.
pub(crate) fn info(case: Option<&Path>) -> Result<(), CommandFailure> {
    let case = case.map(|path| case::read(path, &[])).transpose()?;
    let refresh = RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing());
    let system = System::new_with_specifics(refresh.with_memory(MemoryRefreshKind::nothing().with_ram()));
    let processor = system.cpus().first().map_or("", |cpu| cpu.brand().trim()).to_owned();
    let threads = thread::available_parallelism().map_or_else(|error| error.to_string(), |n| n.to_string());
    let [total, free] = [system.total_memory(), system.available_memory()].map(|count| bytes(count as f64));
    let adapters = gpu::adapters();
    let mut table = TextTable::pairs([
        ("ripstop", env!("CARGO_PKG_VERSION").to_owned()),
        ("processor", processor),
        ("threads", threads),
        ("SIMD", Vectors::widest().name().to_owned()),
        ("memory", format!("{total}, {free} available")),
        ("backend cpu", "f64 or f32".to_owned()),
    ]);
    for (number, adapter) in adapters.iter().enumerate() {
        let limit = bytes(adapter.largest_buffer() as f64);
        let what = format!("{}, {}, {}, buffers up to {limit}", adapter.name(), adapter.kind(), adapter.driver());
        table.row([format!("adapter {number}"), what]);
    }
    let automatic = match gpu::device::automatic(&adapters) {
        Ok(adapter) => format!("gpu, {}", adapter.name()),
        Err(why) => format!("cpu, because {why}"),
    };
    table.row(["auto chooses", automatic.as_str()]);
    if let Some(case) = &case {
        let model = Model::<f32>::part(case).map_err(|error| error.in_file(&case.path.display().to_string()))?;
        let features = model.features();
        let kernels = gpu::shader::KERNELS.iter().filter(|kernel| kernel.is_in(&features)).map(|kernel| kernel.name);
        table.row(["", ""]);
        table.row(["case", case.title.as_str()]);
        table.row(["symmetry", symmetry(model.planes).as_str()]);
        table.row(["kernels per step", kernels.collect::<Vec<_>>().join(", ").as_str()]);
        table.row(["device memory", bytes(gpu::buffers::Sizes::new(&model).total() as f64).as_str()]);
    }
    terminal::print(&table.to_string())
}

/// Prints the JSON Schema of the case file, or its keys as tables.
pub(crate) fn schema(markdown: bool) -> Result<(), CommandFailure> {
    terminal::print_raw(&match markdown {
        true => case::reference(),
        false => format!("{:#}\n", case::schema()),
    })
}

/// Prints the script with which a shell completes commands, options and their values.
pub(crate) fn completions(shell: Shell) -> Result<(), CommandFailure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "ripstop", &mut script);
    terminal::print_raw(&String::from_utf8_lossy(&script))
}

/// Page with a section for every code: `### code name`, then a list of what there is to say.
const CODES: &str = include_str!("../../docs/src/commands.md");

/// Explains one code, or lists all.
pub(crate) fn explain(code: Option<&str>) -> Result<(), CommandFailure> {
    let sections = CODES.split("\n## ").flat_map(|part| part.split("\n### ").skip(1));
    let sections: Vec<(&str, &str, &str)> = sections
        .filter_map(|section| {
            let (heading, list) = section.split_once("\n\n- ")?;
            heading.split_once(' ').map(|(code, name)| (code, name, list))
        })
        .collect();
    let Some(code) = code else {
        let table = TextTable::pairs(sections.iter().map(|section| (section.0, section.1.to_owned())));
        let help = "\n`ripstop explain CODE` says what one means and what to do.\n";
        return terminal::print((part("codes", &table.to_string()) + help).trim_start());
    };
    let is_it = |word: &str| word.eq_ignore_ascii_case(code);
    let Some((code, name, list)) = sections.iter().find(|section| is_it(section.0) || is_it(section.1)) else {
        let codes: Vec<&str> = sections.iter().map(|section| section.0).collect();
        let failure = CommandFailure::expected("no such code", codes.join(", "), code);
        return Err(failure.help("`ripstop explain` lists what they mean"));
    };
    let parts = list.trim_end().split("\n- ").filter_map(|item| item.split_once(": "));
    let parts = parts.map(|(what, text)| (what, text.split_whitespace().collect::<Vec<_>>().join(" ")));
    terminal::print(part(&format!("{code} {name}"), &TextTable::pairs(parts).to_string()).trim_start())
}

/// Solves and prints the grid.
pub(crate) fn crossover(arguments: &CrossoverArguments) -> Result<(), CommandFailure> {
    let fabric = case::read(&arguments.case, &arguments.sets)?.fabric;
    let law = arguments.law.unwrap_or_else(|| fabric.crossover.law.into());
    let (warp, weft) = (&arguments.warp_stretch.0, &arguments.weft_stretch.0);
    if warp.len() * weft.len() > MAX_POINTS {
        let [expected, found] = [format!("at most {MAX_POINTS} points"), format!("{} × {}", warp.len(), weft.len())];
        return Err(CommandFailure::expected("--warp-stretch, --weft-stretch", expected, found));
    }
    let points = unit_cell::solve_with(&fabric, law, warp, weft);
    terminal::print_raw(&match (arguments.json, arguments.csv) {
        (true, _) => json_text(law, &points),
        (_, true) => csv_text(&points),
        _ => table_text(&fabric, law, &points),
    })
}

/// Word of a law on the command line.
fn word(law: CurveLaw) -> String {
    law.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

fn json_text(law: CurveLaw, points: &[CurvePoint]) -> String {
    let object = |point: &CurvePoint| {
        let mut object = Map::from_iter(point.numbers().map(|(name, number)| (name.to_owned(), json!(number))));
        object.insert("iterations".to_owned(), json!(point.cell.iterations as u64));
        Value::Object(object)
    };
    let points: Vec<Value> = points.iter().map(object).collect();
    format!("{:#}\n", json!({ "law": word(law), "points": points }))
}

fn csv_text(points: &[CurvePoint]) -> String {
    let heading = points.first().map(|point| point.numbers().map(|(name, _)| name.to_owned()).join(","));
    let rows = points.iter().map(|point| point.numbers().map(|(_, number)| format!("{number:?}")).join(","));
    heading.into_iter().chain(rows).map(|line| line + "\n").collect()
}

fn table_text(fabric: &Fabric, law: CurveLaw, points: &[CurvePoint]) -> String {
    let heads = ["Λ warp", "Λ weft", "T warp N", "T weft N", "F N", "h warp mm", "h weft mm", "ε warp", "ε weft"];
    let mut table = TextTable::plain(&[Align::Right; 9]);
    table.row(heads);
    for point in points {
        table.row(point.numbers().into_iter().take(heads.len()).map(|(_, number)| short(number, 6)));
    }
    format!("{}, {} law\n\n{table}", fabric.name, word(law))
}
