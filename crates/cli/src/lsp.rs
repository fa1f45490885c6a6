//! The language server `bksim lsp`: what editors ask about model files, over standard input and output.
//!
//! | file, each on those above it alone | holds |
//! |---|---|
//! | `transport.rs` | messages within bounds |
//! | `document.rs` | a text with positions as editors count them, and what stands at one |
//! | `faults.rs` | the model that a text is, or its faults |
//! | `names.rs` | where a name is defined and used |
//! | `hover.rs`, `complete.rs`, `format.rs` | what a name is; what may stand at a place; a text in order |

mod complete;
mod document;
mod faults;
mod format;
mod hover;
mod names;
mod transport;

use std::collections::BTreeMap;

use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use serde_json::{Value, json};

use self::document::Document;
use crate::exit::{Failure, Status};

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
        "renameProvider": true,
        "documentFormattingProvider": true,
        "completionProvider": { "triggerCharacters": [".", "\"", "["] },
    });
    connection.initialize(abilities).map_err(|e| broken(&e))?;
    let mut server = Server { documents: BTreeMap::new(), nesting };
    for message in &connection.receiver {
        match message {
            Message::Request(request) => {
                if connection.handle_shutdown(&request).map_err(|e| broken(&e))? {
                    break;
                }
                let answer = Message::Response(server.answer(request));
                connection.sender.send(answer).map_err(|e| broken(&e))?;
            }
            Message::Notification(notification) => {
                if let Some(faults) = server.take(&notification) {
                    connection
                        .sender
                        .send(Message::Notification(faults))
                        .map_err(|e| broken(&e))?;
                }
            }
            Message::Response(_) => (),
        }
    }
    Ok(())
}

/// The texts that are open.
struct Server {
    documents: BTreeMap<String, Document>,
    nesting: usize,
}

impl Server {
    /// Takes a new text and gives the faults in it.
    fn take(&mut self, notification: &Notification) -> Option<Notification> {
        let params = &notification.params;
        let uri = params["textDocument"]["uri"].as_str()?;
        let text = match notification.method.as_str() {
            "textDocument/didOpen" => params["textDocument"]["text"].as_str()?,
            // The whole text, as was agreed.
            "textDocument/didChange" => {
                params["contentChanges"].as_array()?.last()?["text"].as_str()?
            }
            "textDocument/didClose" => {
                self.documents.remove(uri);
                return Some(published(uri, json!([])));
            }
            _ => return None,
        };
        let document = Document::new(uri, text);
        let faults = faults::of(&document, self.nesting);
        self.documents.insert(uri.to_owned(), document);
        Some(published(uri, faults))
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let uri = params["textDocument"]["uri"].as_str().unwrap_or_default();
        let Some(document) = self.documents.get(uri) else {
            return Response::new_ok(id, Value::Null);
        };
        let byte = document.byte(&params["position"]);
        let result = match method.as_str() {
            "textDocument/hover" => hover::at(document, byte, self.nesting),
            "textDocument/definition" => names::definition(document, byte)
                .map(|range| json!({ "uri": uri, "range": document.range(&range) })),
            "textDocument/completion" => Some(complete::at(document, byte, self.nesting)),
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

#[expect(clippy::needless_pass_by_value, reason = "values of JSON are moved")]
fn published(uri: &str, faults: Value) -> Notification {
    let params = json!({ "uri": uri, "diagnostics": faults });
    Notification::new("textDocument/publishDiagnostics".to_owned(), params)
}
