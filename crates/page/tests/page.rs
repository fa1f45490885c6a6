//! Pages of runs as text: their embedded data, and the thinning of long runs.

use std::io::Write;
use std::process::{Command, Stdio};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bksim::log::{LogReader, Outcome};
use bksim::playback::Playback;
use bksim::record::Recorder;
use bksim::sim::pose::Pose;
use bksim::sim::run::{Observer, Sample, Segment};
use bksim::sim::sensitivity::StateSensitivity;
use bksim::{Mechanism, dae::Control};
use bksim_page::{Budget, IS_BUNDLED, Options, PageError, page};
use bksim_scene::Scene;
use serde_json::Value;

const PENDULUM: &str = include_str!("../../../tests/fixtures/shown-pendulum.toml");

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
    let simulation = mechanism.simulation().expect("equations");
    let log = Recorder::create(Vec::new(), &simulation, text, &start, &[]).expect("a log");
    let mut log = Logging(log);
    let summary = simulation.run(&start, &mut log, &|| false).expect("a run");
    let bytes = log.0.finish(&summary, Outcome::ReachedEnd, "end time reached").expect("a log");
    Playback::open(LogReader::open(&bytes[..]).expect("a log")).expect("a playback")
}

/// The data for the page's script.
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
fn curves_tell_where_they_are_one_of_many_solutions() {
    if is_without_bundle() {
        return;
    }
    let mut playback = played(include_str!("../../../tests/fixtures/block-against-stops.toml"));
    let hit = playback.uniqueness()[1].t;
    let found = page(&mut playback, &Options::default()).expect("a page");
    let data = embedded(&found.html);
    let channels = data["curves"]["channels"].as_array().expect("curves");
    let shared: Vec<_> = channels.iter().filter(|c| c["shared"] != serde_json::json!([])).collect();
    assert!(!shared.is_empty() && shared.len() < channels.len(), "{channels:?}");
    for channel in shared {
        assert_eq!(channel["shared"], serde_json::json!([[hit, 1.0]]), "{}", channel["name"]);
    }
    assert!(found.html.contains("Reactions that are not unique"));
}

#[test]
fn assemblies_stand_beside_each_other_in_the_colours_of_both_themes() {
    if is_without_bundle() {
        return;
    }
    let mut playback = played(include_str!("../../../examples/four-bar/model.toml"));
    let plain = page(&mut playback, &Options::default()).expect("a page").html;
    assert!(!plain.contains("id=\"assemblies\""));
    let options = Options { has_assemblies: true, ..Options::default() };
    let html = page(&mut playback, &options).expect("a page").html;
    let (_, section) = html.split_once("id=\"assemblies\"").expect("a section");
    let (section, _) = section.split_once("</section>").expect("its end");
    assert!(section.contains("<p>2 assemblies, all there are</p>"), "{section}");
    let model = playback.mechanism().model.snapshot().to_model();
    let found = bksim::analysis::assemblies(model).expect("assemblies");
    let sheets: Vec<&str> = section.split("<div class=\"sheet").skip(1).collect();
    assert_eq!(sheets.len(), 2);
    for sheet in &sheets {
        for assembly in &found.assemblies {
            let title = format!("{}  {}", assembly.number, assembly.name);
            let first_words = &title[..title.len().min(20)];
            assert!(sheet.contains(first_words), "{first_words}");
        }
    }
    let background =
        |sheet: &str| sheet.split_once("fill=\"").map(|(_, rest)| rest[..7].to_owned());
    assert_ne!(background(sheets[0]), background(sheets[1]));
}

