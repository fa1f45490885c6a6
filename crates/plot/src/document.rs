//! Documents of texts, tables and pictures: a page of HTML that prints, and pages of A4 as PDF.
//!
//! Lengths are CSS pixels of 1/96 inch, so that a picture that is drawn to scale keeps it in print.

use std::fmt::Write as _;

use crate::figure::Size;
use crate::font;
use crate::picture::{PlotError, pages_to_pdf};
use crate::svg::escaped;

/// A sheet of A4, its margin and the room within, px.
const PAGE: Size = Size { width: 793.7, height: 1122.5 };
const MARGIN: f64 = 56.7;
/// Width of what a document holds, px.
pub const ROOM: f64 = PAGE.width - 2.0 * MARGIN;
/// Heights of letters: of the title, headings, texts, and of tables that fit.
const TITLE: f64 = 20.0;
const HEADING: f64 = 14.0;
const TEXT: f64 = 11.0;
const CELL: f64 = 10.0;
/// The smallest letters of a wide table: one that is wider yet goes on in a second table below.
const LEAST: f64 = 8.0;
/// Space between two columns of a table, in heights of letters, and the height of a row.
const GAP: f64 = 1.2;
const ROW: f64 = 1.55;
const INK: &str = "#1f2328";
const RULE: &str = "#c4c9cf";

/// A part of a document.
#[derive(Clone, PartialEq, Debug)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// Rows of cells, the first of which is the heading.
    Table(Vec<Vec<String>>),
    /// A picture as SVG, at most [`ROOM`] wide, or made smaller.
    Picture {
        /// The picture.
        svg: String,
        /// Size of the picture.
        size: Size,
        /// Words below it.
        caption: String,
    },
}

/// Parts under one title.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Document {
    /// Title.
    pub title: String,
    /// The language of its words, `en`.
    pub language: &'static str,
    /// Words at the foot of each page.
    pub foot: String,
    /// The parts, in their order.
    pub blocks: Vec<Block>,
}

/// True of a cell that stands at the right of its column.
fn is_number(cell: &str) -> bool {
    cell.trim_start_matches(['-', '−']).starts_with(|c: char| c.is_ascii_digit())
}

/// The columns of a table with numbers.
fn numeric(rows: &[Vec<String>]) -> Vec<bool> {
    let n = rows.first().map_or(0, Vec::len);
    let column = |k: usize| rows.iter().skip(1).filter_map(move |row| row.get(k));
    let is_of_numbers = |k: usize| {
        column(k).any(|cell| is_number(cell)) && column(k).all(|c| c.is_empty() || is_number(c))
    };
    (0..n).map(is_of_numbers).collect()
}

/// A table as it fits on a page: rows, the widths of their columns at letters of height one, and the height of letters.
struct Fitted {
    rows: Vec<Vec<String>>,
    widths: Vec<f64>,
    size: f64,
}

impl Fitted {
    /// Tables below each other with all columns of one: each begins with the columns of names that this begins with.
    fn all(rows: &[Vec<String>]) -> Vec<Self> {
        let n = rows.first().map_or(0, Vec::len);
        let widest = |k: usize| {
            let cells = rows.iter().filter_map(|row| row.get(k));
            cells.map(|cell| font::width(cell, 1.0)).fold(0.0, f64::max) + GAP
        };
        let widths: Vec<f64> = (0..n).map(widest).collect();
        let of = |columns: &[usize]| {
            let row = |row: &Vec<String>| {
                columns.iter().map(|&k| row.get(k).cloned().unwrap_or_default()).collect()
            };
            let widths: Vec<f64> = columns.iter().map(|&k| widths[k]).collect();
            let size = (ROOM / widths.iter().sum::<f64>()).clamp(LEAST, CELL);
            Self { rows: rows.iter().map(row).collect(), widths, size }
        };
        let all: Vec<usize> = (0..n).collect();
        let n_names = numeric(rows).iter().take_while(|is_number| !**is_number).count();
        let (names, others) = all.split_at(n_names);
        let width = |columns: &[usize]| columns.iter().map(|&k| widths[k]).sum::<f64>();
        if LEAST * width(&all) <= ROOM || others.is_empty() || LEAST * width(names) > 0.5 * ROOM {
            return vec![of(&all)];
        }
        let mut parts = vec![names.to_vec()];
        for &column in others {
            let last = parts.last_mut().expect("there is a first part");
            if last.len() > n_names && CELL * (width(last) + widths[column]) > ROOM {
                parts.push([names, &[column]].concat());
            } else {
                last.push(column);
            }
        }
        parts.iter().map(|part| of(part)).collect()
    }
}

