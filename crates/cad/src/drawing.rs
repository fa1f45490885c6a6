//! [`Drawing`]: the entities of the model space as plain data, in the plane and in world axes.

use crate::geometry::{GeometryError, Path, Point};

/// A drawing, with what is of use to a mechanism.
#[derive(Clone, PartialEq, Debug)]
pub struct Drawing {
    /// The length of one unit of the drawing.
    pub unit: LengthUnit,
    /// In file order. Inserts of blocks other than ours have the curves of the block.
    pub entities: Vec<Entity>,
    /// Corners of the box around all geometry: lower left, upper right; equal when there is none.
    pub extent: [Point; 2],
}

/// The unit of lengths of a drawing.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LengthUnit {
    /// Name as written in model files: `mm`, `inch`.
    pub name: &'static str,
    /// In metres.
    pub metres: f64,
}

/// A handle: the number by which the drawing's own program knows an entity; hexadecimal when written.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Handle(pub u64);

/// One entity.
#[derive(Clone, PartialEq, Debug)]
pub struct Entity {
    /// Type and position, for messages.
    pub location: Location,
    /// Geometry of the entity.
    pub shape: Shape,
    /// The values under the application name `BKSIM`, in order.
    pub xdata: Vec<XValue>,
}

/// Type and position of an entity, as diagnostics state them.
#[derive(Clone, PartialEq, Debug)]
pub struct Location {
    /// Type in the words of the format: `CIRCLE`, `LWPOLYLINE`.
    pub kind: String,
    /// `None` in old drawings without handles.
    pub handle: Option<Handle>,
    /// Layer of the location.
    pub layer: String,
    /// A point of it: the centre, the insertion point, the first vertex.
    pub at: Point,
    /// The lines of the file it takes, counted from one, the last one included; `None` in binary
    /// files.
    pub lines: Option<[usize; 2]>,
}

/// The geometry of an entity.
#[derive(Clone, PartialEq, Debug)]
pub enum Shape {
    /// A point.
    Point(Point),
    /// Lines, arcs, circles, polylines, ellipses and splines; one path each.
    Path(Path),
    /// The curves of an insert of some other block.
    Paths(Vec<Path>),
    /// The boundaries of a hatch.
    Hatch(Vec<Path>),
    /// A text and where it begins.
    Text {
        /// Insertion point.
        at: Point,
        /// The words.
        text: String,
    },
    /// An insert of one of our blocks.
    Insert(Insert),
    /// A linear or an aligned dimension whose text is not the measured length alone.
    Dimension {
        /// The points it is between.
        ends: [Point; 2],
        /// The direction that a linear one measures along, of length one.
        along: Option<Point>,
        /// Text, `<>` for the measured length.
        text: String,
    },
    /// Geometry that was passed over.
    Unread {
        /// The reason.
        why: Unread,
        /// The block that holds the entity, if the drawing shows it by an insert alone.
        block: Option<String>,
    },
    /// Anything else.
    Other,
}

/// Why geometry was passed over.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Unread {
    /// Numbers that make no curve.
    NoCurve(GeometryError),
    /// It does not lie in the plane of the drawing, or parallel to it.
    OutOfPlane,
    /// Inserts within inserts go deeper, or are more, than is read.
    TooMany {
        /// The limit in words.
        limit: &'static str,
    },
}

/// An insert of a block.
#[derive(Clone, PartialEq, Debug)]
pub struct Insert {
    /// Name of the block, upper case.
    pub block: String,
    /// Insertion point.
    pub at: Point,
    /// The world vector of the block's x axis: its scale is its length.
    pub x: Point,
    /// The world vector of the block's y axis.
    pub y: Point,
    /// In file order.
    pub attributes: Vec<Attribute>,
}

/// One attribute of an insert.
#[derive(Clone, PartialEq, Debug)]
pub struct Attribute {
    /// Upper case.
    pub tag: String,
    /// Value as written, without surrounding spaces.
    pub value: String,
    /// Type and position.
    pub location: Location,
}

/// One value of extended entity data.
#[derive(Clone, PartialEq, Debug)]
pub enum XValue {
    /// 1000.
    Text(String),
    /// 1002: `{`.
    Open,
    /// 1002: `}`.
    Close,
    /// 1005.
    Handle(Handle),
    /// 1010 and 1011: a point of the world.
    Point(Point),
    /// 1012: a vector that turns and scales with the entity.
    Displacement(Point),
    /// 1013: a vector that turns with the entity.
    Direction(Point),
    /// 1040, 1070, 1071: a number.
    Number(f64),
    /// 1041: a length in drawing units that scales with the entity.
    Distance(f64),
    /// 1042: a number that scales with the entity.
    Factor(f64),
    /// 1003: a layer.
    Layer(String),
}
