//! The AutoLISP file: no interpreter runs it here, but it is whole and writes what is read.

use bksim_cad::kind::by_name;

const LISP: &str = include_str!("../../../lisp/bksim.lsp");

/// The text without comments, with `""` for every string.
fn code_and_strings(text: &str) -> (String, Vec<String>) {
    let (mut code, mut strings) = (String::new(), Vec::new());
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        match letter {
            ';' => {
                letters.by_ref().find(|&c| c == '\n');
            }
            '"' => {
                let mut string = String::new();
                while let Some(c) = letters.next().filter(|&c| c != '"') {
                    string.push(c);
                    if c == '\\' {
                        string.extend(letters.next());
                    }
                }
                strings.push(string);
                code.push_str("\"\"");
            }
            _ => code.push(letter),
        }
    }
    (code, strings)
}

#[test]
fn parentheses_close_at_the_end_of_every_definition() {
    let (code, _) = code_and_strings(LISP);
    let mut depth = 0;
    for line in code.lines() {
        if line.starts_with("(defun") {
            assert_eq!(depth, 0, "{line}");
        }
        depth += line.matches('(').count();
        let closed = line.matches(')').count();
        assert!(depth >= closed, "{line}");
        depth -= closed;
    }
    assert_eq!(depth, 0);
}

#[test]
fn all_commands_are_defined_and_their_keys_are_known() {
    for command in ["BKBODY", "BKJOINT", "BKDRIVE", "BKDEL", "BKLIST", "BKCMP", "BKSOLVE"] {
        assert!(LISP.contains(&format!("(defun c:{command} ")), "{command}");
    }
    let part = |from: &str, to: &str| {
        let start = LISP.find(from).expect("a command");
        let end = LISP[start..].find(to).expect("the next command");
        &LISP[start..start + end]
    };
    let keys = |kind: &str, text: &str| {
        let kind = by_name(kind).expect("a kind");
        let keys: Vec<&str> =
            text.split("(bk:entry \"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(!keys.is_empty());
        for key in keys {
            assert!(kind.keys.contains(&key), "{} has no key {key}", kind.name);
        }
    };
    keys("body", part("c:BKBODY", "c:BKJOINT"));
    for kind in ["revolute", "prismatic", "slot", "weld"] {
        keys(kind, part("c:BKJOINT", "c:BKDRIVE"));
    }
    keys("drive", part("c:BKDRIVE", "c:BKDEL"));
}
