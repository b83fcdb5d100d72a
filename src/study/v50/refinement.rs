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
mod tests {
    use super::*;

    #[test]
    fn pairs_give_their_mean_ratio_and_students_interval() {
        let pairs = [[100.0, 103.0], [200.0, 202.0], [50.0, 51.0], [80.0, 83.2]];
        let Some(found) = Refinement::new(&pairs) else { unreachable!("there are pairs") };
        assert!((found.ratio - 1.025).abs() < 1e-12 && found.count == 4);
        let sigma = ((0.005_f64.powi(2) * 2.0 + 0.015_f64.powi(2) * 2.0) / 3.0).sqrt();
        assert!((found.sigma - sigma).abs() < 1e-12, "{found:?}");
        // Student's t of three degrees of freedom at 90 %: 2.353.
        assert!((found.half_width(0.9) - 1.5 * 2.353_363 * sigma / 2.0).abs() < 1e-6, "{}", found.half_width(0.9));
    }

    #[test]
    fn one_pair_has_a_ratio_alone() {
        let found = Refinement::new(&[[180.0, 185.4]]);
        assert_eq!(found.map(|found| (found.count, found.half_width(0.9))), Some((1, 0.0)));
        // 180, 185.4, and 190.8 if the error is of first order: the middle of the last two, and half of what is between them.
        assert!(found.is_some_and(|found| (180.0 * found.factor() - 188.1).abs() < 1e-9));
        assert!(found.is_some_and(|found| (180.0 * found.open() - 2.7).abs() < 1e-9));
        assert_eq!(Refinement::new(&[]), None);
    }
}
