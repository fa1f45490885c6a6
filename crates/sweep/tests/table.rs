//! The table of a sweep: what is in it, and that neither threads nor interruptions change a byte.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use bksim_sweep::{
    Axis, Design, Existing, Monitor, Plan, Report, Request, Study, SweepError, codes, parts_of,
    write,
};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;

use crate::common::{plan, press};

/// A directory of its own for each test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("bksim-sweep-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a directory");
        Self(path)
    }

    fn table(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// 60 cases, some of which the reader refuses.
fn study() -> Study {
    let mut request =
        Request::new(&press(), "press", plan(&[("m2", "-0.2:1:12"), ("l1", "0.09:0.11:5")]));
    request.outputs = vec!["max(energy.total)".to_owned(), "rms(state.x_dot)".to_owned()];
    request.changes.t_end = Some(0.05);
    Study::prepare(request).expect("a study")
}

fn sweep(study: &Study, table: &Path, existing: Existing, n_jobs: usize) -> Report {
    write(study, table, existing, n_jobs, &Monitor::default()).expect("a table")
}

#[test]
fn the_table_has_a_row_for_every_case_and_says_what_it_is_of() {
    let scratch = Scratch::new("rows");
    let (study, table) = (study(), scratch.table("t.parquet"));
    let report = sweep(&study, &table, Existing::Refuse, 2);
    assert_eq!((report.n_cases, report.n_done, report.n_failed), (60, 50, 10));
    assert_eq!(report.faults.len(), 1);
    assert!(!parts_of(&table).exists(), "the parts are gone");

    let reader = SerializedFileReader::new(File::open(&table).expect("a file")).expect("a table");
    let columns = reader.metadata().file_metadata().schema_descr();
    let names: Vec<&str> = columns.columns().iter().map(|column| column.name()).collect();
    let expected = [
        "case",
        "m2",
        "l1",
        "max(energy.total)",
        "rms(state.x_dot)",
        "status",
        "code",
        "reason",
        "t_reached",
        "steps",
    ];
    assert_eq!(names, expected);
    let about = reader.metadata().file_metadata().key_value_metadata().expect("metadata");
    let of = |key: &str| {
        about.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.clone())
    };
    assert_eq!(of("bksim.model"), Some(press()));
    assert_eq!(of("bksim.version").as_deref(), Some(bksim::VERSION));
    assert_eq!(of("unit.max(energy.total)").as_deref(), Some("J"));
    assert_eq!(of("unit.rms(state.x_dot)").as_deref(), Some("m/s"));
    assert_eq!(of("bksim.model_sha256").map(|sha| sha.len()), Some(64));

    let rows = study.rows(0..60, 1, &Monitor::default()).expect("threads").expect("an end");
    let mut n_rows = 0;
    for (row, known) in reader.get_row_iter(None).expect("rows").zip(&rows) {
        let row = row.expect("a row");
        assert_eq!(row.get_long(0).expect("a number"), i64::try_from(known.case).expect("small"));
        assert_eq!(row.get_double(1).expect("a number"), known.inputs[0]);
        assert_eq!(row.get_string(5).expect("a text"), known.ending.word());
        match known.ending.fault() {
            None => assert_eq!(row.get_double(3).expect("a number"), known.outputs[0]),
            Some(fault) => {
                assert!(row.get_double(3).is_err(), "nothing is there");
                assert_eq!(row.get_string(6).expect("a code"), fault.code);
                assert_eq!(*row.get_string(7).expect("a reason"), fault.reason);
            }
        }
        n_rows += 1;
    }
    assert_eq!(n_rows, 60);
}

