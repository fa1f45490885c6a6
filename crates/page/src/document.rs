//! The document: its frame, its policy, and its sections.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bksim::playback::Playback;
use bksim_scene::Theme;
use sha2::{Digest, Sha256};

use crate::equations::Equations;
use crate::{certificate, escape, model_text};

/// The page's script, with the library for its curves.
#[cfg(bundled)]
const SCRIPT: &str = include_str!(concat!(env!("OUT_DIR"), "/page.js"));
/// The page's style, with that of the library.
#[cfg(bundled)]
const STYLE: &str = include_str!(concat!(env!("OUT_DIR"), "/page.css"));
/// The licence of the library.
#[cfg(bundled)]
pub(crate) const LICENCES: &str = include_str!(concat!(env!("OUT_DIR"), "/LICENCES"));

#[cfg(not(bundled))]
const SCRIPT: &str = "";
#[cfg(not(bundled))]
const STYLE: &str = "";
#[cfg(not(bundled))]
pub(crate) const LICENCES: &str = "";

/// The contents of a page.
pub(crate) struct Content<'a> {
    /// Heading of the content.
    pub title: &'a str,
    /// The run.
    pub playback: &'a Playback,
    /// Equations of the content.
    pub equations: &'a Equations,
    /// The numbers of the run: headings and HTML.
    pub tables: &'a [(String, String)],
    /// Pictures of all assemblies as HTML; empty where nobody asked for them.
    pub assemblies: &'a str,
    /// Remarks on parts that are left out.
    pub remarks: &'a [String],
}

/// The HTML of the page; `data` is the JSON for the script.
pub(crate) fn write(content: &Content<'_>, data: &str) -> String {
    let title = escape::html(content.title);
    let policy = policy(SCRIPT);
    let style = format!("{}{STYLE}", variables());
    let body = [
        header(content),
        STAGE.to_owned(),
        section("report", "Report", &headed(content.tables)),
        section("assemblies", "Assemblies", content.assemblies),
        section("equations", "Equations", &headed(&content.equations.formulas)),
        section("model", "The model", &model(content)),
        section("certificate", "The run", &certificate::html(content.playback)),
        footer(),
    ];
    let body = body.join("\n");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n\
         </head>\n<body>\n{body}\n\
         <script type=\"application/json\" id=\"run\">{}</script>\n<script>{SCRIPT}</script>\n\
         </body>\n</html>\n",
        escape::json(data)
    )
}

