//! Every diagnostic code with its title and its page: one row each.
//!
//! A code is never reused for another fault. The page is what `bksim explain` prints.

crate::codes! {
    NOT_UTF8 = "M001", "the file is not UTF-8";
    SYNTAX = "M002", "the file is not TOML";
    DUPLICATE = "M003", "a name is defined twice";
    NESTING = "M004", "nested too deeply";
    UNKNOWN_KEY = "M005", "unknown key";
    MISSING_KEY = "M006", "missing key";
    WRONG_KIND = "M007", "wrong kind of value";
    NOT_A_CHOICE = "M008", "not one of the choices";
    BAD_NAME = "M009", "not a usable name";
    NAME_CLASH = "M010", "one name with two meanings";
    UNKNOWN_BODY = "M012", "unknown body";
    UNKNOWN_POINT = "M013", "unknown point";
    UNKNOWN_JOINT = "M014", "unknown joint";
    UNKNOWN_OVERRIDE = "M015", "unknown parameter in an override";
    EXPRESSION = "M020", "the expression cannot be read";
    UNKNOWN_NAME = "M021", "unknown name in an expression";
    UNKNOWN_FUNCTION = "M022", "unknown function";
    CYCLE = "M024", "parameters define each other";
    DIVISION_BY_ZERO = "M025", "division by zero";
    NOT_REAL = "M026", "no real value";
    NOT_FINITE = "M027", "not a finite number";
    NOT_CONSTANT = "M028", "must not change during the motion";
    UNKNOWN_UNIT = "M030", "unknown unit";
    WRONG_DIMENSION = "M031", "wrong dimension";
    CANNOT_ADD = "M032", "different dimensions cannot be added";
    NEEDS_UNIT = "M033", "a number needs its unit";
    LOOKS_LIKE_DEGREES = "M034", "an angle looks like degrees";
    IMPLAUSIBLE_SIZE = "M035", "implausible size or mass";
    DECIMAL_COMMA = "M036", "a comma that looks decimal";
    BAD_MASS = "M040", "impossible mass";
    BAD_INERTIA = "M041", "impossible moments of inertia";
    INERTIA_ABOUT_PIN = "M042", "impossible inertia about the centre of mass";
    NO_DIRECTION = "M043", "an axis without a direction";
    NOT_POSITIVE = "M044", "must be greater than zero";
    ADDS_ENERGY = "M045", "a damper that adds energy";
    BAD_OUTLINE = "M046", "an outline that encloses nothing";
    UNUSED_BODY = "M050", "a body in no joint";
    NO_GROUND = "M051", "bodies not connected with the ground";
    SELF_JOINT = "M052", "both ends on one body";
    TWO_DRIVES = "M053", "two drives of one motion";
    WRONG_JOINT = "M054", "the joint has no such motion";
    KEY_CONFLICT = "M055", "keys that exclude each other";
    NOT_PLANAR = "M056", "a spatial part in a planar model";
    BAD_RESTITUTION = "M057", "a restitution out of range";
    NO_ROOM = "M058", "stops that leave no room";
    NEGATIVE_FRICTION = "M059", "friction that drives";
    BAD_TIME_SPAN = "M060", "the end is the start";
    BAD_TOLERANCE = "M061", "a tolerance out of range";
    NO_BODIES = "M062", "a model without bodies";
    DRAWING_ALONE = "M063", "a drawing that is not there";
    IMPLAUSIBLE_LOAD = "M064", "a load that is hardly meant";
    BAD_FRAME = "M070", "axes that make no frame";
    NOT_PERPENDICULAR = "M071", "axes of a joint that are not perpendicular";
    ALGEBRAIC_LOOP = "M076", "signals that follow from each other";
    BAD_TABLE = "M077", "rows that make no table";
    BAD_RELATION = "M080", "a coupling that couples nothing";
    NO_CARRIER = "M081", "wheels without a common carrier";
    BAD_RATIO = "M082", "a ratio that no wheels have";
    BAD_CLOCK = "M083", "a clock that does not tick";
    UNKNOWN_CLOCK = "M084", "unknown clock";
    NOT_SAMPLED = "M085", "in sampled signals only";
    NO_SURFACE = "M090", "surfaces that a joint does not have";
    NO_CURVE = "M091", "a curve that is none";
    UNKNOWN_CURVE = "M092", "a curve that does not exist";
    BAD_PART = "M093", "a part that cannot be used";
    BAD_COUNT = "M094", "a count that repeats nothing";
    NO_CONDITION = "M095", "a condition that compares nothing";
    LEAVES_ROWS = "M096", "a spline that leaves its rows";
    BAD_MESH = "M100", "a mesh that cannot be read";
    OPEN_MESH = "M101", "a mesh that encloses no volume";
    IMPLAUSIBLE_INERTIA = "M102", "an inertia that hardly fits its body";
    FAR_CENTRE = "M103", "a centre of mass far outside of its body";
    GRAVITY_ACROSS = "M104", "gravity across the plane of all motions";
    AXIS_IN_PLANE = "M105", "the axis of one pin in the plane of the others";
    BAD_RATE = "M106", "a condition on rates that is none";
    NO_ROLLING = "M107", "a shape that does not roll";
    SELF_CONTACT = "M110", "a contact of one body with itself";
    NO_TOUCH = "M111", "shapes that cannot touch";
    MANY_PLACES = "M112", "outlines with too many corners";
    BAD_SHAPE = "M113", "a shape that is none";
    CONTACT_IN_SPACE = "M114", "a contact of outlines in a spatial model";
    NO_DISC = "M115", "rolling resistance of shapes that do not roll";
    TOOTH_ANGLE = "M120", "an angle that teeth do not have";
    NO_PITCH_RADII = "M121", "tooth forces without pitch radii";
    BAD_FLEXIBLE = "M122", "a flexible body that is none";
    NOT_ON_BEAM = "M123", "a point that is on no fixed part of a flexible body";
    NO_GRIP = "M124", "friction of a rope that does not grip";
    NO_RANGED = "M125", "a range of nothing";
    BAD_RANGE = "M126", "a range that is none";
    OUTSIDE_RANGE = "M127", "a value outside of its range";
    NO_PLAY = "M130", "keys of play without a clearance";
    UNKNOWN_CASE = "M135", "a load case that the model has not";
    NO_CHANGE = "M136", "a load case that changes nothing of the model";
    NOT_LEFT = "M137", "a place that a rope cannot leave";
    HERTZ = "M142", "hertz where an angle is counted in radians";
    NO_LIFT = "M143", "keys of lifting off a curve where nothing lifts off, or twice";
    SURFACE_IN_PLANE = "M144", "a contact of surfaces in space in a planar model, or with an outline";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_in_order_and_unique() {
        assert!(PAGES.is_sorted_by(|a, b| a.code < b.code));
    }
}
