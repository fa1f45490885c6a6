//! The language server, driven by a client over its standard input and output.

use std::io::Write;
use std::process::Stdio;

use crate::common::Scratch;
use crate::lsp_client::Client;
use serde_json::{Value, json};

const ARM: &str = r#"[parameters]
l1 = "250 mm"
k = "2*l1" # not l1

[bodies.arm]
mass = "1 kg"
inertia = "0.1 kg m^2"
com = ["l1/2", 0]
points = { A = [0, 0], tip = ["l1", 0] }

[joints.pivot]
type = "revolute"
between = ["ground", "arm.A"]
coordinate = "phi"

[clocks.tick]
every = "1 ms"

[signals.held]
value = "2*(phi_dot)"
clock = "tick"

[loads.pull]
type = "force"
on = "arm.tip"
vector = ["-3 N/m*(arm.tip.x - l1)", 0]

[outputs]
force = "reactions.pivot.fx"
"#;

#[test]
fn faults_stand_in_their_places_while_a_text_is_written() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    assert_eq!(client.open(ARM), json!([]));
    let wrong = ARM.replace("type = \"revolute\"", "type = \"revolut\"");
    let faults = client.change(&wrong);
    let line = wrong.lines().position(|line| line.contains("revolut")).expect("the line");
    assert_eq!(faults[0]["range"]["start"]["line"], line);
    assert_eq!(faults[0]["severity"], 1);
    let message = faults[0]["message"].as_str().expect("a message");
    assert!(message.contains("did you mean `revolute`?"), "{message}");
    client.end();
}

#[test]
fn faults_have_words_in_the_language_of_the_editor() {
    let place = Scratch::new();
    let mut client = Client::start_in(&place, "vi-VN");
    client.open(ARM);
    let faults = client.change(&ARM.replace("type = \"revolute\"", "type = \"revolut\""));
    let message = faults[0]["message"].as_str().expect("a message");
    assert!(
        message.contains("ý bạn là `revolute`?") && message.contains("không thuộc các lựa chọn"),
        "{message}"
    );
    client.end();
}

