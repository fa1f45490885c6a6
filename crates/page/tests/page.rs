//! Pages of runs, as text: what is embedded, and what is left out of long ones.

use bksim::log::{LogReader, Outcome};
use bksim::mbs::run::{Observer, Sample, Segment};
use bksim::mbs::sensitivity::StateSensitivity;
use bksim::playback::Playback;
use bksim::record::Recorder;
use bksim::{Mechanism, dae::Control};
use bksim_page::{Budget, IS_BUNDLED, Options, PageError, page};
use serde_json::Value;

const PENDULUM: &str = r#"
[parameters]
l = "0.5 m"
[bodies.bob]
mass = "2 kg"
points = { P = [0, "-l"] }
com = [0, "-l"]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[initial]
A = { angle = "60 deg" }
[solve]
t_end = "5 s"
"#;

struct Logging(Recorder<Vec<u8>>);

impl Observer for Logging {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.0.write(sample).expect("memory");
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.0.segment(segment).expect("memory");
    }
}

/// The run of a model.
fn played(text: &str) -> Playback {
    let mechanism = Mechanism::from_toml(text, "pendulum").expect("a model");
    let start = mechanism.start().expect("a start");
    let equations = mechanism.formulate().expect("equations");
    let log = Recorder::create(Vec::new(), &mechanism, text, &start, &[]).expect("a log");
    let mut log = Logging(log);
    let summary = mechanism.run(&equations, &start, &mut log, &|| false).expect("a run");
    let bytes = log.0.finish(&summary, Outcome::ReachedEnd, "end time reached").expect("a log");
    Playback::open(LogReader::open(&bytes[..]).expect("a log")).expect("a playback")
}

/// What the page's script reads.
fn embedded(html: &str) -> Value {
    let (_, rest) = html.split_once("id=\"run\">").expect("the data");
    let (json, _) = rest.split_once("</script>").expect("its end");
    serde_json::from_str(json).expect("JSON")
}

fn is_without_bundle() -> bool {
    if !IS_BUNDLED {
        let refused = page(&mut played(PENDULUM), &Options::default());
        assert!(matches!(refused, Err(PageError::NotBundled)));
    }
    !IS_BUNDLED
}

#[test]
fn the_page_holds_motion_poses_scene_and_curves() {
    if is_without_bundle() {
        return;
    }
    let found = page(&mut played(PENDULUM), &Options::default()).expect("a page");
    assert_eq!(found.remarks, Vec::<String>::new());
    assert!(found.deviation < 1e-9, "{}", found.deviation);
    let data = embedded(&found.html);
    assert_eq!(data["span"], serde_json::json!([0.0, 5.0]));
    // q, v and a force in the plane.
    assert_eq!(data["motion"]["columns"], 4);
    assert_eq!(data["motion"]["degrees"].as_array().map(Vec::len), Some(found.n_pieces));
    assert_eq!(data["poses"]["outputs"].as_array().map(Vec::len), Some(2 * 18));
    assert_eq!(data["scene"]["bodies"][1], "bob");
    let names = data["curves"]["channels"].as_array().expect("curves").iter();
    let names: Vec<&str> = names.filter_map(|channel| channel["name"].as_str()).collect();
    assert!(names.contains(&"state.A_angle") && names.contains(&"energy.total"), "{names:?}");
    for part in ["Kinetic energy", "<math", "SHA-256", "Permission is hereby granted"] {
        assert!(found.html.contains(part), "{part}");
    }
}

#[test]
fn what_does_not_fit_is_said() {
    if is_without_bundle() {
        return;
    }
    let mut playback = played(PENDULUM);
    let whole = page(&mut playback, &Options::default()).expect("a page");
    let budget = Budget { motion: 4000, curves: 20_000, equations: 200 };
    let small = page(&mut playback, &Options { budget, title: None }).expect("a page");
    assert!(small.n_pieces < whole.n_pieces && small.html.len() < whole.html.len());
    let thinning = small.thinning.expect("a thinned motion");
    assert!(thinning.n_together > 1 && thinning.deviation > 1e-9, "{thinning:?}");
    assert!(thinning.cut_at.is_none(), "{thinning:?}");
    assert!(small.n_channels[0] < small.n_channels[1]);
    assert_eq!(small.remarks.len(), 3, "{:?}", small.remarks);
    assert!(small.html.contains("too many for one page"));

    // The coarsest page there is says how coarse it is.
    let budget = Budget { motion: 400, ..Budget::default() };
    let coarse = page(&mut playback, &Options { budget, title: None }).expect("a page");
    assert_eq!(coarse.n_pieces, 1);
    let found = coarse.thinning.expect("a thinned motion").deviation;
    assert!(found > thinning.deviation, "{found}");
}

#[test]
fn titles_and_texts_cannot_break_out() {
    if is_without_bundle() {
        return;
    }
    let text = format!("# </pre></script><script>alert(1)</script>\n{PENDULUM}");
    let title = Some("</title><script>alert(2)</script>\"'".to_owned());
    let options = Options { title, ..Options::default() };
    let html = page(&mut played(&text), &options).expect("a page").html;
    assert_eq!(html.matches("<script").count(), 2);
    assert_eq!(html.matches("</script").count(), 2);
    assert!(!html.contains("<script>alert"));
}