#[test]
fn threads_and_interruptions_change_no_byte() {
    let scratch = Scratch::new("bytes");
    let study = study();
    let [one, three, parted] = ["one", "three", "parted"].map(|name| scratch.table(name));
    sweep(&study, &one, Existing::Refuse, 1);
    sweep(&study, &three, Existing::Refuse, 3);
    let whole = fs::read(&one).expect("a table");
    assert_eq!(fs::read(&three).expect("a table"), whole);

    // Stopped after 20 cases, each a part of its own.
    let n_ended = AtomicU64::new(0);
    let monitor = Monitor {
        stop: &|| n_ended.load(Ordering::Relaxed) >= 20,
        progress: &|n| n_ended.store(n, Ordering::Relaxed),
    };
    let report = write(&study, &parted, Existing::Refuse, 1, &monitor).expect("parts");
    assert!(report.is_stopped);
    assert_eq!(report.n_done + report.n_failed, 20);
    assert!(!parted.exists(), "there is no table yet");

    // A part that was cut off in the middle is done again.
    let part = parts_of(&parted).join("000000.parquet");
    let bytes = fs::read(&part).expect("a part");
    fs::write(&part, &bytes[..bytes.len() / 2]).expect("written");
    let report = sweep(&study, &parted, Existing::Resume, 2);
    assert_eq!((report.n_resumed, report.n_done, report.n_failed), (19, 50, 10));
    assert_eq!(fs::read(&parted).expect("a table"), whole);

    // So is one with a single flipped bit, wherever that is, in its checksum, too.
    for k in 0..60 {
        let stop = Monitor { stop: &|| n_ended.load(Ordering::Relaxed) >= 20, ..monitor };
        n_ended.store(0, Ordering::Relaxed);
        write(&study, &parted, Existing::Replace, 1, &stop).expect("parts");
        let ending = if k % 6 == 0 { "crc32" } else { "parquet" };
        let part = parts_of(&parted).join(format!("{:06}.{ending}", k % 20));
        let mut bytes = fs::read(&part).expect("a part");
        let bit = (7919 * k) % (8 * bytes.len());
        bytes[bit / 8] ^= 1 << (bit % 8);
        fs::write(&part, bytes).expect("written");
        let report = sweep(&study, &parted, Existing::Resume, 2);
        assert_eq!(report.n_resumed, 19, "bit {bit} of {}", part.display());
        assert_eq!(fs::read(&parted).expect("a table"), whole, "bit {bit}");
    }

    n_ended.store(0, Ordering::Relaxed);
    let report = write(
        &study,
        &parted,
        Existing::Replace,
        1,
        &Monitor { stop: &|| n_ended.load(Ordering::Relaxed) >= 40, progress: monitor.progress },
    );
    assert!(report.expect("parts").is_stopped);
    let report = sweep(&study, &parted, Existing::Resume, 2);
    assert!(report.n_resumed == 40 && !report.is_stopped, "{report:?}");
    assert_eq!((report.n_done, report.n_failed), (50, 10));
    assert_eq!(fs::read(&parted).expect("a table"), whole);
}

#[test]
fn parts_of_another_sweep_are_not_touched() {
    let scratch = Scratch::new("other");
    let table = scratch.table("t.parquet");
    let monitor = Monitor { stop: &|| true, ..Monitor::default() };
    assert!(write(&study(), &table, Existing::Refuse, 1, &monitor).expect("parts").is_stopped);

    let other = Study::prepare(Request::new(&press(), "press", plan(&[("l1", "0.09,0.1")])));
    let other = other.expect("a study");
    // Nothing was finished yet, so there is nothing to lose; with a part there is.
    fs::write(parts_of(&table).join("000000.parquet"), "a part").expect("written");
    for existing in [Existing::Refuse, Existing::Resume] {
        let refused = write(&other, &table, existing, 1, &Monitor::default());
        let Err(SweepError::Rejected(rejected)) = refused else { panic!("{refused:?}") };
        assert_eq!(rejected.0[0].code, codes::OTHER_SWEEP);
    }
    assert!(parts_of(&table).join("000000.parquet").exists());
    assert_eq!(sweep(&other, &table, Existing::Replace, 1).n_done, 2);
}

#[test]
fn initial_values_vary_as_if_the_model_stated_them() {
    let swing = |rate: &str| {
        press().replace("theta = \"phi\"", &format!("A = {{ angle = \"phi\", rate = \"{rate}\" }}"))
    };
    let outputs = vec!["max(state.theta_dot)".to_owned(), "final(theta)".to_owned()];
    let mut request = Request::new(&swing("0"), "press", plan(&[("A.rate", "0:300 deg/s:3")]));
    request.outputs.clone_from(&outputs);
    let varied = Study::prepare(request).expect("a study");
    let rows = varied.rows(0..3, 1, &Monitor::default()).expect("threads").expect("an end");
    assert_eq!(varied.input_columns()[0].unit, "1/s");
    for (row, rate) in rows.iter().zip(["0 deg/s", "150 deg/s", "300 deg/s"]) {
        let mut request = Request::new(&swing(rate), "press", plan(&[("k", "400 N/m,500 N/m")]));
        request.outputs.clone_from(&outputs);
        let stated = Study::prepare(request).expect("a study");
        let alone = stated.rows(0..1, 1, &Monitor::default()).expect("threads").expect("an end");
        assert_eq!(row.outputs, alone[0].outputs, "{rate}");
        assert!(row.ending.fault().is_none());
    }
    assert!(rows[2].outputs[0] > rows[0].outputs[0]);
    assert!((rows[1].inputs[0] - 150f64.to_radians()).abs() < 1e-15);
}

