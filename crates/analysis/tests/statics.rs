//! Equilibria against references of 15 digits.

mod support;

use bksim_analysis::{Stability, statics};
use support::{Problem, difference};

/// Finds the equilibria of the reference, all and no other.
fn has_these(name: &str) {
    let problem = Problem::load(name);
    let found = statics(problem.model(), &["crank.angle".to_owned()]).expect("equilibria");
    let (columns, mut rows) = (problem.columns(), problem.rows());
    assert!(found.is_complete, "all of the assembly");
    assert_eq!(found.equilibria.len(), rows.len(), "{name}");
    let table = found.table();
    let angle = |q: f64| q.rem_euclid(std::f64::consts::TAU);
    let crank = columns.iter().position(|c| c == "crank.angle").expect("a crank");
    let own = table.column("crank.angle").expect("a crank");
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| angle(own[a]).total_cmp(&angle(own[b])));
    rows.sort_by(|a, b| angle(a[crank]).total_cmp(&angle(b[crank])));
    for (k, column) in columns.iter().enumerate() {
        let expected: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        if column == "stable" {
            let stable = |&i: &usize| {
                f64::from(u8::from(found.equilibria[i].stability == Stability::Stable))
            };
            assert_eq!(order.iter().map(stable).collect::<Vec<_>>(), expected);
            continue;
        }
        // The guide's normal force acts along y, its axis being x.
        let own_name = match column.as_str() {
            "guide.N" => "guide.fy".to_owned(),
            "guide.M" => "guide.mz".to_owned(),
            name => name.replace(".F", ".f").replace(".M", ".m"),
        };
        let values = table.column(&own_name).unwrap_or_else(|| panic!("no column {own_name}"));
        let values: Vec<f64> = order.iter().map(|&i| values[i]).collect();
        // Reactions are compared with the largest of all.
        let largest = if expected.iter().all(|e| e.abs() < 1e-9) { 1e4 } else { 1.0 };
        let off =
            difference(&values, &expected, column.rsplit('.').next() == Some("angle")) / largest;
        assert!(off < 1e-9, "{column} differs by {off:e}: {values:?} against {expected:?}");
    }
}

#[test]
fn toggle_clamp() {
    has_these("eq-toggle-clamp");
}

#[test]
fn four_bar_with_torsion_springs() {
    has_these("eq-four-bar-torsion");
}
