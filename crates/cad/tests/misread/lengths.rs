//! Dimensions with names: parameters that positions follow from.

use bksim_cad::compose::Composition;
use bksim_model::file::{Source, read};

use super::{composed, model, only, words};

/// A dimension between two points, aligned or along an angle.
fn dimension(handle: &str, text: &str, [a, b]: [[f64; 2]; 2], angle: Option<f64>) -> String {
    // Linear ones are of the type 0, aligned ones of 1.
    let kind = i32::from(angle.is_none());
    let angle = angle.map_or_else(String::new, |angle| format!("  50 {angle}\n"));
    let [x1, y1, x2, y2] = [a[0], a[1], b[0], b[1]];
    format!(
        "DIMENSION handle={handle} text=\"{text}\"\n  70 {kind}\n  13 {x1}\n  23 {y1}\n  14 {x2}\n  24 {y2}\n{angle}"
    )
}

/// A four-bar without names of its lengths: crank from (0, 0) to (0, 100), coupler to (300, 200), rocker to
/// (250, 0) on the ground.
fn four_bar(more: &str) -> String {
    let pins = [("A", "0,0"), ("B", "0,100"), ("C", "300,200"), ("D", "250,0")];
    let links = [("crank", [0, 1]), ("coupler", [1, 2]), ("rocker", [3, 2])];
    let bodies = links.map(|(body, ends)| {
        let [from, to] = ends.map(|pin: usize| pins[pin].1);
        format!(
            "LINE layer=BK_BODY_{body} at={from} to={to}\n\
             INSERT block=BK_BODY at={from} NAME={body} MASS=\"1 kg\" INERTIA=\"0.01 kg m^2\"\n"
        )
    });
    let joints = pins.map(|(name, at)| format!("INSERT block=BK_REVOLUTE at={at} NAME={name}\n"));
    bodies.concat() + &joints.concat() + more
}

#[test]
fn named_dimensions_are_parameters_that_positions_follow_from() {
    let [a, b, c, d] = [[0.0, 0.0], [0.0, 100.0], [300.0, 200.0], [250.0, 0.0]];
    let named = [
        dimension("D1", "<> l1", [a, b], None),
        dimension("D2", "l2 = <>", [c, b], None),
        dimension("D3", "l3", [d, c], None),
        dimension("D4", "<> l4", [a, d], Some(0.0)),
    ]
    .concat();
    let [plain, composition] = [four_bar(""), four_bar(&named)].map(|list| composed(&list));
    assert_eq!(composition.diagnostics, []);
    for part in [
        "l1 = \"100 mm\"",
        "l4 = \"250 mm\"",
        "B = [\"l1\", 0]",
        "C = [\"l2\", 0]",
        "C = [\"l3\", 0]",
        "D = [\"l4\", 0]",
    ] {
        assert!(composition.text.contains(part), "{part} is not in\n{}", composition.text);
    }
    // The names change no number; another value moves the pins.
    let lengths = |composition: &Composition, l1: Option<&str>| -> Vec<f64> {
        let overrides: Vec<(String, String)> =
            l1.iter().map(|it| ("l1".to_owned(), (*it).to_owned())).collect();
        let source = Source { overrides: &overrides, ..Source::new(&composition.text, "sheet") };
        let model = read(&source).model.expect("a model");
        let of = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
        let value = |expr| model.pool.evaluate(expr, &of).expect("a number");
        let points = model.bodies.iter().flat_map(|body| &body.points);
        points.map(|point| value(point.position[0])).collect()
    };
    let numbers = lengths(&plain, None);
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(close(&numbers, &lengths(&composition, None)));
    let changed = lengths(&composition, Some("120 mm"));
    let differing: Vec<f64> =
        numbers.iter().zip(&changed).filter(|(a, b)| a != b).map(|(_, b)| *b).collect();
    assert_eq!(differing, [0.12]);
}

#[test]
fn names_of_lengths_that_contradict_or_say_otherwise_are_told() {
    let [a, b, d] = [[0.0, 0.0], [0.0, 100.0], [250.0, 0.0]];
    let twice = dimension("D1", "<> l", [a, b], None) + &dimension("D2", "<> l", [a, d], None);
    let fault = only(&composed(&four_bar(&twice)), "D046");
    assert!(words(&fault).contains("handle D1") && words(&fault).contains("handle D2"));
    let stated = dimension("D1", "l1 = 120", [a, b], None);
    let warning = only(&composed(&four_bar(&stated)), "D051");
    assert!(warning.message.contains("`l1` is 120, but it measures 100 mm"), "{}", warning.message);
    let parameter = "INSERT block=BK_PARAMETER at=0,400 NAME=l1 VALUE=\"120 mm\"\n";
    let fault =
        only(&composed(&four_bar(&(dimension("D1", "<> l1", [a, b], None) + parameter))), "D046");
    assert!(
        fault.message.contains("100 mm as drawn, but 120 mm as a parameter"),
        "{}",
        fault.message
    );
    // Between points of different bodies nothing follows.
    only(&composed(&four_bar(&dimension("D1", "<> e", [b, d], None))), "D052");
    // Numbers, words of drafting, and names that are nowhere near the mechanism mean nothing.
    for text in ["<>", "120", "R<>", "<> TYP"] {
        assert_eq!(composed(&four_bar(&dimension("D1", text, [a, b], None))).diagnostics, []);
    }
    let far = dimension("D1", "width", [[500.0, 0.0], [500.0, 40.0]], None);
    assert_eq!(composed(&four_bar(&far)).text, composed(&four_bar("")).text);
    // Unless a value has the name.
    let spring = "INSERT block=BK_SPRING at=0,100 BODY1=crank BODY2=ground scale=50 NAME=s STIFFNESS=\"1 N/mm\" LENGTH=\"2*width\"\n";
    let composition = composed(&four_bar(&format!("{far}{spring}")));
    assert!(model(&composition).parameters.iter().any(|it| it.name == "width"));
}
