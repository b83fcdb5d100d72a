//! Outcome of a shot, by a written rule.
//!
//! - **stopped**: its velocity along the pack's normal has come to that of what holds it, and what speed is left across it is below a
//!   tenth of the impact speed. That velocity is zero (to a billionth of the impact speed) where an edge is clamped. A pack that nothing
//!   holds flies on with the projectile: there it is the common velocity of both, while fabric covers the projectile.
//! - **rebounded**: the same with more speed left (a ricochet); or, in a run that is carried on from there, it flies back at more
//!   than a hundredth of the impact speed and the pack is quiet.
//! - **perforated**: it has touched the fabric or a yarn has failed, it still flies forward, the pack is quiet, and no fabric of any ply
//!   covers the projectile that can still hold it. No yarn need be broken: it may have pushed a free edge aside.
//! - **running**: none of these by the end.
//!
//! With clay behind the pack, which pushes plugs against the projectile, it need not be quiet: 20 µs without fabric that covers will do.
//!
//! The pack is quiet where for 20 µs it has taken less than a thousandth of the momentum that projectile, or the fabric within
//! twenty radii if that is lighter, would have at impact speed.
//!
//! Fabric covers the projectile where an element lies ahead of it within its cross-section, with a yarn that runs on unbroken
//! for one and a half diameters on both sides: plugs and flaps do not ([`covered`]).
//!
//! It can hold the projectile where the piece of fabric that lies ahead is attached ([`is_held`]). A piece is
//! what unbroken yarns link, node by node; beside a break an element reaches from one to another. It is attached to a clamped
//! edge of its ply that it reaches. Of a ply without one, it is its own inertia that holds: the
//! piece must be at least half of the ply, and not be faster than the projectile. So debris does not hold, however far
//! ahead it flies, and a free ply does as long as it is pushed along. Where all that would hold is faster, the projectile has not
//! come through it and never will: it is stopped.

use std::collections::VecDeque;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::model::layup::{shoulder, unbroken_cells};
use crate::model::mesh::corners;
use crate::num::scalar::Scalar;
use crate::physics::projectile_shape::recess;
use crate::physics::rigid_body::RigidBody;
use crate::run::attachment;
use crate::solver::state::{State, node_position, row_positions};

/// Time without noticeable force after which a perforation is over [s].
const QUIET: f64 = 20e-6;

/// Share of the impact speed that is rest: a body held by nodes that cannot move only comes near to it.
const REST: f64 = 1e-9;
/// Share of the impact speed that is rest against clay, which resists a slow body in part, so that it only comes near to rest.
const REST_ON_CLAY: f64 = 1e-3;

/// Outcome of a shot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Outcome {
    /// Through the pack.
    Perforated,
    /// Brought to rest.
    Stopped,
    /// Thrown back or deflected.
    Rebounded,
    /// Not decided by the end of the run.
    #[default]
    Running,
}

impl Outcome {
    /// Word in `summary.json`.
    pub fn word(self) -> &'static str {
        ["perforated", "stopped", "rebounded", "running"][self as usize]
    }
}

/// State of the projectile from sample to sample.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tracker {
    impact_speed: f64,
    /// Momentum below which the fabric's pull over [`QUIET`] is nothing [N·s].
    quiet_impulse: f64,
    /// Velocity along the normal that the projectile and a pack that nothing holds have in common in the end; zero of others [m/s].
    common: f64,
    window: VecDeque<(f64, f64)>,
    last: Option<(f64, f64)>,
    /// Time at which the velocity along the normal came to that of the fabric that holds [s].
    pub stop_time: Option<f64>,
    /// The fabric that has stopped it flies on, with it.
    pub carried: bool,
    /// Speed away from the pack, along its normal, of a projectile that flies back [m/s].
    pub rebound_velocity: Option<f64>,
    /// It flies back, or is carried along, and nothing has touched it for 20 µs.
    pub separated: bool,
    /// Nothing but fabric that covers speaks against a perforation.
    #[serde(skip)] // of one sample
    pub in_doubt: bool,
    /// Clay stands behind the pack.
    pub backed: bool,
    /// Time since which no fabric has covered a projectile that flies forward through a pack with clay behind it [s].
    through_since: Option<f64>,
    /// Decided so far.
    pub outcome: Outcome,
}

