//! Outlines in the forms that other and older programs write: polylines with heights, filled areas, Bézier pieces, line ends
//! of one byte, blocks whose ends are stated twice or not at all, curves drawn twice.

use bksim_cad::compose::Composition;
use bksim_cad::model::{ModelOptions, Refused, sheet};
use bksim_cad::patch::apply;

/// A drawing in millimetres: groups are divided by bars, a code and a value each.
fn dxf(blocks: &str, entities: &str) -> String {
    let sections = [
        "0 SECTION|2 HEADER|9 $INSUNITS|70 4|0 ENDSEC".to_owned(),
        format!("0 SECTION|2 BLOCKS|{blocks}|0 ENDSEC"),
        format!("0 SECTION|2 ENTITIES|{entities}|0 ENDSEC|0 EOF"),
    ];
    let groups = sections.iter().flat_map(|section| section.split('|'));
    let lines = groups.filter(|group| !group.is_empty()).map(|group| {
        let (code, value) = group.split_once(' ').unwrap_or((group, ""));
        format!("{code}\n{value}\n")
    });
    lines.collect()
}

#[track_caller]
fn composed(bytes: Vec<u8>) -> Composition {
    let sheet = sheet(bytes, None);
    let sheet = sheet.unwrap_or_else(|Refused { diagnostics, .. }| panic!("{diagnostics:#?}"));
    sheet.compose(ModelOptions::default())
}

/// The area of the only body, mm², and the codes of what is said but for its mass.
#[track_caller]
fn area(text: &str) -> (Option<f64>, Vec<&'static str>) {
    let composition = composed(text.as_bytes().to_vec());
    let codes = composition.diagnostics.iter().map(|fault| fault.code.0);
    let codes = codes.filter(|code| *code != "D043").collect();
    (composition.bodies[0].area.as_ref().map(|area| area.area), codes)
}

#[track_caller]
fn assert_area(text: &str, expected: f64, codes: &[&str]) {
    let (found, said) = area(text);
    let found = found.unwrap_or_else(|| panic!("no outline is closed: {said:?}"));
    assert!((found - expected).abs() < 1e-6 * expected, "{found} is not {expected}");
    assert_eq!(said, codes);
}

/// The plate of 100 mm by 20 mm as a polyline with these flags, its corners at these heights.
fn polyline(flags: u8, heights: [f64; 4]) -> String {
    let corners = [[0, 0], [100, 0], [100, 20], [0, 20]];
    let vertices = corners.iter().zip(heights).map(|([x, y], z)| {
        format!("0 VERTEX|8 BK_BODY_plate|10 {x}|20 {y}|30 {z}|70 {}|", u32::from(flags & 8) * 4)
    });
    let vertices: String = vertices.collect();
    format!("0 POLYLINE|8 BK_BODY_plate|66 1|70 {flags}|10 0|20 0|30 0|{vertices}0 SEQEND|8 0")
}

const HOLE: &str = "0 CIRCLE|8 BK_BODY_plate|10 50|20 10|40 5";
const PLATE: &str =
    "0 LWPOLYLINE|8 BK_BODY_plate|90 4|70 1|10 0|20 0|10 100|20 0|10 100|20 20|10 0|20 20";
const WITH_HOLE: f64 = 2000.0 - 25.0 * std::f64::consts::PI;

#[test]
fn a_polyline_with_heights_is_an_outline_where_they_are_equal() {
    for height in [0.0, 7.0] {
        for flags in [1, 9] {
            let text = dxf("", &format!("{}|{HOLE}", polyline(flags, [height; 4])));
            assert_area(&text, WITH_HOLE, &[]);
        }
    }
    // One that is tilted is passed over, and that is said.
    let (_, codes) = area(&dxf("", &format!("{}|{HOLE}", polyline(9, [0.0, 0.0, 5.0, 0.0]))));
    assert_eq!(codes, ["D028"]);
}

