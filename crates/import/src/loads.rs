//! Loads that act along the motion of a joint, as robot files have them: stops, springs, dampers, dry friction.

use crate::draft::{Draft, Table, number, signed};
use crate::job::{Job, Place};
use crate::names::Names;

/// Limits beyond this stand for none.
const NO_LIMIT: f64 = 1e15;

/// Joints that may rub: each sticks or slides either way, and a start tries 4096 cases.
const MAX_FRICTIONS: usize = 7;
/// Part of a range by which a joint of a loop starts within its nearest limit.
const INWARDS: f64 = 0.05;

/// One motion of a joint in which loads act.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<'m> {
    pub(crate) joint: &'m str,
    /// Which of several.
    pub(crate) of: Option<&'static str>,
    /// True if it turns; else it slides.
    pub(crate) turns: bool,
}

impl<'m> Motion<'m> {
    pub(crate) fn only(joint: &'m str, turns: bool) -> Self {
        Self { joint, of: None, turns }
    }

    /// A load that acts in it.
    fn load(&self, names: &mut Names, ending: &str, kind: &str) -> Table {
        let of = self.of.map_or(String::new(), |of| format!("_{of}"));
        let name = names.coin(&format!("{}{of}_{ending}", self.joint));
        let table = Table::new(name, kind).text("joint", self.joint);
        match self.of {
            Some(of) => table.text("of", of),
            None => table,
        }
    }
}

impl Draft {
    /// Stops at the limits of a motion, if it has any; where zero is out of reach, the joint starts at the nearest limit.
    pub(crate) fn add_stop(
        &mut self,
        names: &mut Names,
        motion: Motion<'_>,
        limits: [Option<f64>; 2],
    ) {
        let [lower, upper] = limits.map(|limit| limit.filter(|limit| limit.abs() < NO_LIMIT));
        if lower.is_none() && upper.is_none() {
            return;
        }
        let mut table = motion.load(names, "limit", "stop");
        for (key, limit) in [("min", lower), ("max", upper)] {
            if let Some(limit) = limit {
                table = table.number(key, limit);
            }
        }
        self.loads.push(table);
        let nearest = match (lower, upper) {
            (Some(lower), _) if lower > 0.0 => lower,
            (_, Some(upper)) if upper < 0.0 => upper,
            _ => return,
        };
        let word = motion.of.unwrap_or(if motion.turns { "angle" } else { "position" });
        if self.starts.iter().any(|(joint, own, _)| joint == motion.joint && own == word) {
            return;
        }
        let range = lower.zip(upper).map_or(0.0, |(lower, upper)| upper - lower);
        let inwards = INWARDS * range * nearest.signum();
        self.starts.push((motion.joint.to_owned(), word.to_owned(), [nearest, nearest + inwards]));
    }

    /// Writes where joints start that do not start at zero: of those that cannot, at their limits, but in loops, which move on as they close, a
    /// little within them.
    pub(crate) fn write_starts(&mut self) {
        // A tree has as many joints as bodies.
        let has_loops = self.joints.len() > self.bodies.len();
        for starts in self.starts.chunk_by(|a, b| a.0 == b.0) {
            let key = |(_, word, at): &(String, String, [f64; 2])| {
                format!("{word} = {}", number(at[usize::from(has_loops)]))
            };
            let keys: Vec<String> = starts.iter().map(key).collect();
            self.initial
                .push((starts[0].0.clone(), format!("{{ guess = {{ {} }} }}", keys.join(", "))));
        }
    }

    /// A spring and a damper in a joint: stiffness, where it is at rest, damping.
    pub(crate) fn add_spring(
        &mut self,
        names: &mut Names,
        motion: Motion<'_>,
        [stiffness, rest, damping]: [f64; 3],
    ) {
        if stiffness == 0.0 && damping == 0.0 {
            return;
        }
        let word = if stiffness == 0.0 { "damping" } else { "spring" };
        let kind = match (motion.turns, stiffness == 0.0) {
            (true, _) => "torsion",
            (false, true) => "damper",
            (false, false) => "spring",
        };
        let mut table = motion.load(names, word, kind);
        if stiffness != 0.0 {
            table = table.number("stiffness", stiffness);
            table = table.number(if motion.turns { "angle" } else { "length" }, rest);
        }
        if damping != 0.0 {
            table = table.number("damping", damping);
        }
        self.loads.push(table);
    }

    /// A joint that follows another one: motions as expressions with whether they are lengths, the follower first, then
    /// the multiplier and the offset.
    pub(crate) fn add_mimic(
        &mut self,
        names: &mut Names,
        joint: &str,
        [(of, is_length), (by, by_length)]: [(String, bool); 2],
        [multiplier, offset]: [f64; 2],
    ) {
        let by = if by_length && !is_length { format!("{by}/(1 m)") } else { by };
        let (factor, unit) = match (is_length, by_length) {
            (true, false) => (" m", " m"),
            (true, true) => ("", " m"),
            _ => ("", ""),
        };
        let constant =
            if offset == 0.0 { String::new() } else { format!(" {}{unit}", signed(-offset)) };
        let relation = format!("{of} {}{factor}*{by}{constant}", signed(-multiplier));
        let name = names.coin(&format!("{joint}_mimic"));
        self.couplings.push(Table::new(name, "relation").text("relation", &relation));
    }

    /// Dry friction in a joint, as the file has it at `place`.
    pub(crate) fn add_friction(
        &mut self,
        names: &mut Names,
        motion: Motion<'_>,
        friction: f64,
        place: &Place,
    ) {
        if friction > 0.0 {
            let key = if motion.turns { "torque" } else { "force" };
            let table = motion.load(names, "friction", "friction").number(key, friction);
            self.frictions.push((table.name.clone(), motion.joint.to_owned(), place.clone()));
            self.loads.push(table);
        }
    }

    /// Leaves out dry friction where too many joints rub to find which of them stick.
    pub(crate) fn limit_frictions(&mut self, job: &mut Job<'_>) {
        if self.frictions.len() <= MAX_FRICTIONS {
            return;
        }
        for (load, joint, place) in std::mem::take(&mut self.frictions) {
            self.loads.retain(|table| table.name != load);
            job.leave_out(format!("dry friction of joint {joint}"), &place);
        }
        self.heading.push(format!(
            "More than {MAX_FRICTIONS} joints rub in the file: a start has too many cases then, and their friction is left out."
        ));
    }
}