impl Tracker {
    /// A tracker for a projectile of this mass [kg] striking fabric of the given areal density [kg/m²]. `free`: mass of the pack [kg] and its
    /// momentum along the normal [N·s], if nothing holds it.
    pub fn new(body: &RigidBody, mass: f64, areal_density: f64, free: Option<[f64; 2]>) -> Self {
        let patch = areal_density * std::f64::consts::PI * (20.0 * body.body.radius).powi(2);
        let impact_speed = body.velocity.norm();
        // What is driven has no outcome: the pack is never quiet.
        let quiet_impulse = if body.prescribed { 0.0 } else { 1e-3 * mass.min(patch) * impact_speed };
        Self {
            impact_speed,
            quiet_impulse,
            common: free.map_or(0.0, |[pack, momentum]| (body.velocity.z * mass + momentum) / (mass + pack)),
            ..Self::default()
        }
    }

    /// Takes a sample: `time` [s], impulse on the fabric since the last one [N·s], whether the projectile has touched the fabric or a
    /// yarn has failed, whether fabric covers the projectile.
    pub fn update(&mut self, time: f64, body: &RigidBody, impulse: f64, met: bool, covered: impl Fn() -> bool) {
        if body.prescribed {
            return;
        }
        self.window.push_back((time, impulse));
        while self.window.front().is_some_and(|w| w.0 <= time - QUIET) {
            self.window.pop_front();
        }
        let normal = body.velocity.z;
        let goes_on = self.stop_time.is_some();
        if self.backed && met && self.outcome == Outcome::Running {
            self.through_since = (!covered()).then(|| self.through_since.unwrap_or(time));
            let is_long = self.through_since.is_some_and(|since| time - since >= QUIET);
            if is_long || (self.through_since.is_some() && normal <= 0.0) {
                self.outcome = Outcome::Perforated;
                return;
            }
        }
        if let Some((t0, v0)) = self.last.filter(|_| !goes_on) {
            let passes = |bar: f64| v0 > bar && normal <= bar;
            let carried = self.common > 0.0 && passes(self.common) && covered();
            let rest = if self.backed { REST_ON_CLAY } else { REST };
            if carried || passes(rest * self.impact_speed) {
                let bar = if carried { self.common } else { 0.0 };
                self.stop(t0 + (time - t0) * ((v0 - bar) / (v0 - normal)).min(1.0), body, carried);
            }
        }
        self.last = Some((time, normal));
        let taken: f64 = self.window.iter().map(|w| w.1).sum();
        let quiet = time >= QUIET && taken < self.quiet_impulse;
        let open = self.outcome == Outcome::Running && met && normal > 0.0 && quiet;
        self.in_doubt = open && covered();
        if open && !self.in_doubt {
            self.outcome = Outcome::Perforated;
        }
        if goes_on && quiet {
            let flies_back = normal < -0.01 * self.impact_speed;
            if flies_back {
                self.outcome = Outcome::Rebounded;
                self.rebound_velocity = Some(-normal);
            }
            self.separated = (flies_back || self.carried) && taken == 0.0;
        }
    }

    /// Takes note that fabric has stopped the projectile at `time` [s]; `carried`: fabric that flies on.
    fn stop(&mut self, time: f64, body: &RigidBody, carried: bool) {
        self.stop_time = Some(time);
        self.carried = carried;
        let left = body.velocity.xy().norm();
        self.outcome = if left > 0.1 * self.impact_speed { Outcome::Rebounded } else { Outcome::Stopped };
    }

    /// Decides what is in doubt, if it can be now. `held`: whether fabric that is no faster than a speed [m/s] covers the
    /// projectile and can hold it. Where none does, the projectile has passed; where only faster fabric does, it is stopped.
    pub fn look(&mut self, time: f64, body: &RigidBody, held: impl Fn(f64) -> bool) {
        if held(body.velocity.z) {
            return;
        }
        if held(f64::INFINITY) {
            self.stop(time, body, true);
        } else {
            self.outcome = Outcome::Perforated;
        }
    }

