//! What a device cannot do, and what becomes of a run whose device goes away.
//!
//! Promises: a scene that does not fit is refused before anything is allocated on the device, with the memory it needs;
//! an adapter is found by name, part of a name or number, and an unknown one is an error that lists what there is; a
//! device lost in mid-run ends the run with a reason and with the history so far.

use std::sync::atomic::AtomicBool;

use libtest_mimic::Trial;
use ripstop::gpu::buffers::{BufferId, Sizes};
use ripstop::gpu::{Device, DeviceError, adapters, device};
use ripstop::model::Model;
use ripstop::model::mesh::Grid;
use ripstop::run::device::DeviceSimulation;
use ripstop::run::{self, Options, RunError};

use super::harness::{Outcome, trial};
use crate::scene::{builtin, shipped};

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    vec![
        trial("limits::too_large_for_a_binding_is_refused_with_the_memory_needed", too_large),
        trial("limits::a_dispatch_over_two_dimensions_gives_the_same_bits", two_dimensions),
        trial("limits::an_adapter_is_found_by_name_part_or_number", choice),
        trial("limits::a_device_lost_in_mid_run_leaves_the_history_so_far", lost),
        Trial::test("limits::refused_before_anything_is_allocated", refused),
        Trial::test("limits::a_thousand_shots_are_planned_before_anything_is_allocated", thousand),
    ]
}

/// Plies of 1000 × 1000 elements; nothing of that size is held anywhere.
fn model(plies: usize) -> Model<f32> {
    let mut model = Model::new(&builtin("cases/verify/mirror.json", &[])).unwrap();
    model.grid = Grid { plies, rows: 1000, columns: 1000, ..model.grid };
    model.plies = vec![model.plies[0]; plies];
    model
}

/// Ordinary limits spread a dispatch only from four million elements on; a narrow device does so at once.
fn two_dimensions(device: &'static Device) -> Outcome {
    let case = builtin("cases/verify/mirror.json", &["/solver/end_time_us=6", "/projectile/velocity_m_s=600"]);
    let narrow = Device::open_narrow(&device::choose(&adapters(), None).map_err(|e| e.to_string())?, 7);
    let narrow = narrow.map_err(|e| e.to_string())?;
    assert_eq!(narrow.limits().max_compute_workgroups_per_dimension, 7);
    let [wide, folded] = [device, &narrow].map(|on| {
        let options = Options::default().device(on);
        run::run(&case, options, &AtomicBool::new(false), &mut ()).unwrap()
    });
    assert!(wide.elements > 7 * 64, "{} elements fit into one row of workgroups", wide.elements);
    assert!(!wide.events.is_empty());
    assert_eq!(wide.history, folded.history);
    assert_eq!(wide.events, folded.events);
    Ok(())
}

/// What every device must be able to bind, and what software binds [bytes].
const LEAST_BUFFER: u64 = 1 << 27;

