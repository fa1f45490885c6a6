//! Models of other programs: their text, their faults, and that they move as their files say.
//!
//! The numbers are those of two independent programs each, to 14 digits: sums of body Jacobians by own code, held
//! against mujoco 4.0 and pinocchio 4.1.

use bksim::import::{Base, Imported, import};
use bksim::sim::Mechanism;

use crate::support::{Measures, Within, close, coordinate, derive, model, solve};

fn imported(name: &str, text: &str) -> Imported {
    import(name, text.as_bytes(), &|_| None, Base::Fixed)
}

/// The model of a file that has no errors.
pub(crate) fn text_of(name: &str, text: &str) -> String {
    let imported = imported(name, text);
    imported.model.unwrap_or_else(|| panic!("{name}: {:?}", imported.faults))
}

/// The text without the tables whose names end so.
pub(crate) fn without(text: &str, endings: &[&str]) -> String {
    let mut is_kept = true;
    let mut kept = String::new();
    for line in text.lines() {
        if let Some(table) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            is_kept = !endings.iter().any(|ending| table.ends_with(ending));
        }
        if is_kept {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

/// Values of coordinates and their accelerations at the start with `initial`.
pub(crate) fn at_start(text: &str, initial: &str) -> (Mechanism, Vec<f64>, Vec<f64>) {
    let text = without(text, &["initial"]);
    let text = format!("{text}\n[initial]\n{initial}\n[solve]\nt_end = 1e-6\nevery = 1e-6\n");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let first = &motion.samples[0];
    let (q, a) = (first.q.clone(), first.a.clone());
    (mechanism, q, a)
}

#[track_caller]
pub(crate) fn check(text: &str, initial: &str, expected: &[(&str, f64, f64)]) {
    let (mechanism, q, a) = at_start(text, initial);
    let largest = expected.iter().fold(0.0_f64, |most, (.., a)| most.max(a.abs()));
    for &(name, position, acceleration) in expected {
        let idx = coordinate(&mechanism, name);
        close(name, q[idx], position, Within { relative: 0.0, absolute: 1e-12 });
        let within = Within { relative: 0.0, absolute: 1e-8 * largest };
        close(&format!("acceleration of {name}"), a[idx], acceleration, within);
    }
}

#[test]
fn a_loop_of_sdf_closes_and_accelerates_with_its_springs() {
    let text = text_of("four_bar.sdf", include_str!("../fixtures/import/four_bar.sdf"));
    let initial = "A = { angle = -0.05248, rate = 0.05686 }";
    check(
        &text.replace("[joints.C]\n", "[joints.C]\ncut = true\n"),
        initial,
        &[
            ("A_angle", -0.05248, 56.986_695_879_147),
            ("B_angle", 0.078_341_064_899_59, -84.622_130_131_013),
            ("D_angle", 0.024_485_409_209_201, -24.654_145_269_419),
        ],
    );
}

/// Loops of SDF are closed where the file has its links: a limit that excludes this is left out, and named.
#[test]
fn limits_that_exclude_the_poses_of_a_loop_are_left_out() {
    let file = include_str!("../fixtures/import/four_bar.sdf");
    let limit = "<limit><lower>0.2</lower><upper>1</upper></limit>";
    let limited = file.replacen("</axis>", &format!("{limit}</axis>"), 1);
    let imported = imported("four_bar.sdf", &limited);
    let text = imported.model.expect("a model");
    assert!(!text.contains("type = \"stop\""), "{text}");
    let named =
        imported.left_out.iter().filter(|it| it.what.contains("excludes the poses")).count();
    assert_eq!(named, 1, "{:?}", imported.left_out);
    let kept = file.replacen("</axis>", &format!("{}</axis>", limit.replace("0.2", "-0.2")), 1);
    assert!(text_of("four_bar.sdf", &kept).contains("min = -0.2\nmax = 1"));
}

/// Bounds hold for principal moments, whichever axes these have, and a box from point to point has a square section. About the axis
/// u the body has I + m (r² − (r·u)²), with I = 0.01 by the bound or (m/12) (4 a² + …) of the box, and the weight m (r × g)·u.
#[test]
fn moments_are_bounded_about_their_own_axes_and_boxes_between_points_are_square() {
    let robot = |bound: &str, part: &str| {
        format!(
            "<mujoco><compiler {bound}/><worldbody><body name=\"a\"><joint name=\"j\" axis=\"0 1 0\"/>{part}</body></worldbody></mujoco>"
        )
    };
    let turned = "<inertial pos=\"0.2 0.5 0.1\" mass=\"2\" euler=\"20 30 40\" diaginertia=\"0.001 0.0012 0.0015\"/>";
    let text = text_of("a.xml", &robot("boundinertia=\"0.01\"", turned));
    check(
        &text,
        "",
        &[("j_angle", 0.0, 2.0 * 9.81 * 0.2 / (0.01 + 2.0 * (0.2 * 0.2 + 0.1 * 0.1)))],
    );
    let rod = "<geom type=\"box\" fromto=\"0 0 0 0.4 0 0\" size=\"0.05 0.02\" mass=\"3\"/>";
    let text = text_of("a.xml", &robot("", rod));
    let inertia = 3.0 / 12.0 * (0.1 * 0.1 + 0.4 * 0.4) + 3.0 * 0.2 * 0.2;
    check(&text, "", &[("j_angle", 0.0, 3.0 * 9.81 * 0.2 / inertia)]);
}

/// Fourteen rods on stops, which have 2¹⁴ cases: those with their weight on one side rest on their stops, the others fall off
/// with m g x/(I + m x²).
#[test]
fn many_joints_start_at_their_limits() {
    let rod = |k: usize| {
        let x = if k.is_multiple_of(3) { -0.2 } else { 0.1 * (1 + k) as f64 };
        let body = format!(
            "<link name=\"rod{k}\"><inertial><origin xyz=\"{x} 0 0\"/><mass value=\"2\"/>\
             <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        );
        let joint = format!(
            "<joint name=\"j{k}\" type=\"revolute\"><parent link=\"base\"/><child link=\"rod{k}\"/>\
             <axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"1\" effort=\"0\" velocity=\"0\"/></joint>"
        );
        (x, body + &joint)
    };
    let rods: Vec<(f64, String)> = (0..14).map(rod).collect();
    let all: String = rods.iter().map(|(_, text)| text.as_str()).collect();
    let text =
        text_of("star.urdf", &format!("<robot name=\"star\"><link name=\"base\"/>{all}</robot>"));
    let (mechanism, _, a) = at_start(&text, "");
    for (k, (x, _)) in rods.iter().enumerate() {
        let falls = 2.0 * 9.81 * x / (0.1 + 2.0 * x * x);
        let within = Within { relative: 0.0, absolute: 1e-9 };
        close(
            &format!("j{k}"),
            a[coordinate(&mechanism, &format!("j{k}_angle"))],
            falls.max(0.0),
            within,
        );
    }
}

/// Two axes of a universal joint at 45°. By hand: about the joint the body has (1, 2 + 2·0.09, 3 + 2·0.09) kg m², so that
/// M = [1, 1/√2; 1/√2, 1.59], and its weight turns it by 0.3·2·9.81/√2 about the second axis.
#[test]
fn axes_of_a_universal_joint_need_not_be_square() {
    let sdf = r#"<sdf version="1.9"><model name="skew"><link name="bob"><inertial><pose>0.3 0 0 0 0 0</pose><mass>2</mass>
      <inertia><ixx>1</ixx><iyy>2</iyy><izz>3</izz></inertia></inertial></link>
      <joint name="U" type="universal"><parent>world</parent><child>bob</child>
      <axis><xyz>1 0 0</xyz></axis><axis2><xyz>1 1 0</xyz></axis2></joint></model></sdf>"#;
    let expected = [("U_angle", 0.0, -2.7), ("U_2_angle", 0.0, 5.4 / 2.0_f64.sqrt())];
    check(&text_of("skew.sdf", sdf), "U = { angle = 0 }", &expected);
}

#[test]
fn a_loop_closed_by_connect_accelerates_as_with_hard_constraints() {
    let file = include_str!("../fixtures/import/four_bar_connect.xml");
    let text = without(&text_of("four_bar.xml", file), &["_damping", "_limit"]);
    check(
        &text,
        "B = { angle = 0.359288, rate = -0.0869585 }",
        &[
            ("A_angle", -0.246_581_173_435_58, 73.442_149_354_603),
            ("B_angle", 0.359_288, -103.208_458_666_94),
            ("D_angle", 0.082_970_796_969_755, -12.436_736_182_46),
        ],
    );
}

#[test]
fn equalities_of_joints_are_polynomials_from_their_references() {
    let text = text_of("gears.xml", include_str!("../fixtures/import/gears.xml"));
    check(
        &without(&text, &["_spring", "initial"]),
        "w2 = { angle = 0.40433, rate = 0.993595 }",
        &[
            ("w1_angle", -0.041_525_080_126_459, -3.558_950_455_567_8),
            ("w2_angle", 0.404_33, 9.078_960_565_085),
            ("s_position", 0.010_301_809_305_227, 0.477_422_885_247_37),
        ],
    );
    assert!(text.contains("body \"wheel 1\" is wheel_1"), "{text}");
}

#[test]
fn chains_of_mimic_joints_move_as_one() {
    let imported = imported("mimic.urdf", include_str!("../fixtures/import/mimic.urdf"));
    let text = imported.model.expect("a model");
    // The bias over the mass of the one coordinate that moves them all.
    let knuckle = -0.231_764_767_202_34 / 0.010_968_016_939_638;
    check(
        &text,
        "j_knuckle = { angle = 0.356011, rate = 0.717062 }\n\
         j_wheel = { angle = -0.740477, rate = 0.0985765 }",
        &[
            ("j_knuckle_angle", 0.356_011, knuckle),
            ("j_wheel_angle", -0.740_477, 0.0),
            ("j_middle_angle", 0.634_016_5, 1.5 * knuckle),
            ("j_tip_angle", 0.457_213_2, 1.2 * knuckle),
            ("j_slide_position", -0.014_240_44, -0.04 * knuckle),
        ],
    );
    let renamed = &imported.renamed[0];
    assert_eq!((renamed.from.as_str(), renamed.to.as_str()), ("j tip", "j_tip"));
    // Efforts and speeds of four joints are left out, each with its line.
    assert_eq!(imported.left_out.len(), 4, "{:?}", imported.left_out);
}

#[test]
fn importing_twice_gives_the_same_text() {
    let files = [
        ("four_bar.sdf", include_str!("../fixtures/import/four_bar.sdf")),
        ("gears.xml", include_str!("../fixtures/import/gears.xml")),
        ("mimic.urdf", include_str!("../fixtures/import/mimic.urdf")),
        ("slider_crank.adm", include_str!("../fixtures/import/slider_crank.adm")),
    ];
    for (name, text) in files {
        assert_eq!(imported(name, text), imported(name, text), "{name}");
    }
}

/// x = r cos θ + √(l² − r² sin² θ), θ = 30° + 2 t, in millimetres of the file.
#[test]
fn a_slider_crank_of_adams_follows_its_motion() {
    let file = include_str!("../fixtures/import/slider_crank.adm");
    let imported = imported("slider_crank.adm", file);
    let text = imported.model.unwrap_or_else(|| panic!("{:?}", imported.faults));
    let mechanism = derive(model(&format!("{text}\n[solve]\nt_end = 0.5\nevery = 0.25\n")));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["slider.x", "slider.y", "A.angle"]);
    for sample in &motion.samples {
        let theta = 30_f64.to_radians() + 2.0 * sample.t;
        let x = 0.1 * theta.cos() + (0.09 - (0.1 * theta.sin()).powi(2)).sqrt();
        let within = Within { relative: 0.0, absolute: 1e-9 };
        for (what, found, expected) in [("x", 0, x), ("y", 1, 0.0), ("angle", 2, theta)] {
            close(what, measures.at(sample)[found], expected, within);
        }
    }
    assert!(text.contains("5e-3 N m*(") || text.contains("0.001 N m*(-5*"), "{text}");
    assert!(text.contains("stiffness = 2000"), "2 N/mm: {text}");
    let left: Vec<&str> = imported.left_out.iter().map(|part| part.what.as_str()).collect();
    assert_eq!(left, ["REQUEST/1"]);
}

/// Row of the crank-rocker with a coupler point at 0.4 rad more than drawn: meeting points of circles.
#[test]
fn a_link_of_pmks_has_the_positions_of_its_joints() {
    let link = "?2O.Fe.K,0.1011.MA,A,0,0,0.GB,B,9O,CW,0.GC,C,o0,bW,0.KD,D,_W,0,0.GE,E,VG,mS,0..\
        YRAB,AB,Im,4i,4i,6G,c5cae9,A,B,,.YRBCE,BCE,VG,HC,Ti,Wq,c5cae9,B,C,E,,.YRCD,CD,NS,CW,uG,Im,c5cae9,C,D,,...N_z";
    let text = text_of("link", link);
    let text = format!("{text}\n[solve]\nt_end = 0.1\nevery = 0.1\n");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let names = ["AB.B.x", "AB.B.y", "BCE.C.x", "BCE.C.y", "BCE.E.x", "BCE.E.y"];
    let drawn = Measures::new(&mechanism, &names).at(&motion.samples[0]);
    for (found, expected) in drawn.into_iter().zip([0.6, 0.8, 3.2, 2.4, 2.0, 3.1]) {
        close("as drawn", found, expected, Within { relative: 0.0, absolute: 1e-12 });
    }
    // After a tenth of a second at 20 rev/min the crank has turned by 12°.
    let last = Measures::new(&mechanism, &names).at(&motion.samples[1]);
    let theta = 0.8_f64.atan2(0.6) + 12_f64.to_radians();
    close("B", last[0], theta.cos(), Within { relative: 0.0, absolute: 1e-9 });
    let bar = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let within = Within { relative: 0.0, absolute: 1e-9 };
    close("rod", bar([last[0], last[1]], [last[2], last[3]]), 2.6_f64.hypot(1.6), within);
    close("rocker", bar([4.0, 0.0], [last[2], last[3]]), 0.8_f64.hypot(2.4), within);
    close("coupler", bar([last[2], last[3]], [last[4], last[5]]), 1.2_f64.hypot(0.7), within);
}

#[test]
fn faults_are_at_the_line_that_they_are_about() {
    let urdf = "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n\
        <joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/>\n\
        <mimic joint=\"k\"/></joint>\n</robot>";
    let found = imported("r.urdf", urdf);
    assert!(found.model.is_some(), "a mimic joint of none is a warning");
    let fault = &found.faults[0].diagnostic;
    assert_eq!((fault.code.0, fault.is_error()), ("I005", false));
    let line = bksim::import::line_of(urdf, fault.labels[0].span.start);
    assert_eq!(line, 5);
    // Any bytes lead to faults or a text.
    for cut in 0..urdf.len() {
        let _ = imported("r.urdf", &urdf[..cut]);
        let _ = imported("r.adm", &urdf[..cut]);
    }
}

/// A four-bar in space by MuJoCo's words, its rocker turned by a quarter of a turn that is off by `tilt`.
fn rounded_four_bar(tilt: f64) -> Imported {
    let page = include_str!("../../docs/diagnostics/I027.md");
    let text = page.split("```xml four_bar.xml\n").nth(1).expect("a file");
    let text = text.split("```").next().expect("its end");
    let turn = std::f64::consts::FRAC_PI_2 + tilt;
    imported("four_bar.xml", &text.replace("1.5708 0 0", &format!("{turn:?} 0 0")))
}

/// Rigid by its digits, the loop moves as that of the exact file, away from the pose of the file, too.
#[test]
fn a_flat_loop_moves_though_its_axes_are_rounded() {
    let initial = "A = { angle = -0.35 }";
    let exact = rounded_four_bar(0.0).model.expect("a model");
    assert!(!exact.contains("straightened"), "{exact}");
    let (mechanism, q, _) = at_start(&exact, initial);
    let start = mechanism.start().expect("a start");
    assert_eq!(start.mobility, 1);
    for tilt in [1e-11, 3.7e-6, -1e-5, 5e-5] {
        let found = rounded_four_bar(tilt);
        let faults: Vec<&str> = found.faults.iter().map(|fault| fault.diagnostic.code.0).collect();
        let told: &[&str] = if tilt.abs() > 1e-6 { &["I027"] } else { &[] };
        assert_eq!(faults, told, "{tilt}");
        let text = found.model.expect("a model");
        let (mechanism, near, _) = at_start(&text, initial);
        let start = mechanism.start().expect("a start");
        assert_eq!(start.mobility, 1, "{tilt}");
        assert!(start.position_residual < 1e-12, "{tilt}: {}", start.position_residual);
        for (one, other) in q.iter().zip(&near) {
            assert!((one - other).abs() < 2.0 * tilt.abs(), "{tilt}: {one} {other}");
        }
    }
    // Axes that lean on purpose stay.
    let leaning = rounded_four_bar(1e-3).model.expect("a model");
    assert!(!leaning.contains("straightened"), "{leaning}");
}

/// The pose of the file closes the loop that `connect` makes, though another way round it is shorter.
#[test]
fn a_loop_starts_in_the_pose_of_its_file() {
    let text = r#"<mujoco model="loop"><compiler angle="radian"/><worldbody>
      <body name="a" pos="0.1 0 0.2" euler="0.7 0.4 0.2"><joint name="A" type="ball"/>
        <geom type="box" size="0.1 0.05 0.07" mass="1"/>
        <body name="b" pos="0.2 0.1 0" euler="0.1 0.6 -0.8"><joint name="B" type="slide" axis="1 0.5 0.2"/>
          <geom type="box" size="0.1 0.05 0.07" mass="1"/>
          <body name="c" pos="-0.1 0 0.1" euler="-0.3 -0.5 -0.3"><joint name="C" type="ball" pos="0 0.03 0.04"/>
            <geom type="box" size="0.1 0.05 0.07" mass="1"/></body></body></body>
      <body name="d" pos="-0.2 0.1 0"><joint name="D" axis="0.3 0.2 1"/>
        <geom type="box" size="0.1 0.05 0.07" mass="1"/></body>
    </worldbody><equality><connect name="E" body1="c" body2="d" anchor="-0.1 -0.07 -0.04"/></equality></mujoco>"#;
    let start = derive(model(&text_of("loop.xml", text))).start().expect("a start");
    let is_zero = |value: &f64| value.abs() < 1e-12 || (value - 1.0).abs() < 1e-12;
    assert!(start.q.iter().all(is_zero), "{:?}", start.q);
}

/// Forces on one part alone, and an orientation that is kept: a part that cannot turn moves by the sum of its forces, wherever
/// they act.
#[test]
fn a_part_of_adams_that_keeps_its_orientation_moves_by_forces_on_it_alone() {
    let text = "bracket\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\n\
        MARKER/11, PART=1, QP=100,0,0, REULER=0,0.3,0\nMARKER/12, PART=1, QP=0,0,0, REULER=0.4,0.8,0.2\n\
        PART/2, MASS=2, CM=20, IP=2e4,3e4,4e4, QG=300,200,100, REULER=0.4,0.8,0.2\nMARKER/20, PART=2, QP=10,20,30\n\
        MARKER/21, PART=2, QP=90,-40,0, REULER=0.1,1.2,0.7\nMARKER/22, PART=2, QP=0,0,0\n\
        JPRIM/1, ORIENTATION, I=22, J=12\nSFORCE/1, TRANSLATION, I=21, J=11, ACTIONONLY, FUNCTION=5\n\
        SFORCE/2, TRANSLATION, I=20, J=21, ACTIONONLY, FUNCTION=-3\nSFORCE/3, ROTATION, I=21, J=11, ACTIONONLY, FUNCTION=700\n\
        ACCGRAV/KGRAV=-9810\nEND\n";
    let imported = text_of("bracket.adm", text);
    assert!(!imported.contains("SFORCE/"), "nothing is left out: {imported}");
    let text = format!("{imported}\n[solve]\nt_end = 1e-6\nevery = 1e-6\n");
    let mechanism = derive(model(&text));
    let a = solve(&mechanism).samples[0].a.clone();
    // z of marker 11, and of marker 21 seen from the ground: z-x-z of the marker in z-x-z of the part.
    let euler = |[a, b, c]: [f64; 3], v: [f64; 3]| {
        let about_z =
            |t: f64, [x, y, z]: [f64; 3]| [x * t.cos() - y * t.sin(), x * t.sin() + y * t.cos(), z];
        let about_x =
            |t: f64, [x, y, z]: [f64; 3]| [x, y * t.cos() - z * t.sin(), y * t.sin() + z * t.cos()];
        about_z(a, about_x(b, about_z(c, v)))
    };
    let up = [0.0, 0.0, 1.0];
    let fixed = euler([0.0, 0.3, 0.0], up);
    let turning = euler([0.4, 0.8, 0.2], euler([0.1, 1.2, 0.7], up));
    for (k, name) in ["part_2_x", "part_2_y", "part_2_z"].into_iter().enumerate() {
        let expected = (5.0 * fixed[k] - 3.0 * turning[k]) / 2.0 - 9.81 * up[k];
        let found = a[coordinate(&mechanism, name)];
        close(name, found, expected, Within { relative: 0.0, absolute: 1e-9 });
    }
}

/// A file of MuJoCo has its bodies where joints are at `ref`, and begins to move there; bodies whose mass is stated keep it
/// where shapes are to give masses and there are none.
#[test]
fn a_joint_of_mujoco_starts_at_its_reference() {
    let text = r#"<mujoco model="pendulum"><compiler angle="radian" inertiafromgeom="true"/><worldbody>
      <body name="bob" euler="0 0.5 0"><joint name="A" axis="0 1 0" ref="0.7"/>
        <inertial pos="0.3 0 0" mass="2" diaginertia="0.01 0.02 0.03"/></body>
    </worldbody></mujoco>"#;
    let imported = text_of("pendulum.xml", text);
    let mechanism = derive(model(&format!("{imported}\n[solve]\nt_end = 1e-6\nevery = 1e-6\n")));
    let first = solve(&mechanism).samples[0].clone();
    let at = coordinate(&mechanism, "A_angle");
    close("angle", first.q[at], 0.7, Within { relative: 0.0, absolute: 1e-12 });
    // The bar leans down by half a radian from x, whatever the joint counts.
    let expected = 2.0 * 9.81 * 0.3 * 0.5_f64.cos() / (0.02 + 2.0 * 0.09);
    close("acceleration", first.a[at], expected, Within { relative: 1e-10, absolute: 0.0 });
}

/// A flat loop of pins alone is a rigid frame by less: its axes are made parallel from 1e-9 rad on.
#[test]
fn a_loop_of_pins_moves_though_its_axes_are_off_by_hundred_millionths() {
    let four_bar = |tilt: f64| {
        let link = |name: &str| {
            format!(
                "<link name='{name}'><inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz>\
                 </inertia></inertial></link>"
            )
        };
        let pin = |name: &str, [parent, child]: [&str; 2], [x, y]: [f64; 2], lean: f64| {
            format!(
                "<joint name='{name}' type='revolute'><pose relative_to='__model__'>{x} {y} 0 0 0 0</pose>\
                 <parent>{parent}</parent><child>{child}</child><axis><xyz expressed_in='__model__'>{lean:?} 0 1</xyz>\
                 </axis></joint>"
            )
        };
        let pins = [
            pin("A", ["world", "a"], [0.0, 0.0], tilt),
            pin("B", ["a", "b"], [0.1, 0.05], -tilt),
            pin("C", ["b", "c"], [0.4, 0.3], 0.0),
            pin("D", ["world", "c"], [0.5, 0.0], 0.0),
        ];
        let links = ["a", "b", "c"].map(link).concat();
        imported(
            "loop.sdf",
            &format!("<sdf version='1.9'><model name='m'>{links}{}</model></sdf>", pins.concat()),
        )
    };
    for tilt in [0.0, 2e-8, 3e-7, 2e-6] {
        let found = four_bar(tilt);
        let codes: Vec<&str> = found.faults.iter().map(|fault| fault.diagnostic.code.0).collect();
        assert_eq!(codes.contains(&"I027"), tilt > 0.0, "{tilt}: {codes:?}");
        let start = derive(model(&found.model.expect("a model"))).start().expect("a start");
        assert_eq!(start.mobility, 1, "{tilt}");
    }
    // Smaller angles are none for the ranks of an analysis.
    assert!(!four_bar(1e-10).model.expect("a model").contains("straightened"));
}

/// Joints of MuJoCo are at their references in the pose of the file, that of a loop too.
#[test]
fn a_loop_of_joints_with_references_starts_at_them() {
    let text = r#"<mujoco><compiler angle="degree"/><worldbody>
      <body name="crank"><joint name="a" ref="90"/><geom type="capsule" fromto="0 0 0 0 0.1 0" size="0.01" mass="0.3"/>
        <body name="rod" pos="0 0.1 0"><joint name="b" ref="-70"/><geom type="capsule" fromto="0 0 0 0.3 0.1 0" size="0.01" mass="0.4"/></body></body>
      <body name="rocker" pos="0.35 0 0"><joint name="c" ref="100"/><geom type="capsule" fromto="0 0 0 -0.05 0.2 0" size="0.01" mass="0.4"/></body>
    </worldbody><equality><connect name="cl" body1="rod" body2="rocker" anchor="0.3 0.1 0"/></equality></mujoco>"#;
    let mechanism = derive(model(&text_of("loop.xml", text)));
    let start = mechanism.start().expect("a start");
    for (name, degrees) in [("a_angle", 90.0_f64), ("b_angle", -70.0), ("c_angle", 100.0)] {
        let within = Within { relative: 0.0, absolute: 1e-9 };
        close(name, start.q[coordinate(&mechanism, name)], degrees.to_radians(), within);
    }
}

/// The followed joint keeps its zero; the offset is in the joint that follows, not shared between both.
#[test]
fn the_offset_of_a_mimic_joint_moves_that_joint_alone() {
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
        )
    };
    let joint = |name: &str, [from, to]: [&str; 2], more: &str| {
        format!(
            "<joint name=\"{name}\" type=\"prismatic\"><parent link=\"{from}\"/><child link=\"{to}\"/><axis xyz=\"0 0 1\"/><limit lower=\"0\" upper=\"0.2\" effort=\"1\" velocity=\"1\"/>{more}</joint>"
        )
    };
    let mimic = "<mimic joint=\"j\" multiplier=\"1\" offset=\"0.02\"/>";
    let text = [
        "<robot name=\"r\">".to_owned(),
        ["a", "b", "c"].map(link).concat(),
        joint("j", ["a", "b"], ""),
        joint("k", ["b", "c"], mimic),
        "</robot>".to_owned(),
    ]
    .concat();
    let mechanism = derive(model(&text_of("r.urdf", &text)));
    let start = mechanism.start().expect("a start");
    let within = Within { relative: 0.0, absolute: 1e-12 };
    for (name, value) in [("j_position", 0.0), ("k_position", 0.02)] {
        close(name, start.q[coordinate(&mechanism, name)], value, within);
    }
}

