//! Faults that people draw are named with their places, and nothing of them is solved as something else.

#[path = "../../../studio/tests/diagnostics/drawing.rs"]
mod drawing;

mod doctor;
mod lengths;
mod old_forms;

use bksim_cad::compose::Composition;
use bksim_cad::model::{ModelOptions, Refused, sheet};
use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::{Source, read};

/// The composition of a drawing that is listed, its unit left out, as read with these options.
fn composed_with(list: &str, options: ModelOptions<'_>) -> Result<Composition, Vec<Diagnostic>> {
    let text = drawing::dxf(&format!("units mm\n{list}")).expect("a list of entities");
    let sheet =
        sheet(text.into_bytes(), None).map_err(|Refused { diagnostics, .. }| diagnostics)?;
    Ok(sheet.compose(options))
}

#[track_caller]
fn composed(list: &str) -> Composition {
    composed_with(list, ModelOptions::default())
        .unwrap_or_else(|faults| panic!("the drawing is refused: {faults:#?}"))
}

/// The faults with this code.
fn faults(composition: &Composition, code: &str) -> Vec<Diagnostic> {
    composition.diagnostics.iter().filter(|fault| fault.code.0 == code).cloned().collect()
}

/// The only fault of a drawing.
#[track_caller]
fn only(composition: &Composition, code: &str) -> Diagnostic {
    match composition.diagnostics.as_slice() {
        [one] if one.code.0 == code => one.clone(),
        others => panic!("not {code} alone: {others:#?}"),
    }
}

/// All that is said of a fault.
fn words(fault: &Diagnostic) -> String {
    let labels = fault.labels.iter().map(|label| label.text.as_str());
    let all = std::iter::once(fault.message.as_str()).chain(labels);
    let notes = fault.notes.iter().map(String::as_str);
    all.chain(notes).chain(fault.help.as_deref()).collect::<Vec<_>>().join("\n")
}

/// An arm that hangs from a wall, with its weight.
const ARM: &str = "\
LWPOLYLINE layer=BK_BODY_arm points=\"0,0 300,0 300,20 0,20\"
CIRCLE layer=BK_BODY_arm at=10,10 radius=5
INSERT block=BK_REVOLUTE at=10,10 NAME=A
INSERT block=BK_BODY at=150,10 NAME=arm MASS=\"2 kg\"
";

/// The model of a composition without errors.
#[track_caller]
fn model(composition: &Composition) -> bksim_model::Model {
    let errors: Vec<_> = composition.diagnostics.iter().filter(|it| it.is_error()).collect();
    assert!(errors.is_empty(), "{errors:#?}");
    let reading = read(&Source::new(&composition.text, "sheet"));
    reading.model.unwrap_or_else(|| panic!("{}\n{:#?}", composition.text, reading.diagnostics))
}

#[test]
fn a_decimal_comma_is_refused_with_the_number_to_write() {
    let gravity = |value: &str| {
        composed(&format!(
            "{ARM}INSERT block=BK_GRAVITY handle=9F at=0,99 ACCELERATION=\"{value}\"\n"
        ))
    };
    let refused = only(&gravity("9,81"), "D045");
    assert!(refused.is_error());
    assert!(refused.help.expect("a help").contains("write `9.81` for a number"));
    // What the help says is taken, either way.
    for value in ["9.81", "[9, 81]", "0, -9.81"] {
        model(&gravity(value));
    }
    let record = "POINT at=500,0\n  1001 BKSIM\n  1000 torque\n  1002 {\n  1000 body=arm\n  1000 value=2,5 N m\n  1002 }\n";
    let refused = only(&composed(&format!("{ARM}{record}")), "D045");
    assert_eq!(refused.help.as_deref(), Some("write `2.5 N m`: decimals begin with a point"));
}

#[test]
fn an_insert_of_no_block_is_warned_about_and_the_drawing_read() {
    // A handle of its own, so that the words can be held against it.
    let insert = "INSERT handle=7B layer=parts at=40,50\n  2 NOPE\n";
    let whole = composed(ARM);
    let composition = composed(&format!("{ARM}{insert}"));
    let warning = only(&composition, "D010");
    assert!(!warning.is_error());
    let words = words(&warning);
    for part in ["`NOPE`", "handle 7B", "layer parts", "(40, 50)"] {
        assert!(words.contains(part), "{words}");
    }
    assert_eq!(model(&composition).bodies.len(), model(&whole).bodies.len());
    // So is one within a block that is shown, once; one within a block that nobody inserts is not.
    let inner = "BLOCK name=outer\nINSERT at=1,1\n  2 GONE\nENDBLK\n";
    assert_eq!(composed(&format!("{inner}{ARM}")).diagnostics, []);
    let shown =
        composed(&format!("{inner}{ARM}INSERT block=outer at=0,0\nINSERT block=outer at=9,9\n"));
    assert!(only(&shown, "D010").message.contains("`GONE`"));
}

