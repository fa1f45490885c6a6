//! The window under a virtual display with a software adapter: it opens, plays, follows its size and
//! its file, and survives a broken model. Needs Xvfb, xdotool and a Vulkan driver.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

/// Names of the packages, where they are missing.
const HINT: &str = "on Debian: apt-get install xvfb xdotool mesa-vulkan-drivers libxkbcommon-x11-0";

/// How long a machine with other things to do may take for anything.
const PATIENCE: Duration = Duration::from_mins(1);

/// A display of our own, which goes with the test.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn new() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1600x1000x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| panic!("Xvfb does not start: {error}; {HINT}"));
        let mut line = String::new();
        let stdout = server.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut line).expect("the number of the display");
        assert!(!line.trim().is_empty(), "Xvfb has no display; {HINT}");
        Self { server, name: format!(":{}", line.trim()) }
    }

    /// `bksim view` on this display.
    fn view(&self, place: &Scratch, arguments: &str) -> Command {
        self.bksim(place, &format!("view {arguments}"))
    }

    /// `bksim` on this display.
    fn bksim(&self, place: &Scratch, arguments: &str) -> Command {
        let mut command = place.bksim();
        command.args(arguments.split_whitespace());
        command.env("DISPLAY", &self.name).env_remove("WAYLAND_DISPLAY");
        command.env("XDG_RUNTIME_DIR", place.path());
        command
    }

    /// Runs it to its end and reads its object.
    fn report(&self, place: &Scratch, arguments: &str) -> Value {
        let output = self.view(place, &format!("{arguments} --json")).output().expect("it starts");
        assert!(
            output.status.success(),
            "{}{}; {HINT}",
            text(&output.stdout),
            text(&output.stderr)
        );
        assert_eq!(text(&output.stderr), "");
        serde_json::from_slice(&output.stdout).expect("one object")
    }

    /// Waits for the window of that title.
    fn window(&self, title: &str) -> String {
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            let id = self.xdotool(&["search", "--onlyvisible", "--name", title]);
            if !id.is_empty() {
                return id;
            }
            thread::sleep(Duration::from_millis(100));
        }
        panic!("no window `{title}`; {HINT}");
    }

    /// Does something to a window.
    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool").env("DISPLAY", &self.name).args(arguments).output();
        let output = output.unwrap_or_else(|error| panic!("xdotool: {error}; {HINT}"));
        text(&output.stdout).trim().to_owned()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A window that stays open while the test does something to its files.
struct Open {
    child: Child,
    lines: Receiver<String>,
    told: String,
}

