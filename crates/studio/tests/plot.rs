//! `bksim plot`, from the model to the picture.

use std::fs;

use crate::common::{CRATE, Scratch, other_mcap, text};
use serde_json::Value;

const EXAMPLES: [&str; 6] =
    ["five-link", "four-bar", "parallelogram", "quick-return", "slider-crank", "spring-pendulum"];

/// A ball that falls onto a stop and bounces.
const BALL: &str = include_str!("../../../tests/fixtures/falling-ball.toml");

fn run(place: &Scratch, arguments: &str) -> String {
    let output = place.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn json(place: &Scratch, arguments: &str) -> Value {
    serde_json::from_str(&run(place, &format!("{arguments} --json"))).expect("one object")
}

fn refused(place: &Scratch, arguments: &str) -> (i32, String) {
    let output = place.run(arguments);
    (output.status.code().expect("a status"), text(&output.stderr))
}

/// A place with the log of an example, `NAME.mcap`.
fn solved(name: &str, options: &str) -> Scratch {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/../../examples/{name}/model.toml")).expect("an example");
    place.write(&format!("{name}.toml"), model);
    run(&place, &format!("solve {name}.toml {options}"));
    place
}

/// Points of each curve of an SVG, in pixels.
fn curves(svg: &str) -> Vec<Vec<[f64; 2]>> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let curves = document.descendants().filter(|node| node.attribute("class") == Some("curve"));
    let points = |node: roxmltree::Node<'_, '_>| {
        let path = node.children().find(|child| child.has_tag_name("path")).expect("a path");
        let data = path.attribute("d").expect("data");
        let points = data.split(['M', 'L']).skip(1).map(|point| {
            // A dot is a line of no length.
            let mut numbers = point
                .trim_end_matches("h0")
                .split(' ')
                .map(|number| number.parse().expect("a number"));
            [numbers.next().expect("x"), numbers.next().expect("y")]
        });
        points.collect()
    };
    curves.map(points).collect()
}

/// How far a point is from a piece of a line.
fn distance([x, y]: [f64; 2], ends: &[[f64; 2]]) -> f64 {
    let [[a, b], [c, d]] = [ends[0], ends[1]];
    let (along, across) = (c - a, d - b);
    let length = along * along + across * across;
    let part = if length > 0.0 { ((x - a) * along + (y - b) * across) / length } else { 0.0 };
    let part = part.clamp(0.0, 1.0);
    (x - a - part * along).hypot(y - b - part * across)
}

#[test]
fn every_example_has_an_overview() {
    for example in EXAMPLES {
        let place = solved(example, "--t-end 0.2");
        let object = json(&place, &format!("plot {example}.mcap"));
        let panels = object["panels"].as_array().expect("panels");
        assert!((3..=6).contains(&panels.len()), "{example}: {} panels", panels.len());
        for panel in panels {
            let n = panel["curves"].as_array().expect("curves").len();
            assert!((1..=6).contains(&n), "{example}: {n} curves of {}", panel["label"]);
        }
        let words = run(&place, &format!("plot {example}.mcap -o a.svg"));
        assert!(words.starts_with("wrote a.svg: "), "{words}");
        let svg = fs::read_to_string(place.path().join("a.svg")).expect("a picture");
        assert!(svg.contains("Energy (") && curves(&svg).len() >= 3, "{example}");
        let shown = run(&place, &format!("plot {example}.mcap"));
        assert!(shown.lines().all(|line| line.chars().count() <= 100), "{example}\n{shown}");
        assert!(shown.contains("Time (s)") && !shown.contains('\x1b'), "{shown}");
    }
}

#[test]
fn few_samples_make_a_curve_as_smooth_as_many() {
    let place = solved("spring-pendulum", "--every 1 -o few.mcap");
    run(&place, "solve spring-pendulum.toml --every 0.002 -o many.mcap");
    let of = |name: &str, from: &str| {
        let object = json(&place, &format!("plot {name}.mcap state.phi -o {name}.svg"));
        assert_eq!(object["panels"][0]["curves"][0]["from"], from);
        let svg = fs::read_to_string(place.path().join(format!("{name}.svg"))).expect("a picture");
        curves(&svg).remove(0)
    };
    let [few, many] = [of("few", "motion"), of("many", "samples")];
    for [x, y] in many {
        let after = few.iter().position(|point| point[0] >= x).expect("as long").max(1);
        let [a, b] = [few[after - 1], few[after]];
        let between =
            if b[0] == a[0] { a[1] } else { a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) };
        assert!((between - y).abs() < 0.6, "{between} for {y} at {x}");
    }
}

