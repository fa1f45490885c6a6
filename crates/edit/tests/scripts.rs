//! Random scripts of edits: whatever a hand has done, the text, pose and motion are those of a fresh reading, and undo
//! gives the bytes back.
//!
//! `BKSIM_SCRIPTS` is the number of scripts.

use bksim_edit::{Answer, Session};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::{Value, json};

const TEXTS: [&str; 6] = [
    include_str!("../../../examples/four-bar/model.toml"),
    include_str!("../../../examples/slider-crank/model.toml"),
    include_str!("../../../examples/quick-return/model.toml"),
    include_str!("../../../examples/five-link/model.toml"),
    include_str!("../../../examples/gear-rattle/model.toml"),
    "",
];
/// Number of scripts, where the environment names none.
const N_SCRIPTS: usize = 60;
/// Edits of a script.
const N_EDITS: usize = 10;

fn ask(session: &mut Session, request: &Value) -> Answer {
    session.answer(&request.to_string())
}

fn opened(text: &str) -> (Session, Answer) {
    let mut session = Session::default();
    let answer = ask(&mut session, &json!({ "do": "open", "text": text, "name": "model" }));
    (session, answer)
}

/// An element of a list, `null` of an empty one.
fn any<'v>(random: &mut impl Rng, list: &'v Value) -> &'v Value {
    let n = list.as_array().map_or(0, Vec::len);
    if n == 0 { &Value::Null } else { &list[random.random_range(0..n)] }
}

fn place(random: &mut impl Rng) -> [f64; 2] {
    [0, 1].map(|_| f64::from(random.random_range(-30..30)) * 0.01)
}

/// An end on a named point, on a body, or on the ground.
fn end(random: &mut impl Rng, state: &Value) -> Value {
    let world = place(random);
    match random.random_range(0..4) {
        0 | 1 if state["points"][0].is_object() => {
            json!({ "world": world, "on": any(random, &state["points"])["name"] })
        }
        2 if state["scene"]["bodies"][1].is_string() => {
            json!({ "world": world, "on": any(random, &state["scene"]["bodies"]), "local": place(random) })
        }
        _ => json!({ "world": world }),
    }
}

/// An edit of any kind, most of them possible.
fn edit(random: &mut impl Rng, state: &Value) -> Value {
    let (from, to) = (end(random, state), end(random, state));
    let name = &any(random, &state["elements"])["name"];
    match random.random_range(0..26) {
        0..5 => {
            let control = any(random, &state["controls"]);
            let factor = random.random_range(0.5..1.5);
            let number = control["number"].as_f64().unwrap_or(1.0) * factor;
            let value = format!("{number:.4} {}", control["unit"].as_str().unwrap_or_default());
            json!({ "edit": "set", "path": control["path"].as_str().unwrap_or("solve.t_end"), "value": value })
        }
        5..7 => {
            let point = &any(random, &state["points"])["name"];
            json!({ "edit": "move", "point": point.as_str().unwrap_or("ground.O"), "to": place(random) })
        }
        7 => {
            json!({ "edit": "rename", "name": name, "to": format!("n{}", random.random_range(0..99)) })
        }
        8 if random.random_range(0..4) == 0 => {
            json!({ "edit": "remove", "path": format!("initial.{}", name.as_str().unwrap_or_default()) })
        }
        8 => json!({ "edit": "delete", "name": name }),
        9 | 10 => json!({ "edit": "link", "from": from, "to": to }),
        11 => json!({ "edit": "plate", "corners": [from, to, end(random, state)] }),
        12 => json!({ "edit": "pin", "from": from, "to": to }),
        13 => json!({ "edit": "ground", "at": from }),
        14 => json!({ "edit": "slide", "at": from, "angle": 0.3 }),
        15 => json!({ "edit": "spring", "from": from, "to": to }),
        16 => json!({ "edit": "damper", "from": from, "to": to }),
        17 => json!({ "edit": "force", "at": from, "vector": [1, -2] }),
        18 => json!({ "edit": "gravity" }),
        19 => {
            json!({ "edit": "copy", "name": name, "at": place(random), "mirrored": random.random_range(0..2) == 0 })
        }
        20 => {
            let body = name.as_str().unwrap_or_default();
            json!({ "edit": "length", "from": format!("{body}.A"), "to": format!("{body}.B"), "value": "150 mm" })
        }
        21 => json!({ "edit": "slide", "at": from, "angle": 0, "guide": to }),
        22 => {
            let [a, b] = [0, 1].map(|_| any(random, &state["joints"])["name"].clone());
            json!({ "edit": "gear", "between": [a.as_str().unwrap_or("A"), b.as_str().unwrap_or("B")], "distance": 0.1 })
        }
        23 | 24 => {
            let bodies = state["scene"]["bodies"].as_array().map_or(&[][..], Vec::as_slice);
            let names: Vec<&Value> =
                bodies.iter().skip(1).take(random.random_range(1..4)).collect();
            let by = place(random);
            let to = [json!("delete"), json!({ "move": by }), json!({ "copy": by })];
            json!({ "edit": "group", "names": names, "to": to[random.random_range(0..3)] })
        }
        _ => {
            let joint = &any(random, &state["joints"])["name"];
            json!({ "edit": "motor", "joint": joint.as_str().unwrap_or("A"), "angle": 0.2 })
        }
    }
}