#[test]
fn names_have_values_meanings_and_equations() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    client.open(ARM);
    let mut hover = |needle: &str, more: usize| {
        let params = client.at(ARM, needle, more);
        let found = client.ask("textDocument/hover", params);
        found["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    assert_eq!(hover("l1/2", 1), "`l1` = 0.25 m, length in m");
    assert_eq!(hover("k =", 0), "`k` = 0.5 m, length in m");
    assert_eq!(hover("arm.tip.x", 8), "`arm.tip.x`, length in m");
    let joint = hover("pivot]", 1);
    assert!(joint.starts_with("joint `pivot`") && joint.contains("= 0"), "{joint}");
    // The moment of inertia about the pin: 0.1 + 1·0.125², of l1 as a symbol.
    let body = hover("arm.A", 1);
    assert!(body.starts_with("body `arm`") && body.contains("phi_ddot"), "{body}");
    assert_eq!(hover("phi_dot)", 1), "rate of coordinate `phi` of joint `pivot`, in rad/s");
    assert_eq!(hover("reactions.pivot.fx", 17), "`reactions.pivot.fx`, force in N");
    let key = hover("between", 2);
    assert!(key.starts_with("`between`: "), "{key}");
    client.end();
}

#[test]
fn a_name_is_found_completed_and_renamed() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    client.open(ARM);
    let line_of = |needle: &str| ARM.lines().position(|line| line.contains(needle)).expect(needle);
    for (needle, more, defined) in
        [("l1/2", 0, "l1 = "), ("arm.A", 1, "[bodies.arm]"), ("arm.tip.x", 5, "points =")]
    {
        let params = client.at(ARM, needle, more);
        let found = client.ask("textDocument/definition", params);
        assert_eq!(found["range"]["start"]["line"], line_of(defined), "{needle}: {found}");
    }

    let mut labels = |text: &str, needle: &str, more: usize| -> Vec<String> {
        let params = client.at(text, needle, more);
        let found = client.ask("textDocument/completion", params);
        let items = found.as_array().expect("items").iter();
        items.map(|item| item["label"].as_str().expect("a label").to_owned()).collect()
    };
    let has = |labels: &[String], label: &str| labels.iter().any(|known| known == label);
    let types = labels(ARM, "\"revolute\"", 1);
    assert!(has(&types, "prismatic") && has(&types, "cylinder"), "{types:?}");
    let keys = labels(ARM, "on = \"arm", 0);
    assert!(has(&keys, "axes") && !has(&keys, "stiffness"), "of the type: {keys:?}");
    assert!(has(&keys, "on") && !has(&keys, "vector"), "the others are there: {keys:?}");
    let names = labels(ARM, "l1/2", 0);
    assert!(has(&names, "k") && has(&names, "hypot") && has(&names, "t"), "{names:?}");
    let parts = labels(ARM, "arm.tip.x", 4);
    assert!(has(&parts, "tip") && has(&parts, "vx"), "{parts:?}");
    let names = labels(ARM, "reactions.pivot", 0);
    assert!(has(&names, "phi") && has(&names, "phi_dot") && has(&names, "reactions"), "{names:?}");
    assert_eq!(labels(ARM, "reactions.pivot", 10), ["pivot"]);
    let components = labels(ARM, "reactions.pivot.fx", 16);
    assert!(has(&components, "mz") && has(&components, "fx_joint"), "{components:?}");
    assert_eq!(labels(ARM, "\"tick\"", 1), ["tick"]);

    // Also while another line is faulty that no other follows from.
    let faulty = ARM.replace("\"tick\"", "\"tock\"").replace("arm.tip.x -", "arm. -");
    client.open(&faulty);
    let params = client.at(&faulty, "arm. -", 4);
    let parts = client.ask("textDocument/completion", params).to_string();
    assert!(parts.contains("\"tip\""), "{parts}");
    client.open(ARM);

    // A coordinate: where it is named, in the signal, and with its rate.
    let mut params = client.at(ARM, "phi_dot", 1);
    params["newName"] = "theta".into();
    let edits = client.ask("textDocument/rename", params);
    assert_eq!(edits["changes"][&client.uri].as_array().map(Vec::len), Some(2), "{edits}");

    let mut params = client.at(ARM, "l1/2", 0);
    params["newName"] = "length_1".into();
    let edits = client.ask("textDocument/rename", params);
    let edits = edits["changes"][&client.uri].as_array().expect("edits").clone();
    // In the parameters, the centre of mass, the point and the load; not in the comment.
    assert_eq!(edits.len(), 5, "{edits:?}");
    let mut lines: Vec<String> = ARM.lines().map(str::to_owned).collect();
    for edit in edits.iter().rev() {
        let number = |end: &str, key: &str| {
            usize::try_from(edit["range"][end][key].as_u64().expect(key)).expect("small")
        };
        let line = &mut lines[number("start", "line")];
        line.replace_range(number("start", "character")..number("end", "character"), "length_1");
    }
    let renamed = lines.join("\n") + "\n";
    assert!(renamed.contains("# not l1") && renamed.matches("length_1").count() == 5, "{renamed}");
    assert_eq!(client.open(&renamed), json!([]));
    let mut params = client.at(&renamed, "length_1/2", 0);
    params["newName"] = "k".into();
    let taken = client.response("textDocument/rename", params);
    assert!(taken["error"]["message"].as_str().expect("a fault").contains("already taken"));

    // In load cases and ranges, and of a joint whose reaction an output is.
    let ranged = format!("{ARM}\n[ranges]\nl1 = [\"0.1 m\", \"1 m\"]\npivot.angle = [-1, 1]\n");
    client.open(&ranged);
    for (at, n) in [("l1/2", 6), ("pivot.fx", 3)] {
        let mut params = client.at(&ranged, at, 0);
        params["newName"] = "other".into();
        let edits = client.ask("textDocument/rename", params);
        let edits = edits["changes"][&client.uri].as_array().map(Vec::len);
        assert_eq!(edits, Some(n), "{at}");
    }

    let messy = ARM.replace("mass = ", "mass=").replace("\n[joints", "\n\n\n[joints");
    client.open(&messy);
    let params = json!({ "textDocument": { "uri": client.uri }, "options": {} });
    let edits = client.ask("textDocument/formatting", params);
    assert_eq!(edits[0]["newText"], ARM);
    client.end();
}

