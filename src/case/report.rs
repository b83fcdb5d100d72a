//! What `ripstop check` prints: every field of a case with where its value came from.

use super::{Case, Field, Origin};

/// Values longer than this do not widen their column.
const WIDEST_VALUE: usize = 24;

/// The title, the mesh, and every field: pointer, value, origin and source. Assumed fields begin with `*`.
pub fn report(case: &Case) -> String {
    let mut lines = vec![case.title.clone(), mesh(case), String::new()];
    let pointers = widest(case, |field| &field.pointer, usize::MAX);
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
        lines.push(line(&pointer, &field.with_unit(), origin(field.origin), &field.source, [pointers + 2, values]));
    }
    let assumed = case.fields.iter().filter(|field| field.assumed).count();
    if assumed > 0 {
        lines.push(format!("\n* {assumed} of {} fields are assumed, not published", case.fields.len()));
    }
    lines.join("\n") + "\n"
}

fn mesh(case: &Case) -> String {
    let pack = &case.pack;
    let [x, y] = [pack.element_length_x * 1e3, pack.element_length_y * 1e3];
    let [width, height] = [pack.columns as f64 * x, pack.rows as f64 * y];
    let plies = if pack.plies == 1 { "ply" } else { "plies" };
    format!(
        "{} {plies}, {} × {} elements of {x:.4} × {y:.4} mm: {width:.2} × {height:.2} mm",
        pack.plies, pack.columns, pack.rows
    )
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Read => "read",
        Origin::Default => "default",
        Origin::Derived => "derived",
    }
}

fn widest<'a>(case: &'a Case, text: impl Fn(&'a Field) -> &'a String, most: usize) -> usize {
    let widths = case.fields.iter().map(|field| text(field).chars().count());
    widths.filter(|width| *width <= most).max().unwrap_or(0)
}

fn line(pointer: &str, value: &str, origin: &str, source: &str, [pointers, values]: [usize; 2]) -> String {
    let line = format!("{pointer:pointers$}  {value:values$}  {origin:7}  {source}");
    line.trim_end().to_owned()
}
