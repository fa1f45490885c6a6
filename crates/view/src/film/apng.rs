//! PNG: one picture, or a film, without loss.

use std::io::Write;

use super::FilmError;
use crate::offscreen::Image;

/// Writes one picture.
///
/// # Errors
/// [`FilmError`] when it cannot be written.
pub fn write_png<W: Write>(out: W, image: &Image) -> Result<(), FilmError> {
    let mut writer = encoder(out, image.size).write_header()?;
    writer.write_image_data(&image.rgba)?;
    Ok(writer.finish()?)
}

/// A film as animated PNG.
pub(super) struct Apng<W: Write>(png::Writer<W>);

impl<W: Write> Apng<W> {
    pub(super) fn begin(
        out: W,
        size: [u32; 2],
        fps: f64,
        n_frames: usize,
    ) -> Result<Self, FilmError> {
        let mut encoder = encoder(out, size);
        let n = u32::try_from(n_frames).map_err(|_| FilmError::TooLong(n_frames))?;
        encoder.set_animated(n, 0)?;
        let (numerator, denominator) = delay(fps);
        encoder.set_frame_delay(numerator, denominator)?;
        Ok(Self(encoder.write_header()?))
    }

    pub(super) fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        Ok(self.0.write_image_data(&image.rgba)?)
    }

    pub(super) fn finish(self) -> Result<(), FilmError> {
        Ok(self.0.finish()?)
    }
}

fn encoder<'a, W: Write>(out: W, [width, height]: [u32; 2]) -> png::Encoder<'a, W> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder
}

/// Duration of a frame in seconds, as a fraction.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within its range")]
fn delay(fps: f64) -> (u16, u16) {
    if fps.fract() == 0.0 && fps <= f64::from(u16::MAX) {
        return (1, fps as u16);
    }
    ((1e4 / fps).round().clamp(1.0, f64::from(u16::MAX)) as u16, 10_000)
}

impl From<png::EncodingError> for FilmError {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(error) => Self::Io(error),
            other => Self::Encoder(other.to_string()),
        }
    }
}
