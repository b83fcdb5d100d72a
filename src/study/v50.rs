//! `ripstop v50`: from a case to the velocity at which half of all shots perforate.
//!
//! A threshold is the velocity at which one realisation (same fabric, same hit) turns from stopped to perforated. Velocities lie on a ladder
//! whose rungs are a given part apart, so that a threshold does not depend on where its search began. The search goes up or down in steps
//! that double until it has both outcomes, then halves. Two shots beside the bracket check that the outcome turns once only. The search on
//! a finer mesh begins where that on the mesh of the case ended. A search is replayed from its begin whenever another outcome is known; the
//! first one that is not is what it wants next.
//!
//! Thresholds are sought in blocks, realisations of a block in parallel, on a device in rounds of a shot of each. The next shots depend on
//! outcomes alone, never on the order in which shots ended: a campaign that was broken off asks for the same again, and finds the rows
//! that are there.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use serde::Serialize;
use serde_json::{Value, json};

use super::batch::{self, Batch, BatchError, BatchOptions, ShotOrder, in_threads};
use super::fit::{self, FitRow};
use super::v50_result::V50Result;
use crate::case::{self, Case};
use crate::output::Folder;

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
/// Rungs from the bracket at which the outcome is checked again.
const BESIDE: i32 = 3;
/// Velocities that are searched [m/s].
const SEARCHED: [f64; 2] = [2.0, 4900.0];
/// First step of a search on the finer mesh, over the threshold on the coarser one.
const REFINED_STEP: f64 = 0.02;
/// Realisations that are shot further above their thresholds too, for the residual velocities, and where, over the threshold.
const FURTHER: (u32, &[f64]) = (8, &[1.15, 1.4]);

/// Velocities that are tried: powers of 1 + width, rounded to mm/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rungs {
    /// Distance of neighbours over the lower one [-].
    pub width: f64,
}

impl Rungs {
    /// Velocity of a rung [m/s].
    pub fn velocity(&self, rung: i32) -> f64 {
        ((1.0 + self.width).powi(rung) * 1e3).round() / 1e3
    }

    /// Rung nearest to a velocity [m/s].
    pub fn nearest(&self, velocity: f64) -> i32 {
        (velocity.ln() / self.width.ln_1p()).round() as i32
    }
}

/// Threshold in a bracket [m/s]: its geometric mean, for rungs are powers.
pub fn middle([low, high]: [f64; 2]) -> f64 {
    (low * high).sqrt()
}

/// End of a search before its threshold is known.
#[derive(Clone, Debug, PartialEq)]
pub enum SearchEnd {
    /// Shot whose outcome is not known yet: number of the mesh, and order.
    Wanted(usize, ShotOrder),
    /// Reason why there is no threshold.
    Failed(String),
}

/// Rungs of the highest stop and the lowest perforation around a threshold, by a search from a rung on in steps of at least `step`.
///
/// # Errors
/// The first error of `passes`, or that no velocity changes the outcome.
pub fn bracket(
    rungs: Rungs,
    begin: i32,
    step: i32,
    mut passes: impl FnMut(i32) -> Result<bool, SearchEnd>,
) -> Result<[i32; 2], SearchEnd> {
    let [lowest, highest] = SEARCHED.map(|velocity| rungs.nearest(velocity));
    let (mut at, mut step) = (begin.clamp(lowest, highest), step.max(1));
    let first = passes(at)?;
    let beyond = loop {
        // A long step ends where the search does.
        let next = if first { at - step } else { at + step }.clamp(lowest, highest);
        if next == at {
            return Err(SearchEnd::Failed("no velocity from 2 to 4900 m/s changes the outcome".to_owned()));
        }
        if passes(next)? != first {
            break next;
        }
        at = next;
        step *= 2;
    };
    let [mut low, mut high] = if first { [beyond, at] } else { [at, beyond] };
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if passes(middle)? { high = middle } else { low = middle }
    }
    Ok([low, high])
}

/// Threshold of a realisation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FoundThreshold {
    /// Highest stop below it and lowest perforation above it [m/s]; or why there is none.
    pub(super) bracket: Result<[f64; 2], String>,
    /// Whether the outcome turned once only.
    pub(super) monotone: bool,
    /// Bracket on the finer mesh [m/s], where it was looked for and found.
    pub(super) refined: Option<[f64; 2]>,
}

