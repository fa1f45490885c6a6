//! A session as a page has it: poses under the hand, motions, faults under which the last picture stays.

use bksim_edit::{Answer, Posed, Session, Solver, range_about};
use bksim_model::file::{Source, read};
use serde_json::{Value, json};

const FOUR_BAR: &str = include_str!("../../../examples/four-bar/model.toml");
const SLIDER_CRANK: &str = include_str!("../../../examples/slider-crank/model.toml");
const QUICK_RETURN: &str = include_str!("../../../examples/quick-return/model.toml");
const FIVE_LINK: &str = include_str!("../../../examples/five-link/model.toml");

fn opened(text: &str) -> Session {
    let mut session = Session::default();
    ask(&mut session, &json!({ "do": "open", "text": text, "name": "model" }));
    session
}

fn ask(session: &mut Session, request: &Value) -> Answer {
    session.answer(&request.to_string())
}

fn model(text: &str) -> bksim_model::Model {
    read(&Source::new(text, "model")).model.expect("a model")
}

/// Largest difference of the places and directions of all bodies.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let of_place = |k: &usize| k % 18 < 12;
    assert_eq!(a.len(), b.len());
    (0..a.len()).filter(of_place).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

#[test]
fn a_dragged_point_takes_the_mechanism_where_its_motion_does() {
    for (text, body, point) in [
        (FOUR_BAR, 1, [0.1, 0.0, 0.0]),
        (SLIDER_CRANK, 1, [0.1, 0.0, 0.0]),
        (QUICK_RETURN, 1, [0.1, 0.0, 0.0]),
        (FIVE_LINK, 1, [0.1, 0.0, 0.0]),
    ] {
        let moved = Solver::default().solve(text, "model", model(text)).expect("a motion");
        let mut posed = Posed::of(model(text)).expect("a pose");
        let n = 18 * posed.model().bodies.len();
        let first = &moved.frames[..n];
        assert!(difference(&posed.numbers(), first) < 1e-9, "the start");
        posed.grab(body, point).expect("a body");
        let mut compared = 0;
        for k in (0..moved.times.len()).step_by(7).take(40) {
            let frame = &moved.frames[k * n..(k + 1) * n];
            let at = |i: usize| {
                let row = 18 * body + 3 + 3 * i;
                frame[18 * body + i] + (0..3).map(|j| frame[row + j] * point[j]).sum::<f64>()
            };
            let dragged = posed.to([at(0), at(1), at(2)]);
            assert!(dragged.distance < 1e-9, "{}: {dragged:?} at frame {k}", posed.model().name);
            // One free motion: the place of the point is the pose.
            if text != FIVE_LINK {
                let off = difference(&posed.numbers(), frame);
                assert!(off < 1e-8, "{}: {off} at frame {k}", posed.model().name);
                compared += 1;
            }
        }
        assert!(text == FIVE_LINK || compared > 10);
    }
}

#[test]
fn a_pull_beyond_reach_ends_at_the_nearest_place() {
    let mut posed = Posed::of(model(FOUR_BAR)).expect("a pose");
    posed.grab(1, [0.1, 0.0, 0.0]).expect("the crank");
    let dragged = posed.to([0.3, 0.4, 0.0]);
    // On the ray from the pivot to the hand.
    assert!((dragged.distance - 0.4).abs() < 1e-9, "{dragged:?}");
    let crank = &posed.numbers()[18..36];
    assert!((crank[3] - 0.6).abs() < 1e-5 && (crank[6] - 0.8).abs() < 1e-5, "{crank:?}");
}

#[test]
fn a_stop_holds_the_hand_and_is_named() {
    let text = "[bodies.arm]\nmass = 1\ninertia = 1\npoints = { P = [1, 0] }\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n\
                [loads.end]\ntype = \"stop\"\njoint = \"A\"\nmax = \"30 deg\"\n";
    let mut session = opened(text);
    ask(&mut session, &json!({ "do": "grab", "body": 1, "point": [1, 0, 0] }));
    let answer = ask(&mut session, &json!({ "do": "drag", "to": [0.1, 1, 0] }));
    assert_eq!(answer.json["limit"], "stop of joint A");
    let sine = answer.numbers[18 + 6];
    assert!((sine - 0.5).abs() < 1e-8, "{sine}");
}

