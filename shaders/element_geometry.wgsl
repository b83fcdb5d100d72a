// element_geometry: what of the element kernel's constants depends on the size of an element.
// Twin: src/physics/kinematics.rs

/// The constants of an element's own size; otherwise as in `Scene`.
struct ElementGeometry {
    gradient_x: f32,
    gradient_y: f32,
    membrane_warp: f32,
    membrane_weft: f32,
    half_length_warp: f32,
    half_length_weft: f32,
    /// Hourglass stiffness of both yarns [N/m].
    hourglass: f32,
    viscosity_warp: f32,
    viscosity_weft: f32,
    /// In proportion to the whole length, at steep fronts.
    steep_viscosity_warp: f32,
    steep_viscosity_weft: f32,
    cells: f32,
    area: f32,
}

fn geometry_of(element: u32) -> ElementGeometry {
    let finest = ElementGeometry(
        scene.gradient_x,
        scene.gradient_y,
        scene.membrane_warp,
        scene.membrane_weft,
        scene.half_length_warp,
        scene.half_length_weft,
        scene.hourglass_warp + scene.hourglass_weft,
        scene.viscosity_warp,
        scene.viscosity_weft,
        scene.viscosity_warp,
        scene.viscosity_weft,
        scene.cells,
        scene.area);
    if (!GRADED) { return finest; }
    let place = element_place(element);
    let x = line_at(element_ply(element), 0u, place.y);
    let y = line_at(element_ply(element), 1u, place.x);
    return ElementGeometry(
        finest.gradient_x * x.per_width,
        finest.gradient_y * y.per_width,
        finest.membrane_warp * y.width,
        finest.membrane_weft * x.width,
        finest.half_length_warp * y.width,
        finest.half_length_weft * x.width,
        scene.hourglass_warp * x.per_width * x.per_width + scene.hourglass_weft * y.per_width * y.per_width,
        finest.viscosity_warp * min(x.width, scene.viscous_length_x),
        finest.viscosity_weft * min(y.width, scene.viscous_length_y),
        finest.steep_viscosity_warp * x.width,
        finest.steep_viscosity_weft * y.width,
        finest.cells * y.width * x.width,
        finest.area * y.width * x.width);
}