impl Open {
    fn new(mut command: Command) -> Self {
        let mut child = command.stderr(Stdio::piped()).spawn().expect("it starts");
        let stderr = BufReader::new(child.stderr.take().expect("piped"));
        let (sender, lines) = channel();
        thread::spawn(move || {
            for line in stderr.lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        Self { child, lines, told: String::new() }
    }

    /// Waits until it tells this on stderr.
    fn tells(&mut self, words: &str) {
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            if let Ok(line) = self.lines.recv_timeout(Duration::from_millis(100)) {
                self.told.push_str(&line);
                self.told.push('\n');
                if line.contains(words) {
                    return;
                }
            }
        }
        panic!("`{words}` is not told; but this:\n{}{HINT}", self.told);
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn four_bar() -> Scratch {
    let place = Scratch::new();
    place.write("four-bar.toml", model());
    place
}

fn model() -> String {
    let path = format!("{CRATE}/../../examples/four-bar/model.toml");
    std::fs::read_to_string(path).expect("an example")
}

/// Width, height, and the pixels of a picture.
fn pixels(place: &Scratch, name: &str) -> ([u32; 2], Vec<u8>) {
    let file = std::fs::File::open(place.path().join(name)).expect("a picture");
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    bytes.truncate(info.buffer_size());
    ([info.width, info.height], bytes)
}

/// The part of two pictures of one size that differs by more than a shade.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.chunks(4).zip(b.chunks(4));
    let differs = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 8);
    pairs.clone().filter(differs).count() as f64 / pairs.count() as f64
}

#[test]
fn it_shows_the_instant_asked_for_and_plays() {
    let (display, place) = (Display::new(), four_bar());
    let shot = "--size 640x420 --light --screenshot";
    let report = display
        .report(&place, &format!("four-bar.toml {shot} still.png --paused --t 0.25 --after 1"));
    assert!(report["first_frame_s"].as_f64().is_some_and(|s| s > 0.0), "{report}");
    assert_eq!((report["loads"].as_u64(), report["faulty_loads"].as_u64()), (Some(1), Some(0)));
    assert_eq!(report["draw_calls"], 1);
    assert_eq!(report["screenshot"], "still.png");
    let (size, still) = pixels(&place, "still.png");
    assert_eq!(size, [640, 420]);

    // The same instant again is the same picture, another one and the running clock are not.
    for (arguments, range) in [
        ("again.png --paused --t 0.25 --after 1", 0.0..0.001),
        ("later.png --paused --t 0.6 --after 1", 0.005..0.5),
        ("played.png --t 0.25 --after 1", 0.003..0.5),
    ] {
        display.report(&place, &format!("four-bar.toml {shot} {arguments}"));
        let name = arguments.split(' ').next().expect("a name");
        let other = difference(&still, &pixels(&place, name).1);
        assert!(range.contains(&other), "{name}: {other}");
    }

    // Most of the window is the picture's background; something is in it.
    let white = still.chunks(4).filter(|pixel| pixel[..3] == [255, 255, 255]).count();
    let part = white as f64 / (still.len() / 4) as f64;
    assert!((0.5..0.98).contains(&part), "{part} of the window is empty");
}

#[test]
fn it_measures_frames_of_a_log() {
    let (display, place) = (Display::new(), four_bar());
    assert!(place.run("solve four-bar.toml -o run.mcap").status.success());
    let report = display.report(&place, "run.mcap --size 500x400 --frames 5");
    assert_eq!(report["frames"], 5);
    for key in ["frames_per_second", "cpu_s_per_frame", "primitives", "bytes_per_frame"] {
        assert!(report[key].as_f64().is_some_and(|x| x > 0.0), "{key}: {report}");
    }
    // The keys are those of the page.
    let page = std::fs::read_to_string(format!("{CRATE}/../../docs/json.md")).expect("the page");
    let section = page.split("## `view`").nth(1).expect("the section");
    let section = section.split("\n## ").next().expect("its end");
    let keys = section.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let told = report.as_object().expect("an object").keys().map(String::as_str);
    let told = told.filter(|key| !["ok", "command"].contains(key));
    assert_eq!(told.collect::<Vec<_>>(), keys.collect::<Vec<_>>());
}

#[test]
fn it_follows_its_size_and_its_file_and_survives_a_broken_model() {
    let (display, place) = (Display::new(), four_bar());
    let mut window = Open::new(
        display.view(&place, "four-bar.toml --size 640x420 --screenshot end.png --after 600"),
    );
    let id = display.window("four-bar.toml");

    // Another size: the window goes on.
    display.xdotool(&["windowsize", "--sync", &id, "900", "560"]);
    // Saved in place with another parameter.
    place.write("four-bar.toml", model().replace("speed = \"60 rpm\"", "speed = \"30 rpm\""));
    window.tells("is shown anew");
    // Broken: the fault is told with its place, and the window stays.
    place.write("four-bar.toml", model().replace("mass = \"0.8 kg\"", "mas = \"0.8 kg\""));
    window.tells("four-bar.toml:21:1");
    // Put right by an editor that writes a second file and renames it.
    place.write("four-bar.toml.new", model());
    let (from, to) = (place.path().join("four-bar.toml.new"), place.path().join("four-bar.toml"));
    std::fs::rename(from, to).expect("renamed");
    window.tells("is shown anew");
    assert!(window.child.try_wait().expect("its state").is_none(), "it is still open");

    // Closed like a window that is closed by hand.
    display.xdotool(&["windowfocus", "--sync", &id]);
    display.xdotool(&["key", "ctrl+q"]);
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        if let Some(status) = window.child.try_wait().expect("its state") {
            assert!(status.success(), "{status}");
            return;
        }
        thread::sleep(Duration::from_millis(50));
    }
    panic!("it does not close");
}

#[test]
fn a_fault_at_the_start_is_shown_and_counted() {
    let (display, place) = (Display::new(), four_bar());
    place.write("bad.toml", "[bodies.b]\nmas = 1\n");
    let report =
        display.report(&place, "bad.toml --size 500x400 --dark --screenshot bad.png --after 0.5");
    assert_eq!((report["loads"].as_u64(), report["faulty_loads"].as_u64()), (Some(1), Some(1)));
    assert!(report["first_frame_s"].is_null());
    assert_eq!(pixels(&place, "bad.png").0, [500, 400]);
}

