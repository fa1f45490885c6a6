//! Drawings of each version and container are opened alike, and damaged ones are answered.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use acadrust::types::DxfVersion;
use acadrust::{CadDocument, DwgWriter, DxfReader, EntityType};
use bksim_cad::codes;
use bksim_cad::container::Container;
use bksim_cad::drawing::Handle;
use bksim_cad::model::{ModelOptions, sheet};
use bksim_cad::open::{OpenOptions, Opened, open};
use bksim_cad::tags::excerpt_text;
use bksim_model::diagnostic::Diagnostic;

const DRAWINGS: [&str; 6] =
    ["R12.dxf", "R12_binary.dxf", "R2000.dxf", "R2010.dxf", "R2010_binary.dxf", "R2018.dxf"];

fn drawing(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/drawings").join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn text(name: &str) -> String {
    String::from_utf8_lossy(&drawing(name)).into_owned()
}

fn in_mm() -> OpenOptions {
    OpenOptions { unit: bksim_cad::units::by_name("mm"), ..OpenOptions::default() }
}

fn opened(bytes: Vec<u8>) -> Opened {
    open(bytes, &in_mm()).expect("the drawing opens")
}

fn faults(text: &str) -> Vec<Diagnostic> {
    open(text.as_bytes().to_vec(), &in_mm()).expect_err("the drawing is rejected")
}

/// Kind, handle, layer and geometry of the entities of each block, in order.
fn contents(document: &CadDocument) -> Vec<String> {
    let mut lines = Vec::new();
    for block in document.block_records.iter().filter(|block| block.name != "*Paper_Space") {
        for handle in &block.entity_handles {
            let entity = document.get_entity(*handle).expect("an entity of its block");
            let head = format!("{} {:X} {}", block.name, handle.value(), entity.common().layer);
            lines.push(format!("{head} {}", geometry(entity)));
        }
    }
    lines
}

/// The fields of an entity after those all entities have; those of other kinds by their name.
fn geometry(entity: &EntityType) -> String {
    let all = format!("{entity:?}");
    let name = all.split('(').next().unwrap_or_default().to_owned();
    match entity {
        EntityType::Dimension(_) | EntityType::Solid(_) => name,
        EntityType::MText(text) => {
            format!("MText {:?} {} {}", text.insertion_point, text.height, text.value)
        }
        EntityType::Insert(insert) => {
            let values: Vec<_> = insert.attributes.iter().map(|it| (&it.tag, &it.value)).collect();
            let (point, turn) = (insert.insert_point, insert.rotation);
            let copies = [insert.column_count, insert.row_count];
            format!("Insert {} {point:?} {turn} {copies:?} {values:?}", insert.block_name)
        }
        _ => {
            let own = all.split_once("raw_record: None }").map_or("", |(_, own)| own);
            // The rest are bits of the DWG format.
            format!("{name}{}", own.split(", dwg_flags").next().unwrap_or_default())
        }
    }
}

#[test]
fn what_is_left_out_changes_nothing_of_what_is_read() {
    for name in DRAWINGS {
        let reader = DxfReader::from_reader(Cursor::new(drawing(name))).expect(name);
        let whole = contents(&reader.read().expect(name));
        assert!(whole.len() > 10, "{name}: {} entities", whole.len());
        assert_eq!(contents(&opened(drawing(name)).document), whole, "{name}");
    }
}

#[test]
fn a_dwg_reads_as_the_dxf_it_was_made_from() {
    for version in [DxfVersion::AC1015, DxfVersion::AC1024, DxfVersion::AC1032] {
        let reader = DxfReader::from_reader(Cursor::new(drawing("R2010.dxf"))).expect("a reader");
        let mut document = reader.read().expect("a drawing");
        document.version = version;
        let dwg = DwgWriter::write_to_vec(&document).expect("a DWG");
        let read = opened(dwg);
        assert!(matches!(read.container, Container::Dwg(_)), "{:?}", read.container);
        let geometry = |document: &CadDocument| -> Vec<String> {
            contents(document).into_iter().filter(|line| line.starts_with("*Model_Space")).collect()
        };
        assert_eq!(geometry(&read.document), geometry(&document), "{version:?}");
        // AC1015 links the attributes of an insert from the first to the last, the others list them.
        let has_values = |line: &String| line.contains("Insert ") && !line.ends_with("[]");
        assert!(geometry(&read.document).iter().any(has_values), "{version:?}");
        assert_eq!(read.tags.lines_of(Handle(0x33)), None);
    }
}

#[test]
fn words_come_out_of_the_code_page_escapes_and_utf8() {
    for name in DRAWINGS {
        let read = opened(drawing(name));
        let found = read.document.entities().find_map(|entity| match entity {
            EntityType::Text(text) => Some(text.value.clone()),
            _ => None,
        });
        assert_eq!(found.as_deref(), Some("żółw é"), "{name}");
        let scanned = (0..read.tags.len()).any(|idx| read.tags.text(idx) == "żółw é");
        assert!(scanned, "{name}: the groups do not say the same");
    }
}

