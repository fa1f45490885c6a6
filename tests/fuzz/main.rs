//! Damaged inputs by the thousand: expressions, models, runs, drawings, logs and checkpoints. Each is answered
//! without a panic, in bounded time and memory.
//!
//! Every input follows from the name of its target and its number, so a finding is repeated by running the
//! suite again. `BKSIM_FUZZ=1000000 cargo test --workspace --test fuzz` spreads so many over all targets.
#![expect(clippy::print_stdout, reason = "the numbers of a long run are worth reading")]

mod damage;
mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use std::{env, thread};

use damage::{damaged, generator};
use targets::{TARGETS, Target};

/// Inputs over all targets in the ordinary run of tests: seconds.
const USUAL: u64 = 50_000;
/// One input takes milliseconds; this is a hang.
const PATIENCE: Duration = Duration::from_secs(20);
/// The largest size of the process at any time, kB.
const MOST_MEMORY_KB: u64 = 3 << 20;

/// The input at work.
#[derive(Default)]
struct Present {
    number: AtomicU64,
    bytes: Mutex<Vec<u8>>,
}

impl Present {
    fn set(&self, number: u64, bytes: &[u8]) {
        bytes.clone_into(&mut self.bytes.lock().expect("nobody panics with it"));
        self.number.store(number, Ordering::Relaxed);
    }
}

/// Watches that no input takes too long: a hang ends the process, and is shown.
fn watched<T>(name: &str, work: impl FnOnce(&Present) -> T) -> T {
    let (at, is_done) = (Present::default(), AtomicBool::new(false));
    thread::scope(|scope| {
        scope.spawn(|| {
            let (mut known, mut since) = (0, Instant::now());
            while !is_done.load(Ordering::Relaxed) {
                thread::sleep(Duration::from_millis(5));
                let now = at.number.load(Ordering::Relaxed);
                if now != known {
                    (known, since) = (now, Instant::now());
                } else if since.elapsed() > PATIENCE {
                    let bytes = at.bytes.lock().expect("nobody panics with it");
                    let shown = String::from_utf8_lossy(&bytes);
                    eprintln!("{name}: input {now} takes longer than {PATIENCE:?}:\n{shown}");
                    std::process::abort();
                }
            }
        });
        let result = work(&at);
        is_done.store(true, Ordering::Relaxed);
        result
    })
}

/// Numbers of the inputs at which a target panicked, and of those that it accepted.
fn attack(target: &Target, n: u64) -> (Vec<u64>, u64) {
    let seeds = (target.seeds)();
    assert!(!seeds.is_empty(), "{} has something to damage", target.name);
    let (mut failed, mut n_accepted) = (Vec::new(), 0);
    watched(target.name, |at| {
        for number in 1..=n {
            let mut random = generator(target.name, number);
            let bytes = damaged(&seeds, target.words, &mut random);
            at.set(number, &bytes);
            if let Ok(accepted) = catch_unwind(AssertUnwindSafe(|| (target.feed)(&bytes))) {
                n_accepted += u64::from(accepted);
            } else {
                eprintln!("{} {number}: {:?}", target.name, String::from_utf8_lossy(&bytes));
                failed.push(number);
            }
        }
    });
    (failed, n_accepted)
}

#[test]
fn damaged_inputs_are_answered() {
    let total = env::var("BKSIM_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(USUAL);
    let shares: u64 = TARGETS.iter().map(|target| target.share).sum();
    let chosen = env::var("BKSIM_FUZZ_TARGET").ok();
    let mut findings = Vec::new();
    for target in TARGETS {
        if chosen.as_ref().is_some_and(|name| name != target.name) {
            continue;
        }
        let n = total * target.share / shares + 1;
        let begun = Instant::now();
        let (failed, n_accepted) = attack(target, n);
        let seconds = begun.elapsed().as_secs_f64();
        println!("{}: {n} inputs, {n_accepted} accepted, {seconds:.1} s", target.name);
        assert!(n_accepted > 0 || n < 100, "{}: nothing gets past the first check", target.name);
        findings.extend(failed.iter().map(|number| format!("{} {number}", target.name)));
    }
    assert!(findings.is_empty(), "panics at {findings:?}");
    if let Some(peak) = peak_memory_kb() {
        println!("largest size of the process: {} MB", peak / 1000);
        assert!(peak < MOST_MEMORY_KB, "{peak} kB");
    }
}

/// The largest resident size of this process so far, kB, where the system tells it.
fn peak_memory_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}