/// A coil that is cut off: i = i₀ exp(−R t/L).
#[test]
fn currents_and_resistances_are_varied_in_their_units() {
    let coil = |start: &str| {
        format!(
            r#"
            [parameters]
            R = "1 ohm"
            [bodies.b]
            mass = "1 kg"
            inertia = "1 kg m^2"
            free = true
            [states.i]
            rate = "-R*i/(2 mH)"
            start = "{start}"
            [solve]
            t_end = "1 ms"
            every = "1 ms"
            rtol = 1e-11
            atol = 1e-12
            "#
        )
    };
    let axes = [("R", "2000,4000 mohm"), ("i", "0.5,0.25 kA")];
    let mut request = Request::new(&coil("1 A"), "coil", plan(&axes));
    request.outputs = vec!["final(i)".to_owned()];
    let study = Study::prepare(request).expect("a study");
    let units: Vec<String> = study.input_columns().iter().map(|c| c.unit.clone()).collect();
    assert_eq!(units, ["ohm", "A"]);
    assert_eq!(study.output_columns()[0].unit, "A");
    let rows = study.rows(0..4, 1, &Monitor::default()).expect("threads").expect("an end");
    for row in rows {
        let [resistance, start] = row.inputs[..] else { panic!("{:?}", row.inputs) };
        let expected = start * (-resistance * 1e-3 / 2e-3_f64).exp();
        assert!((row.outputs[0] - expected).abs() < 1e-8 * start, "{row:?} for {expected}");
    }
    // Another unit, and none.
    let fault = |start: &str, axis: &str| {
        let request = Request::new(&coil(start), "coil", plan(&[("i", axis)]));
        let fault = Study::prepare(request).err().map(|fault| fault.0[0].help.clone());
        fault.map(Option::unwrap_or_default)
    };
    let with_unit = Some("write it after the numbers: `i=0:1 A:11`".to_owned());
    assert_eq!([fault("1 A", "1,2 V"), fault("1 A", "1,2")], [with_unit.clone(), with_unit]);
    assert_eq!(fault("1", "1,2 A"), Some("write them alone: `i=0:1:11`".to_owned()));
    assert_eq!(fault("1", "1,2"), None);
}