impl Document {
    /// The document as a page of HTML without scripts.
    pub fn to_html(&self) -> String {
        let title = escaped(&self.title);
        let mut out = format!(
            "<!doctype html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
            self.language
        );
        // Writing to a text does not fail.
        for block in &self.blocks {
            let _ = match block {
                Block::Heading(text) => writeln!(out, "<h2>{}</h2>", escaped(text)),
                Block::Text(text) => writeln!(out, "<p>{}</p>", escaped(text)),
                Block::Table(rows) => Fitted::all(rows)
                    .iter()
                    .try_for_each(|part| writeln!(out, "{}", html_table(part))),
                Block::Picture { svg, caption, .. } => {
                    writeln!(
                        out,
                        "<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>",
                        escaped(caption)
                    )
                }
            };
        }
        let _ = write!(out, "<footer>{}</footer>\n</body>\n</html>\n", escaped(&self.foot));
        out
    }

    /// The document as PDF.
    ///
    /// # Errors
    /// [`PlotError`] when a library refuses a page.
    pub fn to_pdf(&self) -> Result<Vec<u8>, PlotError> {
        pages_to_pdf(&self.pages(), PAGE, &self.title)
    }

    /// The sheets of the document as SVG.
    pub fn pages(&self) -> Vec<String> {
        let mut sheets = Sheets { pages: Vec::new(), page: String::new(), y: MARGIN };
        sheets.text(&self.title, TITLE, 1.6);
        for (idx, block) in self.blocks.iter().enumerate() {
            match block {
                Block::Heading(text) => {
                    // A heading stays with what follows it.
                    let next = self.blocks.get(idx + 1).map_or(0.0, least_height);
                    sheets.room(2.4 * HEADING + next);
                    sheets.y += 0.8 * HEADING;
                    sheets.text(text, HEADING, 1.6);
                }
                Block::Text(text) => {
                    for line in lines(text, TEXT) {
                        sheets.text(&line, TEXT, 1.4);
                    }
                    sheets.y += 0.4 * TEXT;
                }
                Block::Table(rows) => Fitted::all(rows).iter().for_each(|part| sheets.table(part)),
                Block::Picture { svg, size, caption } => sheets.picture(svg, *size, caption),
            }
        }
        sheets.turn();
        let n = sheets.pages.len();
        let foot = |(idx, page): (usize, &String)| {
            let foot = format!("{}    {} / {n}", self.foot, idx + 1);
            let y = PAGE.height - 0.5 * MARGIN;
            page.clone() + &word(&foot, [MARGIN, y], 8.0, "start", "normal") + "</svg>\n"
        };
        sheets.pages.iter().enumerate().map(foot).collect()
    }
}

/// The room that the beginning of a part takes.
fn least_height(block: &Block) -> f64 {
    match block {
        Block::Picture { size, .. } => fitted(*size).height + 2.0 * TEXT,
        _ => 4.0 * TEXT,
    }
}

/// The size of a picture that is at most as large as the room on a page.
fn fitted(size: Size) -> Size {
    let most = PAGE.height - 2.0 * MARGIN - 4.0 * TEXT;
    let scale = (ROOM / size.width).min(most / size.height).min(1.0);
    Size { width: scale * size.width, height: scale * size.height }
}