#[test]
fn two_gravities_solves_or_models_are_a_fault_that_names_both() {
    for (block, values) in [
        ("BK_GRAVITY", "ACCELERATION=\"9.81 m/s^2\""),
        ("BK_SOLVE", "T_END=\"1 s\""),
        ("BK_MODEL", "MASS=g"),
    ] {
        let one = format!("INSERT handle=A1 block={block} at=0,99 {values}\n");
        let two = format!("INSERT handle=A2 block={block} at=5,99 {values}\n");
        assert_eq!(composed(&format!("{ARM}{one}")).diagnostics, []);
        let fault = only(&composed(&format!("{ARM}{one}{two}")), "D046");
        let words = words(&fault);
        assert!(fault.is_error());
        assert!(words.contains("handle A1") && words.contains("handle A2"), "{words}");
    }
    // Gravities of other names add up just the same; so does one of the model file next to the drawing.
    let named = |name: &str, at: &str| {
        format!("INSERT block=BK_GRAVITY at={at} NAME={name} ACCELERATION=\"9.81 m/s^2\"\n")
    };
    only(&composed(&format!("{ARM}{}{}", named("g", "0,9"), named("h", "0,99"))), "D046");
    let beside = |name: &str| {
        let text = format!("[loads.{name}]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n");
        let options = ModelOptions { sidecar: Some(&text), ..ModelOptions::default() };
        composed_with(&format!("{ARM}{}", named("g", "0,9")), options).expect("a drawing")
    };
    assert!(words(&only(&beside("weight"), "D046")).contains("`weight`"));
    // Of the same name, the model file next to the drawing comes first: that is one gravity.
    assert_eq!(model(&beside("g")).loads.len(), 1);
}

#[test]
fn a_copy_of_a_spring_on_itself_is_a_fault_and_two_named_ones_are_two() {
    let spring = |name: &str| {
        format!(
            "INSERT block=BK_SPRING at=200,10 scale=90 rotation=90 {name}BODY1=arm STIFFNESS=\"2 N/mm\"\n"
        )
    };
    let fault = only(&composed(&format!("{ARM}{}{}", spring(""), spring(""))), "D046");
    assert_eq!(fault.message, "a spring is stated twice at one place");
    let two = composed(&format!("{ARM}{}{}", spring("NAME=a "), spring("NAME=b ")));
    assert_eq!(model(&two).loads.len(), 2);
}

#[test]
fn two_starts_of_one_value_are_a_fault_that_names_both() {
    let initial = |name: &str, key: &str, value: &str| {
        format!("INSERT block=BK_INITIAL at=0,99 NAME={name} {key}=\"{value}\"\n")
    };
    let fine = format!("{ARM}{}{}", initial("A", "ANGLE", "20 deg"), initial("A", "RATE", "1"));
    assert_eq!(composed(&fine).diagnostics, []);
    only(&composed(&format!("{fine}{}", initial("A", "ANGLE", "30 deg"))), "D046");
    // An angle of the joint itself, too.
    let stated = ARM.replace("NAME=A", "NAME=A ANGLE=\"10 deg\"");
    only(&composed(&format!("{stated}{}", initial("A", "ANGLE", "30 deg"))), "D046");
}

#[test]
fn entities_whose_numbers_make_no_curve_are_warned_about() {
    let broken = "\
CIRCLE handle=B1 layer=holes at=5,5 radius=0
LWPOLYLINE handle=B2 layer=edges points=\"7,7\" closed=no
SPLINE handle=B3 layer=edges
  71 3
  40 0
  40 1
  10 1
  20 2
";
    let composition = composed(&format!("{ARM}{broken}"));
    let found = faults(&composition, "D025");
    let all: Vec<String> = found.iter().map(words).collect();
    assert_eq!(found.len(), 3, "{all:#?}");
    for (words, handle) in all.iter().zip(["B1", "B2", "B3"]) {
        assert!(words.contains(&format!("handle {handle}")), "{words}");
    }
    assert!(all[0].contains("the radius is 0"), "{}", all[0]);
    assert!(found.iter().all(|fault| !fault.is_error() && fault.help.is_some()));
    model(&composition);
    // One within a block is named with its block, however often that is inserted.
    let inside = "BLOCK name=bolt\nCIRCLE at=0,0 radius=0\nENDBLK\n";
    let inserts = "INSERT block=bolt at=50,10\nINSERT block=bolt at=70,10\n";
    let warning = only(&composed(&format!("{inside}{ARM}{inserts}")), "D025");
    assert!(warning.message.contains("a CIRCLE of the block `bolt`"), "{}", warning.message);
}

