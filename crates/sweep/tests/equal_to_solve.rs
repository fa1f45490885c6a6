//! A row of a sweep is what `bksim solve --set` gives for the same values, to the last bit.

use bksim::Mechanism;
use bksim::analysis::compliances;
use bksim::dae::Control;
use bksim::model::file::{Source, read};
use bksim::sim::hybrid::Passage;
use bksim::sim::run::{Observer, Replay, Sample, Segment, StateSensitivity};
use bksim_sweep::{Ending, Monitor, Request, Row, Study};

use crate::common::{plan, press};

/// A run with its samples, and what there is on both sides of its events.
#[derive(Default)]
struct Taken {
    samples: Vec<Sample>,
    segments: Vec<Segment>,
    passages: Vec<Passage>,
}

impl Observer for Taken {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.samples.push(sample.clone());
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.segments.push(segment.clone());
    }

    fn passage(&mut self, passage: &Passage) {
        self.passages.push(passage.clone());
    }
}

/// The solution of the model by itself: values of parameters, its samples with those around events and close together,
/// or the code of its fault.
type Solved = Result<(Mechanism, [Vec<Sample>; 2]), &'static str>;

fn solve(text: &str, set: &[(String, String)]) -> Solved {
    let reading = read(&Source { overrides: set, ..Source::new(text, "press") });
    let Some(model) = reading.model else {
        let error = reading.diagnostics.iter().find(|fault| fault.is_error());
        return Err(error.expect("a reason").code.0);
    };
    let mechanism = Mechanism::derive(model, Vec::new()).expect("equations");
    let start = mechanism.start().map_err(|rejected| rejected.0[0].code.0)?;
    let simulation = mechanism.simulation().expect("equations");
    let mut taken = Taken::default();
    match simulation.run(&start, &mut taken, &|| false) {
        Ok(_) => {
            let mut replay = Replay::new(&mechanism.compiled, &mechanism.parameters);
            let mut around = |passage| replay.around(passage).expect("an event of this run");
            let mut between: Vec<Sample> = taken.passages.iter().flat_map(&mut around).collect();
            for segment in &taken.segments {
                for k in 0..=40 {
                    let t = segment.t0 + (segment.t1 - segment.t0) * f64::from(k) / 40.0;
                    between.push(replay.at(segment, t).expect("a step of this run").clone());
                }
            }
            Ok((mechanism, [taken.samples, between]))
        }
        Err(failure) => Err(simulation.diagnose(&failure).code.0),
    }
}

fn rows(study: &Study) -> Vec<Row> {
    study.rows(0..study.n_cases(), 2, &Monitor::default()).expect("threads").expect("an end")
}

/// Every row of a sweep against a solution of its own; the number of rows that failed.
fn check(text: &str, axes: &[(&str, &str)]) -> usize {
    let mut request = Request::new(text, "press", plan(axes));
    request.outputs = [
        "final(state.x)",
        "quantile(energy.total, 1)",
        "theta@0.1",
        "max(energy.total)",
        "min(reactions.rod.fx)",
    ]
    .map(str::to_owned)
    .to_vec();
    let study = Study::prepare(request).expect("a study");
    let rows = rows(&study);
    let mut n_failed = 0;
    for row in &rows {
        let set = study.settings(row.case);
        let (mechanism, [samples, between]) = match solve(text, &set) {
            Ok(solved) => solved,
            Err(code) => {
                let fault = row.ending.fault().unwrap_or_else(|| panic!("{set:?} is refused"));
                assert_eq!(fault.code, code, "{set:?}");
                assert!(row.outputs.is_empty());
                n_failed += 1;
                continue;
            }
        };
        assert_eq!(row.ending, Ending::Done, "{set:?}");
        let model = &mechanism.model;
        for ((name, _), value) in set.iter().zip(&row.inputs) {
            let parameter = model.parameters.iter().find(|p| p.name == *name).expect("it is set");
            assert_eq!(parameter.value.to_bits(), value.to_bits(), "{name} in {set:?}");
        }
        let index_of = |name: &str| {
            mechanism.compiled.coordinates.iter().position(|c| c.name == name).expect("a name")
        };
        let joint = mechanism.compiled.joints.iter().position(|j| j == "rod").expect("a joint");
        let last = samples.last().expect("samples");
        let total = |s: &Sample| s.energy.kinetic + s.energy.potential;
        let all = || samples.iter().chain(&between);
        let force = |s: &Sample| s.reactions[joint][0];
        let at = samples.iter().find(|s| s.t == 0.1).expect("a sample at 0.1 s");
        let expected = [
            last.q[index_of("x")],
            samples.iter().map(total).fold(f64::NEG_INFINITY, f64::max),
            at.q[index_of("theta")],
        ];
        for (found, expected) in row.outputs.iter().zip(expected) {
            assert_eq!(found.to_bits(), expected.to_bits(), "{set:?}: {found} {expected}");
        }
        // Extremes between samples are found at least as far out as by many samples.
        let [.., most, least] = row.outputs[..] else { panic!("{row:?}") };
        let of = |value: fn(f64, f64) -> f64, of: &dyn Fn(&Sample) -> f64| {
            all().map(of).reduce(value).expect("samples")
        };
        for (found, dense, side) in
            [(most, of(f64::max, &total), 1.0), (least, of(f64::min, &force), -1.0)]
        {
            let [range, off] =
                [of(f64::max, &force) - of(f64::min, &force), side * (found - dense)];
            let room = 1e-3 * range;
            assert!(off >= -1e-9 * range && off < room, "{set:?}: {found} for {dense}");
        }
        assert_eq!(row.n_steps, last.stats.n_step as u64, "{set:?}");
    }
    n_failed
}