    /// Velocity along the normal of a projectile that is stopped by fabric that carries it along [m/s].
    pub fn carried_velocity(&self) -> Option<f64> {
        self.last.filter(|_| self.carried && self.outcome == Outcome::Stopped).map(|last| last.1)
    }

    /// Whether the pack may be quiet at `time` [s], as far as samples are known.
    pub(crate) fn may_be_quiet(&self, time: f64) -> bool {
        let known = self.window.iter().filter(|w| w.0 > time - QUIET);
        self.outcome == Outcome::Running && time >= QUIET && known.map(|w| w.1).sum::<f64>() < self.quiet_impulse
    }
}

/// Whether a yarn of a ply lies ahead of the body's widest section, or of the faces of its chisel nose, and within its
/// shadow, and runs on from there unbroken on both sides: what has been cut out, and a flap, covers nothing.
pub fn covered<S: Scalar>(model: &Model<S>, state: &State<S>, body: &RigidBody, ply: usize) -> bool {
    covered_by(model, state, body, ply, |_, _| true)
}

/// Whether fabric of a ply covers the body and can still hold it: it is attached to a held edge, or most of a
/// ply without one and no faster than `speed` along the normal [m/s].
pub fn is_held<S: Scalar>(model: &Model<S>, state: &State<S>, body: &RigidBody, ply: usize, speed: f64) -> bool {
    let hold = attachment::supporting(model, state, ply, speed);
    covered_by(model, state, body, ply, |cell, ahead| {
        let held = corners(cell).map(|(row, column)| hold(row, column));
        held.iter().zip(ahead).any(|(held, ahead)| *held && ahead) || (ahead[4] && held == [true; 4])
    })
}

