//! A drawing to begin with: all blocks defined and explained, all layers there.

use super::blocks::{Placed, Words, define, place};
use super::canvas::{Canvas, Mark, Release, WriteError};
use super::symbol::symbol;
use super::{LEGEND_LAYER, UNITS};
use crate::geometry::Point;
use crate::kind::{BODY_LAYER, GROUND_LAYER, JOINT_LAYER, KINDS, Kind, Placement};

/// Colours of the index: layers of bodies by turns, then those of the rest.
pub(super) const BODY_COLOURS: [u8; 6] = [5, 30, 94, 6, 34, 140];
/// Of the ground.
pub(super) const GROUND_COLOUR: u8 = 8;
/// Of joints and of inserts.
pub(super) const JOINT_COLOUR: u8 = 1;
/// Of the legend.
const LEGEND_COLOUR: u8 = 8;

/// Layers of bodies in a template, to be renamed.
const BODIES: [&str; 3] = ["crank", "rod", "slider"];

/// A template to write.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Template<'a> {
    /// Of the file.
    pub release: Release,
    /// Of lengths: `mm`, `cm`, `m`, `inch` or `ft`.
    pub unit: &'a str,
    /// Of a symbol, in units. Default: 10 mm, 2 cm, 0.1 m, 0.5 inch, 0.25 ft.
    pub size: Option<f64>,
}

/// A drawing with the blocks of all kinds, their legend, and the layers.
///
/// The legend is left of the drawing area, on the layer `BK_LEGEND`, which is not read as a model.
///
/// # Errors
/// [`WriteError`].
pub fn template(request: &Template<'_>) -> Result<Vec<u8>, WriteError> {
    let mut canvas = Canvas::new(request.release, request.unit)?;
    let size = request.size.unwrap_or_else(|| usual_size(request.unit));
    canvas.layer(LEGEND_LAYER, LEGEND_COLOUR);
    canvas.layer(GROUND_LAYER, GROUND_COLOUR);
    canvas.layer(JOINT_LAYER, JOINT_COLOUR);
    for (name, colour) in BODIES.iter().zip(BODY_COLOURS) {
        canvas.layer(&format!("{BODY_LAYER}{name}"), colour);
    }
    define(&mut canvas, size)?;
    legend(&mut canvas, size)?;
    let area = [[0.0, 0.0], [40.0 * size, 30.0 * size]];
    canvas.view([[-WIDTH * size, 0.0], area[1]], area);
    canvas.bytes()
}

/// The usual size of a symbol.
pub(super) fn usual_size(unit: &str) -> f64 {
    UNITS.iter().find(|(name, ..)| *name == unit).map_or(1.0, |&(.., size)| size)
}

/// Of the legend, in sizes.
const WIDTH: f64 = 72.0;

/// One insert of each block, with its title and its keys.
fn legend(canvas: &mut Canvas, size: f64) -> Result<(), WriteError> {
    const ROW: f64 = 2.2;
    const TOP: f64 = 28.0;
    const ROWS: usize = 12;
    let at = |column: f64, row: f64| [size * (column - WIDTH), size * (TOP - ROW * row)];
    let title = "Blocks of bksim: copy or insert them; this legend is not part of the model";
    canvas.draw(LEGEND_LAYER, Mark::text(at(0.0, -0.6), 0.5 * size, title))?;
    for (idx, kind) in KINDS.iter().enumerate() {
        let (column, row) = ((idx / ROWS) as f64 * 17.5, (idx % ROWS) as f64);
        explain(canvas, kind, at(column + 1.0, row + 0.5), size)?;
    }
    Ok(())
}

fn explain(canvas: &mut Canvas, kind: &Kind, at: Point, size: f64) -> Result<(), WriteError> {
    let [x, y] = at;
    let (at, to) = match kind.placement {
        Placement::Line => ([x - size, y], [x + size, y]),
        _ if kind.name == "gravity" => ([x, y + 0.7 * size], [x + size, y + 0.7 * size]),
        _ if kind.name == "force" => ([x - 0.7 * size, y], [x, y]),
        _ => ([x, y], [x + size, y]),
    };
    place(
        canvas,
        &Placed {
            kind,
            layer: LEGEND_LAYER,
            at,
            to,
            size,
            words: Words::Usual,
            values: Vec::new(),
        },
    )?;
    let title = symbol(kind.name).map_or("", |symbol| symbol.title);
    let text = |line: f64, height: f64, words: String| {
        Mark::text([x + 1.5 * size, y - line * size], height * size, words)
    };
    canvas.draw(LEGEND_LAYER, text(-0.1, 0.38, format!("{}: {title}", kind.block)))?;
    // Long lists of keys take two lines.
    let keys: Vec<String> = kind.keys.iter().map(|key| key.to_uppercase()).collect();
    let first = keys.len().min(7);
    canvas.draw(LEGEND_LAYER, text(0.45, 0.26, keys[..first].join("  ")))?;
    if first < keys.len() {
        canvas.draw(LEGEND_LAYER, text(0.9, 0.26, keys[first..].join("  ")))?;
    }
    Ok(())
}
