//! Edits of texts: what they change, what they leave, and that every one is undone byte for byte.

use bksim_edit::{Deed, Document, Edit, EditError, End, edited};
use bksim_model::file::{Source, read};

const FOUR_BAR: &str = include_str!("../../../examples/four-bar/model.toml");

fn set(path: &str, value: &str) -> Edit {
    Edit::Set { path: path.to_owned(), value: value.to_owned() }
}

fn end(x: f64, y: f64, on: Option<&str>) -> End {
    End { world: [x, y], on: on.map(str::to_owned), local: None }
}

/// The lines of `new` that `old` has not, and those that are gone.
fn difference<'t>(old: &'t str, new: &'t str) -> (Vec<&'t str>, Vec<&'t str>) {
    let missing = |a: &'t str, b: &str| -> Vec<&'t str> {
        a.lines().filter(|line| !b.lines().any(|other| other == *line)).collect()
    };
    (missing(new, old), missing(old, new))
}

fn is_model(text: &str) -> bool {
    read(&Source::new(text, "edited")).model.is_some()
}

#[test]
fn a_value_is_replaced_and_nothing_else() {
    let text = edited(FOUR_BAR, &set("parameters.a", "0.12 m")).expect("an edit");
    let (new, old) = difference(FOUR_BAR, &text);
    assert_eq!(new, ["a = \"0.12 m\"           # crank"]);
    assert_eq!(old, ["a = \"0.1 m\"           # crank"]);
    // Numbers stay numbers, lists lists; all else is a text.
    for (value, written) in [("2.5", "2.5"), ("[0, 1]", "[0, 1]"), ("a/2", "\"a/2\"")] {
        let text = edited(FOUR_BAR, &set("bodies.crank.mass", value)).expect("an edit");
        assert!(text.contains(&format!("mass = {written}\n")), "{text}");
    }
}

#[test]
fn values_that_are_new_stand_where_they_belong() {
    let text = edited(FOUR_BAR, &set("initial.A.angle", "30 deg")).expect("an edit");
    assert_eq!(difference(FOUR_BAR, &text).0, ["A = { angle = \"30 deg\" }"]);
    let more = edited(&text, &set("initial.A.rate", "0")).expect("an edit");
    assert!(more.contains("A = { angle = \"30 deg\", rate = 0 }\n"), "{more}");
    // A section that is new comes in the order of the reference.
    let without = edited(FOUR_BAR, &Edit::Remove { path: "initial".to_owned() }).expect("an edit");
    assert!(!without.contains("[initial]"), "{without}");
    let text = edited(&without, &set("initial.A.angle", "30 deg")).expect("an edit");
    assert!(text.contains("\n\n[initial]\nA = { angle = \"30 deg\" }\n\n[solve]\n"), "{text}");
    // Windows' line endings stay.
    let windows = FOUR_BAR.replace('\n', "\r\n");
    let text = edited(&windows, &set("initial.A.angle", "30 deg")).expect("an edit");
    assert_eq!(text.matches('\n').count(), text.matches("\r\n").count());
}

#[test]
fn a_point_moves_in_the_unit_or_parameter_in_which_it_is_written() {
    let moved =
        |text: &str, point: &str, to| edited(text, &Edit::Move { point: point.to_owned(), to });
    // The end of a link: its length is a parameter.
    let text = moved(FOUR_BAR, "crank.B", [0.09, 0.12]).expect("an edit");
    assert_eq!(difference(FOUR_BAR, &text).0, ["a = \"0.15 m\"           # crank"]);
    // Its origin: the other end stays.
    let text = moved(FOUR_BAR, "coupler.B", [0.06, 0.0]).expect("an edit");
    assert_eq!(difference(FOUR_BAR, &text).0, ["b = \"0.24 m\"           # coupler"]);
    let plain =
        "[units]\nlength = \"mm\"\n[ground]\npoints = { O = [20, \"3 cm\"], P = [\"2*a\", 0] }\n";
    let text = moved(plain, "ground.O", [0.0125, 0.04]).expect("an edit");
    assert!(text.contains("O = [12.5, \"4 cm\"]"), "{text}");
    let refused = moved(plain, "ground.P", [0.1, 0.0]);
    assert!(matches!(refused, Err(EditError::Formula { .. })), "{refused:?}");
}

