//! Curves that are drawn twice, and outlines that a gap leaves open, anywhere in the drawing.

use bksim_model::diagnostic::Diagnostic;

use crate::codes;
use crate::compose::near_loops;
use crate::drawing::{Drawing, Entity, Shape};
use crate::excerpt::{Excerpts, short};
use crate::geometry::Path;
use crate::outline::{Stroke, chain_apart, doubled};

/// The curves of the entities of a drawing that are chosen.
fn strokes(drawing: &Drawing, is_meant: impl Fn(&Entity) -> bool) -> Vec<Stroke> {
    let entities = drawing.entities.iter().enumerate().filter(|(_, entity)| is_meant(entity));
    let paths = entities.flat_map(|(idx, entity)| {
        let paths: &[Path] = match &entity.shape {
            Shape::Path(path) => std::slice::from_ref(path),
            Shape::Paths(paths) => paths,
            _ => &[],
        };
        paths.iter().map(move |path| Stroke { path: path.clone(), entity: idx })
    });
    paths.collect()
}

/// Whether a layer is one that traces or marks are on.
fn is_result(layer: &str) -> bool {
    let layer = layer.to_uppercase();
    layer.starts_with("BK_TRACE_") || layer == super::DOCTOR_LAYER || layer == "BK_LEGEND"
}

/// A warning for each entity that lies on another one of its layer.
pub(super) fn twice(drawing: &Drawing, tolerance: f64, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
    let layer = |stroke: &Stroke| drawing.entities[stroke.entity].location.layer.to_uppercase();
    let all = strokes(drawing, |entity| !is_result(&entity.location.layer));
    let mut pairs: Vec<[usize; 2]> = doubled(&all, tolerance)
        .into_iter()
        .map(|it| [it.kept, it.copy])
        .filter(|pair| layer(&all[pair[0]]) == layer(&all[pair[1]]))
        .map(|pair| pair.map(|idx| all[idx].entity))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let warning = |[kept, copy]: [usize; 2]| {
        let [kept, copy] = [kept, copy].map(|idx| &drawing.entities[idx].location);
        let message = format!("a {} lies on a {}", copy.kind, kept.kind);
        let help = "delete it (`OVERKILL` in most CAD programs)";
        let warning = Diagnostic::warning(codes::DOUBLED, message).help(help);
        excerpts.at(excerpts.at(warning, copy, "here"), kept, "and here")
    };
    pairs.into_iter().filter(|pair| pair[0] != pair[1]).map(warning).collect()
}

/// A warning for each loop that a small gap leaves open.
pub(super) fn gaps(drawing: &Drawing, tolerance: f64, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
    let all = strokes(drawing, |entity| !is_result(&entity.location.layer));
    let open = chain_apart(&all, tolerance).chains.open;
    let loops = near_loops(&open, tolerance);
    let warning = |(gaps, entities): (Vec<crate::outline::Snap>, Vec<usize>)| {
        let widest = gaps.iter().map(|gap| gap.distance).fold(0.0, f64::max);
        let words: Vec<String> = gaps.iter().map(crate::outline::Snap::words).collect();
        let message = format!("a loop has {}", words.join(" and "));
        let help =
            format!("close it in the drawing, or allow it: `--tolerance {}`", short(widest * 1.1));
        let warning = Diagnostic::warning(codes::OPEN_OUTLINE, message).help(help);
        let locations = entities.into_iter().map(|idx| &drawing.entities[idx].location);
        locations.fold(warning, |warning, at| excerpts.at(warning, at, ""))
    };
    loops.into_iter().map(warning).collect()
}