/// Velocity where a search begins [m/s], and its first step in rungs.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub(super) velocity: f64,
    pub(super) step: i32,
}

/// Threshold of a realisation on the mesh of its case, then on the finer one where `is_refined`. `perforated`: outcome of a shot on a
/// mesh, where it is known, or why it has none.
///
/// # Errors
/// Mesh and order of the next shot to fire.
pub(super) fn threshold(
    realisation: u32,
    rungs: Rungs,
    start: Start,
    is_refined: bool,
    perforated: impl Fn(usize, ShotOrder) -> Option<Result<bool, String>>,
) -> Result<FoundThreshold, (usize, ShotOrder)> {
    let passes = |mesh: usize, rung: i32| {
        let order = ShotOrder { shot: realisation, velocity: Some(rungs.velocity(rung)) };
        perforated(mesh, order).ok_or(SearchEnd::Wanted(mesh, order))?.map_err(SearchEnd::Failed)
    };
    let wanted = |end: SearchEnd| match end {
        SearchEnd::Wanted(mesh, order) => Err((mesh, order)),
        SearchEnd::Failed(reason) => Ok(reason),
    };
    let velocities = |ends: [i32; 2]| ends.map(|rung| rungs.velocity(rung));
    let (mut last_stop, mut first_perforation) = (i32::MIN, i32::MAX);
    let mut seen = |rung: i32| {
        let perforated = passes(0, rung)?;
        if perforated {
            first_perforation = first_perforation.min(rung)
        } else {
            last_stop = last_stop.max(rung)
        }
        Ok(perforated)
    };
    let mut search = || {
        let [low, high] = bracket(rungs, rungs.nearest(start.velocity), start.step, &mut seen)?;
        let further = if realisation < FURTHER.0 { FURTHER.1 } else { &[] };
        let further = further.iter().map(|part| rungs.nearest(rungs.velocity(high) * part));
        [low - BESIDE, high + BESIDE].into_iter().chain(further).try_for_each(|rung| seen(rung).map(drop))?;
        Ok([low, high])
    };
    let found = match search() {
        Ok(ends) => velocities(ends),
        Err(end) => {
            return Ok(FoundThreshold { bracket: Err(wanted(end)?), monotone: true, refined: None });
        }
    };
    let step = (REFINED_STEP / rungs.width).round() as i32;
    let refined = match is_refined.then(|| bracket(rungs, rungs.nearest(middle(found)), step, |rung| passes(1, rung))) {
        Some(Err(end)) => wanted(end).map(|_| None)?,
        Some(Ok(ends)) => Some(velocities(ends)),
        None => None,
    };
    Ok(FoundThreshold { bracket: Ok(found), monotone: last_stop < first_perforation, refined })
}

