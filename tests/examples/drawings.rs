//! Mechanisms drawn with an independent library move as their twins that are written.
//!
//! `crates/cad/tests/author` draws four mechanisms with ezdxf as a designer would, each in another
//! way of attaching: the slider-crank by blocks with attributes, the four-bar by layers, the
//! five-link mechanism by extended data, the quick return by all of them; and each in variants of
//! version, container, unit, place and kind of outline. The plain ones are `examples/*/drawing.dxf`.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::python::python;
use crate::support::{example_text, messages, path, solve};
use bksim::cad::drawing::Shape;
use bksim::cad::kind::KINDS;
use bksim::cad::model::{ModelOptions, sheet};
use bksim::cad::units;
use bksim::{Mechanism, Motion};

const MECHANISMS: [&str; 4] = ["slider-crank", "four-bar", "five-link", "quick-return"];

/// How far a quantity may be off, of the largest value it takes: what the drawings round, 1e-13 of
/// their size, grows on the way. In the five-link mechanism a start that differs in its last digit
/// alone, as from another guess, makes 5e-9 in speeds and forces, though 2e-10 in the coordinates.
fn tolerance(mechanism: &str, is_coordinate: bool) -> f64 {
    if mechanism == "five-link" && !is_coordinate { 1e-8 } else { 1e-9 }
}

fn author() -> PathBuf {
    path("crates/cad/tests/author")
}

/// The folder with every variant, drawn once.
fn drawn() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("drawings");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a folder for drawings");
        python(&author().join("author.py"), &[&folder.to_string_lossy()]);
        folder
    })
}

/// The model file next to an example's drawing.
fn sidecar(mechanism: &str) -> Option<String> {
    fs::read_to_string(path("examples").join(mechanism).join("drawing.toml")).ok()
}

/// The mechanism of a drawing, or what is wrong with it.
fn read(drawing: &Path, mechanism: &str) -> Result<Mechanism, String> {
    let name = drawing.display();
    let bytes = fs::read(drawing).unwrap_or_else(|e| panic!("{name}: {e}"));
    // DXF R12 says nothing of units.
    let is_r12 = name.to_string().ends_with("-r12.dxf");
    let unit = if mechanism == "five-link" { "m" } else { "mm" };
    let unit = units::by_name(unit).filter(|_| is_r12);
    let sheet = sheet(bytes, unit).map_err(|refused| messages(&refused.diagnostics))?;
    let sidecar = sidecar(mechanism);
    let options = ModelOptions { sidecar: sidecar.as_deref(), unit, ..ModelOptions::default() };
    let composition = sheet.compose(options);
    // Drawn by a careful designer: nothing to complain about.
    if !composition.diagnostics.is_empty() {
        return Err(messages(&composition.diagnostics));
    }
    Mechanism::from_toml(&composition.text, mechanism)
        .map_err(|e| format!("{e}\n{}", composition.text))
}

/// The quantities compared of a motion: a row for each, over time.
fn quantities(mechanism: &Mechanism, motion: &Motion) -> Vec<(String, Vec<f64>)> {
    let mut rows = Vec::new();
    let mut add = |name: String, of: &dyn Fn(usize) -> f64| {
        rows.push((name, (0..motion.samples.len()).map(of).collect()));
    };
    let samples = &motion.samples;
    add("t".to_owned(), &|k| samples[k].t);
    let coordinates = &mechanism.compiled.coordinates;
    for (i, coordinate) in coordinates.iter().enumerate() {
        add(coordinate.name.clone(), &|k| samples[k].q[i]);
    }
    for (i, coordinate) in coordinates.iter().enumerate() {
        add(format!("{}_dot", coordinate.name), &|k| samples[k].v[i]);
    }
    for (i, multiplier) in mechanism.compiled.multipliers.iter().enumerate() {
        add(multiplier.name.clone(), &|k| samples[k].lambda[i]);
    }
    for (i, joint) in mechanism.compiled.joints.iter().enumerate() {
        for component in 0..6 {
            add(format!("reaction in {joint}, {component}"), &|k| {
                samples[k].reactions[i][component]
            });
        }
    }
    // Heights of all centres of mass, and their speeds.
    add("potential energy".to_owned(), &|k| samples[k].energy.potential);
    add("kinetic energy".to_owned(), &|k| samples[k].energy.kinetic);
    add("work".to_owned(), &|k| samples[k].work);
    rows
}

