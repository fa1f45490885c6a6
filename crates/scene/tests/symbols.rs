//! Signs of drives, torques, stops and welds stand where the model has them; trails fade evenly.

use bksim_model::Model;
use bksim_model::file::{Source, read};
use bksim_scene::{Camera, Extras, Form, Item, Role, Scene, Theme, picture};
use bksim_sim::Mechanism;
use bksim_sim::pose::Pose;

fn scene(text: &str) -> Scene {
    let reading = read(&Source::new(text, "test"));
    let model: Model = reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    Scene::of(&model, &parameters)
}

/// Two cranks and a slider on the ground, with more sections of the model in `more`.
fn cranks(more: &str) -> Scene {
    let crank = |name: &str| {
        format!(
            "[bodies.{name}]\nmass = 1\ninertia = 0.1\npoints = {{ P = [0, 0], E = [1, 0] }}\n\
             [joints.{name}_pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"{name}.P\"]\n"
        )
    };
    let slider = "[bodies.block]\nmass = 1\n[joints.guide]\ntype = \"prismatic\"\n\
                  between = [\"ground\", \"block\"]\naxis = [1, 0]\n";
    scene(&[&crank("a"), &crank("b"), slider, more].concat())
}

fn of_role(scene: &Scene, role: Role) -> Vec<(usize, Vec<[f64; 3]>)> {
    let shapes = scene.shapes.iter().filter(|shape| shape.role == role);
    shapes.map(|shape| (shape.body, shape.form.reach())).collect()
}

/// Least and largest of a coordinate.
fn extent(points: &[[f64; 3]], axis: usize) -> [f64; 2] {
    let values = || points.iter().map(|p| p[axis]);
    [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
}

#[test]
fn a_model_without_drives_torques_and_welds_has_no_signs_of_them() {
    let scene = cranks("");
    for role in [Role::Drive, Role::Torque, Role::Weld] {
        assert_eq!(of_role(&scene, role), [], "{role:?}");
    }
}

#[test]
fn a_driven_joint_has_an_arrow_about_it_and_a_driven_slider_one_next_to_it() {
    let scene = cranks(
        "[drives.m]\njoint = \"a_pin\"\nmotion = \"1 rad/s*t\"\n\
         [drives.n]\njoint = \"guide\"\nmotion = \"1 m/s*t\"\n",
    );
    let drawn = of_role(&scene, Role::Drive);
    // Motor, arc and head on the ground; shaft and head on the block.
    assert_eq!(drawn.iter().map(|(body, _)| *body).collect::<Vec<_>>(), [0, 0, 0, 3, 3]);
    // The arrow runs anticlockwise about the pin: its head is at its left end, and points down.
    let [arc, head] = [&drawn[1].1, &drawn[2].1];
    assert!(arc.iter().all(|p| (p[0].hypot(p[1]) - 5.2 * scene.pin).abs() < 1e-9));
    assert!(extent(head, 0)[1] < -3.0 * scene.pin && head[0][1] < head[1][1], "{head:?}");
    // That of the block is above it, and points to where its position grows.
    let [shaft, head] = [&drawn[3].1, &drawn[4].1];
    assert!(extent(head, 0)[1] > extent(shaft, 0)[1] && extent(shaft, 1)[0] > 2.7 * scene.pin);
}

#[test]
fn a_torque_has_its_arrow_about_the_joint_it_acts_in() {
    let scene = cranks("[loads.t]\ntype = \"torque\"\non = \"b\"\nvalue = 1\n");
    let drawn = of_role(&scene, Role::Torque);
    assert_eq!(drawn.len(), 2);
    assert!(drawn[0].1.iter().all(|p| (p[0].hypot(p[1]) - 6.6 * scene.pin).abs() < 1e-9));
}

#[test]
fn the_arrow_of_a_torque_turns_in_its_sense() {
    // The middle of the head, left of the joint where the torque is anticlockwise: the arrow is above or below it.
    let head = |value: &str| {
        let scene = cranks(&format!("[loads.t]\ntype = \"torque\"\non = \"b\"\nvalue = {value}\n"));
        let points = of_role(&scene, Role::Torque)[1].1.clone();
        let [x, y] = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / 3.0);
        [x * y.signum(), y]
    };
    let [with, against] = [head("1"), head("-0.3")];
    assert!(with[0] < 0.0 && (with[0] + against[0]).abs() < 1e-9, "{with:?} {against:?}");
    assert!((with[1] - against[1]).abs() < 1e-9, "{with:?} {against:?}");
    // What begins below zero, and what is known with the motion alone.
    assert!((head("\"-1 N m + t*(1 N m/s)\"")[0] - against[0]).abs() < 1e-9);
    assert!((head("\"-b_pin.rate*(1 N m s)\"")[0] - with[0]).abs() < 1e-9);
}

