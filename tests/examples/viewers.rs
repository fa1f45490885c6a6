//! Logs in tools that know nothing of bksim: readers in Python open what runs of the examples leave.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use crate::python::{python, workspace};
use crate::support::{derive, example, example_names, example_text};
use bksim::Mechanism;
use bksim::dae::Control;
use bksim::log::{Level, Log, LogReader, Outcome};
use bksim::model::{Joint, JointKind};
use bksim::record::Recorder;
use bksim::sim::run::{Observer, Sample, Segment};
use bksim::sim::sensitivity::StateSensitivity;
use serde_json::Value;

/// Writes a run to its log.
struct Logged(Recorder<Vec<u8>>);

impl Observer for Logged {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.0.write(sample).expect("written");
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.0.segment(segment).expect("written");
    }
}

/// The log of a run, with a warning in it at its start and a line at its end.
fn logged(mechanism: &Mechanism, text: &str) -> Vec<u8> {
    let start = mechanism.start().expect("a start");
    let simulation = mechanism.simulation().expect("equations");
    let recorder = Recorder::create(Vec::new(), &simulation, text, &start, &[]).expect("a log");
    let mut logged = Logged(recorder);
    logged.0.note(Level::Warning, start.t, "first").expect("written");
    let summary = simulation.run(&start, &mut logged, &|| false).expect("a run");
    logged.0.note(Level::Info, summary.t, "last").expect("written");
    logged.0.finish(&summary, Outcome::ReachedEnd, "done").expect("written")
}

/// Runs an example and keeps its log in a file.
fn example_log(test: &str, name: &str) -> (Mechanism, Log, PathBuf) {
    let mechanism = derive(example(name));
    let bytes = logged(&mechanism, &example_text(name));
    let path = kept(&format!("{test}-{name}"), &bytes);
    (mechanism, Log::read(&bytes[..]).expect("a log"), path)
}

/// Keeps a log in a file.
fn kept(name: &str, bytes: &[u8]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("viewers-{name}.mcap"));
    std::fs::write(&path, bytes).expect("written");
    path
}

/// The script's answer for each log.
fn judged(task: &str, paths: &[PathBuf]) -> Vec<Value> {
    let script = workspace().join("tests/viewers/judge.py");
    let paths = paths.iter().map(|path| path.to_str().expect("a plain path"));
    let args: Vec<&str> = std::iter::once(task).chain(paths).collect();
    serde_json::from_str(&python(&script, &args)).expect("JSON")
}

/// Names of the bodies but the ground.
fn moving(mechanism: &Mechanism) -> Vec<&str> {
    mechanism.model.bodies.iter().skip(1).map(|body| body.name.as_str()).collect()
}

/// The frames that move: those of bodies, then those of massless links that keep their length.
fn frames(mechanism: &Mechanism) -> Vec<&str> {
    let Mechanism { model, .. } = mechanism;
    let is_link = |joint: &&Joint| match joint.kind {
        JointKind::Link { length } => !model.pool.depends_on(length, model.time),
        _ => false,
    };
    let links = model.joints.iter().filter(is_link).map(|joint| joint.name.as_str());
    moving(mechanism).into_iter().chain(links).collect()
}

fn n_samples(log: &Log) -> usize {
    log.series(log.header.topic_id("/state").expect("a state")).t.len()
}