/// A four-bar whose stated positions exclude each other.
const SLIDER: &str = r#"[bodies.crank]
mass = "1 kg"
inertia = "0.1 kg m^2"
points = { A = [0, 0], B = ["1 m", 0] }

[bodies.rod]
mass = "1 kg"
inertia = "0.1 kg m^2"
points = { B = [0, 0], C = ["3 m", 0] }

[bodies.slider]
mass = "1 kg"
inertia = "0.1 kg m^2"

[joints.A]
type = "revolute"
between = ["ground", "crank.A"]

[joints.B]
type = "revolute"
between = ["crank.B", "rod.B"]

[joints.C]
type = "revolute"
between = ["rod.C", "slider"]

[joints.D]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]

[initial]
A = { angle = 0 }
D = { position = "9 m" }
"#;

#[test]
fn faults_of_starts_come_after_a_pause() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    assert_eq!(client.open(SLIDER), json!([]), "it can be read");
    let faults = client.published();
    assert_eq!(faults[0]["code"], "S002", "{faults}");
    assert_eq!(faults[0]["codeDescription"]["href"], "page:/S002");
    let range =
        json!({ "start": { "line": 33, "character": 18 }, "end": { "line": 33, "character": 21 } });
    assert_eq!(faults[0]["range"], range);
    // The first quick fix makes it a guess, of which a warning says how far off it was.
    let fixed = client.fixed(SLIDER, &faults[0], 0);
    assert!(fixed.contains("D = { guess = { position = \"9 m\" } }"), "{fixed}");
    assert_eq!(client.change(&fixed), json!([]));
    assert_eq!(client.published()[0]["code"], "S014");
    let removed = client.fixed(&fixed, &faults[0], 0);
    assert_eq!(removed, fixed, "faults of an earlier text have no fixes");
    // Only the last of several texts counts.
    client.change(SLIDER);
    client.change(&SLIDER.replace("\"9 m\"", "\"4 m\""));
    assert_eq!(client.published(), json!([]));
    client.end();
}

impl Client {
    /// The text after a quick fix of a fault; the same where there is none.
    fn fixed(&mut self, text: &str, fault: &Value, number: usize) -> String {
        let params = json!({
            "textDocument": { "uri": self.uri },
            "range": fault["range"],
            "context": { "diagnostics": [fault] },
        });
        let actions = self.ask("textDocument/codeAction", params);
        let all = actions.as_array().expect("actions").iter();
        let mut of = all.filter(|action| action["diagnostics"][0]["code"] == fault["code"]);
        let Some(action) = of.nth(number) else { return text.to_owned() };
        assert_eq!(action["kind"], "quickfix");
        let edit = &action["edit"]["changes"][&self.uri][0];
        let byte = |end: &str| {
            let number = |key: &str| {
                usize::try_from(edit["range"][end][key].as_u64().expect(key)).expect("small")
            };
            let lines = text.split_inclusive('\n').take(number("line")).map(str::len);
            lines.sum::<usize>() + number("character")
        };
        let new = edit["newText"].as_str().expect("a text");
        format!("{}{new}{}", &text[..byte("start")], &text[byte("end")..])
    }

