//! The language server, driven by a client over its standard input and output.

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use common::Scratch;
use serde_json::{Value, json};

/// A client with its server.
struct Client {
    server: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    uri: String,
    last_id: u64,
}

impl Client {
    fn start(place: &Scratch) -> Self {
        let mut command = place.bksim();
        let mut server = command
            .arg("lsp")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("bksim starts");
        let input = server.stdin.take().expect("it is piped");
        let output = BufReader::new(server.stdout.take().expect("it is piped"));
        let uri = format!("file://{}/arm.toml", place.path().display());
        let mut client = Self { server, input, output, uri, last_id: 0 };
        let abilities =
            client.ask("initialize", json!({ "capabilities": {} }))["capabilities"].clone();
        for ability in ["hoverProvider", "definitionProvider", "renameProvider"] {
            assert_eq!(abilities[ability], true, "{ability}");
        }
        client.tell("initialized", json!({}));
        client
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it listens");
        self.input.flush().expect("it listens");
    }

    #[expect(clippy::needless_pass_by_value, reason = "values of JSON are moved")]
    fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    fn read(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            self.output.read_line(&mut line).expect("it speaks");
            if let Some(number) = line.strip_prefix("Content-Length: ") {
                length = number.trim().parse().expect("a length");
            }
            if line.trim().is_empty() {
                break;
            }
        }
        let mut text = vec![0; length];
        self.output.read_exact(&mut text).expect("a message");
        serde_json::from_slice(&text).expect("JSON")
    }

    /// The whole answer to a request.
    #[expect(clippy::needless_pass_by_value, reason = "values of JSON are moved")]
    fn response(&mut self, method: &str, params: Value) -> Value {
        self.last_id += 1;
        let id = self.last_id;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.read();
            if message["id"] == id {
                return message;
            }
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.response(method, params)["result"].clone()
    }

    /// The faults of a text.
    fn open(&mut self, text: &str) -> Value {
        let document = json!({ "uri": self.uri, "languageId": "toml", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        let published = self.read();
        assert_eq!(published["method"], "textDocument/publishDiagnostics");
        published["params"]["diagnostics"].clone()
    }

    /// A request about the place where `needle` begins, and so many letters on.
    fn at(&mut self, text: &str, needle: &str, more: usize) -> Value {
        let byte = text.find(needle).expect(needle);
        let line = text[..byte].matches('\n').count();
        let start = text[..byte].rfind('\n').map_or(0, |at| at + 1);
        let position = json!({ "line": line, "character": byte - start + more });
        json!({ "textDocument": { "uri": self.uri }, "position": position })
    }

    fn end(mut self) {
        self.ask("shutdown", Value::Null);
        self.tell("exit", Value::Null);
        assert!(self.server.wait().expect("it ends").success());
    }
}

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
    let change = json!({
        "textDocument": { "uri": client.uri, "version": 2 },
        "contentChanges": [{ "text": wrong }],
    });
    client.tell("textDocument/didChange", change);
    let faults = client.read()["params"]["diagnostics"].clone();
    let line = wrong.lines().position(|line| line.contains("revolut")).expect("the line");
    assert_eq!(faults[0]["range"]["start"]["line"], line);
    assert_eq!(faults[0]["severity"], 1);
    let message = faults[0]["message"].as_str().expect("a message");
    assert!(message.contains("did you mean `revolute`?"), "{message}");
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
    assert!(has(&keys, "vector") && !has(&keys, "stiffness"), "of the type: {keys:?}");
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

    let messy = ARM.replace("mass = ", "mass=").replace("\n[joints", "\n\n\n[joints");
    client.open(&messy);
    let params = json!({ "textDocument": { "uri": client.uri }, "options": {} });
    let edits = client.ask("textDocument/formatting", params);
    assert_eq!(edits[0]["newText"], ARM);
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
        let said = common::text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("the client cannot be understood") && said.contains(word), "{said}");
    }
}
