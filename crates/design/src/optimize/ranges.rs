//! Varied quantities with their ranges, and those that the model states outside of them.

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{code, stated_ranges};
use bksim::model::message::short;

use super::{OptimizeWish, is_geometry};
use crate::base::{Quantity, Source, Stated};
use crate::codes;
use crate::error::DesignError;
use crate::spec::{located, place};

/// A varied quantity with its range.
pub(super) struct Range {
    pub(super) stated: Stated,
    pub(super) from: f64,
    pub(super) to: f64,
    /// Unit in which its values are written.
    pub(super) unit: String,
}

/// The quantities that a question varies.
pub(super) fn ranges(
    source: &Source,
    wish: &OptimizeWish,
    is_geometry: bool,
) -> Result<Vec<Range>, DesignError> {
    let names: Vec<String> = wish.vary.iter().map(|(name, _)| name.clone()).collect();
    let stated = source.stated(&names, is_geometry)?;
    let range = |(stated, (_, [from, to])): (Stated, &(String, [String; 2]))| {
        let ends = Quantity::read(from).zip(Quantity::read(to));
        let is_range = |(from, to): &(Quantity, Quantity)| {
            from.value < to.value && from.fits(&stated.unit) && to.fits(&stated.unit)
        };
        let (from, to) = ends.filter(is_range).ok_or_else(|| {
            let message = format!("`{from}` to `{to}` is no range of `{}`", stated.name);
            let unit = &stated.unit;
            let help = format!("give the least value first, and units of the kind {unit}: `{} = [\"0.5 {unit}\", \"2 {unit}\"]`", stated.name);
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, from)
        })?;
        let unit = if to.unit.is_empty() { from.unit.clone() } else { to.unit.clone() };
        Ok(Range { stated, from: from.value, to: to.value, unit })
    };
    stated.into_iter().zip(&wish.vary).map(range).collect()
}

/// Warnings of quantities that the model states outside of the ranges in which they are searched.
pub(super) fn outside(
    source: &Source,
    wish: &OptimizeWish,
) -> Result<Vec<Diagnostic>, DesignError> {
    let warning = |(range, (name, ends)): (&Range, &(String, [String; 2]))| {
        let Range { stated, from, to, .. } = range;
        let slack = 1e-9 * (to - from);
        let is_within = (from - slack..=to + slack).contains(&stated.value);
        // Of a range below `[ranges]` the reader of the model warns.
        if is_within || stated_ranges(&source.text).contains(&(name.clone(), ends.clone())) {
            return None;
        }
        let [own, low, high] = [stated.value, *from, *to].map(short);
        let unit = format!(" {}", stated.unit).trim_end().to_owned();
        let message =
            format!("`{name}` is {own}{unit}, outside of its range from {low} to {high}{unit}");
        let nearest = short(stated.value.clamp(*from, *to));
        let fault = Diagnostic::warning(code::OUTSIDE_RANGE, message)
            .note(format!("the search begins at {nearest}{unit}, the nearest value in it"))
            .help("widen the range, or give the value another number in it");
        Some(match place(&source.text, name) {
            Some(span) => fault.at(span, "its range"),
            None => fault,
        })
    };
    let ranges = ranges(source, wish, is_geometry(wish))?;
    Ok(ranges.iter().zip(&wish.vary).filter_map(warning).collect())
}
