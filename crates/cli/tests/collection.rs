//! Inputs that were once answered wrongly, refused without need, or explained badly: each is run as its author ran it.
//!
//! `collection/*.rows` hold models and drawings with what is right; `collection/*.inputs` hold faulty ones, which are
//! scored by five points. A case begins with `== NAME`, then keys, then its files, each below `--- FILE`:
//!
//! ```text
//! run: ARGUMENTS        the command; the last run counts for `exit`
//! exit: STATUS          0 unless stated
//! says: TEXT            what is printed by any run; blanks and line ends count alike
//! once: TEXT            what is printed once
//! not: TEXT             what is not printed
//! at: FILE:LINE:COLUMN  the place (faulty inputs)
//! code: M044            every fault that is said, in order (faulty inputs)
//! cure: OLD => NEW      what the help asks for; NEW is in it to the letter
//! follow: OLD => NEW    the same for a help that leaves the text to the author
//! in: FILE              the file that the cure changes, the first one unless stated
//! send: TEXT            what standard input gives
//! ```
//!
//! Words after the name of a file: `escaped` writes letters as `\u{a0}`, `cr` ends lines by CR, `utf16` is an encoding,
//! `hex` lists bytes, `dxf` has groups divided by bars, `link` is a link to what is written.
//!
//! ```console
//! $ cargo test --workspace --test cli collection -- --nocapture
//! ```

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;
use std::{fs, thread};

use crate::common::{CRATE, Scratch, text};

#[derive(Default)]
struct Case {
    name: String,
    keys: Vec<(String, String)>,
    /// Names, how they are written, and content.
    files: Vec<(String, String, String)>,
}

impl Case {
    fn all<'c>(&'c self, key: &'c str) -> impl Iterator<Item = &'c str> {
        self.keys.iter().filter(move |(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    fn one<'c>(&'c self, key: &'c str) -> Option<&'c str> {
        self.all(key).next()
    }
}

/// All cases of the files with this ending.
fn cases(ending: &str) -> Vec<Case> {
    let folder = fs::read_dir(Path::new(CRATE).join("tests/collection")).expect("the folder");
    let mut paths: Vec<_> = folder.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|it| it == ending));
    paths.sort();
    let mut found: Vec<Case> = Vec::new();
    for line in paths.iter().flat_map(|path| {
        let text = fs::read_to_string(path).expect("a file of cases");
        text.lines().map(str::to_owned).collect::<Vec<_>>()
    }) {
        if let Some(name) = line.strip_prefix("== ") {
            found.push(Case { name: name.to_owned(), ..Case::default() });
            continue;
        }
        let Some(case) = found.last_mut() else { continue };
        if let Some(file) = line.strip_prefix("--- ") {
            let (name, form) = file.split_once(' ').unwrap_or((file, ""));
            case.files.push((name.to_owned(), form.to_owned(), String::new()));
        } else if let Some((_, _, content)) = case.files.last_mut() {
            content.push_str(&line);
            content.push('\n');
        } else if !line.is_empty() && !line.starts_with('#') {
            let (key, value) = line.split_once(": ").expect("`key: value`");
            case.keys.push((key.to_owned(), value.to_owned()));
        }
    }
    found
}

/// A text with letters that are written as `\u{a0}` put in.
fn unescaped(text: &str) -> String {
    let mut parts = text.split("\\u{");
    let mut found = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (digits, rest) = part.split_once('}').expect("a closed escape");
        let letter = u32::from_str_radix(digits, 16).ok().and_then(char::from_u32);
        found.push(letter.expect("a letter"));
        found.push_str(rest);
    }
    found
}

