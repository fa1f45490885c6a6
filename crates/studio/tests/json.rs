//! `docs/json.md` lists exactly the keys that the commands print, each with its type.

use std::collections::BTreeMap;
use std::fs;

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

/// Objects keyed by names of the model, written `a.*` in the page.
const BY_NAME: [&str; 17] = [
    "q",
    "v",
    "a",
    "lambda",
    "parameters",
    "options",
    "results",
    "attachments[].values",
    "facts",
    "candidates[].numbers",
    "candidates[].checks",
    "poses[].at",
    "open.null_vectors[]",
    "choices[].rows",
    "front.points[].quantities",
    "ends[].quantities",
    "front.points[].rows",
];

type Keys = BTreeMap<String, Vec<String>>;

/// Section of the page → key → the words of its type.
fn documented() -> BTreeMap<String, Keys> {
    let page = fs::read_to_string(format!("{CRATE}/../../docs/json.md")).expect("docs/json.md");
    let mut sections = BTreeMap::new();
    let mut section = String::new();
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            title.trim_matches('`').clone_into(&mut section);
        } else if let Some(row) = line.strip_prefix("| `") {
            let (key, rest) = row.split_once("` | ").expect("a key");
            let types = rest.split(" | ").next().expect("a type").split(" or ");
            let types = types.map(|word| word.trim_end_matches('s').to_owned()).collect();
            let keys: &mut Keys = sections.entry(section.clone()).or_default();
            assert!(keys.insert(key.to_owned(), types).is_none(), "{section}: `{key}` twice");
        }
    }
    sections
}

/// All keys of a value, with the types that occur.
fn collect(value: &Value, path: &str, keys: &mut Keys) {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(object) => {
            let by_name = BY_NAME.contains(&path);
            let key = |name: &String| if by_name { "*".to_owned() } else { name.clone() };
            let join = |name: String| if path.is_empty() { name } else { format!("{path}.{name}") };
            object.iter().map(|(name, child)| (join(key(name)), child)).collect()
        }
        Value::Array(items) => items.iter().map(|item| (format!("{path}[]"), item)).collect(),
        _ => Vec::new(),
    };
    for (child_path, child) in &children {
        collect(child, child_path, keys);
    }
    let kind = match value {
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Null => "null",
        Value::Array(_) | Value::Object(_) => return,
    };
    let kinds = keys.entry(path.to_owned()).or_default();
    if !kinds.contains(&kind.to_owned()) {
        kinds.push(kind.to_owned());
    }
}

/// Three profiles by one law.
const CAM: &str = r#"
[curves]
lift = { type = "cam-law", segments = [{ rise = "9 mm", over = "90 deg", law = "3-4-5" }, { return = "9 mm", over = "90 deg", law = "3-4-5" }, { dwell = "180 deg" }] }
flat = { type = "cam", law = "lift", base_circle = "30 mm", follower = { kind = "flat" } }
knife = { type = "cam", law = "lift", base_circle = "30 mm", follower = { kind = "knife" } }
roller = { type = "cam", law = "lift", base_circle = "30 mm", follower = { kind = "roller", radius = "9 mm" } }
[bodies.cam]
[joints.O]
type = "revolute"
between = ["ground", "cam"]
"#;

/// A swing with questions of design.
const SWING: &str = r#"
[parameters]
k = "20 N m/rad"
j = 1.0
idle = 1.0
[bodies.bob]
mass = "2 kg"
inertia = 0
com = [0, "-0.5 m"]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[loads.spring]
type = "torque"
joint = "A"
value = "-k*j*A.angle"
[initial]
A = { angle = "20 deg" }
[solve]
t_end = "1 s"
[optimize]
minimize = "k"
vary = { k = ["10 N m/rad", "90 N m/rad"] }
subject_to = ["max(A.rate) >= 2 rad/s"]
[fit]
vary = ["k", "j", "idle", "A.angle"]
compare = { theta = "A.angle" }
"#;

