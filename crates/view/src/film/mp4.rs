//! MP4 with H.264.

use std::io::Write;

use muxide::api::{Muxer, MuxerBuilder, MuxerError, VideoCodec};
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, MatrixCoefficients,
    QpRange, RateControlMode, UsageType, VuiConfig,
};
use openh264::formats::{RgbaSliceU8, YUVBuffer};

use super::FilmError;
use crate::offscreen::Image;

/// A film as MP4.
pub(super) struct Mp4<W: Write> {
    encoder: Encoder,
    muxer: Muxer<W>,
    frame: YUVBuffer,
    fps: f64,
    n: usize,
}

/// Coarsest quantisation, at which fine lines are still clean.
const COARSEST: u8 = 24;
/// Finest quantisation.
const FINEST: u8 = 10;

/// Upper bound of the bits for a pixel of a frame; parts at rest need none.
const BITS_PER_PIXEL: f64 = 0.2;

impl<W: Write> Mp4<W> {
    pub(super) fn begin(out: W, size: [u32; 2], fps: f64) -> Result<Self, FilmError> {
        let [width, height] = size;
        let bits = BITS_PER_PIXEL * f64::from(width) * f64::from(height) * fps;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let bits = bits.clamp(5e5, 1e8) as u32;
        #[expect(clippy::cast_possible_truncation, reason = "a few digits")]
        let rate = fps as f32;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let two_seconds = (2.0 * fps).clamp(1.0, 1e6) as u32;
        let config = EncoderConfig::new()
            .bitrate(BitRate::from_bps(bits))
            .max_frame_rate(FrameRate::from_hz(rate))
            .rate_control_mode(RateControlMode::Off)
            .usage_type(UsageType::ScreenContentRealTime)
            .skip_frames(false)
            // Neither exists for pictures of screens: requesting them makes the encoder warn on
            // stderr.
            .adaptive_quantization(false)
            .background_detection(false)
            .qp(QpRange::new(FINEST, COARSEST))
            .num_threads(1)
            // A key frame every two seconds, for seeking.
            .intra_frame_period(IntraFramePeriod::from_num_frames(two_seconds))
            // The conversion below is that of BT.601.
            .vui(VuiConfig::bt709().matrix_coefficients(MatrixCoefficients::Smpte170M));
        let encoder = Encoder::with_api_config(OpenH264API::from_source(), config)?;
        let muxer = MuxerBuilder::new(out)
            .video(VideoCodec::H264, width, height, fps)
            .with_fast_start(true)
            .build()?;
        let frame = YUVBuffer::new(width as usize, height as usize);
        Ok(Self { encoder, muxer, frame, fps, n: 0 })
    }

    pub(super) fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        let size = (image.size[0] as usize, image.size[1] as usize);
        self.frame.read_rgba8(RgbaSliceU8::new(&image.rgba, size));
        let encoded = self.encoder.encode(&self.frame)?;
        let is_key = matches!(encoded.frame_type(), FrameType::IDR | FrameType::I);
        self.muxer.write_video(self.n as f64 / self.fps, &encoded.to_vec(), is_key)?;
        self.n += 1;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<(), FilmError> {
        Ok(self.muxer.finish()?)
    }
}

impl From<openh264::Error> for FilmError {
    fn from(error: openh264::Error) -> Self {
        Self::Encoder(error.to_string())
    }
}

impl From<MuxerError> for FilmError {
    fn from(error: MuxerError) -> Self {
        match error {
            MuxerError::Io(error) => Self::Io(error),
            other => Self::Encoder(other.to_string()),
        }
    }
}
