//! The shots of a V50: thresholds in blocks, realisations of a block in parallel, on a device in rounds of a shot of each.
//!
//! What is asked next depends on outcomes alone, never on the order in which shots ended: a campaign that was broken off asks the same
//! again, and finds the rows that are there.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::json;

use super::estimate::{V50Result, estimate};
use super::realisation::{FoundThreshold, RealisationSearch, Start};
use super::threshold::{Rungs, middle};
use super::{FILES, REFINED_TABLE, TABLE, V50Request, html, json};
use crate::case::{self, Case};
use crate::output::Folder;
use crate::run::batch::DeviceUse;
use crate::study::batch::fire::shoot;
use crate::study::batch::{BatchError, BatchOptions, BatchPlan, DeviceRunner, ShotLog, ShotOrder};
use crate::study::outcomes::Shot;
use crate::study::shots::drawn_columns;
use crate::study::threads::in_threads;

/// Realisations whose thresholds are sought at a time: first few, for the later ones begin where those ended.
const BLOCKS: [u32; 3] = [2, 6, 8];
/// First step of the first searches, over the width of a rung; later ones step by the scatter of those before.
const FIRST_STEP: f64 = 0.1;
/// Velocity at which the first searches begin in a case without a projectile [m/s].
const FALLBACK_VELOCITY: f64 = 100.0;
/// Thresholds without which no interval is narrow.
const LEAST: usize = 8;
/// What a campaign is at.
#[derive(Clone, Copy, Debug)]
pub struct V50Progress<'a> {
    /// Realisations that are done.
    pub done: u32,
    /// Wanted at most.
    pub of: u32,
    /// The last estimate.
    pub last: Option<&'a V50Result>,
}

/// The case whose impact velocity is the one asked for: its scatter moves shots, not the limit.
fn nominal(case: &Case) -> Case {
    let mut case = case.clone();
    if let Some(variability) = case.as_run.get_mut("variability").and_then(serde_json::Value::as_object_mut) {
        variability.remove("velocity");
    }
    if let Some(variability) = &mut case.variability {
        variability.velocity = None;
    }
    case
}

fn plan(case: &Case, request: &V50Request, options: &BatchOptions<'_>) -> BatchPlan {
    let parts = json!({
        "bracket": request.bracket, "count": request.count, "until_width": request.until_width, "level": request.level,
        "refined": request.refined,
    });
    BatchPlan::new("v50", case, options, parts)
}

/// Fires what is not there yet, estimates, and writes table, JSON and page.
///
/// # Errors
/// See [`BatchError`]; rows so far stay.
pub fn run(
    case: &Case,
    request: &V50Request,
    options: &BatchOptions<'_>,
    folder: &Folder,
    resume: bool,
    progress: &mut (dyn FnMut(V50Progress<'_>) + Send),
) -> Result<V50Result, BatchError> {
    let plan = plan(case, request, options);
    plan.begin(folder, FILES, resume)?;
    let nominal = nominal(case);
    let orders = || (0..request.count).map(|shot| ShotOrder { shot, velocity: None });
    let open = |case: Case, table: &'static str| {
        let drawn = drawn_columns(&case, options.seed, orders());
        let device = DeviceRunner::new(options).map(Mutex::new);
        ShotLog::open(folder, table, drawn, resume).map(|log| MeshShots { case, log: Mutex::new(log), device })
    };
    let finer = if request.refined > 0 { case::converged(&nominal) } else { None };
    // Shots that wait for each other have all threads.
    let threads_per_shot = if nominal.varies() { 1 } else { options.threads };
    let options = &BatchOptions { threads_per_shot, ..*options };
    // Without variability all realisations are one.
    let of = if nominal.varies() { request.count } else { 1 };
    let (progress, done) = (Mutex::new(progress), AtomicU32::new(0));
    let cases = [Some((nominal, TABLE)), finer.map(|case| (case, REFINED_TABLE))];
    let meshes = cases.into_iter().flatten().map(|(case, table)| open(case, table)).collect::<Result<_, _>>()?;
    let campaign = Campaign { meshes, request, options, of, done, progress };
    let found = campaign.thresholds()?;
    let used = campaign.meshes.iter().map(MeshShots::device_use).fold(DeviceUse::default(), DeviceUse::with);
    let result = V50Result { device: used, ..campaign.estimate(&found) };
    let case = &campaign.meshes[0].case;
    let tables: Vec<String> = campaign.meshes.iter().map(|mesh| locked(&mesh.log).table(|_| true)).collect();
    let mut texts = vec![
        ("v50.json", format!("{:#}\n", json(case, request, options.seed, &result))),
        ("v50.html", html(case, request, options.seed, &result)),
    ];
    texts.extend([TABLE, REFINED_TABLE].into_iter().zip(tables));
    folder.put(&texts, &[])?;
    let mut logs = campaign.meshes.into_iter().map(|mesh| mesh.log.into_inner());
    logs.try_for_each(|log| log.unwrap_or_else(PoisonError::into_inner).close())?;
    Ok(result)
}

/// The case on one mesh, and its shots.
struct MeshShots<'a> {
    case: Case,
    log: Mutex<ShotLog>,
    /// What fires them; `None`: the processor.
    device: Option<Mutex<DeviceRunner<'a>>>,
}

fn locked<T>(inside: &Mutex<T>) -> MutexGuard<'_, T> {
    inside.lock().unwrap_or_else(PoisonError::into_inner)
}