    /// Completions at the bar of a text.
    fn complete(&mut self, text: &str, trigger: Option<&str>) -> Vec<String> {
        let byte = text.find('|').expect("a bar");
        let text = text.replacen('|', "", 1);
        self.open(&text);
        let line = text[..byte].matches('\n').count();
        let start = text[..byte].rfind('\n').map_or(0, |at| at + 1);
        let mut params = json!({
            "textDocument": { "uri": self.uri },
            "position": { "line": line, "character": byte - start },
        });
        if let Some(trigger) = trigger {
            params["context"] = json!({ "triggerKind": 2, "triggerCharacter": trigger });
        }
        let found = self.ask("textDocument/completion", params);
        let items = found.as_array().expect("items").iter();
        items.map(|item| item["label"].as_str().expect("a label").to_owned()).collect()
    }
}

#[test]
fn quick_fixes_follow_helps() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    for (right, wrong) in [
        ("type = \"revolute\"", "type = \"revolut\""),
        ("\"l1/2\", 0]", "\"L1/2\", 0]"),
        ("\"arm.A\"]", "\"arm.AA\"]"),
        ("mass = \"1 kg\"", "mass = \"1 kgg\""),
        ("clock = \"tick\"", "clok = \"tick\""),
    ] {
        let text = ARM.replace(right, wrong);
        let faults = client.open(&text);
        let fixed = client.fixed(&text, &faults[0], 0);
        assert_eq!(fixed, ARM, "{faults}");
    }
    client.end();
}

#[test]
fn files_that_are_no_models_are_left_alone() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    let manifest = "[package]\nname = \"arm\"\n\n[dependencies]\nserde=\"1\"\n";
    assert_eq!(client.open(manifest), json!([]));
    for method in ["hover", "completion", "formatting", "documentSymbol", "codeAction"] {
        let params = client.at(manifest, "name", 2);
        assert_eq!(client.ask(&format!("textDocument/{method}"), params), Value::Null, "{method}");
    }
    // As a model it has faults.
    assert_ne!(client.open_as("bksim", manifest), json!([]));
    // Positions alone need no masses.
    let linkage = SLIDER.replace("mass = \"1 kg\"\ninertia = \"0.1 kg m^2\"\n", "");
    let faults = client.open(&linkage);
    assert_eq!(faults.as_array().map(Vec::len), Some(1), "{faults}");
    assert_eq!((&faults[0]["code"], &faults[0]["severity"]), (&json!("S030"), &json!(2)));
    assert_eq!(client.published()[1]["code"], "S002");
    client.end();
}

#[test]
fn completions_follow_the_place() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    let (space, none) = (Some(" "), None);
    for (line, trigger, expected) in [
        ("[joints.E]\nbetween = [\"ground\", \"crank.|\"]", none, "A B"),
        ("[loads.f]\ntype = \"force\"\non = \"rod.|\"", none, "B C"),
        ("[couplings.g]\ntype = \"gear\"\nbetween = [\"|\"]", none, "A B C D"),
        ("[bodies.x]\ninertia = { value = 1, |", space, "about as_stated"),
        ("[bodies.x]\ninertia = { value = 1, about = \"|\" }\npoints = { P = [0, 0] }", none, "P"),
        ("[initial]\nB = { |", space, "angle rate guess"),
        ("[initial]\nB = { guess = { angle = \"3 |\" } }", space, "deg rad rev"),
        ("[bodies.x]\nmass = \"1 |", space, "kg g t lb"),
        ("[bodies.x]\npoints = { P = [0, \"1.5 |\"] }", space, "mm m cm in ft"),
        ("[loads.s]\ntype = \"torsion\"\nstiffness = \"100 N|", none, "N m/rad N m/deg N mm/rad"),
        ("[solve]\nmethod = \"|\"", none, "auto radau explicit"),
        ("[solve]\nrtol = |", space, ""),
        ("[parameters]\n# in l = \"1 |", space, ""),
        ("[parameters]\nl2 = \"2*l|\"\nl = 1", space, ""),
    ] {
        let found = client.complete(&format!("{SLIDER}{line}\n"), trigger);
        assert_eq!(found.join(" "), expected, "{line}");
    }
    // Every key that is offered in a table within another is one that the reader knows.
    for line in [
        "[bodies.x]\nmass = 1\npoints = { P = { |",
        "[bodies.x]\ninertia = { |",
        "[bodies.x]\nshapes = [{ |",
        "[curves.c]\ntype = \"cam\"\nfollower = { |",
        "[curves.c]\ntype = \"cam-law\"\nsegments = [{ |",
        "[initial]\ncrank = { |",
        "[initial]\ncrank = { guess = { |",
        "[initial]\nA = { |",
        "[initial]\nD = { guess = { |",
    ] {
        for key in client.complete(&format!("{SLIDER}{line}"), none) {
            let closing = if line.contains("[{") { " = 1 }]" } else { " = 1 }" };
            let closing = if line.contains("guess") || line.contains("points") {
                format!("{closing} }}")
            } else {
                closing.to_owned()
            };
            let start = SLIDER.split("[initial]").next().expect("a start");
            let faults = client.open(&format!("{start}{}{key}{closing}\n", line.replace('|', "")));
            let faults = faults.to_string();
            assert!(
                !faults.contains("\"M005\"") && !faults.contains("\"M001\""),
                "{line}{key}: {faults}"
            );
        }
    }
    client.end();
}

