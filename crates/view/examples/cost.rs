//! Cost of a frame of a large mechanism:
//! `cargo run --release -p bksim-view --example cost -- 1000`.
//!
//! Double pendulums are drawn on a canvas without a window. The parts of a frame are timed one by
//! one: the motion at its instant, the additions to it, and the renderer's own work; not the
//! adapter's, which on a software adapter is the processor's work, too. The result of each part is
//! the median over all frames, which other work on the machine hardly affects. A second argument is
//! the number of points that leave trails: `cost -- 1000 2000`; the longest of all frames shows
//! then whether one blocked.

#![expect(clippy::print_stdout, reason = "the measurement is the result")]

use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bksim::Mechanism;
use bksim::solved::solve;
use bksim_scene::Theme;
use bksim_view::film::Stage;
use bksim_view::offscreen::Canvas;
use bksim_view::renderer::Frame;
use bksim_view::show::Show;

/// Number of measured frames.
const N_FRAMES: u32 = 50;

/// Time that a window spends on trails in a frame.
const PATIENCE: Duration = Duration::from_millis(3);

/// Double pendulums in a square, `n` bodies, over a fifth of a second.
fn pendulums(n: usize) -> String {
    let n_columns = (1..=n).find(|side| 2 * side * side >= n).unwrap_or(1);
    let mut text = String::new();
    let mut line = |arguments: std::fmt::Arguments<'_>| {
        text.write_fmt(arguments).expect("text takes everything");
    };
    let pairs = n.div_ceil(2);
    line(format_args!("[ground]\npoints = {{"));
    for i in 0..pairs {
        let comma = if i == 0 { "" } else { "," };
        let (x, y) = (3 * (i % n_columns), 3 * (i / n_columns));
        line(format_args!("{comma} P{i} = [\"{x} m\", \"{y} m\"]"));
    }
    line(format_args!(" }}\n"));
    for body in 0..2 * pairs {
        line(format_args!("[bodies.b{body}]\nmass = \"1 kg\"\ninertia = \"0.1 kg m^2\"\n"));
        line(format_args!("com = [\"0.5 m\", 0]\npoints = {{ E = [\"1 m\", 0] }}\n"));
        let (pair, second) = (body / 2, body % 2 == 1);
        let on = if second { format!("b{}.E", body - 1) } else { format!("ground.P{pair}") };
        line(format_args!("[joints.j{body}]\ntype = \"revolute\"\n"));
        line(format_args!("between = [\"{on}\", \"b{body}\"]\n"));
    }
    line(format_args!(
        "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n"
    ));
    line(format_args!("[solve]\nt_end = \"0.2 s\"\nrtol = 1e-4\natol = 1e-6\n"));
    text
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The motion.
    let n_bodies = std::env::args().nth(1).map_or(Ok(1000), |n| n.parse())?;
    let text = pendulums(n_bodies);
    let begun = Instant::now();
    let mechanism = Mechanism::from_toml(&text, "pendulums")?;
    let solved = solve(mechanism, &text, &|_| true)?;
    println!("{n_bodies} bodies, derived and solved in {:.2} s", begun.elapsed().as_secs_f64());

    // A canvas with the scene, and the trails.
    let mut canvas = Canvas::new([1280, 720], 1.0)?;
    let mut stage = Stage::new(Show::new(solved.playback), Theme::LIGHT, None, canvas.points())?;
    canvas.scene_mut().set_scene(Arc::clone(stage.show.scene()), &stage.theme);
    let [first, last] = stage.show.span();
    let n_trails = std::env::args().nth(2).map_or(Ok(0), |n| n.parse())?;
    let moving = stage.show.scene().markers.iter().enumerate().filter(|(_, m)| m.at.body != 0);
    let trails: Vec<usize> = moving.map(|(idx, _)| idx).take(n_trails).collect();
    println!("{} trails", trails.len());
    stage.show.options.trails = trails;
    stage.show.patience = Some(PATIENCE);

    // Times of the parts of all frames.
    let (mut seek, mut additions, mut prepare) = (Vec::new(), Vec::new(), Vec::new());
    let mut whole = Vec::new();
    let mut counts = bksim_view::renderer::Counts::default();
    for k in 0..N_FRAMES {
        let t = first + (last - first) * f64::from(k) / f64::from(N_FRAMES);
        let begun = Instant::now();
        stage.show.seek(t)?;
        seek.push(begun.elapsed());
        let begun = Instant::now();
        let extras = stage.show.extras()?;
        additions.push(begun.elapsed());
        let begun = Instant::now();
        let (camera, theme) = (&stage.camera, &stage.theme);
        let poses = stage.show.poses();
        counts = canvas.scene_mut().prepare(&Frame {
            poses,
            extras: &extras,
            camera,
            theme,
            pixels_per_point: 1.0,
        });
        prepare.push(begun.elapsed());
        let begun = Instant::now();
        stage.shoot(&mut canvas, t)?;
        whole.push(begun.elapsed());
    }

    print_times("motion at its instant", seek);
    print_times("additions", additions);
    print_times("renderer", prepare);
    print_times(&format!("with picture, on `{}`", canvas.adapter()), whole);
    println!(
        "{} draw calls, {} primitives, {} bytes a frame",
        counts.n_draws, counts.n_primitives, counts.n_bytes
    );
    Ok(())
}

/// Prints the median and the longest of some times.
fn print_times(name: &str, mut times: Vec<Duration>) {
    times.sort_unstable();
    let ms = |idx: usize| times.get(idx).map_or(0.0, |time| 1e3 * time.as_secs_f64());
    let (median, longest) = (ms(times.len() / 2), ms(times.len().saturating_sub(1)));
    println!("{name:<26}{median:8.3} ms a frame, at most {longest:.3} ms");
}
