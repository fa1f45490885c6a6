//! [`Measure`]: the speed of a window, and a picture of it.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{ColorImage, Context};

use super::options::WindowOptions;
use super::report::{Figures, Outcome};
use crate::renderer::Counts;

/// Measures the speed of a window, and takes a picture of it.
pub(super) struct Measure {
    started: Instant,
    shot_after: Option<Duration>,
    /// Number of frames to count, if requested.
    n_requested: Option<usize>,
    /// Instant at which the files had been read for the first time.
    loaded_at: Option<Instant>,
    /// True if a frame with a motion has been laid out.
    has_motion: bool,
    first_frame: Option<Duration>,
    /// Instant of the first of the counted frames.
    counted_from: Option<Instant>,
    n_frames: usize,
    /// Duration of the counted frames, s.
    seconds: f64,
    /// Work of the window's thread on the counted frames, s.
    cpu_seconds: f64,
    counts: Counts,
    /// The picture, from the thread that takes it.
    shot: Arc<Mutex<Option<Arc<ColorImage>>>>,
    is_shot_requested: bool,
    png: Option<Vec<u8>>,
}

impl Measure {
    pub(super) fn new(options: &WindowOptions) -> Self {
        Self {
            started: options.started,
            shot_after: options.shot_after,
            n_requested: options.n_frames,
            loaded_at: None,
            has_motion: false,
            first_frame: None,
            counted_from: None,
            n_frames: 0,
            seconds: 0.0,
            cpu_seconds: 0.0,
            counts: Counts::default(),
            shot: Arc::default(),
            is_shot_requested: false,
            png: None,
        }
    }

    /// Notes that the files have been read.
    pub(super) fn mark_loaded(&mut self) {
        self.loaded_at.get_or_insert_with(Instant::now);
    }

    /// Takes the cost of the previous frame, s.
    pub(super) fn begin_frame(&mut self, cpu_usage: Option<f32>) {
        let Some(from) = self.counted_from else { return };
        if self.n_requested.is_some_and(|n| self.n_frames >= n) {
            return;
        }
        self.n_frames += 1;
        self.seconds = from.elapsed().as_secs_f64();
        self.cpu_seconds += f64::from(cpu_usage.unwrap_or_default());
    }

    /// Takes the renderer's counts of a frame.
    pub(super) fn count(&mut self, counts: Counts) {
        self.counts = counts;
    }

    /// Notes that a frame was laid out, and requests repaints for the measurements that are
    /// missing; returns whether the previous frame was the first that showed a motion.
    pub(super) fn end_frame(&mut self, context: &Context, has_motion: bool) -> bool {
        // A frame is visible when the next one begins.
        let is_first = self.has_motion && self.first_frame.is_none();
        if is_first {
            self.first_frame = Some(self.started.elapsed());
        }
        if has_motion && !self.has_motion {
            context.request_repaint();
        }
        self.has_motion |= has_motion;
        if self.n_requested.is_some() {
            context.request_repaint();
            if self.loaded_at.is_some() {
                self.counted_from.get_or_insert_with(Instant::now);
            }
        }
        self.take_shot(context);
        is_first
    }

    /// True if there was a request, and all requests are done.
    pub(super) fn is_done(&self) -> bool {
        let has_shot = self.shot_after.is_none() || self.png.is_some();
        let has_frames = self.n_requested.is_none_or(|n| self.n_frames >= n);
        (self.shot_after.is_some() || self.n_requested.is_some()) && has_shot && has_frames
    }

    /// Writes the measurements so far into the outcome.
    pub(super) fn write_into(&mut self, outcome: &mut Outcome) {
        let n = self.n_frames as f64;
        let per_frame = |sum: f64| if n > 0.0 { Some(sum / n) } else { None };
        outcome.figures = Figures {
            first_frame_s: self.first_frame.map(|time| time.as_secs_f64()),
            n_frames: self.n_frames,
            frames_per_second: per_frame(self.seconds).map(|seconds| 1.0 / seconds),
            cpu_s_per_frame: per_frame(self.cpu_seconds),
            n_draws: self.counts.n_draws,
            n_primitives: self.counts.n_primitives,
            n_bytes: self.counts.n_bytes,
        };
        if outcome.png.is_none() {
            outcome.png.clone_from(&self.png);
        }
    }

    /// Requests the picture when it is time, and takes it when it is there.
    fn take_shot(&mut self, context: &Context) {
        let (Some(after), Some(loaded_at)) = (self.shot_after, self.loaded_at) else { return };
        let waited = loaded_at.elapsed();
        if waited < after {
            context.request_repaint_after(after.saturating_sub(waited));
        } else if !self.is_shot_requested {
            self.is_shot_requested = true;
            let (shot, waking) = (Arc::clone(&self.shot), context.clone());
            context.request_screenshot(move |image| {
                *shot.lock().unwrap_or_else(PoisonError::into_inner) = Some(image);
                waking.request_repaint();
            });
            context.request_repaint();
        } else if let Some(image) = self.shot.lock().unwrap_or_else(PoisonError::into_inner).take()
        {
            self.png = encoded(&image);
        }
    }
}

/// A picture as PNG.
fn encoded(image: &ColorImage) -> Option<Vec<u8>> {
    let side = |n: usize| u32::try_from(n).expect("a window has fewer than 2^32 pixels a side");
    let [width, height] = image.size.map(side);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(image.as_raw()).ok()?;
    writer.finish().ok()?;
    Some(bytes)
}