#[test]
fn code_pages_are_those_of_the_header() {
    let cases: [(&str, &[u8], &str); 3] = [
        ("ANSI_1250", b"\xbf\xf3\xb3w", "żółw"),
        ("ANSI_932", b"\x93\xfa\x96\x7b", "日本"),
        ("ANSI_1251", b"\xd0\xfb\xf7\xe0\xe3", "Рычаг"),
    ];
    let bytes = drawing("R2000.dxf");
    let old = b"\\U+017c\xf3\\U+0142w \xe9";
    let at = bytes.windows(old.len()).position(|part| part == old).expect("the text");
    for (page, raw, expected) in cases {
        let file = [&bytes[..at], raw, &bytes[at + old.len()..]].concat();
        let page_at = file.windows(9).position(|part| part == b"ANSI_1252").expect("a code page");
        let file = [&file[..page_at], page.as_bytes(), &file[page_at + 9..]].concat();
        assert_eq!(excerpt_text(&file).len(), file.len());
        let read = opened(file);
        let texts: Vec<String> = read
            .document
            .entities()
            .filter_map(|entity| match entity {
                EntityType::Text(text) => Some(text.value.clone()),
                _ => None,
            })
            .collect();
        assert_eq!(texts, [expected], "{page}");
    }
}

#[test]
fn byte_order_marks_comments_and_line_ends_do_not_matter() {
    let plain = opened(drawing("R2010.dxf"));
    let variants = [
        format!("\u{feff}{}", text("R2010.dxf")),
        format!("999\nby hand\n999\ntwice\n{}", text("R2010.dxf")),
        text("R2010.dxf").replace('\n', "\r\n"),
        text("R2010.dxf").trim_end().to_owned(),
    ];
    for variant in variants {
        let read = opened(variant.clone().into_bytes());
        assert_eq!(contents(&read.document), contents(&plain.document));
        let [first, _] = read.tags.lines_of(Handle(0x34)).expect("lines of the circle");
        assert_eq!(variant.lines().nth(first - 1), Some("CIRCLE"), "line {first}");
    }
}

#[test]
fn a_cut_drawing_says_at_which_line_and_what_was_read() {
    let whole = text("R2010.dxf");
    let circle = whole.find("\nCIRCLE\n").expect("a circle");
    let cut = &whole[..circle + 40];
    let faults = faults(cut);
    assert_eq!(faults.len(), 1);
    assert_eq!(faults[0].code, codes::CUT);
    let n_lines = cut.matches('\n').count();
    let lines = [n_lines, n_lines + 1].map(|line| format!("unexpectedly at line {line}"));
    assert!(lines.iter().any(|line| faults[0].message.ends_with(line)), "{}", faults[0].message);
    assert!(faults[0].notes[0].starts_with("2 entities were read"), "{:?}", faults[0].notes);

    // After the entities, nothing of use is missing.
    let end = whole.rfind("ENDSEC").expect("the end of the objects");
    let read = opened(whole.as_bytes()[..end].to_vec());
    assert_eq!(read.warnings.iter().map(|it| it.code).collect::<Vec<_>>(), [codes::CUT]);
}

#[test]
fn a_number_no_drawing_has_is_shown_with_its_entity() {
    let whole = text("R2010.dxf");
    let radius = whole.find("\n 40\n3.0\n").expect("the radius of the circle") + 1;
    for word in ["nan", "1e999", "-inf", "1e16", "three"] {
        let changed = whole[..radius].to_owned() + &whole[radius..].replacen("3.0", word, 1);
        let faults = faults(&changed);
        let code = if word == "three" { codes::DAMAGED } else { codes::ABSURD_NUMBER };
        assert_eq!((faults.len(), faults[0].code), (1, code), "{word}");
        assert_eq!(&changed[faults[0].labels[0].span.clone()], word);
        let line = changed[..radius].matches('\n').count() + 2;
        assert!(faults[0].message.contains(&format!("line {line}")), "{}", faults[0].message);
        assert!(
            faults[0].notes.contains(&"CIRCLE, handle 34, layer BK_JOINTS, at (1, 2)".to_owned()),
            "{:?}",
            faults[0].notes
        );
    }
}

#[test]
fn counts_beyond_what_follows_are_refused() {
    let whole = text("R2010.dxf");
    let hatch = whole.find("\nHATCH\n").expect("a hatch");
    for (code, old) in [(" 93", "3"), (" 91", "2")] {
        let at = hatch + whole[hatch..].find(&format!("\n{code}\n{old}\n")).expect("a count") + 1;
        for count in ["2000000000", "-1"] {
            let tail = whole[at..].replacen(old, count, 1);
            let tail = if code.contains('3') {
                whole[at..].replacen("\n3\n", &format!("\n{count}\n"), 1)
            } else {
                tail
            };
            let faults = faults(&(whole[..at].to_owned() + &tail));
            assert_eq!(faults[0].code, codes::DAMAGED, "{code} {count}: {faults:?}");
            assert!(faults[0].message.contains("promises"), "{}", faults[0].message);
        }
    }
}