#[test]
fn a_name_changes_wherever_it_is_used() {
    let rename = |name: &str, to: &str| Edit::Rename { name: name.to_owned(), to: to.to_owned() };
    let text = edited(FOUR_BAR, &rename("crank", "arm")).expect("an edit");
    assert!(text.contains("[bodies.arm]") && text.contains("\"arm.B\""), "{text}");
    assert!(!text.contains("[bodies.crank]") && !text.contains("\"crank.A\""), "{text}");
    assert!(is_model(&text));
    // Comments are prose, and stay.
    assert!(text.contains("# crank"));
    let text = edited(FOUR_BAR, &rename("a", "r")).expect("an edit");
    assert!(text.contains("B = [\"r\", 0]") && text.contains("\"0.5 kg*r^2/12\""), "{text}");
    assert!(is_model(&text));
    let taken = edited(FOUR_BAR, &rename("crank", "rocker"));
    assert!(matches!(taken, Err(EditError::Taken { .. })), "{taken:?}");
    let no_name = edited(FOUR_BAR, &rename("crank", "my crank"));
    assert!(matches!(no_name, Err(EditError::NoName { .. })), "{no_name:?}");
}

#[test]
fn what_hangs_on_an_element_goes_with_it() {
    let delete = |name: &str| Edit::Delete { name: name.to_owned() };
    let text = edited(FOUR_BAR, &delete("crank")).expect("an edit");
    for gone in ["[bodies.crank]", "[joints.A]", "[joints.B]", "[drives.motor]"] {
        assert!(!text.contains(gone), "{gone} in {text}");
    }
    for kept in ["[bodies.coupler]", "[joints.C]", "[joints.D]", "[loads.gravity]"] {
        assert!(text.contains(kept), "{kept} not in {text}");
    }
    // Lengths and places that nothing else uses go, too.
    let gone: Vec<&str> = difference(FOUR_BAR, &text).1;
    for line in ["a = ", "speed = "] {
        assert!(gone.iter().any(|own| own.starts_with(line)), "{line} in {text}");
    }
    assert!(text.contains("\nb = ") && text.contains("D = "), "{text}");
    // A body without a joint floats.
    let tree =
        edited(&edited(&text, &delete("D")).expect("an edit"), &delete("rocker")).expect("an edit");
    assert!(tree.contains("free = true") && is_model(&tree), "{tree}");
    let with_output = format!("{FOUR_BAR}\n[outputs]\nswing = \"rocker.angle\"\n");
    let text = edited(&with_output, &delete("rocker")).expect("an edit");
    assert!(!text.contains("swing"), "{text}");
    let used = edited(FOUR_BAR, &delete("a"));
    assert!(matches!(used, Err(EditError::Used { .. })), "{used:?}");
    let missing = edited(FOUR_BAR, &delete("nothing"));
    assert!(matches!(missing, Err(EditError::Missing { .. })), "{missing:?}");
}

/// A four-bar from nothing.
fn drawn() -> Vec<Edit> {
    vec![
        Edit::Link { from: end(0.0, 0.0, None), to: end(0.05, 0.08, None) },
        Edit::Link { from: end(0.05, 0.08, Some("link1.B")), to: end(0.3, 0.15, None) },
        Edit::Link { from: end(0.3, 0.15, Some("link2.B")), to: end(0.28, -0.02, None) },
        Edit::Ground { at: end(0.0, 0.0, Some("link1.A")) },
        Edit::Ground { at: end(0.28, -0.02, Some("link3.B")) },
        Edit::Motor { joint: "C".to_owned(), angle: 58_f64.to_radians() },
        Edit::Spring { from: end(0.3, 0.15, Some("link2.B")), to: end(0.4, 0.15, None) },
        Edit::Gravity {},
    ]
}

