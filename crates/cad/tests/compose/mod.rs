//! Models of drawings: partners, frames, points taken as one, masses, sidecars.
//!
//! The drawings are plain data here; reading them from files has its own tests.

mod elements;
mod sheet;

use bksim_cad::compose::{ComposeOptions, Composition, Origin};
use bksim_cad::drawing::{Shape, XValue};
use bksim_cad::geometry::{Curve, Path, Point};
use bksim_model::file::{Source, read};
use bksim_model::{JointKind, Model, Vector};
use sheet::{Sheet, two_bars};

fn model_of(composition: &Composition) -> Model {
    assert!(
        composition.diagnostics.iter().all(|fault| !fault.is_error()),
        "{:#?}",
        composition.diagnostics
    );
    let reading = read(&Source::new(&composition.text, "sheet"));
    reading.model.unwrap_or_else(|| panic!("{}\n{:#?}", composition.text, reading.diagnostics))
}

fn codes(composition: &Composition) -> Vec<&'static str> {
    composition.diagnostics.iter().map(|fault| fault.code.0).collect()
}

fn values(model: &Model, vector: Vector) -> [f64; 3] {
    let of = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    vector.map(|expr| model.pool.evaluate(expr, &of).expect("a number"))
}

/// Masses of all bodies but the ground, kg.
fn masses(model: &Model) -> Vec<f64> {
    model.bodies[1..].iter().map(|body| values(model, [body.mass; 3])[0]).collect()
}

fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs(), "{value} and {expected}");
}

const SIDECAR: &str = "\
[bodies.crank]
mass = \"2 kg\"

[bodies.rod]
density = \"7850 kg/m^3\"
thickness = \"5 mm\"
";

#[test]
fn a_circle_where_two_bodies_meet_is_a_revolute_named_by_the_text_next_to_it() {
    let model = model_of(&two_bars().compose_with(SIDECAR));
    let joints: Vec<(&str, usize, usize)> = model
        .joints
        .iter()
        .map(|joint| (joint.name.as_str(), joint.predecessor.body.0, joint.successor.body.0))
        .collect();
    assert_eq!(joints, [("A", 0, 1), ("B", 1, 2)]);
    assert!(model.joints.iter().all(|joint| joint.kind == JointKind::Revolute));
}

#[test]
fn a_frame_begins_at_the_joint_with_the_ground_and_points_to_the_next() {
    let model = model_of(&two_bars().compose_with(SIDECAR));
    let point = |body: usize, name: &str| {
        let mut points = model.bodies[body].points.iter();
        values(&model, points.find(|point| point.name == name).expect("a point").position)
    };
    assert_eq!(point(1, "A"), [0.0, 0.0, 0.0]);
    assert_eq!(point(1, "B"), [0.1, 0.0, 0.0]);
    // The rod has no second joint: its axes are those of the world.
    assert_eq!(point(2, "B"), [0.0, 0.0, 0.0]);
}

/// Area and polar moment about the middle of a rounded bar with two holes, by its parts.
fn bar_moments(l: f64, r: f64) -> (f64, f64) {
    let pi = std::f64::consts::PI;
    let hole = r / 3.0;
    let area = 2.0 * r * l + pi * r * r - 2.0 * pi * hole * hole;
    let middle = 2.0 * r * l * (l * l + 4.0 * r * r) / 12.0;
    // A half disc about its own centroid, moved out to its end of the bar.
    let (disc, centroid) = (pi * r * r / 2.0, 4.0 * r / (3.0 * pi));
    let own = pi * r.powi(4) / 4.0 - disc * centroid * centroid;
    let ends = 2.0 * (own + disc * (l / 2.0 + centroid).powi(2));
    let holes = 2.0 * pi * hole * hole * (hole * hole / 2.0 + l * l / 4.0);
    (area, middle + ends - holes)
}

#[test]
fn a_stated_mass_comes_before_a_computed_one_and_keeps_the_shape() {
    let model = model_of(&two_bars().compose_with(SIDECAR));
    let [crank, rod] = masses(&model)[..] else { panic!("two bodies") };
    assert_eq!(crank, 2.0);
    let (area, polar) = bar_moments(100.0, 10.0);
    let inertia = values(&model, model.bodies[1].inertia.moments)[2];
    assert_close(inertia, 2.0 * polar / area * 1e-6, 1e-12);

    let (area, polar) = bar_moments(220.0, 8.0);
    assert_close(rod, 7850.0 * 0.005 * area * 1e-6, 1e-12);
    let inertia = values(&model, model.bodies[2].inertia.moments)[2];
    assert_close(inertia, 7850.0 * 0.005 * polar * 1e-12, 1e-12);
}

