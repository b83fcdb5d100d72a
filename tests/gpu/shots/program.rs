//! The program on the device, as users and scripts meet it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use ripstop::gpu::Device;
use serde_json::Value;
use tempfile::TempDir;

use super::{Outcome, Tests};

pub(super) const TESTS: Tests = &[
    ("a_run_leaves_what_a_run_on_the_processor_leaves", same_files),
    ("an_adapter_is_taken_by_name_and_an_unknown_one_is_3", by_name),
    ("info_lists_the_adapter", info),
];

pub(super) const CASE: &str = "cases/verify/mirror.json";
/// Short and violent, with profiles.
const SETS: [&str; 8] = [
    "--set",
    "/expect=[]",
    "--set",
    "/solver/end_time_us=12",
    "--set",
    "/output/profile_times_us=[5]",
    "--set",
    "/projectile/velocity_m_s=600",
];

pub(super) fn ripstop(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ripstop"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).env("NODEVICE_SELECT", "1").output().unwrap()
}

pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn summary(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

/// Keys of an object and of the objects in it, in order.
fn keys(value: &Value) -> Vec<String> {
    let inner = |(key, value): (&String, &Value)| {
        let below = keys(value).into_iter().map(|below| format!("{key}.{below}")).collect::<Vec<_>>();
        [vec![key.clone()], below].concat()
    };
    value.as_object().into_iter().flatten().flat_map(inner).collect()
}

fn same_files(device: &'static Device) -> Outcome {
    let out = TempDir::new().unwrap();
    let [cpu, gpu] = ["cpu", "gpu"].map(|backend| {
        let folder = out.path().join(backend);
        let run = [&["run", CASE, "--backend", backend, "--out", folder.to_str().unwrap()], &SETS[..]].concat();
        let output = ripstop(&run);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        (folder, text(&output.stdout))
    });
    let expected =
        ["case.json", "events.csv", "history.csv", "profiles.csv", "report.html", "shot.svg", "summary.json"];
    assert_eq!(names(&cpu.0), expected);
    assert_eq!(names(&gpu.0), expected);
    for file in ["history.csv", "events.csv", "profiles.csv"] {
        let [cpu, gpu] = [&cpu.0, &gpu.0].map(|folder| fs::read_to_string(folder.join(file)).unwrap());
        assert_eq!(cpu.lines().next(), gpu.lines().next(), "{file}");
        if file != "events.csv" {
            assert_eq!(cpu.lines().count(), gpu.lines().count(), "{file}");
        }
        assert!(gpu.lines().count() > 10, "{file}");
    }
    let [of_cpu, of_gpu] = [&cpu.0, &gpu.0].map(|folder| summary(folder));
    // Each backend has kernels of its own to report the time of.
    let alike =
        |summary: &Value| keys(summary).into_iter().filter(|key| !key.starts_with("timings.")).collect::<Vec<_>>();
    assert_eq!(alike(&of_cpu), alike(&of_gpu));
    assert_eq!(of_gpu["backend"], "gpu");
    assert_eq!(of_gpu["adapter"], device.name());
    assert_eq!(of_gpu["precision"], "f32");
    assert!(of_gpu["host_overhead_s"].as_f64().unwrap() <= of_gpu["loop_s"].as_f64().unwrap());
    let profile = of_gpu["timings"].as_object().unwrap();
    assert_eq!(profile.is_empty(), !device.has_clock(), "{profile:?}");
    if device.has_clock() {
        let names: Vec<&String> = profile.keys().collect();
        let kernels = ["element_force", "node_update", "ply_contact", "projectile_contact", "energy_balance", "other"];
        assert_eq!(names, kernels);
        for kernel in ["element_force", "node_update", "projectile_contact", "energy_balance"] {
            let share = profile[kernel]["share"].as_f64().unwrap();
            assert!(share > 0.0 && share < 1.0, "{kernel}: {profile:?}");
        }
    }
    assert_eq!(of_gpu["device_lost"], Value::Null);
    for same in ["terms", "case_hash", "steps", "elements", "time_step_us", "outcome", "assumed"] {
        assert_eq!(of_cpu[same], of_gpu[same], "{same}");
    }
    assert!(gpu.1.contains(&format!("gpu, {}, f32", device.name())), "{}", gpu.1);
    assert!(cpu.1.contains("cpu, ") && cpu.1.contains(", f64"), "{}", cpu.1);
    Ok(())
}

fn by_name(device: &'static Device) -> Outcome {
    let out = TempDir::new().unwrap();
    let folder = out.path().join("out");
    let run = |backend: &str, adapter: &str| {
        let asked =
            ["run", CASE, "--backend", backend, "--adapter", adapter, "--out", folder.to_str().unwrap(), "--json"];
        ripstop(&[&asked[..], &SETS[..]].concat())
    };
    let refused = run("gpu", "no such adapter");
    let message = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(3), "{message}");
    assert!(message.contains("no such adapter") && message.contains(device.name()), "{message}");
    assert!(message.contains("ripstop info") && refused.stdout.is_empty(), "{message}");
    assert!(!folder.exists());
    assert_eq!(run("auto", "999").status.code(), Some(3));
    // Part of the name, and `auto` takes what was asked for, software too.
    let part: String = device.name().to_uppercase().chars().take(6).collect();
    let output = run("auto", &part);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["backend"], "gpu", "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains(&format!("auto takes the GPU: {}", device.name())));
    Ok(())
}

fn info(device: &'static Device) -> Outcome {
    let output = ripstop(&["info", CASE]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let text = text(&output.stdout);
    let line = text.lines().find(|line| line.starts_with("adapter 0")).ok_or("no adapter 0")?;
    assert!(line.contains(device.name()) && line.contains("buffers up to"), "{line}");
    assert!(text.contains("auto chooses") && text.contains("device memory"), "{text}");
    Ok(())
}
