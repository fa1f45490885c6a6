//! Models of several files: parts, rows of tables, elements that repeat; and what is said when they are wrong.

use crate::common::{Scratch, text};

/// A drum with a brake, a model of its own.
const DRUM: &str = r#"
[parameters]
r = "0.1 m"
m = "20 kg"
torque = "5 N m"

[ground]
points = { bearing = ["0.3 m", 0] }

[bodies.drum]
mass = "m"
inertia = "m*r^2/2"

[joints.shaft]
type = "revolute"
between = ["ground.bearing", "drum"]
coordinate = "theta"

[tables.drag]
file = "drag.csv"
extrapolate = "linear"

[loads.drive]
type = "torque"
joint = "shaft"
value = "torque - drag(theta_dot)"

[loads.weight]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[solve]
t_end = "1 s"
"#;

const DRAG: &str = "speed [rad/s], torque [N m]\n# measured\n0, 0\n10, 1.5\n20, 4\n";

/// Two drums on an arm, the second in a frame that is turned.
const CRANE: &str = r#"
[parameters]
l = "2 m"
r = "0.15 m"

[bodies.arm]
mass = "50 kg"
com = ["l/2", 0]
inertia = "50 kg*l^2/12"
points = { mid = { at = ["l/2", 0], rpy = [0, 0, "90 deg"] }, tip = ["l", 0] }

[joints.A]
type = "revolute"
between = ["ground", "arm"]

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[use.left]
file = "parts/drum.toml"
on = "arm.tip"
with = { r = "r", torque = "20 N m" }

[use.right]
file = "parts/drum.toml"
on = "arm.mid"

[solve]
t_end = "1 s"
"#;

/// Model of the parts, written out by hand.
const WRITTEN_OUT: &str = r#"
[parameters]
l = "2 m"
r = "0.15 m"
m = "20 kg"

[bodies.arm]
mass = "50 kg"
com = ["l/2", 0]
inertia = "50 kg*l^2/12"
points = { right_bearing = ["l/2", "0.3 m"], left_bearing = ["l + 0.3 m", 0] }

[bodies.left_drum]
mass = "m"
inertia = "m*r^2/2"

[bodies.right_drum]
mass = "m"
inertia = "m*(0.1 m)^2/2"

[joints.A]
type = "revolute"
between = ["ground", "arm"]

[joints.left_shaft]
type = "revolute"
between = ["arm.left_bearing", "left_drum"]
coordinate = "left_theta"

[joints.right_shaft]
type = "revolute"
between = ["arm.right_bearing", "right_drum"]
coordinate = "right_theta"

[tables.drag]
points = [[0, 0], [10, 1.5], [20, 4]]
units = ["rad/s", "N m"]
extrapolate = "linear"

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[loads.left_drive]
type = "torque"
joint = "left_shaft"
value = "20 N m - drag(left_theta_dot)"

[loads.right_drive]
type = "torque"
joint = "right_shaft"
value = "5 N m - drag(right_theta_dot)"

[solve]
t_end = "1 s"
"#;

/// A folder with the crane and its part.
fn crane() -> Scratch {
    let place = Scratch::new();
    std::fs::create_dir(place.path().join("parts")).expect("a folder");
    place.write("crane.toml", CRANE);
    place.write("parts/drum.toml", DRUM);
    place.write("parts/drag.csv", DRAG);
    place
}

