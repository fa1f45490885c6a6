//! `bksim render`: what it writes, and what it refuses.

use std::fs;

use crate::common::{CRATE, Scratch, text};

fn with_model() -> Scratch {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/../../examples/parallelogram/model.toml"));
    place.write("model.toml", model.expect("an example"));
    place
}

/// Width and height of a PNG, from its header.
fn png_size(bytes: &[u8]) -> [u32; 2] {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes")))
}

#[test]
fn a_picture_and_films_of_every_format_are_written() {
    let place = with_model();
    let solved = place.run("solve model.toml -o run.mcap");
    assert!(solved.status.success(), "{}", text(&solved.stderr));
    for (command, start) in [
        ("run.mcap -o a.png --size 65x49", &b"\x89PNG"[..]),
        ("model.toml -o b.png --at 0.1 --labels --background dark --density 2", b"\x89PNG"),
        ("run.mcap -o a.svg --at 0.3 --labels --arrows forces", b"<svg"),
        ("run.mcap -o a.gif --size 64x48 --to 0.2", b"GIF89a"),
        ("run.mcap -o a.apng --size 64x48 --to 0.2 --fps 10 --background transparent", b"\x89PNG"),
        ("run.mcap -o a.mp4 --size 65x49 --to 0.2 --speed 0.5 --background #204060", b"\0\0\0"),
    ] {
        let output = place.run(&format!("render {command}"));
        assert!(output.status.success(), "{command}: {}", text(&output.stderr));
        let name = command.split_whitespace().nth(2).expect("a name");
        let bytes = fs::read(place.path().join(name)).expect("a file");
        assert!(bytes.starts_with(start), "{name}");
        assert!(!place.path().join(format!("{name}.part")).exists(), "{name}");
    }
    let bytes = fs::read(place.path().join("a.png")).expect("a picture");
    assert_eq!(png_size(&bytes), [65, 49]);
    // Sizes of MP4 are even.
    let seen = place.run("render run.mcap -o b.mp4 --size 65x49 --to 0.2 --json");
    assert!(text(&seen.stdout).contains("\"width\": 66"), "{}", text(&seen.stdout));
}

#[test]
fn a_log_and_its_model_give_the_same_picture() {
    let place = with_model();
    assert!(place.run("solve model.toml -o run.mcap").status.success());
    let arguments = "--size 160x120 --at 0.37 --arrows reactions,velocities --ghosts 3";
    for (input, output) in [("run.mcap", "a.png"), ("model.toml", "b.png")] {
        let drawn = place.run(&format!("render {input} -o {output} {arguments}"));
        assert!(drawn.status.success(), "{}", text(&drawn.stderr));
    }
    let [a, b] = ["a.png", "b.png"].map(|name| fs::read(place.path().join(name)).expect("it"));
    assert!(a == b, "they differ");
}

#[test]
fn what_makes_no_sense_is_refused_and_leaves_no_file() {
    let place = with_model();
    place.write("there.png", "mine");
    for (arguments, status, words) in [
        ("model.toml -o there.png", 4, "add --force"),
        ("model.toml -o model.toml", 2, "end its name with"),
        ("model.toml -o out.webm", 2, "end its name with"),
        ("model.toml -o nowhere/out.png", 4, "no directory"),
        ("model.toml -o out.png --at 99", 2, "the motion goes from"),
        ("model.toml -o out.png --fps 10", 2, "for films"),
        ("model.toml -o out.gif --at 0", 2, "for pictures"),
        ("model.toml -o out.png --trail nothing", 2, "is called `nothing`"),
        ("model.toml -o out.png --view 10,20", 2, "planar"),
        ("model.toml -o out.png --section x=0", 2, "--section is for spatial mechanisms"),
        ("model.toml -o out.png --section x=1s", 2, "such as `x = 20 mm`"),
        ("model.toml -o out.png --size 5", 2, "1280x720"),
        ("model.toml -o out.png --background purple", 2, "transparent"),
        ("missing.mcap -o out.png", 4, "no such file"),
        ("model.toml -o out.gif --speed 0", 2, "0.000001"),
        ("model.toml -o out.gif --speed 0.000001", 2, "frames"),
    ] {
        let output = place.run(&format!("render {arguments}"));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {said}");
        assert!(said.contains(words), "{arguments}: {said}");
        assert!(!place.path().join("out.png").exists(), "{arguments}");
        assert!(!place.path().join("out.gif").exists(), "{arguments}");
    }
    assert_eq!(fs::read(place.path().join("there.png")).expect("it is there"), b"mine");
}

#[test]
fn films_are_replaced_by_those_of_the_same_model_and_by_no_other() {
    let place = with_model();
    for name in ["a.gif", "a.mp4", "a.apng"] {
        let command = format!("render model.toml -o {name} --size 64x48 --to 0.1 --fps 10");
        for _ in 0..2 {
            let drawn = place.run(&command);
            assert!(drawn.status.success(), "{name}: {}", text(&drawn.stderr));
        }
        let path = place.path().join(name);
        let mut film = fs::read(&path).expect("a film");
        film[40] ^= 1;
        fs::write(&path, film).expect("written");
        let output = place.run(&command);
        assert_eq!(output.status.code(), Some(4), "{name}: {}", text(&output.stderr));
    }
}

#[test]
fn a_picture_has_title_instant_and_caption_where_they_are_asked_for() {
    let place = with_model();
    let mut command = place.bksim();
    command.args(["render", "model.toml", "-o", "a.svg", "--at", "0.25", "--time"]);
    let output = command.args(["--title", "Up & down", "--caption", "As drawn"]).output();
    let output = output.expect("bksim starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let svg = fs::read_to_string(place.path().join("a.svg")).expect("a picture");
    let document = roxmltree::Document::parse(&svg).expect("XML");
    let words: Vec<&str> = document
        .descendants()
        .filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")))
        .filter_map(|node| node.text())
        .collect();
    assert_eq!(words.first(), Some(&"Up & down"), "{words:?}");
    assert!(words[1].starts_with("t = 0.25"), "{words:?}");
    assert_eq!(words.last(), Some(&"As drawn"), "{words:?}");
    // A frame of a film has them, too: it is another one than without.
    for (name, words) in [("b.png", ""), ("c.png", " --time")] {
        let drawn =
            place.run(&format!("render model.toml -o {name} --size 160x120 --at 0.25{words}"));
        assert!(drawn.status.success(), "{}", text(&drawn.stderr));
    }
    let [b, c] = ["b.png", "c.png"].map(|name| fs::read(place.path().join(name)).expect("it"));
    assert!(b != c, "nothing is written");
}
