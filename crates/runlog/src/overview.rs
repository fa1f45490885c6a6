//! Which quantities of a run to show where nobody has chosen, and words for what is measured in a
//! unit.

/// A number at every instant: a channel, or the size of a vector of several.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Quantity {
    /// The channel, or what the vector's channels begin with.
    pub name: String,
    /// SI.
    pub unit: String,
    /// The channel, or those of the vector.
    pub channels: Vec<String>,
}

/// Quantities of one unit, to be drawn together.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Group {
    /// A word for them, if there is a better one than the unit's usual word.
    pub label: Option<&'static str>,
    /// SI.
    pub unit: String,
    /// A few of them.
    pub quantities: Vec<Quantity>,
}

/// Groups of an overview at most.
pub const MAX_GROUPS: usize = 6;

/// Words for what is measured in a unit.
const WORDS: [(&str, &str); 19] = [
    ("rad", "Angle"),
    ("rad/s", "Angular velocity"),
    ("rad/s^2", "Angular acceleration"),
    ("m", "Position"),
    ("m/s", "Velocity"),
    ("m/s^2", "Acceleration"),
    ("N", "Force"),
    ("N*m", "Moment"),
    ("J", "Energy"),
    ("W", "Power"),
    ("s", "Time"),
    ("kg", "Mass"),
    ("N/m", "Stiffness"),
    ("A", "Current"),
    ("V", "Voltage"),
    ("ohm", "Resistance"),
    ("H", "Inductance"),
    ("C", "Charge"),
    ("", "Number"),
];

/// Values below this part of the largest of their unit are rounding.
const ROUNDING: f64 = 1e-12;
/// The size that rounding leaves of a quantity that is zero throughout, SI, by unit. A bacterium weighs ten thousand times
/// as many newtons, and an atom is a hundred thousand times as wide.
const NOTHING: [(&str, f64); 8] = [
    ("N", 1e-18),
    ("N*m", 1e-18),
    ("J", 1e-18),
    ("W", 1e-18),
    ("m", 1e-15),
    ("rad", 1e-15),
    ("m/s", 1e-14),
    ("rad/s", 1e-14),
];

/// The size below which values of this SI unit are nothing but rounding, in a run whose largest value of that unit is
/// `largest`.
pub fn floor(unit: &str, largest: f64) -> f64 {
    let least = NOTHING.iter().find(|(known, _)| *known == unit).map_or(0.0, |(_, least)| *least);
    least.max(ROUNDING * largest)
}

/// The usual word for what is measured in an SI unit.
pub fn word(unit: &str) -> Option<&'static str> {
    WORDS.iter().find(|(known, _)| *known == unit).map(|(_, word)| *word)
}

/// The SI units that have a usual word.
pub fn usual_units() -> impl Iterator<Item = &'static str> {
    WORDS.iter().map(|(unit, _)| *unit)
}

/// Outputs, coordinates and rates, currents, energies, and efforts of drives or sizes of reactions, among channels with
/// their units; of each at most so many, and how many were left out.
pub fn overview(channels: &[(String, String)], most: usize) -> (Vec<Group>, usize) {
    let of = |topic: &str, unit: &str, names: &[&str]| -> Vec<Quantity> {
        let is_of = |(name, own): &&(String, String)| {
            let name = name.strip_prefix(topic).and_then(|rest| rest.strip_prefix('.'));
            let is_wanted = |name: &str| names.is_empty() || names.contains(&name);
            own == unit && name.is_some_and(|name| !name.contains('.') && is_wanted(name))
        };
        let quantity = |(name, unit): &(String, String)| Quantity {
            name: name.clone(),
            unit: unit.clone(),
            channels: vec![name.clone()],
        };
        channels.iter().filter(is_of).map(quantity).collect()
    };
    let mut groups: Vec<Group> = Vec::new();
    let mut add = |label: Option<&'static str>, unit: &str, quantities: Vec<Quantity>| {
        let is_there = !quantities.is_empty();
        if is_there {
            groups.push(Group { label, unit: unit.to_owned(), quantities });
        }
        is_there
    };
    // What the author named comes first.
    let mut named: Vec<&str> = Vec::new();
    for (name, unit) in channels {
        if name.starts_with("outputs.") && !named.contains(&unit.as_str()) {
            named.push(unit);
        }
    }
    for unit in named {
        add(Some("Output"), unit, of("outputs", unit, &[]));
    }
    for unit in ["rad", "m", "rad/s", "m/s", "A"] {
        add(None, unit, of("state", unit, &[]));
    }
    // States of controllers may be pure numbers as well.
    let is_quaternion =
        |known: &Quantity| ["_e0", "_e1", "_e2", "_e3"].iter().any(|end| known.name.ends_with(end));
    let (quaternions, numbers) = of("state", "", &[]).into_iter().partition(is_quaternion);
    add(Some("Quaternion"), "", quaternions);
    add(None, "", numbers);
    add(None, "J", of("energy", "J", &["kinetic", "potential", "total"]));
    let is_driven = add(Some("Drive effort"), "N*m", of("drives", "N*m", &[]))
        || add(Some("Drive effort"), "N", of("drives", "N", &[]));
    if !is_driven {
        add(Some("Reaction force"), "N", reactions(channels));
    }
    groups.truncate(MAX_GROUPS);
    let n_left_out = groups.iter_mut().map(|group| keep(&mut group.quantities, most)).sum();
    (groups, n_left_out)
}

