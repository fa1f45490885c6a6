//! [`Table`]: columns of numbers from a file of CSV, such as measured values, to be drawn next to runs.
//!
//! The first line names the columns, with their units in brackets where they are not those of the SI:
//! `t, A.angle [deg]`. Columns are divided by commas, semicolons or tabs; with semicolons and tabs a comma may be the
//! decimal one. A cell without a number is a gap, and lines that begin with `#` are passed over.

use std::path::{Path, PathBuf};

use bksim::log::{Column, Field, Header, Selection, Topic};
use bksim::model::file::ShownUnit;
use bksim::overview::usual_units;
use bksim_cli::exit::Failure;

/// Headings of the time.
const TIME: [&str; 2] = ["t", "time"];
/// Topic of columns whose names have none.
const TOPIC: &str = "outputs";

/// A file as it was read.
pub(super) struct Table {
    path: PathBuf,
    /// Without the time.
    headings: Vec<Heading>,
    /// Cells of the headings, row by row.
    cells: Vec<Vec<Option<f64>>>,
    /// s; none of a file without a column of that name.
    times: Option<Vec<f64>>,
}

/// The name of a column and the unit in its brackets.
struct Heading {
    name: String,
    unit: Option<String>,
}

/// Rows in SI units, under the topics of a header.
pub(super) struct Rows {
    /// s; NaN where the file has no times, which no span excludes.
    times: Vec<f64>,
    cells: Vec<Vec<Option<f64>>>,
    /// By topic and field, the place in a row.
    places: Vec<Vec<usize>>,
}

/// True of names of such files.
pub(super) fn is_csv(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

impl Table {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, and one with other cells than numbers below its headings.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(|e| Failure::reading(path, &e))?;
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        let divider = ['\t', ';'].into_iter().find(|divider| text.contains(*divider));
        let divider = divider.unwrap_or(',');
        let lines = text.lines().enumerate();
        let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));

        // The headings, of which one may be the time.
        let Some((_, first)) = lines.next() else { return Err(refused(path, "is empty", None)) };
        let mut headings: Vec<Heading> = first.split(divider).map(Heading::of).collect();
        if headings.iter().any(|heading| heading.name.parse::<f64>().is_ok()) {
            let help = "name the columns in the first line: `t, A.angle [deg]`";
            return Err(refused(path, "has no headings", Some(help)));
        }
        let has = |name: &str| headings.iter().any(|heading| heading.name == name);
        if headings.first().is_some_and(|first| first.name == "case") && has("status") {
            let what =
                "is the table of a sweep, which as CSV does not say units and which columns vary";
            let help = "write the sweep with `-o sweep.parquet` and draw that file";
            return Err(refused(path, what, Some(help)));
        }
        let is_time = |h: &Heading| TIME.iter().any(|time| h.name.eq_ignore_ascii_case(time));
        let time = headings.iter().position(is_time);
        let time = time.map(|place| (place, headings.remove(place)));
        let scale = match time.as_ref().and_then(|(_, heading)| heading.unit.as_deref()) {
            None => None,
            Some(text) => Some(unit_of(path, text, "s", "the time")?),
        };

        // The rows.
        let (mut times, mut all) = (Vec::new(), Vec::new());
        for (number, line) in lines {
            let cell = |cell: &str| value(cell, divider).map_err(|cell| bad(path, number, &cell));
            let mut cells = line.split(divider).map(cell).collect::<Result<Vec<_>, _>>()?;
            cells.resize(headings.len() + usize::from(time.is_some()), None);
            let t = match &time {
                None => Some(f64::NAN),
                Some((place, _)) => cells.remove(*place),
            };
            // Without its time a row has no place.
            let Some(t) = t else { continue };
            times.push(scale.as_ref().map_or(t, |unit| unit.to_si(t)));
            all.push(cells);
        }
        let times = time.map(|_| times);
        Ok(Self { path: path.to_owned(), headings, cells: all, times })
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Names of all columns but the time.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.headings.iter().map(|heading| heading.name.as_str())
    }

    /// True where rows have times.
    pub(super) fn has_times(&self) -> bool {
        self.times.is_some()
    }

    /// The table as a header like that of a log, with its rows in SI units. A column has the whole name and the unit of
    /// the channel that it names in one of `others`.
    ///
    /// # Errors
    /// Units that are none, and those of another quantity than the channel of that name.
    pub(super) fn beside(mut self, others: &[&Header]) -> Result<(Header, Rows), Failure> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let mut header = Header::new(&stem, "csv", "", "");
        let mut places: Vec<Vec<usize>> = Vec::new();
        for (place, heading) in self.headings.iter().enumerate() {
            let known = others.iter().find_map(|header| channel(header, &heading.name));
            let (name, si) = match (&known, &heading.unit) {
                (Some(column), _) => (column.name.clone(), column.unit.clone()),
                (None, None) => (heading.whole_name(), String::new()),
                (None, Some(unit)) => (heading.whole_name(), si_of(&self.path, unit)?),
            };
            if let Some(unit) = &heading.unit {
                let unit = unit_of(&self.path, unit, &si, &format!("`{}`", heading.name))?;
                let column = self.cells.iter_mut().filter_map(|row| row[place].as_mut());
                column.for_each(|value| *value = unit.to_si(*value));
            }
            // Columns of one topic stand together.
            let (topic, field) = name.rsplit_once('.').unwrap_or((TOPIC, &name));
            let topic = format!("/{}", topic.replace('.', "/"));
            let topic = header.topic_id(&topic).unwrap_or_else(|| {
                places.push(Vec::new());
                header.add_topic(Topic::new(&topic, []))
            });
            header.topics[topic.index()].fields.push(Field::new(field, &si, ""));
            places[topic.index()].push(place);
        }
        let times = self.times.unwrap_or_else(|| vec![f64::NAN; self.cells.len()]);
        Ok((header, Rows { times, cells: self.cells, places }))
    }
}

