use super::*;
use crate::case::{self, Case, Shear, ShearModulus};
use crate::physics::shear::ShearConstants;
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::Published;

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
    assert_eq!(bound.of_let_go("tension"), StepBound { critical_step: 0.15 * 2e-7, set_by: "tension" });
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

fn solved(case: &Case, asked: [Option<f64>; 2]) -> Result<InitialStretch, ModelError> {
    let mut pack = case.pack.clone();
    pack.pretension = Some(asked);
    stretch_of_pretension::<Published>(&pack, &UnitCellParameters::new(&case.fabric))
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
        let cell_there = crossover::solve::<f64, Published>(&cell, found.stretch, found.height, both);
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

#[test]
fn no_yarn_is_stretched_to_where_it_breaks() {
    let case = case(&[]);
    let cell = UnitCellParameters::new(&case.fabric);
    let counts = [case.fabric.weft.count, case.fabric.warp.count];
    for (i, name) in ["warp", "weft"].into_iter().enumerate() {
        let with = |strain: f64| {
            let mut asked = [None; 2];
            asked[i] = Some(cell.yarn[i].stiffness * strain * counts[i]);
            solved(&case, asked)
        };
        assert!(with(0.0349).is_ok());
        let broken = with(0.0351);
        assert!(matches!(broken, Err(ModelError::PretensionBreaks { yarn, .. }) if yarn == name), "{broken:?}");
        let beyond = with(0.6);
        assert!(matches!(beyond, Err(ModelError::Pretension { yarn, .. }) if yarn == name), "{beyond:?}");
    }
}
