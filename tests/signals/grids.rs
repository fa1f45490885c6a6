//! Tables of two variables: against bilinear functions, products with tables of one variable, their ends and rows.

use crate::support::{Within, close, derive, messages, model, solve};
use bksim::model::file::{Limits, Source, expand, read};

/// A mass on a guide that a force pushes; `tables` and the force are given.
fn pushed(tables: &str, force: &str, method: &str) -> String {
    format!(
        "{tables}\n[bodies.m]\nmass = \"1 kg\"\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"m\"]\n\
         axis = [1, 0]\n[signals.F]\nvalue = \"{force}\"\n[loads.push]\ntype = \"force\"\non = \"m\"\n\
         vector = [\"F\", 0]\n[solve]\nt_end = 2\nrtol = 1e-11\natol = 1e-12\nmethod = \"{method}\"\n"
    )
}

/// Rows of a grid with these values.
fn rows(x: &[f64], y: &[f64], value: impl Fn(f64, f64) -> f64) -> String {
    let row = |x: f64, y: f64| format!("[{x:?}, {y:?}, {:?}]", value(x, y));
    let all: Vec<String> = x.iter().flat_map(|&x| y.iter().map(move |&y| row(x, y))).collect();
    format!("points = [{}]", all.join(", "))
}

const X: [f64; 6] = [-1.0, 0.0, 0.4, 1.0, 3.0, 50.0];
const Y: [f64; 4] = [0.0, 0.5, 1.2, 2.0];

#[test]
fn straight_lines_along_both_arguments_are_the_bilinear_function() {
    let of = |x: f64, y: f64| 2.0 - 1.5 * x + 0.5 * y + 0.75 * x * y;
    let table = format!(
        "[tables.f]\nunits = [\"m\", \"s\", \"N\"]\ninterpolation = \"linear\"\n{}",
        rows(&X, &Y, of)
    );
    for method in ["explicit", "radau"] {
        let motion = solve(&derive(model(&pushed(&table, "f(S.position, t)", method))));
        for sample in &motion.samples {
            let expected = of(sample.q[0], sample.t);
            close("force", sample.a[0], expected, Within { relative: 0.0, absolute: 1e-12 });
        }
        // The motion itself: the same force without a table.
        let plain = "2 N - 1.5 N/m*S.position + 0.5 N/s*t + 0.75 N/m/s*S.position*t";
        let plain = solve(&derive(model(&pushed("", plain, method))));
        let ends = [&motion, &plain].map(|motion| motion.samples.last().expect("samples").q[0]);
        close("the end", ends[0], ends[1], Within { relative: 1e-9, absolute: 0.0 });
    }
}

#[test]
fn splines_along_both_arguments_are_products_of_splines() {
    let (f, g) = (|x: f64| (1.7 * x).sin() + 0.3, |y: f64| 1.0 + 2.0 * y);
    let line: Vec<String> = X.iter().map(|&x| format!("[{x:?}, {:?}]", f(x))).collect();
    let tables = format!(
        "[tables.both]\nunits = [\"m\", \"s\", \"N\"]\n{}\n[tables.one]\nunits = [\"m\", \"N\"]\npoints = [{}]",
        rows(&X, &Y, |x, y| f(x) * g(y)),
        line.join(", ")
    );
    // A spline through points of a straight line is this line.
    let mut ends = Vec::new();
    for force in ["both(S.position, t)", "one(S.position)*(1 + 2*t/(1 s))"] {
        for method in ["explicit", "radau"] {
            let motion = solve(&derive(model(&pushed(&tables, force, method))));
            ends.push(motion.samples.last().expect("samples").q[0]);
        }
    }
    for end in &ends {
        close("the end", *end, ends[0], Within { relative: 1e-9, absolute: 0.0 });
    }
}

#[test]
fn beyond_its_rows_a_grid_does_as_it_is_told() {
    let of = |x: f64, y: f64| 1.0 + x + y;
    let table = |how: &str| {
        format!(
            "[tables.f]\nunits = [\"m\", \"s\", \"N\"]\ninterpolation = \"linear\"\n{how}\n{}",
            rows(&[0.0, 0.5], &[0.0, 1.0], of)
        )
    };
    let limited = solve(&derive(model(&pushed(
        &table("extrapolate = \"constant\""),
        "f(S.position, t)",
        "auto",
    ))));
    for sample in &limited.samples {
        let expected = of(sample.q[0].clamp(0.0, 0.5), sample.t.min(1.0));
        close("force", sample.a[0], expected, Within { relative: 0.0, absolute: 1e-9 });
    }
    let onwards = solve(&derive(model(&pushed(
        &table("extrapolate = \"linear\""),
        "f(S.position, t)",
        "auto",
    ))));
    for sample in &onwards.samples {
        let expected = of(sample.q[0], sample.t);
        close("force", sample.a[0], expected, Within { relative: 0.0, absolute: 1e-9 });
    }
    // Nothing said: the run ends at the row that is reached first.
    let mechanism = derive(model(&pushed(&table(""), "f(S.position, t)", "auto")));
    let text = mechanism.solve().expect_err("it leaves the table").to_string();
    assert!(text.contains("of table `f` leaves it at t = "), "{text}");
    assert!(text.contains("0.5 m is its last row"), "{text}");
}

