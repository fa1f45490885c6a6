//! Colours.

use serde::Serialize;

/// A colour: red, green, blue and opacity, sRGB, each 0 to 255, the colour not multiplied by the
/// opacity.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Serialize)]
pub struct Color(pub [u8; 4]);

impl Color {
    /// An opaque colour from 0xRRGGBB.
    pub const fn opaque(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self([r, g, b, 255])
    }

    /// Colour with another opacity, 0 to 1.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 to 255")]
    pub fn with_opacity(self, opacity: f32) -> Self {
        let Self([r, g, b, _]) = self;
        Self([r, g, b, (opacity.clamp(0.0, 1.0) * 255.0).round() as u8])
    }

    /// The opaque mixture of this colour over the opaque colour `below`.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 to 255")]
    pub fn over(self, below: Self) -> Self {
        let part = self.opacity();
        let mixed = |i: usize| {
            let (front, back) = (f32::from(self.0[i]), f32::from(below.0[i]));
            (part * front + (1.0 - part) * back).round() as u8
        };
        Self([mixed(0), mixed(1), mixed(2), 255])
    }

    /// Colour this many times as opaque.
    #[must_use]
    pub fn faded(self, factor: f32) -> Self {
        self.with_opacity(self.opacity() * factor)
    }

    /// Opacity, 0 to 1.
    pub fn opacity(self) -> f32 {
        f32::from(self.0[3]) / 255.0
    }

    /// `#rrggbb`, without the opacity.
    pub fn hex(self) -> String {
        let Self([r, g, b, _]) = self;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