#[test]
fn parameters_and_all_that_depends_on_them() {
    // l2, J1 and the start of the slider follow l1; the end of the run follows k.
    assert_eq!(check(&press(), &[("l1", "90 mm:110 mm:3"), ("k", "300 N/m,400 N/m")]), 0);
}

#[test]
fn samples_that_no_output_needs_change_no_bit() {
    for every in ["0.1", "0.001"] {
        let text =
            press().replace("every = \"0.02 s\"", &format!("every = \"{every} s\"\nrtol = 1e-9"));
        let mut request = Request::new(&text, "press", plan(&[("l1", "90 mm:110 mm:3")]));
        request.outputs = vec!["final(state.x)".to_owned(), "theta@0.07".to_owned()];
        let study = Study::prepare(request).expect("a study");
        for row in rows(&study) {
            let (mechanism, [samples, _]) =
                solve(&text, &study.settings(row.case)).expect("a motion");
            let x = mechanism.compiled.coordinates.iter().position(|c| c.name == "x");
            let last = samples.last().expect("samples");
            let expected = last.q[x.expect("a name")];
            assert_eq!(row.outputs[0].to_bits(), expected.to_bits(), "every {every}: {row:?}");
            assert_eq!(row.n_steps, last.stats.n_step as u64);
        }
    }
}

#[test]
fn numbers_without_unit_are_as_the_file_takes_them() {
    assert_eq!(check(&press(), &[("l1", "0.09:0.11:3"), ("m2", "0.5:1.5:2")]), 0);
    let in_mm = press()
        .replace("[parameters]", "[units]\nlength = \"mm\"\n[parameters]\nh = 50")
        .replace("com = [\"l1/2\", 0]", "com = [\"h\", 0]");
    assert_eq!(check(&in_mm, &[("h", "40:60:3")]), 0);
    assert_eq!(check(&in_mm, &[("h", "4 cm:6 cm:3")]), 0);
}

#[test]
fn values_that_the_reader_refuses_are_rows_with_its_code() {
    // Negative masses; roots of negative numbers, divisions by zero, a negative length.
    assert_eq!(check(&press(), &[("m2", "-1,1,-0.5 kg,2")]), 2);
    let rooted = press().replace("l2 = \"3*l1\"", "l2 = \"sqrt(9*l1^2*a)/b\"\na = 1\nb = 1");
    assert_eq!(check(&rooted, &[("a", "-1,1"), ("b", "0,1,-1")]), 5);
}

