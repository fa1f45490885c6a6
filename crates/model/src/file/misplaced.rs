//! Keys of other programs, or of other tables: where what they say is written here.

use super::naming::CASE_KEYS;
use super::tree::{Entry, Value};
use super::words::closest;

/// Keys of a joint that say what acts in it or how it starts, with where that stands; `@` is the joint.
const OF_JOINTS: [(&[&str], &str); 6] = [
    (
        &["friction", "mu", "coulomb"],
        "friction is a load: `[loads.NAME]` with `type = \"friction\"`, `joint = \"@\"` and `force`, `torque` or `mu`",
    ),
    (
        &["stop", "stops", "limit", "limits", "range", "lower", "upper"],
        "a stop is a load: `[loads.NAME]` with `type = \"stop\"`, `joint = \"@\"`, `min` and `max`",
    ),
    (
        &["spring", "stiffness", "damping", "damper"],
        "springs and dampers are loads: `[loads.NAME]` with `type = \"spring\"` where the joint slides and \
         `\"torsion\"` where it turns, and `joint = \"@\"`",
    ),
    (
        &["force", "torque", "moment", "effort", "load", "loads"],
        "what acts in a joint is a load: `[loads.NAME]` with `type = \"force\"` where it slides and `\"torque\"` where it \
         turns, `joint = \"@\"` and `value`",
    ),
    (
        &["motor", "drive", "motion", "actuator", "speed"],
        "a prescribed motion is a drive: `[drives.NAME]` with `joint = \"@\"` and `motion = \"2 rad/s*t\"`",
    ),
    (
        &["initial", "start", "angle", "position", "rate", "velocity"],
        "a start stands in `[initial]`: `@ = { angle = \"30 deg\", rate = 0 }`, where it slides `position` and `velocity`",
    ),
];

/// Keys of a body that say where it starts, or what its size is.
const OF_BODIES: [(&[&str], &str); 2] = [
    (
        &[
            "x",
            "y",
            "z",
            "position",
            "angle",
            "orientation",
            "rpy",
            "velocity",
            "w",
            "rate",
            "initial",
            "start",
        ],
        "a start stands in `[initial]`: `@ = { x = 0, y = \"1 m\", angle = \"30 deg\" }`",
    ),
    (
        &["length", "width", "height", "size", "radius"],
        "a body has no size of its own: its `points` say where joints are, `outline` and `shapes` what it looks like, \
         and with a `density` what it weighs",
    ),
];

/// Keys of a drive that say how fast it is.
const OF_DRIVES: [(&[&str], &str); 1] = [(
    &["speed", "rate", "velocity", "rpm", "omega", "w"],
    "a drive prescribes positions: for a constant speed write `motion = \"60 rpm*t\"`",
)];

/// Keys of runs that have none of their own here.
const OF_RUNS: [(&[&str], &str); 2] = [
    (
        &["steps", "n_steps", "samples", "n_samples", "points", "frames"],
        "samples have a distance in time: `every = \"10 ms\"`, or `times = [0, \"0.1 s\"]`",
    ),
    (
        &["max_step", "hmax", "h_max", "min_step", "hmin", "h_min", "initial_step"],
        "remove it: steps follow from `rtol` and `atol`; constant ones are `step = \"1 ms\"`",
    ),
];

/// Keys of a coupling that say how fast one joint turns by the other.
const OF_COUPLINGS: [(&[&str], &str); 1] = [(
    &["ratio", "gear_ratio", "i", "transmission"],
    "the ratio follows from the wheels: `teeth = [20, 40]` or `radii = [\"20 mm\", \"40 mm\"]`",
)];

/// Keys of other programs in a table, and the key that says it here.
const RENAMED: [(&str, &str, &[&str]); 26] = [
    ("the model", "parameters", &["variables", "constants", "params", "values"]),
    ("the model", "initial", &["initial_conditions", "initial_values", "start", "guesses"]),
    ("drive", "motion", &["law", "function", "value", "angle", "rotation", "displacement"]),
    (
        "`[solve]`",
        "t_end",
        &["duration", "time", "end", "tend", "tmax", "until", "stop_time", "end_time"],
    ),
    ("joint", "type", &["kind", "joint_type", "class"]),
    ("load", "type", &["kind", "load_type", "class"]),
    ("load", "stiffness", &["k", "K", "spring_constant", "rate"]),
    ("load", "damping", &["c", "d", "b", "viscosity", "damping_coefficient"]),
    ("load", "length", &["l0", "L0", "free_length", "rest_length", "natural_length"]),
    ("load", "angle", &["angle0", "free_angle", "rest_angle", "phi0"]),
    ("load", "mu", &["friction", "coefficient", "friction_coefficient"]),
    ("coupling", "type", &["kind", "class"]),
    ("coupling", "between", &["joints", "of", "wheels", "gears"]),
    ("body", "mass", &["m", "weight"]),
    ("body", "inertia", &["I", "J", "Izz", "I_zz", "moi", "moment_of_inertia"]),
    ("body", "com", &["cog", "cg", "cm", "center", "centre", "center_of_mass", "centroid"]),
    ("body", "points", &["markers", "nodes", "joints"]),
    ("the start of joint", "angle", &["theta", "phi", "q", "position", "rotation", "value"]),
    ("the start of joint", "rate", &["omega", "w", "speed", "velocity", "angular_velocity"]),
    ("the start of joint", "position", &["x", "s", "q", "displacement", "angle", "value"]),
    ("the start of joint", "velocity", &["v", "vx", "speed", "rate"]),
    ("the start of body", "angle", &["theta", "phi", "rotation"]),
    ("the start of body", "rate", &["omega", "w", "angular_velocity"]),
    ("`[solve]`", "every", &["dt", "interval", "output_interval", "sampling"]),
    ("`[solve]`", "step", &["timestep", "time_step", "step_size", "h"]),
    ("`[solve]`", "rtol", &["tol", "tolerance", "precision", "accuracy", "reltol"]),
];