#[test]
fn the_last_good_picture_stays_under_a_fault() {
    let mut session = opened(FOUR_BAR);
    let good = ask(&mut session, &json!({ "do": "pose", "pose": "start" }));
    let set = |path: &str, value: &str| json!({ "do": "edit", "edit": { "edit": "set", "path": path, "value": value } });
    let answer = ask(&mut session, &set("bodies.crank.mass", "2 furlongs"));
    assert_eq!(answer.json["is_whole"], false);
    let fault = &answer.json["faults"][0];
    assert!(fault["labels"][0]["line"].as_u64().is_some_and(|line| line > 1), "{fault}");
    assert_eq!(ask(&mut session, &json!({ "do": "pose", "pose": "start" })).numbers, good.numbers);
    // Not TOML at all: the text can still be typed on, and taken back.
    let answer =
        ask(&mut session, &json!({ "do": "edit", "edit": { "edit": "text", "text": "[bodies" } }));
    assert_eq!(answer.json["is_current"], false);
    let answer = ask(&mut session, &set("parameters.a", "1 m"));
    assert_eq!(answer.json["fault"]["code"], "W001");
    ask(&mut session, &json!({ "do": "undo" }));
    let answer = ask(&mut session, &json!({ "do": "undo" }));
    assert_eq!(answer.json["text"], FOUR_BAR);
    assert_eq!(answer.json["is_current"], true);
    // What is no request is a fault, too.
    assert!(session.answer("{\"do\": \"dance\"}").json["fault"]["message"].is_string());
}

#[test]
fn a_motion_of_other_values_equals_that_of_a_fresh_reading_bit_for_bit() {
    let mut session = opened(FOUR_BAR);
    let solve = json!({ "do": "solve" });
    let first = ask(&mut session, &solve);
    assert_eq!(first.json["is_derived"], true, "{}", first.json);
    let edit = json!({ "do": "edit", "edit": { "edit": "set", "path": "parameters.b", "value": "0.32 m" } });
    ask(&mut session, &edit);
    let replayed = ask(&mut session, &solve);
    assert_eq!(replayed.json["is_derived"], false);
    let fresh = ask(&mut opened(session.text()), &solve);
    assert_eq!(replayed.numbers, fresh.numbers);
    assert_ne!(replayed.numbers, first.numbers);
    // Another topology is derived.
    ask(&mut session, &json!({ "do": "edit", "edit": { "edit": "delete", "name": "gravity" } }));
    assert_eq!(ask(&mut session, &solve).json["is_derived"], true);
}

#[test]
fn a_four_bar_drawn_from_nothing_moves() {
    let mut session = opened("");
    let end = |x: f64, y: f64, on: Option<&str>| json!({ "world": [x, y], "on": on });
    for edit in [
        json!({ "edit": "link", "from": end(0.0, 0.0, None), "to": end(0.05, 0.08, None) }),
        json!({ "edit": "link", "from": end(0.05, 0.08, Some("link1.B")), "to": end(0.3, 0.15, None) }),
        json!({ "edit": "link", "from": end(0.3, 0.15, Some("link2.B")), "to": end(0.28, -0.02, None) }),
        json!({ "edit": "ground", "at": end(0.0, 0.0, Some("link1.A")) }),
        json!({ "edit": "ground", "at": end(0.28, -0.02, Some("link3.B")) }),
        json!({ "edit": "motor", "joint": "C", "angle": 0.08_f64.atan2(0.05) }),
    ] {
        let answer = ask(&mut session, &json!({ "do": "edit", "edit": edit }));
        assert_eq!(
            answer.json["is_current"],
            true,
            "{}\n{}",
            answer.json["faults"],
            session.text()
        );
        assert!(answer.json.get("fault").is_none(), "{}", answer.json["fault"]);
    }
    // Drawn where it was clicked, to the digits that are written.
    let answer = ask(&mut session, &json!({ "do": "pose", "pose": "start" }));
    let coupler = &answer.numbers[36..38];
    assert!((coupler[0] - 0.05).abs() < 1e-5 && (coupler[1] - 0.08).abs() < 1e-5, "{coupler:?}");
    let freedoms = ask(&mut session, &json!({ "do": "freedoms" }));
    assert_eq!(freedoms.json["mobility"], 1, "{}", freedoms.json);
    let motion = ask(&mut session, &json!({ "do": "solve" }));
    let n = usize::try_from(motion.json["n_frames"].as_u64().unwrap_or(0)).expect("a number");
    assert!(n > 100, "{}\n{}", motion.json, session.text());
    let equations = ask(&mut session, &json!({ "do": "equations" }));
    assert!(
        equations.json["sections"][0]["html"].as_str().is_some_and(|html| html.contains("<math"))
    );
    let ways = ask(&mut session, &json!({ "do": "assemblies" }));
    assert_eq!(ways.json["assemblies"].as_array().map(Vec::len), Some(2), "{}", ways.json);
    assert_eq!(ways.numbers.len(), 2 * 4 * 18);
}

