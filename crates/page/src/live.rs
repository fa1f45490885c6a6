//! A live page: a model, the module that edits, poses and solves it, and the script around it, in one document.
//!
//! ```text
//! #live     name, text, colours of both themes     #worker   the script of the module's threads
//! #module   the module, compressed, in letters       #codes    faults in Vietnamese, in the same way
//! ```
//!
//! The policy lets one script run, threads of what is in the page, and the module be compiled; it forbids the
//! network, but where the page is served: there it may ask its own server.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bksim::cad::backdrop::Backdrop;
use bksim::translation::{Language, Translation, translations};
use bksim_scene::Theme;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use crate::document::{LICENCES, variables};
use crate::error::PageError;
use crate::{escape, letters};

#[cfg(bundled)]
const SCRIPT: &str = include_str!(concat!(env!("OUT_DIR"), "/live.js"));
#[cfg(bundled)]
const STYLE: &str = include_str!(concat!(env!("OUT_DIR"), "/live.css"));
#[cfg(bundled)]
const WORKER: &str = include_str!(concat!(env!("OUT_DIR"), "/worker.js"));

#[cfg(not(bundled))]
const SCRIPT: &str = "";
#[cfg(not(bundled))]
const STYLE: &str = "";
#[cfg(not(bundled))]
const WORKER: &str = "";

/// Options of a live page.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LiveOptions {
    /// The heading; the name of the model unless given.
    pub title: Option<String>,
    /// True if the page comes from a server that keeps the text in its file.
    pub is_served: bool,
    /// The lines of a drawing that are seen under the mechanism.
    pub under: Option<Backdrop>,
}

/// The live page of a model's text; `module` is the WebAssembly of `crates/live`.
///
/// # Errors
/// [`PageError::NotBundled`] in a build without the script, and [`PageError::NoModule`] for bytes that are none.
pub fn live(
    text: &str,
    name: &str,
    module: &[u8],
    options: &LiveOptions,
) -> Result<String, PageError> {
    if SCRIPT.is_empty() {
        return Err(PageError::NotBundled);
    }
    if !module.starts_with(b"\0asm") {
        return Err(PageError::NoModule);
    }
    let module = packed(module)?;
    let codes = packed(codes().to_string().as_bytes())?;
    let data = json!({
        "name": name,
        "text": text,
        "colors": { "light": Theme::LIGHT, "dark": Theme::DARK },
        "served": options.is_served,
        "under": options.under.as_ref().map(under),
    });
    let title = escape::html(options.title.as_deref().unwrap_or(name));
    let policy = policy(options.is_served);
    let style = format!("{}{STYLE}", variables());
    let data = escape::json(&data.to_string());
    let licences = escape::html(LICENCES.trim());
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n\
         </head>\n<body>\n{}{BODY}\n\
         <footer><details><summary>Licences</summary><pre>{licences}</pre></details></footer>\n\
         <script type=\"application/json\" id=\"live\">{data}</script>\n\
         <script type=\"text/plain\" id=\"worker\">{WORKER}</script>\n\
         <script type=\"text/plain\" id=\"module\">{module}</script>\n\
         <script type=\"text/plain\" id=\"codes\">{codes}</script>\n\
         <script>{SCRIPT}</script>\n</body>\n</html>\n",
        header(&title, options.is_served),
    ))
}

/// Lines and places of a drawing, to a micrometre.
fn under(Backdrop { lines, places }: &Backdrop) -> Value {
    let flat = |points: &[[f64; 2]]| -> Vec<f64> {
        points.iter().flatten().map(|x| (x * 1e6).round() / 1e6).collect()
    };
    let lines: Vec<Vec<f64>> = lines.iter().map(|line| flat(line)).collect();
    json!({ "lines": lines, "places": flat(places) })
}

/// Bytes as a page has them: compressed, in letters.
fn packed(bytes: &[u8]) -> Result<String, PageError> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    let packed = packed.write_all(bytes).and_then(|()| packed.finish());
    Ok(letters::encoded(&packed.map_err(|_| PageError::NoModule)?))
}

