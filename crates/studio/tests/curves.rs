//! Curves, polygons and modes as the commands write them: numbers, pictures, films, pages, drawings.

use std::fs;

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

/// The four-bar of the examples, which has masses and gravity, and its run.
fn with_run() -> Scratch {
    let place = Scratch::new();
    let example = format!("{CRATE}/../../examples/four-bar");
    for name in ["model.toml", "drawing.dxf", "drawing.toml"] {
        place.write(name, fs::read(format!("{example}/{name}")).expect("an example"));
    }
    succeeds(&place, "solve model.toml -o run.mcap");
    place
}

fn succeeds(place: &Scratch, command: &str) -> String {
    let output = place.run(command);
    assert!(output.status.success(), "{command}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn json(place: &Scratch, command: &str) -> Value {
    serde_json::from_str(&succeeds(place, &format!("{command} --json"))).expect("one object")
}

fn read(place: &Scratch, name: &str) -> String {
    fs::read_to_string(place.path().join(name)).expect(name)
}

#[test]
fn curves_are_told_and_written() {
    let place = with_run();
    let told = succeeds(&place, "curves model.toml --point C --centrode coupler --swept rocker");
    assert!(
        told.contains("instant centre at the start") && told.contains("rocker sweeps"),
        "{told}"
    );
    let answer = json(&place, "curves model.toml --point C --centrode coupler -o curves.csv");
    let points = answer["points"][0]["branches"][0]["points"].as_array().expect("points");
    assert!(points.len() > 50, "{answer}");
    let rows = read(&place, "curves.csv").lines().count();
    assert!(
        rows > points.len() && read(&place, "curves.csv").starts_with("curve,branch,piece,x,y,z")
    );
    let refused = place.run("curves model.toml --point coupler.nothing");
    assert!(text(&refused.stderr).contains("error[Q002]"), "{}", text(&refused.stderr));
    let refused = place.run("curves model.toml --workspace C");
    assert!(text(&refused.stderr).contains("error[Q003]"), "{}", text(&refused.stderr));
}

#[test]
fn curves_are_laid_over_pictures_pages_and_drawings() {
    let place = with_run();
    let n_lines = |name: &str| read(&place, name).matches("<path").count();
    succeeds(&place, "render run.mcap -o plain.svg");
    let curves = "--curve C --curve centrode:coupler --curve swept:rocker";
    succeeds(&place, &format!("render run.mcap -o laid.svg {curves}"));
    succeeds(&place, &format!("render model.toml -o model.svg {curves}"));
    assert!(n_lines("laid.svg") >= n_lines("plain.svg") + 4, "a way, two centrodes, a region");
    assert_eq!(n_lines("laid.svg"), n_lines("model.svg"));
    let refused = place.run("render run.mcap -o no.svg --curve nothing");
    assert!(text(&refused.stderr).contains("called `nothing`"), "{}", text(&refused.stderr));

    succeeds(&place, "page run.mcap -o plain.html");
    succeeds(&place, &format!("page run.mcap -o laid.html {curves}"));
    assert!(read(&place, "laid.html").len() > read(&place, "plain.html").len() + 1000);

    succeeds(&place, "solve drawing.toml -o drawn.mcap");
    succeeds(&place, &format!("cad trace drawn.mcap drawing.dxf -o traced.dxf {curves}"));
    let traced = read(&place, "traced.dxf");
    for layer in ["BK_TRACE_CURVES", "BK_TRACE_CENTRODES", "BK_TRACE_REGIONS"] {
        assert!(traced.matches(layer).count() >= 2, "the layer and what is on it: {layer}");
    }
}

#[test]
fn polygons_are_drawn_in_every_format() {
    let place = with_run();
    let pose = "polygons model.toml --drive A.angle=40deg --rate 25 --acceleration 15";
    let answer = json(&place, pose);
    let vectors = answer["acceleration"]["vectors"].as_array().expect("vectors");
    assert!(vectors.iter().any(|v| v["name"] == "a_C/B n"), "{answer}");
    for (name, start) in [("p.svg", &b"<svg"[..]), ("p.png", b"\x89PNG"), ("p.pdf", b"%PDF")] {
        succeeds(&place, &format!("{pose} -o {name}"));
        let bytes = fs::read(place.path().join(name)).expect("a picture");
        assert!(bytes.starts_with(start), "{name}");
    }
    let drawn = read(&place, "p.svg");
    for word in ["velocities", "accelerations", "v_C/B", "a_C/B t"] {
        assert!(drawn.contains(word), "{word}");
    }
}

#[test]
fn modes_are_shown_as_pictures_films_and_pages() {
    let place = Scratch::new();
    let model = r#"
[bodies.upper]
mass = 1
com = [0, -1]
points = { E = [0, -1] }
[bodies.lower]
mass = 1
com = [0, -1]
[joints]
A = { type = "revolute", between = ["ground", "upper"] }
B = { type = "revolute", between = ["upper.E", "lower"] }
[loads]
gravity = { type = "gravity", acceleration = [0, -9.81] }
[solve]
t_end = 0.1
"#;
    place.write("double.toml", model);
    succeeds(&place, "modes double.toml -o first.svg");
    succeeds(&place, "modes double.toml -o second.svg --mode 2 --amplitude 20deg");
    assert!(read(&place, "first.svg") != read(&place, "second.svg"));
    let film = json(&place, "modes double.toml -o film.gif --mode 2");
    assert_eq!(film["frames"], 49, "{film}");
    succeeds(&place, "render double.toml --mode 1 -o render.svg --labels");
    succeeds(&place, "solve double.toml -o run.mcap");
    succeeds(&place, "page run.mcap --mode 2 -o mode.html");
    let refused = place.run("modes double.toml -o third.svg --mode 3");
    assert!(text(&refused.stderr).contains("no mode 3, of 2"), "{}", text(&refused.stderr));
}

#[test]
fn assemblies_and_free_motions_are_drawn_in_every_format() {
    let place = with_run();
    for (name, start) in [("w.svg", &b"<svg"[..]), ("w.png", b"\x89PNG"), ("w.pdf", b"%PDF")] {
        let told = succeeds(&place, &format!("kinematics model.toml --assemblies -o {name}"));
        assert!(told.contains(&format!("wrote {name}: 2 assemblies")), "{told}");
        let bytes = fs::read(place.path().join(name)).expect("a picture");
        assert!(bytes.starts_with(start), "{name}");
    }
    let drawn = read(&place, "w.svg");
    assert!(drawn.contains("1  A-B-C-D open") && drawn.contains("2  A-B-C-D crossed"));
    assert!(!drawn.contains("animation"), "assemblies stand");

    succeeds(&place, "doctor model.toml -o m.svg");
    succeeds(&place, "doctor model.toml -o m.png");
    let moving = read(&place, "m.svg");
    assert!(moving.contains("free motion 1: "), "a name");
    assert_eq!(moving.matches("animation-delay").count(), 24, "frames");
}