fn write(place: &Scratch, name: &str, form: &str, content: &str) {
    match form {
        "link" => {
            let made = std::os::unix::fs::symlink(content.trim(), place.path().join(name));
            made.expect("a link");
        }
        "" => place.write(name, content),
        "escaped" => place.write(name, unescaped(content)),
        "cr" => place.write(name, content.replace('\n', "\r")),
        "utf16" => {
            let units = std::iter::once(0xfeff).chain(content.encode_utf16());
            place.write(name, units.flat_map(u16::to_le_bytes).collect::<Vec<u8>>());
        }
        "hex" => {
            let bytes = content.split_whitespace();
            let bytes = bytes.map(|byte| u8::from_str_radix(byte, 16).expect("hexadecimal"));
            place.write(name, bytes.collect::<Vec<u8>>());
        }
        "dxf" => {
            let groups = content.split(['|', '\n']).filter(|group| !group.is_empty());
            let lines = groups.map(|group| {
                let (code, value) = group.split_once(' ').unwrap_or((group, ""));
                format!("{code}\n{value}\n")
            });
            place.write(name, lines.collect::<String>());
        }
        other => panic!("unknown form `{other}`"),
    }
}

/// One blank between all words.
fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Output of the runs of a case, and the last exit status.
fn printed(case: &Case, place: &Scratch) -> (String, Option<i32>) {
    let (mut all, mut status) = (String::new(), None);
    for run in case.all("run") {
        let mut command = place.bksim();
        command.args(arguments(run)).stdin(Stdio::piped());
        let mut child =
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("bksim starts");
        let mut stdin = child.stdin.take().expect("a pipe");
        let sent = case.one("send").unwrap_or_default().replace("\\r\\n", "\r\n");
        // A program that needs no input closes it.
        let _ = stdin.write_all(sent.as_bytes());
        drop(stdin);
        let output = child.wait_with_output().expect("bksim ends");
        let _ = write!(all, "{}{}", text(&output.stdout), text(&output.stderr));
        status = output.status.code();
    }
    (all, status)
}

/// Arguments divided by blanks, those in double quotes kept together.
fn arguments(line: &str) -> Vec<String> {
    let pieces = line.split('"').enumerate();
    let arguments = pieces.flat_map(|(i, piece)| match i % 2 {
        0 => piece.split_whitespace().map(str::to_owned).collect(),
        _ => vec![piece.to_owned()],
    });
    arguments.collect()
}

fn placed(case: &Case) -> Scratch {
    let place = Scratch::new();
    for (name, form, content) in &case.files {
        write(&place, name, form, content);
    }
    place
}

/// Texts that are missing in an output, said twice or said where they must not be.
fn missing(case: &Case, said: &str) -> Vec<String> {
    let said = words(said);
    let says = case.all("says").filter(|it| !said.contains(&words(it)));
    let once = case.all("once").filter(|it| said.matches(&words(it)).count() != 1);
    let not = case.all("not").filter(|it| said.contains(&words(it)));
    let says = says.map(|it| format!("`{it}` is missing"));
    let once = once.map(|it| format!("`{it}` is not said once"));
    says.chain(once).chain(not.map(|it| format!("`{it}` is said"))).collect()
}

/// The results of a function for all cases, on four threads.
fn each<T: Send>(cases: &[Case], of: impl Fn(&Case) -> T + Sync) -> Vec<T> {
    let share = cases.len().div_ceil(4).max(1);
    thread::scope(|scope| {
        let of = &of;
        let parts = cases.chunks(share);
        let parts = parts.map(|part| scope.spawn(move || part.iter().map(of).collect::<Vec<T>>()));
        let parts: Vec<_> = parts.collect();
        parts.into_iter().flat_map(|part| part.join().expect("a part")).collect()
    })
}