#[test]
fn a_filled_area_is_an_outline_with_its_corners_crosswise() {
    let corners = "10 0|20 0|11 100|21 0|12 0|22 20|13 100|23 20";
    for kind in ["SOLID", "TRACE"] {
        let solid = format!("0 {kind}|8 BK_BODY_plate|{corners}");
        assert_area(&dxf("", &solid), 2000.0, &[]);
        // Lines around it are the outline then.
        assert_area(&dxf("", &format!("{solid}|{PLATE}|{HOLE}")), WITH_HOLE, &[]);
    }
    // With lines that are not around it, it is an outline among theirs; twice, it counts once.
    let solid = format!("0 SOLID|8 BK_BODY_plate|{corners}");
    assert_area(&dxf("", &format!("{solid}|{HOLE}")), WITH_HOLE, &[]);
    assert_area(&dxf("", &format!("{HOLE}|{solid}|{solid}")), WITH_HOLE, &["D027"]);
    let window =
        "0 LWPOLYLINE|8 BK_BODY_plate|90 4|70 1|10 30|20 5|10 50|20 5|10 50|20 15|10 30|20 15";
    assert_area(&dxf("", &format!("{solid}|{window}")), 1800.0, &[]);
    let beside = "0 3DFACE|8 BK_BODY_plate|10 200|20 0|30 0|11 250|21 0|31 0|12 250|22 20|32 0|13 200|23 20|33 0";
    assert_area(&dxf("", &format!("{PLATE}|{beside}")), 3000.0, &[]);
    // What fills a part of an outline, or its whole in two halves, is no hole.
    let part = "0 SOLID|8 BK_BODY_plate|10 0|20 0|11 60|21 0|12 0|22 20|13 60|23 20";
    let rest = "0 SOLID|8 BK_BODY_plate|10 60|20 0|11 100|21 0|12 60|22 20|13 100|23 20";
    assert_area(&dxf("", &format!("{PLATE}|{part}|{rest}|{HOLE}")), WITH_HOLE, &[]);
    let within = "0 SOLID|8 BK_BODY_plate|10 10|20 5|11 20|21 5|12 10|22 15|13 20|23 15";
    assert_area(&dxf("", &format!("{PLATE}|{within}|{HOLE}")), WITH_HOLE, &[]);
    let triangle = "0 SOLID|8 BK_BODY_plate|10 0|20 0|11 100|21 0|12 0|22 20|13 0|23 20";
    assert_area(&dxf("", triangle), 1000.0, &[]);
    let face = "0 3DFACE|8 BK_BODY_plate|10 0|20 0|30 0|11 100|21 0|31 0|12 100|22 20|32 0|13 0|23 20|33 0";
    assert_area(&dxf("", face), 2000.0, &[]);
}

/// A hatch of one border of lines, its corners in millimetres.
fn hatch(corners: [[f64; 2]; 4]) -> String {
    let points = corners.map(|[x, y]| format!("|10 {x}|20 {y}")).concat();
    let border = format!("91 1|92 3|72 0|73 1|93 4{points}|97 0");
    let plane = "10 0|20 0|30 0|210 0|220 0|230 1";
    format!(
        "0 HATCH|100 AcDbEntity|8 BK_BODY_plate|100 AcDbHatch|{plane}|2 SOLID|70 1|71 0|{border}|75 0|76 1|98 0"
    )
}

#[test]
fn a_hatch_apart_from_the_lines_is_an_outline_of_its_own() {
    let at = |x: f64, y: f64| [[x, y], [x + 40.0, y], [x + 40.0, y + 10.0], [x, y + 10.0]];
    assert_area(&dxf("", &hatch(at(0.0, 0.0))), 400.0, &[]);
    assert_area(
        &dxf("", &format!("{PLATE}|{HOLE}|{}", hatch(at(200.0, 0.0)))),
        WITH_HOLE + 400.0,
        &[],
    );
    // Within the lines, across them, and with a corner on them it shows material that is drawn.
    for (x, y) in [(0.0, 0.0), (5.0, 5.0), (80.0, 15.0), (100.0, 20.0)] {
        assert_area(&dxf("", &format!("{PLATE}|{HOLE}|{}", hatch(at(x, y)))), WITH_HOLE, &[]);
    }
}

