//! Strains of the elements, and yarns that are to break by them.

use ripstop::gpu::stepper::Stage;
use ripstop::kernels::element_force::{BREAKING, field as element};

use super::elements::compare_elements;
use super::{Outcome, Pair, STEPS, Seen};

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    let [mut broken, mut spared] = [0; 2];
    for _ in 0..STEPS {
        pair.advance(&[Stage::Elements, Stage::Failure], None)?;
        compare_elements(pair, seen)?;
        let more = judged(pair);
        (broken, spared) = (broken + more[0], spared + more[1]);
    }
    // Nothing is spared where nothing else lies around.
    let alone = pair.scene.model.sheets[0].neighbourhood.as_ref().is_some_and(|around| around.reach <= 0.5);
    if broken < 10 || (spared < 10 && !alone) {
        return Err(format!("{broken} yarns break and {spared} are spared: the scene tells nothing"));
    }
    Ok(())
}

/// Yarns beyond their limit that are to break, and those that what lies around them spares.
fn judged(pair: &Pair<'_>) -> [usize; 2] {
    let (model, state) = (&pair.scene.model, &pair.expected);
    let mut count = [0; 2];
    for row in 0..model.grid.element_rows() {
        let cell = &model.sheet(model.grid.element_row(row).0).cell;
        for (column, yarn) in (0..model.grid.columns).flat_map(|column| [(column, 0), (column, 1)]) {
            let number = |field: usize| f64::from(state.elements.get(row, field + yarn, column + 1));
            if state.alive(row, column, yarn) && number(element::COUNT) >= cell.yarn[yarn].failure_strain {
                count[usize::from(number(element::ALIVE) != BREAKING)] += 1;
            }
        }
    }
    count
}