#[test]
fn an_independent_reader_finds_frames_scene_joints_and_lines() {
    let names = example_names();
    let logs: Vec<_> = names.iter().map(|name| example_log("contents", name)).collect();
    let paths: Vec<PathBuf> = logs.iter().map(|(.., path)| path.clone()).collect();
    for ((name, (mechanism, log, _)), found) in
        names.iter().zip(&logs).zip(judged("contents", &paths))
    {
        let n_samples = n_samples(log);
        for topic in ["/state", "/tf", "/joint_states"] {
            assert_eq!(found["messages"][topic], n_samples, "{name}: {topic}");
        }
        assert_eq!(found["roots"], serde_json::json!(["ground"]), "{name}");
        assert_eq!(found["frames"], serde_json::json!(frames(mechanism)), "{name}");
        assert_eq!(found["scene_times"], serde_json::json!([0]), "{name}");

        // Geometry is told once, on the frames of bodies, for ever, a body at a time.
        let scene = bksim_scene::Scene::of(&mechanism.model, &mechanism.parameters);
        let entities = found["entities"].as_array().expect("entities");
        let mut with_shapes: Vec<&str> =
            scene.shapes.iter().map(|shape| scene.bodies[shape.body].as_str()).collect();
        with_shapes.sort_unstable();
        with_shapes.dedup();
        let mut ids: Vec<&str> = entities.iter().filter_map(|e| e["id"].as_str()).collect();
        ids.sort_unstable();
        assert_eq!(ids, with_shapes, "{name}");
        for entity in entities {
            assert!(
                entity["is_locked"] == true && entity["is_for_ever"] == true,
                "{name}: {entity}"
            );
            assert_eq!(entity["frame"], entity["id"], "{name}");
        }
        let drawn = |body: &&str| entities.iter().any(|entity| entity["frame"] == **body);
        let moving = moving(mechanism);
        let mut rigid = moving.iter().filter(|body| !is_of_beam(mechanism, body));
        assert!(rigid.all(drawn), "{name}: a body has no shape");
        if scene.spans.is_empty() && scene.cords.is_empty() {
            assert_eq!(found["messages"]["/spans"], Value::Null, "{name}");
        } else {
            assert_eq!(found["messages"]["/spans"], n_samples, "{name}");
        }

        let joints = found["joints"].as_array().expect("joints");
        // Integrals of states are coordinates, but no joints.
        let n_states = mechanism.model.states.len();
        assert_eq!(joints.len(), mechanism.compiled.coordinates.len() - n_states, "{name}");
        let end = log.end.as_ref().expect("an end").t_end;
        let lines = found["log"].as_array().expect("lines");
        let texts: Vec<_> = lines.iter().map(|line| (&line[2], &line[3])).collect();
        assert_eq!(texts, [(&3.into(), &"first".into()), (&2.into(), &"last".into())], "{name}");
        for (line, t) in lines.iter().zip([0.0, end]) {
            let times = [&line[0], &line[1]].map(Value::as_f64);
            assert_eq!(times, [Some((t * 1e9_f64).round()); 2], "{name}");
        }
        // Its own reader lists none of this, and has the times of the lines.
        let topics = || log.header.topics.iter().map(|topic| topic.name.as_str());
        let foreign = ["/tf", "/scene", "/spans", "/joint_states", "/log"];
        assert!(!topics().any(|t| foreign.contains(&t) || t.starts_with("/outlines")), "{name}");
        assert!(topics().any(|topic| topic == "/state"));
        let notes: Vec<f64> = log.notes.iter().map(|note| note.t).collect();
        assert_eq!(notes, [0.0, end], "{name}");
    }
}

#[test]
fn outlines_of_a_model_are_areas_of_its_scene() {
    let (.., path) = example_log("areas", "slider-crank");
    let found = judged("contents", &[path]).remove(0);
    let entities = found["entities"].as_array().expect("entities");
    for (body, expected) in [("crank", 1.2 * 0.2), ("rod", 3.2 * 0.12), ("slider", 0.6 * 0.4)] {
        let of_body = entities.iter().filter(|entity| entity["frame"] == body);
        let areas: Vec<f64> = of_body
            .flat_map(|entity| entity["areas"].as_array().cloned().unwrap_or_default())
            .filter_map(|area| area.as_f64())
            .collect();
        assert!(areas.iter().any(|area| (area - expected).abs() < 1e-6), "{body}: {areas:?}");
    }
    // Each shape lies above the ones painted before it.
    let mut n_areas = 0;
    for entity in entities {
        let heights = entity["heights"].as_array().expect("heights");
        let heights: Vec<f64> = heights.iter().filter_map(Value::as_f64).collect();
        assert!(heights.is_sorted_by(|a, b| a < b), "{entity}");
        n_areas += heights.len();
    }
    assert!(n_areas > 3, "{n_areas} areas");
}

#[test]
fn the_schemas_are_those_that_are_published() {
    let names = ["slider-crank", "spring-pendulum"];
    let paths = names.map(|name| example_log("schemas", name).2);
    for (name, found) in names.iter().zip(judged("schemas", &paths)) {
        let counts = found.as_object().expect("counts");
        let schemas: Vec<&str> = counts.keys().map(String::as_str).collect();
        let mut expected = ["FrameTransforms", "JointStates", "Log", "PointCloud", "SceneUpdate"]
            .map(|schema| format!("foxglove.{schema}"))
            .to_vec();
        expected.sort();
        let mut sorted = schemas.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, expected, "{name}");
        // Comparing nothing would prove nothing.
        let fewest = counts.values().filter_map(Value::as_u64).min();
        assert!(
            fewest >= Some(8) && counts["foxglove.SceneUpdate"].as_u64() > Some(60),
            "{counts:?}"
        );
    }
}