#[test]
fn a_page_has_remarks_on_parts_that_do_not_fit() {
    if is_without_bundle() {
        return;
    }
    let mut playback = played(PENDULUM);
    let whole = page(&mut playback, &Options::default()).expect("a page");
    let budget = Budget { motion: 4000, curves: 20_000, equations: 200, ..Budget::default() };
    let small = page(&mut playback, &Options { budget, ..Options::default() }).expect("a page");
    assert!(small.n_pieces < whole.n_pieces && small.html.len() < whole.html.len());
    let thinning = small.thinning.expect("a thinned motion");
    assert!(thinning.n_together > 1 && thinning.deviation > 1e-9, "{thinning:?}");
    assert!(thinning.cut_at.is_none(), "{thinning:?}");
    assert!(small.n_channels[0] < small.n_channels[1]);
    assert_eq!(small.remarks.len(), 3, "{:?}", small.remarks);
    assert!(small.html.contains("too many for one page"));

    // The coarsest page has its deviation, too.
    let budget = Budget { motion: 400, ..Budget::default() };
    let coarse = page(&mut playback, &Options { budget, ..Options::default() }).expect("a page");
    assert_eq!(coarse.n_pieces, 1);
    let found = coarse.thinning.expect("a thinned motion").deviation;
    assert!(found > thinning.deviation, "{found}");
}

/// A ball of `2 n (n - 1)` triangles on a spherical joint.
fn meshed(n: usize) -> String {
    use std::f64::consts::PI;
    let mut corners = vec!["[0, 0, -1]".to_owned(), "[0, 0, 1]".to_owned()];
    for (ring, k) in (1..n).flat_map(|ring| (0..n).map(move |k| (ring, k))) {
        let (polar, around) = (PI * ring as f64 / n as f64, 2.0 * PI * k as f64 / n as f64);
        let [x, y] = [around.cos(), around.sin()].map(|part| polar.sin() * part);
        corners.push(format!("[{x:.9}, {y:.9}, {:.9}]", -polar.cos()));
    }
    let mut faces = Vec::new();
    for k in 0..n {
        let next = (k + 1) % n;
        let at = |ring: usize, k: usize| 2 + (ring - 1) * n + k;
        faces.push([0, at(1, next), at(1, k)]);
        faces.push([1, at(n - 1, k), at(n - 1, next)]);
        for ring in 1..n - 1 {
            faces.push([at(ring, k), at(ring, next), at(ring + 1, next)]);
            faces.push([at(ring, k), at(ring + 1, next), at(ring + 1, k)]);
        }
    }
    format!(
        "space = \"spatial\"\n[bodies.ball]\nmass = 1\ninertia = [0.4, 0.4, 0.4]\n\
         shapes = [{{ type = \"mesh\", corners = [{}], faces = {faces:?}, unit = \"m\" }}]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"ball\"]\n\
         [initial]\nA = {{ rate = 1 }}\n[solve]\nt_end = 0.1\nevery = 0.1\n",
        corners.join(", ")
    )
}

#[test]
fn a_page_of_a_mesh_of_twenty_thousand_faces_is_smaller_than_two_megabytes() {
    if is_without_bundle() {
        return;
    }
    let mut playback = played(&meshed(100));
    let whole = page(&mut playback, &Options::default()).expect("a page");
    let faces = |html: &str| {
        let shapes = embedded(html)["scene"]["shapes"].clone();
        let shapes = shapes.as_array().expect("shapes").iter();
        shapes.map(|shape| shape["faces"].as_array().map_or(0, Vec::len)).max().unwrap_or(0)
    };
    assert_eq!(faces(&whole.html), 19_800);
    assert_eq!(whole.remarks, Vec::<String>::new());
    assert!(whole.html.len() < 2_000_000, "{} bytes", whole.html.len());

    // What does not fit is drawn coarser, and said.
    let budget = Budget { solids: 60_000, ..Budget::default() };
    let coarse = page(&mut playback, &Options { budget, ..Options::default() }).expect("a page");
    let kept = faces(&coarse.html);
    assert!((500..4_000).contains(&kept), "{kept} faces");
    assert!(coarse.remarks.iter().any(|remark| remark.contains("faces")), "{:?}", coarse.remarks);
}

