//! Written drawings, judged by an independent reader.

use crate::common::python;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use bksim_cad::compose::Frame;
use bksim_cad::container::recognise;
use bksim_cad::kind::KINDS;
use bksim_cad::model::{ModelOptions, sheet};
use bksim_cad::tags::Tags;
use bksim_cad::write::Release;
use bksim_cad::write::from_model::{ModelSource as Drawn, Unwritten, from_model};
use bksim_cad::write::graft::graft;
use bksim_cad::write::template::{Template, template};
use bksim_cad::write::trace::{
    BodyShape, Course, CurveKind, MotionCurve, Reaction, Selection, Traced, even_samples, trace,
};
use bksim_mbs::assemble::assemble;
use bksim_model::Model;
use bksim_model::file::{Source, read};
use bksim_sim::compiled::compile;
use bksim_sim::pose::{PlanarPose, Pose, Poses};
use bksim_sim::start::start;

/// Writes a file for the judge.
fn saved(name: &str, bytes: &[u8]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).expect("the directory of tests can be written");
    path
}

/// The facts about drawings that were saved.
fn judged_all(paths: &[PathBuf]) -> Vec<Vec<String>> {
    let script = python::workspace().join("crates/cad/tests/judge.py");
    let args: Vec<&str> = paths.iter().map(|p| p.to_str().expect("a UTF-8 path")).collect();
    let facts = python::python(&script, &args);
    let drawings = facts.split("drawing ").skip(1);
    drawings.map(|facts| facts.lines().skip(1).map(str::to_owned).collect()).collect()
}

/// The facts about a drawing.
fn judged(name: &str, bytes: &[u8]) -> Vec<String> {
    judged_all(&[saved(name, bytes)]).remove(0)
}

fn assert_faultless(name: &str, facts: &[String]) {
    let faults: Vec<&String> = facts.iter().filter(|f| f.starts_with("error")).collect();
    assert!(faults.is_empty(), "{name}: {faults:?}");
}

fn count(facts: &[String], start: &str) -> usize {
    facts.iter().filter(|fact| fact.starts_with(start)).count()
}

#[test]
fn templates_of_all_releases_have_every_block_and_no_fault() {
    let paths = Release::ALL.map(|(release, name, _)| {
        let bytes = template(&Template { release, unit: "mm", size: None }).expect("a template");
        saved(&format!("template-{name}.dxf"), &bytes)
    });
    for ((release, name, _), facts) in Release::ALL.into_iter().zip(judged_all(&paths)) {
        assert_faultless(name, &facts);
        assert_eq!(facts[0], format!("version {name}"));
        if release > Release::R12 {
            assert_eq!(facts[1], "units 4", "{name}");
        }
        for kind in KINDS {
            let tags = format!(" {}", kind.keys.join(" ").to_uppercase());
            let is_block = |fact: &&String| {
                fact.starts_with(&format!("block {} ", kind.block)) && fact.ends_with(&tags)
            };
            assert_eq!(facts.iter().filter(is_block).count(), 1, "{name}: {}", kind.block);
            let inserts = facts.iter().filter(|fact| {
                let mut words = fact.split('|');
                words.next() == Some("insert") && words.nth(1) == Some(kind.block)
            });
            assert_eq!(inserts.count(), 1, "{name}: {}", kind.block);
        }
        assert_eq!(count(&facts, "layer BK_BODY_"), 3, "{name}");
        let outside = facts.iter().filter(|f| f.starts_with("entity") && !f.contains("BK_LEGEND"));
        assert_eq!(outside.count(), 0, "{name}: entities outside of the legend");
    }
}

/// A model with the poses of its start.
fn started(text: &str, name: &str) -> (Model, Vec<PlanarPose>) {
    let (model, poses, _) = started_whole(text, name);
    (model, poses)
}

/// A model, the poses of its start, and what of the start has a name.
fn started_whole(text: &str, name: &str) -> (Model, Vec<PlanarPose>, BTreeMap<String, [f64; 3]>) {
    let reading = read(&Source::new(text, name));
    let model = reading.model.unwrap_or_else(|| panic!("{name}: {:?}", reading.diagnostics));
    let system = assemble(&model);
    let compiled = compile(&model, &system).expect("compiles");
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let start = start(&model, &system, &compiled, &parameters).expect("a start");
    let poses = Poses::compile(&model, &system).expect("compiles");
    let poses = poses.at(&parameters, [(&start.q[..], &start.v[..])]).remove(0);
    let poses = poses.iter().map(Pose::in_plane).collect();
    let coordinates = compiled.coordinates.iter().enumerate();
    let motion =
        coordinates.map(|(i, c)| (c.name.clone(), [start.q[i], start.v[i], start.a[i]])).collect();
    (model, poses, motion)
}