/// Where the motion of a drawing leaves that of its twin furthest, if it does.
fn difference(drawing: &Path, mechanism: &str, twin: &[(String, Vec<f64>)]) -> Option<String> {
    let name = drawing.display();
    let drawn = match read(drawing, mechanism) {
        Ok(drawn) => drawn,
        Err(fault) => return Some(format!("{name}: {fault}")),
    };
    let motion = match drawn.solve() {
        Ok(motion) => motion,
        Err(fault) => return Some(format!("{name}: {fault}")),
    };
    let found = quantities(&drawn, &motion);
    let names = |rows: &[(String, Vec<f64>)]| -> Vec<String> {
        rows.iter().map(|(name, _)| name.clone()).collect()
    };
    if names(&found) != names(twin) {
        return Some(format!("{name}: {:?} against {:?}", names(&found), names(twin)));
    }
    let n_coordinates = drawn.compiled.coordinates.len();
    let pairs =
        found.iter().zip(twin).enumerate().map(|(i, ((quantity, found), (_, expected)))| {
            let largest = expected.iter().fold(1.0, |largest: f64, value| largest.max(value.abs()));
            let errors = found.iter().zip(expected).map(|(a, b)| (a - b).abs() / largest);
            let is_complete = found.len() == expected.len() && found.iter().all(|x| x.is_finite());
            let error = if is_complete { errors.fold(0.0, f64::max) } else { f64::INFINITY };
            // Time and coordinates come first.
            (error / tolerance(mechanism, i <= n_coordinates), error, quantity)
        });
    let (excess, error, quantity) = pairs.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (excess > 1.0).then(|| format!("{name}: {quantity} is off by {error:.1e} of its largest"))
}

#[track_caller]
fn moves_alike(drawing: &Path, mechanism: &str, twin: &[(String, Vec<f64>)]) {
    let difference = difference(drawing, mechanism, twin);
    assert!(difference.is_none(), "{}", difference.unwrap_or_default());
}

fn twin(mechanism: &str) -> Vec<(String, Vec<f64>)> {
    let twin = Mechanism::from_toml(&example_text(mechanism), mechanism);
    let twin = twin.unwrap_or_else(|e| panic!("{mechanism}: {e}"));
    quantities(&twin, &solve(&twin))
}

/// All variants of a mechanism.
fn every_variant_moves_alike(mechanism: &str) {
    let twin = twin(mechanism);
    let files = fs::read_dir(drawn()).expect("the drawings");
    let mut variants: Vec<PathBuf> = files.map(|file| file.expect("a drawing").path()).collect();
    variants.retain(|file| {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        name.strip_prefix(mechanism).is_some_and(|rest| rest.starts_with('-'))
    });
    variants.sort();
    assert!(variants.len() >= 15, "{variants:?}");
    let different = |variant: &PathBuf| difference(variant, mechanism, &twin);
    let differences: Vec<String> = variants.iter().filter_map(different).collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

#[test]
fn the_slider_crank_by_blocks_moves_as_its_twin() {
    every_variant_moves_alike("slider-crank");
}

#[test]
fn the_four_bar_by_layers_moves_as_its_twin() {
    every_variant_moves_alike("four-bar");
}

#[test]
fn the_five_link_mechanism_by_extended_data_moves_as_its_twin() {
    every_variant_moves_alike("five-link");
}

#[test]
fn the_quick_return_in_all_ways_moves_as_its_twin() {
    every_variant_moves_alike("quick-return");
}

#[test]
fn the_examples_are_what_the_independent_library_draws() {
    let of_mechanisms = MECHANISMS.map(|name| (format!("{name}-plain"), format!("{name}/drawing")));
    let of_the_press = ["plain", "outlines"].map(|part| {
        let file = if part == "plain" { "drawing" } else { part };
        (format!("press-{part}"), format!("press/{file}"))
    });
    for (name, example) in of_mechanisms.into_iter().chain(of_the_press) {
        let plain = fs::read(drawn().join(format!("{name}.dxf"))).expect("a drawing");
        let example = path("examples").join(format!("{example}.dxf"));
        let committed = fs::read(&example).unwrap_or_else(|e| panic!("{}: {e}", example.display()));
        assert!(
            plain == committed,
            "{} is not what crates/cad/tests/author draws: draw it anew with `author.py`",
            example.display()
        );
        assert!(committed.len() < 60_000, "{}: {} bytes", example.display(), committed.len());
    }
}

/// ezdxf opens a drawing as it opens damaged ones, checks and mends it, and saves it as the newest
/// version: its own order of sections and objects, nothing kept as it was written.
#[test]
fn drawings_that_another_program_opened_and_saved_move_alike() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("saved");
    fs::create_dir_all(&folder).expect("a folder for drawings");
    let drawings = MECHANISMS.map(|mechanism| path("examples").join(mechanism).join("drawing.dxf"));
    for (mechanism, drawing) in MECHANISMS.iter().zip(drawings) {
        python(
            &author().join("resave.py"),
            &[&folder.to_string_lossy(), &drawing.to_string_lossy()],
        );
        moves_alike(&folder.join("drawing.dxf"), mechanism, &twin(mechanism));
    }
}

