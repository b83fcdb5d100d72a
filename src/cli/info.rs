//! `ripstop info`: what this machine offers.

use std::thread;

use ripstop::case::{self, Case};
use ripstop::gpu;
use ripstop::model::Model;
use ripstop::output::number::bytes;
use ripstop::output::symmetry;
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use super::arguments::InfoArguments;
use super::backend;
use super::failure::CommandFailure;
use super::screen;
use super::table::{Align, TextTable};

/// Prints it.
pub(crate) fn info(arguments: &InfoArguments) -> Result<(), CommandFailure> {
    let case = arguments.case.as_deref().map(|path| case::read(path, &[])).transpose()?;
    let mut table = TextTable::plain(&[Align::Left, Align::Left]);
    machine(&mut table);
    let adapters = gpu::adapters();
    table.row(["backend cpu", "f64 or f32"]);
    for (number, adapter) in adapters.iter().enumerate() {
        let what = format!(
            "{}, {}, {}, buffers up to {}",
            adapter.name(),
            adapter.kind(),
            adapter.driver(),
            bytes(adapter.largest_buffer() as f64)
        );
        table.row([format!("adapter {number}").as_str(), what.as_str()]);
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
        scene(&mut table, case)?;
    }
    screen::print(&table.to_string())
}

/// What a case needs of a backend.
fn scene(table: &mut TextTable, case: &Case) -> Result<(), CommandFailure> {
    let model = Model::<f32>::part(case).map_err(|e| CommandFailure::model(&case.path.display().to_string(), &e))?;
    table.row(["", ""]);
    table.row(["case", case.title.as_str()]);
    for (name, value) in model.features().list() {
        table.row([name, value.as_str()]);
    }
    table.row(["symmetry", symmetry(model.planes).as_str()]);
    let terms = model.features();
    let kernels: Vec<&str> =
        gpu::shader::KERNELS.iter().filter(|kernel| kernel.is_in(&terms)).map(|kernel| kernel.name).collect();
    table.row(["kernels per step", kernels.join(", ").as_str()]);
    let sizes = gpu::buffers::Sizes::new(&model);
    table.row(["device memory", bytes(sizes.total() as f64).as_str()]);
    Ok(())
}

/// The machine.
fn machine(table: &mut TextTable) {
    let what =
        RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing()).with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(what);
    table.row(["ripstop", env!("CARGO_PKG_VERSION")]);
    if let Some(cpu) = system.cpus().first().map(|cpu| cpu.brand().trim()).filter(|name| !name.is_empty()) {
        table.row(["processor", cpu]);
    }
    let threads = thread::available_parallelism().map_or_else(|error| error.to_string(), |n| n.to_string());
    table.row(["threads", threads.as_str()]);
    table.row(["SIMD", simd().as_str()]);
    if system.total_memory() > 0 {
        let [total, free] = [system.total_memory(), system.available_memory()].map(|count| bytes(count as f64));
        table.row(["memory", format!("{total}, {free} available").as_str()]);
    }
}

/// Instruction sets of this processor that matter for the kernels.
#[cfg(target_arch = "x86_64")]
fn simd() -> String {
    let found = [
        ("sse4.2", is_x86_feature_detected!("sse4.2")),
        ("avx", is_x86_feature_detected!("avx")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ];
    let names: Vec<&str> = found.into_iter().filter(|(_, there)| *there).map(|(name, _)| name).collect();
    if names.is_empty() { "none used".to_owned() } else { names.join(", ") }
}

/// Instruction sets of this processor that matter for the kernels.
#[cfg(not(target_arch = "x86_64"))]
fn simd() -> String {
    std::env::consts::ARCH.to_owned()
}