const EXAMPLES: [(&str, &str, &str); 6] = [
    ("five-link", "m", include_str!("../../../examples/five-link/model.toml")),
    ("four-bar", "mm", include_str!("../../../examples/four-bar/model.toml")),
    ("parallelogram", "mm", include_str!("../../../examples/parallelogram/model.toml")),
    ("quick-return", "mm", include_str!("../../../examples/quick-return/model.toml")),
    ("slider-crank", "m", include_str!("../../../examples/slider-crank/model.toml")),
    ("spring-pendulum", "inch", include_str!("../../../examples/spring-pendulum/model.toml")),
];

/// Values of an attribute `key=` of the inserts of a block.
fn values<'a>(facts: &'a [String], block: &str, key: &str) -> Vec<&'a str> {
    let inserts = facts.iter().filter(|fact| fact.split('|').nth(2) == Some(block));
    inserts.filter_map(|fact| fact.split('|').find_map(|value| value.strip_prefix(key))).collect()
}

#[test]
fn examples_are_drawn_whole_and_without_fault_in_every_release() {
    for (name, unit, text) in EXAMPLES {
        let (model, poses) = started(text, name);
        let paths = Release::ALL.map(|(release, tag, _)| {
            let drawn = Drawn { text, model: &model, poses: &poses, release, unit };
            saved(&format!("{name}-{tag}.dxf"), &from_model(&drawn).expect("a drawing"))
        });
        for ((_, tag, _), facts) in Release::ALL.into_iter().zip(judged_all(&paths)) {
            assert_faultless(&format!("{name} {tag}"), &facts);
            let names = |block: &'static str| values(&facts, block, "NAME=");
            let bodies: Vec<&str> = model.bodies[1..].iter().map(|b| b.name.as_str()).collect();
            assert_eq!(names("BK_BODY"), bodies, "{name} {tag}");
            let kinds = ["BK_REVOLUTE", "BK_PRISMATIC", "BK_WELD", "BK_SLOT", "BK_LINK"];
            let joints = kinds.map(|kind| names(kind).len());
            assert_eq!(joints.iter().sum::<usize>(), model.joints.len(), "{name} {tag}");
            let drives: Vec<&str> = model.drives.iter().map(|d| d.name.as_str()).collect();
            assert_eq!(names("BK_DRIVE"), drives, "{name} {tag}");
            assert_eq!(names("BK_PARAMETER").len(), model.parameters.len(), "{name} {tag}");
        }
    }
}

#[test]
fn frames_are_drawn_where_the_start_has_them() {
    let (name, unit, text) = EXAMPLES[1];
    let (model, poses) = started(text, name);
    let drawn = Drawn { text, model: &model, poses: &poses, release: Release::R2010, unit };
    let facts = judged("four-bar-frames.dxf", &from_model(&drawn).expect("a drawing"));
    let frames = values(&facts, "BK_FRAME", "at=");
    assert_eq!(frames.len(), 3);
    for (frame, pose) in frames.iter().zip(&poses[1..]) {
        let numbers: Vec<f64> = frame.split(',').map(|n| n.parse().expect("a number")).collect();
        assert_eq!(numbers[..2], pose.origin.map(|x| 1000.0 * x), "{frame}");
        let turned = (numbers[2].to_radians() - pose.angle).rem_euclid(std::f64::consts::TAU);
        let off = turned.min(std::f64::consts::TAU - turned);
        // The writer of the format rounds degrees to the twelfth decimal.
        assert!(off < 2e-14, "{frame} is off by {off} rad");
    }
}