/// Numbers in base64.
fn doubles(value: &Value) -> Vec<f64> {
    let text = value.as_str().expect("base64");
    let bytes = STANDARD.decode(text).expect("base64");
    let (numbers, _) = bytes.as_chunks::<8>();
    numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

fn count(value: &Value) -> usize {
    value.as_u64().and_then(|n| usize::try_from(n).ok()).expect("a count")
}

/// The polynomials of a page.
fn pieces(data: &Value) -> Vec<Segment> {
    let motion = &data["motion"];
    let n_columns = count(&motion["columns"]);
    let (times, values) = (doubles(&motion["times"]), doubles(&motion["values"]));
    let degrees = motion["degrees"].as_array().expect("degrees").iter();
    let mut first = 0;
    let piece = |(degree, ends): (&Value, &[f64])| {
        let n = (count(degree) + 1) * n_columns;
        first += n;
        let values = values[first - n..first].to_vec();
        Segment { t0: ends[0], t1: ends[1], values, ..Segment::default() }
    };
    degrees.zip(times.windows(2)).map(piece).collect()
}

/// Largest difference of q and v, and of the reaction as a part of the largest, between the page
/// and the equations, at instants of its pieces at which the page does not compare them.
fn differences(pieces: &[Segment], playback: &mut Playback) -> [f64; 2] {
    let (mut largest, mut worst) = (0.0_f64, [0.0_f64; 2]);
    for piece in pieces {
        for part in [0.05, 0.37, 0.71, 0.96] {
            let t = piece.t0 + part * (piece.t1 - piece.t0);
            let mut found = [0.0; 4];
            piece.at(t, &mut found);
            let sample = playback.seek(t).expect("the motion");
            let [fx, fy, ..] = sample.reactions[0];
            let expected = [sample.q[0], sample.v[0], fx, fy];
            let off = |i: usize| (found[i] - expected[i]).abs();
            worst = [worst[0].max(off(0)).max(off(1)), worst[1].max(off(2)).max(off(3))];
            largest = largest.max(fx.hypot(fy));
        }
    }
    [worst[0], worst[1] / largest]
}

#[test]
fn a_large_run_is_thinned_and_its_reactions_with_it() {
    if is_without_bundle() {
        return;
    }
    // A fixed step gives the run 25 000 of them: more than fit into a page.
    let text = PENDULUM.replace("t_end = \"5 s\"", "t_end = \"5 s\"\nstep = \"0.2 ms\"");
    let mut playback = played(&text);
    let n_steps = playback.log().segments.len();
    assert!(n_steps >= 25_000, "{n_steps} steps");
    let large = page(&mut playback, &Options::default()).expect("a page");
    assert!(large.html.len() < 2_000_000, "{} bytes", large.html.len());
    assert!(4 * large.n_pieces < n_steps, "{} pieces", large.n_pieces);
    // The thinned steps are still those of the motion, to the last digits.
    let [motion, reaction] = differences(&pieces(&embedded(&large.html)), &mut playback);
    assert!(motion < 1e-9 && reaction < 1e-9, "{motion:.1e}, reactions {reaction:.1e}");

    // With less space, the stated deviation is the true one.
    let budget = Budget { motion: 4000, ..Budget::default() };
    let small = page(&mut playback, &Options { budget, ..Options::default() }).expect("a page");
    let stated = small.thinning.expect("a thinned motion").deviation;
    let [motion, reaction] = differences(&pieces(&embedded(&small.html)), &mut playback);
    assert!((0.3 * stated..3.0 * stated).contains(&motion), "{motion:.1e}, stated {stated:.1e}");
    assert!((1e-9..1e-2).contains(&reaction), "reactions {reaction:.1e}, stated {stated:.1e}");
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

/// Three cranks share the load of a beam: each reaction is one of many, at all times; the motion is not.
#[test]
fn what_is_one_of_many_solutions_is_marked() {
    if is_without_bundle() {
        return;
    }
    let text = include_str!("../../../examples/parallelogram/model.toml");
    let mut playback = played(text);
    let written = page(&mut playback, &Options::default()).expect("a page");
    let data = embedded(&written.html);
    let spans = |name: &str| -> Value {
        let channels = data["curves"]["channels"].as_array().expect("channels");
        let found = channels.iter().find(|channel| channel["name"] == name);
        found.expect("the channel")["shared"].clone()
    };
    assert_eq!(spans("reactions.A.fx"), serde_json::json!([[0.0, 3.0]]));
    assert_eq!(spans("state.A_angle"), serde_json::json!([]));
    let markers = data["scene"]["markers"].as_array().expect("markers");
    let joint = markers.iter().find(|marker| marker["kind"] == "joint").expect("a joint");
    assert_eq!(joint["shared"], serde_json::json!([[0.0, 3.0]]));

    let data = embedded(&page(&mut played(PENDULUM), &Options::default()).expect("a page").html);
    let channels = data["curves"]["channels"].as_array().expect("channels");
    assert!(channels.iter().all(|channel| channel["shared"] == serde_json::json!([])));
}

/// A string that meets a peg of some size and leaves it, and a belt whose second wheel is carried away.
const CORDS: &str = r#"
[ground]
points = { O = [0, 0], P = [0, -0.5] }
[bodies.bob]
mass = 2
free = true
points = { C = [0, 0] }
[bodies.arm]
mass = 1
inertia = 0.1
points = { A = [0, 0], B = [0.4, 0] }
[bodies.first]
mass = 1
inertia = 0.1
[bodies.second]
mass = 1
inertia = 0.1
[joints.pivot]
type = "revolute"
between = ["ground.O", "arm.A"]
[joints.p1]
type = "revolute"
between = ["arm.A", "first"]
[joints.p2]
type = "revolute"
between = ["arm.B", "second"]
[couplings.string]
type = "rope"
over = ["ground.O", { pulley = "ground.P", radius = "20 mm", turn = "left", leaves = true }, "bob.C"]
[couplings.belt]
type = "belt"
between = ["p1", "p2"]
radii = ["50 mm", "80 mm"]
turns = ["left", "left"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[initial]
bob = { x = 0.6, y = -0.8, vx = 0, vy = 0 }
pivot = { angle = 0, rate = 2 }
p1 = { angle = 0, rate = 1 }
[solve]
t_end = "1.5 s"
every = "50 ms"
"#;

#[test]
fn a_page_lays_ropes_and_belts_as_pictures_do() {
    let mut playback = played(CORDS);
    let [first, last] = playback.span();
    let at = |playback: &mut Playback, part: f64| {
        playback.seek(first + part * (last - first)).expect("an instant");
        playback.poses().to_vec()
    };
    let poses: Vec<Vec<Pose>> = (0..=20).map(|k| at(&mut playback, f64::from(k) / 20.0)).collect();
    let mechanism = playback.mechanism();
    let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &poses[..1]);
    let written = scene.written(&vec![None; scene.shapes.len()], &[], &[], &|_| Vec::new());
    let of_body = |pose: &Pose| {
        let rotation = pose.r_world_from_body.into_iter().flatten();
        pose.origin.into_iter().chain(rotation).chain([0.0; 6]).collect::<Vec<f64>>()
    };
    let numbers: Vec<Vec<f64>> =
        poses.iter().map(|p| p.iter().flat_map(of_body).collect()).collect();
    let script = "import { cordLine } from './cords.js'; let all = ''; process.stdin.on('data', (x) => { all += x; }); \
         process.stdin.on('end', () => { const { cords, numbers } = JSON.parse(all); \
         console.log(JSON.stringify(numbers.map((n) => cords.map((c) => cordLine(c, n))))); });";
    let mut node = Command::new("node")
        .args(["--input-type=module", "-e", script])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/web/src"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("node starts");
    let asked = serde_json::json!({ "cords": written["cords"], "numbers": numbers });
    let mut input = node.stdin.take().expect("its input");
    input.write_all(asked.to_string().as_bytes()).expect("node reads");
    drop(input);
    let output = node.wait_with_output().expect("node ends");
    let lines: Vec<Vec<Vec<[f64; 2]>>> = serde_json::from_slice(&output.stdout).expect("JSON");

    let mut n_corners = Vec::new();
    for (poses, lines) in poses.iter().zip(&lines) {
        for (cord, line) in scene.cords.iter().zip(lines) {
            let expected = cord.line(poses).expect("a way");
            assert_eq!(line.len(), expected.len(), "{}", cord.name);
            for ([x, y], [ex, ey, _]) in line.iter().zip(&expected) {
                assert!((x - ex).abs() < 1e-12 && (y - ey).abs() < 1e-12, "{}", cord.name);
            }
        }
        n_corners.push(lines[1].len());
    }
    // Straight at some instants, bent around the peg at others.
    assert!(n_corners.contains(&2) && n_corners.iter().any(|&n| n > 3), "{n_corners:?}");
}