#[test]
fn blocks_that_multiply_or_hold_themselves_are_refused() {
    let whole = text("R2010.dxf");
    let outer = whole.rfind("\nOUTER\n").expect("an insert of OUTER");
    let inner = whole.find("\nINSERT\n").expect("the insert within OUTER");
    let within =
        whole[..inner].to_owned() + &whole[inner..].replacen("\nBK_BODY\n", "\nOUTER\n", 1);
    assert_eq!(faults(&within)[0].code, codes::BLOCK_IN_ITSELF);

    let tail = whole[outer..].replacen("\n 70\n2\n", "\n 70\n30000\n", 1);
    let tail = tail.replacen("\n 71\n3\n", "\n 71\n30000\n", 1);
    let many = faults(&(whole[..outer].to_owned() + &tail));
    assert_eq!(many[0].code, codes::TOO_LARGE, "{many:?}");
}

#[test]
fn entities_without_a_handle_of_their_own_are_all_read() {
    let whole = text("R12.dxf");
    let n_lines = |document: &CadDocument| {
        document.entities().filter(|entity| matches!(entity, EntityType::Line(_))).count()
    };
    let before = n_lines(&opened(whole.clone().into_bytes()).document);
    // Handle 37 is a line's, 36 a circle's: now both have the same one, or the line has none.
    for (old, new) in
        [("  5\n37\n", "  5\n36\n"), ("  5\n37\n", ""), ("  5\n37\n", "  5\nFFFFFFFFFFFFFFFF\n")]
    {
        let read = opened(whole.replacen(old, new, 1).into_bytes());
        assert_eq!(n_lines(&read.document), before);
        let line = read.document.entities().find_map(|entity| match entity {
            EntityType::Line(line) if line.end.y == 1.0 => Some(Handle(line.common.handle.value())),
            _ => None,
        });
        let line = line.expect("the line");
        assert_eq!(read.tags.own_handle(line), None);
        let record = read.tags.known_record(line).expect("its record");
        assert!(read.tags.is_word(record.start, "LINE"));
    }
}

#[test]
fn a_drawn_mechanism_is_the_same_as_dwg_and_dxf() {
    for example in ["press", "slider-crank", "five-link", "quick-return"] {
        let path = format!("{}/../../examples/{example}/drawing.dxf", env!("CARGO_MANIFEST_DIR"));
        let dxf = std::fs::read(path).expect("an example");
        let document = DxfReader::from_reader(Cursor::new(dxf.clone())).and_then(DxfReader::read);
        let dwg = DwgWriter::write_to_vec(&document.expect("a drawing")).expect("a DWG");
        let [from_dxf, from_dwg] = [dxf, dwg].map(|bytes| {
            let sheet = sheet(bytes, None).unwrap_or_else(|refused| panic!("{refused:?}"));
            // Some state their masses in a sidecar.
            let plate = [Some("1 kg/m^3"), Some("1 m")];
            sheet.compose(ModelOptions { plate, ..ModelOptions::default() }).text
        });
        assert!(from_dxf.contains("[bodies."), "{example}");
        assert_eq!(from_dxf, from_dwg, "{example}");
    }
}

#[test]
fn a_model_space_of_another_name_is_the_model_space() {
    let read = |bytes: Vec<u8>| {
        let unit = bksim_cad::units::by_name("mm");
        sheet(bytes, unit).expect("the drawing is read").drawing.entities.len()
    };
    for name in ["R2000.dxf", "R2010.dxf", "R2018.dxf"] {
        let renamed = text(name).replace("*Model_Space", "*U3").replace("*MODEL_SPACE", "*U3");
        assert!(renamed.contains("*U3"));
        let n_entities = read(drawing(name));
        assert!(n_entities > 10, "{name}");
        assert_eq!(read(renamed.into_bytes()), n_entities, "{name}");
    }
    let mut document = DxfReader::from_reader(Cursor::new(drawing("R2000.dxf")))
        .and_then(DxfReader::read)
        .expect("a drawing");
    let write = |document: &CadDocument| DwgWriter::write_to_vec(document).expect("a DWG");
    let n_entities = read(write(&document));
    let mut block = document.block_records.remove("*Model_Space").expect("the model space");
    block.name = "*U3".to_owned();
    document.header.model_space_block_handle = block.handle;
    document.block_records.add(block).expect("a free name");
    assert_eq!(read(write(&document)), n_entities);
}
