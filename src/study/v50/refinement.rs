//! What a finer mesh moves a limit by: the thresholds of a few realisations on both meshes.
//!
//! Most shots are computed on the mesh of the case. Its thresholds are off by much the same part in every realisation, for the mesh is the
//! same. So a few pairs tell by how much, and their mean corrects the mean of all.
//!
//! Elements half as long move a limit by a part d. If the finer mesh is converged, as it is on S-720 with 2, 4 and 8 elements per
//! crossover (benches/NOTES.md), d is all. If the error falls as the length of an element, as with stretches at the centre of elements,
//! as much again is to come. The correction is the middle, 1.5 d, and may be off by 0.5 d.

use crate::study::student_t;

/// Thresholds on the finer mesh over those on the mesh of the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refinement {
    /// Pairs of thresholds.
    pub count: usize,
    /// Mean ratio [-].
    pub ratio: f64,
    /// Standard deviation of the ratio [-]; 0 for one pair.
    pub sigma: f64,
}

impl Refinement {
    /// From pairs of thresholds, on the mesh of the case and on the finer one, in one unit; `None` without a pair.
    pub fn new(pairs: &[[f64; 2]]) -> Option<Self> {
        let count = pairs.len() as f64;
        let ratios = || pairs.iter().map(|[coarse, fine]| fine / coarse);
        let ratio = ratios().sum::<f64>() / count;
        let squares: f64 = ratios().map(|each| (each - ratio).powi(2)).sum();
        let sigma = if pairs.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 };
        (!pairs.is_empty()).then_some(Self { count: pairs.len(), ratio, sigma })
    }

    /// What limits on the mesh of the case are multiplied by [-]: the middle between a finer mesh that is converged and an error of first
    /// order.
    pub fn factor(&self) -> f64 {
        1.0 + 1.5 * (self.ratio - 1.0)
    }

    /// What that may be off by, either way [-].
    pub fn open(&self) -> f64 {
        0.5 * (self.ratio - 1.0).abs()
    }

    /// Half the width of the interval of the mean factor [-], with this two-sided confidence: Student's; 0 for one pair.
    pub fn half_width(&self, level: f64) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        1.5 * student_t::quantile(level, self.count as u64 - 1) * self.sigma / (self.count as f64).sqrt()
    }
}

#[cfg(test)]
#[path = "refinement_tests.rs"]
mod tests;