/// Request of a V50.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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
    batch::begin("v50", case, options, json!(request), (folder, FILES))?;
    let nominal = without_velocity_scatter(case);
    // Shots that wait for each other have all threads; without variability all realisations are one.
    let (threads_per_shot, of) = if nominal.varies() { (1, request.count) } else { (options.threads, 1) };
    let options = &BatchOptions { threads_per_shot, ..*options };
    let finer = if request.refined > 0 { case::converged(&nominal) } else { None };
    let cases = [Some(nominal), finer].into_iter().flatten();
    let meshes = cases.zip(TABLES).map(|(case, table)| Batch::open(case, options, folder, table));
    let campaign =
        Campaign { meshes: meshes.collect::<Result<_, _>>()?, request, options, of, done: AtomicU32::new(0) };
    let result = campaign.estimate(&campaign.thresholds()?);
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
        V50Result {
            refined_shots: self.meshes.get(1).map_or(0, |finer| finer.table().rows(u32::MAX).count()),
            shots: shots.len(),
            failed: shots.len() - rows.len(),
            ..V50Result::new(found, fit::passed(&rows), &self.meshes[0].case, self.request)
        }
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
        let found =
            in_threads(self.options.threads, 0..groups.len(), |group| self.thresholds_of(groups[group], start))?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Fires what the searches for these thresholds want, round after round, until none wants any more.
    fn thresholds_of(&self, realisations: &[u32], start: Start) -> Result<Vec<FoundThreshold>, BatchError> {
        let rungs = Rungs { width: self.request.bracket };
        let perforated = |mesh: usize, order| {
            let table = self.meshes[mesh].table();
            table.find(order).map(|row| row.perforated().ok_or_else(|| row.reason.clone()))
        };
        let search = |realisation: &u32| {
            let is_refined = *realisation < self.request.refined && self.meshes.len() > 1;
            threshold(*realisation, rungs, start, is_refined, perforated)
        };
        loop {
            let found: Vec<_> = realisations.iter().map(search).collect();
            let wanted: Vec<(usize, ShotOrder)> =
                found.iter().filter_map(|found| found.as_ref().err().copied()).collect();
            if wanted.is_empty() {
                let count = realisations.len() as u32;
                let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
                (self.options.progress)(done, self.of);
                return Ok(found.into_iter().flatten().collect());
            }
            batch::fire(&self.meshes, &wanted, 1, &|_| {})?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNGS: Rungs = Rungs { width: 0.005 };

    /// Bracket that a search from here finds, and how many shots it takes.
    fn found(begin: f64, step: i32, perforates: impl Fn(f64) -> bool) -> (Option<[f64; 2]>, usize) {
        let mut count = 0;
        let found = bracket(RUNGS, RUNGS.nearest(begin), step, |rung| {
            count += 1;
            assert!(count < 60);
            Ok(perforates(RUNGS.velocity(rung)))
        });
        (found.ok().map(|ends| ends.map(|rung| RUNGS.velocity(rung))), count)
    }

    #[test]
    fn a_threshold_does_not_depend_on_where_its_search_begins() {
        for threshold in [7.3, 184.2, 455.0, 2100.0] {
            let (bracket, _) = found(100.0, 20, |velocity| velocity > threshold);
            assert!(bracket.is_some_and(|[low, high]| low <= threshold && threshold < high && high / low < 1.0052));
            for (begin, step) in [(90.0, 1), (184.0, 4), (700.0, 50), (threshold, 1)] {
                let (other, count) = found(begin, step, |velocity| velocity > threshold);
                assert!(other == bracket, "{threshold} {begin}");
                assert!(begin != threshold || count <= 4, "{count} shots from the threshold itself");
            }
        }
        assert_eq!(found(100.0, 20, |_| false).0, None);
    }

    /// Threshold of realisation 3 or 9 by replays, and the rungs that were fired.
    fn replayed(realisation: u32, perforates: impl Fn(f64) -> bool) -> (FoundThreshold, Vec<i32>) {
        let mut fired: Vec<ShotOrder> = Vec::new();
        loop {
            let outcome = |_: usize, order: ShotOrder| {
                let velocity = order.velocity.unwrap_or_default();
                fired.contains(&order).then(|| Ok(perforates(velocity)))
            };
            match threshold(realisation, RUNGS, Start { velocity: 170.0, step: 4 }, false, outcome) {
                Ok(found) => {
                    let rungs = fired.iter().map(|order| RUNGS.nearest(order.velocity.unwrap_or_default()));
                    return (found, rungs.collect());
                }
                Err((_, order)) => fired.push(order),
            }
        }
    }

    #[test]
    fn further_shots_lie_beside_the_bracket_and_of_the_first_realisations_beyond() {
        let (found, rungs) = replayed(9, |velocity| velocity > 184.2);
        let ends = found.bracket.map(|ends| ends.map(|velocity| RUNGS.nearest(velocity)));
        let Ok([low, high]) = ends else { unreachable!("there is a threshold") };
        assert!([low - BESIDE, high + BESIDE].iter().all(|beside| rungs.contains(beside)), "{rungs:?}");
        let (_, more) = replayed(3, |velocity| velocity > 184.2);
        assert_eq!(more[..rungs.len()], rungs);
        let beyond = more[rungs.len()..].iter().map(|rung| RUNGS.velocity(*rung) / 184.2);
        assert!(
            beyond.zip(FURTHER.1).all(|(got, part)| (got / part - 1.0).abs() < 0.01) && more.len() == rungs.len() + 2
        );
    }

    #[test]
    fn an_outcome_that_turns_back_is_seen() {
        assert!(!replayed(9, |velocity| velocity > 184.0 && !(186.5..187.5).contains(&velocity)).0.monotone);
        assert!(replayed(9, |velocity| velocity > 190.0).0.monotone);
    }
}