#[test]
fn a_value_of_the_sidecar_is_found_there_and_one_of_the_drawing_in_its_entity() {
    let composition = two_bars().compose_with(SIDECAR);
    let at = composition.text.find("\"2 kg\"").expect("the mass");
    let here = SIDECAR.find("\"2 kg\"").expect("the mass");
    assert_eq!(composition.origin(&(at..at + 6)), Origin::Sidecar(here..here + 6));
    // A part of the value, too.
    assert_eq!(composition.origin(&(at + 1..at + 2)), Origin::Sidecar(here + 1..here + 2));
    let joint = composition.text.find("\"crank.B\"").expect("the joint");
    let Origin::Drawing(location) = composition.origin(&(joint..joint + 9)) else {
        panic!("a joint comes from the drawing")
    };
    assert_eq!((location.kind.as_str(), location.at), ("CIRCLE", [80.0, 60.0]));
}

/// An arm whose hole is `offset` away from the joint with the ground.
fn arm_off_its_joint(offset: f64) -> Composition {
    let mut sheet = Sheet::default();
    sheet.circle("BK_GROUND", [0.0, 0.0], 5.0);
    sheet.bar("BK_BODY_arm", [offset, 0.0], [300.0, 0.0], 10.0);
    sheet.circle("BK_JOINTS", [0.0, 0.0], 4.0);
    sheet.compose_with("[bodies.arm]\nmass = 1\n")
}

#[test]
fn points_within_the_tolerance_are_one_and_listed() {
    let composition = arm_off_its_joint(0.02);
    assert_eq!(codes(&composition), ["D040"]);
    let snap = &composition.snaps[0];
    assert_eq!((snap.from, snap.to), ([0.02, 0.0], [0.0, 0.0]));
    assert_close(snap.distance, 0.02, 1e-14);
    model_of(&composition);
    // Rounding is not worth a word.
    assert_eq!(codes(&arm_off_its_joint(1e-12)), Vec::<&str>::new());
}

#[test]
fn a_hole_beyond_the_tolerance_is_not_moved_but_mentioned() {
    let composition = arm_off_its_joint(0.5);
    assert_eq!(codes(&composition), ["D041"]);
    assert!(composition.snaps.is_empty());
}

#[test]
fn two_points_of_a_body_within_the_tolerance_are_ambiguous() {
    let mut sheet = two_bars();
    sheet.circle("BK_BODY_rod", [80.02, 60.0], 1.0);
    let composition = sheet.compose_with(SIDECAR);
    assert!(codes(&composition).contains(&"D042"), "{:#?}", composition.diagnostics);
    assert!(composition.text.is_empty());
}

/// Three bars, with holes or as plain rectangles, and a joint where they meet.
fn three_bars(has_holes: bool, names: &[(&str, &str)]) -> Composition {
    let mut sheet = Sheet::default();
    for (body, end) in [("a", [100.0, 0.0]), ("b", [0.0, 100.0]), ("c", [-100.0, 0.0])] {
        let layer = format!("BK_BODY_{body}");
        if has_holes {
            sheet.bar(&layer, [0.0, 0.0], end, 10.0);
        } else {
            let low = [f64::min(end[0], -10.0), f64::min(end[1], -10.0)];
            sheet.rectangle(&layer, low, [f64::max(end[0], 10.0), f64::max(end[1], 10.0)]);
        }
    }
    sheet.insert("BK_REVOLUTE", [0.0, 0.0], 0.0, names);
    sheet.compose_with("bodies = { a = { mass = 1 }, b = { mass = 1 }, c = { mass = 1 } }\n")
}

fn pairs(composition: &Composition) -> Vec<(&str, [&str; 2])> {
    let joints = composition.joints.iter();
    joints.map(|it| (it.name.as_str(), [it.bodies[0].as_str(), it.bodies[1].as_str()])).collect()
}