/// LibreCAD 2.2.0 (Debian's 2.2.0-1) opened `examples/four-bar/drawing.dxf` in a virtual display and
/// saved it with *Save as*, DXF 2007: all entities and layers are there, its own handles, tables and
/// units. It keeps no extended data and no attributes of inserts, so of the four only the drawing by
/// layers is still a mechanism afterwards: the others are refused, and say what is missing.
#[test]
fn a_drawing_by_layers_that_librecad_saved_moves_alike() {
    let saved = path("crates/cad/tests/saved/four-bar.librecad.dxf");
    moves_alike(&saved, "four-bar", &twin("four-bar"));
}

/// Remarks in Polish: as UTF-8, in code page 1250, and, where the code page has no such letter, as
/// `\U+0142`.
#[test]
fn texts_keep_their_letters_in_every_version_and_code_page() {
    let remarks = ["korba i łącznik 5 kg", "pręty 24 x 10", "pięć członów", "długości w mm"];
    for (mechanism, remark) in MECHANISMS.into_iter().zip(remarks) {
        for variant in ["plain", "r12", "r2000", "r2018", "binary", "cp1250", "mirrored"] {
            let file = drawn().join(format!("{mechanism}-{variant}.dxf"));
            let bytes = fs::read(&file).expect("a drawing");
            let sheet = sheet(bytes, units::by_name("mm"));
            let sheet =
                sheet.unwrap_or_else(|refused| panic!("{}", messages(&refused.diagnostics)));
            let has_remark = sheet.drawing.entities.iter().any(
                |entity| matches!(&entity.shape, Shape::Text { text, .. } if text.contains(remark)),
            );
            assert!(has_remark, "{}: no text with `{remark}`", file.display());
        }
    }
}

/// Every kind, its block and its keys stand in one row of the page.
#[test]
fn the_page_on_drawings_lists_everything_that_can_be_attached() {
    let page = fs::read_to_string(path("docs/drawings.md")).expect("the page");
    for kind in KINDS {
        let head = format!("| `{}` | `{}` |", kind.name, kind.block);
        let row = page.lines().find(|line| line.starts_with(&head));
        let row = row.unwrap_or_else(|| panic!("no row `{head}` in docs/drawings.md"));
        let keys = row.rsplit('|').nth(1).unwrap_or_default();
        let listed: Vec<&str> = keys.split(',').map(|key| key.trim().trim_matches('`')).collect();
        assert_eq!(listed, kind.keys, "{}", kind.name);
    }
    let rows = page.lines().filter(|line| line.starts_with("| `") && line.contains("` | `BK_"));
    assert_eq!(rows.count(), KINDS.len(), "a row of docs/drawings.md is about no kind");
}