#[test]
fn bodies_that_move_as_one_are_joined_by_a_solid_square() {
    let weld = |other: &str| {
        let model = "[bodies.c]\nmass = 1\n[joints.w]\ntype = \"weld\"\nbetween = ";
        of_role(&cranks(&format!("{model}[\"{other}\", \"c\"]\n")), Role::Weld).len()
    };
    assert_eq!(weld("a.E"), 1);
    // A weld to the ground has a wall.
    assert_eq!(weld("ground"), 0);
}

/// Lines of the ground that a stop adds, the hatching left out.
fn stop_lines(load: &str) -> (Scene, Vec<Vec<[f64; 3]>>) {
    let (without, with) = (cranks(""), cranks(load));
    let known = of_role(&without, Role::Guide);
    let added = of_role(&with, Role::Guide).into_iter().filter(|line| !known.contains(line));
    let added: Vec<Vec<[f64; 3]>> = added.map(|(_, points)| points).collect();
    (with, added)
}

#[test]
fn stops_stand_where_the_edge_of_a_slider_gets_to() {
    let stop = "[loads.s]\ntype = \"stop\"\njoint = \"guide\"\nmin = -0.3\nmax = 0.5\n";
    let (scene, lines) = stop_lines(stop);
    let edge = 4.2 * scene.pin;
    let extents: Vec<[f64; 2]> = lines.iter().map(|line| extent(line, 0)).collect();
    assert_eq!(extents.len(), 2);
    for ([low, high], x) in extents.into_iter().zip([-0.3 - edge, 0.5 + edge]) {
        assert!((low - x).abs() < 1e-9 && (high - x).abs() < 1e-9, "{low} to {high}, not {x}");
    }
}

#[test]
fn stops_lie_along_a_crank_that_is_turned_so_far() {
    let stop =
        "[loads.s]\ntype = \"stop\"\njoint = \"a_pin\"\nmin = \"-20 deg\"\nmax = \"100 deg\"\n";
    let (scene, lines) = stop_lines(stop);
    assert_eq!(lines.len(), 2);
    for (line, (angle, side)) in lines.iter().zip([(-20_f64, -1.0), (100_f64, 1.0)]) {
        let (sin, cos) = angle.to_radians().sin_cos();
        for [x, y, _] in line {
            let (along, across) = (cos * x + sin * y, cos * y - sin * x);
            assert!(along > 0.0, "{line:?}");
            // The edge of the crank: half its width from its middle line, on the far side.
            assert!((across - side * 1.8 * scene.pin).abs() < 1e-9, "{angle}°: {line:?}");
        }
    }
}

#[test]
fn a_trail_fades_evenly_and_no_part_of_it_is_painted_darker() {
    let scene = cranks("");
    let theme = Theme::LIGHT;
    let path: Vec<[f64; 3]> = (0..=120).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    let extras = Extras { trails: vec![(theme.force, path)], ..Extras::default() };
    let camera = Camera { scale: 1.0, ..Camera::planar([400.0, 300.0]) };
    let drawn = picture(&scene, &[Pose::default(); 4], &extras, &camera, &theme);
    let bare = picture(&scene, &[Pose::default(); 4], &Extras::default(), &camera, &theme);
    let glazes = drawn.items.len() - bare.items.len();
    // Opacity of the trail at each of its points: all lines that cover it, over each other.
    for i in 0..120_u8 {
        let x = 200.0 + f32::from(i) + 0.5;
        let mut clear = 1.0;
        for item in &drawn.items[..glazes] {
            let Item::Line { points, stroke, .. } = item else { panic!("{item:?}") };
            if points[0][0] <= x && points[points.len() - 1][0] >= x {
                clear *= 1.0 - stroke.color.opacity();
            }
        }
        let expected = f32::from(i / 10 + 1) / 12.0;
        let found = 1.0 - clear;
        assert!((found - expected).abs() < 0.01, "{i}: {found} instead of {expected}");
    }
}

