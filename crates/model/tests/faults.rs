//! Every file of `tests/faults` is read; what is said of it stands in the file next to it that ends
//! in `.expected`. To add a case, write the model and run with `BKSIM_UPDATE=1`; then review what
//! was written. A line `# --set name=value` overrides a parameter.

use std::path::{Path, PathBuf};

use bksim_model::cure::{Cure, cures};
use bksim_model::diagnostic::{Diagnostic, Severity, Span};
use bksim_model::file::{Limits, Source, decode, read};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/faults")
}

/// `line:column`, both from one, columns in characters.
fn position(text: &str, place: usize) -> String {
    let before = text.get(..place).expect("places are at characters of the file");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    format!("{line}:{column}")
}

/// All that is said, one fact per line, with the text under each place.
fn rendered(text: &str, diagnostics: &[Diagnostic]) -> String {
    let mut lines = Vec::new();
    for fault in diagnostics {
        let kind = if fault.severity == Severity::Error { "error" } else { "warning" };
        lines.push(format!("{kind}[{}]: {}", fault.code.0, fault.message));
        for label in &fault.labels {
            let Span { start, end } = label.span.clone();
            let under = &text[start..end];
            let under = under.split('\n').next().unwrap_or_default();
            let line = format!("  {} ⟨{under}⟩ {}", position(text, start), label.text);
            lines.push(line.trim_end().to_owned());
        }
        lines.extend(fault.notes.iter().map(|note| format!("  note: {note}")));
        lines.extend(fault.help.iter().map(|help| format!("  help: {help}")));
    }
    lines.join("\n") + "\n"
}

fn overrides(text: &str) -> Vec<(String, String)> {
    let settings = text.lines().filter_map(|line| line.strip_prefix("# --set ")?.split_once('='));
    settings.map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
}

fn said_of(bytes: &[u8]) -> String {
    match decode(bytes) {
        Ok(text) => {
            let overrides = overrides(text);
            let source = Source { overrides: &overrides, ..Source::new(text, "model") };
            let reading = read(&source);
            let is_rejected = reading.diagnostics.iter().any(Diagnostic::is_error);
            assert_eq!(is_rejected, reading.model.is_none(), "{:?}", reading.diagnostics);
            rendered(text, &reading.diagnostics)
        }
        Err(fault) => {
            let text = String::from_utf8_lossy(bytes);
            rendered(&text, &[fault])
        }
    }
}

#[test]
fn every_fault_is_said_as_expected() {
    let mut failures = Vec::new();
    let mut n_cases = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder of faults") {
        let path = entry.expect("a readable folder").path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        n_cases += 1;
        let said = said_of(&std::fs::read(&path).expect("a readable file"));
        let beside = path.with_extension("expected");
        if std::env::var_os("BKSIM_UPDATE").is_some() {
            std::fs::write(&beside, &said).expect("a writable folder");
        }
        let expected = std::fs::read_to_string(&beside).unwrap_or_default();
        if said != expected {
            failures.push(format!("{}\n--- expected\n{expected}--- said\n{said}", path.display()));
        }
    }
    assert!(n_cases > 40, "only {n_cases} cases");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Every help writes something in place of what is at fault: nothing of that fault may be left.
