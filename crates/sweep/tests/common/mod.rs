//! Models and plans that the tests share.
#![allow(dead_code, reason = "each test file uses some of this")]

use bksim_sweep::{Axis, Design, Plan};

/// A crank, a rod and a slider: lengths, inertias, the start and the end of the run are expressions
/// of parameters.
pub(crate) fn press() -> String {
    include_str!("../../../../tests/fixtures/press.toml").to_owned()
}

/// A grid.
pub(crate) fn plan(axes: &[(&str, &str)]) -> Plan {
    let axis = |(name, text): &(&str, &str)| {
        Axis::parse(name, text).expect("an axis").expect("more than one value")
    };
    Plan::new(axes.iter().map(axis).collect(), Design::Grid).expect("a plan")
}
