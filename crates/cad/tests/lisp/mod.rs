//! The AutoLISP file, run by a small interpreter: what its commands attach is read as it was answered.

mod editor;
mod interpreter;

use bksim_cad::attach::attachments;
use bksim_cad::attachment::Attachment;
use bksim_cad::drawing::{Drawing, Entity, LengthUnit, Location, Shape, XValue};
use bksim_cad::excerpt::Excerpts;
use bksim_cad::kind::{KINDS, Placement};
use interpreter::{Answer, Lisp, V, cons, items, list};

const LISP: &str = include_str!("../../../../lisp/bksim.lsp");

/// The editor with the file loaded and two lines drawn.
fn editor() -> Lisp {
    let mut lisp = Lisp::default();
    lisp.load(LISP);
    for _ in 0..2 {
        let line = [cons(V::Int(0), V::Str("LINE".into())), cons(V::Int(8), V::Str("0".into()))];
        lisp.entities.push(Some(list(line)));
    }
    lisp
}

/// The extended data of an entity as they are read out of a file.
fn xdata(groups: &V) -> Vec<XValue> {
    let head = |value: &V| items(value).into_iter().next().unwrap_or(V::Nil);
    let data = items(groups).into_iter().find(|it| head(it) == V::Int(-3));
    let Some(data) = data else { return Vec::new() };
    let ours = items(&items(&data)[1]);
    assert_eq!(ours[0], V::Str("BKSIM".into()));
    let point = |value: &V| {
        let numbers = items(value);
        let number = |idx: usize| match numbers.get(idx) {
            Some(V::Real(number)) => *number,
            other => panic!("a coordinate: {other:?}"),
        };
        [number(1), number(2)]
    };
    let value = |group: &V| {
        let V::Cons(pair) = group else { panic!("a group: {group:?}") };
        match (&pair.0, &pair.1) {
            (V::Int(1000), V::Str(text)) => XValue::Text(text.clone()),
            (V::Int(1002), V::Str(brace)) if brace == "{" => XValue::Open,
            (V::Int(1002), V::Str(_)) => XValue::Close,
            (V::Int(1011), _) => XValue::Point(point(group)),
            (V::Int(1013), _) => XValue::Direction(point(group)),
            (V::Int(1040), V::Real(number)) => XValue::Number(*number),
            other => panic!("a value: {other:?}"),
        }
    };
    ours[1..].iter().map(value).collect()
}

/// Attachments to the drawing of an editor.
fn attached(lisp: &Lisp) -> Vec<Attachment> {
    let (kind, layer) = ("LINE".to_owned(), "0".to_owned());
    let location = Location { kind, handle: None, layer, at: [0.0; 2], lines: None };
    let entity = |groups: &V| Entity {
        location: location.clone(),
        shape: Shape::Other,
        xdata: xdata(groups),
    };
    let entities = lisp.entities.iter().flatten().map(entity).collect();
    let unit = LengthUnit { name: "mm", metres: 1e-3 };
    let drawing = Drawing { unit, entities, extent: [[0.0; 2]; 2] };
    let (found, faults) = attachments(&drawing, &Excerpts::default());
    assert!(faults.is_empty(), "{faults:#?}");
    found
}

/// The command of a kind.
fn command(kind: &str) -> String {
    if kind == "solve" { "BKSETUP".to_owned() } else { format!("BK{}", kind.to_uppercase()) }
}

/// The texts that a kind's keys are answered with.
const WORDS: [&str; 15] =
    ["k0", "k1", "k2", "k3", "k4", "k5", "k6", "k7", "k8", "k9", "k10", "k11", "k12", "k13", "k14"];

#[test]
fn every_kind_has_a_command_that_attaches_all_of_its_keys_and_its_place() {
    for kind in KINDS {
        let mut lisp = editor();
        let mut answers = vec![Answer::Pick(0)];
        answers.extend(WORDS[..kind.keys.len()].iter().map(|word| Answer::Text(word)));
        if kind.name != "body" && kind.placement != Placement::Anywhere {
            answers.push(Answer::Point([10.0, 20.0]));
            if kind.placement != Placement::Point {
                answers.push(Answer::Point([13.0, 24.0]));
            }
        }
        lisp.run(&command(kind.name), &answers).unwrap_or_else(|e| panic!("{}: {e:?}", kind.name));
        let found = attached(&lisp);
        let [one] = found.as_slice() else { panic!("{}: {found:#?}", kind.name) };
        assert_eq!((one.kind.name, one.entity_idx), (kind.name, 0));
        let stated: Vec<(&str, &str)> =
            one.values.iter().map(|it| (it.key, one.text(it.key).unwrap_or(""))).collect();
        let expected: Vec<(&str, &str)> = kind.keys.iter().copied().zip(WORDS).collect();
        assert_eq!(stated, expected);
        if kind.name != "body" && kind.placement != Placement::Anywhere {
            assert_eq!(one.at, Some([10.0, 20.0]), "{}", kind.name);
        }
        assert_eq!(one.to, (kind.placement == Placement::Line).then_some([13.0, 24.0]));
        assert_eq!(one.axis, (kind.placement == Placement::Frame).then_some([3.0, 4.0]));
        assert_eq!(lisp.commands, ["_.UNDO _Begin", "_.UNDO _End"], "{}", kind.name);
    }
}

const PIN: [Answer; 12] = {
    use Answer::{Nothing, Pick, Point, Text};
    [
        Pick(0),
        Text("A"),
        Text("crank"),
        Nothing,
        Nothing,
        Nothing,
        Nothing,
        Nothing,
        Nothing,
        Text("2 rad/s"),
        Nothing,
        Point([5.0, 6.0]),
    ]
};

