//! `ripstop v50`: from a case to the velocity at which half of all shots perforate.
//!
//! Thresholds are sought in blocks, realisations of a block in parallel, on a device in rounds of a shot of each. The next shots depend on
//! outcomes alone, never on the order in which shots ended: a campaign that was broken off asks for the same again, and finds the rows
//! that are there.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use serde_json::{Value, json};

use super::batch::{self, Batch, BatchError, BatchOptions, BatchProgress, ShotOrder, in_threads};
use super::fit::{self, FitRow};
use super::interval::Bounds;
use super::threshold::{FoundThreshold, Rungs, Start, middle, threshold};
use super::v50_result::V50Result;
use crate::case::{self, Case};
use crate::output::Folder;
use crate::run::batch::DeviceUse;

/// Names of the table, and of the table of shots on the converged mesh.
const TABLES: [&str; 2] = ["v50.csv", "v50-refined.csv"];
/// Every file that is written.
pub const FILES: &[&str] = &["plan.json", TABLES[0], TABLES[1], "v50.html", "v50.json"];
/// Realisations whose thresholds are sought at a time: first few, for the later ones begin where those ended.
const BLOCKS: [u32; 3] = [2, 6, 8];
/// First step of the first searches, over the width of a rung; later ones step by the scatter of those before.
const FIRST_STEP: f64 = 0.1;
/// Thresholds without which no interval is narrow.
const LEAST: usize = 8;
/// Request of a V50.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct V50Request {
    /// Realisations at most.
    pub count: u32,
    /// Half the width of the interval over V50 at which to stop early.
    pub until_width: Option<f64>,
    /// Width of the bracket of a threshold, over its lower end.
    pub bracket: f64,
    /// Realisations whose threshold is looked for on the converged mesh too, by which V50 is corrected.
    pub refined: u32,
    /// Two-sided confidence of all intervals.
    pub level: f64,
}

/// Fires what is not there yet, estimates, and writes tables, JSON and page.
///
/// # Errors
/// See [`BatchError`]; rows so far stay.
pub fn run(
    case: &Case,
    request: &V50Request,
    options: &BatchOptions<'_>,
    folder: &Folder,
) -> Result<V50Result, BatchError> {
    let parts = json!({
        "bracket": request.bracket, "count": request.count, "until_width": request.until_width, "level": request.level,
        "refined": request.refined,
    });
    batch::begin("v50", case, options, parts, (folder, FILES))?;
    let nominal = without_velocity_scatter(case);
    // Shots that wait for each other have all threads.
    let threads_per_shot = if nominal.varies() { 1 } else { options.threads };
    let options = &BatchOptions { threads_per_shot, ..*options };
    // Without variability all realisations are one.
    let of = if nominal.varies() { request.count } else { 1 };
    let finer = if request.refined > 0 { case::converged(&nominal) } else { None };
    let cases = [Some(nominal), finer].into_iter().flatten();
    let meshes = cases.zip(TABLES).map(|(case, table)| Batch::open(case, options, folder, table));
    let campaign =
        Campaign { meshes: meshes.collect::<Result<_, _>>()?, request, options, of, done: AtomicU32::new(0) };
    let found = campaign.thresholds()?;
    let device = campaign.meshes.iter().map(Batch::device_use).fold(DeviceUse::default(), DeviceUse::with);
    let result = V50Result { device, ..campaign.estimate(&found) };
    let case = &campaign.meshes[0].case;
    let page = result.report(case, request).html(&format!("V50: {}", case.title), "v50.json and v50.csv");
    let mut texts = vec![("v50.json", format!("{:#}\n", result.json(case, request, options.seed))), ("v50.html", page)];
    texts.extend(TABLES.into_iter().zip(campaign.meshes.iter().map(|mesh| mesh.table().text(u32::MAX))));
    folder.put(&texts, &[])?;
    campaign.meshes.into_iter().try_for_each(Batch::close)?;
    Ok(result)
}

