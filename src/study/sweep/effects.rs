//! Main effects: the mean of a response at each value of a factor, and the part of its variance that the factor explains by itself.

/// Points of a band at least, where the values of a factor are all different, and bands of few points at most.
const LEAST: usize = 4;
const BANDS: usize = 12;

/// Mean of the response at a value of a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectLevel {
    /// Value, or the mean of those of a band.
    pub value: f64,
    /// Mean of the response.
    pub mean: f64,
    /// Points.
    pub count: usize,
}

/// The main effect of a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct MainEffect {
    /// By value, ascending.
    pub levels: Vec<EffectLevel>,
    /// Variance of the means over the variance of the response, Sobol's first index \[-\].
    pub part: f64,
}

/// The main effect of a factor, from pairs of its value and the response. Where hardly a value comes twice, values are put together in bands
/// of as many points each. `None` of fewer than two values, or where the response does not vary.
pub(crate) fn main_effect(pairs: &[[f64; 2]]) -> Option<MainEffect> {
    let mut pairs: Vec<[f64; 2]> = pairs.iter().copied().filter(|pair| pair.iter().all(|x| x.is_finite())).collect();
    pairs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let distinct = 1 + pairs.windows(2).filter(|pair| pair[0][0] != pair[1][0]).count();
    let banded = 2 * distinct > pairs.len() && distinct > LEAST;
    let groups: Vec<&[[f64; 2]]> = if banded {
        let bands = (pairs.len() / LEAST).min(BANDS.max((pairs.len() as f64).sqrt() as usize / 2));
        (0..bands).map(|n| &pairs[n * pairs.len() / bands..(n + 1) * pairs.len() / bands]).collect()
    } else {
        pairs.chunk_by(|a, b| a[0] == b[0]).collect()
    };
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|pair| pair[1]).sum::<f64>() / count;
    let variance = pairs.iter().map(|pair| (pair[1] - mean).powi(2)).sum::<f64>() / count;
    let level = |group: &&[[f64; 2]]| {
        let n = group.len() as f64;
        let sum = |of: usize| group.iter().map(|pair| pair[of]).sum::<f64>() / n;
        EffectLevel { value: sum(0), mean: sum(1), count: group.len() }
    };
    let levels: Vec<EffectLevel> = groups.iter().map(level).collect();
    let between = levels.iter().map(|level| level.count as f64 * (level.mean - mean).powi(2)).sum::<f64>() / count;
    // Means of few points differ by chance too; those of a grid do not, for every other key takes all its values at each.
    let within = (variance - between).max(0.0) * count / (count - levels.len() as f64).max(1.0);
    let chance = if banded { within * (levels.len() as f64 - 1.0) / count } else { 0.0 };
    let part = ((between - chance) / variance).max(0.0);
    (levels.len() > 1 && variance > 0.0).then_some(MainEffect { levels, part })
}

#[cfg(test)]
#[path = "effects_tests.rs"]
mod tests;