/// Keeps so many, spread evenly over all; how many have gone.
pub fn keep<T>(quantities: &mut Vec<T>, most: usize) -> usize {
    let n = quantities.len();
    if n <= most {
        return 0;
    }
    let mut chosen: Vec<usize> = (0..most).map(|k| k * (n - 1) / (most - 1).max(1)).collect();
    chosen.dedup();
    let mut place = 0;
    quantities.retain(|_| {
        place += 1;
        chosen.contains(&(place - 1))
    });
    n - most
}

/// The size of the force of each joint.
fn reactions(channels: &[(String, String)]) -> Vec<Quantity> {
    let mut sizes: Vec<Quantity> = Vec::new();
    for (channel, unit) in channels {
        let Some((name, component)) = channel.rsplit_once('.') else { continue };
        if !name.starts_with("reactions.") || !["fx", "fy", "fz"].contains(&component) {
            continue;
        }
        match sizes.iter_mut().find(|size| size.name == name) {
            Some(size) => size.channels.push(channel.clone()),
            None => sizes.push(Quantity {
                name: name.to_owned(),
                unit: unit.clone(),
                channels: vec![channel.clone()],
            }),
        }
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels(names: &[(&str, &str)]) -> Vec<(String, String)> {
        names.iter().map(|(name, unit)| ((*name).to_owned(), (*unit).to_owned())).collect()
    }

    #[test]
    fn drives_stand_for_what_moves_and_reactions_where_there_are_none() {
        let mut all = channels(&[
            ("state.a", "rad"),
            ("state.x", "m"),
            ("state.a_dot", "rad/s"),
            ("state.i", "A"),
            ("energy.total", "J"),
            ("energy.work", "J"),
            ("reactions.A.fx", "N"),
            ("reactions.A.fy", "N"),
            ("reactions.A.mx", "N*m"),
        ]);
        let (groups, n_left_out) = overview(&all, 6);
        let units: Vec<&str> = groups.iter().map(|group| group.unit.as_str()).collect();
        assert_eq!((units, n_left_out), (vec!["rad", "m", "rad/s", "A", "J", "N"], 0));
        assert_eq!(groups[4].quantities.len(), 1, "work is not among the energies");
        assert_eq!(groups[5].quantities[0].channels, ["reactions.A.fx", "reactions.A.fy"]);
        all.extend(channels(&[("drives.motor", "N*m")]));
        let last = overview(&all, 6).0.pop().expect("groups");
        assert_eq!((last.label, last.quantities.len()), (Some("Drive effort"), 1));
    }

    #[test]
    fn numbers_of_a_controller_are_no_quaternion() {
        let all = channels(&[("state.rod_e0", ""), ("state.rod_e1", ""), ("state.gain", "")]);
        let groups = overview(&all, 6).0;
        let labels: Vec<_> = groups.iter().map(|g| (g.label, g.quantities.len())).collect();
        assert_eq!(labels, [(Some("Quaternion"), 2), (None, 1)]);
    }

    #[test]
    fn few_of_many_are_spread_over_all() {
        let mut numbers: Vec<usize> = (0..11).collect();
        assert_eq!(keep(&mut numbers, 3), 8);
        assert_eq!(numbers, [0, 5, 10]);
    }
}