/// Title, meaning and cure in Vietnamese of the codes that a live page can show: those of models, runs, answers and
/// edits.
fn codes() -> Value {
    let is_shown = |code: &str| code.starts_with(['M', 'S', 'R', 'W']);
    let rows = translations(Language::Vietnamese).filter(|(code, _)| is_shown(code));
    let row = |words: &Translation| json!([words.title, words.meaning, words.cure]);
    rows.map(|(code, words)| (code.to_owned(), row(words))).collect::<Map<_, _>>().into()
}

/// The content security policy of a live page.
fn policy(is_served: bool) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    let style = format!("{}{STYLE}", variables());
    let connect = if is_served { "connect-src 'self'; " } else { "" };
    format!(
        "default-src 'none'; script-src 'sha256-{}' 'wasm-unsafe-eval'; worker-src blob:; \
         style-src 'sha256-{}'; {connect}img-src data: blob:; base-uri 'none'; form-action 'none'",
        hash(SCRIPT),
        hash(&format!("\n{style}")),
    )
}

fn header(title: &str, is_served: bool) -> String {
    let save = if is_served { "Save" } else { "Download" };
    format!(
        r#"<header>
<h1>{title}</h1>
<button type="button" id="undo" disabled title="Undo (Ctrl+Z)">Undo</button>
<button type="button" id="redo" disabled title="Redo (Ctrl+Y)">Redo</button>
<button type="button" id="share" title="A link that holds this model">Share</button>
<select id="export" aria-label="Export" title="Files of what is shown"><option value="" selected>Export</option><option value="png">Picture (PNG)</option><option value="svg">Picture (SVG)</option><option value="csv">Curves (CSV)</option><option value="toml">Model (TOML)</option></select>
<button type="button" id="save" class="main" title="The text as a TOML file (Ctrl+S)">{save}</button>
<button type="button" id="theme" aria-label="Dark theme" aria-pressed="false" title="Light or dark"></button>
</header>
"#
    )
}