#[test]
fn an_impact_is_an_upright_line() {
    let place = Scratch::new();
    place.write("ball.toml", BALL);
    run(&place, "solve ball.toml");
    let object = json(&place, "plot ball.mcap state.S_position_dot -o v.svg");
    // It falls for a second, and comes back as fast as it went.
    let curve = &object["panels"][0]["curves"][0];
    let number = |key: &str| curve[key].as_f64().expect("a number");
    assert!((number("smallest") + 10.0).abs() < 1e-6, "{curve}");
    assert!((number("largest") - 10.0).abs() < 1e-6, "{curve}");
    let svg = fs::read_to_string(place.path().join("v.svg")).expect("a picture");
    let curve = curves(&svg).remove(0);
    let steepest = curve.windows(2).map(|pair| (pair[0][1] - pair[1][1], pair[1][0] - pair[0][0]));
    let (height, width) = steepest.fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    assert!(height > 200.0 && width < 0.02, "{height} high, {width} wide");
}

#[test]
fn runs_lie_over_each_other_and_over_other_channels() {
    let place = solved("slider-crank", "--t-end 1");
    run(&place, "solve slider-crank.toml --t-end 1 --set q1=70 -o strong.mcap");
    let object = json(&place, "plot slider-crank.mcap strong.mcap state.theta1 -o both.svg");
    assert_eq!(object["panels"][0]["curves"].as_array().map(Vec::len), Some(2));
    let svg = fs::read_to_string(place.path().join("both.svg")).expect("a picture");
    // What differs is in the legend.
    assert!(svg.contains(">slider-crank, q1 = 55 N m</text>"), "{svg}");
    assert!(svg.contains(">strong, q1 = 70 N m</text>"));
    // The path of the rod's middle has one scale; phases of two units make two panels.
    let object =
        json(&place, "plot slider-crank.mcap state.y2 state.y2_dot --x state.x2 -o path.svg");
    assert_eq!(
        (&object["x"], object["panels"].as_array().map(Vec::len)),
        (&"state.x2".into(), Some(2))
    );
    let svg = fs::read_to_string(place.path().join("path.svg")).expect("a picture");
    assert!(svg.contains(">x2 (m)</text>") && svg.contains(">y2 (m)</text>"));
}

#[test]
fn measured_values_are_points_on_the_curve_of_the_run() {
    let place = Scratch::new();
    place.write("ball.toml", BALL);
    run(&place, "solve ball.toml --t-end 1");
    // 5 m − 5 m/s² t², as someone measures it: milliseconds, millimetres and decimal commas.
    let row = |k: i32| format!("{};{:.1};\n", 100 * k, 5000.0 - 50.0 * f64::from(k * k));
    let rows: String = (0..=9).map(row).collect();
    let rows = rows.replace('.', ",");
    place.write("camera.csv", format!("# seen\nTime [ms];S.position [mm];speed [m/s]\n{rows}"));
    let object = json(&place, "plot ball.mcap camera.csv S.position -o both.svg");
    let curves = object["panels"][0]["curves"].as_array().expect("curves").clone();
    assert_eq!((curves.len(), object["panels"].as_array().map(Vec::len)), (2, Some(1)));
    assert_eq!((&curves[1]["log"], &curves[1]["unit"]), (&"camera.csv".into(), &curves[0]["unit"]));
    let [smallest, largest] = ["smallest", "largest"].map(|key| curves[1][key].as_f64());
    assert!((smallest.expect("a number") - 0.95).abs() < 1e-12 && largest == Some(5.0));

    // Every point lies on the line, to a part of a pixel.
    let svg = fs::read_to_string(place.path().join("both.svg")).expect("a picture");
    assert!(svg.contains(">camera</text>") && svg.contains(">ball</text>"));
    let drawn = self::curves(&svg);
    let (line, points) = (&drawn[0], &drawn[1]);
    assert!(points.len() >= 10, "{} points", points.len());
    for [x, y] in points {
        let nearest = line.windows(2).map(|ends| distance([*x, *y], ends));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.5, "{nearest} px from the line at {x}, {y}");
    }
    // A table by itself has its own units.
    let object = json(&place, "plot camera.csv S.position --in mm");
    assert_eq!(object["panels"][0]["curves"][0]["largest"], 5000.0);
}