#[test]
fn a_four_bar_is_drawn_from_nothing_and_is_a_model_at_each_step() {
    let mut document = Document::new("");
    for edit in drawn() {
        document.apply(&edit).expect("an edit");
        let reading = read(&Source::new(document.text(), "drawn"));
        assert!(reading.model.is_some(), "{:?}\n{}", reading.diagnostics, document.text());
    }
    let model = read(&Source::new(document.text(), "drawn")).model.expect("a model");
    assert_eq!((model.bodies.len(), model.joints.len()), (4, 4));
    assert_eq!((model.drives.len(), model.loads.len()), (1, 2));
    while document.undo() {}
    assert_eq!(document.text(), "");
    while document.redo() {}
    assert!(is_model(document.text()));
}

#[test]
fn edits_of_a_moving_hand_are_undone_together() {
    let mut document = Document::new(FOUR_BAR);
    for length in ["0.11 m", "0.12 m", "0.13 m"] {
        document.apply_moving(&set("parameters.a", length)).expect("an edit");
    }
    document.settle();
    document.apply_moving(&set("parameters.a", "0.14 m")).expect("an edit");
    assert!(document.undo());
    assert!(document.text().contains("a = \"0.13 m\""));
    assert!(document.undo());
    assert_eq!(document.text(), FOUR_BAR);
    assert!(!document.undo());
}

#[test]
fn a_plate_has_the_inertia_of_its_corners_and_pins_where_it_meets_points() {
    let on_ground = edited("", &Edit::Point { body: "ground".to_owned(), at: [0.0, 0.0] });
    let text = on_ground.expect("an edit");
    let corners = vec![
        end(0.0, 0.0, Some("ground.A")),
        end(0.3, 0.0, None),
        end(0.3, 0.1, None),
        end(0.0, 0.1, None),
    ];
    let text = edited(&text, &Edit::Plate { corners }).expect("an edit");
    assert!(is_model(&text), "{text}");
    // A rectangle of 0.3 m by 0.1 m: (0.09 + 0.01)/12 m².
    assert!(text.contains("inertia = \"1 kg*0.00833333 m^2\""), "{text}");
    assert!(text.contains("com = [\"150 mm\", \"50 mm\"]"), "{text}");
    assert!(text.contains("between = [\"ground.A\", \"plate1.A\"]"), "{text}");
    let two = Edit::Plate { corners: vec![end(0.0, 0.0, None), end(1.0, 0.0, None)] };
    assert!(edited(&text, &two).is_err());
}

#[test]
fn a_distance_that_is_typed_becomes_the_parameter_or_the_place() {
    let length = |from: &str, to: &str, value: &str| Edit::Length {
        from: from.to_owned(),
        to: to.to_owned(),
        value: value.to_owned(),
    };
    let text = edited(FOUR_BAR, &length("crank.A", "crank.B", "120 mm")).expect("an edit");
    assert_eq!(difference(FOUR_BAR, &text).0, ["a = \"120 mm\"           # crank"]);
    let plate =
        "[bodies.p]\nmass = 1\npoints = { A = [\"10 mm\", 0], B = [\"40 mm\", \"40 mm\"] }\n";
    let text = edited(plate, &length("p.A", "p.B", "100 mm")).expect("an edit");
    assert!(text.contains("B = [\"70 mm\", \"80 mm\"]"), "{text}");
    let bare =
        "[units]\nlength = \"mm\"\n[bodies.p]\nmass = 1\npoints = { A = [0, 0], B = [30, 40] }\n";
    let text = edited(bare, &length("p.A", "p.B", "25")).expect("an edit");
    assert!(text.contains("B = [15, 20]"), "{text}");
    let crank = "[parameters]\na = \"60 mm\"\n[bodies.c]\nmass = 1\n\
                 points = { A = [0, 0], B = [\"a\", 0], T = [\"40 mm\", \"30 mm\"] }\n";
    let text = edited(crank, &length("c.T", "c.B", "50 mm")).expect("an edit");
    assert!(text.contains("a = \"80 mm\""), "{text}");
    for value in ["3 kg", "100 deg", "-3 mm", "a*2", "0 m"] {
        assert!(edited(crank, &length("c.A", "c.T", value)).is_err(), "{value}");
        assert!(edited(crank, &length("c.A", "c.B", value)).is_err(), "{value}");
    }
    for refused in
        [length("p.A", "p.A", "1 m"), length("p.A", "p.B", "l/2"), length("p.A", "q.B", "1 m")]
    {
        assert!(edited(plate, &refused).is_err(), "{refused:?}");
    }
}

