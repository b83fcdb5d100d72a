//! What a user should know before a run.

use ripstop::case::{Case, Shape};

/// One line each.
pub(crate) fn notes(case: &Case) -> Vec<String> {
    thin_projectile(case).into_iter().collect()
}

/// Contact is sampled at nodes: between them a thin projectile is not seen.
fn thin_projectile(case: &Case) -> Option<String> {
    let diameter = match case.projectile.as_ref()?.shape {
        Shape::Cylinder { diameter, .. }
        | Shape::Sphere { diameter }
        | Shape::Cone { diameter, .. }
        | Shape::Ogive { diameter, .. }
        | Shape::Fragment { diameter, .. } => diameter,
        Shape::Bar { .. } => return None, // meets whole rows of nodes
    };
    let cell = case.pack.element_length_x.max(case.pack.element_length_y);
    let cells = diameter / cell;
    (cells < 3.0).then(|| {
        format!("note: the projectile is {cells:.1} elements wide; below 3 it may slip between the nodes that contact is sampled at")
    })
}
