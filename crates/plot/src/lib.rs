//! Curves as figures: SVG, PNG, PDF and text.
//!
//! ```
//! use bksim_plot::{Axis, Curve, Figure, Format, Panel, Theme};
//!
//! let points = (0..=200).map(|i| 0.05 * f64::from(i)).map(|t| [t, (2.0 * t).sin()]);
//! let panel = Panel::new(
//!     Axis::new("time", "s"),
//!     Axis::new("angle", "rad"),
//!     vec![Curve::new("A_angle", points.collect())],
//! );
//! let figure = Figure::new("pendulum", vec![panel]);
//! let svg = figure.to_svg(figure.natural_size(), &Theme::LIGHT);
//! assert!(svg.contains("angle (rad)"));
//! let png = figure.render(Format::Png, None, &Theme::DARK)?;
//! assert!(png.starts_with(b"\x89PNG"));
//! # Ok::<(), bksim_plot::PlotError>(())
//! ```
//!
//! | file | contents |
//! |---|---|
//! | `decimate.rs`, `thin.rs` | curves of any length in constant memory: over time, in the plane |
//! | `ticks.rs`, `axis.rs` | 1-2-5 ticks and their labels; ranges and scales |
//! | `figure.rs`, `theme.rs` | figures as plain data; colours |
//! | `font.rs`, `layout.rs`, `legend.rs` | widths of texts; positions of panels, axes and names |
//! | `svg.rs`, `picture.rs` | the picture as SVG; from there to PNG and PDF |
//! | `document.rs` | documents of texts, tables and pictures: HTML, pages of PDF |
//! | `terminal.rs` | the picture in characters |
//!
//! # Invariants
//!
//! Knows no mechanisms, no logs and no files. The same figure gives the same bytes on every machine:
//! the font is in the program. Any numbers are drawn, or left out as gaps; none makes it panic.

mod axis;
mod decimate;
mod document;
mod figure;
mod font;
mod layout;
mod legend;
mod picture;
mod svg;
mod terminal;
mod theme;
mod thin;
mod ticks;

pub use axis::{Axis, Scale, unit_text};
pub use decimate::{Envelope, LARGEST, Point};
pub use document::{Block, Document, ROOM};
pub use figure::{Curve, Figure, Mark, Panel, Size};
pub use picture::{Format, PlotError, convert};
pub use terminal::Screen;
pub use theme::Theme;
pub use thin::Trace;
pub use ticks::round_numbers;
