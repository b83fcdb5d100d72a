//! Contact that has no room for points of the rim, or finds no rest.

use ripstop::gpu::Device;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{TOUCH_WORDS, status};
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::Stage;

use super::{Outcome, Pair};
use crate::gpu::kernels::scenes::{self, Scene};

/// Words of `Touch` in `shaders/contact_points.wgsl`: normal impulse, and in the first one how many there are.
const IMPULSE_WORD: usize = 11;
const END_WORD: usize = 21;

/// Counters and touches after a step with another source, and with the kernels as they are.
fn after_step(device: &Device, scene: &Scene, [find, put]: [&str; 2]) -> Result<[[Vec<u32>; 2]; 2], String> {
    let run = |put: &str| -> Result<_, String> {
        let source = |kernel: &Kernel| kernel.source().replace(find, put);
        let mut pair = Pair::new(device, scene, &source)?;
        pair.begin();
        let info = pair.gpu.whole_step(scene.state.step, None, 1);
        pair.gpu.run_stages(&info, &[Stage::Nodes, Stage::Projectile]).map_err(|e| e.to_string())?;
        Ok([pair.read(BufferId::Status)?, pair.read(BufferId::Touches)?])
    };
    assert!(ripstop::gpu::shader::KERNELS.iter().any(|kernel| kernel.source().contains(find)), "no {find}");
    Ok([run(put)?, run(find)?])
}

/// More points of the rim than there is room for are counted, and none is heeded.
pub(crate) fn crowded(device: &Device) -> Outcome {
    let scene = scenes::struck::rim_scenes().swap_remove(0);
    let [[small, _], [enough, _]] = after_step(device, &scene, ["found > scene.constraints", "found > 5u"])?;
    if small[status::OVERFLOW_EDGES] <= 5 || enough[status::OVERFLOW_EDGES] != 0 {
        return Err(format!("{} points where there is room for 5", small[status::OVERFLOW_EDGES]));
    }
    if small[status::BAD_STEP] == u32::MAX { Ok(()) } else { Err("numbers go bad without the rim".into()) }
}

/// Points that pull when no more solves are allowed are let go: contact never pulls, and the run goes on.
pub(crate) fn restless(device: &Device) -> Outcome {
    let at_nodes =
        scenes::contact_scenes().into_iter().find(|scene| scene.name == "light cylinder, one side of the face");
    for scene in [scenes::struck::rim_scenes().swap_remove(0), at_nodes.ok_or("no such scene")?] {
        let replace = ["const SET_CHANGES: u32 = 40u;", "const SET_CHANGES: u32 = 0u;"];
        let [[counters, touches], [_, settled]] = after_step(device, &scene, replace)?;
        let [restless, settled] = [touches, settled].map(|touches| normal_impulses(&touches));
        if counters[status::BAD_STEP] != u32::MAX || restless.iter().any(|impulse| *impulse < 0.0) {
            return Err(format!("{}: {restless:?} where no change is allowed", scene.name));
        }
        if restless == settled {
            return Err(format!("{}: it needs no change, and shows nothing", scene.name));
        }
    }
    Ok(())
}

/// Normal impulses of all touches [N·s].
fn normal_impulses(touches: &[u32]) -> Vec<f32> {
    let count = touches[END_WORD] as usize;
    touches
        .chunks_exact(TOUCH_WORDS as usize)
        .skip(1)
        .take(count)
        .map(|touch| f32::from_bits(touch[IMPULSE_WORD]))
        .collect()
}