#[test]
fn a_pin_through_the_holes_of_three_bodies_is_two_joints() {
    let pin = three_bars(true, &[("NAME", "P")]);
    assert_eq!(codes(&pin), Vec::<&str>::new());
    assert_eq!(pairs(&pin), [("P_1", ["a", "b"]), ("P_2", ["a", "c"])]);
    assert!(pin.text.contains("between = [\"a.P\", \"b.P\"]"), "{}", pin.text);
    // In another order, with the ground, or only two of them.
    let ordered = three_bars(true, &[("NAME", "P"), ("BODIES", "c, ground, a, b")]);
    let expected = [("P_1", ["c", "ground"]), ("P_2", ["c", "a"]), ("P_3", ["c", "b"])];
    assert_eq!(pairs(&ordered), expected);
    assert_eq!(model_of(&ordered).joints.len(), 3);
    assert_eq!(pairs(&three_bars(true, &[("BODIES", "c, a")])), [("J1", ["c", "a"])]);
    let two = three_bars(true, &[("NAME", "P"), ("BODY1", "a"), ("BODY2", "c")]);
    assert_eq!(pairs(&two), [("P", ["a", "c"])]);
    // What one joint has cannot be that of two.
    assert_eq!(codes(&three_bars(true, &[("ANGLE", "20 deg")])), ["D038"]);
    for (bodies, code) in [("a", "D037"), ("a, b, a", "D037"), ("a, b, d", "D036")] {
        assert_eq!(codes(&three_bars(true, &[("BODIES", bodies)])), [code], "{bodies}");
    }
}

#[test]
fn three_bodies_that_overlap_at_a_point_are_asked_about() {
    let asked = three_bars(false, &[("NAME", "P")]);
    assert_eq!(codes(&asked), ["D038"]);
    assert_eq!(asked.diagnostics[0].message, "3 bodies meet joint `P` at (0, 0): `a`, `b`, `c`");
    let help = asked.diagnostics[0].help.as_deref().unwrap_or_default();
    assert!(help.ends_with("or all that one pin joins: `bodies=a, b, c`"), "{help}");
    let answered = three_bars(false, &[("NAME", "P"), ("BODIES", "a, b, c")]);
    assert_eq!(pairs(&answered), [("P_1", ["a", "b"]), ("P_2", ["a", "c"])]);
    assert_eq!(codes(&three_bars(false, &[("BODY1", "a"), ("BODY2", "d")])), ["D036"]);
}

#[test]
fn a_body_block_takes_the_smallest_outline_around_it() {
    let mut sheet = Sheet::default();
    // A frame around the sheet, a slotted link, a block in its slot, and a bar across them all.
    sheet.rectangle("FRAME", [-100.0, -100.0], [400.0, 200.0]);
    sheet.rectangle("0", [0.0, 0.0], [200.0, 40.0]);
    sheet.rectangle("0", [20.0, 10.0], [180.0, 30.0]);
    sheet.rectangle("0", [80.0, 12.0], [110.0, 28.0]);
    sheet.rectangle("0", [120.0, -50.0], [130.0, 90.0]);
    for (name, at) in [("link", [10.0, 5.0]), ("block", [90.0, 20.0]), ("bar", [125.0, 80.0])] {
        let values = [("NAME", name), ("DENSITY", "1000"), ("THICKNESS", "10"), ("FREE", "yes")];
        sheet.insert("BK_BODY", at, 0.0, &values);
    }
    let model = model_of(&sheet.compose(ComposeOptions::default()));
    // 1000 kg/m^3 and 10 mm make 1e-5 kg for each square millimetre. The bar comes first: links
    // that it crosses are no part of it.
    let expected = [200.0 * 40.0 - 160.0 * 20.0, 30.0 * 16.0, 10.0 * 140.0];
    for (mass, expected) in masses(&model).into_iter().zip(expected) {
        assert_close(mass, expected * 1e-5, 1e-12);
    }
}

#[test]
fn a_body_block_on_a_pin_takes_what_the_hole_is_in() {
    let mut sheet = Sheet::default();
    sheet.rectangle("FRAME", [-100.0, -100.0], [600.0, 200.0]);
    sheet.bar("0", [0.0, 0.0], [200.0, 0.0], 20.0);
    // A wheel with a hole for its axle.
    sheet.circle("0", [400.0, 0.0], 30.0);
    sheet.circle("0", [400.0, 0.0], 5.0);
    for (name, at) in [("bar", [0.0, 0.0]), ("wheel", [400.0, 0.0])] {
        let values = [("NAME", name), ("DENSITY", "1000"), ("THICKNESS", "10"), ("FREE", "yes")];
        sheet.insert("BK_BODY", at, 0.0, &values);
    }
    let model = model_of(&sheet.compose(ComposeOptions::default()));
    let pi = std::f64::consts::PI;
    let expected = [bar_moments(200.0, 20.0).0, pi * (900.0 - 25.0)];
    for (mass, expected) in masses(&model).into_iter().zip(expected) {
        assert_close(mass, expected * 1e-5, 1e-12);
    }
}

