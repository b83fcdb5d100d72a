//! `ripstop v50`: from a case to the velocity at which half of all shots perforate.
//!
//! A threshold is the velocity at which one realisation (same fabric, same hit) turns from stopped to perforated. Velocities lie on a ladder
//! whose rungs are a given part apart, so that a threshold does not depend on where its search began. A pack may be perforated at some
//! velocities, stop again at higher ones, where it tears off its frame, and be perforated beyond: its limit is the lowest. So a search goes
//! down to a stop, from there up in steps that are never long, halves, and begins anew below where a slower shot perforates. What is
//! caught by cloth that has torn off its frame is not stopped. An undecided shot is fired again with a later end. The search on a finer
//! mesh begins where that on the mesh of the case ended. A search is replayed from its begin whenever another outcome is known; the first
//! one that is not is what it wants next.
//!
//! Thresholds are sought in blocks, realisations of a block in parallel, on a device in rounds of a shot of each. The next shots depend on
//! outcomes alone, never on the order in which shots ended: a campaign that was broken off asks for the same again, and finds the rows
//! that are there.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::json;

use super::batch::{self, Batch, BatchError, BatchOptions, ShotOrder, StudyProgress, in_threads};
use super::shots::ShotRow;
pub use super::v50_result::V50Request;
use super::v50_result::V50Result;
use crate::case::{self, Case};
use crate::output::Folder;

/// Names of the tables of shots: of the case, on the converged mesh, and with yarns as woven.
const TABLES: [&str; 3] = ["v50.csv", "v50-refined.csv", "v50-as-woven.csv"];
/// Every file that is written.
pub const FILES: &[&str] = &["plan.json", TABLES[0], TABLES[1], TABLES[2], "v50.html", "v50.json"];
/// Part of strain and strength that fibres out of woven KM2 keep (Cheng, Chen and Weerasooriya 2005), and the power of it that moves limits.
pub const AS_WOVEN: [f64; 2] = [0.785, 0.77];
/// Realisations whose thresholds are sought at a time: first few, for the later ones begin where those ended.
const BLOCKS: [u32; 3] = [2, 6, 8];
/// First step of the first searches, over the width of a rung; later ones step by the scatter of those before.
const FIRST_STEP: f64 = 0.1;
/// Thresholds without which no interval is narrow.
const LEAST: usize = 8;
/// Longest step up, over the velocity: packs that stop again are perforated over a wider range below.
const LONGEST_STEP: f64 = 0.2;
/// Rungs from the bracket at which the outcome is checked again.
const BESIDE: i32 = 3;
/// Velocities that are searched [m/s].
const SEARCHED: [f64; 2] = [2.0, 4900.0];
/// Reasons why there is no threshold between them.
const PASSES: &str = "even 2 m/s perforates; look at /pack/edges, and at units of mass and strength";
const STOPS: &str = "even 4900 m/s is stopped; look at units of mass and strength";
/// First step of a search on the finer mesh or as woven, over where it begins.
const OTHER_STEP: f64 = 0.02;
/// Realisations that are shot further from their thresholds too.
const WIDELY: u32 = 8;
/// Where, over the threshold: below it, where all must be stopped, and above it, for the residual velocities.
const FURTHER: [&[f64]; 2] = [&[0.96, 0.92, 0.85, 0.7, 0.55], &[1.15, 1.4]];

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
    /// Shot whose outcome is not known yet: number of the case, and order.
    Wanted(usize, ShotOrder),
    /// Reason why there is no threshold.
    Failed(String),
}

/// Whether a shot perforates for certain: one without an outcome does not.
///
/// # Errors
/// The shot, where it is still to be fired.
fn certainly(passes: Result<bool, SearchEnd>) -> Result<bool, SearchEnd> {
    if matches!(passes, Err(SearchEnd::Failed(_))) { Ok(false) } else { passes }
}