#[test]
fn what_has_the_same_name_is_changed_and_not_doubled() {
    let mut lisp = editor();
    lisp.run("BKREVOLUTE", &PIN).expect("a joint");
    // Enter keeps what is there; a point removes it.
    let mut again = PIN.to_vec();
    again[2] = Answer::Text("lever");
    again[9] = Answer::Text(".");
    again[11] = Answer::Nothing;
    lisp.run("BKREVOLUTE", &again).expect("the same joint");
    let found = attached(&lisp);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!((found[0].text("body1"), found[0].text("rate")), (Some("lever"), None));
    assert_eq!(found[0].at, Some([5.0, 6.0]));
    // Another name is another joint; so is another kind.
    again[1] = Answer::Text("B");
    lisp.run("BKREVOLUTE", &again).expect("another joint");
    assert_eq!(attached(&lisp).len(), 2);
}

#[test]
fn records_are_edited_listed_and_removed_one_by_one() {
    use Answer::{Nothing, Number, Pick, Text};
    let mut lisp = editor();
    lisp.run("BKREVOLUTE", &PIN).expect("a joint");
    let drive = [Pick(0), Text("motor"), Text("A"), Nothing, Text("60 rpm*t"), Nothing];
    lisp.run("BKDRIVE", &drive).expect("a drive");
    // Renamed, it is still the same one.
    let edit = [Pick(0), Number(2), Text("engine"), Nothing, Nothing, Text("50 rpm*t"), Nothing];
    lisp.run("BKEDIT", &edit).expect("an edit");
    let found = attached(&lisp);
    let motions: Vec<_> = found.iter().map(|it| (it.text("name"), it.text("motion"))).collect();
    assert_eq!(motions, [(Some("A"), None), (Some("engine"), Some("50 rpm*t"))]);
    lisp.printed.clear();
    lisp.run("BKLIST", &[Pick(0)]).expect("a list");
    assert!(
        lisp.printed.contains("revolute A") && lisp.printed.contains("motion=50 rpm*t"),
        "{}",
        lisp.printed
    );
    lisp.run("BKDEL", &[Pick(0), Number(1)]).expect("one is removed");
    assert_eq!(attached(&lisp).len(), 1);
    lisp.run("BKDEL", &[Pick(0)]).expect("the last one is removed");
    assert_eq!(attached(&lisp).len(), 0);
}

#[test]
fn a_command_that_is_cancelled_or_fails_leaves_the_drawing_as_it_was() {
    let mut lisp = editor();
    lisp.run("BKREVOLUTE", &PIN).expect("a joint");
    let before = lisp.entities.clone();
    lisp.printed.clear();
    let mut cancelled = PIN[..5].to_vec();
    cancelled.push(Answer::Cancel);
    assert!(lisp.run("BKREVOLUTE", &cancelled).is_err());
    assert_eq!(lisp.entities, before);
    assert_eq!(lisp.printed, "", "cancelling needs no word");
    assert!(
        lisp.commands.ends_with(&["_.UNDO _End".to_owned(), "_.U".to_owned()]),
        "{:?}",
        lisp.commands
    );
    // A failure in the middle of it, after something was stored.
    lisp.load("(defun bk:mark (record) (car (entget 1)))");
    assert!(lisp.run("BKREVOLUTE", &PIN).is_err());
    assert_eq!(lisp.entities, before);
    assert!(lisp.printed.contains("bksim: bad argument type"), "{}", lisp.printed);
}

#[test]
fn markers_stand_where_things_are_attached_and_go_again() {
    let mut lisp = editor();
    lisp.run("BKREVOLUTE", &PIN).expect("a joint");
    let texts = |lisp: &Lisp| {
        lisp.entities.iter().flatten().filter(|it| format!("{it:?}").contains("BK_MARKS")).count()
    };
    assert_eq!(texts(&lisp), 1);
    lisp.run("BKMARK", &[]).expect("markers");
    assert_eq!(texts(&lisp), 1, "drawn anew, not twice");
    lisp.run("BKUNMARK", &[]).expect("no markers");
    assert_eq!(texts(&lisp), 0);
}

#[test]
fn any_kind_is_asked_for_by_its_name_and_the_program_is_run_on_the_saved_file() {
    let mut lisp = editor();
    let mut answers = vec![Answer::Text("Revolute")];
    answers.extend(PIN);
    lisp.run("BKADD", &answers).expect("a joint");
    assert_eq!(attached(&lisp)[0].kind.name, "revolute");
    lisp.run("BKADD", &[Answer::Text("hinge")]).expect("an answer");
    assert!(lisp.printed.contains("`hinge` is no kind; kinds are ground body"), "{}", lisp.printed);
    lisp.commands.clear();
    lisp.run("BKDOCTOR", &[]).expect("a run");
    assert_eq!(lisp.commands, ["_.QSAVE", "cmd.exe /k bksim cad doctor \"C:\\work\\press.dwg\""]);
}

#[test]
fn the_table_of_kinds_is_that_of_the_program() {
    let rows = items(&editor().variable("bk:kinds"));
    assert_eq!(rows.len(), KINDS.len());
    for (row, kind) in rows.iter().zip(KINDS) {
        let parts = items(row);
        let place = match kind.placement {
            Placement::Anywhere => V::Nil,
            Placement::Point => V::Sym("point".into()),
            Placement::Frame => V::Sym("frame".into()),
            Placement::Line => V::Sym("line".into()),
        };
        let keys: Vec<V> = kind.keys.iter().map(|key| V::Str((*key).to_owned())).collect();
        assert_eq!((parts[0].clone(), parts[1].clone()), (V::Str(kind.name.into()), place));
        assert_eq!(parts[2..], keys, "{}", kind.name);
    }
}
