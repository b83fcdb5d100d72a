//! Three-phase optimal design, 3POD (Wu & Tian 2014): search, then D-optimal shots, then a search for one quantile.

use super::d_optimal::{clipped, d_optimal};
use super::replay::{Asked, Replay};
use super::robbins_monro::RobbinsMonro;
use crate::num::link::Link;
use crate::study::binary_response::{fit, location};
use crate::study::outcomes::Shot;

/// Gap, in σg, below which shots are placed beside it to give overlap.
const NARROW: f64 = 1.5;
/// How far beside it, in σg.
const BESIDE: f64 = 0.3;
/// What σg is multiplied with where those did not.
const SHRINK: f64 = 2.0 / 3.0;

/// Guesses it starts from, and how long its phases are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreePod {
    /// Lower guess of V50.
    pub low: f64,
    /// Upper guess of V50.
    pub high: f64,
    /// Guess of σ.
    pub sigma: f64,
    /// Shots of the second phase, all later ones where no quantile is sought.
    pub d_optimal: usize,
    /// Chance of a perforation at the velocity that the third phase seeks.
    pub quantile: Option<f64>,
}

impl ThreePod {
    /// Velocity of the next shot.
    pub fn next(&self, shots: &[Shot]) -> f64 {
        let Asked(velocity) = match self.procedure(&mut Replay::new(shots)) {
            Ok(never) => match never {},
            Err(asked) => asked,
        };
        velocity
    }

    fn procedure(&self, replay: &mut Replay<'_>) -> Result<std::convert::Infallible, Asked> {
        let sigma = self.bracket(replay)?;
        let sigma = narrow(replay, sigma)?;
        widen(replay, sigma)?;
        let mut second = 0;
        loop {
            if let Some(p) = self.quantile.filter(|_| second >= self.d_optimal) {
                seek(replay, p)?;
            }
            let seen = replay.seen();
            replay.ask(|| {
                let seen = seen.iter().collect();
                let [mu, sigma] = clipped(&seen);
                d_optimal(&seen, mu, sigma)
            })?;
            second += 1;
        }
    }

    /// Until there are both outcomes. Gives σg, which is doubled after every third shot that did not help.
    fn bracket(&self, replay: &mut Replay<'_>) -> Result<f64, Asked> {
        let at = |share: f64| self.low + share * (self.high - self.low);
        let [first, second] = [replay.ask(|| at(0.25))?.perforated, replay.ask(|| at(0.75))?.perforated];
        let mut sigma = self.sigma;
        match (first, second) {
            (false, true) => {}
            (true, false) => {
                replay.ask(|| self.low - 3.0 * sigma)?;
                replay.ask(|| self.high + 3.0 * sigma)?;
            }
            (same, _) => {
                for n in 1.. {
                    if n % 3 == 0 {
                        sigma *= 2.0;
                    }
                    let far = NARROW * f64::from(n) * sigma;
                    let velocity = if same { self.low - far } else { self.high + far };
                    if replay.ask(|| velocity)?.perforated != same {
                        break;
                    }
                }
            }
        }
        Ok(sigma)
    }
}

/// Until there is overlap. Gives σg.
fn narrow(replay: &mut Replay<'_>, mut sigma: f64) -> Result<f64, Asked> {
    loop {
        let seen = replay.outcomes();
        let (Some(stop), Some(perforation), Some(gap)) = (seen.fastest_stop(), seen.slowest_perforation(), seen.gap())
        else {
            return Ok(sigma);
        };
        if gap < 0.0 {
            return Ok(sigma);
        }
        if gap >= NARROW * sigma {
            replay.ask(|| location(Link::Probit, &seen, sigma))?;
            continue;
        }
        let [perforated, stopped] = seen.counts();
        let beside = |above: bool| if above { perforation + BESIDE * sigma } else { stop - BESIDE * sigma };
        // First where the rarer outcome lies.
        let above = stopped > perforated;
        for above in [above, !above] {
            if replay.ask(|| beside(above))?.perforated != above {
                return Ok(sigma);
            }
        }
        sigma *= SHRINK;
    }
}

/// Shots within the overlap, beside it where it is narrow.
fn widen(replay: &mut Replay<'_>, sigma: f64) -> Result<(), Asked> {
    let seen = replay.outcomes();
    let [Some(stop), Some(perforation)] = [seen.fastest_stop(), seen.slowest_perforation()] else { return Ok(()) };
    let middle = 0.5 * (stop + perforation);
    if stop - perforation < sigma {
        replay.ask(|| middle + 0.5 * sigma)?;
        replay.ask(|| middle - 0.5 * sigma)?;
    } else {
        replay.ask(|| middle)?;
    }
    Ok(())
}

/// The third phase. Ends only where there is no estimate to start from.
fn seek(replay: &mut Replay<'_>, p: f64) -> Result<(), Asked> {
    let seen = replay.outcomes();
    let Ok(found) = fit(Link::Probit, &seen) else { return Ok(()) };
    let [mu, sigma] = clipped(&seen);
    let mut search = RobbinsMonro::new(p, sigma, found.covariance, found.sigma);
    let mut velocity = mu + Link::Probit.quantile(p) * sigma;
    loop {
        let shot = replay.ask(|| velocity)?;
        velocity = search.next(shot.velocity, shot.perforated);
    }
}
