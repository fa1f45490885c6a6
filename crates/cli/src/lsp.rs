//! The language server `bksim lsp`: what editors ask about model files, over standard input and output.
//!
//! | file, each on those above it alone | holds |
//! |---|---|
//! | `transport.rs` | messages within bounds |
//! | `scan.rs` | headers, keys and values of a text that is being written |
//! | `document.rs` | a text with positions as editors count them, and whether it is a model |
//! | `faults.rs` | the model that a text is, or its faults, those of its start among them |
//! | `starts.rs` | starts that are looked for after a pause |
//! | `actions.rs` | cures of faults |
//! | `names.rs` | where a name is given and used; the outline |
//! | `hover.rs`, `inlays.rs`, `complete.rs`, `format.rs` | what a name is; values of expressions; what may stand at a place; a text in order |

mod actions;
mod complete;
mod document;
mod faults;
mod format;
mod hover;
mod inlays;
mod names;
mod starts;
mod transport;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bksim::translation::Language;
use crossbeam_channel::select;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use serde_json::{Value, json};

use self::document::Document;
use self::faults::{Shown, judge};
use self::starts::{Number, Started, Starts};
use crate::exit::{Failure, Status};
use bksim::translation::speak;

/// Serves one client until it says goodbye.
///
/// # Errors
/// Standard input or output that is closed early.
pub(crate) fn run(nesting: usize) -> Result<Status, Failure> {
    let (connection, threads) = transport::stdio();
    let served = serve(&connection, nesting);
    drop(connection);
    // What could not be read is why the connection has ended.
    if let Some(fault) = threads.unread() {
        return Err(broken(&fault));
    }
    served?;
    threads.join().map_err(|e| broken(&e))?;
    Ok(Status::Done)
}

/// A client that makes no sense.
fn broken(error: &dyn std::fmt::Display) -> Failure {
    let message = format!("the client cannot be understood: {error}");
    Failure::usage(message, "`bksim lsp` is started by editors")
}

/// Answers until the client says goodbye or is gone.
fn serve(connection: &Connection, nesting: usize) -> Result<(), Failure> {
    let abilities = json!({
        "textDocumentSync": 1,
        "hoverProvider": true,
        "definitionProvider": true,
        "referencesProvider": true,
        "documentHighlightProvider": true,
        "documentSymbolProvider": true,
        "codeActionProvider": { "codeActionKinds": ["quickfix"] },
        "inlayHintProvider": true,
        "renameProvider": true,
        "documentFormattingProvider": true,
        "completionProvider": { "triggerCharacters": [".", "\"", "[", "{", " "] },
    });
    let options = connection.initialize(abilities).map_err(|e| broken(&e))?;
    let pages = options["initializationOptions"]["pages"].as_str().map(str::to_owned);
    // An editor that states its language has the last word on it.
    if let Some(locale) = options["locale"].as_str() {
        speak(Language::of_locale(locale));
    }
    let mut server = Server { texts: BTreeMap::new(), starts: Starts::new(), nesting, pages };
    let send = |message: Message| connection.sender.send(message).map_err(|e| broken(&e));
    loop {
        let (timer, found) = (server.starts.timer(), server.starts.found.clone());
        select! {
            recv(connection.receiver) -> message => match message {
                Ok(Message::Request(request)) => {
                    if connection.handle_shutdown(&request).map_err(|e| broken(&e))? {
                        return Ok(());
                    }
                    send(Message::Response(server.answer(request)))?;
                }
                Ok(Message::Notification(notification)) => {
                    if let Some(faults) = server.take(&notification) {
                        send(Message::Notification(faults))?;
                    }
                }
                Ok(Message::Response(_)) => (),
                Err(_) => return Ok(()),
            },
            recv(found) -> started => {
                if let Some(faults) = started.ok().and_then(|started| server.started(started)) {
                    send(Message::Notification(faults))?;
                }
            }
            recv(timer) -> _ => server.begin(),
        }
    }
}

/// A text that is open, with the faults that the editor knows of.
struct Open {
    document: Document,
    /// Number of the text; that of a document that is closed is 0.
    number: Number,
    /// The version that the editor gave the text.
    version: Value,
    faults: Vec<Shown>,
}

/// The texts that are open.
struct Server {
    texts: BTreeMap<String, Open>,
    starts: Starts,
    nesting: usize,
    /// Address of the page of a code, with `{code}` in it.
    pages: Option<String>,
}

