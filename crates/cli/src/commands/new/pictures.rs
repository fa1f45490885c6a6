//! Small pictures of examples in dots of Braille, as they start: for terminals of any kind.

use std::fs;
use std::path::Path;

use bksim::sim::pose::Poses;
use bksim_scene::{Camera, Extras, Item, Scene, StandardView, Theme, picture};

use crate::args::ModelArgs;
use crate::source::{derive, load};

/// Columns and rows of a picture.
const SIZE: [usize; 2] = [30, 9];
/// Dots of a character, across and down.
const DOTS: [usize; 2] = [2, 4];
/// Side of the area that a camera draws in, px; any will do.
const AREA: f64 = 400.0;
/// Levels to which the models of examples nest.
const NESTING: usize = 64;

/// The lines of the picture of a model that lies in a folder with all its files; none of one that does not start.
pub(super) fn lines(files: &[(&str, &[u8])], first: &str) -> Option<Vec<String>> {
    let folder = tempfile::tempdir().ok()?;
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).ok()?;
    }
    let strokes = strokes(&folder.path().join(first))?;
    Some(dots(&strokes))
}

/// The outlines of all that is drawn of a model at its start, px from the upper left corner.
fn strokes(model: &Path) -> Option<Vec<Vec<[f64; 2]>>> {
    let loaded = load(&ModelArgs::of(model), NESTING).ok()?;
    let mechanism = derive(&loaded.source, loaded.model).ok()?;
    let start = mechanism.start().ok()?;
    let poses = Poses::compile(&mechanism.model, &mechanism.system).ok()?;
    let poses = poses.at(&mechanism.parameters, [(&start.q[..], &start.v[..])]);
    let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &poses);
    let camera = if scene.is_planar {
        Camera::planar([AREA; 2])
    } else {
        let [azimuth, elevation] = StandardView::Isometric.angles_deg().map(f64::to_radians);
        Camera::spatial([AREA; 2], azimuth, elevation)
    };
    let drawn = picture(&scene, poses.first()?, &Extras::default(), &camera, &Theme::LIGHT);
    let closed = |points: &[[f32; 2]], is_closed: bool| -> Vec<[f64; 2]> {
        let again = points.first().filter(|_| is_closed);
        points.iter().chain(again).map(|point| point.map(f64::from)).collect()
    };
    let of_item = |item: &Item| match item {
        Item::Region { rings, .. } => rings.iter().map(|ring| closed(ring, true)).collect(),
        Item::Line { points, is_closed, .. } => vec![closed(points, *is_closed)],
        Item::Text { .. } => Vec::new(),
    };
    Some(drawn.items.iter().flat_map(of_item).collect())
}

/// Strokes in dots, as large as fits.
fn dots(strokes: &[Vec<[f64; 2]>]) -> Vec<String> {
    let n = [0, 1].map(|axis| SIZE[axis] * DOTS[axis]);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in strokes.iter().flatten() {
        for axis in 0..2 {
            (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
        }
    }
    let room = |axis: usize| (n[axis] - 1) as f64 / (high[axis] - low[axis]).max(f64::MIN_POSITIVE);
    let scale = room(0).min(room(1));
    let mut is_set = vec![vec![false; n[0]]; n[1]];
    let mut set = |point: [f64; 2]| {
        let [x, y] = [0, 1].map(|axis| (scale * (point[axis] - low[axis])).round());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 on")]
        let dot = is_set.get_mut(y as usize).and_then(|row| row.get_mut(x as usize));
        if let Some(dot) = dot {
            *dot = true;
        }
    };
    for pair in strokes.iter().flat_map(|stroke| stroke.windows(2)) {
        let [a, b] = [pair[0], pair[1]];
        let length = scale * (b[0] - a[0]).hypot(b[1] - a[1]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few dots")]
        let n_steps = (length.ceil() as usize).clamp(1, n[0] + n[1]);
        for k in 0..=n_steps {
            let part = k as f64 / n_steps as f64;
            set([0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis])));
        }
    }
    let rows = is_set.chunks(DOTS[1]).map(|rows| {
        let letter = |column: usize| {
            let dot = |x: usize, y: usize| rows[y][column * DOTS[0] + x];
            braille(&dot)
        };
        let line: String = (0..SIZE[0]).map(letter).collect();
        line.trim_end_matches('\u{2800}').to_owned()
    });
    let rows: Vec<String> = rows.collect();
    let n_rows = rows.iter().rposition(|row| !row.is_empty()).map_or(0, |last| last + 1);
    rows.into_iter().take(n_rows).collect()
}

/// The letter with these dots.
fn braille(dot: &dyn Fn(usize, usize) -> bool) -> char {
    // Unicode, Braille patterns: dots 1, 2, 3, 7 on the left, 4, 5, 6, 8 on the right.
    const BITS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
    let places = (0..DOTS[1]).flat_map(|y| (0..DOTS[0]).map(move |x| (x, y)));
    let bits: u32 = places.filter(|&(x, y)| dot(x, y)).map(|(x, y)| BITS[y][x]).sum();
    char::from_u32(0x2800 + bits).unwrap_or(' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_become_dots_that_fill_the_picture() {
        let side = |a: [f64; 2], b: [f64; 2]| vec![a, b];
        // A square as high as the picture: 36 dots, so 18 columns.
        let square = vec![vec![[0.0, 0.0], [7.0, 0.0], [7.0, 7.0], [0.0, 7.0], [0.0, 0.0]]];
        let lines = dots(&square);
        assert_eq!(lines.len(), SIZE[1]);
        assert!(lines.iter().all(|line| line.chars().count() == 18), "{lines:#?}");
        assert!(lines[0].starts_with('⡏') && lines[8].ends_with('⣸'), "{lines:#?}");
        // A line along x takes one row; nothing takes none.
        assert_eq!(dots(&[side([0.0, 1.0], [5.0, 1.0])]).len(), 1);
        assert!(dots(&[]).is_empty());
    }
}
