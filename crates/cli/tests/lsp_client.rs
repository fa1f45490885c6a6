//! A client of the language server, over its standard input and output.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use crate::common::Scratch;
use serde_json::{Value, json};

/// A client with its server.
pub(crate) struct Client {
    server: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    pub(crate) uri: String,
    last_id: u64,
    version: u64,
}

impl Client {
    pub(crate) fn start(place: &Scratch) -> Self {
        Self::start_in(place, "en")
    }

    /// A client of an editor in a language.
    pub(crate) fn start_in(place: &Scratch, locale: &str) -> Self {
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
        let mut client = Self { server, input, output, uri, last_id: 0, version: 0 };
        let abilities = client.ask(
            "initialize",
            json!({ "capabilities": {}, "locale": locale, "initializationOptions": { "pages": "page:/{code}" } }),
        );
        let abilities = abilities["capabilities"].clone();
        for ability in
            ["hoverProvider", "definitionProvider", "renameProvider", "inlayHintProvider"]
        {
            assert_eq!(abilities[ability], true, "{ability}");
        }
        client.tell("initialized", json!({}));
        client
    }

    pub(crate) fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it listens");
        self.input.flush().expect("it listens");
    }

    #[expect(clippy::needless_pass_by_value, reason = "values of JSON are moved")]
    pub(crate) fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    pub(crate) fn read(&mut self) -> Value {
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
    pub(crate) fn response(&mut self, method: &str, params: Value) -> Value {
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

    pub(crate) fn ask(&mut self, method: &str, params: Value) -> Value {
        self.response(method, params)["result"].clone()
    }

    /// The faults of a text when it is read.
    pub(crate) fn open(&mut self, text: &str) -> Value {
        self.open_as("toml", text)
    }

    pub(crate) fn open_as(&mut self, language: &str, text: &str) -> Value {
        self.version += 1;
        let document = json!({ "uri": self.uri, "languageId": language, "version": self.version, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        self.published()
    }

    pub(crate) fn change(&mut self, text: &str) -> Value {
        self.version += 1;
        let change = json!({
            "textDocument": { "uri": self.uri, "version": self.version },
            "contentChanges": [{ "text": text }],
        });
        self.tell("textDocument/didChange", change);
        self.published()
    }

    /// The next faults of the last text; those of earlier texts may come before.
    pub(crate) fn published(&mut self) -> Value {
        loop {
            let message = self.read();
            if message["params"]["version"] == self.version {
                assert_eq!(message["method"], "textDocument/publishDiagnostics");
                return message["params"]["diagnostics"].clone();
            }
        }
    }

    /// A request about the place where `needle` begins, and so many letters on.
    pub(crate) fn at(&mut self, text: &str, needle: &str, more: usize) -> Value {
        let byte = text.find(needle).expect(needle);
        let line = text[..byte].matches('\n').count();
        let start = text[..byte].rfind('\n').map_or(0, |at| at + 1);
        let position = json!({ "line": line, "character": byte - start + more });
        json!({ "textDocument": { "uri": self.uri }, "position": position })
    }

    pub(crate) fn end(mut self) {
        self.ask("shutdown", Value::Null);
        self.tell("exit", Value::Null);
        assert!(self.server.wait().expect("it ends").success());
    }
}
