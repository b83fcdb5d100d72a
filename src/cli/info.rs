//! `ripstop info`: what this machine offers.

use std::thread;

use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use super::failure::Failure;
use super::number::bytes;
use super::screen;
use super::table::{Align, Table};

/// Prints it.
pub(crate) fn info() -> Result<(), Failure> {
    let what =
        RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing()).with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(what);
    let mut table = Table::plain(&[Align::Left, Align::Left]);
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
    table.row(["backend cpu", "yes"]);
    table.row(["backend gpu", "not in this version"]);
    table.row(["auto chooses", "cpu, because this version has no GPU backend"]);
    screen::print(&table.to_string())
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
    if names.is_empty() { "sse2".to_owned() } else { names.join(", ") }
}

/// Instruction sets of this processor that matter for the kernels.
#[cfg(not(target_arch = "x86_64"))]
fn simd() -> String {
    std::env::consts::ARCH.to_owned()
}