#[test]
fn wheels_guides_and_copies_are_models() {
    let [a, b] = [end(0.0, 0.0, None), end(0.1, 0.0, None)];
    let mut document = Document::new("");
    let link = |from: &End, to: &End| Edit::Link { from: from.clone(), to: to.clone() };
    let ground = |on: &str, x: f64| Edit::Ground { at: end(x, 0.0, Some(on)) };
    for edit in [link(&a, &b), link(&b, &a), ground("link1.A", 0.0), ground("link2.A", 0.1)] {
        document.apply(&edit).expect("an edit");
    }
    let gear = Edit::Gear { between: ["A".to_owned(), "B".to_owned()], distance: 0.1, phase: 0.5 };
    let meshed = edited(document.text(), &gear).expect("an edit");
    assert!(meshed.contains("radii = [\"r1\", \"100 mm - r1\"]"), "{meshed}");
    assert!(is_model(&meshed), "{meshed}");
    // A pin in a slot of the other link.
    let guide = Some(end(0.0, 0.0, Some("link1.A")));
    let slide = Edit::Slide { at: end(0.1, 0.0, Some("link2.A")), angle: 0.0, guide };
    let text = edited(document.text(), &slide).expect("an edit");
    assert!(text.contains("between = [\"link1.A\", \"link2.A\"]\ndirection = \"0 deg\""), "{text}");
    let copy =
        |name: &str, mirrored| Edit::Copy { name: name.to_owned(), at: [0.2, 0.1], mirrored };
    let text = edited(document.text(), &copy("link1", false)).expect("an edit");
    assert!(is_model(&text), "{text}");
    assert_eq!(text.matches("B = [\"l1\", 0]").count(), 2, "{text}");
    let plate = "[bodies.p]\nmass = 1\ncom = [0, \"-h\"]\npoints = { A = [0, 1], B = [2, \"h/2\"] }\n\
                 outline = [[0, \"30 mm\"], [1, 0]]\n[parameters]\nh = 1\n";
    let text = edited(plate, &copy("p", true)).expect("an edit");
    let (new, _) = difference(plate, &text);
    assert!(new.contains(&"com = [0, \"h\"]"), "{new:?}");
    assert!(new.contains(&"points = { A = [0, -1], B = [2, \"-(h/2)\"] }"), "{new:?}");
    assert!(new.contains(&"outline = [[0, \"-30 mm\"], [1, 0]]"), "{new:?}");
}

#[test]
fn names_change_in_load_cases_too() {
    let text = format!(
        "{FOUR_BAR}\n[cases.heavy]\nset = {{ crank.mass = \"3 kg\", a = \"0.11 m\", initial.D.angle.guess = \"90 deg\" }}\n"
    );
    let rename = |name: &str, to: &str| Edit::Rename { name: name.to_owned(), to: to.to_owned() };
    let mut document = Document::new(&text);
    for (name, to) in [("crank", "arm"), ("a", "r"), ("D", "E")] {
        document.apply(&rename(name, to)).expect("an edit");
    }
    let last = document.text().lines().last().expect("a line");
    assert_eq!(
        last,
        "set = { arm.mass = \"3 kg\", r = \"0.11 m\", initial.E.angle.guess = \"90 deg\" }"
    );
}

