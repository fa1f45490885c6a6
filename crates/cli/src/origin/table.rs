//! Tables of CSV that bksim wrote: known by their headings and by how their numbers are written.

use std::fs::File;
use std::io;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord};

/// Columns of words, not of numbers.
const WORDS: [&str; 3] = ["status", "code", "reason"];

/// True for a table all of whose headings, units aside, are among `known`, and whose numbers are as bksim writes
/// them.
pub fn has_headings(path: &Path, known: &dyn Fn(&str) -> bool) -> bool {
    read(path, known).unwrap_or(false)
}

/// True for a table of numbers as bksim writes them, whatever its headings.
pub fn is_table(path: &Path) -> bool {
    has_headings(path, &|_| true)
}

/// The headings of a table, units aside; none of a file that is not one.
pub fn headings(path: &Path) -> Vec<String> {
    let first = open(path).and_then(|mut table| Ok(table.headers()?.clone()));
    let name = |heading: &str| without_unit(heading).to_owned();
    first.map(|first| first.iter().map(name).collect()).unwrap_or_default()
}

fn open(path: &Path) -> io::Result<csv::Reader<File>> {
    let file = File::open(path)?;
    // Nothing but a file can be replaced.
    if !file.metadata()?.is_file() {
        return Err(io::ErrorKind::Unsupported.into());
    }
    Ok(ReaderBuilder::new().from_reader(file))
}

fn read(path: &Path, known: &dyn Fn(&str) -> bool) -> io::Result<bool> {
    let mut table = open(path)?;
    let headings = table.headers()?.clone();
    let names: Vec<&str> = headings.iter().map(without_unit).collect();
    if names.is_empty() || !names.iter().all(|name| !name.is_empty() && known(name)) {
        return Ok(false);
    }
    let mut row = StringRecord::new();
    while table.read_record(&mut row)? {
        let mut cells = names.iter().zip(row.iter());
        if !cells.all(|(name, cell)| WORDS.contains(name) || is_own_number(cell)) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The name in a heading such as `A.angle [deg]`.
fn without_unit(heading: &str) -> &str {
    heading
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once(" ["))
        .map_or(heading, |(name, _)| name)
}

/// True for an empty cell, and for a number in the fewest digits that tell it.
fn is_own_number(cell: &str) -> bool {
    let Ok(value) = cell.parse::<f64>() else { return cell.is_empty() };
    if !value.is_finite() {
        return true;
    }
    let mantissa = cell.split(['e', 'E']).next().unwrap_or_default();
    let has_idle_zeros =
        mantissa.rsplit_once('.').is_some_and(|(_, part)| part.len() > 1 && part.ends_with('0'));
    let digits = |text: &str| -> String {
        let all: String = text.chars().filter(char::is_ascii_digit).collect();
        all.trim_matches('0').to_owned()
    };
    let shortest = format!("{value:e}");
    let shortest = shortest.split('e').next().unwrap_or_default();
    !has_idle_zeros && !cell.starts_with('+') && digits(mantissa) == digits(shortest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_table_is_known_by_its_headings_and_its_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        for (content, is_own) in [
            ("t,state.x\n0,1\n", true),
            ("t,state.x\n0.0,0.00001234\n1e-7,\n0.1,NaN\n", true),
            ("t,state.x [mm]\n-12.5,1e300\n", true),
            ("t\n", true),
            ("t,state.y\n0,1\n", false),
            ("t,state.x\n0,1,2\n", false),
            ("t,state.x\n0,1.50\n", false),
            ("t,state.x\n0,+1\n", false),
            ("t,state.x\n0,0.30000000000000000001\n", false),
            ("t,state.x\n0,one\n", false),
            ("t,status,reason\n0,stopped,\"late, but not long\"\n", true),
            ("t,\n0,1\n", false),
            ("", false),
        ] {
            fs::write(&path, content).expect("written");
            let known =
                |name: &str| ["t", "state.x", "state.v", "status", "reason"].contains(&name);
            assert_eq!(has_headings(&path, &known), is_own, "{content:?}");
        }
        fs::write(&path, "any,thing\n1,2\n").expect("written");
        assert!(is_table(&path) && !is_table(folder.path()));
    }

    #[test]
    fn every_number_that_is_written_is_known_again() {
        let mut value = 1.0_f64;
        for k in 0..2000 {
            value = (value * 1.7 + f64::from(k)).sin() * 10.0_f64.powi(k % 40 - 20);
            for text in [value.to_string(), format!("{value:?}"), format!("{value:e}")] {
                assert!(is_own_number(&text), "{text}");
            }
        }
    }
}
