//! Random scenes: a plain shot with some of its keys changed.
//!
//! Each change is drawn, or not, on its own, so that shrinking takes away one after the other and what is left of a
//! failing scene is the plain shot with the few changes that matter. Seed and number give the same scene on every machine.

use proptest::option::weighted;
use proptest::prelude::{Strategy, prop_oneof};
use proptest::sample::select;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde_json::Value;

use super::changes::{Change, changes, further};
use super::user;
use super::values::number;

/// What a scene is made of.
#[derive(Clone, Debug)]
pub(super) struct RandomScene {
    /// Elements along warp and weft.
    pub(super) cells: [u32; 2],
    pub(super) changes: Vec<Change>,
    /// Point of aim from the centre, over the size of the pack.
    pub(super) aim: Option<[f64; 2]>,
    /// Initial tension over what breaks the yarns.
    pub(super) pretension: Option<[f64; 2]>,
    /// Steps of the run, about.
    pub(super) steps: u32,
    /// A whole case instead, as a user would write it.
    pub(super) user: Option<Value>,
    /// What not every machine computes; drawn last, so that the rest is the same scene without them.
    pub(super) further: Vec<Change>,
}

impl RandomScene {
    /// The scene without some of what not every machine computes, the fewest left out first; the whole is not among them.
    pub(super) fn with_less(&self) -> impl Iterator<Item = Self> + '_ {
        // A user's scene has none of them.
        let drawn = if self.user.is_some() { 0 } else { self.further.len() };
        let given: Vec<usize> = (0..drawn).filter(|at| !self.further[*at].is_empty()).collect();
        let mut without: Vec<u32> = (1..1 << given.len()).collect();
        without.sort_by_key(|left_out| left_out.count_ones());
        without.into_iter().map(move |left_out| {
            let mut less = self.clone();
            let gone = given.iter().enumerate().filter(|(bit, _)| left_out >> bit & 1 == 1);
            gone.for_each(|(_, at)| less.further[*at].clear());
            less
        })
    }
}

/// A tree of the scene with this number, to be shrunk; `None` does not happen.
pub(super) fn tree(seed: u64, number: u64) -> Option<impl proptest::strategy::ValueTree<Value = RandomScene>> {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..16].copy_from_slice(&number.to_le_bytes());
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &bytes));
    draws().new_tree(&mut runner).ok()
}

fn draws() -> impl Strategy<Value = RandomScene> {
    let anywhere = || number(-0.6..0.6);
    let side = || select(vec![0.5, -0.5]);
    let aim = prop_oneof![
        3 => [anywhere(), anywhere()],
        1 => [side().boxed(), anywhere().boxed()],
        1 => [anywhere().boxed(), side().boxed()],
        1 => [side(), side()],
    ];
    let pretension = [number(0.0..0.4), number(0.0..0.4)];
    let cells = [1_u32..25, 1_u32..25];
    let parts =
        (cells, changes(), weighted(0.5, aim), weighted(0.2, pretension), 20_u32..400, user::scenes(), further());
    parts.prop_map(|(cells, changes, aim, pretension, steps, user, further)| RandomScene {
        cells,
        changes,
        aim,
        pretension,
        steps,
        user,
        further,
    })
}
