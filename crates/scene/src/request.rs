//! The request of a picture or a film: here, where no graphics are, for those who read a
//! request and hand it on.

use std::ops::RangeInclusive;
use std::str::FromStr;

use crate::{Color, Theme};

/// The background of a mechanism.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Background {
    /// Dark on light.
    #[default]
    Light,
    /// Light on dark.
    Dark,
    /// Nothing, and dark lines on it.
    Transparent,
    /// A colour, 0xRRGGBB.
    Color(u32),
}

impl Background {
    /// The colours drawn with. A background decides by how bright it is which lines are seen on it.
    pub fn theme(self) -> Theme {
        match self {
            Self::Light | Self::Transparent => Theme::LIGHT,
            Self::Dark => Theme::DARK,
            Self::Color(rgb) => {
                let [_, r, g, b] = rgb.to_be_bytes().map(f64::from);
                // Luma of BT.601.
                let is_dark = 0.299 * r + 0.587 * g + 0.114 * b < 128.0;
                let theme = if is_dark { Theme::DARK } else { Theme::LIGHT };
                Theme { background: Color::opaque(rgb), ..theme }
            }
        }
    }
}

impl FromStr for Background {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = "expected light, dark, transparent, or a colour such as #fff8e7";
        match text {
            "light" => Ok(Self::Light),
            "dark" => Ok(Self::Dark),
            "transparent" => Ok(Self::Transparent),
            _ => {
                let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
                let is_hex = |digits: &&str| digits.bytes().all(|b| b.is_ascii_hexdigit());
                let digits = digits.filter(is_hex).ok_or(wrong)?;
                u32::from_str_radix(digits, 16).map(Self::Color).map_err(|_| wrong)
            }
        }
    }
}

/// Widths and heights that a picture can have, pixels.
pub const SIDES: RangeInclusive<u32> = 16..=16384;
/// Pixels per point that a picture can have.
pub const DENSITIES: RangeInclusive<f32> = 0.25..=8.0;
/// Frames a second, speeds and pasts that a film can have.
pub const FACTORS: RangeInclusive<f64> = 1e-6..=1e6;
/// Ghosts that a picture can have.
pub const MOST_GHOSTS: u16 = 200;
