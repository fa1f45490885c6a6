//! [`Server`]: one page and one file for the browser of this computer, and nothing for anyone else.
//!
//! ```text
//! GET /TOKEN/        the page          PUT /TOKEN/file   {"before": "…", "text": "…"}: written if the file still
//! GET /TOKEN/file    the text                            holds `before`, else 409
//! ```
//!
//! It listens on the loopback interface alone. A request must name this very address as its host, so that no name of
//! another site that leads here is taken; must come from a page of this server or from none; and must know the token,
//! 128 random bits of which only the address that is printed says something.

use std::io::Read;

use bksim_cli::exit::Failure;
use serde::Deserialize;
use tiny_http::{Header, Method, Request, Response};

use super::file::{ModelFile, NotWritten};

/// Largest request that is read, bytes.
const MOST_BYTES: u64 = 8 << 20;
/// Headers of every answer: nothing of it is kept, guessed at, framed or shown to other sites.
const HEADERS: [(&str, &str); 5] = [
    ("Cache-Control", "no-store"),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Content-Security-Policy", "frame-ancestors 'none'"),
];

/// A server that listens.
pub(crate) struct Server {
    http: tiny_http::Server,
    host: String,
    token: String,
}

/// A text for the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Put {
    before: String,
    text: String,
}

/// Status, type and body of an answer.
type Answer = (u16, &'static str, String);

impl Server {
    /// Listens at a port of this computer; at a free one if it is 0.
    pub(crate) fn open(port: u16) -> Result<Self, Failure> {
        let unavailable = |what: String| {
            Failure::usage(
                format!("no page can be served: {what}"),
                "name another --port, or none for a free one",
            )
        };
        let http =
            tiny_http::Server::http(("127.0.0.1", port)).map_err(|e| unavailable(e.to_string()))?;
        let address =
            http.server_addr().to_ip().ok_or_else(|| unavailable("no address".to_owned()))?;
        let mut random = [0; 16];
        getrandom::fill(&mut random).map_err(|e| unavailable(e.to_string()))?;
        let token = format!("{:032x}", u128::from_be_bytes(random));
        Ok(Self { http, host: address.to_string(), token })
    }

    /// The address of the page.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }

    /// Answers requests until the process is ended.
    pub(crate) fn serve(&self, file: &ModelFile, page: &dyn Fn(&str) -> Result<String, String>) {
        for mut request in self.http.incoming_requests() {
            let (status, kind, body) = self.answer(&mut request, file, page);
            let mut response = Response::from_string(body).with_status_code(status);
            for (name, value) in HEADERS.iter().chain(&[("Content-Type", kind)]) {
                if let Ok(header) = Header::from_bytes(name.as_bytes(), value.as_bytes()) {
                    response.add_header(header);
                }
            }
            // A browser that went away needs no answer.
            let _ = request.respond(response);
        }
    }

    fn answer(
        &self,
        request: &mut Request,
        file: &ModelFile,
        page: &dyn Fn(&str) -> Result<String, String>,
    ) -> Answer {
        const TEXT: &str = "text/plain; charset=utf-8";
        let plain = |status: u16, words: &str| (status, TEXT, words.to_owned());
        if let Some(words) = self.refused(request) {
            return plain(403, words);
        }
        let place = request.url().strip_prefix(&format!("/{}/", self.token)).map(str::to_owned);
        let method = request.method().clone();
        match (method, place.as_deref()) {
            (Method::Get, Some("")) => match file
                .read()
                .map_err(|_| "the file cannot be read".to_owned())
                .and_then(|text| page(&text))
            {
                Ok(html) => (200, "text/html; charset=utf-8", html),
                Err(words) => plain(500, &words),
            },
            (Method::Get, Some("file")) => match file.read() {
                Ok(text) => (200, TEXT, text),
                Err(_) => plain(500, "the file cannot be read"),
            },
            (Method::Put, Some("file")) => put(request, file),
            (_, Some("" | "file")) => plain(405, "no such method here"),
            _ => plain(404, "nothing is here"),
        }
    }

    /// Why a request is none of the page's own.
    fn refused(&self, request: &Request) -> Option<&'static str> {
        let of = |name: &'static str| {
            let headers = request.headers().iter().filter(move |header| header.field.equiv(name));
            headers.map(|header| header.value.as_str()).collect::<Vec<&str>>()
        };
        if of("Host") != [self.host.as_str()] {
            return Some("this is another host");
        }
        let own = format!("http://{}", self.host);
        if of("Origin").iter().any(|origin| *origin != own) {
            return Some("this comes from another site");
        }
        // A request that writes says where it comes from.
        if *request.method() != Method::Get && of("Origin").is_empty() {
            return Some("this comes from nowhere");
        }
        let site = of("Sec-Fetch-Site");
        site.iter()
            .any(|site| !["same-origin", "none"].contains(site))
            .then_some("this comes from another site")
    }
}

/// Writes the file, if it holds the text that was edited.
fn put(request: &mut Request, file: &ModelFile) -> Answer {
    let plain = |status: u16, words: &str| (status, "text/plain; charset=utf-8", words.to_owned());
    let mut body = Vec::new();
    let read = request.as_reader().take(MOST_BYTES + 1).read_to_end(&mut body);
    if read.is_err() || body.len() as u64 > MOST_BYTES {
        return plain(413, "this is too much");
    }
    let Ok(Put { before, text }) = serde_json::from_slice(&body) else {
        return plain(400, "this is no text for the file");
    };
    match file.replace(&before, &text) {
        Ok(()) => plain(200, "written"),
        Err(NotWritten::Changed) => {
            plain(409, "The file was changed by another program, and nothing was written.")
        }
        Err(NotWritten::Refused(words)) => {
            plain(500, &format!("The file cannot be written: {words}"))
        }
    }
}
