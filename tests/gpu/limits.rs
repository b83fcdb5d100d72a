//! Limits and choice of a device, and the program on it.
//!
//! Promises: a scene that does not fit is refused before anything is allocated on the device, with the memory it needs;
//! an adapter is found by name, part of a name or number, and an unknown one is an error that lists what there is; the program leaves the
//! files on a device that it leaves on the processor.

use std::fs;
use std::process::{Command, Output};

use libtest_mimic::Trial;
use ripstop::gpu::buffers::{BufferId, Sizes};
use ripstop::gpu::{Device, DeviceError, adapters, device};
use ripstop::model::Model;
use ripstop::model::mesh::Grid;
use ripstop::run::device::DeviceSimulation;
use ripstop::run::{Options, RunError, Skips};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::harness::{Outcome, trial};
use crate::support::{builtin, shipped};

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    vec![
        trial("limits::bench_times_packs_and_batches_beside_the_processor", bench),
        trial("limits::a_dispatch_over_two_dimensions_gives_the_same_bits", two_dimensions),
        trial("limits::an_adapter_is_found_by_name_part_or_number", choice),
        trial("limits::a_run_leaves_the_files_of_a_run_on_the_processor", program),
        trial("limits::an_unknown_adapter_is_3_and_info_lists_those_there_are", program_adapters),
        Trial::test("limits::too_large_for_a_binding_is_refused_with_the_memory_needed", too_large),
        Trial::test("limits::refused_before_anything_is_allocated", refused),
        Trial::test("limits::a_thousand_shots_are_planned_before_anything_is_allocated", thousand),
    ]
}

/// Plies of 1000 × 1000 elements, for which nothing is allocated.
fn model(plies: usize) -> Model<f32> {
    let mut model = Model::new(&builtin(CASE, &[])).unwrap();
    model.grid = Grid { plies, rows: 1000, columns: 1000, ..model.grid };
    model.plies = vec![model.plies[0]; plies];
    model
}

/// Ordinary limits spread a dispatch only from four million elements on; a narrow device does so at once.
fn two_dimensions(device: &'static Device) -> Outcome {
    let case = builtin(CASE, &["/solver/end_time_us=6", "/projectile/velocity_m_s=600"]);
    let narrow =
        pollster::block_on(Device::request_narrow(&device::choose(&adapters(), None).map_err(|e| e.to_string())?, 7));
    let narrow = narrow.map_err(|e| e.to_string())?;
    assert_eq!(narrow.limits().max_compute_workgroups_per_dimension, 7);
    let [wide, folded] = [device, &narrow].map(|on| Options::default().device(on).run(&case).unwrap());
    assert!(wide.elements > 7 * 64, "{} elements fit into one row of workgroups", wide.elements);
    assert!(!wide.events.is_empty());
    assert_eq!(wide.history, folded.history);
    assert_eq!(wide.events, folded.events);
    Ok(())
}

/// The portable limits, and ones of which 32-bit numbers are the only one left.
fn too_large() -> Result<(), libtest_mimic::Failed> {
    let mut limits = Device::noop().limits();
    let room = limits.max_storage_buffer_binding_size;
    let check = |plies: usize, limits: &wgpu::Limits| {
        let sizes = Sizes::new(&model(plies));
        (sizes, sizes.check(limits, "any"))
    };
    // The largest buffer of a pack holds sixteen words per node.
    let most = (room / (4 * 16 * 1001 * 1001)) as usize;
    assert_eq!((most, check(most, &limits).1), (2, Ok(())));
    let (sizes, refused) = check(most + 1, &limits);
    let (total, needed) = (sizes.total(), sizes.bytes(BufferId::Nodes));
    let expected = DeviceError::TooLarge { adapter: "any".into(), buffer: "nodes", needed, limit: room, total };
    assert_eq!(refused, Err(expected));
    assert!(needed > room && total == BufferId::ALL.iter().map(|id| sizes.bytes(*id)).sum::<u64>());
    (limits.max_storage_buffer_binding_size, limits.max_buffer_size) = (u64::MAX, u64::MAX);
    assert!(check(260, &limits).1.is_ok() && check(275, &limits).1.is_err());
    Ok(())
}

