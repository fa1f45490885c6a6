//! A logged run played back: at the instants of its samples it is the run, bit for bit or nearly, and
//! between them it is what a run with more samples has there.

use crate::support::{Within, close, derive, example_names, example_text, model};
use bksim::dae::Control;
use bksim::log::{LogReader, Outcome, Record};
use bksim::model::Method;
use bksim::playback::{Playback, PlaybackError};
use bksim::record::Recorder;
use bksim::sim::run::{Observer, Sample, Segment};
use bksim::sim::sensitivity::StateSensitivity;
use bksim::{Mechanism, VERSION};

/// Keeps a run and writes its log.
struct Kept {
    samples: Vec<Sample>,
    recorder: Recorder<Vec<u8>>,
}

impl Observer for Kept {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.samples.push(sample.clone());
        self.recorder.write(sample).expect("written");
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.recorder.segment(segment).expect("written");
    }
}

/// The samples of a run and its log.
fn logged(mechanism: &Mechanism, text: &str) -> (Vec<Sample>, Vec<u8>) {
    let start = mechanism.start().expect("a start");
    let simulation = mechanism.simulation().expect("equations");
    let recorder = Recorder::create(Vec::new(), &simulation, text, &start, &[]).expect("a log");
    let mut kept = Kept { samples: Vec::new(), recorder };
    let summary = simulation.run(&start, &mut kept, &|| false).expect("a run");
    let bytes = kept.recorder.finish(&summary, Outcome::ReachedEnd, "done").expect("written");
    (kept.samples, bytes)
}

fn played(bytes: &[u8]) -> Playback {
    let log = LogReader::open(bytes).expect("a log");
    Playback::open(log).unwrap_or_else(|e| panic!("{e}"))
}

/// Compares everything that lasts.
fn same(what: &str, found: &Sample, expected: &Sample, within: f64) {
    let parts = |s: &Sample| -> Vec<(String, f64)> {
        let energy = [s.energy.kinetic, s.energy.potential, s.energy.power];
        let named = |name: &'static str, values: &[f64]| {
            values.iter().enumerate().map(|(i, &x)| (format!("{name}[{i}]"), x)).collect::<Vec<_>>()
        };
        let mut all = named("q", &s.q);
        all.extend(named("v", &s.v));
        all.extend(named("a", &s.a));
        all.extend(named("lambda", &s.lambda));
        all.extend(named("reactions", s.reactions.as_flattened()));
        all.extend(named("energy", &energy));
        all
    };
    let size = parts(expected).iter().fold(1.0_f64, |size, (_, x)| size.max(x.abs()));
    let expected_t = expected.t;
    for ((name, found), (_, expected)) in parts(found).into_iter().zip(parts(expected)) {
        let what = format!("{what}, t = {expected_t}: {name}");
        close(&what, found, expected, Within { absolute: within * size, relative: within });
    }
}

#[test]
fn at_its_samples_a_playback_is_the_run() {
    for name in example_names() {
        let text = example_text(&name);
        for method in [Method::Auto, Method::Radau] {
            let mut model = model(&text);
            model.solve.method = method;
            let mechanism = derive(model);
            let (samples, bytes) = logged(&mechanism, &text);
            let mut playback = played(&bytes);
            assert_eq!(playback.span(), [samples[0].t, samples[samples.len() - 1].t]);
            for sample in samples.iter().step_by(7) {
                let found = playback.seek(sample.t).expect("a sample");
                same(&format!("{name}, {method:?}"), found, sample, 1e-9);
            }
        }
    }
}

#[test]
fn between_its_samples_a_playback_is_a_run_with_more_samples() {
    let text = example_text("slider-crank");
    // One method for both: `auto` takes another one where outputs are few.
    let mut few = model(&text);
    few.solve.method = Method::Explicit;
    few.solve.every = Some(0.5 * few.solve.t_end);
    let mut many = model(&text);
    many.solve.method = Method::Explicit;
    many.solve.every = Some(many.solve.t_end / 97.0);
    let (samples, bytes) = logged(&derive(few), &text);
    assert_eq!(samples.len(), 3);
    let (samples, _) = logged(&derive(many), &text);
    let mut playback = played(&bytes);
    for sample in &samples {
        same("slider-crank", playback.seek(sample.t).expect("a sample"), sample, 1e-9);
    }
}

#[test]
fn contacts_and_friction_are_played_in_the_modes_they_had() {
    let text = include_str!("../fixtures/stop-and-friction.toml");
    let mechanism = derive(model(text));
    let (samples, bytes) = logged(&mechanism, text);
    let mut playback = played(&bytes);
    let n_modes = playback.log().segments.iter().map(|s| s.modes.clone());
    let n_modes = n_modes.collect::<Vec<_>>();
    assert!(n_modes.iter().any(|modes| *modes != n_modes[0]), "nothing has switched");
    for sample in &samples {
        same("block", playback.seek(sample.t).expect("a sample"), sample, 1e-9);
    }
}

