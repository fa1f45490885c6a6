//! A film that is stopped from outside.
#![cfg(unix)]

#[path = "../../cli/tests/common/mod.rs"]
mod common;

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::{Scratch, text};

/// A pendulum that swings for long.
const LONG: &str = r#"
[bodies.bob]
mass = "1 kg"
inertia = 0
com = [0, "-1 m"]

[joints.A]
type = "revolute"
between = ["ground", "bob"]

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[initial]
A = { angle = "30 deg" }

[solve]
t_end = "100 s"
every = "1 ms"
"#;

/// A run of the command that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_film_that_no_disk_should_hold_is_refused_with_its_size() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    let output = place.run("render long.toml -o long.gif --speed 0.01 --size 400x400");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("would have 250000 frames and could take 40 GB"), "{said}");
    assert_eq!(fs::read_dir(place.path()).expect("the directory").count(), 1);
}

#[test]
fn a_film_that_is_interrupted_leaves_nothing_behind() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    let child = place
        .bksim()
        .args(["render", "long.toml", "-o", "long.gif", "--speed", "0.1", "--size", "400x400"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("bksim starts");
    let mut child = Running(child);
    let begun = Instant::now();
    let names = || -> Vec<String> {
        let entries = fs::read_dir(place.path()).expect("the directory");
        let name = |entry: fs::DirEntry| entry.file_name().into_string().expect("a name");
        entries.map(|entry| name(entry.expect("an entry"))).collect()
    };
    while !names().iter().any(|name| name.contains(".gif.")) {
        assert!(begun.elapsed() < Duration::from_mins(1), "no film is begun");
        sleep(Duration::from_millis(20));
    }
    let kill = Command::new("kill").args(["-INT", &child.0.id().to_string()]).status();
    assert!(kill.expect("kill starts").success());
    let status = child.0.wait().expect("it ends");
    assert_eq!(status.code(), Some(130));
    assert_eq!(names(), ["long.toml"]);
}