fn too_large(device: &'static Device) -> Outcome {
    let limits = device.limits();
    let mut least = limits.clone();
    (least.max_storage_buffer_binding_size, least.max_buffer_size) = (LEAST_BUFFER, LEAST_BUFFER);
    for limits in [&limits, &least] {
        let room = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let fits = |plies: usize| {
            let sizes = Sizes::new(&model(plies));
            (sizes, sizes.check(limits, device.name()))
        };
        // The largest buffer of a pack holds sixteen words per node.
        let most = (room / (4 * 16 * 1001 * 1001)) as usize;
        assert!(most > 1, "{room} bytes are less than every device must bind");
        assert_eq!(fits(most).1, Ok(()), "{most} plies");
        let (sizes, refused) = fits(most + 1);
        let Err(DeviceError::TooLarge { adapter, buffer, needed, limit, total }) = refused else {
            return Err(format!("{} plies are not refused: {refused:?}", most + 1));
        };
        // The first that has no room: where a ply is much of it, accounts have none either.
        let without_room = BufferId::ALL.into_iter().find(|name| sizes.bytes(*name) > room).unwrap();
        let named = if room == LEAST_BUFFER { "accounts" } else { without_room.variable() };
        assert_eq!((adapter.as_str(), buffer, limit), (device.name(), named, room));
        assert_eq!(needed, sizes.bytes(without_room));
        assert_eq!(total, BufferId::ALL.iter().map(|name| sizes.bytes(*name)).sum::<u64>());
        assert!(needed > room && total > needed);
    }
    // Where a buffer may be larger than what 32-bit numbers reach, they are the limit.
    let mut endless = limits;
    endless.max_storage_buffer_binding_size = u64::MAX;
    endless.max_buffer_size = u64::MAX;
    assert!(Sizes::new(&model(260)).check(&endless, "any").is_ok());
    assert!(Sizes::new(&model(275)).check(&endless, "any").is_err());
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

fn lost(device: &'static Device) -> Outcome {
    let case = builtin("cases/verify/mirror.json", &["/projectile/velocity_m_s=600"]);
    let adapter = device::choose(&adapters(), Some(device.name())).map_err(|e| e.to_string())?;
    let other = Device::open(&adapter).map_err(|e| e.to_string())?;
    let mut simulation = DeviceSimulation::new(&case, &other).map_err(|e| e.to_string())?.with_batch(8);
    while simulation.steps() < 64 {
        simulation.advance(&case);
    }
    assert!(!simulation.finished());
    let steps = simulation.steps();
    other.destroy();
    let mut more = 0;
    while !simulation.finished() {
        simulation.advance(&case);
        more += 1;
        assert!(more < 4, "the run goes on without a device");
    }
    let run = simulation.into_run(1.0);
    let reason = run.lost.as_ref().ok_or("nothing was lost")?;
    assert!(reason.contains(device.name()), "{reason}");
    assert!(run.divergence.is_none() && !run.interrupted && run.steps >= steps);
    // What was there is what an undisturbed run has at that time; the device of the other tests is still there.
    let mut whole = DeviceSimulation::new(&case, device).map_err(|e| e.to_string())?.with_batch(8);
    while whole.steps() < run.steps {
        whole.advance(&case);
    }
    let whole = whole.into_run(1.0);
    assert!(run.history.len() > 10 && run.history == whole.history[..run.history.len()]);
    assert!(run.events == whole.events[..run.events.len()]);
    Ok(())
}

/// A thousand shots of a quarter of a ply fit into 8 GB; a batch is as large as its largest buffer and the memory allow.
fn thousand() -> Result<(), libtest_mimic::Failed> {
    let model = Model::part(&shipped("cases/s720-1ply-155.json", &[])).unwrap();
    assert_eq!(model.planes.copies(), 4);
    let sizes = Sizes::new(&model);
    let all = sizes.with_shots(1000);
    assert!(all.planned() < 8_000_000_000, "{} bytes", all.planned());
    assert_eq!(all.total(), 1000 * sizes.total());
    assert!(all.planned() > all.total(), "what results are fetched through counts too");
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
    let case = builtin("cases/verify/mirror.json", &["/pack/width_mm=2500", "/pack/height_mm=2500"]);
    let device = Device::noop();
    match DeviceSimulation::new(&case, &device) {
        Err(RunError::Device(DeviceError::TooLarge { adapter, buffer, needed, limit, total })) => {
            let elements = (case.pack.rows * case.pack.columns) as u64;
            assert_eq!((adapter.as_str(), buffer, needed, limit), ("noop", "forces", 36 * elements, 128 << 20));
            assert!(total > needed);
        }
        Err(error) => return Err(error.to_string().into()),
        Ok(_) => return Err("accepted".into()),
    }
    // The equations of a rim grow with the square of its length.
    let wide = [
        "/solver/contact_sampling=edges",
        "/projectile/diameter_mm=60",
        "/projectile/offset_mm=[0,0]",
        "/pack/plies=12",
    ];
    let case = builtin("cases/verify/mirror.json", &[&wide[..], &["/pack/width_mm=80", "/pack/height_mm=80"]].concat());
    match DeviceSimulation::new(&case, &device) {
        Err(RunError::Device(DeviceError::TooLarge { buffer: "matrix", .. })) => Ok(()),
        Err(error) => Err(error.to_string().into()),
        Ok(_) => Err("accepted".into()),
    }
}