#[test]
fn a_pose_becomes_the_start() {
    // The crank of the third turns by less than a right angle and a bit.
    for (text, to) in [
        (FOUR_BAR, [-0.04, 0.1, 0.0]),
        (SLIDER_CRANK, [-0.04, 0.1, 0.0]),
        (FIVE_LINK, [0.08, 0.06, 0.0]),
    ] {
        let mut session = opened(text);
        ask(&mut session, &json!({ "do": "grab", "body": 1, "point": [0.1, 0, 0] }));
        let posed = ask(&mut session, &json!({ "do": "drag", "to": to }));
        ask(&mut session, &json!({ "do": "release" }));
        let answer = ask(&mut session, &json!({ "do": "start_here" }));
        assert!(answer.json.get("fault").is_none(), "{}", answer.json["fault"]);
        assert_eq!(
            answer.json["is_current"],
            true,
            "{}\n{}",
            answer.json["faults"],
            session.text()
        );
        // Six digits are written.
        let off = difference(&posed.numbers, &answer.numbers);
        assert!(off < 1e-4, "{off}\n{}", session.text());
        let fresh = ask(&mut opened(session.text()), &json!({ "do": "pose", "pose": "start" }));
        assert!(difference(&fresh.numbers, &posed.numbers) < 1e-4, "{}", session.text());
    }
}

#[test]
fn a_length_under_a_slider_keeps_the_pose_that_the_hand_gave() {
    let mut session = opened(FOUR_BAR);
    ask(&mut session, &json!({ "do": "grab", "body": 1, "point": [0.1, 0, 0] }));
    let before = ask(&mut session, &json!({ "do": "drag", "to": [0.0, 0.1, 0] }));
    let edit = json!({ "edit": "set", "path": "parameters.b", "value": "0.301 m" });
    let after = ask(&mut session, &json!({ "do": "edit", "edit": edit, "moving": true }));
    let off = difference(&before.numbers, &after.numbers);
    assert!(off > 1e-6 && off < 0.05, "{off}");
}