#[test]
#[expect(clippy::print_stdout, reason = "the verdicts are worth reading")]
fn every_row_of_the_collection_is_right() {
    let cases = cases("rows");
    assert!(cases.len() > 40, "only {} rows", cases.len());
    let wrong = each(&cases, |case| {
        let place = placed(case);
        let (said, status) = printed(case, &place);
        let mut wrong = missing(case, &said);
        let exit = case.one("exit").map_or(0, |it| it.parse().expect("a status"));
        if status != Some(exit) {
            wrong.push(format!("exit {status:?} instead of {exit}"));
        }
        let verdict = if wrong.is_empty() { "right".to_owned() } else { wrong.join("; ") };
        println!("{:34} {verdict}", case.name);
        if wrong.is_empty() { String::new() } else { format!("{}: {verdict}\n{said}", case.name) }
    });
    let wrong: Vec<_> = wrong.into_iter().filter(|it| !it.is_empty()).collect();
    assert!(wrong.is_empty(), "{} rows are wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// Codes of all that is said about the input, in order.
fn codes(said: &str) -> Vec<&str> {
    let lines = said.lines().filter_map(|line| {
        let rest = ["error[", "warning[", "note["].iter().find_map(|it| line.strip_prefix(it))?;
        Some(rest.split_once(']')?.0)
    });
    lines.collect()
}

/// True if what the help asks for takes every fault away.
fn is_cured(case: &Case, said: &str) -> bool {
    let asked = case.all("cure").map(|it| (true, it));
    let mut asked = asked.chain(case.all("follow").map(|it| (false, it))).peekable();
    if asked.peek().is_none() {
        return codes(said).is_empty();
    }
    let place = placed(case);
    let helps = said.lines().filter_map(|line| line.split_once("= help: "));
    let helps = words(&helps.map(|(_, help)| help).collect::<Vec<_>>().join(" "));
    for (is_literal, change) in asked {
        let (old, new) = change.split_once(" =>").expect("`OLD => NEW`");
        let new = new.trim_start();
        let name = case.one("in").unwrap_or(&case.files[0].0);
        let path = place.path().join(name);
        if is_literal && !helps.contains(&words(new)) {
            return false;
        }
        match new {
            // Encodings and links are mended by writing the file again.
            "UTF-8" => {
                let (_, _, content) =
                    case.files.iter().find(|(it, ..)| it == name).expect("the file");
                place.write(name, content);
            }
            "a file" => {
                fs::remove_file(&path).expect("the link");
                place.write(name, "[bodies.p]\nmass = 1\nfree = true\n");
            }
            _ => {
                let before = fs::read_to_string(&path).expect("a text");
                let [old, new] = [old, new].map(|it| unescaped(it).replace("\\n", "\n"));
                assert!(before.contains(&old), "{}: `{old}` is not in {name}", case.name);
                place.write(name, before.replacen(&old, &new, 1));
            }
        }
    }
    let (after, status) = printed(case, &place);
    status == Some(0) && codes(&after).iter().all(|code| !codes(said).contains(code))
}

#[test]
#[expect(clippy::print_stdout, reason = "the table of scores is worth reading")]
fn faulty_inputs_have_five_points_of_five() {
    let cases = cases("inputs");
    assert!(cases.len() > 40, "only {} inputs", cases.len());
    let scores = each(&cases, |case| {
        let place = placed(case);
        let (said, status) = printed(case, &place);
        let exit = case.one("exit").map_or(0, |it| it.parse().expect("a status"));
        let is_placed = case.all("at").all(|at| said.contains(&format!("--> {at}\n")));
        let expected: Vec<&str> = case.all("code").collect();
        let missing = missing(case, &said);
        let points = [
            status == Some(exit),
            is_placed,
            missing.is_empty(),
            is_cured(case, &said),
            codes(&said) == expected,
        ];
        let lost = if points.contains(&false) {
            format!("{}\n{said}", missing.join("; "))
        } else {
            String::new()
        };
        (points, lost)
    });
    println!("{:30} exit place what help only points", "input");
    let mut sum = 0;
    for (case, (points, _)) in cases.iter().zip(&scores) {
        let n = points.iter().filter(|it| **it).count();
        sum += n;
        let [a, b, c, d, e] = points.map(u8::from);
        println!("{:30} {a:4} {b:5} {c:4} {d:4} {e:4} {n:6}", case.name);
    }
    println!("{sum} of {} points", 5 * cases.len());
    let lost = cases.iter().zip(&scores).filter(|(_, (_, lost))| !lost.is_empty());
    let lost: Vec<_> =
        lost.map(|(case, (points, lost))| format!("{} {points:?}: {lost}", case.name)).collect();
    assert_eq!(sum, 5 * cases.len(), "{}", lost.join("\n"));
}