#[test]
fn what_one_of_several_files_has_not_is_said() {
    let place = solved("spring-pendulum", "--t-end 0.1");
    place.write("phi.csv", "t,phi\n0,0.1\n0.05,0.11\n");
    place.write("untimed.csv", "phi\n0.1\n0.2\n");
    place.write("words.csv", "t,phi\n0,high\n");
    place.write("length.csv", "t,phi [mm]\n0,1\n");
    place.write("bare.csv", "0,1\n1,2\n");
    let cases = [
        ("phi.csv energy.total", 2, "`phi.csv` has no `energy.total`"),
        ("phi.csv energy.total", 2, "it has state.phi"),
        ("untimed.csv phi", 2, "has no column `t`"),
        ("untimed.csv phi", 2, "--x phi"),
        ("words.csv phi", 1, "`high` in line 2"),
        ("length.csv phi", 1, "in mm, which is rad elsewhere"),
        ("bare.csv phi", 1, "has no headings"),
        (
            "phi.csv state.phi_dot --x energy.total",
            2,
            "`phi.csv` has no `energy.total` to draw over",
        ),
    ];
    for (arguments, status, words) in cases {
        let (found, message) = refused(&place, &format!("plot spring-pendulum.mcap {arguments}"));
        assert!(found == status && message.contains(words), "{arguments}: {found} {message}");
    }
    // One of several channels: the others are drawn.
    let told = place.run("plot spring-pendulum.mcap phi.csv state.phi energy.total -o a.svg");
    assert!(told.status.success());
    let message = text(&told.stderr);
    assert!(message.contains("`phi.csv` has no `energy.total`, and no curve of it"), "{message}");
    let object = json(&place, "plot spring-pendulum.mcap phi.csv state.phi energy.total");
    assert_eq!(object["runs"][1]["missing"], serde_json::json!(["energy.total"]));
}

#[test]
fn a_stretch_of_time_is_cut_out() {
    let place = solved("four-bar", "");
    run(&place, "plot four-bar.mcap state.D_angle --from 0.5 --to 1.5 -o part.svg");
    let object = json(&place, "plot four-bar.mcap solver.n_step --from 0.5 --to 1.5");
    assert_eq!(object["panels"][0]["curves"][0]["values"], 201);
    let svg = fs::read_to_string(place.path().join("part.svg")).expect("a picture");
    assert!(svg.contains(">0.6</text>") && !svg.contains(">0.4</text>"), "{svg}");
    for part in ["--from 2 --to 1", "--from nan"] {
        let (status, words) = refused(&place, &format!("plot four-bar.mcap {part}"));
        assert!(status == 2 && words.contains("--from"), "{words}");
    }
    let (status, words) = refused(&place, "plot four-bar.mcap --from 77");
    assert!(status == 1 && words.contains("no values"), "{words}");
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let place = solved("spring-pendulum", "--t-end 0.1");
    let cases = [
        ("plot spring-pendulum.mcap state.phy", 2, "did you mean `state.phi`"),
        ("plot spring-pendulum.mcap -o a.jpg", 2, "no ending that names a picture"),
        ("plot spring-pendulum.mcap --size 10x10 -o a.png", 2, "a picture cannot be 10 by 10"),
        ("plot spring-pendulum.mcap --size huge -o a.png", 2, "such as 1200x800"),
        ("plot spring-pendulum.mcap --x energy", 2, "names 5 channels"),
        ("plot missing.mcap", 4, "there is no such file"),
        ("plot spring-pendulum.toml --tolerance near", 2, "expected a length"),
        ("plot spring-pendulum.mcap -o missing/a.svg", 4, "cannot be written"),
    ];
    for (arguments, status, words) in cases {
        let (found, message) = refused(&place, arguments);
        assert!(found == status && message.contains(words), "{arguments}: {found} {message}");
    }
    // A picture of the same model is replaced, and one that was edited since is not.
    for file in ["a.svg", "a.pdf"] {
        run(&place, &format!("plot spring-pendulum.mcap -o {file}"));
        run(&place, &format!("plot spring-pendulum.mcap state.phi -o {file}"));
        let mut edited = fs::read(place.path().join(file)).expect("a picture");
        edited[100] ^= 1;
        place.write(file, &edited);
        let (status, words) = refused(&place, &format!("plot spring-pendulum.mcap -o {file}"));
        assert!(status == 4 && words.contains("--force"), "{words}");
        run(&place, &format!("plot spring-pendulum.mcap -o {file} --force"));
    }
}