#[test]
fn names_change_in_quantities_that_results_have_of_them() {
    let text = format!(
        "{FOUR_BAR}\n[outputs]\nF = \"reactions.A.force\"\n\n[optimize]\nminimize = \"max(transmission.C)\"\n\
         vary = {{ \"a\" = [1, 2] }}\n"
    );
    let rename = |name: &str, to: &str| Edit::Rename { name: name.to_owned(), to: to.to_owned() };
    let mut document = Document::new(&text);
    for (name, to) in [("A", "pin"), ("C", "top"), ("a", "r")] {
        document.apply(&rename(name, to)).expect("an edit");
    }
    let new = document.text();
    for line in ["F = \"reactions.pin.force\"", "max(transmission.top)", "\"r\" = [1, 2]"] {
        assert!(new.contains(line), "{line} in {new}");
    }
}

#[test]
fn names_that_go_are_gone_from_load_cases_ranges_and_questions() {
    let more = "[ranges]\na = [\"0.08 m\", \"0.12 m\"]\nA.angle = [\"0 deg\", \"90 deg\"]\nrod.mass = [1, 2]\n\n\
                [cases.heavy]\nset = { crank.mass = \"3 kg\", a = \"0.11 m\", initial.A.angle = \"9 deg\" }\n\n\
                [cases.light.set]\ncrank.mass = \"1 kg\"\nrocker.mass = \"1 kg\"\n\n\
                [optimize]\nvary = { a = [\"0.08 m\", \"0.12 m\"], b = [1, 2] }\nfrom = [{ a = \"0.1 m\" }]\n\n\
                [tolerance]\nplay = { A = \"0.02 mm\", C = \"0.02 mm\" }\n";
    let rename = |name: &str, to: &str| Edit::Rename { name: name.to_owned(), to: to.to_owned() };
    let text = format!("{FOUR_BAR}\n{}", more.replace("rod", "coupler"));
    let mut document = Document::new(&text);
    document.apply(&rename("a", "r")).expect("an edit");
    document.apply(&rename("crank", "arm")).expect("an edit");
    assert!(
        document.text().contains("\nr = [\"0.08 m\", \"0.12 m\"]\nA.angle"),
        "{}",
        document.text()
    );
    assert!(document.text().contains("vary = { r = ["), "{}", document.text());
    assert!(document.text().contains("from = [{ r = \"0.1 m\" }]"), "{}", document.text());
    document.apply(&Edit::Delete { name: "arm".to_owned() }).expect("an edit");
    let new = document.text();
    assert!(new.contains("set = { r = \"0.11 m\" }"), "{new}");
    assert!(new.contains("[cases.light.set]\nrocker.mass = \"1 kg\"\n"), "{new}");
    assert!(!new.contains("A.angle") && !new.contains("arm"), "{new}");
    assert!(new.contains("play = { C = \"0.02 mm\" }"), "{new}");
    assert!(document.undo() && document.undo() && document.undo());
    assert_eq!(document.text(), text);
}

