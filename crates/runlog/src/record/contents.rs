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
    /// Whether the channels of other programs are there, too: `/tf`, `/scene`, `/spans`,
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

/// A joint that yields, or one of its directions, with its stiffness, as an option for the log.
pub fn compliance_option(name: &str, stiffness: &str) -> (String, String) {
    (format!("{COMPLIANCE}{name}"), stiffness.to_owned())
}

/// The joints that yield among the options of a log, with their stiffnesses.
pub fn compliances(options: &BTreeMap<String, String>) -> Vec<(String, String)> {
    let yields = |(key, value): (&String, &String)| {
        Some((key.strip_prefix(COMPLIANCE)?.to_owned(), value.clone()))
    };
    options.iter().filter_map(yields).collect()
}

/// The parameters among the options of a log that were given on the command line.
pub fn overrides(options: &BTreeMap<String, String>) -> Vec<(String, String)> {
    let set =
        |(key, value): (&String, &String)| Some((key.strip_prefix(SET)?.to_owned(), value.clone()));
    options.iter().filter_map(set).collect()
}