#[test]
fn logs_cut_anywhere_are_told_and_drawn_as_far_as_they_go() {
    let place = solved("slider-crank", "--t-end 2");
    let log = fs::read(place.path().join("slider-crank.mcap")).expect("a log");
    let mut n_drawn = 0;
    for part in 0..20 {
        place.write("cut.mcap", &log[..log.len() * part / 20]);
        let info = place.run("info cut.mcap");
        // Without its index, which comes last, a log is whole.
        let is_whole = text(&info.stdout).contains("end time reached");
        assert!(!is_whole || part > 10, "{part}/20");
        for command in ["info cut.mcap", "plot cut.mcap", "plot cut.mcap energy.work"] {
            let output = place.run(command);
            let words = text(&output.stderr);
            let status = output.status.code().expect("no signal");
            assert!(status == 0 || status == 1, "{command} of {part}/20: {words}");
            let is_told = text(&output.stdout).contains("cut off") || words.contains("was cut off");
            assert!(status == 1 || is_told != is_whole, "{command} of {part}/20: {words}");
            n_drawn += u32::from(status == 0 && is_told && command.starts_with("plot"));
        }
    }
    assert!(n_drawn > 4, "{n_drawn} were drawn");
}

#[test]
fn logs_of_other_programs_are_refused() {
    let place = Scratch::new();
    place.write("other.mcap", other_mcap());
    let (status, words) = refused(&place, "plot other.mcap");
    assert!(status == 1 && words.contains("holds no bksim run"), "{words}");
}

#[test]
fn colours_of_names_from_outside_do_not_reach_the_terminal() {
    let place = Scratch::new();
    let model = fs::read_to_string(format!("{CRATE}/../../examples/slider-crank/model.toml"));
    place.write("a\u{1b}[31mb.toml", model.expect("an example"));
    for arguments in
        [&["solve", "a\u{1b}[31mb.toml", "--t-end", "0.1"][..], &["plot", "a--31mb.mcap"]]
    {
        let output = place.bksim().args(arguments).env("CLICOLOR_FORCE", "1").output();
        let output = output.expect("bksim starts");
        let said = text(&output.stdout);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(!said.contains("a\u{1b}[31mb"), "{said:?}");
        assert!(said.contains("a\\u{1b}[31mb"), "{said:?}");
    }
}

#[test]
fn a_log_that_was_cut_tells_which_reactions_are_not_unique() {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/../../tests/fixtures/block-against-stops.toml"));
    place.write("block.toml", model.expect("a model"));
    run(&place, "solve block.toml");
    let whole = fs::read(place.path().join("block.mcap")).expect("a log");
    let told = json(&place, "info block.mcap")["uniqueness"].clone();
    assert_eq!(told.as_array().map(Vec::len), Some(2), "{told}");
    // Without its end, which is a record of this name.
    let end = whole.windows(9).position(|bytes| bytes == b"bksim.end").expect("an end");
    place.write("cut.mcap", &whole[..end]);
    let cut = json(&place, "info cut.mcap");
    assert_eq!((&cut["complete"], &cut["uniqueness"]), (&Value::Bool(false), &told));
    assert!(run(&place, "info cut.mcap").contains("reactions that are not unique"));
    run(&place, "plot cut.mcap multipliers.ld1 -o cut.svg");
    let svg = fs::read_to_string(place.path().join("cut.svg")).expect("a picture");
    assert!(svg.contains("(not unique)"), "{svg}");
}