/// A text in lines that fit.
fn lines(text: &str, size: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("there is a first line");
        let longer = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
        if last.is_empty() || font::width(&longer, size) <= ROOM {
            *last = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

/// A text as an element of SVG.
fn word(text: &str, [x, y]: [f64; 2], size: f64, anchor: &str, weight: &str) -> String {
    let text = escaped(text);
    format!(
        "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size:.2}\" text-anchor=\"{anchor}\" font-weight=\"{weight}\" fill=\"{INK}\">{text}</text>\n"
    )
}

/// Pages as they are filled.
struct Sheets {
    pages: Vec<String>,
    page: String,
    /// Where the next part begins.
    y: f64,
}

impl Sheets {
    /// Ends a page that has something on it.
    fn turn(&mut self) {
        if self.page.is_empty() {
            return;
        }
        let Size { width, height } = PAGE;
        let page = std::mem::take(&mut self.page);
        self.pages.push(format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\">\n{page}"));
        self.y = MARGIN;
    }

    /// Begins a page where there is no room on this one.
    fn room(&mut self, height: f64) {
        if self.y + height > PAGE.height - MARGIN {
            self.turn();
        }
    }

    fn text(&mut self, text: &str, size: f64, leading: f64) {
        self.room(leading * size);
        self.y += leading * size;
        let text = font::fitted(text, size, ROOM);
        self.page += &word(&text, [MARGIN, self.y - 0.35 * size], size, "start", "normal");
    }

    fn picture(&mut self, svg: &str, size: Size, caption: &str) {
        let drawn = fitted(size);
        self.room(drawn.height + 2.2 * TEXT);
        let scale = drawn.width / size.width;
        let x = MARGIN + 0.5 * (ROOM - drawn.width);
        let _ = writeln!(
            self.page,
            "<g transform=\"translate({x:.2} {:.2}) scale({scale:.6})\">{svg}</g>",
            self.y
        );
        self.y += drawn.height + 0.4 * TEXT;
        for line in lines(caption, TEXT) {
            self.text(&line, TEXT, 1.3);
        }
        self.y += TEXT;
    }

    fn table(&mut self, Fitted { rows, widths, size }: &Fitted) {
        let Some(head) = rows.first() else { return };
        let size = *size;
        let total: f64 = widths.iter().sum();
        // A table that is still too wide loses the ends of its widest cells.
        let shrink = (ROOM / (size * total)).min(1.0);
        let right = numeric(rows);
        for (idx, row) in rows.iter().enumerate() {
            if self.y + ROW * size > PAGE.height - MARGIN {
                self.turn();
                if idx > 0 {
                    self.row(head, (widths, &right), size, shrink);
                }
            }
            self.row(row, (widths, &right), size, shrink);
            let color = if idx == 0 { INK } else { RULE };
            let (x, y) = (MARGIN + ROOM.min(shrink * size * total), self.y);
            let _ = writeln!(
                self.page,
                "<path d=\"M{MARGIN} {y:.2}H{x:.2}\" stroke=\"{color}\" stroke-width=\"0.6\" fill=\"none\"/>"
            );
        }
        self.y += TEXT;
    }

    fn row(&mut self, row: &[String], (widths, right): (&[f64], &[bool]), size: f64, shrink: f64) {
        self.y += ROW * size;
        let (mut x, y) = (MARGIN, self.y - 0.45 * size);
        for ((cell, width), is_right) in row.iter().zip(widths).zip(right) {
            let width = width * size * shrink;
            let text = font::fitted(cell, size, width - 0.4 * GAP * size);
            let (at, anchor) =
                if *is_right { (x + width - 0.5 * GAP * size, "end") } else { (x, "start") };
            self.page += &word(&text, [at, y], size, anchor, "normal");
            x += width;
        }
    }
}

fn html_table(Fitted { rows, size, .. }: &Fitted) -> String {
    let right = numeric(rows);
    let row = |(idx, row): (usize, &Vec<String>)| {
        let tag = if idx == 0 { "th" } else { "td" };
        let cell = |(cell, is_right): (&String, &bool)| {
            let class = if *is_right { " class=\"number\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escaped(cell))
        };
        format!("<tr>{}</tr>", row.iter().zip(&right).map(cell).collect::<String>())
    };
    let rows: Vec<String> = rows.iter().enumerate().map(row).collect();
    let letters =
        if *size < CELL { format!(" style=\"font-size: {size:.1}px\"") } else { String::new() };
    format!("<table{letters}>\n{}\n</table>", rows.join("\n"))
}

const STYLE: &str = "\
@page { size: A4; margin: 15mm }
body { font: 10pt/1.4 Ubuntu, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif; color: #1f2328; max-width: 180mm; margin: 15mm auto }
h1 { font-size: 16pt } h2 { font-size: 12pt; margin: 1.4em 0 .4em; break-after: avoid }
table { border-collapse: collapse; font-size: 7.5pt; font-variant-numeric: tabular-nums; break-inside: auto; margin-bottom: 1em }
th, td { text-align: left; padding: .15em 1em .15em 0; border-bottom: 1px solid #c4c9cf; font-weight: normal }
th { border-color: #1f2328 } .number { text-align: right; white-space: nowrap }
figure { margin: 1em 0; text-align: center; break-inside: avoid } figcaption { font-size: 9pt }
footer { margin-top: 2em; font-size: 8pt; color: #5c636b }
@media print { body { margin: 0 } }
";

#[cfg(test)]
mod tests {
    use super::*;

    fn document(n_rows: usize) -> Document {
        let row = |k: usize| vec![format!("A{k}"), format!("{}.5", k)];
        let rows = std::iter::once(vec!["joint <&>".to_owned(), "force (N)".to_owned()]);
        let rows = rows.chain((0..n_rows).map(row)).collect();
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"200\" height=\"100\"><rect width=\"9\" height=\"9\"/></svg>\n";
        let size = Size { width: 200.0, height: 100.0 };
        let picture = Block::Picture { svg: svg.to_owned(), size, caption: "A square.".to_owned() };
        let blocks = vec![Block::Heading("Forces".to_owned()), Block::Table(rows), picture];
        Document {
            title: "Press & lever".to_owned(),
            language: "en",
            foot: "bksim".to_owned(),
            blocks,
        }
    }

    #[test]
    fn a_long_table_goes_on_under_its_heading_on_every_page() {
        let pages = document(200).pages();
        assert!(pages.len() > 2, "{} pages", pages.len());
        for page in &pages {
            roxmltree::Document::parse(page).expect("a page of valid XML");
            assert!(page.contains("joint &lt;&amp;&gt;"));
        }
        let all = pages.concat();
        assert!((0..200).all(|k| all.contains(&format!(">A{k}<"))), "no row is lost");
    }

    #[test]
    fn a_table_that_is_too_wide_goes_on_below_with_its_names() {
        let heads = (0..20).map(|k| format!("angle of joint {k} [deg]"));
        let heads = std::iter::once("joint".to_owned()).chain(heads);
        let cells = (0..20).map(|k| format!("{k}.25"));
        let cells = std::iter::once("A".to_owned()).chain(cells);
        let rows = vec![heads.collect(), cells.collect()];
        let parts = Fitted::all(&rows);
        assert!(parts.len() > 1);
        let fits = |part: &Fitted| part.size * part.widths.iter().sum::<f64>() <= ROOM * 1.000_001;
        assert!(parts.iter().all(fits), "no part is wider than the page");
        assert!(parts.iter().all(|part| part.rows[0][0] == "joint" && part.rows[1][0] == "A"));
        let n: usize = parts.iter().map(|part| part.rows[0].len() - 1).sum();
        assert_eq!(n, 20, "each column is there once");
    }

    #[test]
    fn html_and_pdf_hold_the_same_parts() {
        let document = document(3);
        let html = document.to_html();
        for part in ["<h1>Press &amp; lever</h1>", "<td class=\"number\">2.5</td>", "<rect width"] {
            assert!(html.contains(part), "{part}");
        }
        let pdf = document.to_pdf().expect("a document");
        assert!(pdf.starts_with(b"%PDF"));
        assert_eq!(document.pages().len(), 1);
    }
}
