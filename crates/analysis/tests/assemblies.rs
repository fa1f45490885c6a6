//! Assemblies against lists of all that planar linkages have.

mod support;

use bksim_analysis::assemblies;
use serde_json::Value;
use support::{model, number};

const LINKAGES: &str = include_str!("../../../tests/data/assemblies/planar.json");

/// Kinds that come apart into dyads.
const OF_DYADS: [&str; 8] = [
    "fourbar-grashof",
    "fourbar-nongrashof",
    "slider-crank",
    "watt-1",
    "watt-2",
    "stephenson-3",
    "leg",
    "stephenson-triad",
];

#[test]
fn linkages_of_dyads_have_the_listed_assemblies_and_that_is_proved() {
    let linkages: Vec<Value> = serde_json::from_str(LINKAGES).expect("linkages");
    let mut n_proved = 0;
    for linkage in &linkages {
        let id = linkage["id"].as_str().expect("a name");
        let Some(kind) = OF_DYADS.iter().find(|kind| id.starts_with(*kind)) else { continue };
        let listed = linkage["assemblies"].as_array().expect("assemblies");
        // The start in one of them.
        let crank = &linkage["crank"];
        let joint = crank["joint"].as_str().expect("a joint");
        let text = format!(
            "{}\n[initial]\n{joint} = {{ angle = {} }}\n",
            linkage["model"].as_str().expect("a model"),
            number(&crank["angle"])
        );
        let found = assemblies(model(&text)).expect("assemblies");
        if *kind == "stephenson-triad" {
            assert!(found.proof.is_none(), "{id}: a triad is no dyad");
            continue;
        }
        n_proved += 1;
        let proof = found.proof.as_ref().unwrap_or_else(|| panic!("{id} is not proved"));
        assert_eq!([proof.n, found.assemblies.len()], [listed.len(); 2], "{id}");
        assert!(proof.margin > 0.0 && proof.margin < 1.0);
        for expected in listed {
            let bodies = expected["bodies"].as_object().expect("bodies");
            let is_this = |found: &&bksim_analysis::Assembly| {
                let value = |name: String| {
                    found.pose.iter().find(|(known, ..)| *known == name).expect("a quantity").1
                };
                bodies.iter().all(|(body, place)| {
                    let tau = std::f64::consts::TAU;
                    let turn = value(format!("{body}.angle")) - number(&place[2]);
                    (value(format!("{body}.x")) - number(&place[0])).abs() < 1e-9
                        && (value(format!("{body}.y")) - number(&place[1])).abs() < 1e-9
                        && (turn - tau * (turn / tau).round()).abs() < 1e-9
                })
            };
            assert_eq!(found.assemblies.iter().filter(is_this).count(), 1, "{id}");
        }
    }
    assert!(n_proved >= 100, "{n_proved} linkages");
}

/// A block on a turning guide: two closures, one dyad RPR.
#[test]
fn an_inverted_slider_crank_is_proved() {
    let text = "[ground.points]\nD = [0.3, 0]\n\
                [bodies]\ncrank = { mass = 1, inertia = 1, points = { B = [0.1, 0] } }\n\
                block = { mass = 1, inertia = 1 }\nguide = { mass = 1, inertia = 1, points = { G = [0, 0.05] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"block\"] }\n\
                S = { type = \"prismatic\", between = [\"guide.G\", \"block\"], axis = [1, 0] }\n\
                D = { type = \"revolute\", between = [\"ground.D\", \"guide\"] }\n\
                [initial]\nA = { angle = 0.8 }\n";
    let found = assemblies(model(text)).expect("assemblies");
    let proof = found.proof.expect("a proof");
    assert_eq!([found.assemblies.len(), proof.n], [2, 2]);
    assert_eq!(proof.dyads[0].kind, "RPR");
    // The guide passes at 0.05 m beside D, pin B at the distance d.
    let (x, y) = (0.1 * 0.8f64.cos() - 0.3, 0.1 * 0.8f64.sin());
    assert!((proof.margin - (1.0 - 0.05 / x.hypot(y))).abs() < 1e-12);
}
