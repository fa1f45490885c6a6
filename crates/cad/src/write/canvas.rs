//! A drawing in the making: layers, marks, blocks and inserts, in the plane.

use acadrust::entities::{
    Arc, AttributeDefinition, AttributeEntity, Circle, EntityType, HorizontalAlignment, Insert,
    Line, LwPolyline, LwVertex, Point as PointEntity, Solid, Text, TextHorizontalAlignment,
};
use acadrust::tables::{BlockRecord, Layer, TableEntry};
use acadrust::types::{Color, DxfVersion, Handle, Vector2, Vector3};
use acadrust::{CadDocument, DxfWriter};
use thiserror::Error;

use super::UNITS;
use crate::geometry::Point;

/// A release of the format, oldest first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Release {
    /// AC1009: no units, names of 31 characters.
    R12,
    /// AC1015.
    R2000,
    /// AC1018.
    R2004,
    /// AC1021: Unicode from here on.
    R2007,
    /// AC1024.
    R2010,
    /// AC1027.
    R2013,
    /// AC1032.
    R2018,
}

impl Release {
    /// All of them, with their names and their tags in the file.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::R12, "R12", "AC1009"),
        (Self::R2000, "R2000", "AC1015"),
        (Self::R2004, "R2004", "AC1018"),
        (Self::R2007, "R2007", "AC1021"),
        (Self::R2010, "R2010", "AC1024"),
        (Self::R2013, "R2013", "AC1027"),
        (Self::R2018, "R2018", "AC1032"),
    ];

    /// The release of a name such as `R2010`.
    pub fn by_name(name: &str) -> Option<Self> {
        let mut all = Self::ALL.iter();
        all.find(|(_, known, _)| known.eq_ignore_ascii_case(name)).map(|&(release, ..)| release)
    }

    fn version(self) -> DxfVersion {
        match self {
            Self::R12 => DxfVersion::AC1009,
            Self::R2000 => DxfVersion::AC1015,
            Self::R2004 => DxfVersion::AC1018,
            Self::R2007 => DxfVersion::AC1021,
            Self::R2010 => DxfVersion::AC1024,
            Self::R2013 => DxfVersion::AC1027,
            Self::R2018 => DxfVersion::AC1032,
        }
    }
}

/// Why a drawing could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// No such unit is known to drawings.
    #[error("`{0}` is not a unit of drawings")]
    UnknownUnit(String),
    /// The writer of the format refused.
    #[error("the drawing cannot be written: {0}")]
    Format(#[from] acadrust::DxfError),
}

/// Something to draw. Lengths are in drawing units, angles in radians.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Mark {
    /// A straight line.
    Line(Point, Point),
    /// A circle.
    Circle(Point, f64),
    /// Counter-clockwise from the first angle to the second.
    Arc(Point, f64, [f64; 2]),
    /// Corners, each with the bulge of what follows it.
    Polyline { corners: Vec<(Point, f64)>, is_closed: bool },
    /// A filled triangle.
    Fill([Point; 3]),
    /// A point.
    Dot(Point),
    /// One line of text.
    Text(Label),
}

/// One line of text.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Label {
    /// The left end of its base line, or the middle.
    pub(crate) at: Point,
    pub(crate) height: f64,
    pub(crate) text: String,
    pub(crate) is_centred: bool,
}

impl Mark {
    /// A polyline without arcs.
    pub(crate) fn chain(points: &[Point], is_closed: bool) -> Self {
        Self::Polyline { corners: points.iter().map(|&p| (p, 0.0)).collect(), is_closed }
    }

    /// A text that begins at a point.
    pub(crate) fn text(at: Point, height: f64, text: impl Into<String>) -> Self {
        Self::Text(Label { at, height, text: text.into(), is_centred: false })
    }

    /// A text about a point.
    pub(crate) fn centred(at: Point, height: f64, text: impl Into<String>) -> Self {
        Self::Text(Label { at, height, text: text.into(), is_centred: true })
    }