fn choice(device: &'static Device) -> Outcome {
    let found = adapters();
    let name = |wanted: &str| device::choose(&found, Some(wanted)).map(|a| a.name().to_owned());
    let best = device::choose(&found, None).map_err(|e| e.to_string())?;
    assert_eq!(best.name(), device.name());
    let whole = best.name().to_owned();
    assert_eq!(name(&whole), Ok(whole.clone()));
    assert_eq!(name(&whole.to_uppercase()[..4]), Ok(whole.clone()));
    for (number, adapter) in found.iter().enumerate() {
        assert_eq!(name(&number.to_string()), Ok(adapter.name().to_owned()));
    }
    for unknown in ["no such adapter", "9999"] {
        let Err(DeviceError::NoSuchAdapter { wanted, found }) = name(unknown) else {
            return Err(format!("{unknown}: {:?}", name(unknown)));
        };
        assert!(wanted == unknown && found.contains(&whole), "{wanted} {found:?}");
    }
    assert!(matches!(device::choose(&[], Some("0")), Err(DeviceError::NoAdapter)));
    // Hardware comes before software.
    assert!(found.windows(2).all(|pair| pair[0].is_hardware() || !pair[1].is_hardware()));
    Ok(())
}

/// A thousand shots of a quarter of a ply fit into 1.2 GB; a batch is as large as its largest buffer and the memory allow.
fn thousand() -> Result<(), libtest_mimic::Failed> {
    let model = Model::part(&shipped("cases/s720-1ply-155.json", &[])).unwrap();
    assert_eq!(model.planes.copies(), 4);
    let sizes = Sizes::new(&model);
    let all = sizes.with_shots(1000);
    assert!(all.planned() < 1_200_000_000, "{} bytes", all.planned());
    assert_eq!(all.total(), 1000 * sizes.total() - 999 * 4 * sizes.line_numbers, "all have the same lines");
    assert!(all.planned() > all.total(), "buffers that results are fetched through count too");
    let portable = Device::noop().limits();
    let most = sizes.most_shots(&portable, u64::MAX);
    assert!(most > 10 && sizes.with_shots(most).check(&portable, "any").is_ok());
    assert!(sizes.with_shots(most + 1).check(&portable, "any").is_err());
    let few = sizes.most_shots(&portable, 10 * sizes.planned() + 1);
    assert_eq!((few, sizes.most_shots(&portable, 0)), (10, 1), "one shot is tried whatever it takes");
    Ok(())
}

/// On a device that grants what every WebGPU device must, whatever this machine has.
fn refused() -> Result<(), libtest_mimic::Failed> {
    let device = Device::noop();
    let refused = |sets: &[&str]| match DeviceSimulation::with_skips(&builtin(CASE, sets), &device, Skips::WHOLE) {
        Err(RunError::Device(DeviceError::TooLarge { buffer, needed, limit, .. })) => (buffer, needed, limit),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("accepted"),
    };
    let large = ["/pack/width_mm=2500", "/pack/height_mm=2500"];
    let [columns, rows] = builtin(CASE, &large).pack.mesh.count.map(|count| count as u64 + 1);
    let lines = 2 * 32 * (rows.max(columns) + 1);
    assert_eq!(refused(&large), ("nodes", 48 * rows * columns + lines, 128 << 20));
    // The equations of a long edge in twelve plies fit: they lie block by block.
    let sets = ["/projectile/diameter_mm=60", "/projectile/offset_mm=[0,0]", "/pack/plies=12"];
    let edges = ["/solver/contact_sampling=edges", "/pack/width_mm=80", "/pack/height_mm=80"];
    let wide = builtin(CASE, &[sets, edges].concat());
    assert!(DeviceSimulation::with_skips(&wide, &device, Skips::WHOLE).is_ok());
    Ok(())
}

pub(super) const CASE: &str = "cases/verify/mirror.json";
/// Short and violent, with profiles.
const SETS: [&str; 4] = [
    "--set=/expect=[]",
    "--set=/solver/end_time_us=12",
    "--set=/output/profile_times_us=[5]",
    "--set=/projectile/velocity_m_s=600",
];

pub(super) fn ripstop(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ripstop"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).env("NODEVICE_SELECT", "1").output().unwrap()
}

pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Keys of an object and of the objects in it, in order, but for those of timings: each backend has kernels of its own.
fn keys(value: &Value) -> Vec<String> {
    let inner = |(key, value): (&String, &Value)| {
        let below = keys(value).into_iter().filter(|_| key != "timings").map(|below| format!("{key}.{below}"));
        [key.clone()].into_iter().chain(below).collect::<Vec<_>>()
    };
    value.as_object().into_iter().flatten().flat_map(inner).collect()
}

