//! Every example as a picture, at its start and later.

use std::path::{Path, PathBuf};

use bksim::Mechanism;
use bksim::cad::model::ModelOptions;
use bksim::model::file::{Limits, expand};
use bksim::sim::pose::{Pose, Poses};
use bksim_scene::{Camera, Extras, Picture, Scene, Theme, picture, titled_svg};

/// A mechanism that has moved.
struct Moved {
    name: String,
    scene: Scene,
    motion: Vec<Vec<Pose>>,
}

fn path(relative: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(relative)
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).expect("a readable file")
}

/// The text of a model with the parts that it uses.
fn whole(path: &Path) -> String {
    let own = text(path);
    let mut read = |file: &str| Ok(text(&path.with_file_name(file)).into_bytes());
    expand("model.toml", &own, Limits::default(), &mut read).map_or(own, |whole| whole.text)
}

fn moved(name: &str, mechanism: &Mechanism) -> Moved {
    let motion = mechanism.solve().expect("a motion");
    let poses = Poses::compile(&mechanism.model, &mechanism.system).expect("poses");
    let every = (motion.samples.len() / 100).max(1);
    let states = motion.samples.iter().step_by(every).map(|s| (&s.q[..], &s.v[..]));
    let motion = poses.at(&mechanism.parameters, states);
    let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
    Moved { name: name.to_owned(), scene, motion }
}

/// The examples, from text and from drawings, and models with what these lack.
fn mechanisms() -> Vec<Moved> {
    let mut all = Vec::new();
    let mut folders: Vec<PathBuf> = std::fs::read_dir(path("examples"))
        .expect("the examples are there")
        .map(|entry| entry.expect("a readable entry").path())
        .collect();
    folders.sort();
    for folder in folders {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        if folder.join("model.toml").is_file() {
            let model = Mechanism::from_toml(&whole(&folder.join("model.toml")), &name);
            all.push(moved(&name, &model.expect("a model")));
        }
        if folder.join("drawing.dxf").is_file() {
            let bytes = std::fs::read(folder.join("drawing.dxf")).expect("a readable file");
            let side = folder.join("drawing.toml");
            let side = side.is_file().then(|| text(&side));
            let options = ModelOptions { sidecar: side.as_deref(), ..ModelOptions::default() };
            let model = bksim::mechanism_from_drawing(bytes, options, &name);
            all.push(moved(&format!("{name}-drawn"), &model.expect("a model")));
        }
    }
    let mut files: Vec<PathBuf> = std::fs::read_dir(path("crates/scene/tests/models"))
        .expect("the models are there")
        .map(|entry| entry.expect("a readable entry").path())
        .collect();
    files.sort();
    for file in files {
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let model = Mechanism::from_toml(&text(&file), &name);
        all.push(moved(&name, &model.expect("a model")));
    }
    all
}

/// Points of all shapes in the world.
fn points(moved: &Moved) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for poses in &moved.motion {
        for shape in &moved.scene.shapes {
            let reach = shape.form.reach().into_iter();
            points.extend(reach.map(|p| poses[shape.body].place(p)));
        }
    }
    points
}

fn drawn(moved: &Moved, theme: &Theme, size: [f64; 2], has_labels: bool) -> Picture {
    let camera =
        if moved.scene.is_planar { Camera::planar(size) } else { Camera::spatial(size, 0.6, 0.35) };
    let camera = camera.fitted(points(moved), 0.08);
    let extras = Extras { has_labels, ..Extras::default() };
    let mut picture = picture(&moved.scene, &moved.motion[0], &extras, &camera, theme);
    picture.items.extend(bksim_scene::scale_bar(&camera, theme));
    picture
}

#[test]
fn every_example_is_drawn() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gallery");
    std::fs::create_dir_all(&folder).expect("a folder");
    for moved in mechanisms() {
        let Moved { name, scene, motion } = &moved;
        assert_eq!(scene.bodies.len(), motion[0].len(), "{name}: a pose for each body");
        for body in 1..scene.bodies.len() {
            // The parts of a beam are on the spans of its name.
            let is_drawn = scene.shapes.iter().any(|shape| shape.body == body)
                || scene.spans.iter().any(|span| scene.bodies[body].starts_with(&span.name));
            assert!(is_drawn, "{name}: `{}` is not drawn", scene.bodies[body]);
        }
        let views = [
            ("light", &Theme::LIGHT, [720.0, 540.0], false),
            ("dark", &Theme::DARK, [720.0, 540.0], true),
            ("small", &Theme::LIGHT, [360.0, 270.0], true),
        ];
        for (view, theme, size, has_labels) in views {
            let picture = drawn(&moved, theme, size, has_labels);
            let text = titled_svg(&picture, name);
            roxmltree::Document::parse(&text).expect("valid XML");
            assert_eq!(text, titled_svg(&drawn(&moved, theme, size, has_labels), name));
            std::fs::write(folder.join(format!("{name}-{view}.svg")), text).expect("written");
        }
    }
}