    /// Mark `size` times as large about the origin.
    pub(crate) fn scaled(self, size: f64) -> Self {
        let scale = |[x, y]: Point| [size * x, size * y];
        match self {
            Self::Line(from, to) => Self::Line(scale(from), scale(to)),
            Self::Circle(centre, radius) => Self::Circle(scale(centre), size * radius),
            Self::Arc(centre, radius, angles) => Self::Arc(scale(centre), size * radius, angles),
            Self::Polyline { corners, is_closed } => Self::Polyline {
                corners: corners.into_iter().map(|(p, bulge)| (scale(p), bulge)).collect(),
                is_closed,
            },
            Self::Fill(corners) => Self::Fill(corners.map(scale)),
            Self::Dot(at) => Self::Dot(scale(at)),
            Self::Text(label) => {
                Self::Text(Label { at: scale(label.at), height: size * label.height, ..label })
            }
        }
    }

    fn entity(self) -> EntityType {
        match self {
            Self::Line(from, to) => {
                EntityType::Line(Line::from_points(in_space(from), in_space(to)))
            }
            Self::Circle(centre, radius) => {
                EntityType::Circle(Circle { center: in_space(centre), radius, ..Circle::new() })
            }
            Self::Arc(centre, radius, [start, end]) => EntityType::Arc(
                Arc::from_center_radius_angles(in_space(centre), radius, start, end),
            ),
            Self::Polyline { corners, is_closed } => {
                let corner =
                    |([x, y], bulge): (Point, f64)| LwVertex::with_bulge(Vector2::new(x, y), bulge);
                let vertices = corners.into_iter().map(corner).collect();
                EntityType::LwPolyline(LwPolyline { vertices, is_closed, ..LwPolyline::new() })
            }
            Self::Fill([a, b, c]) => {
                EntityType::Solid(Solid::triangle(in_space(a), in_space(b), in_space(c)))
            }
            Self::Dot(at) => {
                EntityType::Point(PointEntity { location: in_space(at), ..PointEntity::new() })
            }
            Self::Text(label) => {
                let mut text =
                    Text::with_value(label.text, in_space(label.at)).with_height(label.height);
                if label.is_centred {
                    text.horizontal_alignment = TextHorizontalAlignment::Center;
                    text.alignment_point = Some(in_space(label.at));
                }
                EntityType::Text(text)
            }
        }
    }
}

/// Shape and prompt of one attribute of a block.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct AttributeStyle {
    pub(crate) tag: String,
    pub(crate) prompt: String,
    pub(crate) at: Point,
    pub(crate) height: f64,
    pub(crate) is_visible: bool,
    pub(crate) is_centred: bool,
}

/// An insert of a block.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Insertion<'a> {
    pub(crate) block: &'a str,
    pub(crate) layer: &'a str,
    pub(crate) at: Point,
    /// Along the x axis of the block, and across it.
    pub(crate) scale: [f64; 2],
    /// Of the block's x axis, rad.
    pub(crate) rotation: f64,
    /// With the value of each; positions are in the block and are not turned with it.
    pub(crate) attributes: Vec<(AttributeStyle, String)>,
}

/// A new drawing.
#[derive(Debug)]
pub struct Canvas {
    document: CadDocument,
    release: Release,
}

impl Canvas {
    /// An empty drawing with lengths in `unit`: `mm`, `cm`, `m`, `inch` or `ft`.
    ///
    /// # Errors
    /// [`WriteError::UnknownUnit`].
    pub fn new(release: Release, unit: &str) -> Result<Self, WriteError> {
        let known = UNITS.iter().find(|(name, ..)| *name == unit);
        let &(_, insunits, ..) = known.ok_or_else(|| WriteError::UnknownUnit(unit.to_owned()))?;
        let mut document = CadDocument::with_version(release.version());
        document.header.insertion_units = insunits;
        document.header.measurement = i16::from(!matches!(unit, "inch" | "ft"));
        Ok(Self { document, release })
    }

    /// Adds a layer of a colour of the index, unless there is one of this name.
    pub(crate) fn layer(&mut self, name: &str, colour: u8) {
        if self.document.layers.contains(name) {
            return;
        }
        let mut layer = Layer::with_color(name, Color::Index(colour));
        layer.set_handle(self.document.allocate_handle());
        // A layer that is there already is as good.
        let _ = self.document.layers.add(layer);
    }