#[test]
fn values_keep_the_words_of_the_file_and_bare_numbers_get_their_unit() {
    let text = include_str!("../../../tests/fixtures/press-in-millimetres.toml");
    let (model, poses) = started(text, "press");
    let drawn = Drawn { text, model: &model, poses: &poses, release: Release::R2018, unit: "mm" };
    let facts = judged("press.dxf", &from_model(&drawn).expect("a drawing"));
    let expected = [
        ("BK_MODEL", "NAME=", "press"),
        ("BK_MODEL", "LENGTH=", "mm"),
        ("BK_PARAMETER", "VALUE=", "2 N/mm"),
        ("BK_BODY", "MASS=", "3 kg"),
        ("BK_BODY", "INERTIA=", "0"),
        ("BK_PRISMATIC", "BODY1=", "ground"),
        ("BK_PRISMATIC", "POINT2=", "origin"),
        ("BK_SPRING", "STIFFNESS=", "k"),
        ("BK_SPRING", "LENGTH=", "30 mm"),
        ("BK_SPRING", "POINT2=", "T"),
        ("BK_STOP", "MAX=", "80 mm"),
        ("BK_FORCE", "VECTOR=", "[0, 5 N*sin(2 rad/s*t)]"),
        ("BK_INITIAL", "POSITION=", "12 mm"),
        ("BK_INITIAL", "VELOCITY=", "1 m/s"),
        ("BK_SOLVE", "T_END=", "2 s"),
        ("BK_SOLVE", "TIMES=", "[0.5, 1.0]"),
    ];
    for (block, key, value) in expected {
        assert_eq!(values(&facts, block, key), [value], "{block} {key}");
    }
}

#[test]
fn what_has_no_place_in_a_drawing_is_refused_by_name() {
    let turned = "[bodies.a]\nmass = 1\n[joints.A]\ntype = \"revolute\"\n\
                  between = [\"ground\", \"a\"]\naxis = [0, 0, -1]\n";
    let alike = "[bodies.a]\nmass = 1\n[bodies.A]\nmass = 1\n[joints.J]\ntype = \"revolute\"\n\
                 between = [\"ground\", \"a\"]\n[joints.K]\ntype = \"revolute\"\n\
                 between = [\"a\", \"A\"]\n";
    let spatial = format!("space = \"spatial\"\n{}", turned.replace("-1", "1"));
    let play = turned.replace("axis = [0, 0, -1]", "clearance = \"1 mm\"");
    for (text, code) in [(turned, "D071"), (alike, "D072"), (&spatial, "D070"), (&play, "D071")] {
        let reading = read(&Source::new(text, "m"));
        let model = reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
        let poses = vec![PlanarPose::default(); model.bodies.len()];
        let release = Release::R2010;
        let drawn = Drawn { text, model: &model, poses: &poses, release, unit: "mm" };
        match from_model(&drawn) {
            Err(Unwritten::Model(fault)) => assert_eq!(fault.code.0, code, "{fault:?}"),
            other => panic!("{code}: {other:?}"),
        }
    }
}

/// The text of the model of a drawing.
fn composed(name: &str, bytes: Vec<u8>, unit: Option<&str>) -> String {
    let unit = unit.and_then(bksim_cad::units::by_name);
    let sheet = sheet(bytes, unit).unwrap_or_else(|e| panic!("{name}: {:?}", e.diagnostics));
    let composition = sheet.compose(ModelOptions::default());
    assert!(!composition.text.is_empty(), "{name}: {:?}", composition.diagnostics);
    composition.text
}