/// The content security policy: nothing is loaded, and no script runs but this one.
fn policy(script: &str) -> String {
    let hash = STANDARD.encode(Sha256::digest(script.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'; \
         img-src data:; base-uri 'none'; form-action 'none'"
    )
}

/// The colours of both themes as variables of the style.
pub(crate) fn variables() -> String {
    let of = |theme: &Theme| {
        let color = |name: &str, color: bksim_scene::Color| format!("--{name}:{};", color.hex());
        [
            color("background", theme.background),
            color("text", theme.text),
            color("faint", theme.faint),
            color("accent", theme.palette[0]),
            color("force", theme.force),
            color("velocity", theme.velocity),
        ]
        .concat()
    };
    format!(
        ":root{{color-scheme:light;{}}}\n:root[data-theme=dark]{{color-scheme:dark;{}}}\n",
        of(&Theme::LIGHT),
        of(&Theme::DARK)
    )
}

/// Heading, facts and remarks.
fn header(content: &Content<'_>) -> String {
    let title = escape::html(content.title);
    let model = &content.playback.mechanism().model;
    let log = content.playback.log();
    let [first, last] = content.playback.span();
    let count =
        |n: usize, one: &str, many: &str| format!("{n}\u{a0}{}", if n == 1 { one } else { many });
    let facts = [
        count(model.bodies.len().saturating_sub(1), "body", "bodies"),
        count(model.joints.len(), "joint", "joints"),
        format!("{first}\u{a0}s to {last}\u{a0}s"),
    ];
    let mut remarks = content.remarks.to_vec();
    match &log.end {
        None => remarks
            .insert(0, "The log of this run was cut short; the page has what was left.".to_owned()),
        Some(end) if end.outcome == bksim::log::Outcome::Stopped => {
            remarks.insert(0, format!("The run stopped early: {}.", end.reason));
        }
        Some(_) => (),
    }
    let remarks: Vec<String> =
        remarks.iter().map(|remark| format!("<p>{}</p>", escape::html(remark))).collect();
    let notice = if remarks.is_empty() {
        String::new()
    } else {
        format!("<aside class=\"notice\" role=\"note\">{}</aside>", remarks.concat())
    };
    format!(
        "<header>\n<div><h1>{title}</h1>\n<p class=\"quiet\">{}</p></div>\n\
         <button type=\"button\" id=\"theme\" aria-label=\"Dark theme\" aria-pressed=\"false\" \
         title=\"Light or dark\"></button>\n</header>\n{notice}",
        escape::html(&facts.join(" · ")),
    )
}

/// The parts that the script fills: the drawing with its controls, and the curves.
const STAGE: &str = r#"<noscript><p class="notice">This page moves with JavaScript, which is switched off here.</p></noscript>
<main>
<section id="motion" aria-label="Motion">
<div class="picture">
<canvas id="picture" tabindex="0" role="img" aria-label="The mechanism"></canvas>
<div class="corner" role="group" aria-label="View">
<button type="button" id="zoom-in" aria-label="Zoom in" title="Zoom in (+)">+</button>
<button type="button" id="zoom-out" aria-label="Zoom out" title="Zoom out (−)">−</button>
<button type="button" id="fit" aria-label="Show all" title="Show all (0)"></button>
<select id="look" aria-label="Direction of view" title="Direction of view" hidden></select>
</div>
</div>
<div class="controls">
<div class="transport" role="group" aria-label="Playback">
<button type="button" id="back" aria-label="One frame back" title="One frame back (,)"></button>
<button type="button" id="play" class="main" aria-label="Play" title="Play or pause (space)"></button>
<button type="button" id="forth" aria-label="One frame on" title="One frame on (.)"></button>
<button type="button" id="loop" aria-label="Loop" aria-pressed="true" title="Start again at the end (L)"></button>
</div>
<output id="time" for="scrub"></output>
<label class="speed">Speed <select id="speed"></select></label>
<input type="range" id="scrub" min="0" max="1" step="any" value="0" aria-label="Time">
</div>
<div class="choices">
<label><input type="checkbox" id="labels"> Names</label>
<label><input type="checkbox" id="velocities"> Velocities</label>
<label><input type="checkbox" id="reactions"> Reactions</label>
<label id="section" hidden>Section <select id="cut" aria-label="Cut across an axis"><option value="">none</option><option value="0">across x</option><option value="1">across y</option><option value="2">across z</option></select>
<input type="range" id="cut-at" min="0" max="1" step="any" value="0.5" aria-label="Place of the section" hidden> <output id="cut-text" for="cut-at"></output></label>
<details id="trails"><summary>Trails</summary><div class="list"></div></details>
</div>
</section>
<section id="curves" aria-label="Curves">
<div class="charts"></div>
<details id="channels"><summary>Choose curves</summary><div class="list"></div></details>
<p class="quiet hint">Drag across a chart to zoom in, double-click for all of it; drag the line, or click, to move in time.</p>
</section>
</main>"#;

/// A section with its heading; empty if it has no body.
fn section(id: &str, title: &str, body: &str) -> String {
    if body.is_empty() {
        return String::new();
    }
    format!("<section class=\"text\" id=\"{id}\">\n<h2>{title}</h2>\n{body}\n</section>")
}

/// Parts with their headings; their bodies are HTML already.
fn headed(parts: &[(String, String)]) -> String {
    let part = |(title, html): &(String, String)| {
        let title = escape::html(title);
        format!(
            "<div class=\"part\">\n<h3>{title}</h3>\n<div class=\"scroll\">{html}</div>\n</div>"
        )
    };
    let parts: Vec<String> = parts.iter().map(part).collect();
    if parts.is_empty() {
        return String::new();
    }
    format!("<div class=\"parts\">\n{}\n</div>", parts.join("\n"))
}

/// Bodies, joints, parameters, and the text of the model.
fn model(content: &Content<'_>) -> String {
    let (text, is_whole) = model_text::html(&content.playback.log().header.model_text);
    let cut = if is_whole { "" } else { "<p>The rest of the text is in the log.</p>" };
    format!(
        "{}\n<details><summary>Text of the model</summary>\n<pre tabindex=\"0\">{text}</pre>{cut}</details>",
        headed(&content.equations.tables)
    )
}

fn footer() -> String {
    format!(
        "<footer>\n<p>Written by bksim {}. Curves are drawn with uPlot.</p>\n\
         <details><summary>Licences</summary><pre>{}</pre></details>\n</footer>",
        bksim::VERSION,
        escape::html(LICENCES.trim())
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_bundle_ends_its_element() {
        assert!(!SCRIPT.contains("</script") && !SCRIPT.contains("<!--"));
        assert!(!STYLE.contains("</style") && !STYLE.contains("url(http"));
    }

    #[test]
    fn the_policy_allows_one_script() {
        // SHA-256 of nothing, in base64, as `openssl dgst -sha256 -binary | base64` writes it.
        let hash = "47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=";
        assert!(policy("").contains(&format!("script-src 'sha256-{hash}'")));
    }
}
