//! The critical time step and what sets it.
//!
//! The highest frequency of the assembled mesh is bounded by that of one element. In a one-point quad with lumped
//! mass the patterns of ∂/∂X, ∂/∂Y and hourglass are orthogonal, and within each the directions e_i (yarn) and n_i
//! (shear) are too, so the bound is the largest of the terms below, for any stretch and shear angle. Contact is
//! kinematic and adds no stiffness.
//!
//! Where stretches are means over an element, both yarns act on the hourglass mode, too. Then the largest term is exceeded by b1·b2 at most,
//! with |b|² = |q|²/(3 Λ²): a twelfth where the edges differ from the centre by half of the stretch. A Courant number of 0.9 leaves a fifth.

use crate::case::{CaseError, Edge, Edges, InitialDeflection, Pack};
use crate::num::scalar::bisect;
use crate::physics::crossover::{self, Equilibrium};
use crate::physics::kinematics::ElementConstants;
use crate::physics::membrane::{LONGEST_LEVER, largest_tangent};
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::Sinusoidal;

/// The step bound of a fabric's mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepBound {
    /// 2/ω of the stiffest element mode [s].
    pub critical_step: f64,
    /// Name of that mode.
    pub set_by: &'static str,
}

impl StepBound {
    /// The bound of a fabric. Yarn waves give min(Lx √(Ad/C1), Ly √(Ad/C2)).
    /// `length`: of an element [m]; `areal_density` [kg/m²]; `viscosity`: the coefficient q of the shock viscosity [-], which acts half a
    /// step late, so that a wave's step is shorter by √(1 + q²) − q.
    pub fn new([lx, ly]: [f64; 2], areal_density: f64, element: &ElementConstants<f64>, viscosity: f64) -> Self {
        let yarn = &element.cell.yarn;
        let c1 = yarn[0].stiffness / (2.0 * yarn[1].half_span);
        let c2 = yarn[1].stiffness / (2.0 * yarn[0].half_span);
        let levers = (LONGEST_LEVER / lx).powi(2) + (LONGEST_LEVER / ly).powi(2);
        // Tension stiffens the directions across the yarns, where shear acts, by at most its value at failure.
        let limit = [0, 1].map(|i| yarn[i].failure_strain.min(1.0));
        let tension = (c1 * limit[0] / (lx * lx)).max(c2 * limit[1] / (ly * ly));
        let damped = ((1.0 + viscosity * viscosity).sqrt() - viscosity).powi(-2);
        let terms = [
            (4.0 * damped * c1 / (lx * lx), "wave along the warp"),
            (4.0 * damped * c2 / (ly * ly), "wave along the weft"),
            (4.0 * (largest_tangent(&element.shear) * levers + tension), "trellis shear"),
            ((element.hourglass[0] + element.hourglass[1]) / (lx * ly), "hourglass stiffness"),
        ];
        let (stiffest, set_by) = terms.into_iter().fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a });
        Self { critical_step: 2.0 / (stiffest / areal_density).sqrt(), set_by }
    }

    /// The bound of a ply that starts with what makes energy as yarns go slack, the less the shorter the step: `part` of this, set by that.
    #[must_use]
    pub fn shortened(self, part: f64, set_by: &'static str) -> Self {
        Self { critical_step: part * self.critical_step, set_by }
    }
}

/// Step of a ply that starts far from equilibrium, over the critical one [-]. Tension leaves it in a front as steep as the mesh. Measured: a single element, the worst there is, gains at most
/// 0.4 % of its energy at a Courant number of 0.9; with half of the critical step it was 4.2 %.
pub(super) const LET_GO: f64 = 0.15;

/// Elements of a ply under tension below which energy made and lost at slack does not even out [-]. Measured: plies of 32 to 512 elements that are
/// torn gain −7.1 to 1.9 % of their energy with the critical step, one of 1764 −0.6 to 0.5 %.
pub(super) const FEW: usize = 1000;

/// Step of such a ply over the critical one [-]. The error falls with its square: with 0.5 it was −1.5 to 1.1 %, with 0.15 −0.3 to 0.1 %.
pub(super) const STEP_OF_FEW: f64 = 1.0 / 3.0;

/// Stretch of yarns by the initial deflection above which a ply starts far from equilibrium [-]. Measured: plies of 4 to 20 elements whose yarns
/// it stretches by 2 to 12 % gain 1.0 to 1.7 % of their energy with the critical step.
const STEEP: f64 = 0.01;