#[test]
fn a_drawn_model_reads_back_with_the_same_start_and_accelerations() {
    let more = [
        ("loads", "mm", include_str!("data/loads.toml")),
        ("units", "mm", include_str!("data/units.toml")),
        ("elements", "mm", include_str!("data/elements.toml")),
    ];
    for (name, unit, text) in EXAMPLES.into_iter().chain(more) {
        let (model, poses, expected) = started_whole(text, name);
        for (release, tag, _) in Release::ALL {
            let drawn = Drawn { text, model: &model, poses: &poses, release, unit };
            let bytes = from_model(&drawn).expect("a drawing");
            let is_unitless = (release == Release::R12).then_some(unit);
            let back = composed(&format!("{name} {tag}"), bytes, is_unitless);
            let (again, _, found) = started_whole(&back, name);
            assert_eq!(again.name, model.name, "{back}");
            assert_eq!(again.coordinates, model.coordinates, "{back}");
            let names = |model: &Model| -> Vec<String> {
                let loads = model.loads.iter().map(|l| &l.name);
                let drives = model.drives.iter().map(|d| &d.name);
                let couplings = model.couplings.iter().map(|c| &c.name);
                let curves = model.curves.iter().map(|c| &c.name);
                let controllers = model.states.iter().map(|s| &s.name);
                let signals = model.named_signals.iter().map(|s| &s.name);
                let held = model.held.iter().map(|s| &s.name);
                let named = couplings.chain(curves).chain(controllers).chain(signals).chain(held);
                let mut all: Vec<String> = model
                    .joints
                    .iter()
                    .map(|j| &j.name)
                    .chain(loads)
                    .chain(drives)
                    .chain(named)
                    .cloned()
                    .collect();
                all.sort();
                all
            };
            assert_eq!(names(&again), names(&model), "{back}");
            assert_eq!(
                found.keys().collect::<Vec<_>>(),
                expected.keys().collect::<Vec<_>>(),
                "{name} {tag}: {back}"
            );
            for (coordinate, numbers) in &expected {
                for (a, b) in numbers.iter().zip(found[coordinate]) {
                    // The loose weight of `loads` stays where the start leaves it, to the 1e-11
                    // to which a start closes.
                    let tolerance = if name == "loads" { 1e-10 } else { 1e-12 };
                    let scale = 1.0 + a.abs().max(b.abs());
                    let off = (a - b).abs();
                    assert!(
                        off < tolerance * scale,
                        "{name} {tag} {coordinate}: {a} is not {b}, off by {off:.1e}\n{back}"
                    );
                }
            }
        }
    }
}

/// A table with more rows than a value holds, and friction of teeth and of a follower on its cam.
#[test]
fn long_tables_and_friction_by_surfaces_read_back() {
    let rows: Vec<String> =
        (0..300).map(|k| format!("[{}, 0.{k:03}]", 0.1 * f64::from(k))).collect();
    let elements = include_str!("data/elements.toml");
    let short = "points = [[0, 0], [1, 0.2], [9, 0.9]]";
    assert!(elements.contains(short));
    let rub = "[loads.teeth]\ntype = \"friction\"\ncoupling = \"mesh\"\nmu = 0.05\nstatic = 0.06\n\
               pressure_angle = 0.35\n\
               [loads.face]\ntype = \"friction\"\njoint = \"face\"\nmu = 0.1\n[initial]\n";
    let text = elements
        .replace(short, &format!("points = [{}]", rows.join(", ")))
        .replace("[initial]\n", rub);
    let (model, poses, expected) = started_whole(&text, "long");
    for (release, tag, _) in Release::ALL {
        let drawn = Drawn { text: &text, model: &model, poses: &poses, release, unit: "mm" };
        let bytes = from_model(&drawn).expect("a drawing");
        let is_unitless = (release == Release::R12).then_some("mm");
        let back = composed(tag, bytes, is_unitless);
        assert!(back.contains(&format!("[{}]", rows.join(", "))), "{tag}: {back}");
        let (again, _, found) = started_whole(&back, "long");
        assert_eq!(again.loads.len(), model.loads.len(), "{back}");
        for (coordinate, numbers) in &expected {
            for (a, b) in numbers.iter().zip(found[coordinate]) {
                let scale = 1.0 + a.abs().max(b.abs());
                assert!(
                    (a - b).abs() < 1e-11 * scale,
                    "{tag} {coordinate}: {a} is not {b}\n{back}"
                );
            }
        }
    }
}

/// A bar that turns once about the origin: something to trace in any drawing.
fn turning(n: u32) -> (Course, Vec<BodyShape>) {
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let pose =
        |i| PlanarPose { angle: angle(i), rate: std::f64::consts::TAU, ..PlanarPose::default() };
    let force = |i| [30.0 * f64::cos(angle(i)), 30.0 * f64::sin(angle(i))];
    let corners = [[-10.0, -10.0], [110.0, -10.0], [110.0, 10.0], [-10.0, 10.0]];
    let corners = corners.map(|at| bksim_cad::geometry::Vertex { at, bulge: 0.0 });
    let path = bksim_cad::geometry::Path::from_bulges(&corners, true).expect("a rectangle");
    let course = Course {
        times: (0..=n).map(|i| f64::from(i) / f64::from(n)).collect(),
        poses: (0..=n).map(|i| vec![PlanarPose::default(), pose(i)]).collect(),
        points: vec![Traced { name: "bar.E".into(), body_idx: 1, at: [0.1, 0.0] }],
        reactions: vec![Reaction {
            name: "O".into(),
            body_idx: 1,
            at: [0.0, 0.0],
            force: (0..=n).map(force).collect(),
        }],
        curves: vec![MotionCurve {
            name: "bar.E".into(),
            kind: CurveKind::Way,
            body_idx: 0,
            pieces: vec![vec![[0.1, 0.0], [0.0, 0.1], [-0.1, 0.0]]],
            is_closed: true,
        }],
    };
    (course, vec![BodyShape { body_idx: 1, paths: vec![path], frame: Frame::default() }])
}