#[test]
fn functions_and_powers_follow_and_exponents_decide_dimensions() {
    let functions =
        press().replace("l2 = \"3*l1\"", "l2 = \"max(3*l1, sqrt(l1^2 + (280 mm)^2))\"").replace(
            "phi = \"30 deg\"",
            "phi = \"atan2(l1, 170 mm) + if(lt(m2, 1 kg), a, -a)\"\na = \"2 deg\"",
        );
    assert_eq!(check(&functions, &[("l1", "90 mm:110 mm:4"), ("m2", "0.5,1.5 kg")]), 0);
    // Only the root of a square is a length.
    let rooted = press().replace("l2 = \"3*l1\"", "l2 = \"(9*l1^2)^e\"\ne = 0.5");
    assert_eq!(check(&rooted, &[("e", "0.25,0.5,1"), ("l1", "90 mm,100 mm")]), 4);
}

#[test]
fn loops_that_cannot_close_are_rows_with_their_code() {
    // The slider is held where a short rod does not reach.
    let held = press()
        .replace("l2 = \"3*l1\"", "l2 = \"300 mm\"")
        .replace("x = { guess = \"4*l1\" }", "x = \"0.38 m\"")
        .replace("theta = \"phi\"", "theta = { guess = \"phi\" }");
    assert_eq!(check(&held, &[("l2", "0.2,0.3,0.31")]), 1);
}

#[test]
fn what_reverses_an_outline_has_equations_of_its_own() {
    let text = include_str!("../../../tests/fixtures/plate-and-block.toml");
    assert_eq!(check(text, &[("w", "-0.3,-0.1,0,0.1,0.3")]), 1);
}

#[test]
fn kinks_stops_and_friction_follow_the_values() {
    let text = include_str!("../../../tests/fixtures/kinks-and-contacts.toml");
    assert_eq!(check(text, &[("gap", "0.1,0.2"), ("mu", "-0.1,0,0.3"), ("m", "1,2")]), 4);
}

#[test]
fn joints_that_yield_share_in_rows_what_they_share_in_solutions() {
    let text = include_str!("../../../tests/fixtures/beam-on-three-pins.toml");
    let springs = [("A", "1e8 N/m"), ("B", "3e8 N/m"), ("C", "1e8 N/m"), ("C", "1e5 N m/rad")];
    let springs = springs.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec();
    let mut request = Request::new(text, "beam", plan(&[("m", "2,3,-1 kg"), ("x", "0.6,0.7 m")]));
    request.outputs = vec!["final(reactions.B.fy)".to_owned()];
    let rigid = rows(&Study::prepare(request.clone()).expect("a study"));
    request.compliance.clone_from(&springs);
    let study = Study::prepare(request.clone()).expect("a study");
    let yielding = rows(&study);
    assert_ne!(
        study.fingerprint(),
        Study::prepare(Request { compliance: Vec::new(), ..request.clone() })
            .expect("a study")
            .fingerprint()
    );
    for (row, rigid) in yielding.iter().zip(&rigid).filter(|(row, _)| row.ending == Ending::Done) {
        let set = study.settings(row.case);
        let source = Source { overrides: &set, ..Source::new(text, "beam") };
        let mut model = read(&source).model.expect("a model");
        model.compliances = compliances(&model, &springs).expect("springs");
        let mechanism = Mechanism::derive(model, Vec::new()).expect("equations");
        let joint = mechanism.compiled.joints.iter().position(|j| j == "B").expect("a joint");
        let motion = mechanism.solve().expect("a run");
        let expected = motion.samples.last().expect("samples").reactions[joint][1];
        assert_eq!(row.outputs[0].to_bits(), expected.to_bits(), "{set:?}");
        assert!((row.outputs[0] - rigid.outputs[0]).abs() > 1.0, "{set:?}: {}", row.outputs[0]);
    }
    assert_eq!(yielding.iter().filter(|row| row.ending == Ending::Done).count(), 4);

    request.compliance = vec![("D".to_owned(), "1 N/m".to_owned())];
    let refused = Study::prepare(request).expect_err("no such joint");
    assert_eq!(refused.0[0].code.0, "Q002");
}

