//! Models without lengths, with absurd ones, and with many bodies.

use std::fmt::Write;

use bksim_model::Model;
use bksim_model::file::{Source, read};
use bksim_scene::{Arrow, Camera, CutSide, Extras, Scene, Section, Theme, picture, svg};
use bksim_sim::pose::Pose;

const SLIDER: &str = include_str!("../../../tests/fixtures/oblique-slider.toml");

fn model(text: &str) -> Model {
    let reading = read(&Source::new(text, "test"));
    reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
}

fn points(scene: &Scene) -> Vec<[f64; 3]> {
    scene.shapes.iter().flat_map(|shape| shape.form.reach()).collect()
}

/// Draws a scene with everything at the ground's pose.
fn drawn(scene: &Scene, poses: &[Pose]) -> String {
    let theme = &Theme::LIGHT;
    let arrow = |color, from, vector| Arrow { color, from, vector, is_hollow: false };
    let hollow = |color, from, vector| Arrow { color, from, vector, is_hollow: true };
    let extras = Extras {
        has_labels: true,
        trails: vec![(theme.force, vec![[0.0; 3], [f64::NAN; 3], [1e300; 3]])],
        arrows: vec![
            arrow(theme.force, [0.0; 3], [0.0; 3]),
            arrow(theme.force, [0.0; 3], [f64::NAN, 1.0, 0.0]),
            arrow(theme.velocity, [1e300; 3], [1e300; 3]),
            hollow(theme.force, [0.0; 3], [0.0; 3]),
            hollow(theme.force, [0.0; 3], [f64::NAN, 1.0, 0.0]),
            hollow(theme.force, [1e300; 3], [1e300; 3]),
        ],
        ghosts: vec![poses.to_vec(), Vec::new()],
        section: Section::new([1.0, 0.3, 0.2], [0.0; 3], CutSide::Nearer),
        ..Extras::default()
    };
    let camera = Camera::planar([400.0, 300.0]).fitted(points(scene), 0.1);
    let text = svg(&picture(scene, poses, &extras, &camera, theme));
    roxmltree::Document::parse(&text).expect("valid XML");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    text
}

#[test]
fn no_value_of_a_length_makes_a_scene_panic_or_hold_what_is_no_number() {
    let model = model(SLIDER);
    let l = [1.0, 1e-6, 1e6, 0.0, -1.0, 1e300, -1e300, 1e-300, f64::NAN, f64::INFINITY];
    for l in l {
        let scene = Scene::of(&model, &[l]);
        assert!(scene.pin > 0.0 && scene.pin.is_finite(), "pin {} at l = {l}", scene.pin);
        assert!(points(&scene).iter().flatten().all(|x| x.is_finite()), "at l = {l}");
        let wild = Pose { origin: [f64::NAN, 1e300, -1e300], ..Pose::default() };
        // In space, it is cut by a plane.
        let spatial = Scene { is_planar: false, ..scene.clone() };
        for scene in [scene, spatial] {
            drawn(&scene, &[Pose::default(); 4]);
            drawn(&scene, &[wild; 4]);
            drawn(&scene, &[]);
        }
    }
}

#[test]
fn a_scene_grows_with_the_mechanism() {
    let model = model(SLIDER);
    let one = Scene::of(&model, &[1.0]);
    for factor in [1e-6, 1e-3, 1e3, 1e6] {
        let other = Scene::of(&model, &[factor]);
        assert!((other.pin / (factor * one.pin) - 1.0).abs() < 1e-12);
        let pairs = points(&one).into_iter().zip(points(&other));
        for (a, b) in pairs {
            let close = (0..3).all(|i| (b[i] - factor * a[i]).abs() < 1e-9 * factor);
            assert!(close, "{a:?} times {factor} is not {b:?}");
        }
    }
}

#[test]
fn a_body_without_any_length_is_a_disc() {
    let text =
        "[bodies.a]\nmass = 1\nfree = true\n[bodies.b]\nmass = 1\ninertia = 1\nfree = true\n";
    let scene = Scene::of(&model(text), &[]);
    assert_eq!(scene.shapes.iter().filter(|s| s.body == 1).count(), 1);
    assert!(scene.pin > 0.0);
    drawn(&scene, &[Pose::default(); 3]);
}

#[test]
fn a_chain_of_a_thousand_links_is_a_thousand_links() {
    let mut text = String::new();
    for i in 1..=1000 {
        let before = if i == 1 { "ground".into() } else { format!("b{}.E", i - 1) };
        write!(
            text,
            "[bodies.b{i}]\nmass = 1\ninertia = 1\ncom = [0.5, 0]\npoints = {{ O = [0, 0], E = [1, 0] }}\n\
             [joints.j{i}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{i}.O\"]\n"
        )
        .expect("text takes everything");
    }
    let scene = Scene::of(&model(&text), &[]);
    assert!((scene.pin - 0.03).abs() < 1e-12);
    // A link, the two halves of its centre of mass, and its pin.
    let on_last = scene.shapes.iter().filter(|s| s.body == 1000).count();
    assert_eq!(on_last, 4);
    drawn(&scene, &vec![Pose::default(); 1001]);
}

#[test]
fn neighbours_have_different_colours() {
    let scene = Scene::of(&model(SLIDER), &[1.0]);
    let colours: Vec<_> =
        (1..4).map(|body| scene.shapes.iter().find(|s| s.body == body).map(|s| s.role)).collect();
    assert!(colours[0] != colours[1] && colours[1] != colours[2], "{colours:?}");
}