const PENDULUM: &str = "[parameters]\nl = \"0.5 m\"\n[bodies.arm]\nmass = 1\ninertia = 0.01\ncom = [\"l\", 0]\n\
    points = { P = [\"l\", 0] }\n[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n\
    [loads.weight]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
    [initial]\nA = { angle = \"-30 deg\" }\n[solve]\nt_end = 1\n";

/// The place of a body's point in an answer.
fn place_of(answer: &Answer, body: usize, point: [f64; 3]) -> [f64; 3] {
    let at = &answer.numbers[18 * body..];
    [0, 1, 2].map(|i| at[i] + (0..3).map(|j| at[3 + 3 * i + j] * point[j]).sum::<f64>())
}

fn steps(session: &mut Session, n: usize, to: Option<[f64; 3]>) -> Answer {
    let mut answer = Answer::default();
    for _ in 0..n {
        answer = ask(session, &json!({ "do": "step", "dt": 0.02, "to": to }));
        assert!(answer.json.get("fault").is_none(), "{}", answer.json);
    }
    answer
}

#[test]
fn a_live_motion_is_that_of_the_model() {
    for text in [PENDULUM, FOUR_BAR, SLIDER_CRANK] {
        let moved = Solver::default().solve(text, "model", model(text)).expect("a motion");
        let n = moved.frames.len() / moved.times.len();
        let mut session = opened(text);
        ask(&mut session, &json!({ "do": "live" }));
        let answer = steps(&mut session, 10, None);
        let t = answer.json["t"].as_f64().expect("a time");
        let k = moved.times.iter().position(|time| (time - t).abs() < 1e-9).expect("a sample");
        let off = difference(&answer.numbers, &moved.frames[k * n..(k + 1) * n]);
        assert!((t - 0.2).abs() < 1e-9 && off < 1e-4, "{off} at {t} s");
    }
}

#[test]
fn a_hand_pulls_a_moving_body_and_lets_it_go() {
    let mut session = opened(PENDULUM);
    ask(&mut session, &json!({ "do": "live" }));
    let free = steps(&mut session, 5, None);
    let held = ask(&mut session, &json!({ "do": "pull", "body": 1, "point": [0.5, 0, 0] }));
    assert_eq!(held.json["t"], free.json["t"]);
    assert!(difference(&held.numbers, &free.numbers) < 1e-12);
    // It comes to rest where the hand is, but for the sag of its weight.
    let answer = steps(&mut session, 150, Some([0.3, 0.4, 0.0]));
    let [x, y, _] = place_of(&answer, 1, [0.5, 0.0, 0.0]);
    assert!((x - 0.3).hypot(y - 0.4) < 0.02, "{x} {y}");
    // Free again, its energy stays.
    let energy = |answer: &Answer| -> f64 {
        answer.json["energy"].as_array().into_iter().flatten().filter_map(Value::as_f64).sum()
    };
    let [first, last] = [1, 100].map(|n| steps(&mut session, n, None));
    assert!((energy(&first) - energy(&last)).abs() < 1e-4, "{} {}", first.json, last.json);
    assert!(difference(&first.numbers, &last.numbers) > 0.1);
    // The pose stays when it rests.
    let rest = ask(&mut session, &json!({ "do": "rest" }));
    assert!(difference(&rest.numbers, &last.numbers) < 1e-9);
}

#[test]
fn a_live_motion_goes_on_with_another_length() {
    let mut session = opened(PENDULUM);
    ask(&mut session, &json!({ "do": "live" }));
    let before = steps(&mut session, 12, None);
    ask(
        &mut session,
        &json!({ "do": "edit", "edit": { "edit": "set", "path": "parameters.l", "value": "0.25 m" } }),
    );
    let after = steps(&mut session, 1, None);
    let angle = |answer: &Answer| answer.numbers[18 + 6].atan2(answer.numbers[18 + 3]);
    let speed = |answer: &Answer| answer.numbers[18 + 17];
    assert!((after.json["t"].as_f64().expect("a time") - 0.26).abs() < 1e-9);
    assert!((angle(&after) - angle(&before) - 0.02 * speed(&before)).abs() < 0.01);
    assert!((speed(&after) - speed(&before)).abs() < 0.9, "rates go on");
    // A driven one is where its drive is.
    let mut session = opened(SLIDER_CRANK);
    ask(&mut session, &json!({ "do": "live", "t": 0.3 }));
    let answer = steps(&mut session, 1, None);
    assert!((answer.json["t"].as_f64().expect("a time") - 0.32).abs() < 1e-9);
}

#[test]
fn a_picture_is_drawn_as_a_page_sees_it() {
    let mut session = opened(FOUR_BAR);
    let view = |dark: bool| {
        json!({ "centre": [0.1, 0, 0], "scale": 1000, "rows": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                         "size": [400, 300], "is_dark": dark, "has_names": true })
    };
    let ask_for = |session: &mut Session, dark| {
        ask(session, &json!({ "do": "picture", "numbers": [], "view": view(dark) }))
    };
    let [light, dark] = [false, true].map(|dark| ask_for(&mut session, dark).json["svg"].clone());
    let svg = light.as_str().expect("a picture");
    assert!(
        svg.starts_with("<svg") && svg.contains("width=\"400\"") && svg.contains(">A<"),
        "{svg}"
    );
    assert_ne!(light, dark);
}

#[test]
fn sliders_of_negative_numbers_mirror_those_of_positive_ones() {
    for x in [3.0, 0.5] {
        let [[low, high], below] = [range_about(x, "N"), range_about(-x, "N")];
        assert_eq!([low, high], [0.2 * x, 2.0 * x]);
        assert_eq!(below, [-high, -low]);
    }
    assert_eq!(range_about(0.0, "N"), [-1.0, 1.0]);
    assert_eq!(range_about(-30.0, "deg"), [-180.0, 180.0]);
    assert_eq!(range_about(-200.0, "deg"), [-400.0, -40.0]);
}

#[test]
fn sliders_go_between_the_ends_that_the_model_states() {
    let text = format!(
        "{FOUR_BAR}\n[ranges]\na = [\"0.08 m\", \"120 mm\"]\nD.guess.angle = [\"30 deg\", \"2 rad\"]\n"
    );
    let mut session = opened(&text);
    let state = ask(&mut session, &json!({ "do": "redo" })).json;
    let range = |path: &str| {
        let controls = state["controls"].as_array().expect("controls");
        let control = controls.iter().find(|control| control["path"] == path).expect(path);
        (control["unit"].as_str().expect("a unit").to_owned(), control["range"].clone())
    };
    let [low, high] = [0.08, 0.12];
    assert_eq!(range("parameters.a"), ("m".to_owned(), json!([low, high, (high - low) / 200.0])));
    let (unit, ends) = range("initial.D.guess.angle");
    assert_eq!((unit.as_str(), &ends[0], &ends[1]), ("deg", &json!(30.0), &json!(114.592)));
    assert_eq!(state["faults"].as_array().map(Vec::len), Some(0), "{}", state["faults"]);
}

#[test]
fn every_body_of_a_motion_is_cut_free() {
    let mut session = opened(FOUR_BAR);
    let solved = ask(&mut session, &json!({ "do": "solve" }));
    let count = |key: &str| solved.json[key].as_array().expect("a list").len();
    let n_frames =
        usize::try_from(solved.json["n_frames"].as_u64().expect("a count")).expect("fits");
    let n_bodies = solved.json["scene"]["bodies"].as_array().expect("bodies").len();
    let (rows, n_curves) = (&solved.json["forces"], count("curves"));
    let first = n_frames * (1 + n_curves + 18 * n_bodies);
    assert_eq!(solved.numbers.len(), first + 9 * count("forces") * n_frames);
    // Action and reaction: on both bodies of the pin C, at its place, of the size that the curve has.
    let row = |body: &str| {
        let bodies = solved.json["scene"]["bodies"].as_array().expect("bodies");
        let place = bodies.iter().position(|name| name == body).expect("the body");
        let all = rows.as_array().expect("rows");
        all.iter().position(|row| row["body"] == place && row["name"] == "C").expect("the pin")
    };
    let curves = solved.json["curves"].as_array().expect("curves");
    let curve = curves.iter().position(|curve| curve["name"] == "reaction of C").expect("it");
    for frame in [0, n_frames / 3, n_frames - 1] {
        let nine = |row: usize| &solved.numbers[first + 9 * (frame * count("forces") + row)..][..9];
        let (a, b) = (nine(row("coupler")), nine(row("rocker")));
        let size = a[0].hypot(a[1]);
        assert!((0..3).all(|i| (a[i] + b[i]).abs() <= 1e-12 * size), "{a:?} {b:?}");
        assert!((3..6).all(|i| (a[i] - b[i]).abs() < 1e-9), "{a:?} {b:?}");
        let shown = solved.numbers[n_frames * (1 + curve) + frame];
        assert!((size - shown).abs() <= 1e-12 * shown, "{size} {shown}");
    }
}

#[test]
fn limits_and_transmission_angles_are_those_of_the_lengths() {
    let mut session = opened(FOUR_BAR);
    let found = ask(&mut session, &json!({ "do": "limits" })).json;
    let tables = found["tables"].as_array().expect("tables");
    let titled = |title: &str| tables.iter().find(|table| table["title"] == title).expect("it");
    // Ground 0.3, crank 0.1, coupler 0.3, rocker 0.25 m: the law of cosines in the poses with the crank in line with the ground.
    let angle = |ground: f64| {
        let cos = (0.3_f64.powi(2) + 0.25_f64.powi(2) - ground.powi(2)) / (2.0 * 0.3 * 0.25);
        let acute = cos.abs().acos().to_degrees();
        format!("{} deg", (acute * 1e4).round() / 1e4)
    };
    let mut expected = [angle(0.3 - 0.1), angle(0.3 + 0.1)];
    let rows = titled("Transmission angles")["rows"].as_array().expect("rows");
    let row = rows.iter().find(|row| row[0] == "C").expect("the pin of coupler and rocker");
    let shown = [&row[1], &row[3]].map(|cell| cell.as_str().expect("a text").to_owned());
    let value = |text: &String| text.trim_end_matches(" deg").parse::<f64>().expect("a number");
    expected.sort_by(|a, b| value(a).total_cmp(&value(b)));
    // Where coupler and rocker are at right angles the angle is greatest.
    assert_eq!(shown[0], expected[0]);
    assert!(value(&shown[1]) >= value(&expected[1]));
    assert_eq!(titled("Four-bars")["rows"][0][2], "Grashof");
    // While a hand drags, the angle of the pose.
    ask(&mut session, &json!({ "do": "grab", "body": 1, "point": [0.1, 0.0, 0.0] }));
    let dragged = ask(&mut session, &json!({ "do": "drag", "to": [0.1, 0.0, 0.0] })).json;
    let degrees = dragged["transmissions"][0]["degrees"].as_f64().expect("an angle");
    let least = value(&angle(0.3 - 0.1));
    assert!((degrees - least).abs() < 1e-3, "{degrees} {least}");
    let two = include_str!("../../../examples/cart-pole/model.toml");
    let refused = ask(&mut opened(two), &json!({ "do": "limits" })).json;
    assert!(refused["refused"].as_str().is_some_and(|why| why.contains('2')), "{refused}");
}

#[test]
fn symbols_of_equations_know_their_bodies_and_values() {
    let mut session = opened(FOUR_BAR);
    let symbols = ask(&mut session, &json!({ "do": "equations" })).json["symbols"].clone();
    let named = |name: &str| {
        let all = symbols.as_array().expect("symbols").clone();
        all.into_iter().find(|symbol| symbol["name"] == name).expect("the symbol")
    };
    let at = ask(&mut session, &json!({ "do": "coordinates" })).json;
    let first = at["names"][0].as_str().expect("a name").to_owned();
    assert_eq!(named(&first)["bodies"], json!([1]));
    assert_eq!(named("b")["value"], 0.3);
    assert_eq!(named("b")["bodies"], json!([2]), "the coupler");
}

#[test]
fn elements_offer_the_keys_that_they_lack() {
    let mut session = opened(FOUR_BAR);
    let state = ask(&mut session, &json!({ "do": "settle" }));
    assert_eq!(state.json, json!({}));
    let state = ask(&mut session, &json!({ "do": "undo" })).json;
    let elements = state["elements"].as_array().expect("elements").clone();
    let of =
        |name: &str| elements.iter().find(|element| element["name"] == name).expect("it").clone();
    let more = of("C")["more"].as_array().expect("keys").clone();
    assert!(more.contains(&json!("mu")) && !more.contains(&json!("between")), "{more:?}");
    let edit =
        json!({ "do": "edit", "edit": { "edit": "set", "path": "joints.C.mu", "value": "0.1" } });
    let state = ask(&mut session, &edit).json;
    assert!(state["text"].as_str().expect("a text").contains("mu = 0.1"), "{}", state["text"]);
}
