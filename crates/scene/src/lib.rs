//! Mechanisms as shapes: outlines and textbook symbols on bodies, cameras, themes, and pictures.
//!
//! ```text
//! Model → Scene            shapes in the frames of their bodies, once
//! Scene + poses → Picture  the view of a camera at one instant: regions, lines and words in pixels
//! Picture → SVG
//! ```
//!
//! The window, films, pages and the scene in a log all draw from one [`Scene`]. This crate knows no
//! graphics card.

mod camera;
mod color;
mod cord;
mod depth;
mod draw;
mod from_model;
mod geometry;
mod label;
mod pick;
mod picture;
pub mod request;
mod rod;
mod rule;
mod scene;
mod section;
mod solid;
mod span;
mod svg;
mod theme;
mod turn;
pub mod vectors;
mod written;

pub use camera::{Camera, StandardView};
pub use color::Color;
pub use cord::{Cord, CordPlace, FirstTurn};
pub use draw::{Arrow, Extras, Words, picture};
pub use pick::Picked;
pub use picture::{Align, Item, Picture, Stroke};
pub use rod::{sheets, silhouette};
pub use rule::scale_bar;
pub use scene::{Attached, Form, Marker, MarkerKind, Role, Scene, Shape, Span, SpanKind};
pub use section::{CutSide, HalfSpace, Section};
pub use solid::{Edge, LIGHT, SeenFace, Solid};
pub use span::Stretched;
pub use svg::{svg, titled_svg};
pub use theme::{Paint, SectionPaint, Sizes, Theme};
pub use turn::{Turn, TurnTimes};
pub use written::WrittenSolid;