fn done(place: &Scratch, arguments: &str) -> String {
    let output = place.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// The last row of the states of a model: number by column.
fn ends(place: &Scratch, model: &str) -> Vec<(String, f64)> {
    done(place, &format!("solve {model} -o {model}.mcap --force"));
    let table = done(place, &format!("export {model}.mcap"));
    let (header, last) = (table.lines().next(), table.lines().last());
    let cells = header.expect("a header").split(',').zip(last.expect("a row").split(','));
    cells
        .filter(|(name, _)| name.starts_with("state."))
        .map(|(name, value)| (name.to_owned(), value.parse().expect("a number")))
        .collect()
}

/// The faults of a model that is refused, as they are printed.
fn said(place: &Scratch, model: &str) -> String {
    let output = place.run(&format!("check {model}"));
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    text(&output.stderr)
}

#[test]
fn parts_move_as_the_model_that_is_written_out_by_hand() {
    let place = crane();
    place.write("hand.toml", WRITTEN_OUT);
    let (parts, hand) = (ends(&place, "crane.toml"), ends(&place, "hand.toml"));
    assert_eq!(parts.len(), 6);
    for (name, value) in &parts {
        let (_, expected) = hand.iter().find(|(known, _)| known == name).expect("the same names");
        assert!(
            (value - expected).abs() < 1e-8 * expected.abs().max(1.0),
            "{name}: {value}, {expected}"
        );
    }
    // A part is a model by itself.
    assert!(ends(&place, "parts/drum.toml").iter().any(|(name, _)| name == "state.theta"));
}

#[test]
fn the_whole_is_one_text_that_reads_the_same() {
    let place = crane();
    place.write("whole.toml", done(&place, "expand crane.toml"));
    assert_eq!(ends(&place, "whole.toml"), ends(&place, "crane.toml"));
    // A model of one file stays as it is, to the comment.
    place.write("hand.toml", format!("# by hand\n{WRITTEN_OUT}"));
    assert_eq!(done(&place, "expand hand.toml").trim(), format!("# by hand\n{WRITTEN_OUT}").trim());
    // A log has the whole, and needs its parts no longer.
    std::fs::remove_dir_all(place.path().join("parts")).expect("the parts go");
    assert!(done(&place, "info crane.toml.mcap").contains("state.left_theta"));
}

#[test]
fn parameters_of_parts_are_set_by_their_names() {
    let place = crane();
    let end = |set: &str| {
        done(&place, &format!("solve crane.toml -o set.mcap --force {set}"));
        done(&place, "export set.mcap").lines().last().map(str::to_owned)
    };
    assert_ne!(end(""), end("--set right_torque=6"));
}

/// Bodies, joints and signals of the model stand in for those that a part has to be a model by itself.
#[test]
fn a_part_takes_bodies_joints_and_signals_of_the_model() {
    let lid = "[bodies.lid]\nmass = \"15 kg\"\ninertia = \"1.2 kg m^2\"\ncom = [\"0.45 m\", 0]\n\
               points = { P = [\"0.3 m\", 0] }\n\
               [joints.hinge]\ntype = \"revolute\"\nbetween = [\"ground\", \"lid\"]\n\
               [initial.hinge]\nangle = \"0.9 rad\"\n";
    let spring = "[signals.push]\nvalue = \"200 N\"\n\
                  [ground]\npoints = { G = [\"50 mm\", \"-350 mm\"] }\n\
                  [loads.gas]\ntype = \"spring\"\nbetween = [\"ground.G\", \"lid.P\"]\n\
                  stiffness = \"400 N/m\"\nlength = \"0.9 m\"\n\
                  [loads.extra]\ntype = \"torque\"\njoint = \"hinge\"\nvalue = \"push*0.1 m*cos(hinge.angle)\"\n";
    let gravity = "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n";
    let place = Scratch::new();
    place.write("spring.toml", format!("{lid}{spring}"));
    place.write("alone.toml", format!("{lid}{spring}{gravity}").replace("200 N", "250 N"));
    let of_model = |text: &str| text.replace("lid", "hatch").replace("hinge", "A");
    let with = "with = { lid = \"hatch\", hinge = \"A\", push = \"F\" }";
    let model = format!(
        "[parameters]\nF = \"250 N\"\n{}{gravity}[use.gas]\nfile = \"spring.toml\"\n{with}\n",
        of_model(lid)
    );
    place.write("hatch.toml", &model);
    let [hatch, alone] = ["hatch.toml", "alone.toml"].map(|name| ends(&place, name));
    assert_eq!(hatch.len(), 2);
    for ((name, value), (_, expected)) in hatch.iter().zip(&alone) {
        assert!((value - expected).abs() < 1e-9, "{name}: {value}, {expected}");
    }
    place.write("hatch.toml", model.replace("push =", "puch ="));
    let said = said(&place, "hatch.toml");
    assert!(said.contains("the part of use `gas` has no `puch`"), "{said}");
    assert!(said.contains("did you mean `push`?"), "{said}");
}

#[test]
fn elements_repeat_with_their_numbers() {
    let place = Scratch::new();
    let chain = "[bodies.link]\ncount = 3\nmass = \"1 kg\"\ninertia = \"{i}e-2 kg m^2\"\n\
                 points = { end = [\"0.2 m\", 0] }\n\
                 [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"link1\"]\n\
                 [joints.pin]\ncount = 2\nfirst = 2\ntype = \"revolute\"\n\
                 between = [\"link{i-1}.end\", \"link{i}\"]\n\
                 [initial.\"pin{i}\"]\ncount = 2\nfirst = 2\nangle = \"{i}0 deg\"\n\
                 [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n";
    place.write("chain.toml", chain);
    let whole = done(&place, "expand chain.toml");
    for line in [
        "[bodies.link2]",
        "inertia = \"3e-2 kg m^2\"",
        "[joints.pin3]",
        "between = [\"link2.end\", \"link3\"]",
        "[initial.pin3]",
        "angle = \"30 deg\"",
    ] {
        assert!(whole.contains(line), "{line} is not in\n{whole}");
    }
    assert!(!whole.contains("count") && !whole.contains("link4"), "{whole}");
    done(&place, "solve chain.toml");

    // Counts and braces that are none, each with its place.
    let wrong = [
        ("count = 3", "count = 2.5", "`count` is no whole number above 0 in `link`", "2:9"),
        ("count = 3", "count = 0", "`count` is no whole number above 0 in `link`", "2:9"),
        ("first = 2\ntype", "first = -1\ntype", "`first` is no whole number in `pin`", "11:9"),
        ("link{i-1}.end", "link{next}.end", "`{next}` is no number of an element", "13:12"),
        ("link{i-1}.end", "link{i-9}.end", "`{i-9}` is no number of an element", "13:12"),
        ("link{i-1}.end", "link{i", "`{` is no number of an element", "13:12"),
        ("count = 3", "count = 999999", "`link` makes the model too large", "2:9"),
    ];
    for (old, new, message, at) in wrong {
        place.write("wrong.toml", chain.replacen(old, new, 1));
        let said = said(&place, "wrong.toml");
        assert!(said.contains(message) && said.contains("M094"), "{new}: {said}");
        assert!(said.contains(&format!("wrong.toml:{at}")), "{new}: {said}");
    }
}

#[test]
fn faults_are_said_in_the_file_that_has_them() {
    let cases = [
        // In a part.
        ("parts/drum.toml", "mass = \"m\"", "mass = \"n\"", "drum.toml:11:9", "M021"),
        ("parts/drum.toml", "theta_dot)", "theta_dott)", "drum.toml:26:24", "M021"),
        ("parts/drum.toml", "[loads.drive]", "[loads.drive", "drum.toml:23:1\n", "M002"),
        ("parts/drum.toml", "\"drag.csv\"", "\"drug.csv\"", "drum.toml:20:8", "M077"),
        (
            "parts/drum.toml",
            "[solve]",
            "[units]\nlength = \"mm\"\n[solve]",
            "drum.toml:33:1",
            "M093",
        ),
        // In rows.
        ("parts/drag.csv", "10, 1.5", "10, x", "drag.csv:4:5", "M077"),
        ("parts/drag.csv", "10, 1.5", "10, 1.5, 3", "drag.csv:4:1", "M077"),
        ("parts/drag.csv", "20, 4", "5, 4", "drag.csv:5:1", "M077"),
        ("parts/drag.csv", "[N m]", "", "drag.csv:1:1", "M077"),
        ("parts/drag.csv", "[N m]", "[Nn]", "drag.csv:1:24", "M030"),
        // In the model itself.
        ("crane.toml", "mass = \"50 kg\"", "mass = \"50 kgg\"", "crane.toml:7:12", "M030"),
        ("crane.toml", "torque = \"20 N m\"", "torgue = \"20 N m\"", "crane.toml:23:19", "M021"),
        ("crane.toml", "torque = \"20 N m\"", "torque = \"20 N\"", "drum.toml:26:10", "M032"),
        (
            "crane.toml",
            "[bodies.arm]",
            "[bodies]\narm = 3\n[bodies.arn]",
            "crane.toml:24:6",
            "M013",
        ),
        ("crane.toml", "arm.tip", "arm.top", "crane.toml:22:6", "M013"),
        ("crane.toml", "arm.tip", "arn.tip", "crane.toml:22:6", "M012"),
        ("crane.toml", "on = \"arm.tip\"", "at = \"arm.tip\"", "crane.toml:22:1", "M005"),
        ("crane.toml", "file = \"parts/drum.toml\"", "", "crane.toml:20:6", "M006"),
        ("crane.toml", "parts/drum.toml", "parts/drums.toml", "crane.toml:21:8", "M093"),
        ("crane.toml", "parts/drum.toml", "crane.toml", "crane.toml:21:8", "M093"),
        ("crane.toml", "parts/drum.toml", "../../etc/hostname", "crane.toml:21:8", "M093"),
        ("crane.toml", "[joints.A]", "[joints.left_shaft]", "crane.toml:12:9", "M003"),
    ];
    let mut wrong = Vec::new();
    for (file, old, new, at, code) in cases {
        let place = crane();
        let whole = std::fs::read_to_string(place.path().join(file)).expect("a file");
        assert!(whole.contains(old), "{old} is not in {file}");
        place.write(file, whole.replacen(old, new, 1));
        let said = said(&place, "crane.toml");
        let is_said = [at, code, "help: "].iter().all(|part| said.contains(part));
        // A part that is used twice has its faults once, but for those that speak of its names.
        let has_no_name = ["M002", "M030"].contains(&code);
        let is_once = !has_no_name || said.matches("error[").count() == 1;
        if !(is_said && is_once) {
            wrong.push(format!("{file}, {new}: {at}, {code} not in\n{said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn parts_that_multiply_without_end_are_refused_at_once() {
    let place = Scratch::new();
    for k in 0..15 {
        let next = format!("[use.a]\ncount = 4\nfile = \"p{}.toml\"\n", k + 1);
        place.write(&format!("p{k}.toml"), next);
    }
    place.write("p15.toml", DRUM.replace("file = \"drag.csv\"", "points = [[0, 0], [1, 1]]"));
    let begun = std::time::Instant::now();
    let said = said(&place, "p0.toml");
    assert!(said.contains("makes the model too large"), "{said}");
    assert!(said.matches("error[").count() == 1, "{said}");
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
}

/// A drawing of one disc on a pin: groups of code and value, records on entities by extended data.
fn drawn_disc(records: &[&[&str]]) -> String {
    let mut groups: Vec<(u16, &str)> = vec![
        (0, "SECTION"),
        (2, "HEADER"),
        (9, "$ACADVER"),
        (1, "AC1015"),
        (9, "$INSUNITS"),
        (70, "6"),
        (0, "ENDSEC"),
        (0, "SECTION"),
        (2, "TABLES"),
        (0, "TABLE"),
        (2, "APPID"),
        (0, "APPID"),
        (2, "BKSIM"),
        (70, "0"),
        (0, "ENDTAB"),
        (0, "ENDSEC"),
        (0, "SECTION"),
        (2, "ENTITIES"),
        (0, "CIRCLE"),
        (8, "BK_BODY_disc"),
        (10, "0"),
        (20, "0"),
        (40, "0.2"),
    ];
    for record in records {
        groups.extend([(0, "POINT"), (8, "0"), (10, "0"), (20, "0"), (1001, "BKSIM")]);
        groups.extend([(1000, record[0]), (1002, "{")]);
        groups.extend(record[1..].iter().map(|&entry| (1000, entry)));
        groups.push((1002, "}"));
    }
    groups.extend([(0, "ENDSEC"), (0, "EOF")]);
    let lines = groups.iter().flat_map(|(code, value)| [code.to_string(), (*value).to_owned()]);
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// A motor of the library and a drum of a file next to the drawing turn drawn bodies as they turn written ones.
#[test]
fn a_drawing_with_parts_moves_as_its_twin() {
    let place = crane();
    let drawing = drawn_disc(&[
        &["body", "name=disc", "mass=4 kg", "inertia=0.08 kg m^2"],
        &["revolute", "name=A", "body1=ground", "body2=disc"],
        &["part", "name=motor", "part=dc-motor", "with=rotor = disc; shaft = A; supply = 12 V"],
        &["part", "name=hoist", "file=parts/drum.toml", "on=disc", "with=torque = 2 N m"],
        &["solve", "t_end=0.5 s"],
    ]);
    place.write("drawn.dxf", drawing);
    place.write(
        "twin.toml",
        "[bodies.disc]\nmass = \"4 kg\"\ninertia = \"0.08 kg m^2\"\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"disc\"]\n\
         [use.motor]\npart = \"dc-motor\"\nwith = { rotor = \"disc\", shaft = \"A\", supply = \"12 V\" }\n\
         [use.hoist]\nfile = \"parts/drum.toml\"\non = \"disc\"\nwith = { torque = \"2 N m\" }\n\
         [solve]\nt_end = \"0.5 s\"\n",
    );
    let written = ends(&place, "twin.toml");
    assert!(written.iter().any(|(name, value)| name == "state.motor_current" && *value != 0.0));
    assert_eq!(ends(&place, "drawn.dxf"), written);
}