impl Heading {
    fn of(cell: &str) -> Self {
        let cell = cell.trim().trim_matches('"').trim();
        let parts = cell.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
        match parts {
            Some((name, unit)) => {
                let unit = Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty());
                Self { name: name.trim().to_owned(), unit }
            }
            None => Self { name: cell.to_owned(), unit: None },
        }
    }

    /// The name with a topic.
    fn whole_name(&self) -> String {
        if self.name.contains('.') { self.name.clone() } else { format!("{TOPIC}.{}", self.name) }
    }
}

impl Rows {
    /// Hands the time of each row and the cells of a selection to `put`.
    pub(super) fn each(&self, selection: &Selection, put: &mut dyn FnMut(f64, &[Option<f64>])) {
        let place = |column: &Column| self.places[column.topic.index()][column.field_idx];
        let places: Vec<usize> = selection.columns().iter().map(place).collect();
        let mut chosen = vec![None; places.len()];
        for (t, cells) in self.times.iter().zip(&self.cells) {
            chosen.iter_mut().zip(&places).for_each(|(cell, &place)| *cell = cells[place]);
            put(*t, &chosen);
        }
    }
}

/// The one channel of this name.
fn channel(header: &Header, name: &str) -> Option<Column> {
    match Selection::new(header, [name]).ok()?.columns() {
        [column] => Some(column.clone()),
        _ => None,
    }
}

/// The number of a cell, none of an empty one; as the error the words in place of a number.
fn value(cell: &str, divider: char) -> Result<Option<f64>, String> {
    let cell = cell.trim().trim_matches('"').trim();
    if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
        return Ok(None);
    }
    let has_comma = divider != ',' && !cell.contains('.');
    let number = if has_comma { cell.replacen(',', ".", 1) } else { cell.to_owned() };
    number.parse().map(Some).map_err(|_| cell.to_owned())
}

/// The unit of a column whose SI unit this is.
fn unit_of(path: &Path, text: &str, si: &str, what: &str) -> Result<ShownUnit, Failure> {
    let unit = ShownUnit::parse(text).ok_or_else(|| no_unit(path, text))?;
    if unit.measures(si) {
        return Ok(unit);
    }
    let si = if si.is_empty() { "a plain number" } else { si };
    let why = format!("gives {what} in {text}, which is {si} elsewhere");
    Err(refused(path, &why, Some("name a unit of the same quantity in the brackets")))
}

/// The SI unit of the quantity that a unit measures.
fn si_of(path: &Path, text: &str) -> Result<String, Failure> {
    let unit = ShownUnit::parse(text).ok_or_else(|| no_unit(path, text))?;
    let found = usual_units().find(|si| unit.measures(si));
    found.map(str::to_owned).ok_or_else(|| {
        refused(path, &format!("has a column in {text}, which no channel is in"), None)
    })
}

fn no_unit(path: &Path, text: &str) -> Failure {
    let help = "write a unit in the brackets, such as `A.angle [deg]`";
    refused(path, &format!("has a heading with `{text}`, which is no unit"), Some(help))
}

fn bad(path: &Path, line_idx: usize, cell: &str) -> Failure {
    let what = format!("has `{cell}` in line {} where a number is expected", line_idx + 1);
    refused(path, &what, Some("leave out cells without a value, and divide cells by commas"))
}

fn refused(path: &Path, what: &str, help: Option<&str>) -> Failure {
    Failure::Input { path: path.to_owned(), what: what.to_owned(), help: help.map(str::to_owned) }
}
