//! Prompts of CAD programs when a block is inserted: each key in words, with an example.

/// `(kind, key, words)`; a kind of `""` stands for all others.
const PROMPTS: &[(&str, &str, &str)] = &[
    ("", "name", "Name, e.g. A"),
    ("ground", "name", "Name, e.g. ground"),
    ("body", "name", "Name of the body, e.g. crank"),
    ("body", "mass", "Mass, e.g. 2 kg; empty: of the outline"),
    ("body", "inertia", "Moment of inertia, e.g. 0.1 kg m^2; empty: of the outline"),
    ("body", "about", "Point the moment of inertia is about, e.g. A; empty: centre of mass"),
    ("body", "density", "Density of the outline, e.g. 7850 kg/m^3"),
    ("body", "thickness", "Thickness of the outline, e.g. 10 mm"),
    ("body", "free", "true: may move without joints"),
    ("body", "coordinates", "Names of x, y and angle, e.g. [x2, y2, theta2]"),
    ("point", "name", "Name of the point, e.g. P"),
    ("", "body", "Body, e.g. crank; empty: by geometry"),
    ("", "body1", "First body, e.g. ground; empty: by geometry"),
    ("", "body2", "Second body, e.g. crank; empty: by geometry"),
    ("", "bodies", "All bodies of one pin, e.g. crank, rod, lever; empty: by geometry"),
    ("", "point1", "Point of the first body, e.g. A; empty: here"),
    ("", "point2", "Point of the second body, e.g. B; empty: here"),
    ("", "coordinate", "Name of its coordinate, e.g. theta1; empty: chosen"),
    ("", "cut", "true or false: cut into a constraint; empty: chosen"),
    ("", "angle", "Angle at the start, e.g. 30 deg; empty: as drawn"),
    ("", "rate", "Rate at the start, e.g. 2 rad/s"),
    ("", "position", "Position at the start, e.g. 50 mm; empty: as drawn"),
    ("", "velocity", "Velocity at the start, e.g. 0.1 m/s"),
    ("", "length", "Length, e.g. 120 mm"),
    ("spring", "length", "Unloaded length, e.g. 120 mm"),
    ("gravity", "acceleration", "Acceleration of free fall, e.g. 9.81 m/s^2"),
    ("", "point", "Point it acts on, e.g. P; empty: here"),
    ("", "value", "Value, e.g. 20 N"),
    ("torque", "value", "Torque, e.g. 5 N m"),
    ("parameter", "value", "Value, e.g. 9.81 m/s^2"),
    ("initial", "value", "Value of a coordinate, e.g. 30 deg"),
    ("", "vector", "Components in place of a value, e.g. [10 N, 0]"),
    ("", "axes", "body: components turn with the body"),
    ("torque", "body", "Body it acts on, e.g. crank; empty: by geometry"),
    ("", "from", "Body that bears the opposite, e.g. rod; empty: ground"),
    ("", "joint", "Joint, e.g. A; empty: the one here"),
    ("", "stiffness", "Stiffness, e.g. 500 N/m"),
    ("torsion", "stiffness", "Stiffness, e.g. 20 N m/rad"),
    ("", "damping", "Damping, e.g. 5 N s/m"),
    ("torsion", "damping", "Damping, e.g. 0.1 N m s/rad"),
    ("torsion", "angle", "Unloaded angle, e.g. 0 deg"),
    ("", "of", "angle or position; empty unless the joint is a slot"),
    ("", "min", "Smallest position, e.g. -30 deg"),
    ("", "max", "Largest position, e.g. 30 deg"),
    ("", "restitution", "Speed after an impact over the speed before, 0 to 1"),
    ("", "force", "Friction force, e.g. 5 N"),
    ("", "torque", "Friction torque, e.g. 0.2 N m"),
    ("", "mu", "Coefficient of friction in the place of a force, e.g. 0.1"),
    ("", "static", "Largest friction while it sticks, e.g. 8 N; of a coefficient, e.g. 0.15"),
    ("", "radius", "Radius of the pin or the thread, e.g. 5 mm"),
    ("friction", "length", "Length of the sleeve whose ends bear, e.g. 120 mm"),
    ("", "coupling", "Gear or rack whose teeth rub in place of a joint, e.g. pair"),
    ("", "pressure_angle", "Pressure angle of the teeth, e.g. 20 deg"),
    ("", "loss", "Loss factor of the teeth, e.g. 0.1; empty: by their numbers"),
    ("", "curve", "Curve that is followed, e.g. track"),
    (
        "point-on-curve",
        "radius",
        "Radius of a roller about the second point, e.g. 8 mm; empty: none",
    ),
    ("", "second_curve", "Curve of the second body, e.g. rim"),
    ("", "tangents", "opposite or same, as both parameters rise; empty: opposite"),
    ("", "rolling", "Parameters of two points that come together, e.g. 0, pi; empty: it slides"),
    ("", "side", "Side of the curve on which the roller is: left or right"),
    ("line-on-curve", "axis", "Direction of the face in the second body, e.g. [1, 0]"),
    ("line-on-curve", "direction", "Its angle to x in place of AXIS, e.g. 0 deg"),
    ("cylinder", "min", "Smallest length, e.g. 200 mm"),
    ("cylinder", "max", "Largest length, e.g. 350 mm"),
    ("", "between", "Joints in their order, e.g. A, B; empty: those at the two ends"),
    ("screw", "between", "The joint that turns, then the one that slides, e.g. A, S"),
    ("", "teeth", "Numbers of teeth, e.g. 20, 40"),
    ("rack", "teeth", "Number of teeth of the pinion, e.g. 20"),
    ("", "module", "Module, e.g. 2 mm"),
    ("", "radii", "Pitch radii, e.g. 20 mm, 40 mm"),
    ("", "ratio", "Rate of the second over that of the first, e.g. -0.5"),
    ("", "internal", "true: the second wheel has its teeth inside"),
    ("", "carrier", "Body against which the angles count, e.g. arm; empty: chosen"),
    ("", "phase", "Position of the second where the first is at zero, e.g. 5 deg"),
    ("", "reversed", "true: a positive turn moves the rack backwards"),
    ("", "crossed", "true: the wheels turn in opposite senses"),
    ("", "turns", "Sense around each wheel, e.g. left, left, right"),
    ("cam-law", "turns", "How many times the segments follow each other, e.g. 3"),
    ("belt", "length", "Length without load, e.g. 1.6 m; empty: what the start needs"),
    ("chain", "length", "Length without load, e.g. 1.6 m; empty: what the start needs"),
    ("", "lead", "Travel of one turn, e.g. 5 mm"),
    ("", "relation", "What is zero, e.g. 2*A.angle - B.angle"),
    ("", "points", "Rows, e.g. 0, 12; 100, 9.5; 150, 0"),
    ("", "file", "File of the rows, e.g. motor.csv"),
    ("part", "file", "File of the part, e.g. parts/motor.toml"),
    ("", "units", "Units of the columns, e.g. rad/s, N m"),
    ("", "interpolation", "smooth, monotone or linear"),
    ("", "extrapolate", "refused, constant or linear"),
    ("", "formula", "Point by the parameter p, e.g. 0.5 m*cos(p), 0.3 m*sin(p)"),
    ("", "parameter", "Name of the parameter; empty: p"),
    ("", "range", "Values between which it is drawn, e.g. 0, 2*pi"),
    (
        "",
        "segments",
        "Segments, e.g. [{ rise = \"20 mm\", over = \"120 deg\", law = \"3-4-5\" }, …]",
    ),
    ("", "law", "Law of the lift, e.g. lift"),
    ("", "base_circle", "Radius of the base circle, e.g. 30 mm"),
    ("", "follower", "Follower, e.g. { kind = \"roller\", radius = \"10 mm\" }"),
    ("", "sense", "counter-clockwise or clockwise"),
    ("state", "rate", "Its rate of change, e.g. ref - A.angle"),
    ("state", "start", "Value at the start, e.g. 0"),
    ("clock", "every", "Interval of the ticks, e.g. 1 ms"),
    ("clock", "start", "First tick, e.g. 0 s"),
    ("signal", "value", "Expression, e.g. kp*err + ki*e"),
    ("", "clock", "Clock at whose ticks it is computed, e.g. c"),
    ("signal", "start", "Value before the first tick or event, e.g. 0"),
    ("", "when", "Events, e.g. [{ condition = \"A.angle > 1\", value = 0 }]"),
    ("", "part", "Part of the library, e.g. dc-motor"),
    ("", "on", "Point that is the ground of the part, e.g. arm.mount"),
    ("", "with", "Values of the part, e.g. R = 2 ohm; L = 1 mH"),
    ("", "input", "Inputs of linear equations, e.g. u"),
    ("", "output", "Outputs of linear equations, e.g. A.angle"),
    ("", "motion", "Prescribed motion, e.g. 60 rpm*t"),
    ("parameter", "name", "Name, e.g. g"),
    ("initial", "name", "Body, joint or coordinate, e.g. crank"),
    ("initial", "angle", "Angle, e.g. 30 deg"),
    ("", "angle1", "First angle of a joint that has two, e.g. 30 deg"),
    ("", "angle2", "Second angle of a joint that has two, e.g. 30 deg"),
    ("", "rate1", "Rate of the first angle, e.g. 2 rad/s"),
    ("", "rate2", "Rate of the second angle, e.g. 2 rad/s"),
    ("initial", "position", "Position, e.g. 50 mm"),
    ("", "x", "x of the centre of mass, e.g. 50 mm"),
    ("", "y", "y of the centre of mass, e.g. 20 mm"),
    ("", "vx", "Velocity along x, e.g. 0.1 m/s"),
    ("", "vy", "Velocity along y, e.g. 0.1 m/s"),
    ("", "guess", "true: the values may move until all joints close"),
    ("", "t_start", "Start, e.g. 0 s"),
    ("", "t_end", "End, e.g. 5 s"),
    ("", "every", "Interval of the output, e.g. 10 ms"),
    ("", "times", "Times of the output, e.g. [0.1, 0.5]"),
    ("", "rtol", "Relative tolerance, e.g. 1e-8"),
    ("", "atol", "Absolute tolerance, e.g. 1e-10"),
    ("", "step", "Fixed step, e.g. 1 ms; empty: chosen"),
    ("", "newton_tolerance", "Newton tolerance with a fixed step, e.g. 1e-10"),
    ("", "method", "auto, radau or explicit"),
    ("", "formulation", "ggl, index2, index3 or index1"),
    ("", "jit", "auto, on or off"),
    ("model", "name", "Name of the mechanism, e.g. press"),
    ("model", "coordinates", "auto, relative or absolute"),
    ("model", "length", "Unit of bare lengths in values, e.g. mm; empty: m"),
    ("model", "mass", "Unit of bare masses in values, e.g. g; empty: kg"),
    ("model", "time", "Unit of bare times in values, e.g. ms; empty: s"),
    ("model", "angle", "Unit of bare angles in values, e.g. deg; empty: rad"),
    ("model", "force", "Unit of bare forces in values, e.g. kN; empty: N"),
];

/// The prompt for the value of a key.
pub(super) fn prompt(kind: &str, key: &str) -> &'static str {
    let of = |kind: &str| PROMPTS.iter().find(|(k, name, _)| *k == kind && *name == key);
    of(kind).or_else(|| of("")).map_or("Value", |(.., words)| words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::KINDS;

    #[test]
    fn every_key_is_asked_for_in_its_own_words() {
        for kind in KINDS {
            for key in kind.keys {
                assert_ne!(prompt(kind.name, key), "Value", "{} {key}", kind.name);
            }
        }
    }

    #[test]
    fn every_prompt_belongs_to_a_key() {
        for (kind, key, _) in PROMPTS {
            let mut kinds = KINDS.iter().filter(|k| kind.is_empty() || k.name == *kind);
            assert!(kinds.any(|k| k.keys.contains(key)), "{kind} {key}");
        }
    }
}
