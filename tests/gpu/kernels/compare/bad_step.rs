//! A number that is not finite stops everything after its step, on the spot.

use ripstop::gpu::Device;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{StepInfo, status};
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::Stage;
use ripstop::solver::node_update::field as node;

use super::{Outcome, Pair};
use crate::gpu::kernels::scenes::{self, Scene};

pub(crate) fn bad_step(device: &Device) -> Outcome {
    stops(device, &scenes::struck::pack_scenes()[0])?;
    let rim = scenes::struck::rim_scenes().into_iter().find(|scene| scene.name.contains("on turned plies"));
    stops(device, &rim.ok_or("no such scene")?)
}

fn stops(device: &Device, scene: &Scene) -> Outcome {
    let mut pair = Pair::new(device, scene, &Kernel::source)?;
    let mut spoilt = scene.state.clone();
    spoilt.nodes.set(3, node::VELOCITY + 1, 2, f32::NAN);
    pair.gpu.upload(&scene.model, &spoilt);
    let index = scene.state.step;
    let whole = |index| StepInfo { index, ..pair.gpu.whole_step(0, None, 1) };
    let infos = [index, index + 1].map(whole);
    let info = |at: u64| infos[(at - index) as usize];
    let all = [Stage::Elements, Stage::Nodes, Stage::Plies, Stage::Projectile];
    pair.gpu.run_stages(&info(index), &all).map_err(|e| e.to_string())?;
    let everything = |pair: &Pair<'_>| BufferId::ALL.map(|name| pair.read(name));
    if u64::from(pair.read(BufferId::Status)?[status::BAD_STEP]) != index {
        return Err("a velocity that is no number goes unnoticed".into());
    }
    let before = everything(&pair);
    pair.gpu.run_stages(&info(index + 1), &all).map_err(|e| e.to_string())?;
    if everything(&pair) == before { Ok(()) } else { Err("the steps after a bad one change something".into()) }
}
