//! Contents of a log other than samples: options, parameters given on the command line, and the
//! channels that are there on request.

use std::collections::BTreeMap;

use bksim_sim::sensitivity::Sensitive;

/// Contents of a log other than samples.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Contents<'a> {
    /// Settings to keep with the model's own.
    pub options: &'a [(String, String)],
    /// Quantities that have a channel for the sensitivities to each: `/sensitivity/l1`,
    /// `/sensitivity/A/rate`.
    pub sensitive: &'a [Sensitive],
    /// True if the channels of other programs are there, too: `/tf`, `/scene`, `/spans`,
    /// `/joint_states`, `/outlines/…`.
    pub has_viewers: bool,
}

impl Default for Contents<'_> {
    /// No options, no sensitivities, and the channels of other programs.
    fn default() -> Self {
        Self { options: &[], sensitive: &[], has_viewers: true }
    }
}

/// Options with this prefix are parameters given on the command line.
const SET: &str = "set.";

/// A parameter given on the command line, as an option for the log.
pub fn set_option(name: &str, value: &str) -> (String, String) {
    (format!("{SET}{name}"), value.to_owned())
}

/// Options with this prefix are joints that yield.
const COMPLIANCE: &str = "compliance.";

/// Joints that yield, or some of their directions, with their stiffnesses, as options for the log: one of each name, with all
/// of its stiffnesses.
pub fn compliance_options(written: &[(String, String)]) -> Vec<(String, String)> {
    let mut of_name: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, stiffness) in written {
        of_name.entry(name).or_default().push(stiffness);
    }
    of_name.iter().map(|(name, all)| (format!("{COMPLIANCE}{name}"), all.join(", "))).collect()
}

/// The joints that yield among the options of a log, with their stiffnesses.
pub fn compliances(options: &BTreeMap<String, String>) -> Vec<(String, String)> {
    let yields =
        options.iter().filter_map(|(key, value)| key.strip_prefix(COMPLIANCE).zip(Some(value)));
    let each = |(name, all): (&str, &String)| {
        all.split(", ").map(|stiffness| (name.to_owned(), stiffness.to_owned())).collect::<Vec<_>>()
    };
    yields.flat_map(each).collect()
}

/// The parameters among the options of a log that were given on the command line.
pub fn overrides(options: &BTreeMap<String, String>) -> Vec<(String, String)> {
    let set =
        |(key, value): (&String, &String)| Some((key.strip_prefix(SET)?.to_owned(), value.clone()));
    options.iter().filter_map(set).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_keeps_all_of_its_stiffnesses() {
        let written = [("B.fy", "2 N/m"), ("A", "1e8 N/m"), ("A", "1e5 N m/rad")];
        let written = written.map(|(name, value)| (name.to_owned(), value.to_owned()));
        let known = compliances(&compliance_options(&written).into_iter().collect());
        assert_eq!(known, [1, 2, 0].map(|k| written[k].clone()));
    }
}
