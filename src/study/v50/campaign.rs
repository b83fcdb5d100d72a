//! The shots of a V50: thresholds in blocks, realisations of a block in parallel; or a design, shot after shot.
//!
//! What is asked next depends on outcomes alone, never on the order in which shots ended: a campaign that was broken off asks the same
//! again, and finds the rows that are there.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use serde_json::json;

use super::estimate::{V50Result, estimate};
use super::threshold::{FurtherShots, Rungs, ThresholdSearch, Wanted, middle};
use super::{Design, FILES, REFINED_TABLE, TABLE, V50Request, html, json};
use crate::case::{self, Case};
use crate::output::Folder;
use crate::study::batch::fire::shoot;
use crate::study::batch::{BatchError, BatchOptions, BatchPlan, ShotLog, ShotOrder};
use crate::study::designs::{Langlie, Neyer, ThreePod, UpDown};
use crate::study::outcomes::Shot;
use crate::study::shots::drawn_columns;
use crate::study::threads::in_threads;

/// Realisations whose thresholds are sought at a time: first few, for the later ones begin where those ended.
const BLOCKS: [u32; 3] = [2, 6, 8];
/// First step of the first searches, over the width of a rung; later ones step by the scatter of those before.
const FIRST_STEP: f64 = 0.1;
/// Thresholds without which no interval is narrow.
const LEAST: usize = 8;
/// First step of a search on the finer mesh, over the threshold on the coarser one.
const REFINED_STEP: f64 = 0.02;
/// Realisations that are shot further above their thresholds too, for the residual velocities, and where.
const FURTHER: (u32, &[f64]) = (8, &[1.15, 1.4]);

/// What a campaign is at.
#[derive(Clone, Copy, Debug)]
pub struct V50Progress<'a> {
    /// Realisations, or shots of a design, that are done.
    pub done: u32,
    /// Wanted at most.
    pub of: u32,
    /// The last estimate.
    pub last: Option<&'a V50Result>,
}

/// What is known of the threshold of a realisation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FoundThreshold {
    /// Highest stop below it and lowest perforation above it [m/s]; or why there is none.
    pub(super) bracket: Result<[f64; 2], String>,
    pub(super) monotone: bool,
    /// The bracket on the finer mesh [m/s], where it was looked for and found.
    pub(super) refined: Option<[f64; 2]>,
}

/// The case whose impact velocity is the one asked for: its scatter moves shots, not the limit.
fn nominal(case: &Case, design: Design) -> Case {
    let mut case = case.clone();
    if design == Design::Thresholds {
        if let Some(variability) = case.as_run.get_mut("variability").and_then(serde_json::Value::as_object_mut) {
            variability.remove("velocity");
        }
        if let Some(variability) = &mut case.variability {
            variability.velocity = None;
        }
    }
    case
}