/// A spline of this degree through control points, every piece a Bézier curve of its own.
fn bezier(degree: usize, control: &[[f64; 2]]) -> String {
    let n_pieces = control.len() / (degree + 1);
    let knots = (0..=n_pieces).flat_map(|k| std::iter::repeat_n(k, degree + 1));
    let knots = knots.map(|k| format!("|40 {k}")).collect::<Vec<_>>().concat();
    let points = control.iter().map(|[x, y]| format!("|10 {x}|20 {y}|30 0"));
    let points = points.collect::<Vec<_>>().concat();
    let [n_knots, n] = [control.len() + degree + 1, control.len()];
    format!("0 SPLINE|8 BK_BODY_disc|70 8|71 {degree}|72 {n_knots}|73 {n}|74 0{knots}{points}")
}

#[test]
fn a_spline_of_bezier_pieces_hangs_together_where_their_ends_are_one() {
    // Four cubic arcs that stand for a circle; the area of each by the integral of x dy over its polynomial.
    let (r, k) = (50.0, 50.0 * 0.552_284_749_8);
    let quarter = [[r, 0.0], [r, k], [k, r], [0.0, r]];
    let turned = |n: usize, [x, y]: [f64; 2]| match n {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    };
    let circle: Vec<[f64; 2]> = (0..4).flat_map(|n| quarter.map(|p| turned(n, p))).collect();
    let cross = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| ax * by - ay * bx;
    let [a, b, c, d] = quarter;
    let sector = 0.3 * cross(a, b)
        + 0.15 * cross(a, c)
        + 0.05 * cross(a, d)
        + 0.15 * cross(b, c)
        + 0.15 * cross(b, d)
        + 0.3 * cross(c, d);
    assert_area(&dxf("", &bezier(3, &circle)), 4.0 * sector, &[]);

    let square = [[0.0, 0.0], [100.0, 0.0], [100.0, 20.0], [0.0, 20.0], [0.0, 0.0]];
    let sides = square.windows(2).flat_map(|pair| [pair[0], pair[1]]);
    assert_area(&dxf("", &bezier(1, &sides.collect::<Vec<_>>())), 2000.0, &[]);

    // A piece that begins elsewhere breaks the curve.
    let mut broken = circle;
    broken[4][0] += 0.3;
    let (found, codes) = area(&dxf("", &bezier(3, &broken)));
    assert_eq!((found, codes), (None, vec!["D025"]));
}

#[test]
fn line_ends_of_old_programs_are_read_and_kept() {
    let text = dxf("", PLATE).replace('\n', "\r");
    assert_area(&text, 2000.0, &[]);
    let patched = apply(text.clone().into_bytes(), &[]).expect("a drawing");
    assert_eq!(String::from_utf8(patched.bytes).expect("text"), text);
    // A fault in it has its line.
    let bad = text.replace("20\r20\r", "20\rtwenty\r");
    let refused = sheet(bad.into_bytes(), None).expect_err("no number");
    assert!(refused.diagnostics[0].message.contains("on line"), "{:?}", refused.diagnostics);
    assert!(refused.text.lines().count() > 20, "its lines can be shown");
}

#[test]
fn what_is_drawn_twice_counts_once_and_is_named() {
    let rotated =
        "0 LWPOLYLINE|8 BK_BODY_plate|90 4|70 1|10 100|20 20|10 100|20 0|10 0|20 0|10 0|20 20";
    let arcs = "0 ARC|8 BK_BODY_plate|10 50|20 10|40 5|50 0|51 180|0 ARC|8 BK_BODY_plate|10 50|20 10|40 5|50 180|51 360";
    for (more, n_copies) in [
        (HOLE.to_owned(), 1),
        (format!("{HOLE}|{HOLE}"), 2),
        (PLATE.to_owned(), 1),
        (rotated.to_owned(), 1),
        (arcs.to_owned(), 2),
        (format!("{HOLE}|{rotated}"), 2),
    ] {
        let text = dxf("", &format!("{PLATE}|{HOLE}|{more}"));
        assert_area(&text, WITH_HOLE, &vec!["D027"; n_copies]);
    }
    // A hole of another size is none of it.
    let (_, codes) =
        area(&dxf("", &format!("{PLATE}|{HOLE}|0 CIRCLE|8 BK_BODY_plate|10 50|20 10|40 6")));
    assert!(!codes.contains(&"D027"), "{codes:?}");
}