#[test]
fn transforms_are_those_of_the_crank_s_triangle() {
    let (_, log, path) = example_log("triangle", "slider-crank");
    let found = judged("slider-crank", &[path]).remove(0);
    let number = |key: &str| found[key].as_f64().expect("a number");
    assert_eq!(found["n_compared"], 3 * n_samples(&log));
    // Samples are projected onto the joints far below the solver's tolerance of 1e-8.
    assert!(number("places") < 1e-10 && number("angles") < 1e-10, "{found}");
}

/// True of a beam and its parts, which are spans.
fn is_of_beam(mechanism: &Mechanism, body: &str) -> bool {
    let mut beams = mechanism.model.bodies.iter().filter(|body| body.flexible.is_some());
    beams.any(|beam| body.starts_with(&beam.name))
}

#[test]
fn rerun_loads_transforms_outlines_lines_and_own_channels() {
    let names = example_names();
    let logs: Vec<_> = names.iter().map(|name| example_log("rerun", name)).collect();
    let paths: Vec<PathBuf> = logs.iter().map(|(.., path)| path.clone()).collect();
    for ((name, (mechanism, log, _)), found) in names.iter().zip(&logs).zip(judged("rerun", &paths))
    {
        let (n_samples, frames) = (n_samples(log), frames(mechanism));
        assert_eq!(found["/tf"]["Transform3D"], n_samples * frames.len(), "{name}");
        for frame in &frames {
            let points = &found[format!("/outlines/{frame}")]["Points3D"];
            if !is_of_beam(mechanism, frame) {
                assert_eq!(*points, 1, "{name}: {frame}");
            }
        }
        assert_eq!(found["/log"]["TextLog"], 2, "{name}");
        assert_eq!(found["/joint_states"]["JointStates"], n_samples, "{name}");
        assert_eq!(found["/state"]["State"], n_samples, "{name}");
    }
}

#[test]
fn equal_runs_leave_equal_files_with_what_viewers_are_shown() {
    let text = example_text("spring-pendulum");
    let mechanism = derive(example("spring-pendulum"));
    assert!(logged(&mechanism, &text) == logged(&mechanism, &text));
}

#[test]
fn a_resumed_run_shows_the_same() {
    let name = "spring-pendulum";
    let (text, mechanism) = (example_text(name), derive(example(name)));
    let simulation = mechanism.simulation().expect("equations");
    let start = simulation.start().expect("a start");
    let log =
        || Logged(Recorder::create(Vec::new(), &simulation, &text, &start, &[]).expect("log"));

    // Until its thirtieth step, then on from the log of that.
    let steps = Cell::new(30);
    let stop = || {
        steps.set(steps.get() - 1);
        steps.get() == 0
    };
    let mut first = log();
    let summary = simulation.run(&start, &mut first, &stop).expect("a run");
    let checkpoint = summary.checkpoint.clone().expect("stopped");
    let first = first.0.finish(&summary, Outcome::Stopped, "stopped").expect("written");
    let mut second = log();
    let mut reader = LogReader::open(&first[..]).expect("a log");
    assert!(second.0.copy(&mut reader, &checkpoint).expect("copied"));
    let summary = simulation.resume(&start, &checkpoint, &mut second, &|| false);
    let summary = summary.expect("a run");
    let second = second.0.finish(&summary, Outcome::ReachedEnd, "done").expect("written");
    let mut whole = log();
    let summary = simulation.run(&start, &mut whole, &|| false).expect("a run");
    let whole = whole.0.finish(&summary, Outcome::ReachedEnd, "done").expect("written");

    let parts = [("first", first), ("second", second), ("whole", whole)];
    let paths = parts.map(|(part, bytes)| kept(&format!("resumed-{part}"), &bytes));
    let [first, second, whole] = &judged("digest", &paths)[..] else { panic!("three logs") };
    assert!(first["/tf"].is_string() && first["/tf"] != whole["/tf"], "{first}");
    assert!(whole["/spans"].is_string() && whole["/joint_states"].is_string(), "{whole}");
    assert_eq!(second, whole);
}
