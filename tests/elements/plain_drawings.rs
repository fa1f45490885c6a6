//! Drawings without attributes: the joints, bodies, freedoms and scales that their draughtsmen meant.

use bksim::cad::model::ModelOptions;
use bksim::import::plain::{Options, Understanding, understand};
use bksim::mechanism_from_drawing;

use crate::support::{derive, model, solve};

macro_rules! drawing {
    ($name:literal) => {
        drawing!($name, ".dxf")
    };
    ($name:literal, $ending:literal) => {
        ($name, include_bytes!(concat!("../fixtures/import/plain/", $name, $ending)).as_slice())
    };
}

/// Kind, place and number of bodies of a joint.
type Joint = (&'static str, [f64; 2], usize);

struct Meant {
    drawing: (&'static str, &'static [u8]),
    mobility: i64,
    mm_per_unit: f64,
    n_bodies: usize,
    joints: &'static [Joint],
}

const PIN: &str = "pin";
const SLIDE: &str = "slide";

#[rustfmt::skip]
const ALL: [Meant; 18] = [
    // Single lines, split, in inches, pins as blocks, a side view next to it.
    Meant { drawing: drawing!("slider_crank_b"), mobility: 1, mm_per_unit: 25.4, n_bodies: 3, joints: &[
        (SLIDE, [8.325, 3.150], 2), (PIN, [3.937, 3.150], 2), (PIN, [4.696, 4.054], 2), (PIN, [8.325, 3.150], 2)] },
    // All on one layer, lines twice, ends that miss; no unit.
    Meant { drawing: drawing!("offset_press_b"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (SLIDE, [80.0, -5.910], 2), (PIN, [100.0, 80.0], 2), (PIN, [75.751, 94.0], 2), (PIN, [80.0, -5.910], 2)] },
    Meant { drawing: drawing!("sprung_lever_b"), mobility: 1, mm_per_unit: 1.0, n_bodies: 1, joints: &[(PIN, [100.0, 80.0], 2)] },
    // One block at half size, a plate by its hatching.
    Meant { drawing: drawing!("watt_b"), mobility: 1, mm_per_unit: 2.0, n_bodies: 5, joints: &[
        (PIN, [62.0, 47.0], 2), (PIN, [63.307, 61.943], 2), (PIN, [101.563, 80.456], 2), (PIN, [106.829, 50.922], 2),
        (PIN, [127.491, 77.461], 2), (PIN, [162.444, 79.275], 2), (PIN, [146.459, 56.899], 2)] },
    Meant { drawing: drawing!("gear_pair_a"), mobility: 1, mm_per_unit: 1.0, n_bodies: 4, joints: &[
        ("gear", [125.0, 80.0], 2), (PIN, [100.0, 80.0], 2), (PIN, [175.0, 80.0], 2), (PIN, [187.997, 115.708], 2),
        (PIN, [295.335, 139.762], 2), (PIN, [290.0, 80.0], 2)] },
    // One constraint too many, and lengths that miss each other by more than rounding.
    Meant { drawing: drawing!("parallelogram_b"), mobility: 1, mm_per_unit: 1.0, n_bodies: 4, joints: &[
        (PIN, [100.0, 80.0], 2), (PIN, [160.0, 80.0], 2), (PIN, [220.0, 80.0], 2),
        (PIN, [115.391, 122.286], 2), (PIN, [175.391, 122.286], 2), (PIN, [235.391, 122.286], 2)] },
    Meant { drawing: drawing!("rack"), mobility: 1, mm_per_unit: 1.0, n_bodies: 2, joints: &[
        (PIN, [100.0, 100.0], 2), ("rack", [100.0, 130.0], 2), (SLIDE, [105.0, 134.0], 2)] },
    Meant { drawing: drawing!("inverted"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (PIN, [100.0, 100.0], 2), (PIN, [100.0, 40.0], 2), (PIN, [120.0, 125.0], 2), (SLIDE, [120.0, 125.0], 2)] },
    Meant { drawing: drawing!("train"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (PIN, [60.0, 100.0], 2), (PIN, [110.0, 100.0], 2), (PIN, [155.0, 100.0], 2),
        ("gear", [80.0, 100.0], 2), ("gear", [125.0, 100.0], 2)] },
    Meant { drawing: drawing!("planet"), mobility: 2, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (PIN, [100.0, 100.0], 3), (PIN, [145.0, 100.0], 2), ("gear", [125.0, 100.0], 2)] },
    Meant { drawing: drawing!("trammel"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (PIN, [100.0, 150.0], 2), (PIN, [160.0, 80.0], 2), (SLIDE, [100.0, 150.0], 2), (SLIDE, [160.0, 80.0], 2)] },
    // The ring is hatched, so it stands still, and what turns in it turns about its centre.
    Meant { drawing: drawing!("ring"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (PIN, [100.0, 100.0], 3), (PIN, [150.0, 100.0], 2), ("gear", [130.0, 100.0], 2), ("gear inside", [170.0, 100.0], 2)] },
    Meant { drawing: drawing!("eccentric"), mobility: 1, mm_per_unit: 1.0, n_bodies: 2, joints: &[
        (PIN, [100.0, 100.0], 2), ("cam", [108.0, 146.0], 2), (SLIDE, [100.0, 203.5], 2)] },
    Meant { drawing: drawing!("roller"), mobility: 1, mm_per_unit: 1.0, n_bodies: 2, joints: &[
        (PIN, [100.0, 100.0], 2), ("cam", [103.819, 145.817], 2), (PIN, [190.0, 150.0], 2)] },
    // A pitch circle about the pin of a rocker: with one drive all of it moves if the wheel is the rocker's.
    Meant { drawing: drawing!("sector"), mobility: 1, mm_per_unit: 1.0, n_bodies: 4, joints: &[
        (PIN, [0.0, 0.0], 2), (PIN, [12.0, 32.5], 2), (PIN, [120.0, 0.0], 2), (PIN, [115.464, 69.853], 2),
        ("rack", [120.0, -40.0], 2), (SLIDE, [125.0, -52.0], 2)] },
    // Pictures: rules of styles, shifts, a pin of curves of Bézier.
    Meant { drawing: drawing!("slider_crank_c", ".svg"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (SLIDE, [140.0, 50.0], 2), (PIN, [40.0, 50.0], 2), (PIN, [60.0, 80.0], 2), (PIN, [140.0, 50.0], 2)] },
    // A symbol that is used twice, chain lines, no unit.
    Meant { drawing: drawing!("gears_c", ".svg"), mobility: 1, mm_per_unit: 1.0, n_bodies: 2, joints: &[
        (PIN, [60.0, 80.0], 2), (PIN, [110.0, 80.0], 2), ("gear", [80.0, 80.0], 2)] },
    // Turned by a matrix of six digits, half a millimetre each unit, ground by a pattern, arcs around pins.
    Meant { drawing: drawing!("four_bar_c", ".svg"), mobility: 1, mm_per_unit: 1.0, n_bodies: 3, joints: &[
        (PIN, [51.876, 56.337], 2), (PIN, [66.876, 82.318], 2), (PIN, [140.512, 96.555], 2), (PIN, [130.660, 42.445], 2)] },
];

