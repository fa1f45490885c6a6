//! Shapes of bodies as solids: closed, seen from outside, and hiding what is behind them.

use bksim_model::file::{Source, read};
use bksim_scene::{Camera, Extras, Form, Item, Scene, Solid, Theme, picture};
use bksim_sim::pose::Pose;

/// The scene of bodies with these shapes, one body each.
fn scene(shapes: &[&str]) -> Scene {
    let bodies: Vec<String> = shapes
        .iter()
        .enumerate()
        .map(|(i, shape)| {
            format!("[bodies.b{i}]\ndensity = 1000\nfree = true\nshapes = [{shape}]\n")
        })
        .collect();
    let text = format!("space = \"spatial\"\n{}", bodies.concat());
    let reading = read(&Source::new(&text, "solids"));
    let model = reading.model.unwrap_or_else(|| panic!("{:#?}", reading.diagnostics));
    Scene::of(&model, &[])
}

fn solids(scene: &Scene) -> Vec<&Solid> {
    let forms = scene.shapes.iter().map(|shape| &shape.form);
    forms
        .filter_map(|form| if let Form::Solid(solid) = form { Some(solid) } else { None })
        .collect()
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// The volume inside faces that are counter-clockwise from outside, by the divergence theorem.
fn volume(solid: &Solid) -> f64 {
    let fan = |face: &Vec<usize>| {
        let corner = |i: usize| solid.corners[face[i]];
        (1..face.len() - 1)
            .map(|i| dot(corner(0), cross(corner(i), corner(i + 1))) / 6.0)
            .sum::<f64>()
    };
    solid.faces.iter().map(fan).sum()
}

#[test]
fn shapes_are_closed_and_have_their_volume() {
    let frame = "at = [0.3, -2, 1], rpy = [0.4, 1.2, -0.7]";
    let scene = scene(&[
        &format!("{{ type = \"box\", size = [0.3, 0.2, 0.1], {frame} }}"),
        &format!("{{ type = \"cylinder\", radius = 0.2, length = 0.5, {frame} }}"),
        &format!(
            "{{ type = \"plate\", outline = [[0, 0], [0, 1], [2, 0]], thickness = 0.1, {frame} }}"
        ),
    ]);
    let n_edges = |solid: &Solid| solid.faces.iter().map(Vec::len).sum::<usize>() / 2;
    let expected = [(0.006, 1e-12), (std::f64::consts::PI * 0.02, 1e-2), (0.1, 1e-12)];
    let found = solids(&scene);
    assert_eq!(found.len(), 3);
    for (solid, (volume_m3, tolerance)) in found.iter().zip(expected) {
        assert!((volume(solid) / volume_m3 - 1.0).abs() < tolerance, "{}", volume(solid));
        assert_eq!(solid.edges.len(), n_edges(solid), "each edge belongs to two faces");
    }
}

#[test]
fn a_box_shows_three_faces_and_nine_edges_and_is_shaded_by_the_light() {
    let scene = scene(&["{ type = \"box\", size = [1, 1, 1] }"]);
    let [solid] = solids(&scene)[..] else { panic!("one solid") };
    let camera = Camera::spatial([200.0, 200.0], 0.6, 0.5);
    let faces = solid.seen(|p| p, &camera);
    assert_eq!(faces.len(), 3);
    assert_eq!(faces.iter().map(|face| face.edges.len()).sum::<usize>(), 9);
    let shades: Vec<f32> = faces.iter().map(|face| face.shade).collect();
    assert!(shades.iter().all(|shade| (0.0..=1.0).contains(shade)));
    assert!(shades[0] != shades[1] && shades[1] != shades[2], "{shades:?}");
    // From above, one.
    let above = Camera::spatial([200.0, 200.0], 0.0, std::f64::consts::FRAC_PI_2);
    assert_eq!(solid.seen(|p| p, &above).len(), 1);
}

/// A small box at the far end of a long plate is farther from the eye than the middle of the plate, and
/// yet in front of it.
#[test]
fn what_stands_on_a_plate_hides_it_wherever_it_stands() {
    for x in [-4.0, 0.0, 4.0] {
        let scene = scene(&[
            &format!("{{ type = \"box\", size = [0.5, 0.5, 0.5], at = [{x}, 0, 0.35] }}"),
            "{ type = \"box\", size = [10, 2, 0.2] }",
        ]);
        let poses = vec![Pose::default(); 3];
        for step in 0..12 {
            let azimuth = f64::from(step) * std::f64::consts::FRAC_PI_6;
            for (elevation, is_box_first) in [(0.4, false), (-0.4, true)] {
                let points = scene.shapes.iter().flat_map(|shape| shape.form.reach());
                let camera =
                    Camera::spatial([400.0, 400.0], azimuth, elevation).fitted(points, 0.1);
                let middles: Vec<f64> = scene
                    .shapes
                    .iter()
                    .map(|shape| match &shape.form {
                        Form::Solid(solid) => camera.project(solid.middle())[2],
                        _ => 0.0,
                    })
                    .collect();
                let depths = scene.depths(&middles, &poses, &camera.r_view_from_world);
                let solid = |body: usize| {
                    let is_its = |shape: &&bksim_scene::Shape| {
                        shape.body == body && matches!(shape.form, Form::Solid(_))
                    };
                    scene.shapes.iter().position(|shape| is_its(&shape)).expect("a solid")
                };
                let [small, plate] = [1, 2].map(|body| depths[solid(body)]);
                assert_eq!(small < plate, is_box_first, "{x} {azimuth} {elevation}");
            }
        }
    }
}

#[test]
fn faces_of_a_solid_are_painted_in_different_colours() {
    let scene = scene(&["{ type = \"cylinder\", radius = 0.3, length = 1 }"]);
    let camera = Camera::spatial([200.0, 200.0], 0.6, 0.5);
    let drawn = picture(&scene, &[Pose::default(); 2], &Extras::default(), &camera, &Theme::LIGHT);
    let mut fills: Vec<_> = drawn
        .items
        .iter()
        .filter_map(
            |item| if let Item::Region { fill, .. } = item { Some(fill.hex()) } else { None },
        )
        .collect();
    fills.sort();
    fills.dedup();
    assert!(fills.len() > 10, "{fills:?}");
}

/// Symbols are in proportion to bodies that have nothing but shapes.
#[test]
fn a_body_of_shapes_alone_has_small_symbols() {
    for size in [0.01, 1.0, 100.0] {
        let scene = scene(&[&format!("{{ type = \"box\", size = [{size}, {size}, {size}] }}")]);
        assert!(scene.pin < 0.1 * size, "a pin of {} m on a box of {size} m", scene.pin);
        assert!(scene.pin > 0.01 * size);
    }
}