#[test]
fn rows_of_a_file_may_have_two_arguments() {
    let text = pushed("[tables.f]\nfile = \"map.csv\"", "f(S.position, t)", "auto");
    let open = |csv: &'static str| {
        move |file: &str| {
            if file == "map.csv" {
                Ok(csv.as_bytes().to_vec())
            } else {
                Err("is not there".to_owned())
            }
        }
    };
    let good = "x [mm]; time [s]; force [N]\n0; 0; 1\n0; 3; 4\n2000; 0; 3\n2000; 3; 6\n20000; 0; 21\n20000; 3; 24\n";
    let whole = expand("model.toml", &text, Limits::default(), &mut open(good)).expect("a file");
    assert!(whole.faults.is_empty(), "{}", messages(&whole.faults));
    let motion = solve(&derive(model(&whole.text)));
    for sample in &motion.samples {
        let expected = 1.0 + sample.q[0] + sample.t;
        close("force", sample.a[0], expected, Within { relative: 0.0, absolute: 1e-9 });
    }
    let uneven = "0, 0, 1\n0, 3, 4\n2, 0, 3\n2, 3\n";
    let whole = expand("model.toml", &text, Limits::default(), &mut open(uneven)).expect("a file");
    assert!(messages(&whole.faults).contains("row 4 of table `f` has 2 columns, not three"));
}

#[test]
fn faults_of_grids_name_the_row() {
    let cases = [
        (
            "[[0, 0, 1], [0, 1, 2], [1, 0, 2], [1, 2, 3]]",
            "row 4 of table `f` has the second argument 2, not 1",
        ),
        (
            "[[0, 0, 1], [0, 1, 2], [1, 0, 2], [2, 1, 3]]",
            "row 4 of table `f` has the first argument 2, not 1",
        ),
        ("[[0, 1, 1], [0, 0, 2], [1, 1, 2], [1, 0, 3]]", "row 2 of table `f` has 0 after 1"),
        (
            "[[1, 0, 1], [1, 1, 2], [0, 0, 2], [0, 1, 3]]",
            "row 3 of table `f` begins with 0 after 1",
        ),
        ("[[0, 0, 1], [0, 1, 2], [1, 0, 2]]", "table `f` has 3 rows, with 2 and 2 arguments"),
        ("[[0, 0, 1], [1, 0, 2]]", "table `f` has 2 rows, with 2 and 1 arguments"),
        ("[[0, 0, 1], [0, 1]]", "row 2 of table `f`: expected three numbers"),
    ];
    for (points, expected) in cases {
        let table = format!("[tables.f]\nunits = [\"m\", \"s\", \"N\"]\npoints = {points}");
        let text = pushed(&table, "f(S.position, t)", "auto");
        let found = messages(&read(&Source::new(&text, "test")).diagnostics);
        assert!(found.contains(expected), "{points}: {found}");
    }
    let table = format!("[tables.f]\n{}", rows(&X, &Y, |x, y| x + y));
    for (call, expected) in [
        ("f(1)", "`f` takes 2 arguments, found 1"),
        ("f(1, 2 m)", "the argument of table `f` has no unit"),
    ] {
        let found =
            messages(&read(&Source::new(&pushed(&table, call, "auto"), "test")).diagnostics);
        assert!(found.contains(expected), "{call}: {found}");
    }
}

/// A call with numbers alone is a number.
#[test]
fn a_grid_has_a_value_where_a_number_is_needed() {
    let table =
        format!("[tables.f]\ninterpolation = \"linear\"\n{}", rows(&X, &Y, |x, y| 3.0 * x - y));
    let start = "[initial]\nS.position = \"f(0.2, 1) + f(3, 2)\"\n";
    let motion = solve(&derive(model(&format!("{}{start}", pushed(&table, "1 N", "auto")))));
    close(
        "the start",
        motion.samples[0].q[0],
        0.6 - 1.0 + 9.0 - 2.0,
        Within { relative: 1e-14, absolute: 0.0 },
    );
}