/// A body of a density with two holes, and an outline that is drawn as these lines.
fn plate_drawn_as(lines: &[[Point; 2]]) -> Composition {
    let mut sheet = Sheet::default();
    sheet.circle("BK_BODY_plate", [20.0, 20.0], 5.0);
    for [from, to] in lines {
        let curves = vec![Curve::Segment { from: *from, to: *to }];
        let shape = Shape::Path(Path { curves, is_closed: false });
        sheet.add("LINE", "BK_BODY_plate", *from, shape);
    }
    let sidecar = "[bodies.plate]\ndensity = 1000\nthickness = \"10 mm\"\nfree = true\n";
    sheet.compose_with(sidecar)
}

#[test]
fn an_open_outline_is_not_mistaken_for_its_holes() {
    let corners = [[0.0, 0.0], [100.0, 0.0], [100.0, 40.0], [0.0, 40.0], [0.0, 0.0]];
    let edges: Vec<[Point; 2]> = corners.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let closed = plate_drawn_as(&edges);
    assert_eq!(codes(&closed), Vec::<&str>::new());
    let pi = std::f64::consts::PI;
    assert_close(masses(&model_of(&closed))[0], (4000.0 - 25.0 * pi) * 1e-5, 1e-12);
    // A centre line across it does no harm.
    let crossed = [edges.as_slice(), &[[[-10.0, 20.0], [110.0, 20.0]]]].concat();
    assert_eq!(codes(&plate_drawn_as(&crossed)), Vec::<&str>::new());
    assert_eq!(codes(&plate_drawn_as(&edges[..3])), ["D020"]);
}

#[test]
fn records_on_the_outline_say_the_same_as_blocks() {
    let text = |text: &str| XValue::Text(text.to_owned());
    let record = |kind: &str, entries: &[XValue]| {
        [&[text(kind), XValue::Open], entries, &[XValue::Close]].concat()
    };
    let mut by_record = Sheet::default();
    let body = [text("name=arm"), text("mass=2 kg"), text("inertia=0.1 kg m^2")];
    let joint = [text("name=O"), text("rate=3"), text("at"), XValue::Point([0.0, 0.0])];
    let force = [
        text("name=f"),
        text("value=5 N"),
        text("at"),
        XValue::Point([100.0, 0.0]),
        text("axis"),
        XValue::Direction([0.0, 1.0]),
    ];
    by_record.bar("0", [0.0, 0.0], [100.0, 0.0], 10.0).xdata =
        [record("body", &body), record("revolute", &joint), record("force", &force)].concat();

    let mut by_block = Sheet::default();
    by_block.bar("BK_BODY_arm", [0.0, 0.0], [100.0, 0.0], 10.0);
    let body = [("NAME", "arm"), ("MASS", "2 kg"), ("INERTIA", "0.1 kg m^2")];
    by_block.insert("BK_BODY", [0.0, 0.0], 0.0, &body);
    by_block.insert("BK_REVOLUTE", [0.0, 0.0], 0.0, &[("NAME", "O"), ("RATE", "3")]);
    let up = std::f64::consts::FRAC_PI_2;
    by_block.insert("BK_FORCE", [100.0, 0.0], up, &[("NAME", "f"), ("VALUE", "5 N")]);

    // The centre of mass is that of the outline, with or without its holes.
    let [a, b] = [by_record, by_block].map(|sheet| sheet.compose(ComposeOptions::default()).text);
    assert_eq!(a, b);
    assert!(a.contains("vector = [0, \"5 N\"]"), "{a}");
}

#[test]
fn a_body_without_mass_may_be_weighed_for_a_material_that_is_tried_out() {
    let composition = two_bars().compose(ComposeOptions::default());
    assert_eq!(codes(&composition), ["D043", "D043"]);
    assert!(composition.text.is_empty());
    let plate = [Some("7850 kg/m^3"), Some("5 mm")];
    let composition = two_bars().compose(ComposeOptions { plate, ..ComposeOptions::default() });
    assert_eq!(codes(&composition), Vec::<&str>::new());
    let (area, _) = bar_moments(100.0, 10.0);
    assert_close(masses(&model_of(&composition))[0], 7850.0 * 0.005 * area * 1e-6, 1e-12);
}