#[test]
fn units_of_parameters_are_written_as_they_are_read() {
    let units = ["m", "rad/s", "kg/m/s", "A/s", "ohm", "V/A/s", "rad/V/s^2", "N m/A"];
    let model = |units: &[String]| {
        let parameters = units.iter().enumerate().map(|(k, unit)| format!("p{k} = \"3 {unit}\"\n"));
        let parameters: String = parameters.collect();
        let rest = "[bodies.b]\nmass = 1\nfree = true\n";
        let text = format!("[parameters]\n{parameters}{rest}");
        let reading = bksim::model::file::read(&bksim::model::file::Source::new(&text, "test"));
        reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
    };
    let first = model(&units.map(str::to_owned));
    let written = |k| bksim_sweep::si_unit(&first, &format!("p{k}")).expect("a unit");
    let written: Vec<String> = (0..units.len()).map(written).collect();
    let second = model(&written);
    for (first, second) in first.parameters.iter().zip(&second.parameters) {
        assert_eq!((&first.unit, first.value), (&second.unit, second.value));
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_the_nearest_name() {
    let code = |axes: &[(&str, &str)], outputs: &[&str]| {
        let mut request = Request::new(&press(), "press", plan(axes));
        request.outputs = outputs.iter().map(|&output| output.to_owned()).collect();
        let fault = Study::prepare(request).expect_err("a fault").0.swap_remove(0);
        (fault.code, fault.help.unwrap_or_default())
    };
    let (unknown, help) = code(&[("l3", "1,2")], &[]);
    assert_eq!(unknown, codes::UNKNOWN_AXIS);
    assert!(help.contains("`l1`") || help.contains("`l2`"), "{help}");
    let good = [("l1", "0.1,0.11")];
    let (unknown, help) = code(&good, &["max(state.theta_dt)"]);
    assert_eq!(unknown, codes::UNKNOWN_OUTPUT);
    assert!(help.contains("state.theta_dot"), "{help}");
    for output in ["most(theta)", "theta@x", "theta@1e9", "max(theta", "fx"] {
        assert_eq!(code(&good, &[output]).0, codes::UNKNOWN_OUTPUT, "{output}");
    }
    assert_eq!(code(&[("theta", "0,1")], &[]).0, codes::BAD_AXIS, "without a unit");
    // All cases are refused: the model's own fault is reported.
    assert_eq!(code(&[("m1", "-1,-2")], &[]).0.0, "M040");
}

/// A body that falls along x from rest.
const FALLING: &str = r#"
        [parameters]
        m = "1 kg"
        a = "1 m/s^2"
        [bodies.block]
        mass = "m"
        [joints.guide]
        type = "prismatic"
        between = ["ground", "block"]
        axis = [1, 0]
        coordinate = "x"
        [loads.gravity]
        type = "gravity"
        acceleration = ["a", 0]
        [solve]
        t_end = 1
"#;

#[test]
fn a_mean_and_a_value_at_a_time_are_those_of_the_motion() {
    // A body that falls: x = ½ t², on average 1/6 and √(1/20) in the mean square.
    let axis = Axis::parse("a", "1:2").expect("an axis").expect("an axis");
    let plan = Plan::new(vec![axis], Design::Sobol { n: 8, seed: 1 }).expect("a plan");
    let mut request = Request::new(FALLING, "block", plan);
    request.outputs =
        ["mean(x)", "rms(x)", "x@0.333", "min(x)", "max(x_dot)"].map(str::to_owned).to_vec();
    let study = Study::prepare(request).expect("a study");
    let rows = study.rows(0..8, 1, &Monitor::default()).expect("threads").expect("an end");
    for row in rows {
        let a = row.inputs[0];
        let expected = [a / 6.0, a / 20f64.sqrt(), 0.5 * a * 0.333 * 0.333, 0.0, a];
        for (idx, (found, expected)) in row.outputs.iter().zip(expected).enumerate() {
            // The trapezoidal rule on 500 samples; the others are exact but for rounding.
            let tolerance = if idx < 2 { 2e-6 } else { 1e-9 };
            assert!((found - expected).abs() < tolerance, "{idx}: {found} {expected}");
        }
    }
}

/// An output with its unit and its value at an acceleration.
type Expected = (&'static str, &'static str, fn(f64) -> f64);

#[test]
fn outputs_are_expressions_of_what_is_taken_of_quantities_over_time() {
    let axis = Axis::parse("a", "1 m/s^2:2 m/s^2").expect("an axis").expect("an axis");
    let plan = Plan::new(vec![axis], Design::Sobol { n: 4, seed: 1 }).expect("a plan");
    let mut request = Request::new(FALLING, "block", plan);
    // For x = ½ a t² from 0 s to 1 s.
    let expected: [Expected; 12] = [
        ("peak_to_peak(x)", "m", |a| a / 2.0),
        ("max(x) - min(x)", "m", |a| a / 2.0),
        ("max(x)/a", "s^2", |_| 0.5),
        ("first(x_dot > 0.5 m/s)", "s", |a| 0.5 / a),
        ("first(x >= 9 m)", "s", |_| f64::NAN),
        ("quantile(x_dot, 0.25)", "m/s", |a| a / 4.0),
        ("max(m*x_dot^2/2) - energy.kinetic", "N*m", |_| 0.0),
        ("max(t*x_dot)", "m", |a| a),
        ("x - 20 cm", "m", |a| a / 2.0 - 0.2),
        ("max(hypot(3*block.x, 4*x))", "m", |a| 2.5 * a),
        ("max(if x_dot > 0.5 m/s then x_dot else 0)", "m/s", |a| a),
        ("sqrt(2*x/a)@0.25", "s", |_| 0.25),
    ];
    request.outputs = expected.iter().map(|(text, ..)| (*text).to_owned()).collect();
    let study = Study::prepare(request).expect("a study");
    for (output, (text, unit, _)) in study.outputs().iter().zip(&expected) {
        assert_eq!(output.unit, *unit, "{text}");
        assert!(output.name.contains("state.") || output.name == *text, "{}", output.name);
    }
    for row in study.rows(0..4, 1, &Monitor::default()).expect("threads").expect("an end") {
        for (found, (text, _, value)) in row.outputs.iter().zip(&expected) {
            let value = value(row.inputs[0]);
            let is_same = (found - value).abs() < 1e-9 || found.is_nan() && value.is_nan();
            assert!(is_same, "{text}: {found} for {value}");
        }
    }

    // Faults are told, each in its own words.
    let faults = [
        ("max(x) + max(x_dot)", "add"),
        ("max(max(x))", "one number already"),
        ("first(x)", "what"),
        ("quantile(x, 95)", "part of the time"),
        ("sin(x)", "unit"),
        ("max(x)@0.5", "one number"),
        ("x^y", "no signal `y`"),
        ("max(x) quux", "no output"),
    ];
    for (text, word) in faults {
        let axis = Axis::parse("a", "1,2").expect("an axis").expect("an axis");
        let plan = Plan::new(vec![axis], Design::Grid).expect("a plan");
        let mut request = Request::new(FALLING, "block", plan);
        request.outputs = vec![text.to_owned()];
        let fault = Study::prepare(request).expect_err(text).0.swap_remove(0);
        assert_eq!(fault.code, codes::UNKNOWN_OUTPUT, "{text}");
        assert!(fault.message.contains(word), "{text}: {}", fault.message);
    }
}
