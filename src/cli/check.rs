//! Commands that run nothing: `ripstop check`, `info`, `schema` and `completions`.

use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use ripstop::case::{self, Case};
use ripstop::gpu;
use ripstop::model::Model;
use ripstop::num::simd::Vectors;
use ripstop::output::checks::case_warnings;
use ripstop::output::number::{bytes, grouped, us};
use ripstop::output::symmetry;
use ripstop::run::{Sample, Simulation, Skips};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use super::arguments::Arguments;
use super::failure::CommandFailure;
use super::terminal::{self, Align, TextTable};
use super::{backend, input, result};

/// `ripstop check`
#[derive(Args, Debug)]
pub(crate) struct CheckArguments {
    /// Case files
    #[arg(value_name = "CASE.json", required = true)]
    cases: Vec<PathBuf>,
    /// Change of every case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    sets: Vec<String>,
}

/// `ripstop info`
#[derive(Args, Debug)]
pub(crate) struct InfoArguments {
    /// Also say which terms this case has, which kernels run and what memory a GPU needs
    #[arg(value_name = "CASE.json")]
    case: Option<PathBuf>,
}

/// `ripstop schema`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop schema > ripstop.schema.json
  ripstop schema --markdown > keys.md")]
pub(crate) struct SchemaArguments {
    /// Print tables of every key in Markdown instead, for people
    #[arg(long)]
    markdown: bool,
}

/// `ripstop completions`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop completions bash > ~/.local/share/bash-completion/completions/ripstop
  ripstop completions zsh > ~/.zfunc/_ripstop
  ripstop completions fish > ~/.config/fish/completions/ripstop.fish")]
pub(crate) struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Reports every case; fails if any of them is refused.
pub(crate) fn check(arguments: &CheckArguments) -> Result<(), CommandFailure> {
    let mut failures = Vec::new();
    for (index, path) in arguments.cases.iter().enumerate() {
        match report(path, &arguments.sets) {
            Ok(report) => {
                let gap = if index > 0 { "\n" } else { "" };
                terminal::print(&format!("{gap}{}\n{report}", path.display()))?;
            }
            Err(failure) => failures.push(failure),
        }
    }
    failures.into_iter().reduce(CommandFailure::and).map_or(Ok(()), Err)
}

/// Fields of a case, its run, notes and warnings.
fn report(path: &Path, sets: &[String]) -> Result<String, CommandFailure> {
    let case = input::read(path, sets)?;
    let simulation = Simulation::<f64>::with_skips(&case, Skips::default())
        .map_err(|error| CommandFailure::model(&path.display().to_string(), &error))?;
    let run = format!("\n{}\n{}\n", terminal::heading("the run"), the_run(&case, &simulation));
    let notes = result::part("notes", &case.notes.join("\n"));
    let warnings = result::part("warnings", &result::warnings(&case_warnings(&case)));
    Ok([case::report(&case), run, notes, warnings].concat())
}

/// Time step, size and memory of the run.
fn the_run(case: &Case, simulation: &Simulation<f64>) -> TextTable {
    let (model, state) = (&simulation.model, &simulation.state);
    let steps = (case.solver.end_time / model.dt).ceil() as u64 + 1;
    let rows = (case.solver.end_time / case.output.history_interval).ceil() + 1.0;
    let numbers = (state.nodes.data.len() + state.elements.data.len()) * size_of::<f64>();
    let memory = numbers as f64 + rows * size_of::<Sample>() as f64;
    let elements = model.whole_elements() as u64;
    TextTable::pairs([
        ("  critical time step", format!("{}, set by: {}", us(model.bound.critical_step), model.bound.set_by)),
        ("  time step", us(model.dt)),
        ("  steps", format!("{} at most", grouped(steps))),
        ("  elements", grouped(elements)),
        ("  element-steps", format!("{} at most", grouped(elements.saturating_mul(steps)))),
        ("  symmetry", symmetry(model.planes)),
        ("  memory", format!("{} of state and history", bytes(memory))),
    ])
}

/// Prints what this machine offers.
pub(crate) fn info(arguments: &InfoArguments) -> Result<(), CommandFailure> {
    let case = arguments.case.as_deref().map(|path| case::read(path, &[])).transpose()?;
    let mut table = TextTable::plain(&[Align::Left, Align::Left]);
    machine(&mut table);
    table.row(["backend cpu", "f64 or f32"]);
    let adapters = gpu::adapters();
    for (number, adapter) in adapters.iter().enumerate() {
        let limit = bytes(adapter.largest_buffer() as f64);
        let what = format!("{}, {}, {}, buffers up to {limit}", adapter.name(), adapter.kind(), adapter.driver());
        table.row([format!("adapter {number}"), what]);
    }
    if adapters.is_empty() {
        table.row(["backend gpu", "no graphics adapter was found"]);
    }
    let automatic = match backend::automatic(&adapters) {
        Ok(adapter) => format!("gpu, {}", adapter.name()),
        Err(why) => format!("cpu, because {why}"),
    };
    table.row(["auto chooses", automatic.as_str()]);
    if let Some(case) = &case {
        needs(&mut table, case)?;
    }
    terminal::print(&table.to_string())
}

/// Needs of a case: kernels, memory of a device.
fn needs(table: &mut TextTable, case: &Case) -> Result<(), CommandFailure> {
    let model = Model::<f32>::part(case).map_err(|e| CommandFailure::model(&case.path.display().to_string(), &e))?;
    let features = model.features();
    let kernels = gpu::shader::KERNELS.iter().filter(|kernel| kernel.is_in(&features)).map(|kernel| kernel.name);
    table.row(["", ""]);
    table.row(["case", case.title.as_str()]);
    table.row(["symmetry", symmetry(model.planes).as_str()]);
    table.row(["kernels per step", kernels.collect::<Vec<_>>().join(", ").as_str()]);
    table.row(["device memory", bytes(gpu::buffers::Sizes::new(&model).total() as f64).as_str()]);
    Ok(())
}

/// Version, processor and memory.
fn machine(table: &mut TextTable) {
    let memory = MemoryRefreshKind::nothing().with_ram();
    let system =
        System::new_with_specifics(RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing()).with_memory(memory));
    table.row(["ripstop", env!("CARGO_PKG_VERSION")]);
    if let Some(cpu) = system.cpus().first().map(|cpu| cpu.brand().trim()).filter(|name| !name.is_empty()) {
        table.row(["processor", cpu]);
    }
    let threads = std::thread::available_parallelism().map_or_else(|error| error.to_string(), |n| n.to_string());
    table.row(["threads", threads.as_str()]);
    table.row(["SIMD", Vectors::widest().name()]);
    if system.total_memory() > 0 {
        let [total, free] = [system.total_memory(), system.available_memory()].map(|count| bytes(count as f64));
        table.row(["memory", format!("{total}, {free} available").as_str()]);
    }
}

/// Prints the JSON Schema of the case file, or its keys as tables.
pub(crate) fn schema(arguments: &SchemaArguments) -> Result<(), CommandFailure> {
    terminal::print(&match arguments.markdown {
        true => case::reference(),
        false => format!("{:#}\n", case::schema()),
    })
}

/// Prints the script with which a shell completes commands, options and their values.
pub(crate) fn completions(arguments: &CompletionsArguments) -> Result<(), CommandFailure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "ripstop", &mut script);
    terminal::print(&String::from_utf8_lossy(&script))
}