#[test]
fn blocks_end_once_whatever_the_file_says() {
    let block = |name: &str, end: &str| {
        format!("0 BLOCK|8 0|2 {name}|10 0|20 0|0 CIRCLE|8 0|10 0|20 0|40 2{end}")
    };
    let end = "|0 ENDBLK|5 1D|8 0";
    let whole = format!("{}|{}", block("BOLT", end), block("NUT", end));
    let inserts = "|0 INSERT|8 0|2 BOLT|10 200|20 0|0 INSERT|8 0|2 NUT|10 300|20 0";
    let entities = format!("{PLATE}{inserts}");
    assert_area(&dxf(&whole, &entities), 2000.0, &[]);
    // Its groups twice; the whole of it twice; one that is on paper.
    for twice in
        ["|0 ENDBLK|5 1D|8 0|5 1E|67 1|8 0", "|0 ENDBLK|8 0|0 ENDBLK|8 0", "|0 ENDBLK|67 1|8 0"]
    {
        let blocks = format!("{}|{}", block("BOLT", twice), block("NUT", end));
        assert_area(&dxf(&blocks, &entities), 2000.0, &[]);
    }
    for (first, second, n) in [("", end, 1), (end, "", 1), ("", "", 2)] {
        let blocks = format!("{}|{}", block("BOLT", first), block("NUT", second));
        assert_area(&dxf(&blocks, &entities), 2000.0, &vec!["D076"; n]);
        let drawn = composed(dxf(&blocks, &entities).into_bytes());
        let about = |fault: &&bksim_model::diagnostic::Diagnostic| fault.code.0 == "D076";
        let fault = drawn.diagnostics.iter().find(about).expect("a warning");
        assert!(fault.message.contains(if first.is_empty() { "`BOLT`" } else { "`NUT`" }));
        assert_eq!(fault.labels.len(), 1, "its line is shown");
    }
}

#[test]
fn what_is_left_out_on_a_layer_of_shapes_is_said_by_every_reader() {
    let ray = "0 RAY|8 BK_BODY_plate|10 0|20 0|11 1|21 0";
    let misspelt = "0 CIRCLE|8 BK_BODDY_wheel|10 300|20 0|40 9";
    let (_, codes) = area(&dxf("", &format!("{PLATE}|{ray}|{misspelt}")));
    assert_eq!(codes, ["D050", "D049"]);
    // Elsewhere it is the sheet's.
    let (_, codes) = area(&dxf("", &format!("{PLATE}|0 RAY|8 sheet|10 0|20 0|11 1|21 0")));
    assert_eq!(codes, Vec::<&str>::new());
}

#[test]
fn a_thousand_findings_take_no_longer_than_a_thousand_entities() {
    let twice = |k: usize| {
        let line = format!("0 LINE|8 0|10 {k}|20 {}|11 {}|21 9", k % 97, k + 5);
        format!("{line}|{line}")
    };
    let entities: Vec<String> = (0..3000).map(twice).collect();
    let text = dxf("", &format!("{PLATE}|{}", entities.join("|")));
    let begun = std::time::Instant::now();
    let report = bksim_cad::doctor::examine(text.into_bytes(), ModelOptions::default());
    let n = report.findings.iter().filter(|finding| finding.fault.code.0 == "D027").count();
    assert_eq!(n, 3000);
    // A quarter of a second on an idle machine; comparing each with each took minutes.
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
}