fn program(device: &'static Device) -> Outcome {
    let out = TempDir::new().unwrap();
    let [cpu, gpu] = ["cpu", "gpu"].map(|backend| {
        let folder = out.path().join(backend);
        let run = ["run", CASE, "--backend", backend, "--out", folder.to_str().unwrap()];
        let output = ripstop(&[&run[..], &SETS].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let summary = fs::read(folder.join("summary.json")).unwrap();
        let header = |file| fs::read_to_string(folder.join(file)).unwrap().lines().next().unwrap().to_owned();
        let headers = ["history.csv", "events.csv", "profiles.csv"].map(header);
        let mut names: Vec<_> = fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name()).collect();
        names.sort();
        (names, headers, serde_json::from_slice::<Value>(&summary).unwrap(), text(&output.stdout))
    });
    assert_eq!((&cpu.0, &cpu.1, keys(&cpu.2)), (&gpu.0, &gpu.1, keys(&gpu.2)));
    for (key, expected) in [("backend", "gpu"), ("adapter", device.name()), ("precision", "f32")] {
        assert_eq!(gpu.2[key], expected);
    }
    for same in ["case_hash", "steps", "elements", "time_step_us", "outcome", "assumed", "device_lost"] {
        assert_eq!(cpu.2[same], gpu.2[same], "{same}");
    }
    assert!(gpu.2["host_overhead_s"].as_f64().unwrap() <= gpu.2["loop_s"].as_f64().unwrap());
    let timings = gpu.2["timings"].as_object().unwrap();
    assert_eq!(timings.is_empty(), !device.has_clock(), "{timings:?}");
    let kernels = ["sweep", "projectile_contact", "energy_balance"];
    for kernel in kernels.iter().filter(|_| device.has_clock()) {
        let share = timings[*kernel]["share"].as_f64().unwrap();
        assert!(share > 0.0 && share < 1.0, "{kernel}: {timings:?}");
    }
    assert!(gpu.3.contains(&format!("gpu, {}, f32", device.name())) && cpu.3.contains(", f64"), "{}", gpu.3);
    Ok(())
}

/// On a ply of a few crossovers.
fn bench(device: &'static Device) -> Outcome {
    let out = TempDir::new().unwrap();
    let mut case: Value = serde_json::from_slice(&fs::read(CASE).unwrap()).unwrap();
    case["pack"] = json!({ "width_mm": 7.62, "height_mm": 7.62, "edges": "clamped" });
    case["projectile"]["offset_mm"] = json!([0, 0]);
    let [file, folder] = ["case.json", "out"].map(|name| out.path().join(name).to_str().unwrap().to_owned());
    fs::write(&file, case.to_string()).unwrap();
    let output = ripstop(&["bench", "--gpu", &file, "--out", &folder, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let written: Value = serde_json::from_slice(&fs::read(format!("{folder}/gpu.json")).unwrap()).unwrap();
    assert_eq!(printed, written);
    let measured = &printed["cases"][0];
    assert_eq!((&measured["device"], &measured["left_out"]), (&json!(device.name()), &json!([])));
    let floors = ["copy_gb_per_s", "dispatch_us", "host_us_per_step", "storage_barrier_us", "dependent_read_us"];
    assert!(floors.iter().all(|floor| measured[floor].as_f64().unwrap() > 0.0), "{measured:#}");
    let scenes = measured["scenes"].as_array().unwrap();
    let found: Vec<(&str, u64)> =
        scenes.iter().map(|scene| (scene["name"].as_str().unwrap(), scene["elements"].as_u64().unwrap())).collect();
    let each = found[0].1;
    let packs = [1, 4, 16, 32, 50].map(|plies| plies * each);
    let batches = [64, 1000].map(|shots| shots * each);
    assert_eq!(found.iter().map(|(_, elements)| *elements).collect::<Vec<_>>(), [&packs[..], &batches].concat());
    assert_eq!([found[4].0, found[6].0], ["50 plies", "1000 shots of 1 ply"]);
    for scene in scenes {
        let numbers = [&scene["step_us"], &scene["element_steps_per_s"], &scene["kernels"][0]["us"]];
        let beside = &scene["cpu"]["element_steps_per_s"];
        assert!(numbers.iter().all(|number| number.as_f64().unwrap() > 0.0), "{scene:#}");
        assert_eq!(beside.as_f64().is_some_and(|rate| rate > 0.0), scene["shots"] == 1, "{scene:#}");
    }
    let refused = ripstop(&["bench", "--gpu", &file, "--backend", "cpu"]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    Ok(())
}

fn program_adapters(device: &'static Device) -> Outcome {
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
    assert!(message.contains("ripstop info") && refused.stdout.is_empty() && !folder.exists(), "{message}");
    assert_eq!(run("auto", "999").status.code(), Some(3));
    // Part of the name, and `auto` takes what was asked for, software too.
    let part: String = device.name().to_uppercase().chars().take(6).collect();
    let output = run("auto", &part);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["backend"], "gpu", "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains(&format!("auto takes the GPU: {}", device.name())));
    let output = ripstop(&["info", CASE]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let words = text(&output.stdout);
    let line = words.lines().find(|line| line.starts_with("adapter 0")).ok_or("no adapter 0")?;
    assert!(line.contains(device.name()) && line.contains("buffers up to"), "{line}");
    assert!(words.contains("auto chooses") && words.contains("device memory"), "{words}");
    Ok(())
}