impl Server {
    /// Takes a new text and gives the faults in it.
    fn take(&mut self, notification: &Notification) -> Option<Notification> {
        let params = &notification.params;
        let uri = params["textDocument"]["uri"].as_str()?;
        let document = match notification.method.as_str() {
            "textDocument/didOpen" => {
                let opened = &params["textDocument"];
                let language = opened["languageId"].as_str().unwrap_or_default();
                Document::new(uri, language, opened["text"].as_str()?)
            }
            // The whole text, as was agreed.
            "textDocument/didChange" => {
                let text = params["contentChanges"].as_array()?.last()?["text"].as_str()?;
                self.texts.get(uri)?.document.with(text)
            }
            "textDocument/didClose" => {
                if let Some(open) = self.texts.remove(uri) {
                    open.number.store(0, Ordering::Relaxed);
                }
                return Some(published(uri, &Value::Null, &[]));
            }
            _ => return None,
        };
        let mut faults = Vec::new();
        if document.is_model() {
            let judged = judge(&document, self.nesting);
            faults = judged.shown(&document, self.pages.as_deref());
            if judged.model.is_some() {
                self.starts.ask(uri);
            }
        }
        let known = self.texts.remove(uri);
        let number = known.map_or_else(Number::default, |open| open.number);
        number.fetch_add(1, Ordering::Relaxed);
        let version = params["textDocument"]["version"].clone();
        let message = published(uri, &version, &faults);
        self.texts.insert(uri.to_owned(), Open { document, number, version, faults });
        Some(message)
    }

    /// Looks for the start that is due.
    fn begin(&mut self) {
        let Some(uri) = self.starts.next() else { return };
        let Some(open) = self.texts.get(&uri) else { return };
        let (document, number) = (open.document.clone(), Arc::clone(&open.number));
        self.starts.begin(uri, document, number, self.nesting, self.pages.clone());
    }

    /// Takes what was found about a start and gives all faults of its text.
    fn started(&mut self, started: Started) -> Option<Notification> {
        self.starts.end();
        let open = self.texts.get_mut(&started.uri)?;
        if open.number.load(Ordering::Relaxed) != started.number {
            return None;
        }
        open.faults = started.shown?;
        Some(published(&started.uri, &open.version, &open.faults))
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let uri = params["textDocument"]["uri"].as_str().unwrap_or_default();
        let Some(open) = self.texts.get(uri).filter(|open| open.document.is_model()) else {
            return Response::new_ok(id, Value::Null);
        };
        let document = &open.document;
        let byte = document.byte(&params["position"]);
        let range = || -> Range<usize> {
            document.byte(&params["range"]["start"])..document.byte(&params["range"]["end"])
        };
        let places = || -> Value {
            let found = names::references(document, byte);
            found.iter().map(|at| json!({ "uri": uri, "range": document.range(at) })).collect()
        };
        let result = match method.as_str() {
            "textDocument/hover" => hover::at(document, byte, self.nesting),
            "textDocument/definition" => names::definition(document, byte)
                .map(|range| json!({ "uri": uri, "range": document.range(&range) })),
            "textDocument/references" | "textDocument/documentHighlight" => Some(places()),
            "textDocument/documentSymbol" => Some(names::outline(document)),
            "textDocument/codeAction" => Some(actions::of(document, uri, &open.faults, &range())),
            "textDocument/inlayHint" => Some(inlays::of(document, &range(), self.nesting)),
            "textDocument/completion" => {
                let is_space = params["context"]["triggerCharacter"] == " ";
                Some(complete::at(document, byte, self.nesting, is_space))
            }
            "textDocument/formatting" => Some(format::edits(document)),
            "textDocument/rename" => {
                let new = params["newName"].as_str().unwrap_or_default();
                match names::rename(document, byte, new) {
                    Ok(edits) => Some(json!({ "changes": { uri: edits } })),
                    Err(fault) => {
                        let code = ErrorCode::InvalidParams as i32;
                        return Response::new_err(id, code, fault);
                    }
                }
            }
            other => {
                let code = ErrorCode::MethodNotFound as i32;
                return Response::new_err(id, code, format!("no method `{other}`"));
            }
        };
        Response::new_ok(id, result.unwrap_or(Value::Null))
    }
}

fn published(uri: &str, version: &Value, faults: &[Shown]) -> Notification {
    let faults: Vec<&Value> = faults.iter().map(|fault| &fault.json).collect();
    let mut params = json!({ "uri": uri, "diagnostics": faults });
    if !version.is_null() {
        params["version"] = version.clone();
    }
    Notification::new("textDocument/publishDiagnostics".to_owned(), params)
}