/// The request of the next step of a script.
fn request(random: &mut impl Rng, state: &Value) -> Value {
    match random.random_range(0..12) {
        0 => json!({ "do": "undo" }),
        1 => json!({ "do": "redo" }),
        2 => json!({ "do": "settle" }),
        3 => {
            let edits = [edit(random, state), edit(random, state)];
            json!({ "do": "edit", "edit": { "edit": "several", "edits": edits } })
        }
        _ => {
            json!({ "do": "edit", "edit": edit(random, state), "moving": random.random_range(0..3) == 0 })
        }
    }
}

/// Compares a session with a fresh one of its text: what is shown, the pose of the start, and the motion if `is_moved`.
fn compare(session: &mut Session, state: &Answer, is_moved: bool, script: &str) {
    let text = session.text().to_owned();
    let (mut fresh, shown) = opened(&text);
    for key in ["text", "is_current", "is_whole", "faults", "controls", "elements"] {
        assert_eq!(state.json[key], shown.json[key], "{key} of {script}:\n{text}");
    }
    if text.trim().is_empty() || shown.json["is_current"] != true {
        return;
    }
    assert_eq!(
        state.json["joints"].as_array().map(Vec::len),
        shown.json["joints"].as_array().map(Vec::len)
    );
    let start = json!({ "do": "pose", "pose": "start" });
    let [own, other] = [&mut *session, &mut fresh].map(|one| ask(one, &start));
    assert_eq!(own.numbers, other.numbers, "pose of {script}:\n{text}");
    if is_moved {
        let solve = json!({ "do": "solve" });
        let [own, other] = [&mut *session, &mut fresh].map(|one| ask(one, &solve));
        assert_eq!(own.json["faults"], other.json["faults"], "faults of {script}:\n{text}");
        let is_same = own.numbers.len() == other.numbers.len()
            && own.numbers.iter().zip(&other.numbers).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(is_same, "motion of {script}:\n{text}");
    }
}

#[test]
fn whatever_is_edited_equals_a_fresh_reading_and_is_undone() {
    let named = std::env::var("BKSIM_SCRIPTS").ok().and_then(|n| n.parse().ok());
    let n_scripts: usize = named.unwrap_or(N_SCRIPTS);
    let (mut n_made, mut n_refused, mut n_moved) = (0, 0, 0);
    for number in 0..n_scripts {
        let mut random = Pcg64::seed_from_u64(number as u64);
        let original = TEXTS[number % TEXTS.len()];
        let (mut session, mut state) = opened(original);
        for step in 0..N_EDITS {
            let asked = request(&mut random, &state.json);
            let script = format!("script {number}, step {step}: {asked}");
            let before = session.text().to_owned();
            let answer = ask(&mut session, &asked);
            if answer.json.get("fault").is_some() {
                n_refused += 1;
                assert_eq!(session.text(), before, "{script}");
                continue;
            }
            n_made += 1;
            if answer.json.get("text").is_some() {
                state = answer;
                let is_moved = random.random_range(0..6) == 0;
                n_moved += usize::from(is_moved);
                compare(&mut session, &state, is_moved, &script);
            }
        }
        for way in ["undo", "redo", "undo"] {
            while ask(&mut session, &json!({ "do": way })).json[format!("can_{way}")] == true {}
            assert!(way == "redo" || session.text() == original, "{way} of script {number}");
        }
    }
    eprintln!("{n_scripts} scripts: {n_made} changes, {n_refused} refused, {n_moved} motions");
    assert!(n_made > 3 * n_refused, "{n_made} of {}", n_made + n_refused);
}