    /// Sets the view of the opened drawing: lower left and upper right corner.
    pub(crate) fn view(&mut self, [low, high]: [Point; 2], limits: [Point; 2]) {
        let header = &mut self.document.header;
        (header.model_space_extents_min, header.model_space_extents_max) =
            (in_space(low), in_space(high));
        [header.model_space_limits_min, header.model_space_limits_max] =
            limits.map(|[x, y]| Vector2::new(x, y));
        for view in self.document.vports.iter_mut() {
            view.view_center =
                Vector2::new(f64::midpoint(low[0], high[0]), f64::midpoint(low[1], high[1]));
            // A window is about half as high as it is wide.
            view.view_height = 1.1 * (high[1] - low[1]).max((high[0] - low[0]) / 1.8);
        }
    }

    /// Draws in the model space.
    ///
    /// # Errors
    /// [`WriteError::Format`].
    pub(crate) fn draw(&mut self, layer: &str, mark: Mark) -> Result<(), WriteError> {
        let mut entity = mark.entity();
        layer.clone_into(&mut entity.common_mut().layer);
        self.document.add_entity(entity)?;
        Ok(())
    }

    /// Defines a block: marks in the colour of the insert, and attributes without a value.
    ///
    /// # Errors
    /// [`WriteError::Format`].
    pub(crate) fn block(
        &mut self,
        name: &str,
        marks: Vec<Mark>,
        attributes: &[AttributeStyle],
    ) -> Result<(), WriteError> {
        let mut record = BlockRecord::new(name);
        let owner = self.document.allocate_handle();
        record.set_handle(owner);
        record.block_entity_handle = self.document.allocate_handle();
        record.block_end_handle = self.document.allocate_handle();
        record.flags.has_attributes = !attributes.is_empty();
        record.units = self.document.header.insertion_units;
        self.document.block_records.add(record)?;
        for mark in marks {
            self.add_to(owner, mark.entity())?;
        }
        for style in attributes {
            self.add_to(owner, EntityType::AttributeDefinition(definition(style)))?;
        }
        Ok(())
    }

    fn add_to(&mut self, owner: Handle, mut entity: EntityType) -> Result<(), WriteError> {
        entity.common_mut().owner_handle = owner;
        entity.common_mut().color = Color::ByBlock;
        self.document.add_entity(entity)?;
        Ok(())
    }

    /// Inserts a block with its attributes.
    ///
    /// # Errors
    /// [`WriteError::Format`].
    pub(crate) fn insert(&mut self, insertion: Insertion<'_>) -> Result<(), WriteError> {
        let [along, across] = insertion.scale;
        let mut insert = Insert::new(insertion.block, in_space(insertion.at))
            .with_scale(along, across, across)
            .with_rotation(insertion.rotation);
        insertion.layer.clone_into(&mut insert.common.layer);
        for (style, value) in insertion.attributes {
            let mut attribute = AttributeEntity::from_definition(&definition(&style), Some(value));
            let [x, y] = [0, 1].map(|i| insertion.at[i] + style.at[i]);
            attribute.set_position(Vector3::new(x, y, 0.0));
            attribute.common.color = Color::ByLayer;
            insertion.layer.clone_into(&mut attribute.common.layer);
            insert.attributes.push(attribute);
        }
        self.document.add_entity(EntityType::Insert(insert))?;
        Ok(())
    }

    /// The drawing as an ASCII DXF file.
    ///
    /// # Errors
    /// [`WriteError::Format`].
    pub fn bytes(&self) -> Result<Vec<u8>, WriteError> {
        Ok(DxfWriter::new(&self.document).with_version(self.release.version()).write_to_vec()?)
    }
}

fn definition(style: &AttributeStyle) -> AttributeDefinition {
    let mut definition =
        AttributeDefinition::new(style.tag.clone(), style.prompt.clone(), String::new());
    definition.set_position(in_space(style.at));
    definition.height = style.height;
    definition.flags.invisible = !style.is_visible;
    definition.common.color = Color::ByBlock;
    if style.is_centred {
        definition.horizontal_alignment = HorizontalAlignment::Center;
    }
    definition
}

fn in_space([x, y]: Point) -> Vector3 {
    Vector3::new(x, y, 0.0)
}