/// Targets: drawings of ours, of the independent library, in text and binary.
fn targets() -> Vec<(String, Vec<u8>)> {
    let (name, unit, text) = EXAMPLES[1];
    let (model, poses) = started(text, name);
    let mut all: Vec<(String, Vec<u8>)> = Release::ALL
        .map(|(release, tag, _)| {
            let drawn = Drawn { text, model: &model, poses: &poses, release, unit };
            (format!("traced-own-{tag}"), from_model(&drawn).expect("a drawing"))
        })
        .into();
    for other in ["R12", "R12_binary", "R2000", "R2010", "R2010_binary", "R2018"] {
        let path = python::workspace().join(format!("crates/cad/tests/drawings/{other}.dxf"));
        all.push((format!("traced-{other}"), fs::read(path).expect("a drawing of the tests")));
    }
    all
}

#[test]
fn a_trace_adds_to_a_drawing_and_changes_nothing_else() {
    let (course, shapes) = turning(72);
    let selection = Selection {
        paths: true,
        envelope: true,
        hodograph: true,
        reactions: even_samples(&course.times, 4),
        ghosts: even_samples(&course.times, 5),
    };
    let addition = trace(&course, &shapes, &selection, 1000.0);
    for (name, bytes) in targets() {
        let container = recognise(&bytes).expect("a drawing");
        let tags = Tags::scan(bytes.clone(), container).expect("a drawing");
        let traced = graft(&tags, &addition).expect("a traced drawing");

        let paths =
            [saved(&format!("{name}-before.dxf"), &bytes), saved(&format!("{name}.dxf"), &traced)];
        let [before, after] = judged_all(&paths).try_into().expect("two drawings");
        assert_faultless(&name, &after);
        // Old entities are there in the same order; new ones are on the layers of traces.
        let is_new = |fact: &&String| fact.contains("BK_TRACE_");
        let old: Vec<&String> = after.iter().filter(|fact| !is_new(fact)).collect();
        assert_eq!(old, before.iter().collect::<Vec<_>>(), "{name}");
        let count = |start: &str| after.iter().filter(|f| f.starts_with(start)).count();
        assert_eq!(count("layer BK_TRACE_"), 6, "{name}");
        for layer in ["PATHS", "ENVELOPE", "HODOGRAPH", "REACTIONS", "GHOSTS", "CURVES"] {
            assert!(count(&format!("entity BK_TRACE_{layer} ")) > 0, "{name}: {layer}");
        }
        // Byte for byte: the old file with one block in the layers, one in the entities, and
        // another seed of handles.
        let n_kept = kept(&bytes, &traced);
        assert!(bytes.len() - n_kept <= 8, "{name}: {n_kept} of {} bytes kept", bytes.len());
    }
}

/// How many bytes of a file are in another one in the same order, found in long pieces.
fn kept(old: &[u8], new: &[u8]) -> usize {
    const PIECE: usize = 64;
    let (mut i, mut j, mut n_kept) = (0, 0, 0);
    while i < old.len() && j < new.len() {
        let same = old[i..].iter().zip(&new[j..]).take_while(|(a, b)| a == b).count();
        (i, j, n_kept) = (i + same, j + same, n_kept + same);
        // Either a few bytes were replaced, or something was inserted before the next piece.
        let found = (0..16_usize.min(old.len() - i)).find_map(|skip| {
            let piece = &old[i + skip..(i + skip + PIECE).min(old.len())];
            let at = new[j..].windows(piece.len().max(1)).position(|window| window == piece)?;
            (!piece.is_empty()).then_some((skip, at))
        });
        let Some((skip, at)) = found else { break };
        (i, j) = (i + skip, j + at);
    }
    n_kept
}
