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

/// A number with its unit as printed: `m/s²`, `N·m`, and a minus sign.
fn printed(text: &str) -> String {
    let text = text.replace('*', "·").replace("^2", "²").replace("^3", "³");
    text.strip_prefix('-').map(|size| format!("−{size}")).unwrap_or(text)
}

/// A table, its first row the heading.
fn table(rows: &[Row]) -> String {
    let row = |tag: &str, cells: &Row| {
        // The first cell names what the others are the numbers of.
        let words = |(column, cell): (usize, &String)| {
            if column == 0 { escaped(cell) } else { printed(&escaped(cell)) }
        };
        let cell = |cell| format!("<{tag}>{}</{tag}>", words(cell));
        format!("<tr>{}</tr>", cells.iter().enumerate().map(cell).collect::<String>())
    };
    let [head, body @ ..] = rows else { return String::new() };
    let body: String = body.iter().map(|cells| row("td", cells)).collect();
    format!("<table><thead>{}</thead><tbody>{body}</tbody></table>", row("th", head))
}
