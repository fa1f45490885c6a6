//! Kinds of attachments to a drawing: one row per kind, with its block and its keys.
//!
//! A kind is written in three ways that mean the same: extended data `revolute { name=A … }`, an
//! insert of the block `BK_REVOLUTE` with the attributes `NAME`, …, or a layer.

/// The section of the model that an attachment goes to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Section {
    /// `[ground]`.
    Ground,
    /// `[bodies.…]`.
    Bodies,
    /// A named point of a body.
    Points,
    /// A body's centre of mass.
    Centre,
    /// A body's frame.
    Frames,
    /// `[joints.…]`.
    Joints,
    /// `[loads.…]`.
    Loads,
    /// `[drives.…]`.
    Drives,
    /// `[couplings.…]`.
    Couplings,
    /// `[tables.…]`.
    Tables,
    /// `[curves.…]`.
    Curves,
    /// `[states.…]`.
    States,
    /// `[clocks.…]`.
    Clocks,
    /// `[signals.…]`.
    Signals,
    /// `[use.…]`: models of other files, or of the library.
    Parts,
    /// `[parameters]`.
    Parameters,
    /// `[initial]`.
    Initial,
    /// `[solve]`.
    Solve,
    /// `[io]`.
    Io,
    /// The top level: name and coordinates; `[units]`, the units of bare numbers.
    Model,
}

/// Sections of what is called by its name and says the keys of a model file as they are, with their words
/// there.
pub const NAMED: [(Section, &str); 7] = [
    (Section::Tables, "tables"),
    (Section::Curves, "curves"),
    (Section::Couplings, "couplings"),
    (Section::States, "states"),
    (Section::Clocks, "clocks"),
    (Section::Signals, "signals"),
    (Section::Parts, "use"),
];

/// The meaning of where an attachment stands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Placement {
    /// Nothing: it may stand anywhere.
    Anywhere,
    /// One point.
    Point,
    /// A point and a direction.
    Frame,
    /// Two points: the insertion point and the block's (1, 0).
    Line,
}

/// One kind of attachment.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Kind {
    /// Name as written in extended data.
    pub name: &'static str,
    /// Name of the block.
    pub block: &'static str,
    /// Section of the model.
    pub section: Section,
    /// The meaning of where it stands.
    pub placement: Placement,
    /// Keys of the kind as in extended data; attributes have the same in upper case. A `name` comes first.
    pub keys: &'static [&'static str],
}

const INITIAL: &[&str] = &[
    "name", "x", "y", "angle", "angle1", "angle2", "position", "vx", "vy", "rate", "rate1",
    "rate2", "velocity", "value", "guess",
];

macro_rules! kinds {
    ($($name:literal $block:literal $section:ident $placement:ident $keys:expr;)*) => {
        /// All kinds.
        pub const KINDS: &[Kind] = &[$(Kind {
            name: $name,
            block: $block,
            section: Section::$section,
            placement: Placement::$placement,
            keys: $keys,
        }),*];
    };
}

