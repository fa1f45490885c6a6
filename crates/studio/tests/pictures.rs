//! The pictures of `docs/pictures` are what the commands draw: every example moving, and its curves, on
//! light and on dark.
//!
//! They are drawn again and compared: the same elements in the same order, every number within half a
//! pixel, since rounding differs from machine to machine. With `BKSIM_BLESS=1` they are written.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{CRATE, Scratch, text};

/// Largest difference of a number, pixels.
const TOLERANCE: f64 = 0.5;

fn root() -> PathBuf {
    Path::new(CRATE).join("../..").canonicalize().expect("the project")
}

/// Pictures of an example: what each is of.
fn examples() -> Vec<(String, PathBuf)> {
    let folders = fs::read_dir(root().join("examples")).expect("examples");
    let mut all = Vec::new();
    for folder in folders.map(|entry| entry.expect("an entry").path()) {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        let model = [folder.join("model.toml"), folder.join("drawing.dxf")];
        all.extend(model.into_iter().find(|path| path.is_file()).map(|model| (name, model)));
    }
    all.sort();
    all
}

#[test]
fn every_picture_is_what_the_commands_draw() {
    let pictures = root().join("docs/pictures");
    let is_blessing = std::env::var_os("BKSIM_BLESS").is_some();
    let place = Scratch::new();
    let examples = examples();
    assert!(examples.len() >= 8, "{examples:?}");
    for (name, model) in &examples {
        succeeds(&place, &format!("solve {} -o {name}.mcap", model.display()));
        for theme in ["light", "dark"] {
            let motion = format!("{name}-{theme}.svg");
            let curves = format!("{name}-curves-{theme}.svg");
            succeeds(&place, &format!("render {name}.mcap -o {motion} --background {theme}"));
            succeeds(&place, &format!("plot {name}.mcap -o {curves} --theme {theme}"));
            for picture in [motion, curves] {
                let drawn = fs::read_to_string(place.path().join(&picture)).expect("a picture");
                let drawn = without_mark(&drawn);
                if is_blessing {
                    fs::create_dir_all(&pictures).expect("a folder");
                    fs::write(pictures.join(&picture), drawn).expect("written");
                    continue;
                }
                let kept = fs::read_to_string(pictures.join(&picture));
                let kept = kept.unwrap_or_else(|e| panic!("docs/pictures/{picture}: {e}"));
                if let Err(difference) = compare(drawn, &kept) {
                    panic!("docs/pictures/{picture} is not what is drawn: {difference}");
                }
            }
        }
    }
}

#[test]
fn every_example_shows_its_pictures_and_so_does_the_gallery() {
    let gallery = fs::read_to_string(root().join("docs/seeing/gallery.md")).expect("a gallery");
    for (name, _) in &examples() {
        let readme = root().join("examples").join(name).join("README.md");
        let readme = fs::read_to_string(&readme).expect("a README");
        for picture in ["light", "dark", "curves-light", "curves-dark"] {
            let file = format!("pictures/{name}-{picture}.svg");
            assert!(readme.contains(&format!("../../docs/{file}")), "README of {name}: {file}");
            let is_of_motion = !picture.starts_with("curves");
            assert!(!is_of_motion || gallery.contains(&format!("../{file}")), "gallery: {file}");
        }
        assert!(gallery.contains(&format!("(../../examples/{name})")), "gallery: {name}");
        let command = format!("`bksim new {name} --template {name}`");
        assert!(gallery.contains(&command), "gallery: {command}");
    }
}

#[test]
fn a_picture_that_is_shifted_by_a_pixel_is_another() {
    let kept = "<path d=\"M10.25 3.5L4 -2\"/>";
    assert_eq!(compare(kept, kept), Ok(()));
    assert_eq!(compare("<path d=\"M10.05 3.5L4 -2.2\"/>", kept), Ok(()));
    assert!(compare("<path d=\"M11.25 3.5L4 -2\"/>", kept).is_err());
    assert!(compare("<path d=\"M10.25 3.5L4 -2L1 1\"/>", kept).is_err());
    assert!(compare("<line d=\"M10.25 3.5L4 -2\"/>", kept).is_err());
}

/// A picture without the remark at its end, whose checksum depends on the last digit of every number.
fn without_mark(picture: &str) -> &str {
    picture.rsplit_once("<!-- made by bksim ").map_or(picture, |(picture, _)| picture)
}

fn succeeds(place: &Scratch, command: &str) {
    let output = place.run(command);
    assert!(output.status.success(), "bksim {command}: {}", text(&output.stderr));
}

/// Says where two pictures differ.
fn compare(found: &str, expected: &str) -> Result<(), String> {
    let (found, expected) = (pieces(found), pieces(expected));
    for (idx, (a, b)) in found.iter().zip(&expected).enumerate() {
        let is_same = match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= TOLERANCE,
            _ => a == b,
        };
        if !is_same {
            return Err(format!("piece {idx}: `{a}` in place of `{b}`"));
        }
    }
    if found.len() == expected.len() {
        return Ok(());
    }
    Err(format!("{} pieces in place of {}", found.len(), expected.len()))
}

/// Numbers, and the text between them.
fn pieces(picture: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut start = 0;
    let mut was_number = false;
    for (idx, c) in picture.char_indices() {
        let is_number = c.is_ascii_digit() || c == '.' || c == '-';
        if is_number != was_number || c == '-' {
            pieces.push(&picture[start..idx]);
            start = idx;
        }
        was_number = is_number;
    }
    pieces.push(&picture[start..]);
    pieces
}
