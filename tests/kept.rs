//! Scenes for checkpoints, and all that a run of them gives.

use ripstop::case::Case;
use ripstop::output;
use ripstop::simulation::Run;
use serde_json::Value;

use crate::scene::builtin;

/// 24 × 16 elements struck off centre and aslant, with failures, friction, rotation, profiles on and between samples.
pub(crate) fn ply() -> Case {
    let sets = ["/pack/width_mm=30.48", "/pack/height_mm=20.32", "/projectile/velocity_m_s=400"];
    let times = ["/solver/end_time_us=36", "/output/profile_times_us=[5,11.03,30]", "/output/history_interval_us=0.7"];
    builtin("cases/verify/mirror.json", &[&sets[..], &times, &["/expect=[]"]].concat())
}

/// Three such plies, one of them turned, that touch and rub.
pub(crate) fn pack() -> Case {
    let layup = r#"/pack/layup=[{"plies":1},{"plies":1,"orientation_deg":30},{"plies":1}]"#;
    let sets = ["/pack/width_mm=25.4", "/pack/height_mm=22.86", "/projectile/velocity_m_s=500", layup];
    let times = ["/solver/end_time_us=26", "/output/history_interval_us=0.7"];
    builtin("cases/verify/mirror.json", &[&sets[..], &times, &["/expect=[]"]].concat())
}

/// Two plies struck in the middle, of which a quarter is computed; the run ends with its outcome.
pub(crate) fn quarter() -> Case {
    let size = ["/pack/width_mm=25.4", "/pack/height_mm=25.4", "/pack/plies=2", "/expect=[]", "/solver/end_time_us=80"];
    let shot = ["/projectile/length_mm=5", "/projectile/mass_g=0.3", "/projectile/velocity_m_s=60"];
    let profile = "/output/profile_times_us=[20]";
    builtin("cases/s720-1ply-155.json", &[&size[..], &shot, &[profile]].concat())
}

/// Everything a run computed, every digit.
pub(crate) fn result(case: &Case, run: &Run) -> Vec<String> {
    let Run { history, events, profiles, ply_history, .. } = run;
    let rows = history.iter().map(|row| format!("{row:?}"));
    let events = events.iter().map(|event| format!("{event:?}"));
    let profiles = profiles.iter().map(|profile| format!("{profile:?}"));
    let plies = ply_history.iter().map(|ply| format!("{ply:?}"));
    let summary = without_costs(output::summary(case, run, 0.0));
    rows.chain(events).chain(profiles).chain(plies).chain([summary.to_string()]).collect()
}

/// A summary without what the run cost.
pub(crate) fn without_costs(mut summary: Value) -> Value {
    for cost in ["loop_s", "host_s", "wall_s", "element_steps_per_s", "threads", "profile"] {
        summary.as_object_mut().unwrap().remove(cost).unwrap_or_else(|| panic!("{cost}"));
    }
    summary
}
