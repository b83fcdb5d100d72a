//! The ballistic limit by bisection.

/// Doublings of the first step in search of a bracket.
const DOUBLINGS: u32 = 8;

/// Two velocities that the ballistic limit lies between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityBracket {
    /// The projectile is stopped or thrown back [m/s].
    pub stopped: f64,
    /// It perforates [m/s].
    pub perforated: f64,
}

impl VelocityBracket {
    /// Half way between [m/s].
    pub fn middle(&self) -> f64 {
        0.5 * (self.stopped + self.perforated)
    }
}

/// Bisects from a guess [m/s] until the bracket is no wider than `width` [-] of it; `perforates` tells whether a shot of that
/// velocity does. `None` where eight doublings of the step find no bracket.
///
/// # Errors
/// What a shot did not start for.
pub(crate) fn bisect<E>(
    guess: f64,
    width: f64,
    mut perforates: impl FnMut(f64) -> Result<bool, E>,
) -> Result<Option<VelocityBracket>, E> {
    let Some(mut limit) = bracket(guess, width, &mut perforates)? else { return Ok(None) };
    while limit.perforated - limit.stopped > width * guess {
        let middle = limit.middle();
        if perforates(middle)? {
            limit.perforated = middle;
        } else {
            limit.stopped = middle;
        }
    }
    Ok(Some(limit))
}

/// Steps away from the guess, twice as far each time, until the outcome turns.
fn bracket<E>(
    guess: f64,
    width: f64,
    perforates: &mut impl FnMut(f64) -> Result<bool, E>,
) -> Result<Option<VelocityBracket>, E> {
    let above = perforates(guess)?;
    let mut last = guess;
    let mut step = 2.0 * width * guess;
    for _ in 0..DOUBLINGS {
        let next = if above { last - step } else { last + step };
        if next <= 0.0 {
            break;
        }
        if perforates(next)? != above {
            let (stopped, perforated) = if above { (next, last) } else { (last, next) };
            return Ok(Some(VelocityBracket { stopped, perforated }));
        }
        last = next;
        step *= 2.0;
    }
    Ok(None)
}

#[cfg(test)]
#[path = "limit_tests.rs"]
mod tests;
