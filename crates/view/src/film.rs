//! Films: pictures at even instants, encoded one after another and never held together.

mod apng;
mod gif;
#[cfg(feature = "mp4")]
mod mp4;
mod palette;
mod stage;

use std::io::Write;

use crate::offscreen::Image;

pub use self::apng::write_png;
pub use self::palette::{Colors, Palette};
pub(crate) use self::stage::aspect_ratio;
pub use self::stage::{ShootError, Stage};

/// The instants of a film.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Clip {
    /// First instant, s of the motion.
    pub from: f64,
    /// End of the clip, s of the motion; before `from` in a run back in time.
    pub to: f64,
    /// Frames a second of the film; greater than zero.
    pub fps: f64,
    /// Seconds of the motion in a second of the film: 0.1 is slow motion; greater than zero.
    pub speed: f64,
}

impl Clip {
    /// Number of frames; each is shown for `1/fps`, so the film stops at the end of the clip.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1")]
    pub fn n_frames(&self) -> usize {
        ((self.to - self.from).abs() / self.speed * self.fps).round().max(1.0) as usize
    }

    /// The instant of frame `k`: `from + k·speed/fps`, s.
    pub fn time(&self, k: usize) -> f64 {
        let forward = if self.to < self.from { -1.0 } else { 1.0 };
        self.from + forward * (k as f64 * self.speed / self.fps)
    }
}

/// File format of a film.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FilmFormat {
    /// Animated PNG: lossless.
    Apng,
    /// GIF: 255 colours, opens everywhere.
    Gif,
    /// MP4 with H.264: small; sizes are even.
    #[cfg(feature = "mp4")]
    Mp4,
}

impl FilmFormat {
    /// The nearest size that the format supports.
    pub fn fitting(self, size: [u32; 2]) -> [u32; 2] {
        match self {
            #[cfg(feature = "mp4")]
            Self::Mp4 => size.map(|n| n.next_multiple_of(2)),
            Self::Apng | Self::Gif => size,
        }
    }

    /// Default of the frames a second: GIF counts in hundredths of a second.
    pub fn usual_fps(self) -> f64 {
        match self {
            Self::Gif => 25.0,
            _ => 30.0,
        }
    }
}

/// Error of writing a film.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// An encoder refuses the frames.
    #[error("the frames cannot be encoded: {0}")]
    Encoder(String),
    /// The film has more frames than its format can count.
    #[error("a film of {0} frames is too long")]
    TooLong(usize),
}

/// Writes a film frame by frame.
pub struct Film<W: Write>(Encoder<W>);

enum Encoder<W: Write> {
    Apng(apng::Apng<W>),
    Gif(Box<gif::Gif<W>>),
    #[cfg(feature = "mp4")]
    Mp4(Box<mp4::Mp4<W>>),
}

impl<W: Write> Film<W> {
    /// Begins a film of `n_frames` pictures of `size`, `fps` of them a second. `palette` are the
    /// colours of a GIF: the best for some of its pictures.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn begin(
        out: W,
        format: FilmFormat,
        size: [u32; 2],
        fps: f64,
        n_frames: usize,
        palette: Palette,
    ) -> Result<Self, FilmError> {
        Ok(Self(match format {
            FilmFormat::Apng => Encoder::Apng(apng::Apng::begin(out, size, fps, n_frames)?),
            FilmFormat::Gif => Encoder::Gif(Box::new(gif::Gif::begin(out, size, fps, palette)?)),
            #[cfg(feature = "mp4")]
            FilmFormat::Mp4 => Encoder::Mp4(Box::new(mp4::Mp4::begin(out, size, fps)?)),
        }))
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        match &mut self.0 {
            Encoder::Apng(film) => film.add(image),
            Encoder::Gif(film) => film.add(image),
            #[cfg(feature = "mp4")]
            Encoder::Mp4(film) => film.add(image),
        }
    }

    /// Ends the film and flushes its file.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn finish(self) -> Result<(), FilmError> {
        match self.0 {
            Encoder::Apng(film) => film.finish(),
            Encoder::Gif(film) => film.finish(),
            #[cfg(feature = "mp4")]
            Encoder::Mp4(film) => film.finish(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_lie_at_exact_instants() {
        let clip = Clip { from: 0.5, to: 2.5, fps: 30.0, speed: 0.25 };
        assert_eq!(clip.n_frames(), 240);
        assert_eq!(clip.time(0), 0.5);
        assert_eq!(clip.time(60), 1.0);
        assert_eq!(clip.time(120), 1.5);
        let back = Clip { from: 1.0, to: 0.0, fps: 10.0, speed: 1.0 };
        assert_eq!((back.n_frames(), back.time(5)), (10, 0.5));
        assert_eq!(Clip { to: 1.0, ..back }.n_frames(), 1);
    }
}
