//! The sheet as a workbook of XLSX: the largest forces, those of each case, the cases, the forces over time.
//!
//! A workbook is an archive of XML files (ECMA-376, part 1, §18): a list of sheets, a style for headings, and a file of rows for
//! each sheet, with texts where they are used.

use std::fmt::Write as _;

use bksim::fmu::archive;
use bksim::report::{Cell, pin_table, six_digits};
use bksim::sim::run::Unreplayed;

use super::page::instants;
use super::{Runs, case_table};

/// Instants of a case over time.
const INSTANTS: u32 = 200;

/// A sheet of the workbook: name, headings and rows.
type Sheet = (&'static str, Vec<String>, Vec<Vec<Cell>>);

/// The bytes of the workbook.
pub(super) fn of(runs: &mut Runs) -> Result<Vec<u8>, Unreplayed> {
    let largest = runs.largest();
    let mut sheets: Vec<Sheet> = vec![("Largest", largest.heads, largest.rows)];
    let cases = case_table(runs);
    if let [heads, rows @ ..] = cases.as_slice() {
        let all = pin_table(&runs.named(), &runs.units);
        sheets.push(("Each case", all.heads, all.rows));
        let text = |row: &Vec<String>| row.iter().cloned().map(Cell::Text).collect();
        sheets.push(("Load cases", heads.clone(), rows.iter().map(text).collect()));
    }
    let (heads, rows) = over_time(runs)?;
    sheets.push(("Over time", heads, rows));
    Ok(archive(&files(&sheets)))
}

const XML: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n";
const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006";
const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
const TYPES: &str = "application/vnd.openxmlformats-officedocument.spreadsheetml";
/// Two styles of cells: plain, and bold for headings.
const STYLES: &str = "<fonts count=\"2\"><font><sz val=\"11\"/></font><font><b/><sz val=\"11\"/></font></fonts>\
     <fills count=\"2\"><fill><patternFill patternType=\"none\"/></fill><fill><patternFill patternType=\"gray125\"/></fill></fills>\
     <borders count=\"1\"><border><left/><right/><top/><bottom/></border></borders>\
     <cellStyleXfs count=\"1\"><xf fontId=\"0\" fillId=\"0\" borderId=\"0\"/></cellStyleXfs>\
     <cellXfs count=\"2\"><xf fontId=\"0\" fillId=\"0\" borderId=\"0\" xfId=\"0\"/>\
     <xf fontId=\"1\" fillId=\"0\" borderId=\"0\" xfId=\"0\" applyFont=\"1\"/></cellXfs>\
     <cellStyles count=\"1\"><cellStyle name=\"Normal\" xfId=\"0\" builtinId=\"0\"/></cellStyles>";

/// The files of the archive.
fn files(sheets: &[Sheet]) -> Vec<(String, Vec<u8>)> {
    let numbered = || sheets.iter().enumerate().map(|(idx, sheet)| (idx + 1, sheet));
    let mut types = format!(
        "{XML}<Types xmlns=\"{PACKAGE}/content-types\">\
         <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\
         <Override PartName=\"/xl/workbook.xml\" ContentType=\"{TYPES}.sheet.main+xml\"/>\
         <Override PartName=\"/xl/styles.xml\" ContentType=\"{TYPES}.styles+xml\"/>"
    );
    let mut listed = String::new();
    let mut related =
        format!("<Relationship Id=\"rId0\" Type=\"{OFFICE}/styles\" Target=\"styles.xml\"/>");
    // Writing to a text does not fail.
    for (n, (name, ..)) in numbered() {
        let _ = write!(
            types,
            "<Override PartName=\"/xl/worksheets/sheet{n}.xml\" ContentType=\"{TYPES}.worksheet+xml\"/>"
        );
        let _ = write!(listed, "<sheet name=\"{name}\" sheetId=\"{n}\" r:id=\"rId{n}\"/>");
        let _ = write!(
            related,
            "<Relationship Id=\"rId{n}\" Type=\"{OFFICE}/worksheet\" Target=\"worksheets/sheet{n}.xml\"/>"
        );
    }
    types += "</Types>";
    let relations = |all: &str| {
        format!("{XML}<Relationships xmlns=\"{PACKAGE}/relationships\">{all}</Relationships>")
    };
    let book = format!(
        "<Relationship Id=\"rId1\" Type=\"{OFFICE}/officeDocument\" Target=\"xl/workbook.xml\"/>"
    );
    let workbook = format!(
        "{XML}<workbook xmlns=\"{MAIN}\" xmlns:r=\"{OFFICE}\"><sheets>{listed}</sheets></workbook>"
    );
    let styles = format!("{XML}<styleSheet xmlns=\"{MAIN}\">{STYLES}</styleSheet>");
    let mut files = vec![
        ("[Content_Types].xml".to_owned(), types),
        ("_rels/.rels".to_owned(), relations(&book)),
        ("xl/workbook.xml".to_owned(), workbook),
        ("xl/_rels/workbook.xml.rels".to_owned(), relations(&related)),
        ("xl/styles.xml".to_owned(), styles),
    ];
    files.extend(numbered().map(|(n, (_, heads, rows))| {
        (format!("xl/worksheets/sheet{n}.xml"), worksheet(heads, rows))
    }));
    files.into_iter().map(|(path, text)| (path, text.into_bytes())).collect()
}

/// The rows of a sheet, the headings on top; columns as wide as the headings, which stay while rows move.
fn worksheet(heads: &[String], rows: &[Vec<Cell>]) -> String {
    let mut out = format!(
        "{XML}<worksheet xmlns=\"{MAIN}\"><sheetViews><sheetView workbookViewId=\"0\">\
         <pane ySplit=\"1\" topLeftCell=\"A2\" activePane=\"bottomLeft\" state=\"frozen\"/></sheetView></sheetViews><cols>"
    );
    for (idx, head) in heads.iter().enumerate() {
        let texts = rows.iter().filter_map(|row| match row.get(idx) {
            Some(Cell::Text(text)) => Some(text.chars().count()),
            _ => None,
        });
        let width = texts.chain([head.chars().count()]).max().unwrap_or(0).clamp(8, 60) + 2;
        let n = idx + 1;
        let _ = write!(out, "<col min=\"{n}\" max=\"{n}\" width=\"{width}\" customWidth=\"1\"/>");
    }
    out += "</cols><sheetData>";
    let heads: Vec<Cell> = heads.iter().cloned().map(Cell::Text).collect();
    for (idx, row) in std::iter::once(&heads).chain(rows).enumerate() {
        let style = if idx == 0 { " s=\"1\"" } else { "" };
        out += "<row>";
        for cell in row {
            let _ = match cell {
                Cell::Text(text) => {
                    let text = text.replace('&', "&amp;").replace('<', "&lt;");
                    write!(out, "<c t=\"inlineStr\"{style}><is><t>{text}</t></is></c>")
                }
                // A cell without a number stays empty.
                Cell::Number(x) if x.is_finite() => write!(out, "<c{style}><v>{x}</v></c>"),
                Cell::Number(_) => write!(out, "<c{style}/>"),
            };
        }
        out += "</row>";
    }
    out + "</sheetData></worksheet>"
}

/// Components of all forces over time.
fn over_time(runs: &mut Runs) -> Result<(Vec<String>, Vec<Vec<Cell>>), Unreplayed> {
    let (force, time) = (runs.units.of("N"), runs.units.of("s"));
    let has_cases = runs.cases.iter().any(|case| !case.name.is_empty());
    let mut heads = if has_cases { vec!["case".to_owned()] } else { Vec::new() };
    heads.push(format!("t [{}]", time.unit));
    for joint in &runs.cases[0].report.reactions {
        heads.extend(
            ["force", "fx", "fy", "fz"]
                .map(|part| format!("{}.{part} [{}]", joint.name, force.unit)),
        );
    }
    let mut rows = Vec::new();
    for case in &mut runs.cases {
        let peaks: Vec<f64> = case.report.reactions.iter().map(|joint| joint.force.value).collect();
        let span = case.report.span[0].abs().max(case.report.span[1].abs());
        for t in instants(case, INSTANTS) {
            let name = case.name.clone();
            let (reactions, _) = case.bearings(t)?;
            let mut row = if has_cases { vec![Cell::Text(name)] } else { Vec::new() };
            row.push(Cell::Number(six_digits(time.of_si(t), time.of_si(span))));
            for (reaction, peak) in reactions.iter().zip(&peaks) {
                let [fx, fy, fz, ..] = *reaction;
                let scale = force.of_si(*peak);
                let of = |x: f64| Cell::Number(six_digits(force.of_si(x), scale));
                row.extend([fx.hypot(fy).hypot(fz), fx, fy, fz].map(of));
            }
            rows.push(row);
        }
    }
    Ok((heads, rows))
}