/// Start of a ply of this size [m] that is far from equilibrium, if it is: tension that ends at a free edge (of its pre-tension, in
/// which a direction that keeps its length has one, too, or of its deflection), or a steep deflection.
pub fn let_go(
    pretension: Option<[Option<f64>; 2]>,
    deflection: Option<InitialDeflection>,
    edges: Edges,
    size: [f64; 2],
) -> Option<&'static str> {
    let Edges { left, right, bottom, top } = edges;
    let ends = [[left, right], [bottom, top]];
    let stretch = [0, 1].map(|i: usize| {
        let slope = |d: InitialDeflection| {
            std::f64::consts::PI * d.amplitude / size[i] * f64::from([d.warp_half_waves, d.weft_half_waves][i])
        };
        0.25 * deflection.map_or(0.0, slope).powi(2)
    });
    let stretched = |i: usize| stretch[i] > 0.0 || pretension.is_some_and(|forces| forces[i] != Some(0.0));
    if (0..2).any(|i| stretched(i) && ends[i].contains(&Edge::Free)) {
        return Some("initial tension at a free edge");
    }
    stretch.iter().any(|stretch| *stretch > STEEP).then_some("steep initial deflection")
}

/// Stretch range searched, Λ − 1.
const RANGE: [f64; 2] = [-0.5, 0.5];

/// Uniform stretch of the pack before the shot, and the yarn heights in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialStretch {
    /// Λ − 1 along warp and weft [-].
    pub stretch: [f64; 2],
    /// Yarn heights [m].
    pub height: [f64; 2],
}