kinds! {
    "ground" "BK_GROUND" Ground Point &["name"];
    "body" "BK_BODY" Bodies Point &[
        "name", "mass", "inertia", "about", "density", "thickness", "free", "coordinates",
    ];
    "point" "BK_POINT" Points Point &["name", "body"];
    "com" "BK_COM" Centre Point &["body"];
    "frame" "BK_FRAME" Frames Frame &["body"];
    "revolute" "BK_REVOLUTE" Joints Point &[
        "name", "body1", "body2", "point1", "point2", "coordinate", "cut", "angle", "rate", "bodies",
    ];
    "prismatic" "BK_PRISMATIC" Joints Frame &[
        "name", "body1", "body2", "point1", "point2", "coordinate", "cut", "position", "velocity",
    ];
    "slot" "BK_SLOT" Joints Frame &[
        "name", "body1", "body2", "point1", "point2", "coordinate", "cut", "position", "velocity",
        "angle", "rate",
    ];
    "weld" "BK_WELD" Joints Point &["name", "body1", "body2", "point1", "point2", "cut"];
    "link" "BK_LINK" Joints Line &["name", "body1", "body2", "point1", "point2", "length"];
    "point-on-curve" "BK_POINT_ON_CURVE" Joints Line &[
        "name", "body1", "body2", "point1", "point2", "curve", "radius", "side", "coordinate",
    ];
    "line-on-curve" "BK_LINE_ON_CURVE" Joints Line &[
        "name", "body1", "body2", "point1", "point2", "curve", "axis", "direction", "coordinate",
    ];
    "curve-on-curve" "BK_CURVE_ON_CURVE" Joints Line &[
        "name", "body1", "body2", "point1", "point2", "curve", "second_curve", "tangents", "rolling",
        "coordinate",
    ];
    "cylinder" "BK_CYLINDER" Joints Line &[
        "name", "body1", "body2", "point1", "point2", "min", "max", "restitution", "coordinate",
    ];
    "gravity" "BK_GRAVITY" Loads Frame &["name", "acceleration"];
    "force" "BK_FORCE" Loads Frame &["name", "body", "point", "value", "vector", "axes", "joint", "of"];
    "actuator" "BK_ACTUATOR" Loads Line &["name", "body1", "body2", "point1", "point2", "value"];
    "torque" "BK_TORQUE" Loads Point &["name", "body", "from", "joint", "of", "value"];
    "spring" "BK_SPRING" Loads Line &[
        "name", "body1", "body2", "point1", "point2", "stiffness", "length", "damping",
        "joint", "of",
    ];
    "damper" "BK_DAMPER" Loads Line &[
        "name", "body1", "body2", "point1", "point2", "damping", "joint", "of",
    ];
    "torsion" "BK_TORSION" Loads Point &["name", "joint", "of", "stiffness", "angle", "damping"];
    "stop" "BK_STOP" Loads Point &["name", "joint", "of", "min", "max", "restitution"];
    "friction" "BK_FRICTION" Loads Point &[
        "name", "joint", "of", "force", "torque", "mu", "static", "radius", "length", "coupling",
        "pressure_angle", "loss",
    ];
    "drive" "BK_DRIVE" Drives Point &["name", "joint", "of", "motion"];
    "gear" "BK_GEAR" Couplings Line &[
        "name", "between", "teeth", "module", "radii", "ratio", "internal", "carrier", "phase",
    ];
    "rack" "BK_RACK" Couplings Line &[
        "name", "between", "teeth", "module", "radius", "reversed", "phase",
    ];
    "belt" "BK_BELT" Couplings Line &[
        "name", "between", "teeth", "module", "radii", "crossed", "carrier", "phase", "turns", "length",
        "stiffness", "damping",
    ];
    "chain" "BK_CHAIN" Couplings Line &[
        "name", "between", "teeth", "module", "radii", "carrier", "phase", "turns", "length",
        "stiffness", "damping",
    ];
    "screw" "BK_SCREW" Couplings Point &["name", "between", "lead", "phase"];
    "relation" "BK_RELATION" Couplings Anywhere &["name", "relation"];
    "table" "BK_TABLE" Tables Anywhere &[
        "name", "points", "file", "units", "interpolation", "extrapolate",
    ];
    "curve" "BK_CURVE" Curves Anywhere &["name", "points", "formula", "parameter", "range"];
    "cam-law" "BK_CAM_LAW" Curves Anywhere &["name", "segments", "turns"];
    "cam" "BK_CAM" Curves Anywhere &["name", "law", "base_circle", "follower", "sense"];
    "state" "BK_STATE" States Anywhere &["name", "rate", "start"];
    "clock" "BK_CLOCK" Clocks Anywhere &["name", "every", "start"];
    "signal" "BK_SIGNAL" Signals Anywhere &["name", "value", "clock", "start", "when"];
    "part" "BK_PART" Parts Anywhere &["name", "part", "file", "on", "with"];
    "parameter" "BK_PARAMETER" Parameters Anywhere &["name", "value"];
    "initial" "BK_INITIAL" Initial Anywhere INITIAL;
    "solve" "BK_SOLVE" Solve Anywhere &[
        "t_start", "t_end", "every", "times", "rtol", "atol", "step", "newton_tolerance", "method",
        "formulation", "jit",
    ];
    "io" "BK_IO" Io Anywhere &["input", "output"];
    "model" "BK_MODEL" Model Anywhere &[
        "name", "coordinates", "length", "mass", "time", "angle", "force",
    ];
}

/// Geometry on the layer `BK_BODY_crank` is the shape of the body `crank`.
pub const BODY_LAYER: &str = "BK_BODY_";

/// Geometry on the layer `BK_CURVE_track` is the curve `track`, which joints follow.
pub const CURVE_LAYER: &str = "BK_CURVE_";

/// Geometry on this layer belongs to the ground.
pub const GROUND_LAYER: &str = "BK_GROUND";

/// A circle on this layer is a revolute of the two bodies that meet there.
pub const JOINT_LAYER: &str = "BK_JOINTS";

/// Marks of what is wrong with the drawing are on this layer; nothing on it is read.
pub const DOCTOR_LAYER: &str = "BK_DOCTOR";

/// The application name of our extended data.
pub const APPLICATION: &str = "BKSIM";

/// The kind of a name as written in extended data.
pub fn by_name(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name.eq_ignore_ascii_case(name))
}