/// The parts that the script fills.
const BODY: &str = r#"<noscript><p>This page lives by JavaScript, which is switched off here.</p></noscript>
<main>
<section id="stage" aria-label="The mechanism">
<div class="tools" role="toolbar" aria-label="Tools">
<button type="button" data-tool="hand" aria-pressed="true" title="Drag a point or body">Hand</button>
<button type="button" data-tool="shape" aria-pressed="false" title="Drag points to change lengths">Shape</button>
<button type="button" data-tool="select" aria-pressed="false" title="Hold several bodies at once">Select</button>
<button type="button" data-tool="link" aria-pressed="false" title="Draw a link">Link</button>
<button type="button" data-tool="plate" aria-pressed="false" title="Draw a plate with three corners or more">Plate</button>
<button type="button" data-tool="ground" aria-pressed="false" title="Pin a point to the ground">Ground</button>
<button type="button" data-tool="pin" aria-pressed="false" title="Join two points">Pin</button>
<button type="button" data-tool="slide" aria-pressed="false" title="Let a point slide along a line">Slide</button>
<button type="button" data-tool="slot" aria-pressed="false" title="Let a point of a body slide along another body">Slot</button>
<button type="button" data-tool="gear" aria-pressed="false" title="Let two wheels mesh">Gears</button>
<button type="button" data-tool="spring" aria-pressed="false" title="A spring between two points">Spring</button>
<button type="button" data-tool="damper" aria-pressed="false" title="A damper between two points">Damper</button>
<button type="button" data-tool="force" aria-pressed="false" title="A force on a point">Force</button>
<button type="button" data-tool="motor" aria-pressed="false" title="Drive a joint">Motor</button>
<button type="button" id="gravity" title="Gravity along −y">Gravity</button>
<button type="button" data-tool="copy" aria-pressed="false" title="Copy a body">Copy</button>
<button type="button" data-tool="mirror" aria-pressed="false" title="Copy a body, mirrored">Mirror</button>
<button type="button" data-tool="delete" aria-pressed="false" title="Delete a body">Delete</button>
<button type="button" id="under" title="A picture underneath, to draw over">Picture</button>
<input type="file" id="underlay" accept="image/*" hidden aria-label="Picture underneath">
</div>
<div class="picture">
<canvas id="picture" tabindex="0" role="application" aria-label="The mechanism: N goes to the next point, arrow keys move, Enter takes hold and lets go"></canvas>
<div id="dimensions" hidden></div>
<output id="status" aria-live="polite"></output>
<output id="freedoms"></output>
<output id="transmissions"></output>
<div class="corner" role="group" aria-label="View">
<button type="button" id="zoom-in" aria-label="Zoom in" title="Zoom in">+</button>
<button type="button" id="zoom-out" aria-label="Zoom out" title="Zoom out">−</button>
<button type="button" id="fit" aria-label="Show all" title="Show all">⤢</button>
</div>
</div>
<div id="transport" class="off" role="group" aria-label="Motion">
<button type="button" id="back" aria-label="One frame back"></button>
<button type="button" id="play" class="main" aria-label="Play" title="Play or pause (space)"></button>
<button type="button" id="forth" aria-label="One frame on"></button>
<button type="button" id="loop" aria-label="Loop" aria-pressed="true"></button>
<output id="time" for="scrub"></output>
<label>Speed <select id="speed"></select></label>
<button type="button" id="live-run" aria-pressed="false" title="Let it move, and pull at it">Live</button>
<button type="button" id="to-start" title="Go back to the pose of the start">To start</button>
<button type="button" id="start-here" title="Write this pose into the model as its start">Start here</button>
<label><input type="checkbox" id="labels" checked> Names</label>
<label title="Distances of points, to be typed in place"><input type="checkbox" id="sized"> Dimensions</label>
<label title="The motion before the last change, faintly"><input type="checkbox" id="ghost"> Before</label>
<input type="range" id="scrub" min="0" max="1" step="any" value="0" aria-label="Time">
</div>
<ul id="faults" hidden aria-label="Faults"></ul>
</section>
<section id="side" aria-label="The model">
<div role="tablist">
<button type="button" role="tab" data-tab="values" aria-selected="true">Values</button>
<button type="button" role="tab" data-tab="elements" aria-selected="false">Elements</button>
<button type="button" role="tab" data-tab="text" aria-selected="false">Text</button>
<button type="button" role="tab" data-tab="curves" aria-selected="false">Curves</button>
<button type="button" role="tab" data-tab="study" aria-selected="false">Study</button>
<button type="button" role="tab" data-tab="limits" aria-selected="false">Limits</button>
<button type="button" role="tab" data-tab="equations" aria-selected="false">Equations</button>
<button type="button" role="tab" data-tab="ways" aria-selected="false">Ways</button>
</div>
<div role="tabpanel" data-tab="values"><div id="values"></div></div>
<div role="tabpanel" data-tab="elements" hidden><div id="elements"></div></div>
<div role="tabpanel" data-tab="text" hidden><div id="lines" aria-hidden="true"></div><textarea id="text" spellcheck="false" autocomplete="off" autocapitalize="off" aria-label="The text of the model"></textarea></div>
<div role="tabpanel" data-tab="curves" hidden><div id="charts"></div><div id="chosen"></div></div>
<div role="tabpanel" data-tab="study" hidden><div id="study"></div></div>
<div role="tabpanel" data-tab="limits" hidden><div id="limits"></div></div>
<div role="tabpanel" data-tab="equations" hidden><div id="equations"></div></div>
<div role="tabpanel" data-tab="ways" hidden><div id="ways"></div></div>
</section>
</main>"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_bundles_ends_its_element() {
        for text in [SCRIPT, WORKER] {
            assert!(!text.contains("</script") && !text.contains("<!--"));
        }
        assert!(!STYLE.contains("</style") && !STYLE.contains("url("));
    }

    #[test]
    fn the_policy_has_no_unsafe_word_but_that_of_the_module() {
        for is_served in [false, true] {
            let policy = policy(is_served).replace("'wasm-unsafe-eval'", "");
            assert!(!policy.contains("unsafe"), "{policy}");
            assert_eq!(policy.contains("connect-src"), is_served);
        }
    }

    #[test]
    fn a_page_holds_its_model_and_a_module_is_asked_for() {
        if SCRIPT.is_empty() {
            return;
        }
        let refused = live("", "x", b"<html>", &LiveOptions::default());
        assert!(matches!(refused, Err(PageError::NoModule)));
        let html = live("a = \"</script>\"\n", "x<y", b"\0asm\x01\0\0\0", &LiveOptions::default());
        let html = html.expect("a page");
        assert!(html.contains("<h1>x&lt;y</h1>") && html.contains("a = \\\"\\u003c/script>\\\""));
    }
}