fn plan(case: &Case, request: &V50Request, options: &BatchOptions<'_>) -> BatchPlan {
    let design = match request.design {
        Design::Thresholds => json!({ "bracket": request.bracket }),
        _ => json!({ "velocity_m_s": request.velocity, "sigma_m_s": request.sigma }),
    };
    let parts = json!({
        "design": request.design.word(), "parameters": design, "count": request.count, "until_width": request.until_width,
        "level": request.fit.level, "precision": options.precision.name(), "refined": request.refined,
    });
    BatchPlan::new("v50", case, options.seed, parts)
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
    let nominal = nominal(case, request.design);
    let orders = || (0..request.count).map(|shot| ShotOrder { shot, velocity: Some(request.velocity[0]) });
    let open = |case: Case, table: &'static str| {
        let drawn = drawn_columns(&case, options.seed, orders());
        ShotLog::open(folder, table, drawn, resume).map(|log| MeshShots { case, log: Mutex::new(log) })
    };
    let is_refined = request.design == Design::Thresholds && request.refined > 0;
    let finer = if is_refined { case::converged(&nominal) } else { None };
    // Shots that wait for each other have all threads.
    let one_by_one = request.design != Design::Thresholds || !nominal.varies();
    let threads_per_shot = if one_by_one { options.threads } else { 1 };
    let options = &BatchOptions { threads_per_shot, ..*options };
    let finer = finer.map(|case| open(case, REFINED_TABLE)).transpose()?;
    // Without variability all realisations are one.
    let of = if request.design == Design::Thresholds && !nominal.varies() { 1 } else { request.count };
    let (mesh, progress, done) = (open(nominal, TABLE)?, Mutex::new(progress), AtomicU32::new(0));
    let campaign = Campaign { mesh, finer, request, options, of, done, progress };
    let found = match request.design {
        Design::Thresholds => campaign.thresholds()?,
        _ => campaign.design()?,
    };
    let result = campaign.estimate(&found);
    let Campaign { mesh: MeshShots { case, log }, finer, .. } = campaign;
    let case = &case;
    let log = log.into_inner().unwrap_or_else(PoisonError::into_inner);
    let finer = finer.map(|shots| shots.log.into_inner().unwrap_or_else(PoisonError::into_inner));
    let table = log.table(|_| true);
    #[cfg(feature = "parquet")]
    crate::output::parquet::put(folder, super::PARQUET, &table)?;
    let mut texts = vec![
        ("v50.json", format!("{:#}\n", json(case, request, options.seed, &result))),
        ("v50.html", html(case, request, options.seed, &result)),
        (TABLE, table),
    ];
    texts.extend(finer.as_ref().map(|log| (REFINED_TABLE, log.table(|_| true))));
    folder.put(&texts, &[])?;
    log.close()?;
    finer.map_or(Ok(()), ShotLog::close)?;
    Ok(result)
}

/// The case on one mesh, and its shots.
struct MeshShots {
    case: Case,
    log: Mutex<ShotLog>,
}

impl MeshShots {
    fn rows(&self) -> std::sync::MutexGuard<'_, ShotLog> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The outcome of a shot: of its row, or of a shot that is fired now. `None`: it has none, and why.
    fn outcome(
        &self,
        order: ShotOrder,
        options: &BatchOptions<'_>,
        given_up: &AtomicBool,
    ) -> Result<Result<Shot, String>, BatchError> {
        let known = self.rows().find(order).cloned();
        let row = match known {
            Some(row) => row,
            None => {
                let row = shoot(&self.case, order, options, given_up).ok_or(BatchError::Interrupted)?;
                self.rows().add(row.clone())?;
                row
            }
        };
        Ok(row.as_shot().ok_or(row.reason))
    }
}

struct Campaign<'a, 'p> {
    mesh: MeshShots,
    /// On the converged mesh, where that is another one.
    finer: Option<MeshShots>,
    request: &'a V50Request,
    options: &'a BatchOptions<'a>,
    /// Realisations, or shots of a design, at most, and those that are done.
    of: u32,
    done: AtomicU32,
    progress: Mutex<&'p mut (dyn FnMut(V50Progress<'_>) + Send)>,
}

/// Where a search begins [m/s] and its first step, in rungs.
#[derive(Clone, Copy)]
struct Start {
    velocity: f64,
    step: i32,
}

impl Campaign<'_, '_> {
    fn estimate(&self, found: &[FoundThreshold]) -> V50Result {
        let refined_shots = self.finer.as_ref().map_or(0, |finer| finer.rows().rows().count());
        estimate(&self.mesh.case, self.request, found, self.mesh.rows().rows(), refined_shots)
    }

    /// Tells how far the campaign is.
    fn tell(&self, last: Option<&V50Result>) {
        let mut tell = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        tell(V50Progress { done: self.done.load(Ordering::Relaxed), of: self.of, last });
    }