/// `inertial auto` weighs the shapes with which a link collides: a box of 6 kg, and a ball of half a kilogram aside of it.
#[test]
fn a_link_of_sdf_weighs_as_its_shapes_do() {
    let ball = "<collision name=\"d\"><density>500</density><pose>0.5 0 0 0 0 0</pose><geometry><sphere><radius>0.062035049089940</radius></sphere></geometry></collision>";
    let text = |more: &str| {
        format!(
            "<sdf version=\"1.11\"><model name=\"m\"><link name=\"b\"><inertial auto=\"true\"><density>1000</density></inertial><collision name=\"c\"><geometry><box><size>0.1 0.2 0.3</size></box></geometry></collision>{more}</link></model></sdf>"
        )
    };
    let number = |text: &str, key: &str| -> Vec<f64> {
        let start = format!("{key} = ");
        let line = text.lines().find_map(|line| line.strip_prefix(&start)).expect(key);
        line.trim_matches(['[', ']']).split(", ").map(|n| n.parse().expect("a number")).collect()
    };
    let within = Within { relative: 1e-9, absolute: 1e-12 };
    let alone = text_of("m.sdf", &text(""));
    close("mass", number(&alone, "mass")[0], 6.0, within);
    for (found, exact) in number(&alone, "inertia").iter().zip([0.065, 0.05, 0.025]) {
        close("inertia", *found, exact, within);
    }
    let both = text_of("m.sdf", &text(ball));
    close("mass", number(&both, "mass")[0], 6.5, within);
    close("centre", number(&both, "com")[0], 0.25 / 6.5, within);
}