/// Case whose impact velocity is the one asked for: its scatter moves shots, not the limit.
fn without_velocity_scatter(case: &Case) -> Case {
    let mut case = case.clone();
    if let Some(variability) = case.as_run.get_mut("variability").and_then(Value::as_object_mut) {
        variability.remove("velocity");
    }
    if let Some(variability) = &mut case.variability {
        variability.velocity = None;
    }
    case
}

struct Campaign<'a> {
    /// Shots on the mesh of the case, and on the converged one, where that is another and was asked for.
    meshes: Vec<Batch<'a>>,
    request: &'a V50Request,
    options: &'a BatchOptions<'a>,
    /// Realisations at most, and those that are done.
    of: u32,
    done: AtomicU32,
}

impl Campaign<'_> {
    fn estimate(&self, found: &[FoundThreshold]) -> V50Result {
        let shots: Vec<Option<FitRow>> = self.meshes[0].table().rows(u32::MAX).map(|row| row.fit_row()).collect();
        let rows: Vec<FitRow> = shots.iter().copied().flatten().collect();
        let result = V50Result {
            refined_shots: self.meshes.get(1).map_or(0, |finer| finer.table().rows(u32::MAX).count()),
            shots: shots.len(),
            failed: shots.len() - rows.len(),
            ..V50Result::default()
        };
        result.with_thresholds(found, fit::passed(&rows), &self.meshes[0].case, self.request)
    }

    fn report_progress(&self, v50: Option<(f64, Bounds)>) {
        (self.options.progress)(BatchProgress { done: self.done.load(Ordering::Relaxed), of: self.of, v50 });
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
            self.report_progress(result.v50.map(|v50| (v50, result.bounds)));
            let is_narrow = |width: f64| result.bounds.is_narrow(result.v50, width);
            if found.len() >= LEAST && self.request.until_width.is_some_and(is_narrow) {
                break;
            }
        }
        Ok(found)
    }

    /// Start of the next searches: the middle of the thresholds so far, and steps of their scatter.
    fn start(&self, found: &[FoundThreshold]) -> Start {
        let width = self.request.bracket;
        let brackets = found.iter().filter_map(|found| found.bracket.as_ref().ok());
        let mut middles: Vec<f64> = brackets.copied().map(middle).collect();
        middles.sort_by(f64::total_cmp);
        if middles.is_empty() {
            let velocity = self.meshes[0].case.projectile.as_ref().map_or(100.0, |projectile| projectile.velocity);
            return Start { velocity, step: (FIRST_STEP / width).round() as i32 };
        }
        let velocity = middles[middles.len() / 2];
        let mean = middles.iter().sum::<f64>() / middles.len() as f64;
        let square = middles.iter().map(|middle| (middle - mean).powi(2)).sum::<f64>() / middles.len() as f64;
        Start { velocity, step: (square.sqrt() / (width * mean)).round() as i32 }
    }

    /// Thresholds of some realisations: each on a thread, or all together on a device.
    fn block(&self, block: Range<u32>, start: Start) -> Result<Vec<FoundThreshold>, BatchError> {
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
        let outcome = |mesh: usize, order| self.meshes[mesh].table().find(order).map(|row| row.shot());
        let search = |realisation: &u32| {
            let is_refined = *realisation < self.request.refined && self.meshes.len() > 1;
            threshold(*realisation, rungs, start, is_refined, outcome)
        };
        loop {
            let found: Vec<_> = realisations.iter().map(search).collect();
            let wanted: Vec<(usize, ShotOrder)> =
                found.iter().filter_map(|found| found.as_ref().err().copied()).collect();
            if wanted.is_empty() {
                self.done.fetch_add(realisations.len() as u32, Ordering::Relaxed);
                return Ok(found.into_iter().flatten().collect());
            }
            if given_up.load(Ordering::Relaxed) {
                return Err(BatchError::Interrupted);
            }
            for (number, mesh) in self.meshes.iter().enumerate() {
                let orders = wanted.iter().filter(|(mesh, _)| *mesh == number).map(|(_, order)| *order);
                mesh.fire(&orders.collect::<Vec<_>>(), 1, &|_| self.report_progress(None))?;
            }
        }
    }
}