fn understood((name, bytes): (&str, &[u8]), answers: &[(&str, &str)]) -> Understanding {
    let answers = answers.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
    let options = Options { answers: answers.collect(), ..Options::default() };
    understand(name, bytes, &options).unwrap_or_else(|faults| panic!("{name}: {faults:?}"))
}

#[test]
fn all_joints_are_found_and_none_is_invented() {
    for meant in ALL {
        let found = understood(meant.drawing, &[]);
        let name = meant.drawing.0;
        let mut left: Vec<_> = found.joints.iter().filter(|joint| !joint.is_asked).collect();
        // One percent of the picture, which is 100 units or more, and 8 in inches.
        let near = if name == "slider_crank_b" { 0.04 } else { 0.9 };
        for (kind, at, n_bodies) in meant.joints {
            let is_it = |joint: &&&bksim::import::plain::FoundJoint| {
                let [x, y] = [joint.at[0] - at[0], joint.at[1] - at[1]];
                joint.kind == *kind && x.hypot(y) < near && joint.bodies.len() == *n_bodies
            };
            let place = left.iter().position(|joint| is_it(&joint));
            let place = place.unwrap_or_else(|| panic!("{name}: no {kind} at {at:?} in {left:?}"));
            left.remove(place);
        }
        assert!(left.is_empty(), "{name}: invented {left:?}");
        assert_eq!(found.mobility, meant.mobility, "{name}");
        assert_eq!(found.bodies.len(), meant.n_bodies, "{name}");
        assert!(
            (found.mm_per_unit / meant.mm_per_unit - 1.0).abs() < 1e-12,
            "{name}: {}",
            found.mm_per_unit
        );
    }
}