/// A four-bar with questions of design.
const BAR: &str = r#"
[parameters]
a = "60 mm"
b = "170 mm"
c = "120 mm"
d = "180 mm"
[ground]
points = { A = [0, 0], D = ["d", 0] }
[bodies.crank]
points = { A = [0, 0], B = ["a", 0] }
[bodies.coupler]
points = { B = [0, 0], C = ["b", 0] }
[bodies.rocker]
points = { D = [0, 0], C = ["c", 0] }
[joints]
A = { type = "revolute", between = ["ground.A", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "coupler.B"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker.D"] }
[initial]
A = { angle = "40 deg" }
D = { guess = { angle = "85 deg" } }
[tolerance]
of = "rocker.angle"
at = { "A.angle" = "40 deg" }
limits = { a = "±0.1 mm", c = "±0.15 mm" }
samples = 100
"#;

/// A block on two guides in one line, which part where `h` is not zero.
const GUIDES: &str = r#"
[parameters]
h = "0 m"
[ground.points]
P = [0, "h"]
[bodies.block]
mass = 1
inertia = 1
[joints.S]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[joints.R]
type = "prismatic"
between = ["ground.P", "block"]
axis = [1, 0]
[initial]
S = { velocity = "1 m/s" }
"#;

/// A block that runs against a stop, with friction and a spring with a kink.
const CONTACTS: &str = include_str!("../../../tests/fixtures/contacts.toml");

/// Drawings without attributes with all that can be understood of one.
const PLAIN: [(&str, &[u8]); 3] = [
    ("gears.dxf", include_bytes!("../../../tests/fixtures/import/plain/gear_pair_a.dxf")),
    ("lever.dxf", include_bytes!("../../../tests/fixtures/import/plain/sprung_lever_b.dxf")),
    ("rack.dxf", include_bytes!("../../../tests/fixtures/import/plain/rack.dxf")),
];

#[test]
fn the_page_lists_the_keys_that_are_printed() {
    let place = Scratch::new();
    place.write("mimic.urdf", include_str!("../../../tests/fixtures/import/mimic.urdf"));
    for (name, drawing) in PLAIN {
        place.write(name, drawing);
    }
    for example in [
        "five-link",
        "parallelogram",
        "four-bar",
        "winch",
        "quick-return",
        "robot-arm",
        "rocking-block",
    ] {
        let model = fs::read(format!("{CRATE}/../../examples/{example}/model.toml"));
        place.write(&format!("{example}.toml"), model.expect("an example"));
    }
    for example in ["slider-crank", "four-bar", "five-link", "press"] {
        let drawing = fs::read(format!("{CRATE}/../../examples/{example}/drawing.dxf"));
        place.write(&format!("{example}.dxf"), drawing.expect("an example"));
    }
    // A circle on a layer that means nothing.
    let press = fs::read_to_string(format!("{CRATE}/../../examples/press/drawing.dxf"));
    let end = "  0\nENDSEC\n  0\nSECTION\n  2\nOBJECTS\n";
    let circle = "  0\nCIRCLE\n  8\nBK_JOINT\n 10\n1\n 20\n2\n 40\n3\n";
    let sick = press.expect("an example").replace("\r\n", "\n").replacen(
        end,
        &format!("{circle}{end}"),
        1,
    );
    place.write("sick.dxf", sick);
    place.write("bad.toml", "[bodies.b]\nmas = 1\n");
    place.write("bead.toml", "[bodies.bead]\nmass = 1\nfree = true\n");
    place.write("contacts.toml", CONTACTS);
    place.write("outputs.toml", format!("{CONTACTS}[outputs]\nway = \"2*S.position\"\n[cases.other]\nset = {{ solve.t_end = 0.5 }}\n"));
    place.write("guides.toml", GUIDES);
    place.write("cam.toml", CAM);
    place.write("undercut.toml", CAM.replace("30 mm", "5 mm"));
    place.write("swing.toml", SWING);
    place.write(
        "swing.csv",
        "t [s],theta [deg]\n0,20\n0.1,18.9\n0.2,15.7\n0.3,10.7\n0.4,4.7\n0.5,-2\n",
    );
    place.write("bar.toml", BAR);
    let longer = "[optimize]\nmaximize = \"b\"\nvary = { b = [\"150 mm\", \"200 mm\"] }\nover = \"A.angle=40:50 deg:3\"\n";
    let open = BAR.replace("b = \"170 mm\"", "b = \"400 mm\"");
    place.write("open.toml", format!("{BAR}{longer}subject_to = [\"min(D.angle) >= 0 deg\"]\n"));
    place.write("wide.toml", open.replace("[tolerance]", &format!("{longer}[tolerance]")));
    // Two catalogue rows of which one closes, and two objectives.
    let rows = "[optimize.choose.base]\nnear = { d = \"180 mm\" }\nfar = { d = \"900 mm\" }\n";
    let trade = "[optimize]\nminimize = [\"b\", \"1 m - b\"]\npoints = 3\n\
                 vary = { b = [\"150 mm\", \"200 mm\"] }\nover = \"A.angle=40:50 deg:3\"\n";
    place.write("trade.toml", format!("{BAR}{trade}{rows}"));
    place.write("rows.toml", format!("{BAR}{longer}{rows}"));
    place.write(
        "lever.toml",
        "[synthesize]\ntask = \"quick_return\"\ntime_ratio = 1.6\nground = 0.3\n",
    );
    place.write(
        "three.toml",
        "[synthesize]\ntask = \"function\"\nphi = [0.5, 1, 1.5]\npsi = [1, 1.4, 2]\n",
    );
    let commands = [
        "optimize swing.toml -o spring.toml",
        "optimize open.toml",
        "optimize trade.toml --plot front.svg",
        "optimize rows.toml",
        "fit swing.toml --data swing.csv -o fitted.toml --plot fitted.png",
        "fit swing.toml --data swing.csv --vary k",
        "tolerance bar.toml --plot parts.svg",
        "tolerance bar.toml --of crank.B.x --of crank.B.y --play B=0.02mm",
        "tolerance bar.toml --at 'A.angle=250deg'",
        "tolerance bar.toml --keep rocker.angle=±0.5deg --of max(rocker.angle) --at A.angle=40:60deg:3 -o cheaper.toml --plot mixed.svg",
        "synthesize lever.toml -o candidates",
        "synthesize three.toml",
        "cam cam.toml flat -o flat.csv",
        "cam undercut.toml flat",
        "cam cam.toml knife --cutter 5mm",
        "cam cam.toml roller -o roller.dxf",
        "cam cam.toml lift",
        "new fresh",
        "new --list",
        "new arm --template robot-arm",
        "completions bash",
        "man solve",
        "man -o pages",
        "check five-link.toml",
        "check parallelogram.toml",
        "check winch.toml",
        "check bead.toml",
        "check rocking-block.toml",
        "check four-bar.toml",
        "check bad.toml",
        "edit bead.toml --apply {\"edit\":\"gravity\"}",
        "check missing.toml",
        "expand five-link.toml",
        "parts",
        "parts dc-motor",
        "equations five-link.toml",
        "equations four-bar.toml",
        "equations contacts.toml",
        "equations robot-arm.toml",
        "equations outputs.toml",
        "expr x*y-y=1 --solve x --certificate",
        "expr x+1 --at x=1",
        "code five-link.toml -o code",
        "code five-link.toml --part solver -o solver",
        "fmu five-link.toml --input q1 -o five-link.fmu",
        "fmu five-link.toml --fmi 2 --sources -o sources.fmu",
        "gradient guides.toml --of energy.total -o gradient.csv",
        "assemble five-link.toml",
        "assemble parallelogram.toml",
        "solve parallelogram.toml --every 0.1",
        "solve five-link.toml --t-end 0.5",
        "solve contacts.toml --t-end 1",
        "solve five-link.toml --t-end 0",
        "sweep four-bar.toml --set b=0.01,0.3 --t-end 0.1 --log-cases all",
        "sweep four-bar.toml --set b=1:2:0",
        "export parallelogram.mcap energy -o energy.csv",
        "sweep four-bar.toml --set b=0.27:0.3:4 --set a=0.1,0.1001 --t-end 0.1 -o four.parquet",
        "plot four.parquet",
        "plot parallelogram.mcap",
        "plot five-link.mcap parallelogram.mcap energy.work state.ti1 --x energy.total -o energy.svg",
        "plot parallelogram.mcap state.nothing",
        "export parallelogram.mcap energy -o joules.csv --in kJ",
        "report parallelogram.mcap",
        "report contacts.toml -o contacts.md",
        "report outputs.toml --case other",
        "plot four-bar.toml --path coupler.C -o path.svg",
        "report quick-return.toml --units mm,deg",
        "info parallelogram.mcap",
        "info contacts.mcap",
        "info cut.mcap",
        "info other.mcap",
        "page parallelogram.mcap",
        "render parallelogram.mcap -o film.gif --size 64x48 --to 0.2 --fps 10",
        "render five-link.toml -o picture.png --size 64x48",
        "render five-link.toml -o picture.svg",
        "cad mass slider-crank.dxf",
        "cad mass four-bar.dxf --body crank",
        "cad dist slider-crank.dxf",
        "cad list slider-crank.dxf",
        "cad list five-link.dxf",
        "cad list press.dxf",
        "cad doctor press.dxf",
        "cad doctor sick.dxf -o marked.dxf",
        "cad body set slider-crank.dxf rod inertia= -o edited.dxf",
        "cad template -o template.dxf",
        "cad from-toml five-link.toml -o drawn.dxf",
        "solve slider-crank.dxf --t-end 0.1",
        "cad trace slider-crank.mcap slider-crank.dxf -o traced.dxf",
        "cad to-toml slider-crank.dxf",
        "cad to-toml slider-crank.dxf -o fresh2.toml",
        "import mimic.urdf",
        "import mimic.urdf -o mimic.toml",
        "import gears.dxf -o gears.toml --picture gears.svg",
        "import rack.dxf",
        "import lever.dxf --answer circle.79=mass",
        "explain",
        "explain M012",
        "explain Z999",
        "solve --nonsense",
    ];
    let mut printed: BTreeMap<String, Keys> = BTreeMap::new();
    for command in commands {
        if command == "info cut.mcap" {
            let log = fs::read(place.path().join("parallelogram.mcap")).expect("a log");
            place.write("cut.mcap", &log[..log.len() / 2]);
            place.write("other.mcap", crate::common::other_mcap());
        }
        let output = place.run(&format!("{command} --json"));
        assert_eq!(text(&output.stderr), "", "{command}");
        let object: Value = serde_json::from_slice(&output.stdout).expect("one object");
        let ok = object["ok"].as_bool().expect("ok");
        assert_eq!(ok, output.status.success(), "{command}");
        let own =
            if ok { object["command"].as_str().expect("command") } else { "A command that fails" };
        let mut keys = Keys::new();
        collect(&object, "", &mut keys);
        for (key, kinds) in keys {
            let section = match key.as_str() {
                "ok" | "command" | "case" => "Every command",
                key if key.starts_with("diagnostics[]") => "Diagnostics",
                _ => own,
            };
            let known = printed.entry(section.to_owned()).or_default().entry(key).or_default();
            known.extend(kinds);
            known.sort();
            known.dedup();
        }
    }

    let mut pages = documented();
    // Their objects are keyed by names of the model throughout; their own tests compare the numbers.
    for question in [
        "kinematics",
        "curves",
        "polygons",
        "static",
        "linearize",
        "modes",
        "bode",
        "doctor",
        "verify",
        "inverse",
        "sheet",
    ] {
        pages.remove(question);
    }
    // Said once more where failures are explained.
    pages.get_mut("A command that fails").expect("the section").remove("diagnostics[]");
    // A served page is there until it is ended.
    assert!(pages.get_mut("edit").expect("the section").remove("url").is_some());
    // A window needs a display: its test compares the keys.
    assert!(pages.remove("view").is_some(), "the section");
    // No example of these few lines crosses a singular pose.
    let of_poses = |key: &String| key.starts_with("singular_poses[]");
    let solve = pages.get_mut("solve").expect("the section");
    assert_eq!(solve.keys().filter(|key| of_poses(key)).count(), 3);
    solve.retain(|key, _| !of_poses(key));
    printed.get_mut("solve").expect("the command").retain(|key, _| !of_poses(key));
    let titles = |map: &BTreeMap<String, Keys>| map.keys().cloned().collect::<Vec<_>>();
    assert_eq!(titles(&pages), titles(&printed));
    for (section, keys) in &printed {
        let page = &pages[section];
        let names = |keys: &Keys| keys.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(page), names(keys), "{section}");
        for (key, kinds) in keys {
            for kind in kinds {
                assert!(page[key].contains(kind), "{section}: `{key}` is a {kind}");
            }
        }
    }
}