    /// Whether so many thresholds or shots have made the interval narrow enough.
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
            let velocity =
                self.mesh.case.projectile.as_ref().map_or(self.request.velocity[0], |projectile| projectile.velocity);
            return Start { velocity, step: (FIRST_STEP / rungs.width).round() as i32 };
        }
        let velocity = middles[middles.len() / 2];
        let mean = middles.iter().sum::<f64>() / middles.len() as f64;
        let square = middles.iter().map(|middle| (middle - mean).powi(2)).sum::<f64>() / middles.len() as f64;
        Start { velocity, step: (square.sqrt() / (rungs.width * mean)).round() as i32 }
    }

    /// Thresholds of some realisations, each on a thread.
    fn block(&self, block: std::ops::Range<u32>, start: Start) -> Result<Vec<FoundThreshold>, BatchError> {
        in_threads(self.options.threads, block.start as usize..block.end as usize, |number, given_up| {
            let found = self.search(number as u32, start, given_up)?;
            self.done.fetch_add(1, Ordering::Relaxed);
            Ok(found)
        })
    }

    fn search(&self, realisation: u32, start: Start, given_up: &AtomicBool) -> Result<FoundThreshold, BatchError> {
        let beyond = if realisation < FURTHER.0 { FURTHER.1 } else { &[] };
        let further = FurtherShots { beside: true, beyond };
        let found = self.search_on(&self.mesh, realisation, start, further, given_up)?;
        let (Ok(bracket), Some(finer)) = (&found.bracket, &self.finer) else { return Ok(found) };
        if realisation >= self.request.refined {
            return Ok(found);
        }
        let start = Start { velocity: middle(*bracket), step: (REFINED_STEP / self.request.bracket).round() as i32 };
        let refined = self.search_on(finer, realisation, start, FurtherShots::NONE, given_up)?.bracket.ok();
        Ok(FoundThreshold { refined, ..found })
    }

    /// The threshold of a realisation on one mesh.
    fn search_on(
        &self,
        mesh: &MeshShots,
        realisation: u32,
        start: Start,
        further: FurtherShots,
        given_up: &AtomicBool,
    ) -> Result<FoundThreshold, BatchError> {
        let none = |reason| Ok(FoundThreshold { bracket: Err(reason), monotone: true, refined: None });
        let rungs = Rungs { width: self.request.bracket };
        let mut search = ThresholdSearch::new(rungs, start.velocity, start.step, further);
        loop {
            match search.wanted() {
                Wanted::Shot(rung) => {
                    let order = ShotOrder { shot: realisation, velocity: Some(rungs.velocity(rung)) };
                    match mesh.outcome(order, self.options, given_up)? {
                        Ok(shot) => search.see(rung, shot.perforated),
                        Err(reason) => return none(reason),
                    }
                    self.tell(None);
                }
                Wanted::Nothing => break,
                Wanted::NoThreshold => return none("no velocity from 2 to 4900 m/s changes the outcome".to_owned()),
            }
        }
        let bracket = search.bracket().ok_or_else(|| "no bracket".to_owned());
        Ok(FoundThreshold { bracket, monotone: search.is_monotone(), refined: None })
    }

    /// Shots of a design, one after the other. A shot without an outcome tells a design nothing.
    fn design(&self) -> Result<Vec<FoundThreshold>, BatchError> {
        let given_up = AtomicBool::new(false);
        let mut shots: Vec<Shot> = Vec::new();
        for shot in 0..self.of {
            let order = ShotOrder { shot, velocity: Some(next_velocity(self.request, &shots)) };
            shots.extend(self.mesh.outcome(order, self.options, &given_up)?.ok());
            self.done.fetch_add(1, Ordering::Relaxed);
            let result = self.estimate(&[]);
            self.tell(Some(&result));
            if self.is_narrow(shots.len(), &result) {
                break;
            }
        }
        Ok(Vec::new())
    }
}

/// Velocity that a design wants next, of those that can be shot [m/s].
fn next_velocity(request: &V50Request, shots: &[Shot]) -> f64 {
    let V50Request { velocity: [low, high], sigma, .. } = *request;
    let next = match request.design {
        Design::Langlie => Langlie { low, high }.next(shots),
        Design::Neyer => Neyer { low, high, sigma }.next(shots),
        Design::ThreePod => ThreePod { low, high, sigma, d_optimal: usize::MAX, quantile: None }.next(shots),
        Design::UpDown | Design::Thresholds => UpDown { start: 0.5 * (low + high), step: sigma }.next(shots),
    };
    next.clamp(1.0, 4999.0)
}