#[test]
fn outline_references_and_values_of_a_text() {
    let place = Scratch::new();
    let mut client = Client::start(&place);
    client.open(ARM);
    let document = json!({ "textDocument": { "uri": client.uri } });
    let outline = client.ask("textDocument/documentSymbol", document);
    let names: Vec<&str> =
        outline.as_array().expect("symbols").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(names, ["parameters", "arm", "pivot", "tick", "held", "pull", "outputs"]);
    assert_eq!(outline[2]["detail"], "joints revolute");
    assert_eq!(outline[1]["children"][1]["name"], "tip");

    for (needle, more, n) in [
        ("l1 = ", 0, 5),
        ("arm.tip\"", 5, 3),
        ("[joints.pivot", 9, 2),
        ("reactions.pivot", 12, 2),
        ("phi_dot", 1, 2),
        ("tick]", 1, 2),
    ] {
        let params = client.at(ARM, needle, more);
        let found = client.ask("textDocument/references", params);
        assert_eq!(found.as_array().map(Vec::len), Some(n), "{needle}: {found}");
    }

    let range =
        json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let params = json!({ "textDocument": { "uri": client.uri }, "range": range });
    let hints = client.ask("textDocument/inlayHint", params);
    let hints: Vec<(u64, &str)> = hints
        .as_array()
        .expect("hints")
        .iter()
        .filter_map(|hint| Some((hint["position"]["line"].as_u64()?, hint["label"].as_str()?)))
        .collect();
    // Of the signal and the load, which follow the motion, there are none.
    assert_eq!(hints, [(2, "= 0.5 m"), (7, "= 0.125 m"), (8, "= 0.25 m")]);
    client.end();
}

#[test]
fn a_client_that_makes_no_sense_is_told_so() {
    for (input, word) in [
        (
            "Content-Length: 99999999999999\r\n\r\n",
            "a message of 99999999999999 bytes is announced",
        ),
        ("hello\r\n\r\n", "a header without `:`"),
        ("Content-Length: 2\r\n\r\n{}", "no message"),
    ] {
        let place = Scratch::new();
        let mut command = place.bksim();
        command.arg("lsp").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut server = command.spawn().expect("bksim starts");
        let mut input_end = server.stdin.take().expect("it is piped");
        input_end.write_all(input.as_bytes()).expect("it listens");
        // The client stays there: it ends by itself.
        let output = server.wait_with_output().expect("an end");
        drop(input_end);
        let said = crate::common::text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("the client cannot be understood") && said.contains(word), "{said}");
    }
}
