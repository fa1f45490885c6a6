//! [`WayRates`]: a way on from a pose, named by the rates of joints along it.

/// Rates of joints, the first of which is one, each with its name and the unit of the value: a way on from a pose.
pub type WayRates = Vec<(String, f64, &'static str)>;

/// The cure of a start in which branches cross, where none can be chosen.
pub(crate) const ASIDE: &str =
    "begin aside of it, on the branch that is meant: state another value in `[initial]`";

/// A way in words: `A.angle 1, D.angle -2.33333`.
pub fn in_words(way: &WayRates) -> String {
    let rate = |(name, rate, unit): &(String, f64, &'static str)| {
        let rounded = (rate * 1e5).round() / 1e5;
        let unit = if *unit == "m" { " m" } else { "" };
        format!("{name} {}{unit}", if rounded == 0.0 { 0.0 } else { rounded })
    };
    way.iter().map(rate).collect::<Vec<_>>().join(", ")
}