/// Finds the stretch that carries the pre-tension asked for; a direction without one keeps its length.
///
/// # Errors
/// When no stretch does, or when it would break a yarn.
pub fn stretch_of_pretension(pack: &Pack, cell: &UnitCellParameters<f64>) -> Result<InitialStretch, CaseError> {
    let rest = InitialStretch { stretch: [0.0; 2], height: [cell.yarn[0].height, cell.yarn[1].height] };
    let Some(asked) = pack.pretension else { return Ok(rest) };
    let mut stretch = [0.0; 2];
    // Where a yarn is absent the heights sum up to nothing, and the other one straightens freely.
    let solved = |stretch: [f64; 2]| crossover::solve::<f64, Sinusoidal>(cell, stretch, rest.height, true);
    // Per reference length [N/m].
    let force = |there: &Equilibrium<f64>, i: usize| there.in_plane[i] / (2.0 * cell.yarn[1 - i].half_span);
    let largest = |is_below: &dyn Fn(f64) -> bool| {
        let [low, high] = bisect(RANGE, 60, is_below);
        0.5 * (low + high)
    };
    // Both membrane forces grow with both stretches, so each direction is bisected, the warp inside the weft.
    let warp = |weft: f64| match asked[0] {
        Some(n) => largest(&|s| force(&solved([s, weft]), 0) <= n),
        None => 0.0,
    };
    if let Some(n) = asked[1] {
        stretch[1] = largest(&|s| force(&solved([warp(s), s]), 1) <= n);
    }
    stretch[0] = warp(stretch[1]);
    let there = solved(stretch);
    for (i, yarn) in ["warp", "weft"].into_iter().enumerate() {
        if let Some(n) = asked[i].filter(|n| (force(&there, i) - n).abs() > 1e-6 * n.max(1.0)) {
            let expected = "a force that a stretch between 0.5 and 1.5 gives";
            return Err(CaseError::at("/pack/pretension", expected, format!("{n} N/m along {yarn}")));
        }
        let limit = cell.yarn[i].failure_strain;
        if cell.yarn[i].stiffness > 0.0 && there.strain[i] >= limit {
            let expected = format!("a force that leaves the {yarn} below its failure strain, {limit}");
            return Err(CaseError::at("/pack/pretension", expected, format!("a strain of {:.4}", there.strain[i])));
        }
    }
    Ok(InitialStretch { stretch, height: there.height })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{self, Case, Shear, ShearModulus};
    use crate::physics::membrane::ShearConstants;
    use crate::physics::unit_cell_parameters::UnitCellParameters;

    const LX: f64 = 2e-3;
    const LY: f64 = 1.5e-3;
    const DENSITY: f64 = 0.3;

    /// The bound of a fabric whose yarns have these stiffnesses over the width of a yarn [N/m] and break at these strains, with this shear
    /// modulus times thickness and these hourglass stiffnesses [N/m].
    fn bound(c: [f64; 2], strain: [f64; 2], shear: f64, hourglass: [f64; 2], viscosity: f64) -> StepBound {
        let mut cell = UnitCellParameters::new(&case::shipped(&[]).fabric);
        let half_span = [0.6e-3, 0.8e-3];
        for i in 0..2 {
            cell.yarn[i].half_span = half_span[i];
            cell.yarn[i].stiffness = c[i] * 2.0 * half_span[1 - i];
            cell.yarn[i].failure_strain = strain[i];
        }
        let modulus = ShearModulus::Tangent;
        let shear = Shear { g1: 0.25 * shear, g2: shear, gamma1: 0.3, gamma2: 0.6, modulus };
        let element = ElementConstants {
            cell,
            shear: ShearConstants::new(Some(&shear), 1.0),
            gradient: [0.5 / LX, 0.5 / LY],
            membrane: [0.0; 2],
            half_length: [0.5 * LY, 0.5 * LX],
            hourglass,
            viscosity: [0.0; 2],
            viscous_length: [1.0; 2],
            per_steep: 0.0,
            rate: None,
            mode_share: 0.0,
            cells: 1.0,
            area: LX * LY,
        };
        StepBound::new([LX, LY], DENSITY, &element, viscosity)
    }

    #[track_caller]
    fn assert_bound(found: StepBound, step: f64, set_by: &str) {
        assert_eq!(found.set_by, set_by);
        assert!((found.critical_step / step - 1.0).abs() < 1e-12, "{} instead of {step}", found.critical_step);
    }

    #[test]
    fn a_wave_takes_the_critical_step_over_an_element() {
        // L/c with c = √(C/Ad).
        let warp = LX * (DENSITY / 3e6_f64).sqrt();
        assert_bound(bound([3e6, 1e3], [0.03; 2], 0.0, [0.0; 2], 0.0), warp, "wave along the warp");
        let weft = LY * (DENSITY / 2e6_f64).sqrt();
        assert_bound(bound([3e6, 2e6], [0.03; 2], 0.0, [0.0; 2], 0.0), weft, "wave along the weft");
        // Shock viscosity shortens it to that by √(1 + q²) − q: a half, where q is three quarters.
        assert_bound(bound([3e6, 1e3], [0.03; 2], 0.0, [0.0; 2], 0.75), 0.5 * warp, "wave along the warp");
        assert_bound(bound([3e6, 2e6], [0.03; 2], 0.0, [0.0; 2], 0.75), 0.5 * weft, "wave along the weft");
    }

    #[test]
    fn shear_of_a_folded_element_under_breaking_tension_sets_the_step_of_a_stiff_trellis() {
        // The levers are 9/4 of those of an element at rest.
        let levers = (2.25 / LX).powi(2) + (2.25 / LY).powi(2);
        let of = |tension: f64| (DENSITY / (5e6 * levers + tension)).sqrt();
        let trellis = "trellis shear";
        assert_bound(bound([4e6, 1e3], [0.25, 0.1], 5e6, [0.0; 2], 0.0), of(4e6 * 0.25 / (LX * LX)), trellis);
        assert_bound(bound([1e3, 4e6], [0.25, 0.1], 5e6, [0.0; 2], 0.0), of(4e6 * 0.1 / (LY * LY)), trellis);
        // Yarns that do not break count as if they did at twice their length.
        assert_bound(bound([4e6, 1e3], [1e30, 0.1], 5e6, [0.0; 2], 0.0), of(4e6 / (LX * LX)), trellis);
        assert_bound(bound([1e3, 4e6], [0.1, 1e30], 5e6, [0.0; 2], 0.0), of(4e6 / (LY * LY)), trellis);
    }

    #[test]
    fn the_hourglass_mode_has_both_stiffnesses_and_the_mass_of_a_node_at_each_corner() {
        // ω² = k/(4 · m/4) of the mode with k = k1 + k2, m the mass of the element: 2/ω.
        let step = 2.0 * (DENSITY * LX * LY / 7e7).sqrt();
        assert_bound(bound([3e6, 2e6], [0.03; 2], 0.0, [3e7, 4e7], 0.0), step, "hourglass stiffness");
        assert_bound(bound([3e6, 2e6], [0.03; 2], 0.0, [3e7, 4e7], 0.75), step, "hourglass stiffness");
    }

    #[test]
    fn tension_is_let_go_at_free_edges_across_it_only() {
        let held = Edges { left: Edge::Clamped, right: Edge::Clamped, bottom: Edge::Free, top: Edge::Roller };
        let size = [0.04, 0.02];
        let of_forces = |forces, edges| let_go(forces, None, edges, size).is_some();
        assert!(!of_forces(None, held));
        assert!(!of_forces(Some([Some(1e4), Some(0.0)]), held));
        assert!(of_forces(Some([Some(1e4), None]), held) && of_forces(Some([None, Some(1.0)]), held));
        assert!(!of_forces(Some([Some(1e4); 2]), Edges { bottom: Edge::Roller, ..held }));
        // A deflection stretches yarns along its waves.
        let deflected = |warp_half_waves, weft_half_waves| {
            let_go(None, Some(InitialDeflection { amplitude: 1e-4, warp_half_waves, weft_half_waves }), held, size)
                .is_some()
        };
        assert_eq!([deflected(1, 0), deflected(0, 1), deflected(2, 3)], [false, true, true]);
        let bound = StepBound { critical_step: 2e-7, set_by: "wave along the warp" };
        assert_eq!(bound.shortened(LET_GO, "tension"), StepBound { critical_step: 0.15 * 2e-7, set_by: "tension" });
    }

    #[test]
    fn a_steep_deflection_is_let_go_whatever_the_edges() {
        // Yarns are stretched by (π n A/L)²/4: 1 % at a slope of 0.2 where they cross the plane.
        let of = |amplitude, [warp_half_waves, weft_half_waves]: [u32; 2]| {
            let deflection = InitialDeflection { amplitude, warp_half_waves, weft_half_waves };
            let held = Edges { left: Edge::Clamped, right: Edge::Clamped, bottom: Edge::Clamped, top: Edge::Roller };
            let_go(None, Some(deflection), held, [0.04, 0.02])
        };
        let at = |slope: f64, half_wave: f64| slope * half_wave / std::f64::consts::PI;
        let steep = Some("steep initial deflection");
        assert_eq!([of(at(0.19, 0.04), [1, 0]), of(at(0.21, 0.04), [1, 0])], [None, steep]);
        assert_eq!([of(at(0.19, 0.02), [2, 0]), of(at(0.21, 0.02), [2, 0])], [None, steep]);
        assert_eq!([of(at(0.19, 0.005), [1, 4]), of(at(-0.21, 0.005), [1, 4])], [None, steep]);
    }

    fn case(more: &[&str]) -> Case {
        case::shipped(&[&["/fabric/weft/count_per_inch=15", "/fabric/weft/modulus_gpa=60"], more].concat())
    }

    fn solved(case: &Case, asked: [Option<f64>; 2]) -> Result<InitialStretch, CaseError> {
        let mut pack = case.pack.clone();
        pack.pretension = Some(asked);
        stretch_of_pretension(&pack, &UnitCellParameters::new(&case.fabric))
    }

    #[test]
    fn a_stretched_pack_carries_what_was_asked_and_keeps_its_length_elsewhere() {
        let absent = [&[][..], &[r#"/fabric/weft={"absent": true, "count_per_inch": 15}"#]];
        for (more, asked) in absent.into_iter().flat_map(|more| {
            [[Some(900.0), None], [None, Some(700.0)], [Some(900.0), Some(2500.0)], [Some(0.01), Some(1e4)]]
                .map(|asked| (more, asked))
        }) {
            let case = case(more);
            let cell = UnitCellParameters::new(&case.fabric);
            let both = more.is_empty();
            if !both && asked[1].is_some() {
                assert!(solved(&case, asked).is_err(), "a yarn that is not there carries nothing");
                continue;
            }
            let found = solved(&case, asked).unwrap_or_else(|error| unreachable!("{error}"));
            let cell_there = crossover::solve::<f64, Sinusoidal>(&cell, found.stretch, found.height, both);
            // Yarns per length of the other direction's side.
            let counts = [case.fabric.weft.count, case.fabric.warp.count];
            for i in 0..2 {
                match asked[i] {
                    Some(n) => {
                        let carried = cell_there.in_plane[i] * counts[i];
                        assert!((carried - n).abs() <= 1e-6 * n.max(1.0), "{asked:?}: {carried}");
                    }
                    None => assert_eq!(found.stretch[i], 0.0),
                }
            }
            if both {
                assert!((0..2).all(|i| (cell_there.height[i] / found.height[i] - 1.0).abs() < 1e-6), "{found:?}");
            }
        }
    }
}