/// Velocities, momenta and the path of a centre of mass are no channels of the log.
#[test]
fn what_the_model_can_name_is_drawn() {
    let place = solved("slider-crank", "");
    let object = json(&place, "plot slider-crank.mcap rod.vx rod.px");
    let curves = |panel: usize| object["panels"][panel]["curves"][0].clone();
    assert_eq!(
        (&curves(0)["channel"], &curves(1)["channel"]),
        (&"rod.vx".into(), &"rod.px".into())
    );
    let drawn = json(&place, "plot slider-crank.mcap rod.y --x rod.x -o path.svg");
    let curve = &drawn["panels"][0]["curves"][0];
    assert_eq!((&curve["channel"], &curve["from"]), (&"rod.y".into(), &"motion".into()));
    // The middle of the rod comes up to half of the crank's length.
    let lengths =
        [&curve["smallest"], &curve["largest"]].map(|value| value.as_f64().expect("a number"));
    assert!(lengths[0] > -0.5 - 1e-6 && lengths[1] < 0.5 + 1e-6, "{lengths:?}");
    let (status, said) = refused(&place, "plot slider-crank.mcap rod.why");
    assert_eq!(status, 2);
    assert!(said.contains("no channel matches `rod.why`"), "{said}");
}

#[test]
fn a_model_is_drawn_like_its_log_in_the_units_of_the_reader() {
    let place = solved("four-bar", "--t-end 1");
    let of_log = json(&place, "plot four-bar.mcap D.angle:deg A.rate:rpm");
    let panel = |object: &Value, idx: usize| object["panels"][idx].clone();
    assert_eq!(panel(&of_log, 0)["unit"], "deg");
    assert_eq!(panel(&of_log, 1)["unit"], "rpm");
    // The crank turns at the speed of its drive.
    let rate = &panel(&of_log, 1)["curves"][0];
    for end in ["smallest", "largest"] {
        let rpm = rate[end].as_f64().expect("a number");
        assert!((rpm - 60.0).abs() < 1e-6, "{rate}");
    }
    // The axis says whose angle it is; a coordinate of the state has a name of its own.
    run(&place, "plot four-bar.mcap D.angle --title none -o angle.svg");
    run(&place, "plot four-bar.mcap state.D_angle --title none -o state.svg");
    let drawn = |name: &str| fs::read_to_string(place.path().join(name)).expect("a picture");
    let [measure, state] = ["angle.svg", "state.svg"].map(drawn);
    assert!(measure.contains("D.angle"), "{measure}");
    assert!(state.contains("D_angle") && !state.contains("state.D_angle"), "{state}");
    let in_si = json(&place, "plot four-bar.mcap D.angle");
    let [deg, rad] = [&of_log, &in_si]
        .map(|object| panel(object, 0)["curves"][0]["largest"].as_f64().expect("a number"));
    assert!((deg - rad.to_degrees()).abs() < 1e-9 * deg.abs(), "{deg} deg, {rad} rad");
    let of_model = json(&place, "plot four-bar.toml D.angle --units deg,ms");
    assert_eq!(panel(&of_model, 0)["unit"], "deg");
    let (status, said) = refused(&place, "plot four-bar.mcap D.angle:mm");
    assert!(status == 2 && said.contains("is in rad, not in mm"), "{said}");
}

#[test]
fn the_path_of_a_point_is_drawn_to_one_scale() {
    let place = solved("four-bar", "--t-end 1");
    let object = json(&place, "plot four-bar.mcap --path crank.B --units mm -o path.svg");
    let curve = &object["panels"][0]["curves"][0];
    // The pin of a crank of 100 mm goes round.
    for (end, expected) in [("smallest", -100.0), ("largest", 100.0)] {
        let y = curve[end].as_f64().expect("a number");
        assert!((y - expected).abs() < 0.01, "{curve}");
    }
    let svg = fs::read_to_string(place.path().join("path.svg")).expect("a picture");
    assert!(svg.contains("x (mm)") && svg.contains("y (mm)"), "axes have units");
    let circle = &curves(&svg)[0];
    let extent = |axis: usize| {
        let values = circle.iter().map(|point| point[axis]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    assert!((extent(0) - extent(1)).abs() < 0.5, "{} by {}", extent(0), extent(1));
    let two = json(&place, "plot four-bar.mcap --path crank.B --path coupler.C energy.kinetic");
    assert_eq!(two["panels"].as_array().map(Vec::len), Some(2));
    assert_eq!(two["panels"][1]["curves"].as_array().map(Vec::len), Some(2));
}
