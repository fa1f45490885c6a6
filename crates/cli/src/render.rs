//! Diagnostics for people (an excerpt with carets) and for programs (JSON).

use std::io::Write;

use annotate_snippets::{Group, Level, Renderer};
use anstream::adapter::strip_str;
use bksim::model::diagnostic::Diagnostic;
use bksim_load::{Text, WIDTH, styled, titled};
pub use bksim_load::{json_all, plain as plain_text};
use serde_json::{Value, json};

use crate::exit::Failure;
use crate::output;
use crate::quiet::is_quiet;
use crate::visible::{Styles, visible};

/// Prints diagnostics to stderr.
pub fn print_all(source: &Text, faults: &[Diagnostic]) {
    for fault in faults.iter().filter(|fault| fault.is_error() || !is_quiet()) {
        to_stderr(&styled(source, fault));
    }
}

/// A warning about a file that is no model, on stderr.
pub fn warning(message: &str) {
    if is_quiet() {
        return;
    }
    let group = Group::with_title(Level::WARNING.primary_title(message));
    to_stderr(&Renderer::styled().term_width(WIDTH).render(&[group]));
}

/// A failure as text without styles.
pub fn failure_text(failure: &Failure) -> String {
    let about = |path: &std::path::Path, what: &str| format!("`{}` {what}", path.display());
    let unstyled =
        |message: &str, help: Option<&str>| strip_str(&titled(message, help)).to_string();
    match failure {
        Failure::OutputClosed => String::new(),
        Failure::Model { source, diagnostics } => {
            let texts = diagnostics.iter().map(|fault| plain_text(source, fault));
            texts.collect::<Vec<_>>().join("\n\n")
        }
        Failure::File { path, what, help } | Failure::Input { path, what, help } => {
            unstyled(&about(path, what), help.as_deref())
        }
        Failure::Usage { message, help } => unstyled(message, help.as_deref()),
        Failure::Unavailable { message, help } => unstyled(message, Some(help)),
    }
}

/// A failed command: text on stderr, or one JSON object on stdout.
pub(crate) fn failure(failure: &Failure, command: &str, as_json: bool) {
    let body = match failure {
        Failure::OutputClosed => return,
        Failure::Model { source, diagnostics } => {
            if !as_json {
                print_all(source, diagnostics);
                return;
            }
            json!({ "diagnostics": json_all(source, diagnostics) })
        }
        Failure::File { path, what, help } | Failure::Input { path, what, help } => {
            let message = format!("`{}` {what}", path.display());
            if !as_json {
                untitled(&message, help.as_deref());
                return;
            }
            json!({ "file": path.display().to_string(), "message": message, "help": help })
        }
        Failure::Usage { message, help } => {
            if !as_json {
                untitled(message, help.as_deref());
                return;
            }
            json!({ "message": message, "help": help })
        }
        Failure::Unavailable { message, help } => {
            if !as_json {
                untitled(message, Some(help));
                return;
            }
            json!({ "message": message, "help": help })
        }
    };
    let mut object = json!({
        "ok": false, "command": command, "exit_status": failure.status().code(),
    });
    if let (Some(object), Value::Object(body)) = (object.as_object_mut(), body) {
        object.extend(body);
    }
    // The exit status tells as much when nobody reads the object; where it cannot be written, people are told.
    if let Err(unwritten @ Failure::File { .. }) = output::object_text(&object) {
        to_stderr(&failure_text(&unwritten));
    }
}

fn untitled(message: &str, help: Option<&str>) {
    to_stderr(&titled(message, help));
}

/// Prints a line of a command that goes on to stderr.
pub fn line(text: &str) {
    to_stderr(text);
}

/// Prints a line to stderr. Where that cannot be written there is nobody left to tell.
fn to_stderr(text: &str) {
    let _ = writeln!(anstream::stderr().lock(), "{}", visible(text, Styles::Kept));
}