#[test]
fn every_drawing_becomes_a_model_that_moves() {
    for meant in ALL {
        let name = meant.drawing.0;
        let asked = understood(meant.drawing, &[]);
        let drive = asked.questions.iter().find(|question| question.key == "drive");
        let drive = drive.expect("what drives it is asked").readings[1].answer.clone();
        let driven = understood(meant.drawing, &[("drive", drive.as_str()), ("gravity", "down")]);
        let text = format!("{}\n[solve]\nt_end = \"20 ms\"\nevery = \"10 ms\"\n", driven.model);
        let motion = solve(&derive(model(&text)));
        let [first, last] = [&motion.samples[0], &motion.samples[motion.samples.len() - 1]];
        let way = first.q.iter().zip(&last.q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(way > 1e-4, "{name} moved by {way}");
    }
}

#[test]
fn what_has_two_readings_is_asked_with_its_place_and_meaning() {
    let lever = drawing!("sprung_lever_b");
    let found = understood(lever, &[]);
    let keys: Vec<&str> = found.questions.iter().map(|question| question.key.as_str()).collect();
    assert!(keys.contains(&"unit"), "{keys:?}");
    assert_eq!(keys.iter().filter(|key| key.starts_with("stiffness.")).count(), 2, "{keys:?}");
    assert_eq!(found.elements.iter().filter(|element| element.kind == "spring").count(), 2);
    let circle = found.questions.iter().find(|it| it.readings.iter().any(|it| it.answer == "mass"));
    let circle = circle.expect("the circle next to `m = 2 kg`");
    assert!(circle.handle.is_some() && circle.at.is_some());
    let freedoms: Vec<_> =
        circle.readings.iter().map(|it| (it.answer.as_str(), it.freedoms)).collect();
    assert_eq!(freedoms, [("hole", Some(1)), ("mass", Some(1)), ("pin", Some(0))]);

    let answered = understood(lever, &[(&circle.key, "mass"), ("unit", "in")]);
    let mass = answered.elements.iter().find(|element| element.kind == "mass").expect("a mass");
    assert_eq!((mass.mass, answered.mm_per_unit), (Some(2.0), 25.4));
    let pinned = understood(lever, &[(&circle.key, "pin")]);
    assert_eq!(pinned.mobility, 0);

    let scale = understood(drawing!("parallelogram_b"), &[]);
    assert!(scale.questions.iter().any(|question| question.key == "scale"));
    let by_sheet = understood(drawing!("parallelogram_b"), &[("scale", "sheet")]);
    assert!((by_sheet.mm_per_unit - 2.0).abs() < 1e-12);
}

#[test]
fn a_drawing_is_understood_alike_every_time_and_any_bytes_are_faults() {
    let (name, bytes) = drawing!("watt_b");
    assert_eq!(understood((name, bytes), &[]), understood((name, bytes), &[]));
    for cut in [0, 200, bytes.len() / 3, bytes.len() - 40] {
        // Whatever is left is a drawing or a list of faults.
        if let Err(faults) = understand(name, &bytes[..cut], &Options::default()) {
            assert!(!faults.is_empty());
        }
    }
    let answers = vec![("motor".to_owned(), "A".to_owned()), ("drive".to_owned(), "B".to_owned())];
    let options = Options { answers, ..Options::default() };
    let faults = understand(name, bytes, &options).expect_err("answers to nothing");
    let codes: Vec<&str> = faults.iter().map(|fault| fault.code.0).collect();
    assert_eq!(codes, ["I018", "I019"]);
}

/// A picture whose size is in its own units is in those that are stated; it holds no attributes, and what is no XML is a fault
/// at its place.
#[test]
fn a_picture_has_the_unit_that_is_stated_and_holds_no_model() {
    let (name, bytes) = drawing!("four_bar_c", ".svg");
    let options = Options { unit: bksim::cad::units::by_name("cm"), ..Options::default() };
    let stated = understand(name, bytes, &options).expect("a mechanism");
    let own = understood((name, bytes), &[]);
    // The page is 210 mm of 420 units, 297 of them high.
    let at = |found: &Understanding| found.joints.iter().find(|it| it.name == "A").expect("A").at;
    let ([x, y], [own_x, own_y]) = (at(&stated), at(&own));
    assert!((x - 2.0 * own_x).abs() < 1e-9 && (y - 2.0 * own_y).abs() < 1e-9, "{x} {y}");
    assert!((stated.mm_per_unit - 10.0).abs() < 1e-12, "{}", stated.mm_per_unit);
    assert_eq!(own.records.expect_err("no attributes").code.0, "I020");
    let gears = understood(drawing!("gears_c", ".svg"), &[]);
    assert!(gears.questions.iter().any(|question| question.key == "unit"));
    let broken = b"<svg>\n<circle r='1'>\n</svg>";
    let faults = understand("broken", broken, &Options::default()).expect_err("no XML");
    assert_eq!((faults[0].code.0, faults[0].labels[0].span.start), ("I002", 21));
}

/// A drawing with what was understood attached to it moves as the text of the model does, and differs from the drawing by
/// extended data alone.
#[test]
fn a_drawing_with_what_was_understood_is_the_model() {
    for drawing in [drawing!("gear_pair_a"), drawing!("loose"), drawing!("slider_crank_b")] {
        let asked = understood(drawing, &[]);
        let drive = asked.questions.iter().find(|question| question.key == "drive");
        let drive = drive.expect("what drives it is asked").readings[1].answer.clone();
        let answers = [("drive", drive.as_str()), ("gravity", "down")];
        let driven = understood(drawing, &answers);
        let edits = driven.records.as_ref().expect("records");
        let attached = bksim::cad::patch::apply(drawing.1.to_vec(), edits).expect("entities");
        // All lines of the file are there, but for the next free handle.
        let mut left: Vec<&[u8]> = attached.bytes.split(|byte| *byte == b'\n').collect();
        left.sort_unstable();
        let mut lines: Vec<&[u8]> = drawing.1.split(|byte| *byte == b'\n').collect();
        lines.sort_unstable();
        let mut left = left.into_iter().peekable();
        let mut is_kept = |line: &&[u8]| {
            while left.next_if(|other| *other < *line).is_some() {}
            left.next_if(|other| *other == *line).is_some()
        };
        let n_changed = lines.len() - lines.iter().copied().filter(&mut is_kept).count();
        assert!(n_changed <= 1, "{}: {n_changed} lines changed", drawing.0);
        let solving = "[solve]\nt_end = \"20 ms\"\nevery = \"10 ms\"\n";
        let options = ModelOptions { sidecar: Some(solving), ..ModelOptions::default() };
        let own = mechanism_from_drawing(attached.bytes, options, "attached").expect("a mechanism");
        let text = derive(model(&format!("{}\n{solving}", driven.model)));
        let energy = |mechanism| {
            let motion = solve(mechanism);
            motion.samples.iter().map(|sample| sample.energy.kinetic).collect::<Vec<f64>>()
        };
        let (own, expected) = (energy(&own), energy(&text));
        assert_eq!(own.len(), expected.len());
        for (found, expected) in own.iter().zip(&expected) {
            let size = expected.abs().max(1e-9);
            assert!(
                (found - expected).abs() < 1e-6 * size,
                "{}: {found} J, not {expected} J",
                drawing.0
            );
        }
    }
    // At another scale than 1:1 a drawing cannot say what it means.
    let refused = understood(drawing!("watt_b"), &[]).records.expect_err("half size");
    assert_eq!(refused.code.0, "I020");
}

/// Four bars and four pins without bearings: one body stands still, and any of them may.
#[test]
fn which_body_stands_still_is_asked_where_nothing_is_hatched() {
    let found = understood(drawing!("loose"), &[]);
    let question = found.questions.iter().find(|question| question.key == "ground");
    let question = question.expect("which body is the ground").clone();
    assert_eq!((question.readings.len(), found.mobility, found.bodies.len()), (4, 1, 3));
    for reading in &question.readings {
        let answered = understood(drawing!("loose"), &[("ground", reading.answer.as_str())]);
        assert_eq!(answered.mobility, 1, "{}", reading.answer);
        let on_ground = answered.joints.iter().filter(|joint| joint.bodies[0] == "ground").count();
        assert_eq!(on_ground, 2, "{}", reading.answer);
    }
}

/// A disc of 40 mm whose pin is 10 mm off its centre lifts a flat face by the height of its centre: 6 mm at the start and, a
/// quarter of a turn on, 8 mm.
#[test]
fn a_flat_follower_is_lifted_by_an_eccentric_disc() {
    let driven = understood(drawing!("eccentric"), &[("drive", "O")]);
    let text = format!("{}\n[solve]\nt_end = \"250 ms\"\nevery = \"250 ms\"\n", driven.model);
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let [first, last] = [&motion.samples[0], &motion.samples[motion.samples.len() - 1]];
    let place = mechanism.system.coordinates().iter().position(|c| c.name.contains("slide"));
    let place = place.expect("the follower's own coordinate");
    let lift = last.q[place] - first.q[place];
    assert!((lift - 0.002).abs() < 1e-7, "{lift} m");
}

/// A support is a triangle with its corner in the middle of the pin or, as often, on its circle.
#[test]
fn a_pin_stands_on_a_triangle_that_begins_at_its_circle() {
    let four_bar = |apex: f64| {
        let line = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| {
            format!("0\nLINE\n8\n0\n10\n{ax}\n20\n{ay}\n11\n{bx}\n21\n{by}\n")
        };
        let [a, b, c, d] = [
            [0.0, 0.0],
            [16.209_069_2, 25.244_129_5],
            [105.711_173_9, 69.846_520_1],
            [110.0, 10.0],
        ];
        let mut entities: Vec<String> = [(a, b), (b, c), (c, d)].map(|(p, q)| line(p, q)).to_vec();
        entities.extend(
            [a, b, c, d].map(|[x, y]| format!("0\nCIRCLE\n8\n0\n10\n{x}\n20\n{y}\n40\n2.5\n")),
        );
        for [x, y] in [a, d] {
            let (top, base) = ([x, y - apex], y - 14.0);
            entities.push(line(top, [x - 9.0, base]));
            entities.push(line(top, [x + 9.0, base]));
            entities.push(line([x - 12.0, base], [x + 12.0, base]));
            for k in -3..=3 {
                let x = x + 4.0 * f64::from(k);
                entities.push(line([x, base], [x - 4.0, base - 4.0]));
            }
        }
        format!("0\nSECTION\n2\nENTITIES\n{}0\nENDSEC\n0\nEOF\n", entities.concat())
    };
    for apex in [0.0, 2.5] {
        let text = four_bar(apex);
        let found = understood(("four_bar", text.as_bytes()), &[]);
        let on_ground = |joint: &&bksim::import::plain::FoundJoint| {
            joint.bodies.iter().any(|body| body == "ground")
        };
        assert_eq!((found.joints.len(), found.mobility), (4, 1), "{apex}: {:?}", found.joints);
        assert_eq!(found.joints.iter().filter(on_ground).count(), 2, "{apex}");
        assert!(found.joints.iter().all(|joint| !joint.is_asked), "{apex}: {:?}", found.joints);
    }
}