/// Sections of other programs.
const SECTIONS: [(&[&str], &str); 10] = [
    (
        &["inputs", "input"],
        "an input is a parameter that `[io]` names: `input = [\"u\"]`, with `u` in `[parameters]`",
    ),
    (
        &["bearings", "pins", "hinges", "sliders", "guides", "connections", "pairs"],
        "what connects two bodies is a joint: `[joints.NAME]` with `type` and `between`",
    ),
    (
        &["gravity"],
        "gravity is a load: `[loads]` with `gravity = { type = \"gravity\", acceleration = [0, \"-9.81 m/s^2\"] }`",
    ),
    (
        &["forces", "force", "torques", "springs", "spring", "dampers", "stops", "friction"],
        "it is a load: `[loads.NAME]` with its `type`",
    ),
    (
        &["motors", "motor", "motions", "actuators"],
        "a prescribed motion is a drive: `[drives.NAME]` with `joint` and `motion`",
    ),
    (
        &["links", "link", "constraints"],
        "links between two points are joints: `[joints.NAME]` with `type = \"distance\"`",
    ),
    (
        &["gears", "gear", "belts", "racks"],
        "it is a coupling of two joints: `[couplings.NAME]` with its `type`",
    ),
    (&["cams", "cam", "profiles"], "a cam is a curve: `[curves.NAME]` with `type = \"cam\"`"),
    (
        &["points", "markers"],
        "points belong to a body: `points = { A = [0, 0] }` in `[bodies.NAME]` or `[ground]`",
    ),
    (
        &["simulation", "settings", "integrator", "solver"],
        "the options of a run stand in `[solve]`",
    ),
];

/// Where what an unknown key of `owner`, such as ``joint `A` ``, says is written; `None` where it is nothing that
/// people write there.
pub(super) fn misplaced(owner: &str, key: &str) -> Option<String> {
    if owner.starts_with("load case ") && closest(key, &CASE_KEYS).is_none() {
        let words = "what a case changes stands in braces: `set = { rod.mass = \"2 kg\" }`";
        return Some(words.to_owned());
    }
    let (noun, name) = owner.split_once(' ').unwrap_or((owner, ""));
    let rows: &[(&[&str], &str)] = match noun {
        "joint" => &OF_JOINTS,
        "body" => &OF_BODIES,
        "drive" => &OF_DRIVES,
        "coupling" => &OF_COUPLINGS,
        "`[solve]`" => &OF_RUNS,
        "the" if name == "model" => &SECTIONS,
        _ => return None,
    };
    let row = rows.iter().find(|(keys, _)| keys.contains(&key))?;
    Some(row.1.replace('@', name.trim_matches('`')))
}

/// Keys of a force or torque that say its size.
const SIZES: [&str; 6] = ["force", "torque", "moment", "effort", "magnitude", "size"];

/// The key that an unknown one stands for: of a force or torque that of `free` ones which takes what it says.
pub(super) fn meant_key<'k>(
    owner: &str,
    entry: &Entry,
    has_point: bool,
    free: &[&'k str],
) -> Option<&'k str> {
    let key = entry.key.as_str();
    let noun = owner.split_once(" `").map_or(owner, |(noun, _)| noun);
    let is_vector =
        matches!(entry.node.value, Value::Array(_)) || has_point && free.contains(&"axes");
    let meant = if noun == "load" && SIZES.contains(&key) {
        if is_vector { "vector" } else { "value" }
    } else {
        return renamed(noun, key, free);
    };
    free.iter().copied().find(|known| *known == meant)
}

/// The key of `free` ones that says in a table of this kind what one of other programs says.
pub(super) fn renamed<'k>(noun: &str, key: &str, free: &[&'k str]) -> Option<&'k str> {
    let rows = RENAMED.iter().filter(|(of, _, theirs)| *of == noun && theirs.contains(&key));
    rows.into_iter().find_map(|(_, ours, _)| free.iter().copied().find(|known| known == ours))
}

/// Types of joints and loads, with the words of other programs for them.
const TYPES: [(&str, &[&str]); 11] = [
    ("revolute", &["pin", "hinge", "pivot", "rotary", "rotational", "bearing"]),
    ("prismatic", &["slider", "slide", "sliding", "translational", "linear", "guide"]),
    ("weld", &["fixed", "rigid", "glue"]),
    ("spherical", &["ball", "ball-joint", "ball_joint", "socket"]),
    ("universal", &["cardan", "hooke", "gimbal"]),
    ("slot", &["pin-in-slot", "pin_in_slot", "slotted"]),
    ("screw", &["helical", "thread"]),
    ("link", &["rod", "bar", "massless-rod"]),
    ("torsion", &["torsion-spring", "torsion_spring", "rotational-spring"]),
    ("damper", &["dashpot", "shock"]),
    ("torque", &["moment", "couple"]),
];

/// The type among `known` ones that a word of other programs stands for.
pub(super) fn meant_type<'k>(word: &str, known: &[&'k str]) -> Option<&'k str> {
    let lower = word.to_ascii_lowercase();
    let rows = TYPES.iter().filter(|(_, theirs)| theirs.contains(&lower.as_str()));
    rows.into_iter().find_map(|(ours, _)| known.iter().copied().find(|own| own == ours))
}