#[test]
fn helps_cure_when_they_are_followed_to_the_letter() {
    let (mut n_followed, mut n_helps, mut failures) = (0, 0, Vec::new());
    for entry in std::fs::read_dir(folder()).expect("the folder of faults") {
        let path = entry.expect("a readable folder").path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let bytes = std::fs::read(&path).expect("a readable file");
        let Ok(text) = decode(&bytes) else { continue };
        let overrides = overrides(text);
        let said = |text: &str| {
            read(&Source { overrides: &overrides, ..Source::new(text, "model") }).diagnostics
        };
        for fault in said(text) {
            n_helps += 1;
            let cures = cures(text, &fault);
            n_followed += usize::from(!cures.is_empty());
            // Of several words in a list the first one is the nearest, the others fit the place.
            let is_list = fault.help.as_ref().is_some_and(|help| help.starts_with("one of"));
            for Cure { span, text: new } in cures.into_iter().take(if is_list { 1 } else { 9 }) {
                let changed = format!("{}{new}{}", &text[..span.start], &text[span.end..]);
                let (before, after) = (said(text), said(&changed));
                let is_same = |other: &&Diagnostic| {
                    (other.code, &other.message) == (fault.code, &fault.message)
                };
                let counted = |all: &[Diagnostic]| all.iter().filter(is_same).count();
                // Nor may what is written be a fault of its own.
                let line = |text: &str, of: &Diagnostic| {
                    of.labels.first().map(|label| text[..label.span.start].matches('\n').count())
                };
                let here = line(text, &fault);
                let is_known =
                    |other: &Diagnostic| before.iter().any(|old| old.message == other.message);
                let is_example =
                    fault.help.as_ref().is_some_and(|help| help.contains("for example"));
                let codes: &[&str] = if is_example {
                    &["M002", "M020"]
                } else {
                    &["M002", "M003", "M005", "M007", "M020", "M022"]
                };
                let is_of_writing = |of: &Diagnostic| codes.contains(&of.code.0);
                let other = after
                    .iter()
                    .find(|of| is_of_writing(of) && line(&changed, of) == here && !is_known(of));
                if counted(&after) >= counted(&before) || other.is_some() {
                    failures.push(format!(
                        "{}: {}\n{:?}\n{}\n{:?}",
                        path.display(),
                        fault.message,
                        fault.help,
                        changed
                            .lines()
                            .zip(text.lines())
                            .find(|(a, b)| a != b)
                            .map_or("unchanged", |(a, _)| a),
                        other.map(|other| &other.message)
                    ));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} of {n_followed}:\n{}", failures.len(), failures.join("\n\n"));
    assert!(n_followed > 120, "only {n_followed} of {n_helps} helps say what to write");
}

#[test]
fn messages_keep_to_the_house_style() {
    for entry in std::fs::read_dir(folder()).expect("the folder of faults") {
        let path = entry.expect("a readable folder").path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let said = said_of(&std::fs::read(&path).expect("a readable file"));
        for line in said.lines() {
            let message = line.split("]: ").nth(1).unwrap_or_default();
            assert!(!message.ends_with('.'), "{}: {line}", path.display());
            for word in ["i64", "f64", "Option", "NaN", "toml::", "Spanned", "panick"] {
                assert!(!line.contains(word), "{}: {line}", path.display());
            }
        }
        for fault in said.split("error[").skip(1) {
            assert!(fault.contains("help: "), "{} has no help:\n{fault}", path.display());
            assert!(fault.lines().count() <= 12, "{} is too long:\n{fault}", path.display());
        }
    }
}

#[test]
fn deep_nesting_is_refused_at_once() {
    let started = std::time::Instant::now();
    let brackets = format!("x = {}", "[".repeat(100_000));
    let said = read(&Source::new(&brackets, "deep")).diagnostics;
    assert_eq!(said.len(), 1, "{said:?}");
    assert_eq!(said[0].labels[0].span, 68..69);
    assert!(said[0].help.as_ref().is_some_and(|help| help.contains("--max-nesting")));

    let (open, close) = ("(".repeat(50_000), ")".repeat(50_000));
    let text = format!("[parameters]\na = \"{open}1{close}\"\n[bodies.b]\nmass = 1\nfree = true\n");
    let said = read(&Source::new(&text, "deep")).diagnostics;
    assert_eq!(said.len(), 1, "{said:?}");
    assert_eq!(said[0].labels[0].span, 13 + 5 + 64..13 + 5 + 65);
    assert!(said[0].help.as_ref().is_some_and(|help| help.contains("--max-nesting")));
    let limits = Limits { nesting: 100_000 };
    let reading = read(&Source { limits, ..Source::new(&text, "deep") });
    assert!(reading.model.is_some(), "{:?}", reading.diagnostics);
    assert!(started.elapsed().as_secs() < 2, "took {:?}", started.elapsed());
}

#[test]
fn long_chains_of_parameters_are_read_in_any_order() {
    let n = 20_000;
    let lines: Vec<String> = (0..n).map(|i| format!("p{i} = \"p{} + 1\"", i + 1)).collect();
    let text = format!(
        "[parameters]\n{}\np{n} = 0\n[bodies.b]\nmass = \"p0\"\nfree = true\n",
        lines.join("\n")
    );
    let reading = read(&Source::new(&text, "chain"));
    let model = reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    assert_eq!(model.parameters.last().map(|p| (p.name.as_str(), p.value)), Some(("p0", 20_000.0)));
}

/// Damages models in many small ways: nothing may panic or hang, and every place must be in the
/// text. The sequence of damages is fixed.
#[test]
fn damaged_models_are_read_without_panic() {
    let mut seed = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = move |below: usize| {
        // xorshift64, Marsaglia (2003).
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        usize::try_from(seed % below.max(1) as u64).expect("below a usize")
    };
    let mut models: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(folder()).expect("the folder of faults") {
        let bytes = std::fs::read(entry.expect("a readable folder").path());
        models.extend(String::from_utf8(bytes.expect("a readable file")).ok());
    }
    models.sort();
    let pieces = [
        "\"", "[", "]", "{", "}", "=", ",", "\n", ".", "-", "(", ")", "nan", "1e999", "t", "θ",
        "'''", "#", " ", "/0", "^", "\"\"\"", "[[", "*", "mass", "0", "ground.", "\\", "= 1\n",
    ];
    for round in 0..3000 {
        let mut text = models[random(models.len())].clone();
        for _ in 0..=random(4) {
            let at = random(text.len() + 1);
            let at = (0..=at).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
            let end = (at + random(12)..=text.len()).find(|&e| text.is_char_boundary(e));
            match random(3) {
                0 => text.insert_str(at, pieces[random(pieces.len())]),
                1 => text.replace_range(at..end.unwrap_or(text.len()), ""),
                _ => {
                    text.replace_range(at..end.unwrap_or(text.len()), pieces[random(pieces.len())]);
                }
            }
        }
        let reading = read(&Source::new(&text, "damaged"));
        let is_rejected = reading.diagnostics.iter().any(Diagnostic::is_error);
        assert_eq!(is_rejected, reading.model.is_none(), "round {round}:\n{text}");
        for cure in reading.diagnostics.iter().flat_map(|fault| cures(&text, fault)) {
            let place = text.get(cure.span.clone());
            assert!(place.is_some(), "round {round}: {cure:?} outside of\n{text}");
        }
        for label in reading.diagnostics.iter().flat_map(|fault| &fault.labels) {
            let place = text.get(label.span.clone());
            assert!(place.is_some(), "round {round}: {label:?} outside of\n{text}");
        }
    }
}
