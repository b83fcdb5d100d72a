//! Report of `ripstop check`: every field of a case with where its value came from.

use super::text::short_number_text;
use super::{Case, Layer, grading};

/// Values longer than this do not widen their column.
const WIDEST_VALUE: usize = 40;

/// The title, the mesh, and every field: pointer, value, origin and source. Assumed fields begin with `*`.
pub fn report(case: &Case) -> String {
    let mut lines = vec![case.title.clone(), mesh(case), String::new()];
    let pointers = case.fields.iter().map(|field| field.pointer.chars().count()).max().unwrap_or(0);
    let values = case.fields.iter().map(|field| field.with_unit().chars().count());
    let values = values.filter(|width| *width <= WIDEST_VALUE).max().unwrap_or(0).max("value".len());
    lines.push(line("  field", "value", "origin", "source", [pointers + 2, values]));
    let mut group = "";
    for field in &case.fields {
        let top = field.pointer.split('/').nth(1).unwrap_or_default();
        if top != group && !group.is_empty() {
            lines.push(String::new());
        }
        group = top;
        let mark = if field.assumed { "* " } else { "  " };
        let pointer = format!("{mark}{}", field.pointer);
        lines.push(line(&pointer, &field.with_unit(), field.origin.word(), &field.source, [pointers + 2, values]));
    }
    let assumed = case.fields.iter().filter(|field| field.assumed).count();
    if assumed > 0 {
        lines.push(format!("\n* {assumed} of {} fields are assumed, not published", case.fields.len()));
    }
    lines.join("\n") + "\n"
}

/// The mesh of the pack; of a layup in one line per group, from the struck side.
pub(crate) fn mesh(case: &Case) -> String {
    let pack = &case.pack;
    if pack.layup.is_empty() {
        let mesh: Vec<String> = case.layers().iter().map(elements).collect();
        return format!("{}, {}", plies(pack.plies), mesh.join(""));
    }
    let line = |layer: &Layer| {
        let mesh = elements(layer);
        let turned = short_number_text(layer.orientation.to_degrees());
        format!("{} of {} at {turned}°, {mesh}", plies(layer.plies), layer.fabric.name)
    };
    pack.layup.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn plies(count: u32) -> String {
    format!("{count} {}", if count == 1 { "ply" } else { "plies" })
}

fn elements(layer: &Layer) -> String {
    let [x, y] = [layer.element_length_x, layer.element_length_y].map(|length| length * 1e3);
    let [width, height] = [layer.columns as f64 * x, layer.rows as f64 * y];
    let [columns, rows] = layer.counts();
    let from = if layer.grading.is_some() { "from " } else { "of " };
    let grown = layer.grading.map_or(String::new(), |g| format!(" ({})", grading::words(&g)));
    format!("{columns} × {rows} elements {from}{x:.4} × {y:.4} mm{grown}: {width:.2} × {height:.2} mm")
}

fn line(pointer: &str, value: &str, origin: &str, source: &str, [pointers, values]: [usize; 2]) -> String {
    let line = format!("{pointer:pointers$}  {value:values$}  {origin:7}  {source}");
    line.trim_end().to_owned()
}