#[test]
fn an_entity_out_of_the_plane_is_warned_about() {
    let tilted = "CIRCLE handle=B1 layer=holes at=5,5 radius=3\n  210 1\n  220 0\n  230 0\n";
    let warning = only(&composed(&format!("{ARM}{tilted}")), "D028");
    assert!(words(&warning).contains("handle B1"), "{}", words(&warning));
    // A mirrored one is in the plane.
    let mirrored = tilted.replace("  210 1\n", "  210 0\n").replace("  230 0\n", "  230 -1\n");
    assert_eq!(composed(&format!("{ARM}{mirrored}")).diagnostics, []);
}

/// The arm with other names: of the body, the joint and the parameter that drives it.
fn named(body: &str, joint: &str, parameter: &str, motion: &str) -> String {
    format!(
        "LWPOLYLINE layer=\"BK_BODY_{body}\" points=\"0,0 300,0 300,20 0,20\"\n\
         INSERT block=BK_REVOLUTE at=10,10 NAME=\"{joint}\"\n\
         INSERT block=BK_BODY at=150,10 NAME=\"{body}\" MASS=\"2 kg\"\n\
         INSERT block=BK_PARAMETER at=0,99 NAME=\"{parameter}\" VALUE=\"60 rpm\"\n\
         INSERT block=BK_DRIVE at=10,10 NAME=motor JOINT=\"{joint}\" MOTION=\"{motion}\"\n"
    )
}

#[test]
fn names_of_any_script_are_solved_under_a_spelling_that_is_told() {
    for (body, joint, parameter, spelled) in [
        ("thanh truyền", "khớp 1", "ω", ["thanh_truyen", "khop_1", "omega"]),
        ("μοχλός", "Ο-1", "φ₁", ["mochlos", "O_1", "phi1"]),
        ("连杆", "1", "转速", ["LianGan", "j1", "ZhuanSu"]),
        ("rod-1", "A-1", "n'", ["rod_1", "A_1", "n_prime"]),
    ] {
        let composition = composed(&named(body, joint, parameter, &format!("2*{parameter}*t")));
        let warning = only(&composition, "D047");
        for (name, spelled) in [body, joint, parameter].iter().zip(spelled) {
            assert!(
                warning.message.contains(&format!("`{name}` is `{spelled}`")),
                "{}",
                warning.message
            );
        }
        let model = model(&composition);
        assert_eq!(model.bodies[1].name, spelled[0]);
        assert_eq!(model.joints[0].name, spelled[1]);
        assert_eq!(model.parameters[0].name, spelled[2]);
        // The reports have the author's names, and lead to those of the model.
        assert_eq!(composition.bodies[0].name, body);
        assert_eq!(composition.model_name(body), spelled[0]);
        assert_eq!(
            composition.drawn_words(&format!("body `{}`", spelled[0])),
            format!("body `{body}`")
        );
    }
    // Plain names are as they are, and nothing is said.
    assert_eq!(composed(&named("arm", "A", "n", "2*n*t")).diagnostics, []);
}

#[test]
fn a_model_file_beside_may_have_either_spelling() {
    let drawn = named("rod-1", "A", "n", "n*t").replace(" MASS=\"2 kg\"", "");
    for key in ["\"rod-1\"", "rod_1"] {
        let beside = format!(
            "[bodies.{key}]\nmass = \"3 kg\"\n[loads.f]\ntype = \"torque\"\non = {key}\nvalue = 1\n"
        );
        let beside = beside.replace("on = rod_1", "on = \"rod_1\"");
        let options = ModelOptions { sidecar: Some(&beside), ..ModelOptions::default() };
        let composition = composed_with(&drawn, options).expect("a drawing");
        let model = model(&composition);
        assert_eq!((model.bodies.len(), model.loads.len()), (2, 1), "{}", composition.text);
        // A fault of a value is still found where it stands.
        let at = composition.text.find("\"3 kg\"").expect("the mass");
        let here = beside.find("\"3 kg\"").expect("the mass");
        let origin = composition.origin(&(at..at + 6));
        assert_eq!(origin, bksim_cad::compose::Origin::Sidecar(here..here + 6));
    }
}