#[test]
fn a_sign_on_a_rod_is_painted_over_all_of_it() {
    let rod = |role, x: f64| bksim_scene::Shape {
        body: 0,
        role,
        form: Form::Rod { ends: [[x, 0.0, 0.0]; 2], radius: 0.1 },
    };
    let shapes = vec![rod(Role::Body(0), 1.0), rod(Role::Pin, 0.0), rod(Role::Pin, 3.0)];
    let scene = Scene { bodies: vec!["a".into()], shapes, pin: 0.1, ..Scene::default() };
    let depths = scene.depths(&[1.0, 0.0, 3.0], &[], &[[0.0; 3]; 3]);
    assert_eq!(depths, [1.0, 1.1, 3.1]);
}

#[test]
fn a_slide_in_space_lies_along_its_axis_in_both_bodies_and_its_guide_reaches_as_far_as_it_goes() {
    for kind in ["prismatic", "cylindrical"] {
        // The guide's point is turned against its body, that of the block is not.
        let scene = scene(&format!(
            r#"
            space = "spatial"
            [bodies]
            arm = {{ mass = 1, inertia = [0.1, 0.1, 0.1], points = {{ A = {{ at = [0.2, 0, 0], rpy = [0, 0, "90 deg"] }} }} }}
            block = {{ mass = 1, inertia = [0.1, 0.1, 0.1] }}
            [joints]
            turn = {{ type = "revolute", between = ["ground", "arm"] }}
            slide = {{ type = "{kind}", between = ["arm.A", "block"], axis = [1, 0, 0] }}
            [initial]
            slide = {{ position = 0.3 }}
            "#
        ));
        let reach = |body: usize, axis: usize| {
            let own = scene.shapes.iter().filter(|shape| shape.body == body);
            let drawn = own.filter(|shape| matches!(shape.role, Role::Body(_)));
            let points: Vec<[f64; 3]> = drawn.flat_map(|shape| shape.form.reach()).collect();
            extent(&points, axis)
        };
        // Along x of the point, which is y of the arm.
        let [low, high] = reach(1, 1);
        assert!(low < 0.0 && high > 0.3 + scene.pin, "{kind}: from {low} to {high}");
        let [x, y, z] = [0, 1, 2].map(|axis| reach(2, axis)).map(|[low, high]| high - low);
        assert!(x > 1.4 * y && (y - z).abs() < 1e-12, "{kind}: {x} by {y} by {z}");
    }
}

#[test]
fn a_torque_that_changes_its_sense_turns_its_arrow_over() {
    let text = "[bodies.a]\nmass = 1\ninertia = 0.1\npoints = { P = [0, 0], E = [1, 0] }\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"a.P\"]\n\
                [loads.m]\ntype = \"torque\"\non = \"a\"\nvalue = \"2 N*m*cos(1 rad/s*t)\"\n";
    let mechanism = Mechanism::from_toml(text, "cosine").expect("a model");
    let mut scene = Scene::of(&mechanism.model, &mechanism.parameters);
    let mut torques = scene.torques(&mechanism).expect("compiles").expect("a sign");
    let mut at = |t: f64| torques.at((t, &[0.0], &[0.0]), &[]).to_vec();
    let before = of_role(&scene, Role::Torque);
    // The arrow about the upper side of the pin is its own mirror image in x.
    scene.turn(&at(2.0));
    for ((_, old), (_, new)) in before.iter().zip(of_role(&scene, Role::Torque)) {
        assert!(
            old.iter()
                .zip(&new)
                .all(|(p, q)| { (p[0] + q[0]).abs() < 1e-12 && (p[1] - q[1]).abs() < 1e-12 })
        );
    }
    assert_ne!(before, of_role(&scene, Role::Torque));
    assert!(!scene.is_turned_by(&at(4.0)), "still against the angle");
    let instants: Vec<_> = (0..=70).map(|k| 0.1 * f64::from(k)).map(|t| (t, at(t))).collect();
    let [times] = &scene.turn_times(&instants)[..] else { panic!("one sign") };
    assert!(!times.is_over && times.times.len() == 2);
    for (found, exact) in times.times.iter().zip([0.5, 1.5].map(|part| part * std::f64::consts::PI))
    {
        assert!((found - exact).abs() < 1e-3, "{found} is not {exact}");
    }
}