#[test]
fn a_group_is_moved_copied_and_deleted_as_one() {
    let group = |names: &[&str], to: Deed| Edit::Group {
        names: names.iter().map(|name| (*name).to_owned()).collect(),
        to,
    };
    let all = ["crank", "coupler", "rocker"];
    let mut document = Document::new(FOUR_BAR);

    // The ground goes with the bodies; two ways of one hand are one change.
    document.apply_moving(&group(&all, Deed::Move([0.01, 0.0]))).expect("an edit");
    document.apply_moving(&group(&all, Deed::Move([0.05, 0.02]))).expect("an edit");
    let moved = "points = { A = [\"50 mm\", \"20 mm\"], D = [\"d + 50 mm\", \"20 mm\"] }";
    assert!(document.text().contains(moved), "{}", document.text());
    document.settle();
    document.apply(&group(&all, Deed::Move([-0.05, 0.0]))).expect("an edit");
    assert!(document.text().contains("D = [\"d\", \"20 mm\"]"), "{}", document.text());
    assert!(document.undo() && document.undo());
    assert_eq!(document.text(), FOUR_BAR);

    // A copy is a second mechanism with the motion of the first.
    document.apply(&group(&all, Deed::Copy([0.0, 0.5]))).expect("an edit");
    let reading = read(&Source::new(document.text(), "copied"));
    let model =
        reading.model.unwrap_or_else(|| panic!("{:?}\n{}", reading.diagnostics, document.text()));
    assert_eq!((model.bodies.len(), model.joints.len(), model.drives.len()), (7, 8, 2));
    assert!(document.text().contains("[\"d\", \"500 mm\"]"), "{}", document.text());
    let posed = bksim_edit::Posed::of(model).expect("a pose").numbers();
    for body in 1..4 {
        for k in 0..12 {
            let by = if k == 1 { 0.5 } else { 0.0 };
            let [own, copy] = [body, body + 3].map(|body| posed[18 * body + k]);
            assert!((copy - own - by).abs() < 1e-9, "number {k} of body {body}: {own} {copy}");
        }
    }
    let with_copy = document.text().to_owned();

    // What goes with one that is deleted may be named, too.
    document
        .apply(&group(&["crank1", "B1", "coupler1", "rocker1"], Deed::Delete))
        .expect("an edit");
    assert!(!document.text().contains("crank1") && document.text().contains("[bodies.crank]"));
    assert!(document.undo());
    assert_eq!(document.text(), with_copy);
    assert!(document.undo());
    assert_eq!(document.text(), FOUR_BAR);
    document.apply(&group(&["nobody"], Deed::Delete)).expect_err("no such body");
    document.apply(&group(&[], Deed::Delete)).expect_err("nothing");
}

#[test]
fn joints_and_wheels_that_cannot_be_are_refused() {
    let refused = |edit: &str| {
        let edit: Edit = serde_json::from_str(edit).expect("an edit");
        edited(FOUR_BAR, &edit).expect_err("no joint").code().0
    };
    let gear = |a: &str, b: &str, distance: f64| {
        refused(&format!(
            r#"{{ "edit": "gear", "between": ["{a}", "{b}"], "distance": {distance} }}"#
        ))
    };
    // No carrier in common, one joint twice, no distance.
    assert_eq!([gear("A", "C", 0.1), gear("A", "A", 0.1), gear("A", "D", 0.0)], ["M081"; 3]);
    let end = |on: &str| format!(r#"{{ "world": [0.1, 0], "on": "{on}" }}"#);
    let two = |kind: &str, from: &str, to: &str| {
        refused(&format!(r#"{{ "edit": "{kind}", "from": {}, "to": {} }}"#, end(from), end(to)))
    };
    assert_eq!(two("pin", "crank.A", "crank.B"), "M052");
    let at = end("ground.A");
    assert_eq!(refused(&format!(r#"{{ "edit": "slide", "at": {at}, "angle": 0 }}"#)), "M052");
    assert_eq!(refused(&format!(r#"{{ "edit": "ground", "at": {at} }}"#)), "M052");
    let meshing = r#"{ "edit": "gear", "between": ["A", "D"], "distance": 0.3 }"#;
    let meshing: Edit = serde_json::from_str(meshing).expect("an edit");
    assert!(edited(FOUR_BAR, &meshing).expect("wheels").contains("type = \"gear\""));
}