/// A tool that is driven at 1 m/s against a force that jumps where it has come to `s`: the peak is on one side of
/// the event, between two samples.
#[test]
fn extremes_count_both_sides_of_an_event() {
    let text = |force: &str| {
        format!(
            "[parameters]\ns = 0.5\n[bodies.b]\nmass = 1\n\
             [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n\
             [drives.go]\njoint = \"S\"\nmotion = \"1 m/s*t\"\n\
             [loads.f]\ntype = \"force\"\non = \"b\"\nvector = [\"-({force})\", 0]\n\
             [solve]\nt_end = 1\nevery = 0.1\n"
        )
    };
    let [before, after]: [fn(f64) -> f64; 2] = [|s| 100.0 * s, |s| 100.0 * (1.0 - s)];
    for (force, peak) in [
        ("if(S.position < s, 100*S.position, 0)", before),
        ("if(S.position < s, 0, 100*(1 - S.position))", after),
    ] {
        let mut request = Request::new(&text(force), "tool", plan(&[("s", "0.23:0.77:4")]));
        request.outputs =
            ["max(drives.go)", "peak_to_peak(drives.go)", "min(-drives.go)", "final(drives.go)"]
                .map(str::to_owned)
                .to_vec();
        let study = Study::prepare(request).expect("a study");
        let found = rows(&study);
        assert_eq!(found.len(), 4);
        for (k, row) in (0..).zip(&found) {
            let expected = peak(0.23 + 0.18 * f64::from(k));
            let [max, span, min, last] = row.outputs[..] else { panic!("{row:?}") };
            for value in [max, span, -min] {
                assert!((value - expected).abs() < 1e-7, "{force}: {value} is not {expected}");
            }
            assert!(last.abs() < 1e-9, "{force}: {last} at the end");
        }
    }
}

/// A slider-crank of crank r and rod n·r at a constant rate: its slider is fastest where sin²θ = z solves
/// z³ − n² z² − n⁴ z + n⁴ = 0, and its acceleration is largest in the outer dead centre, ω² r (1 + 1/n); both between the
/// few samples.
#[test]
fn extremes_between_samples_are_those_of_a_closed_form() {
    let text = "[parameters]\nn = 3\n[ground]\npoints = { O = [0, 0] }\n\
        [bodies.crank]\nmass = 1\ninertia = 0.1\npoints = { A = [0.1, 0] }\n\
        [bodies.rod]\nmass = 1\ninertia = 0.1\npoints = { A = [0, 0], B = [\"n*0.1\", 0] }\n\
        [bodies.slider]\nmass = 1\n\
        [joints.O]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"crank\"]\n\
        [joints.A]\ntype = \"revolute\"\nbetween = [\"crank.A\", \"rod.A\"]\n\
        [joints.B]\ntype = \"revolute\"\nbetween = [\"rod.B\", \"slider\"]\n\
        [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"slider\"]\naxis = [1, 0]\n\
        [drives.go]\njoint = \"O\"\nmotion = \"0.3 + 2*t\"\n\
        [initial]\nS = { guess = { position = \"0.39 m\" } }\n\
        [solve]\nt_end = 7\nevery = 0.25\nrtol = 1e-11\natol = 1e-13\n";
    let mut request = Request::new(text, "press", plan(&[("n", "2.5:4:4")]));
    request.outputs = [
        "max(slider.vx)",
        "min(slider.ax)",
        "peak_to_peak(slider.x)",
        "max_between(slider.vx, 2 s, 3.5 s)",
        "max_between(slider.x, 3.25 s, 3.5 s)",
    ]
    .map(str::to_owned)
    .to_vec();
    let study = Study::prepare(request).expect("a study");
    let (r, rate) = (0.1, 2.0_f64);
    for row in rows(&study) {
        let n = row.inputs[0];
        let cubic = |z: f64| z * z * z - n * n * z * z - n.powi(4) * z + n.powi(4);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let z = f64::midpoint(low, high);
            if cubic(z) > 0.0 { low = z } else { high = z }
        }
        let (sin, cos) = (low.sqrt(), (1.0 - low).sqrt());
        let fastest = r * rate * (sin + sin * cos / (n * n - sin * sin).sqrt());
        // The largest place of a part of the time is at its end: there the slider comes back.
        let theta = 0.3 + rate * 3.25;
        let at_end = r * (theta.cos() + (n * n - theta.sin().powi(2)).sqrt());
        let expected = [fastest, -r * rate * rate * (1.0 + 1.0 / n), 2.0 * r, fastest, at_end];
        for (found, expected) in row.outputs.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "n = {n}: {found} is not {expected}");
        }
    }
}