impl MeshShots<'_> {
    /// The outcome of a shot that has a row, or why it has none.
    fn outcome(&self, order: ShotOrder) -> Option<Result<Shot, String>> {
        locked(&self.log).find(order).map(|row| row.as_shot().ok_or_else(|| row.reason.clone()))
    }

    /// Fires shots that have no row yet, on a device those together that go together.
    fn fire(
        &self,
        orders: &[ShotOrder],
        options: &BatchOptions<'_>,
        given_up: &AtomicBool,
        fired: &dyn Fn(),
    ) -> Result<(), BatchError> {
        let add = |row| {
            locked(&self.log).add(row)?;
            fired();
            Ok(())
        };
        if let Some(device) = &self.device {
            let shots = orders.iter().map(|order| (&self.case, *order));
            return locked(device).fire(shots, &mut |_, row| add(row));
        }
        orders
            .iter()
            .try_for_each(|order| add(shoot(&self.case, *order, options, given_up).ok_or(BatchError::Interrupted)?))
    }

    fn device_use(&self) -> DeviceUse {
        self.device.as_ref().map(|device| locked(device).device_use()).unwrap_or_default()
    }
}

struct Campaign<'a, 'p> {
    /// Of the case, and the converged one, where that is another and was asked for.
    meshes: Vec<MeshShots<'a>>,
    request: &'a V50Request,
    options: &'a BatchOptions<'a>,
    /// Realisations at most, and those that are done.
    of: u32,
    done: AtomicU32,
    progress: Mutex<&'p mut (dyn FnMut(V50Progress<'_>) + Send)>,
}

impl Campaign<'_, '_> {
    fn estimate(&self, found: &[FoundThreshold]) -> V50Result {
        let refined_shots = self.meshes.get(1).map_or(0, |finer| locked(&finer.log).rows().count());
        let mesh = &self.meshes[0];
        estimate(&mesh.case, self.request, found, locked(&mesh.log).rows(), refined_shots)
    }

    /// Tells how far the campaign is.
    fn tell(&self, last: Option<&V50Result>) {
        let mut tell = locked(&self.progress);
        tell(V50Progress { done: self.done.load(Ordering::Relaxed), of: self.of, last });
    }

    /// Whether so many thresholds have made the interval narrow enough.
    fn is_narrow(&self, count: usize, result: &V50Result) -> bool {
        count >= LEAST && self.request.until_width.is_some_and(|width| result.is_within(width))
    }

    fn thresholds(&self) -> Result<Vec<FoundThreshold>, BatchError> {
        let mut found: Vec<FoundThreshold> = Vec::new();
        let mut blocks = BLOCKS.iter();
        let mut size = BLOCKS[0];
        while (found.len() as u32) < self.of {
            size = blocks.next().copied().unwrap_or(size);
            let first = found.len() as u32;
            found.extend(self.block(first..(first + size).min(self.of), self.start(&found))?);
            let result = self.estimate(&found);
            self.tell(Some(&result));
            if self.is_narrow(found.len(), &result) {
                break;
            }
        }
        Ok(found)
    }

    /// Where the next searches begin: in the middle of the thresholds so far, in steps of their scatter.
    fn start(&self, found: &[FoundThreshold]) -> Start {
        let rungs = Rungs { width: self.request.bracket };
        let mut middles: Vec<f64> =
            found.iter().filter_map(|found| found.bracket.as_ref().ok()).copied().map(middle).collect();
        middles.sort_by(f64::total_cmp);
        if middles.is_empty() {
            let projectile = self.meshes[0].case.projectile.as_ref();
            let velocity = projectile.map_or(FALLBACK_VELOCITY, |projectile| projectile.velocity);
            return Start { velocity, step: (FIRST_STEP / rungs.width).round() as i32 };
        }
        let velocity = middles[middles.len() / 2];
        let mean = middles.iter().sum::<f64>() / middles.len() as f64;
        let square = middles.iter().map(|middle| (middle - mean).powi(2)).sum::<f64>() / middles.len() as f64;
        Start { velocity, step: (square.sqrt() / (rungs.width * mean)).round() as i32 }
    }

    /// Thresholds of some realisations: each on a thread, or all together on a device.
    fn block(&self, block: std::ops::Range<u32>, start: Start) -> Result<Vec<FoundThreshold>, BatchError> {
        let realisations: Vec<u32> = block.collect();
        let at_a_time = if self.options.device.is_some() { realisations.len() } else { 1 };
        let groups: Vec<&[u32]> = realisations.chunks(at_a_time).collect();
        let found = in_threads(self.options.threads, 0..groups.len(), |group, given_up| {
            self.thresholds_of(groups[group], start, given_up)
        })?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Fires what the searches for these thresholds want, round after round, until none wants any more.
    fn thresholds_of(
        &self,
        realisations: &[u32],
        start: Start,
        given_up: &AtomicBool,
    ) -> Result<Vec<FoundThreshold>, BatchError> {
        let rungs = Rungs { width: self.request.bracket };
        let meshes = |realisation| if realisation < self.request.refined { self.meshes.len() } else { 1 };
        let search = |realisation: &u32| RealisationSearch::new(*realisation, rungs, start, meshes(*realisation));
        let mut searches: Vec<RealisationSearch> = realisations.iter().map(search).collect();
        let mut wanted = vec![Vec::new(); self.meshes.len()];
        loop {
            for search in &mut searches {
                while let Some((number, order)) = search.wanted() {
                    let Some(outcome) = self.meshes[number].outcome(order) else {
                        wanted[number].push(order);
                        break;
                    };
                    search.see(outcome);
                }
            }
            if wanted.iter().all(Vec::is_empty) {
                self.done.fetch_add(realisations.len() as u32, Ordering::Relaxed);
                return Ok(searches.into_iter().map(RealisationSearch::found).collect());
            }
            for (mesh, orders) in self.meshes.iter().zip(&mut wanted) {
                mesh.fire(orders, self.options, given_up, &|| self.tell(None))?;
                orders.clear();
            }
        }
    }
}