#[test]
fn a_figure_opens_in_a_window_with_its_curves() {
    let (display, place) = (Display::new(), four_bar());
    assert!(place.run("solve four-bar.toml -o run.mcap").status.success());
    let shoot = |name: &str, arguments: &str| {
        let arguments = format!(
            "plot run.mcap {arguments} --window --size 640x420 --screenshot {name} --after 1 --json"
        );
        let output = display.bksim(&place, &arguments).output().expect("it starts");
        assert!(output.status.success(), "{}; {HINT}", text(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).expect("one object");
        assert_eq!((&report["format"], &report["screenshot"]), (&"window".into(), &name.into()));
        let (size, pixels) = pixels(&place, name);
        assert_eq!(size, [640, 420]);
        pixels
    };
    let has = |pixels: &[u8], [r, g, b]: [u8; 3]| {
        let is_near = |pixel: &&[u8]| {
            pixel[0].abs_diff(r) < 12 && pixel[1].abs_diff(g) < 12 && pixel[2].abs_diff(b) < 12
        };
        pixels.chunks(4).filter(is_near).count()
    };
    // The background, and the first and the second colour of curves: those of pictures.
    let light = shoot("light.png", "energy.kinetic energy.total --theme light");
    assert!(has(&light, [0xff, 0xff, 0xff]) > 100_000);
    assert!(has(&light, [0x2f, 0x6f, 0xb5]) > 300 && has(&light, [0xd9, 0x76, 0x1c]) > 300);
    let dark = shoot("dark.png", "energy.kinetic --theme dark");
    assert!(has(&dark, [0xff, 0xff, 0xff]) < 100 && has(&dark, [0x5a, 0x9b, 0xe0]) > 300);
    assert_eq!(has(&dark, [0xf0, 0x96, 0x48]), 0, "no second curve");
}

#[test]
fn a_figure_without_a_display_says_so_and_names_are_checked_before() {
    let place = four_bar();
    assert!(place.run("solve four-bar.toml -o run.mcap").status.success());
    let mut command = place.bksim();
    command.args(["plot", "run.mcap", "--window"]);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let output = command.output().expect("it starts");
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(told.contains("there is no display") && told.contains("without --window"), "{told}");
    for (arguments, status, words) in [
        ("--window -o run.svg", 2, "cannot be used with"),
        ("--screenshot run.png", 2, "--window"),
        ("--window --screenshot run.mcap", 4, "is the log itself"),
        ("--window --size 20x20", 2, "from 200 to 10000"),
    ] {
        let output = place.run(&format!("plot run.mcap {arguments}"));
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {told}");
        assert!(told.contains(words), "{arguments}: {told}");
    }
}

#[test]
fn a_window_whose_display_goes_away_ends_with_a_sentence() {
    let place = four_bar();
    let mut display = Display::new();
    let command = display.view(&place, "four-bar.toml");
    let mut open = Open::new(command);
    display.window("four-bar");
    thread::sleep(Duration::from_millis(500));
    display.server.kill().expect("a kill");
    open.tells("the display server has gone away");
    assert_eq!(open.child.wait().expect("an end").code(), Some(4), "{}", open.told);
    assert!(!open.told.contains("panicked"), "{}", open.told);
}

#[test]
fn without_a_display_or_an_adapter_it_says_so() {
    let place = four_bar();
    let mut command = place.bksim();
    command.args(["view", "four-bar.toml"]);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let output = command.output().expect("it starts");
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(told.contains("there is no display") && told.contains("bksim render"), "{told}");

    let display = Display::new();
    let mut command = display.view(&place, "four-bar.toml");
    let nowhere = place.path().join("none.json");
    command.env("VK_ICD_FILENAMES", &nowhere).env("VK_DRIVER_FILES", &nowhere);
    let output = command.output().expect("it starts");
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(told.contains("no graphics adapter") && told.contains("mesa-vulkan-drivers"), "{told}");

    // Before any window: what cannot be read, and what would be overwritten.
    let output = place.run("view missing.toml");
    assert_eq!(output.status.code(), Some(4));
    let output = place.run("view four-bar.toml --screenshot four-bar.toml --force");
    assert!(text(&output.stderr).contains("would be overwritten"));
}
