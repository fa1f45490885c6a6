//! GIF: 255 colours, and of each frame only the part that changes.

use std::borrow::Cow;
use std::io::Write;

use gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::{FilmError, Palette};
use crate::offscreen::Image;

/// A film as GIF, played in a loop.
pub(super) struct Gif<W: Write> {
    encoder: Encoder<W>,
    palette: Palette,
    fps: f64,
    width: usize,
    /// Frames so far.
    n: usize,
    /// The last frame, as indices into the palette.
    last: Vec<u8>,
}

impl<W: Write> Gif<W> {
    pub(super) fn begin(
        out: W,
        size: [u32; 2],
        fps: f64,
        palette: Palette,
    ) -> Result<Self, FilmError> {
        let side = |n: u32| u16::try_from(n).map_err(|_| too_large(size));
        let (width, height) = (side(size[0])?, side(size[1])?);
        let mut encoder = Encoder::new(out, width, height, &palette.bytes())?;
        encoder.set_repeat(Repeat::Infinite)?;
        Ok(Self { encoder, palette, fps, width: usize::from(width), n: 0, last: Vec::new() })
    }

    pub(super) fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        let indices = self.palette.indices(image);
        // Transparent pixels cannot replace opaque ones: such frames are whole and cleared
        // afterwards.
        let is_clear = |indices: &[u8]| indices.contains(&Palette::TRANSPARENT);
        let is_whole = self.last.is_empty() || is_clear(&indices) || is_clear(&self.last);
        let [left, top, right, bottom] = if is_whole {
            [0, 0, self.width, indices.len() / self.width]
        } else {
            changed(&self.last, &indices, self.width)
        };
        let mut buffer = Vec::with_capacity((right - left) * (bottom - top));
        for row in top..bottom {
            for at in row * self.width + left..row * self.width + right {
                let is_kept = !is_whole && self.last[at] == indices[at];
                buffer.push(if is_kept { Palette::TRANSPARENT } else { indices[at] });
            }
        }
        let dispose =
            if is_clear(&indices) { DisposalMethod::Background } else { DisposalMethod::Keep };
        let small = |n: usize| u16::try_from(n).expect("sides of the film fit into 16 bits");
        let frame = Frame {
            delay: self.delay(),
            dispose,
            transparent: Some(Palette::TRANSPARENT),
            left: small(left),
            top: small(top),
            width: small(right - left),
            height: small(bottom - top),
            buffer: Cow::Owned(buffer),
            ..Frame::default()
        };
        self.encoder.write_frame(&frame)?;
        (self.last, self.n) = (indices, self.n + 1);
        Ok(())
    }

    /// Duration of the next frame, hundredths of a second; rounding errors do not add up.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    fn delay(&self) -> u16 {
        let end = |n: usize| (100.0 * n as f64 / self.fps).round();
        (end(self.n + 1) - end(self.n)).clamp(1.0, f64::from(u16::MAX)) as u16
    }

    pub(super) fn finish(self) -> Result<(), FilmError> {
        self.encoder.into_inner()?.flush()?;
        Ok(())
    }
}

/// The rectangle in which two frames differ: left, top, right, bottom; one pixel if nowhere.
fn changed(old: &[u8], new: &[u8], width: usize) -> [usize; 4] {
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (at, _) in old.iter().zip(new).enumerate().filter(|(_, (a, b))| a != b) {
        for (axis, x) in [at % width, at / width].into_iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(x), high[axis].max(x + 1));
        }
    }
    if low[0] == usize::MAX { [0, 0, 1, 1] } else { [low[0], low[1], high[0], high[1]] }
}

fn too_large([width, height]: [u32; 2]) -> FilmError {
    FilmError::Encoder(format!("a GIF of {width}x{height} pixels is too large: 65535 is the most"))
}

impl From<gif::EncodingError> for FilmError {
    fn from(error: gif::EncodingError) -> Self {
        match error {
            gif::EncodingError::Io(error) => Self::Io(error),
            other => Self::Encoder(other.to_string()),
        }
    }
}
