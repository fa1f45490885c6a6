//! A run that is killed at any moment leaves a log of whole samples, and goes on from it as if undisturbed.
//!
//! `BKSIM_KILLS` sets how many runs are killed.
#![cfg(unix)]
#![expect(clippy::print_stdout, reason = "the numbers of a long run are worth reading")]

mod common;

use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};
use std::{env, fs};

use common::{Scratch, text};

/// A pendulum with a sample every millisecond.
const LONG: &str = include_str!("../../../tests/fixtures/long-pendulum.toml");
/// The largest part of the runs that may lose more than a quarter of a second, as other work delays them.
const SLOW: f64 = 0.1;

/// A run that ends with the test.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn done(place: &Scratch, arguments: &str) -> String {
    let output = place.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn a_killed_run_goes_on_as_if_undisturbed() {
    let n_kills = env::var("BKSIM_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(6_u64);
    let place = Scratch::new();
    place.write("long.toml", LONG.replace("1e6 s", "90 s"));
    let begun = Instant::now();
    done(&place, "solve long.toml -o whole.mcap");
    let mut lasts = begun.elapsed();
    let whole = done(&place, "export whole.mcap");

    let log = place.path().join("long.mcap");
    let (mut n_resumed, mut n_slow) = (0, 0);
    for k in 0..n_kills {
        let _ = fs::remove_file(&log);
        let mut command = place.bksim();
        command.args(["solve", "long.toml"]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut run = Killed(command.spawn().expect("bksim starts"));
        // Some moment of the run: the golden ratio spreads them evenly.
        let part = (0.618_033_988_75 * k as f64).fract();
        sleep(lasts.mul_f64(0.2 + 0.7 * part));
        run.0.kill().expect("a kill");
        let killed = SystemTime::now();
        if run.0.wait().expect("an end").success() {
            // The machine has less else to do than before.
            lasts = lasts.mul_f64(0.8);
            continue;
        }
        let Ok(file) = fs::metadata(&log) else { continue };
        let lost = killed.duration_since(file.modified().expect("a time")).unwrap_or_default();
        n_slow += u64::from(lost > Duration::from_millis(250));

        // What can be read is a beginning of the whole run: every row, to its last number.
        let output = place.run("export long.mcap");
        let kept = text(&output.stdout);
        assert!(whole.starts_with(&kept) && kept.ends_with('\n'), "run {k}: {}", last_line(&kept));

        if kept == whole {
            continue;
        }
        // It goes on from there; one that was killed at its very beginning says so.
        let output = place.run("solve --resume long.mcap --force");
        let said = text(&output.stderr);
        if output.status.code() == Some(1) {
            assert!(said.contains("says nothing to go on from"), "run {k}: {said}");
            assert!(kept.len() < whole.len() / 2, "run {k}: {} bytes", kept.len());
            continue;
        }
        assert_eq!(output.status.code(), Some(0), "run {k}: {said}");
        assert!(done(&place, "export long-resumed.mcap") == whole, "run {k}: other samples");
        n_resumed += 1;
    }
    println!("{n_resumed} of {n_kills} killed runs resumed, {n_slow} had lost more than 0.25 s");
    assert!(2 * n_resumed >= n_kills, "{n_resumed} of {n_kills} were resumed");
    assert!(
        n_slow as f64 <= 1.0 + SLOW * n_kills as f64,
        "{n_slow} of {n_kills} lost more than 0.25 s"
    );
}

fn last_line(table: &str) -> &str {
    table.lines().last().unwrap_or_default()
}

#[test]
fn a_damaged_log_is_refused_or_goes_on_to_the_same_run() {
    let place = Scratch::new();
    place.write("long.toml", LONG.replace("1e6 s", "30 s"));
    done(&place, "solve long.toml -o whole.mcap");
    let whole = done(&place, "export whole.mcap");
    let bytes = killed(&place);

    let n_flips = 30;
    let (mut n_refused, mut n_same) = (0, 0);
    for k in 0..n_flips {
        // Half of the bits are in the description of the run, ahead of its samples.
        let n_bytes = if k % 2 == 0 { bytes.len().min(20_000) } else { bytes.len() };
        let bit = (1_000_003 * (k + 1)) % (8 * n_bytes);
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        place.write("long.mcap", &damaged);
        let output = place.run("solve --resume long.mcap --force");
        match output.status.code() {
            Some(0) => {
                assert!(done(&place, "export long-resumed.mcap") == whole, "bit {bit} changes it");
                n_same += 1;
            }
            Some(1) => n_refused += 1,
            _ => panic!("bit {bit}: {}", text(&output.stderr)),
        }
    }
    println!("of {n_flips} damaged logs {n_refused} are refused, {n_same} go on");
    assert!(n_refused > n_flips / 4, "{n_refused} are refused, {n_same} go on");
}

/// The log of a run that was killed after it had saved its state.
fn killed(place: &Scratch) -> Vec<u8> {
    let log = place.path().join("long.mcap");
    let is_saved = || text(&place.run("info long.mcap").stdout).contains("resumable");
    for _ in 0..20 {
        let _ = fs::remove_file(&log);
        let mut command = place.bksim();
        command.args(["solve", "long.toml"]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut run = Killed(command.spawn().expect("bksim starts"));
        while run.0.try_wait().expect("a state").is_none() {
            if log.exists() && is_saved() {
                break;
            }
            sleep(Duration::from_millis(20));
        }
        run.0.kill().expect("a kill");
        run.0.wait().expect("an end");
        if is_saved() {
            return fs::read(&log).expect("a log");
        }
    }
    panic!("no run was killed between its first state and its end");
}
