//! The numbers of the run in tables: limits, strokes, time ratios, velocities, efforts, reactions, energies.

use bksim::model::file::ShownUnits;
use bksim::playback::Playback;
use bksim::report::{Row, report, tables};

use crate::escape::html as escaped;

/// Headings and HTML of the tables; none where the run has no such numbers.
pub(crate) fn html(playback: &mut Playback, units: &ShownUnits) -> Vec<(String, String)> {
    // A motion that cannot be replayed has been refused before this; a report is no reason to have no page.
    let Ok(found) = report(playback) else { return Vec::new() };
    let tables = tables(&found, units).into_iter();
    tables.map(|(name, rows)| (name.to_owned(), table(&rows))).collect()
}

/// A table, its first row the heading.
fn table(rows: &[Row]) -> String {
    let row = |tag: &str, cells: &Row| {
        let cell = |cell: &String| format!("<{tag}>{}</{tag}>", escaped(cell));
        format!("<tr>{}</tr>", cells.iter().map(cell).collect::<String>())
    };
    let [head, body @ ..] = rows else { return String::new() };
    let body: String = body.iter().map(|cells| row("td", cells)).collect();
    format!("<table><thead>{}</thead><tbody>{body}</tbody></table>", row("th", head))
}
