//! Values from outside, such as those of `--set`, take the place of the file's.

use bksim_model::Method;
use bksim_model::file::{Source, code, read};

use crate::reading::{FLOATING, value};

/// Arrays are no parameters, and a file need not have the keys of its start and of its run.
#[test]
fn paths_lead_to_arrays_and_to_keys_that_are_not_there() {
    let text = r#"
        [bodies.rod]
        mass = "1 kg"
        com = ["1 m", 0]
        inertia = "1 kg m^2"
        [joints.pin]
        type = "revolute"
        between = ["ground", "rod"]
        [loads.push]
        type = "force"
        on = "rod"
        vector = ["1 N", 0]
    "#;
    let set = |path: &str, value: &str| {
        let overrides = [(path.to_owned(), value.to_owned())];
        read(&Source { overrides: &overrides, ..Source::new(text, "test") })
    };
    let good = |path: &str, value: &str| {
        let reading = set(path, value);
        assert_eq!(reading.diagnostics, [], "{path}");
        reading.model.expect("a model")
    };
    let model = good("rod.com", "[0, \"-50 mm\"]");
    assert_eq!(model.bodies[1].com.map(|e| value(&model, e)), [0.0, -0.05, 0.0]);
    assert_eq!(good("solve.t_end", "3 s").solve.t_end.to_bits(), 3.0_f64.to_bits());
    assert_eq!(good("solve.method", "radau").solve.method, Method::Radau);
    assert_eq!(good("pin.rate", "60 rpm").initial.len(), 1);
    assert_eq!(good("initial.pin.angle", "0.5").initial.len(), 1);
    // A misspelt key is unknown, and its value is not left aside.
    for (path, code) in [
        ("solve.tend", code::UNKNOWN_KEY),
        ("loads.push.vectro", code::UNKNOWN_KEY),
        ("loads.psuh.vector", code::UNKNOWN_OVERRIDE),
        ("loads.push", code::UNKNOWN_OVERRIDE),
    ] {
        let codes: Vec<_> = set(path, "[1, 2]").diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(codes, [code], "{path}");
    }
}

/// `--set a=0.1` has no unit to compare with that of the range.
#[test]
fn a_bare_number_from_outside_takes_the_place_of_a_quantity_with_a_range() {
    let text =
        format!("[parameters]\na = \"0.2 m\"\n[ranges]\na = [\"10 cm\", \"30 cm\"]\n{FLOATING}");
    let overrides = [("a".to_owned(), "0.1".to_owned())];
    let reading = read(&Source { overrides: &overrides, ..Source::new(&text, "test") });
    assert_eq!(reading.diagnostics, []);
    assert_eq!(reading.model.expect("a model").parameters[0].value.to_bits(), 0.1_f64.to_bits());
}

#[test]
fn overrides_replace_definitions() {
    let text = format!("[parameters]\nl = \"1 m\"\ns = \"l/2\"\n{FLOATING}");
    let overrides = [("l".to_owned(), "20 cm".to_owned())];
    let reading = read(&Source { overrides: &overrides, ..Source::new(&text, "test") });
    let model = reading.model.expect("a model");
    let values: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    assert_eq!(values, [0.2, 0.1]);
}