/// Rungs of the highest stop and the lowest perforation around the lowest threshold, by a search from a rung on in steps of at least
/// `step`. `below`: distances in rungs, all below 0, from that stop to where all must be stopped too.
///
/// # Errors
/// The first error of `passes`, or that no velocity changes the outcome.
pub fn bracket(
    rungs: Rungs,
    begin: i32,
    step: i32,
    below: &[i32],
    mut passes: impl FnMut(i32) -> Result<bool, SearchEnd>,
) -> Result<[i32; 2], SearchEnd> {
    let [lowest, highest] = SEARCHED.map(|velocity| rungs.nearest(velocity));
    let step = step.max(1);
    let longest = step.max((LONGEST_STEP / rungs.width) as i32);
    let mut begin = begin.clamp(lowest, highest);
    loop {
        let (mut low, mut down, mut up) = (begin, step, step);
        while passes(low)? {
            if low == lowest {
                return Err(SearchEnd::Failed(PASSES.to_owned()));
            }
            // A long step ends where the search does.
            low = (low - down).max(lowest);
            down *= 2;
        }
        let mut high = low;
        while high == low || !passes(high)? {
            if high == highest {
                return Err(SearchEnd::Failed(STOPS.to_owned()));
            }
            low = high;
            high = (low + up).min(highest);
            up = (2 * up).min(longest);
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if passes(middle)? { high = middle } else { low = middle }
        }
        let slower = below.iter().map(|distance| low + distance).filter(|rung| *rung >= lowest);
        let mut perforated = slower.map(|rung| Ok(certainly(passes(rung))?.then_some(rung)));
        begin = match perforated.find_map(Result::transpose) {
            Some(rung) => rung?,
            None => return Ok([low, high]),
        };
    }
}

/// Threshold of a realisation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FoundThreshold {
    /// Highest stop below it and lowest perforation above it [m/s]; or why there is none.
    pub(super) bracket: Result<[f64; 2], String>,
    /// Whether the outcome turned once only.
    pub(super) monotone: bool,
    /// Brackets on the finer mesh and as woven [m/s], where they were looked for and found.
    pub(super) others: [Option<[f64; 2]>; 2],
}

/// Velocity where a search begins [m/s], and its first step in rungs.
type Start = (f64, i32);

/// Threshold of a realisation of the case, then of `others`: the number of each, and where its search begins, over that threshold.
/// `perforated`: outcome of a shot, where it is known, or why it has none.
///
/// # Errors
/// Number of the case and order of the next shot to fire.
pub(super) fn threshold(
    realisation: u32,
    rungs: Rungs,
    start: Start,
    others: [Option<(usize, f64)>; 2],
    perforated: impl Fn(usize, ShotOrder) -> Option<Result<bool, String>>,
) -> Result<FoundThreshold, (usize, ShotOrder)> {
    let passes = |case: usize, rung: i32| {
        let order = ShotOrder { shot: realisation, velocity: Some(rungs.velocity(rung)) };
        perforated(case, order).ok_or(SearchEnd::Wanted(case, order))?.map_err(SearchEnd::Failed)
    };
    let wanted = |end: SearchEnd| match end {
        SearchEnd::Wanted(case, order) => Err((case, order)),
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
        let widely = |far: &[f64]| -> Vec<i32> {
            let far = far.iter().filter(|_| realisation < WIDELY);
            far.map(|part| rungs.nearest(*part)).collect()
        };
        let [below, above] = FURTHER.map(widely);
        let below = [&[-BESIDE], &below[..]].concat();
        let [low, high] = bracket(rungs, rungs.nearest(start.0), start.1, &below, &mut seen)?;
        [BESIDE].into_iter().chain(above).try_for_each(|rung| certainly(seen(high + rung)).map(drop))?;
        Ok([low, high])
    };
    let found = match search() {
        Ok(ends) => velocities(ends),
        Err(end) => {
            return Ok(FoundThreshold { bracket: Err(wanted(end)?), monotone: true, others: [None; 2] });
        }
    };
    let step = (OTHER_STEP / rungs.width).round() as i32;
    let mut brackets = [None; 2];
    for (found_there, (case, part)) in brackets.iter_mut().zip(others).filter_map(|(to, other)| Some((to, other?))) {
        match bracket(rungs, rungs.nearest(part * middle(found)), step, &[], |rung| passes(case, rung)) {
            Ok(ends) => *found_there = Some(velocities(ends)),
            Err(end) => drop(wanted(end)?),
        }
    }
    Ok(FoundThreshold { bracket: Ok(found), monotone: last_stop < first_perforation, others: brackets })
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
    let nominal = case::at_nominal_velocity(case);
    // Shots that wait for each other have all threads; without variability all realisations are one.
    let (threads_per_shot, of) = if nominal.varies() { (1, request.count) } else { (options.threads, 1) };
    let options = &BatchOptions { threads_per_shot, ..*options };
    let finer = if request.refined > 0 { case::converged(&nominal) } else { None };
    let is_alone = request.refined > 0 && !nominal.varies();
    let woven = if is_alone { case::as_woven(&nominal, AS_WOVEN[0]) } else { None };
    let cases = [Some(nominal), finer, woven].into_iter().zip(TABLES);
    let (cases, tables): (Vec<Case>, Vec<&str>) = cases.filter_map(|(case, table)| Some((case?, table))).unzip();
    let others = [TABLES[1], TABLES[2]].map(|name| tables.iter().position(|table| *table == name));
    let batches = cases.into_iter().zip(&tables).map(|(case, table)| Batch::open(case, options, folder, table));
    let batches = batches.collect::<Result<_, _>>()?;
    let campaign = Campaign { batches, others, request, options, of, done: AtomicU32::new(0) };
    let result = campaign.result()?;
    let case = &campaign.batches[0].case;
    let page = result.report(case, request).html(
        &format!("{}: {}", if result.is_alone { "Ballistic limit" } else { "V50" }, case.title),
        "v50.json and v50.csv",
    );
    let mut texts = vec![("v50.json", format!("{:#}\n", result.json(case, request, options.seed))), ("v50.html", page)];
    texts.extend(tables.into_iter().zip(campaign.batches.iter().map(|batch| batch.table().text(u32::MAX))));
    folder.put(&texts, &[])?;
    campaign.batches.iter().try_for_each(|batch| batch.table().close())?;
    Ok(result)
}

