//! Contact that has no room for points of the rim, or finds no rest.

use ripstop::gpu::Device;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::status;
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::Stage;

use super::{Outcome, Pair};
use crate::gpu::kernels::scenes::{self, Scene};

/// The counters after a step with another source, and those of the scene as it is.
fn counters(device: &Device, scene: &Scene, find: &str, put: &str) -> Result<[Vec<u32>; 2], String> {
    let run = |put: &str| {
        let source = |kernel: &Kernel| kernel.source().replace(find, put);
        let mut pair = Pair::new(device, scene, &source)?;
        pair.begin();
        let info = pair.gpu.whole_step(scene.state.step, None, 1);
        pair.gpu.run_stages(&info, &[Stage::Nodes, Stage::Projectile]).map_err(|e| e.to_string())?;
        pair.read(BufferId::Status)
    };
    assert!(ripstop::gpu::shader::KERNELS.iter().any(|kernel| kernel.source().contains(find)), "no {find}");
    Ok([run(put)?, run(find)?])
}

/// More points of the rim than there is room for are counted, and none is heeded.
pub(crate) fn crowded(device: &Device) -> Outcome {
    let scene = scenes::struck::rim_scenes().swap_remove(0);
    let [small, enough] = counters(device, &scene, "found > scene.ties", "found > 5u")?;
    if small[status::OVERFLOW_EDGES] <= 5 || enough[status::OVERFLOW_EDGES] != 0 {
        return Err(format!("{} points where there is room for 5", small[status::OVERFLOW_EDGES]));
    }
    if small[status::BAD_STEP] == u32::MAX { Ok(()) } else { Err("numbers go bad without the rim".into()) }
}

/// A set of points that still changes when no more solves are allowed ends the run in that step.
pub(crate) fn restless(device: &Device) -> Outcome {
    let at_nodes =
        scenes::contact_scenes().into_iter().find(|scene| scene.name == "light cylinder, one side of the face");
    for scene in [scenes::struck::rim_scenes().swap_remove(0), at_nodes.ok_or("no such scene")?] {
        let [one, enough] = counters(device, &scene, "const SET_CHANGES: u32 = 40u;", "const SET_CHANGES: u32 = 0u;")?;
        let of = |counters: &[u32]| [counters[status::NOT_CONVERGED], counters[status::BAD_STEP]];
        if of(&enough) != [0, u32::MAX] {
            return Err(format!("{}: {:?} where 40 changes are allowed", scene.name, of(&enough)));
        }
        if of(&one) != [1, scene.state.step as u32] {
            return Err(format!("{}: {:?} where none is", scene.name, of(&one)));
        }
    }
    Ok(())
}
