//! `bksim cad doctor`: what it finds, and its marks.

use bksim_cad::model::{ModelOptions, sheet};

use super::{ARM, drawing, words};

/// The report on a listed drawing.
fn examined(list: &str) -> bksim_cad::doctor::Report {
    let text = drawing::dxf(list).expect("a list of entities");
    bksim_cad::doctor::examine(text.into_bytes(), ModelOptions::default())
}

#[test]
fn the_doctor_finds_what_is_wrong_and_where() {
    assert_eq!(examined(&format!("units mm\n{ARM}")).findings, []);
    let list = format!(
        "units none\n{ARM}\
         LAYER name=old off=yes\n\
         CIRCLE handle=41 layer=old at=250,10 radius=4\n\
         CIRCLE handle=42 layer=BK_JOINT at=20,10 radius=4\n\
         REGION handle=43 layer=BK_BODY_arm\n\
         LINE handle=44 at=400,0 to=450,0\n\
         LINE handle=45 at=450,0 to=400,0\n\
         LINE handle=46 layer=part at=500,0 to=560,0\n\
         LINE handle=47 layer=part at=560,0 to=530,50\n\
         LINE handle=48 layer=part at=530,50 to=500,0.2\n\
         CIRCLE handle=49 at=600,0 radius=0\n\
         INSERT handle=4A at=650,0\n  2 NOPE\n\
         INSERT handle=4B block=BK_GRAVITY at=0,99 ACCELERATION=\"9,81\"\n\
         INSERT handle=4C block=BK_GRAVITY at=0,199 ACCELERATION=9.81\n"
    );
    let report = examined(&list);
    let found: Vec<(&str, Option<u64>)> = report
        .findings
        .iter()
        .map(|it| (it.fault.code.0, it.places.first().and_then(|at| at.handle).map(|at| at.0)))
        .collect();
    for expected in [
        ("D006", None),
        ("D010", Some(0x4A)),
        ("D020", Some(0x46)),
        ("D025", Some(0x49)),
        ("D027", Some(0x45)),
        ("D045", None),
        ("D046", Some(0x4C)),
        ("D048", Some(0x41)),
        ("D049", Some(0x42)),
        ("D050", Some(0x43)),
    ] {
        assert!(found.contains(&expected), "{expected:?} is not in {found:?}");
    }
    assert_eq!(found.len(), 10, "{found:?}");
    assert!(report.findings.iter().all(|it| it.fault.help.is_some()));
    let gap = report.findings.iter().find(|it| it.fault.code.0 == "D020").expect("the gap");
    assert_eq!((gap.places.len(), gap.places[1].at), (2, [530.0, 50.0]));
    assert!(words(&gap.fault).contains("a gap of 0.2 units"), "{}", words(&gap.fault));
}

#[test]
fn the_marks_of_the_doctor_are_not_read() {
    let list = format!("units mm\n{ARM}INSERT handle=4A at=650,0\n  2 NOPE\n");
    let text = drawing::dxf(&list).expect("a list of entities").into_bytes();
    let examine = |bytes: Vec<u8>| bksim_cad::doctor::examine(bytes, ModelOptions::default());
    let report = examine(text.clone());
    let options = bksim_cad::open::OpenOptions::default();
    let tags = bksim_cad::open::check(text.clone(), &options).expect("a drawing").tags;
    let addition = bksim_cad::doctor::marks(&report);
    let marked = bksim_cad::write::graft::graft(&tags, &addition).expect("a copy");
    let shown = String::from_utf8_lossy(&marked);
    assert!(shown.contains("BK_DOCTOR") && shown.contains("1 D010: the drawing has no block"));
    let compose =
        |bytes: Vec<u8>| sheet(bytes, None).expect("a drawing").compose(ModelOptions::default());
    let [plain, again] = [text, marked.clone()].map(compose);
    assert_eq!(plain.text, again.text);
    assert_eq!(plain.tolerance, again.tolerance);
    assert_eq!(examine(marked).findings.len(), report.findings.len());
}
