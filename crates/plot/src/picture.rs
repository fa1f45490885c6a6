//! Figures as files: SVG, pixels as PNG, pages as PDF.

use std::path::Path;
use std::sync::Arc;

use fontdb::Database;
use krilla::geom::Size as PageSize;
use krilla::metadata::Metadata;
use krilla::page::PageSettings;
use krilla_svg::{SurfaceExt, SvgSettings};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use crate::{Figure, Size, Theme, font};

/// File format of a figure.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// Lines and texts, for browsers and drawing programs.
    Svg,
    /// Pixels.
    Png,
    /// A page, for print.
    Pdf,
}

impl Format {
    /// The format that an ending names, upper or lower case.
    pub fn named(ending: &str) -> Option<Self> {
        let formats = [Self::Svg, Self::Png, Self::Pdf];
        formats.into_iter().find(|format| format.ending().eq_ignore_ascii_case(ending))
    }

    /// The format that the name of a file asks for; SVG where it names none.
    pub fn of(path: &Path) -> Self {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.and_then(Self::named).unwrap_or(Self::Svg)
    }

    /// Ending of the files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
            Self::Pdf => "pdf",
        }
    }
}

/// Error of [`Figure::render`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// A size that is too small, too large, or not a number.
    #[error("a picture cannot be {width} by {height}: each side takes {least} to {most}")]
    Size {
        /// Requested width.
        width: f64,
        /// Requested height.
        height: f64,
        /// Smallest side.
        least: f64,
        /// Largest side.
        most: f64,
    },
    /// A library refused the output of this crate: a fault of this crate.
    #[error("the picture cannot be made: {what}")]
    Library {
        /// Message of the library.
        what: String,
    },
}

/// Smallest and largest side of a picture, px.
const SIDES: [f64; 2] = [120.0, 10_000.0];
/// Size from which a PNG has finer pixels rather than smaller texts, px.
const FINE_FROM: [f64; 2] = [1200.0, 700.0];
/// Pixels of a fine PNG per pixel of the layout, along a side.
const FINE: f64 = 2.0;
/// Points of 1/72 inch in a pixel of 1/96 inch.
const POINTS_PER_PIXEL: f64 = 72.0 / 96.0;

impl Figure {
    /// The bytes of a file. `size` counts the pixels of a PNG, and CSS pixels otherwise; without
    /// it, the figure has its natural size, which a PNG shows with two pixels per CSS pixel.
    ///
    /// # Errors
    /// [`PlotError::Size`].
    pub fn render(
        &self,
        format: Format,
        size: Option<Size>,
        theme: &Theme,
    ) -> Result<Vec<u8>, PlotError> {
        let natural = self.natural_size();
        let (size, scale) = match (format, size) {
            (Format::Png, None) => (natural, FINE),
            (Format::Png, Some(size))
                if size.width >= FINE_FROM[0] && size.height >= FINE_FROM[1] =>
            {
                (Size { width: size.width / FINE, height: size.height / FINE }, FINE)
            }
            (_, size) => (size.unwrap_or(natural), 1.0),
        };
        let [least, most] = SIDES;
        let Size { width, height } = size;
        if ![width, height].iter().all(|side| (least..=most).contains(side)) {
            return Err(PlotError::Size { width, height, least, most });
        }
        let svg = self.to_svg(size, theme);
        match format {
            Format::Svg => Ok(svg.into_bytes()),
            Format::Png => to_png(&tree(&svg)?, size, scale),
            Format::Pdf => to_pdf(&tree(&svg)?, size, &self.title),
        }
    }
}

/// A picture of this size as the bytes of a file.
///
/// # Errors
/// [`PlotError`] when a library refuses it.
pub fn convert(svg: &str, format: Format, size: Size, title: &str) -> Result<Vec<u8>, PlotError> {
    match format {
        Format::Svg => Ok(svg.as_bytes().to_vec()),
        Format::Png => to_png(&tree(svg)?, size, FINE),
        Format::Pdf => to_pdf(&tree(svg)?, size, title),
    }
}

fn tree(svg: &str) -> Result<Tree, PlotError> {
    let mut fonts = Database::new();
    for bytes in font::FONTS {
        fonts.load_font_data(bytes.to_vec());
    }
    let family = fonts.faces().next().and_then(|face| face.families.first());
    let (family, _) = family.cloned().expect("the fonts built in are valid and have names");
    fonts.set_sans_serif_family(&family);
    // Letters of other languages come from the fonts of the system.
    if !svg.chars().all(font::has) {
        fonts.load_system_fonts();
    }
    let options = Options { fontdb: Arc::new(fonts), font_family: family, ..Options::default() };
    Tree::from_str(svg, &options).map_err(|error| library(&error))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "sides are checked")]
fn to_png(tree: &Tree, size: Size, scale: f64) -> Result<Vec<u8>, PlotError> {
    let [width, height] = [size.width, size.height].map(|side| (side * scale).round() as u32);
    let mut pixels =
        Pixmap::new(width, height).ok_or_else(|| library(&"no room for the pixels"))?;
    let transform = Transform::from_scale(scale as f32, scale as f32);
    resvg::render(tree, transform, &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| library(&error))
}

fn to_pdf(tree: &Tree, size: Size, title: &str) -> Result<Vec<u8>, PlotError> {
    trees_to_pdf(std::slice::from_ref(tree), size, title)
}

/// Pages of one size, as SVG, in one PDF.
pub(crate) fn pages_to_pdf(
    pages: &[String],
    size: Size,
    title: &str,
) -> Result<Vec<u8>, PlotError> {
    let trees = pages.iter().map(|page| tree(page)).collect::<Result<Vec<_>, _>>()?;
    trees_to_pdf(&trees, size, title)
}

#[expect(clippy::cast_possible_truncation, reason = "sides are checked")]
fn trees_to_pdf(trees: &[Tree], size: Size, title: &str) -> Result<Vec<u8>, PlotError> {
    let [width, height] = [size.width, size.height].map(|side| (side * POINTS_PER_PIXEL) as f32);
    let settings = PageSettings::from_wh(width, height);
    let page_size = PageSize::from_wh(width, height);
    let (settings, page_size) =
        settings.zip(page_size).ok_or_else(|| library(&"no page of this size"))?;
    let mut document = krilla::Document::new();
    document.set_metadata(Metadata::new().title(title.to_owned()));
    for tree in trees {
        let mut page = document.start_page_with(settings.clone());
        let mut surface = page.surface();
        let drawn = surface.draw_svg(tree, page_size, SvgSettings::default());
        surface.finish();
        page.finish();
        drawn.ok_or_else(|| library(&"the drawing was refused"))?;
    }
    document.finish().map_err(|error| library(&format!("{error:?}")))
}

fn library(error: &dyn std::fmt::Display) -> PlotError {
    PlotError::Library { what: error.to_string() }
}