struct Campaign<'a> {
    /// Shots of the case, and of those that it is compared with.
    batches: Vec<Batch<'a>>,
    /// Number of that on the converged mesh, where it is another and was asked for, and of that with yarns as woven.
    others: [Option<usize>; 2],
    request: &'a V50Request,
    options: &'a BatchOptions<'a>,
    /// Realisations at most, and those that are done.
    of: u32,
    done: AtomicU32,
}

impl Campaign<'_> {
    fn estimate(&self, found: &[FoundThreshold]) -> V50Result {
        let rows = |batch: usize| self.batches[batch].table().rows(u32::MAX).cloned().collect::<Vec<ShotRow>>();
        V50Result {
            other_shots: self.others.map(|other| other.map_or(0, |other| rows(other).len())),
            ..V50Result::new(found, rows(0), &self.batches[0].case, self.request)
        }
    }

    /// Result of so many thresholds as are asked for, or as its interval needs.
    fn result(&self) -> Result<V50Result, BatchError> {
        let mut found: Vec<FoundThreshold> = Vec::new();
        let mut sizes = BLOCKS.into_iter();
        loop {
            let (first, size) = (found.len() as u32, sizes.next().unwrap_or(BLOCKS[2]));
            found.extend(self.block(first..(first + size).min(self.of), self.start(&found))?);
            let result = self.estimate(&found);
            let is_narrow = |width: f64| result.bounds.is_narrow(result.v50, width);
            let is_enough = found.len() >= LEAST && self.request.until_width.is_some_and(is_narrow);
            if is_enough || found.len() as u32 >= self.of {
                return Ok(result);
            }
        }
    }

    /// Start of the next searches: the middle of the thresholds so far, and steps of their scatter.
    fn start(&self, found: &[FoundThreshold]) -> Start {
        let width = self.request.bracket;
        let brackets = found.iter().filter_map(|found| found.bracket.as_ref().ok());
        let mut middles: Vec<f64> = brackets.copied().map(middle).collect();
        middles.sort_by(f64::total_cmp);
        if middles.is_empty() {
            let velocity = self.batches[0].case.projectile.as_ref().map_or(100.0, |projectile| projectile.velocity);
            return (velocity, (FIRST_STEP / width).round() as i32);
        }
        let velocity = middles[middles.len() / 2];
        let mean = middles.iter().sum::<f64>() / middles.len() as f64;
        let square = middles.iter().map(|middle| (middle - mean).powi(2)).sum::<f64>() / middles.len() as f64;
        (velocity, (square.sqrt() / (width * mean)).round() as i32)
    }

    /// Thresholds of some realisations: each on a thread, or all together on a device.
    fn block(&self, block: Range<u32>, start: Start) -> Result<Vec<FoundThreshold>, BatchError> {
        let realisations: Vec<u32> = block.collect();
        let at_a_time = if self.options.device.is_some() { realisations.len() } else { 1 };
        let groups: Vec<&[u32]> = realisations.chunks(at_a_time).collect();
        let found = in_threads(self.options.threads, groups.len(), |group| self.thresholds_of(groups[group], start))?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Fires what the searches for these thresholds want, round after round, until none wants any more.
    fn thresholds_of(&self, realisations: &[u32], start: Start) -> Result<Vec<FoundThreshold>, BatchError> {
        let rungs = Rungs { width: self.request.bracket };
        let perforated = |number: usize, order| {
            let Batch { case, .. } = &self.batches[number];
            let table = self.batches[number].table();
            let row = table.find(order).filter(|row| row.later_end(case).is_none())?;
            Some(row.defeats().ok_or_else(|| format!("at {} m/s: {}", row.velocity, row.reason)))
        };
        let search = |realisation: &u32| {
            let [finer, woven] = self.others;
            let finer = finer.filter(|_| *realisation < self.request.refined).map(|finer| (finer, 1.0));
            let woven = woven.map(|woven| (woven, AS_WOVEN[0].powf(AS_WOVEN[1])));
            threshold(*realisation, rungs, start, [finer, woven], perforated)
        };
        loop {
            let found: Vec<_> = realisations.iter().map(search).collect();
            let of_batch = |(number, order): &(usize, ShotOrder)| (&self.batches[*number], *order);
            let wanted: Vec<_> = found.iter().filter_map(|found| found.as_ref().err().map(of_batch)).collect();
            if wanted.is_empty() {
                let count = realisations.len() as u32;
                self.done.fetch_add(count, Ordering::Relaxed);
                return Ok(found.into_iter().flatten().collect());
            }
            batch::fire(&wanted, 1, &|_| {})?;
            let seen: Vec<StudyProgress> = self.batches.iter().map(|batch| batch.table().progress()).collect();
            (self.options.progress)(StudyProgress {
                done: self.done.load(Ordering::Relaxed),
                of: self.of,
                shots: seen.iter().map(|seen| seen.shots).sum(),
                limit: seen[0].limit,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNGS: Rungs = Rungs { width: 0.005 };

    /// Bracket that a search from here finds, and how many shots it takes.
    fn found(begin: f64, step: i32, perforates: impl Fn(f64) -> bool) -> (Option<[f64; 2]>, usize) {
        let (mut count, below) = (0, &FURTHER[0].iter().map(|part| RUNGS.nearest(*part)).collect::<Vec<_>>());
        let found = bracket(RUNGS, RUNGS.nearest(begin), step, below, |rung| {
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
                assert!(begin != threshold || count <= 9, "{count} shots from the threshold itself");
            }
        }
        assert_eq!(found(100.0, 20, |_| false).0, None);
        assert_eq!(found(100.0, 20, |_| true).0, None);
    }

    /// Four plies of KM2 that stop a 64-grain cylinder again where they tear off their frame.
    #[test]
    fn of_a_pack_that_stops_again_the_lowest_limit_is_found() {
        for (begin, step) in [(100.0, 20), (260.0, 20), (300.0, 4), (423.0, 20), (423.0, 1), (450.0, 20), (900.0, 20)] {
            let (bracket, _) = found(begin, step, |velocity| (270.0..410.0).contains(&velocity) || velocity > 440.0);
            assert!(
                bracket.is_some_and(|[low, high]| low < 270.0 && high > 269.9 && high < 272.0),
                "{begin} {bracket:?}"
            );
        }
    }

    /// Threshold of realisation 3 or 9 by replays, and the rungs that were fired.
    fn replayed(realisation: u32, perforates: impl Fn(f64) -> bool) -> (FoundThreshold, Vec<i32>) {
        let mut fired: Vec<ShotOrder> = Vec::new();
        loop {
            let outcome = |_: usize, order: ShotOrder| {
                let velocity = order.velocity.unwrap_or_default();
                fired.contains(&order).then(|| Ok(perforates(velocity)))
            };
            match threshold(realisation, RUNGS, (170.0, 4), [None; 2], outcome) {
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
        let beyond: Vec<f64> =
            more.iter().filter(|rung| !rungs.contains(*rung)).map(|rung| RUNGS.velocity(*rung) / 184.2).collect();
        assert!(beyond.iter().zip(FURTHER.concat()).all(|(got, part)| (got / part - 1.0).abs() < 0.01), "{beyond:?}");
        assert_eq!(beyond.len(), FURTHER.concat().len());
    }

    #[test]
    fn an_outcome_that_turns_back_is_seen() {
        assert!(!replayed(9, |velocity| velocity > 184.0 && !(186.5..187.5).contains(&velocity)).0.monotone);
        assert!(replayed(9, |velocity| velocity > 190.0).0.monotone);
    }
}
