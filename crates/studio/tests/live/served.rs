//! `bksim edit`: what the browser of this computer may ask for, and that nobody else may ask for anything.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

use crate::common::{Scratch, text};

const MODEL: &str = "# a comment\n[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n";

/// A server, which ends with the test.
struct Served {
    child: Child,
    host: String,
    token: String,
    place: Scratch,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Served {
    fn open() -> Self {
        let place = Scratch::new();
        place.write("model.toml", MODEL);
        place.write("module.wasm", b"\0asm\x01\0\0\0");
        let mut command = place.bksim();
        command.args(["edit", "model.toml"]).env("BKSIM_LIVE", place.path().join("module.wasm"));
        let mut child = command.stdout(Stdio::piped()).spawn().expect("bksim starts");
        let stdout = child.stdout.take().expect("a pipe");
        let mut line = String::new();
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        let url = line.split_whitespace().find(|word| word.starts_with("http://"));
        let url = url.unwrap_or_else(|| panic!("no address in {line:?}"));
        let (host, token) =
            url["http://".len()..].trim_end_matches('/').split_once('/').expect("a token");
        Self { host: host.to_owned(), token: token.to_owned(), child, place }
    }

    /// Status and body of the answer to a request with these headers, the host's own unless given.
    fn ask(&self, method: &str, path: &str, headers: &[&str], body: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.host).expect("a server");
        let has_host = headers.iter().any(|header| header.starts_with("Host:"));
        let host = if has_host { String::new() } else { format!("Host: {}\r\n", self.host) };
        let more: String = headers.iter().flat_map(|header| [*header, "\r\n"]).collect();
        let request = format!(
            "{method} {path} HTTP/1.1\r\n{host}{more}Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        );
        stream.write_all(request.as_bytes()).expect("a request");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let answer = text(&answer);
        let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, answer)
    }

    fn path(&self, name: &str) -> String {
        format!("/{}/{name}", self.token)
    }

    fn put(&self, before: &str, text: &str) -> (u16, String) {
        let body = serde_json::json!({ "before": before, "text": text }).to_string();
        let origin = format!("Origin: http://{}", self.host);
        self.ask("PUT", &self.path("file"), &[&origin], &body)
    }

    fn file(&self) -> String {
        fs::read_to_string(self.place.path().join("model.toml")).expect("the model")
    }
}

#[test]
fn the_page_is_served_to_its_own_address_and_to_no_other() {
    if !bksim_page::IS_BUNDLED {
        return;
    }
    let served = Served::open();
    assert!(served.host.starts_with("127.0.0.1:"), "{}", served.host);
    assert_eq!(served.token.len(), 32);
    let (status, page) = served.ask("GET", &served.path(""), &[], "");
    assert_eq!(status, 200, "{page}");
    assert!(page.contains("id=\"module\"") && page.contains("connect-src 'self'"));
    assert!(page.contains("Cross-Origin-Resource-Policy: same-origin"));
    let (status, answer) = served.ask("GET", &served.path("file"), &[], "");
    assert!(status == 200 && answer.ends_with(MODEL), "{answer}");

    let own = format!("Origin: http://{}", served.host);
    let file = served.path("file");
    let cases: [(&str, &str, &[&str], u16); 14] = [
        ("GET", "/", &[], 404),
        ("GET", "/0123456789abcdef0123456789abcdef/file", &[], 404),
        ("GET", &served.path("../../etc/passwd"), &[], 404),
        ("GET", &served.path("model.toml"), &[], 404),
        ("GET", &file, &["Host: evil.example"], 403),
        ("GET", &file, &["Host: localhost"], 403),
        ("GET", &file, &["Origin: https://evil.example"], 403),
        ("GET", &file, &["Origin: null"], 403),
        ("GET", &file, &["Sec-Fetch-Site: cross-site"], 403),
        ("PUT", &file, &[], 403),
        ("POST", &file, &[own.as_str()], 405),
        ("DELETE", &file, &[own.as_str()], 405),
        ("PUT", &file, &[own.as_str()], 400),
        ("PUT", "/model.toml", &[own.as_str()], 404),
    ];
    for (method, path, headers, expected) in cases {
        let (status, answer) = served.ask(method, path, headers, "");
        assert_eq!(status, expected, "{method} {path} {headers:?}: {answer}");
    }
    assert_eq!(served.file(), MODEL);
}

#[test]
fn two_editors_of_one_file_lose_nothing() {
    if !bksim_page::IS_BUNDLED {
        return;
    }
    let served = Served::open();
    let heavier = MODEL.replace("mass = 1", "mass = 2");
    assert_eq!(served.put(MODEL, &heavier).0, 200);
    assert_eq!(served.file(), heavier);
    // Another program writes; the page still has the text before.
    let other = format!("{heavier}# by hand\n");
    served.place.write("model.toml", &other);
    let (status, answer) = served.put(&heavier, MODEL);
    assert!(status == 409 && answer.contains("another program"), "{answer}");
    assert_eq!(served.file(), other);
    assert_eq!(served.put(&other, MODEL).0, 200);
    assert_eq!(served.file(), MODEL);
}

#[test]
fn edits_from_the_command_line_change_what_they_are_about_or_nothing() {
    let place = Scratch::new();
    place.write("model.toml", MODEL);
    let apply = |edits: &[&str]| {
        let mut command = place.bksim();
        command.args(["edit", "model.toml"]);
        for edit in edits {
            command.args(["--apply", edit]);
        }
        command.output().expect("bksim starts")
    };
    let rename = r#"{"edit": "rename", "name": "b", "to": "block"}"#;
    let set = r#"{"edit": "set", "path": "bodies.block.mass", "value": "3 kg"}"#;
    let output = apply(&[rename, set]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let written = fs::read_to_string(place.path().join("model.toml")).expect("the model");
    let expected = MODEL.replace("bodies.b]", "bodies.block]").replace("\"b\"", "\"block\"");
    assert_eq!(written, expected.replace("mass = 1", "mass = \"3 kg\""));
    // One that cannot be made leaves the file as it is, with those before it.
    for (edits, status, words) in [
        (&[set, r#"{"edit": "delete", "name": "rod"}"#][..], 1, "W002"),
        (&[r#"{"edit": "paint"}"#], 2, "takes an edit as JSON"),
    ] {
        let output = apply(edits);
        assert_eq!(output.status.code(), Some(status), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
        assert_eq!(fs::read_to_string(place.path().join("model.toml")).expect("it"), written);
    }
}

#[test]
fn without_the_module_a_live_page_says_how_to_have_it() {
    let place = Scratch::new();
    place.write("model.toml", MODEL);
    let mut command = place.bksim();
    command
        .args(["page", "model.toml", "--live"])
        .env("BKSIM_LIVE", place.path().join("none.wasm"));
    let output = command.output().expect("bksim starts");
    assert_eq!(output.status.code(), Some(if bksim_page::IS_BUNDLED { 4 } else { 2 }));
    assert!(!place.path().join("model.html").exists());
}