#[test]
fn sampled_signals_are_played_as_they_were_held() {
    let text = include_str!("../fixtures/elements/encoder-quantised.toml");
    let text = text.replace("every = 0.02", "every = 0.0013");
    for method in [Method::Explicit, Method::Radau] {
        let mut model = model(&text);
        model.solve.method = method;
        let mechanism = derive(model);
        let (samples, bytes) = logged(&mechanism, &text);
        let mut playback = played(&bytes);
        for sample in &samples {
            let found = playback.seek(sample.t).expect("a sample");
            same("encoder", found, sample, 1e-9);
            assert_eq!(found.signals, sample.signals, "{method:?}, t = {}", sample.t);
        }
        // At a tick, what follows it.
        let segments = playback.log().segments.clone();
        for segment in &segments {
            assert_eq!(playback.seek(segment.t0).expect("a sample").signals, segment.modes);
        }
        let is_jump = |pair: &&[Segment]| pair[0].modes != pair[1].modes;
        assert!(segments.windows(2).filter(is_jump).count() > 100);
    }
}

#[test]
fn signals_and_poses_are_those_of_the_instant() {
    let text = example_text("slider-crank");
    let mechanism = derive(model(&text));
    let (samples, bytes) = logged(&mechanism, &text);
    let mut playback = played(&bytes);
    let names: Vec<String> = playback.channels().signals().map(|(_, name, _)| name).collect();
    assert!(names.contains(&"energy.total".to_owned()), "{names:?}");
    assert!(playback.signal("energy.work").is_none(), "work is gathered on the way");
    let first = playback.signal(&names[0]).expect("the first coordinate");
    let t = samples[40].t;
    playback.seek(t).expect("a sample");
    let found = playback.value(first);
    close(
        "the first coordinate",
        found,
        samples[40].q[0],
        Within { absolute: 1e-9, relative: 0.0 },
    );
    assert_eq!(playback.poses().len(), mechanism.model.bodies.len());
    // Outside of the run its ends are shown.
    assert_eq!(playback.seek(-5.0).expect("a sample").t, samples[0].t);
    assert_eq!(playback.seek(f64::INFINITY).expect("a sample").t, samples[samples.len() - 1].t);
}

#[test]
fn a_log_without_motion_says_so() {
    let text = example_text("slider-crank");
    let mechanism = derive(model(&text));
    let start = mechanism.start().expect("a start");
    let simulation = mechanism.simulation().expect("equations");
    let recorder = Recorder::create(Vec::new(), &simulation, &text, &start, &[]).expect("a log");
    let summary = bksim::sim::run::Summary::default();
    let bytes = recorder.finish(&summary, Outcome::Stopped, "at once").expect("written");
    let log = LogReader::open(&bytes[..]).expect("a log");
    assert_eq!(log.header().version, VERSION);
    assert!(matches!(Playback::open(log), Err(PlaybackError::NoMotion)));
    let mut log = LogReader::open(&bytes[..]).expect("a log");
    assert!(!matches!(log.next_record().expect("readable"), Some(Record::Segment(_))));
}

#[test]
fn a_log_has_the_values_of_the_simulation_that_moved() {
    let text = example_text("slider-crank");
    let mechanism = derive(model(&text));
    let mut simulation = mechanism.simulation().expect("equations");
    let mut values = simulation.parameters().to_vec();
    for value in &mut values {
        *value *= 1.01;
    }
    simulation.set_parameters(&values);
    let mut options = simulation.options().clone();
    options.t_end *= 0.5;
    simulation.set_options(&options);

    let start = simulation.start().expect("a start");
    let recorder = Recorder::create(Vec::new(), &simulation, &text, &start, &[]).expect("a log");
    let mut kept = Kept { samples: Vec::new(), recorder };
    let summary = simulation.run(&start, &mut kept, &|| false).expect("a run");
    let bytes = kept.recorder.finish(&summary, Outcome::ReachedEnd, "done").expect("written");
    let log = LogReader::open(&bytes[..]).expect("a log");
    assert_eq!(log.header().t_end, options.t_end);
    for (parameter, value) in mechanism.model.parameters.iter().zip(&values) {
        assert_eq!(log.header().parameters[&parameter.name].value, *value, "{}", parameter.name);
    }
    let mut playback = played(&bytes);
    assert_eq!(playback.mechanism().parameters, values);
    for sample in kept.samples.iter().step_by(7) {
        same("with other values", playback.seek(sample.t).expect("a sample"), sample, 1e-9);
    }
}

#[test]
fn no_number_that_is_not_finite_gets_into_a_log() {
    let text = example_text("slider-crank");
    let mechanism = derive(model(&text));
    let simulation = mechanism.simulation().expect("equations");
    let samples = simulation.solve().expect("a run").samples;
    let start = simulation.start().expect("a start");
    for bad in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let recorder = Recorder::create(Vec::new(), &simulation, &text, &start, &[]);
        let mut log = recorder.expect("a log");
        log.write(&samples[0]).expect("finite");
        let mut sample = samples[1].clone();
        sample.reactions[1][2] = bad;
        let refused = log.write(&sample).expect_err("not finite").to_string();
        let name = format!("`reactions.{}.fz`", mechanism.model.joints[1].name);
        assert!(refused.starts_with(&name) && refused.contains(&format!("{bad}")), "{refused}");
    }
}