/// A rod of two lines and two arcs around two points, one end of the upper line moved by a gap, with
/// more strokes, the pin in its left end, and a body in it.
fn rod(gap: f64, more: &str, body: &str) -> String {
    format!(
        "LINE handle=31 at=0,-10 to=100,-10\n\
         LINE handle=32 at=0,10 to={},10\n\
         ARC handle=33 at=100,0 radius=10 from=-90 until=90\n\
         ARC handle=34 at=0,0 radius=10 from=90 until=270\n\
         CIRCLE handle=35 at=0,0 radius=4\n{more}\
         INSERT block=BK_BODY {body} NAME=rod DENSITY=\"7850 kg/m^3\" THICKNESS=10\n\
         INSERT block=BK_REVOLUTE at=0,0 NAME=A\n",
        100.0 - gap
    )
}

fn area(composition: &Composition) -> f64 {
    composition.bodies[0].area.expect("an outline").area
}

#[test]
fn a_doubled_line_is_named_and_the_outline_found_nevertheless() {
    let whole = composed(&rod(0.0, "", "at=50,0"));
    assert_eq!(whole.diagnostics, []);
    for copy in [
        "LINE handle=3A at=0,-10 to=100,-10\n",
        "LINE handle=3A at=100,-10 to=0,-10\n",
        "LINE handle=3A at=100,-10 to=60,-10\n",
        "ARC handle=3A at=0,0 radius=10 from=90 until=270\n",
        "LWPOLYLINE handle=3A closed=no points=\"0,-10 40,-10 100,-10\"\n",
    ] {
        let doubled = composed(&rod(0.0, copy, "at=50,0"));
        let warning = only(&doubled, "D027");
        assert!(words(&warning).contains("handle 3A"), "{copy}: {}", words(&warning));
        assert!((area(&doubled) / area(&whole) - 1.0).abs() < 1e-12, "{copy}");
        model(&doubled);
    }
    // By layer just as well.
    let layered = |list: &str| {
        list.replace("LINE ", "LINE layer=BK_BODY_rod ").replace("ARC ", "ARC layer=BK_BODY_rod ")
    };
    let copy = "LINE handle=3A at=0,-10 to=100,-10\n";
    only(&composed(&layered(&rod(0.0, copy, "at=50,0"))), "D027");
}

#[test]
fn a_gap_is_named_with_its_size_its_place_and_the_tolerance_that_closes_it() {
    // A frame around the sheet must not be taken for the outline, nor the hole of the pin.
    let frame = "LWPOLYLINE points=\"-200,-200 300,-200 300,200 -200,200\"\n";
    for (more, body) in [("", "at=50,0"), (frame, "at=50,0"), ("", "at=0,0"), (frame, "at=0,0")] {
        let list = rod(0.1, more, body);
        let fault = only(&composed(&list), "D020");
        let words = words(&fault);
        let parts = [
            "`rod`",
            "0.1 units",
            "(100, 10)",
            "(99.9, 10)",
            "handle 32",
            "handle 33",
            "--tolerance 0.11",
        ];
        for part in parts {
            assert!(words.contains(part), "{part} is not in {words}");
        }
        let options = ModelOptions { tolerance: Some(0.11), ..ModelOptions::default() };
        let composition = composed_with(&list, options).expect("a drawing");
        assert_eq!(faults(&composition, "D026").len(), 1, "{:#?}", composition.diagnostics);
        assert!((area(&composition) / 2264.0 - 1.0).abs() < 1e-3, "{}", area(&composition));
        model(&composition);
    }
    // What is open on purpose is no outline: an arrow's arc around the pin.
    let arrow = "ARC at=0,0 radius=15 from=20 until=330\n";
    assert_eq!(composed(&rod(0.0, arrow, "at=50,0")).diagnostics, []);
    // By layer.
    let layered = rod(0.1, "", "at=50,0")
        .replace("LINE ", "LINE layer=BK_BODY_rod ")
        .replace("ARC ", "ARC layer=BK_BODY_rod ");
    let words = words(&faults(&composed(&layered), "D020")[0]);
    assert!(words.contains("0.1 units") && words.contains("--tolerance 0.11"), "{words}");
}

#[test]
fn lines_that_meet_elsewhere_leave_the_outlines_alone() {
    let cross = "LINE at=400,0 to=500,0\nLINE at=400,0 to=450,50\nLINE at=400,0 to=450,-50\n";
    let composition = composed(&rod(0.0, cross, "at=50,0"));
    assert_eq!(composition.diagnostics, []);
    assert!((area(&composition) / 2264.0 - 1.0).abs() < 1e-3);
    // Where they meet at the outline itself, it is asked about.
    let line = "LINE handle=3A at=0,10 to=30,60\n";
    let fault = only(&composed(&rod(0.0, line, "at=50,0")), "D021");
    assert!(words(&fault).contains("handle 3A"), "{}", words(&fault));
}