/// Whether an element covers the body that `counts`, by its row and column and by which of its corners, and its centre, lie ahead.
fn covered_by<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    body: &RigidBody,
    ply: usize,
    counts: impl Fn([usize; 2], [bool; 5]) -> bool,
) -> bool {
    let shoulder = shoulder(body);
    let place = |point: Vector3<f64>| {
        let local = body.to_body(&point);
        (local, if body.body.profile.bar { local.x.abs() } else { local.xy().norm() })
    };
    let ahead = |point: Vector3<f64>| {
        let (local, across) = place(point);
        across < body.body.radius && local.z + recess(&body.body.profile, local.into()) > shoulder
    };
    let mesh = &model.ply_type(ply).mesh;
    let (first, span) = (model.grid.first_element_row(ply), unbroken_cells(mesh, body));
    // Whether a yarn is unbroken in an element and for `span` finest cells on either side, or to the edge of the ply. Beyond a mirror
    // plane lie images of cells that are no further from it on this side, so that to the plane is far enough.
    let stands = |row, column, yarn| state.alive(first + row, column, yarn) || !mesh.is_present(row, column);
    let runs_on = |row: usize, column: usize, yarn: usize| match yarn {
        0 => mesh.lines[0].within(column, span as f64).all(|column| stands(row, column, 0)),
        _ => mesh.lines[1].within(row, span as f64).all(|row| stands(row, column, 1)),
    };
    // The directions in which `place` measures how far across a point is, in the axes of the ply, and where the body is along them.
    let sides = [Vector3::x(), if body.body.profile.bar { Vector3::zeros() } else { Vector3::y() }].map(|side| {
        let side = body.orientation * side;
        (mesh.to_ply(side.into()), -side.dot(&body.position))
    });
    // An element with a corner further away is not looked at any closer.
    let far = |row, column| body.body.radius + 2.0 * mesh.size(row, column).iter().sum::<f64>();
    // What covers it lies beside it, most often: from there on first.
    let [x, y, _] = mesh.to_ply(body.position.into());
    let [beside, _] = mesh.element_at([x, y]);
    (beside..mesh.rows).chain(0..beside).any(|row| {
        (0..mesh.columns).zip(row_positions(model, state, ply, row)).any(|(column, [x, y, z])| {
            let across = sides.map(|([a, b, c], at)| (a * x + b * y + c * z + at).powi(2));
            if across[0] + across[1] >= far(row, column).powi(2) || !state.is_intact(first + row, column) {
                return false;
            }
            let [a, b, c, d] =
                corners([row, column]).map(|(row, column)| node_position(model, state, [ply, row, column]));
            let ahead = [a, b, c, d, (a + b + c + d) * 0.25].map(ahead);
            ahead.contains(&true) && (0..2).any(|yarn| runs_on(row, column, yarn)) && counts([row, column], ahead)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    /// The projectile of the README's shot, with another velocity [m/s].
    fn body(velocity: [f64; 3]) -> RigidBody {
        let model = Model::<f64>::new(&case::shipped(&[])).unwrap_or_else(|error| unreachable!("{error}"));
        let Some(body) = model.projectile.clone() else { unreachable!("there is one") };
        RigidBody { velocity: velocity.into(), ..body }
    }

    #[test]
    fn a_pack_is_quiet_below_a_thousandth_of_what_a_patch_of_twenty_radii_takes() {
        let body = body([0.0, 0.0, 100.0]);
        let patch = 0.2 * std::f64::consts::PI * (20.0 * body.body.radius).powi(2);
        for mass in [1e-3 * patch, 1e3 * patch] {
            let quiet = Tracker::new(&body, mass, 0.2, None).quiet_impulse;
            let expected = 1e-3 * mass.min(patch) * 100.0;
            assert!((quiet / expected - 1.0).abs() < 1e-12, "{mass}: {quiet} for {expected}");
        }
    }

    #[test]
    fn what_keeps_a_tenth_of_its_speed_along_the_pack_has_rebounded() {
        for (left, expected) in [(9.0, Outcome::Stopped), (11.0, Outcome::Rebounded)] {
            let mut tracker = Tracker::new(&body([0.0, 0.0, 100.0]), 1e-3, 0.2, None);
            tracker.update(1e-6, &body([left, 0.0, 50.0]), 0.0, false, || false);
            tracker.update(2e-6, &body([left, 0.0, -1.0]), 0.0, false, || false);
            assert_eq!(tracker.outcome, expected, "{left} m/s");
        }
    }

    /// A tracker of a shot at 100 m/s, whose pack is quiet below this impulse [N·s].
    fn tracker() -> (Tracker, f64) {
        let tracker = Tracker::new(&body([0.0, 0.0, 100.0]), 1e-3, 1e3, None);
        let quiet = tracker.quiet_impulse;
        assert!((quiet / 1e-4 - 1.0).abs() < 1e-12, "{quiet}");
        (tracker, quiet)
    }

    #[test]
    fn a_pack_is_quiet_when_the_last_twenty_microseconds_took_little() {
        let forward = body([0.0, 0.0, 50.0]);
        // Nothing touches: quiet from 20 µs on, to the last bit.
        for (time, expected) in [(19.999e-6, Outcome::Running), (20e-6, Outcome::Perforated)] {
            let (mut tracker, _) = tracker();
            assert_eq!(tracker.may_be_quiet(time), expected == Outcome::Perforated);
            tracker.update(time, &forward, 0.0, true, || false);
            assert_eq!(tracker.outcome, expected, "{time}");
        }
        // An impulse counts for 20 µs; as much as the bound is too much, and two halves are one.
        for (impulses, time, expected) in [
            ([0.5, 0.5], 23.9e-6, Outcome::Running),
            ([0.5, 0.5], 24.1e-6, Outcome::Perforated),
            ([0.5, 0.499], 23.0e-6, Outcome::Perforated),
            ([0.0, 1.0], 24.1e-6, Outcome::Running),
            ([0.0, 1.0], 25.1e-6, Outcome::Perforated),
        ] {
            let (mut tracker, quiet) = tracker();
            for (at, impulse) in [4e-6, 5e-6].into_iter().zip(impulses) {
                tracker.update(at, &forward, impulse * quiet, true, || false);
            }
            assert_eq!(tracker.may_be_quiet(time), expected == Outcome::Perforated, "{impulses:?} {time}");
            tracker.update(time, &forward, 0.0, true, || false);
            assert_eq!(tracker.outcome, expected, "{impulses:?} {time}");
            assert!(!tracker.may_be_quiet(time) || expected == Outcome::Running);
        }
    }

    #[test]
    fn what_is_through_flies_forward_past_fabric_it_met_and_is_not_covered() {
        let time = 30e-6;
        for (speed, met, covered, expected) in [
            (50.0, true, false, Outcome::Perforated),
            (50.0, false, false, Outcome::Running),
            (50.0, true, true, Outcome::Running),
            (0.0, true, false, Outcome::Running),
            (-50.0, true, false, Outcome::Running),
        ] {
            let (mut tracker, _) = tracker();
            tracker.update(time, &body([0.0, 0.0, speed]), 0.0, met, || covered);
            assert_eq!((tracker.outcome, tracker.in_doubt), (expected, covered), "{speed} {met} {covered}");
        }
        // What is driven has no outcome.
        let driven = RigidBody { prescribed: true, ..body([0.0, 0.0, 50.0]) };
        let mut tracker = Tracker::new(&driven, 1e-3, 1e3, None);
        assert_eq!(tracker.quiet_impulse, 0.0);
        tracker.update(time, &driven, 0.0, true, || false);
        assert_eq!(tracker.outcome, Outcome::Running);
    }

    #[test]
    fn a_stop_is_timed_between_samples_and_followed_by_a_rebound_from_a_hundredth_of_the_speed_on() {
        let (mut tracker, quiet) = tracker();
        tracker.update(10e-6, &body([0.0, 0.0, 6.0]), 0.0, false, || false);
        tracker.update(14e-6, &body([0.0, 0.0, -2.0]), 0.5 * quiet, false, || false);
        // Three quarters of the way from 6 to −2 m/s.
        assert!(tracker.stop_time.is_some_and(|time| (time - 13e-6).abs() < 1e-18), "{tracker:?}");
        assert_eq!((tracker.outcome, tracker.rebound_velocity), (Outcome::Stopped, None));
        tracker.update(21e-6, &body([0.0, 0.0, -0.9]), 0.0, false, || false);
        assert_eq!(tracker.outcome, Outcome::Stopped, "below a hundredth");
        tracker.update(22e-6, &body([0.0, 0.0, -3.0]), 2.0 * quiet, false, || false);
        assert_eq!(tracker.outcome, Outcome::Stopped, "not quiet");
        tracker.update(42.1e-6, &body([0.0, 0.0, -3.0]), 0.5 * quiet, false, || false);
        assert_eq!((tracker.outcome, tracker.rebound_velocity), (Outcome::Rebounded, Some(3.0)));
        assert!(!tracker.separated, "touched a moment ago");
        tracker.update(62.2e-6, &body([0.0, 0.0, -4.0]), 0.0, false, || false);
        assert!(tracker.separated && tracker.rebound_velocity == Some(4.0));
        assert!(tracker.stop_time.is_some_and(|time| (time - 13e-6).abs() < 1e-18));
    }

    #[test]
    fn what_is_in_doubt_is_decided_by_what_holds() {
        let flying = body([0.0, 0.0, 50.0]);
        for (slowest, outcome, carried) in [
            (Some(49.0), Outcome::Running, None),
            (Some(50.0), Outcome::Running, None),
            (Some(51.0), Outcome::Stopped, Some(50.0)),
            (None, Outcome::Perforated, None),
        ] {
            let (mut tracker, _) = tracker();
            tracker.update(30e-6, &flying, 0.0, true, || true);
            assert!(tracker.in_doubt);
            tracker.look(30e-6, &flying, |speed| slowest.is_some_and(|slowest: f64| slowest <= speed));
            assert_eq!((tracker.outcome, tracker.carried_velocity()), (outcome, carried), "{slowest:?}");
            assert_eq!(tracker.stop_time, carried.map(|_| 30e-6));
        }
    }
}