#[test]
fn two_things_of_one_name_are_shown_both() {
    let mut sheet = two_bars();
    sheet.insert("BK_TORQUE", [0.0, 0.0], 0.0, &[("NAME", "m"), ("VALUE", "1 N m")]);
    sheet.insert("BK_TORQUE", [80.0, 60.0], 0.0, &[("NAME", "m"), ("VALUE", "1 N m")]);
    let composition = sheet.compose_with(SIDECAR);
    assert_eq!(codes(&composition), ["D034"]);
    // Without text there are no labels: the notes say where.
    assert_eq!(composition.diagnostics[0].notes.len(), 2);
}

#[test]
fn the_sidecar_adds_what_the_drawing_cannot_say_and_keeps_its_comments() {
    let sidecar = format!(
        "# a press\nname = \"press\"\n{SIDECAR}\n[loads.g]\ntype = \"gravity\"\nacceleration = [0, -10]\n\
         [joints.B]\ncut = true\n[initial]\ncrank = {{ angle = 0.1 }}\n"
    );
    let composition = two_bars().compose_with(&sidecar);
    let model = model_of(&composition);
    assert_eq!(model.name, "press");
    assert!(composition.text.starts_with("# a press\n"), "{}", composition.text);
    assert_eq!(model.loads.len(), 1);
    assert_eq!(model.joints.iter().map(|joint| joint.cut).collect::<Vec<_>>(), [None, Some(true)]);
    // The start that is stated is taken as it is stated, without the drawn pose.
    let of_crank = model.initial.iter().filter(|start| start.name.starts_with("crank"));
    assert_eq!(of_crank.map(|start| start.is_guess).collect::<Vec<_>>(), [false]);
}

#[test]
fn what_an_entity_says_itself_comes_before_its_layer() {
    let mut sheet = two_bars();
    let text = |text: &str| XValue::Text(text.to_owned());
    sheet.circle("BK_BODY_crank", [500.0, 0.0], 10.0).xdata =
        vec![text("body"), XValue::Open, text("name=wheel"), XValue::Close];
    let composition =
        sheet.compose_with(&format!("{SIDECAR}\n[bodies.wheel]\nmass = 1\nfree = true\n"));
    assert_eq!(codes(&composition), Vec::<&str>::new());
    let area = |name: &str| {
        let body = composition.bodies.iter().find(|body| body.name == name).expect("the body");
        body.area.expect("an outline").area
    };
    assert_close(area("wheel"), 100.0 * std::f64::consts::PI, 1e-12);
    assert_close(area("crank"), bar_moments(100.0, 10.0).0, 1e-12);
}

#[test]
fn layers_that_differ_in_case_are_one() {
    let mut sheet = two_bars();
    sheet.circle("bk_body_CRANK", [40.0, 30.0], 2.0);
    let composition = sheet.compose_with(SIDECAR);
    assert_eq!(composition.bodies.len(), 2);
    let hole = 4.0 * std::f64::consts::PI;
    let crank = composition.bodies[0].area.expect("an outline").area;
    assert_close(crank, bar_moments(100.0, 10.0).0 - hole, 1e-12);
}

#[test]
fn two_centres_of_mass_are_one_too_many() {
    let mut sheet = two_bars();
    for x in [10.0, 20.0] {
        sheet.insert("BK_COM", [x, 0.0], 0.0, &[("BODY", "crank")]);
    }
    assert_eq!(codes(&sheet.compose_with(SIDECAR)), ["D034"]);
}

#[test]
fn bare_numbers_have_the_units_of_the_model() {
    let mut sheet = two_bars();
    sheet.insert("BK_MODEL", [0.0, 0.0], 0.0, &[("MASS", "g")]);
    sheet.insert("BK_BODY", [40.0, 30.0], 0.0, &[("NAME", "crank"), ("MASS", "2000")]);
    let sidecar = "[bodies.rod]\nmass = \"1 kg\"\n";
    let model = model_of(&sheet.compose_with(sidecar));
    assert_eq!(masses(&model), [2.0, 1.0]);
    let (area, polar) = bar_moments(100.0, 10.0);
    let inertia = values(&model, model.bodies[1].inertia.moments)[2];
    assert_close(inertia, 2.0 * polar / area * 1e-6, 1e-12);
}
