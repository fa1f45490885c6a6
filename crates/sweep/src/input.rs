//! The quantities that axes vary: parameters and stated initial values of the model.

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{WrittenUnit, suggest};
use bksim::model::{Initial, Model};

use crate::axis::Axis;
use crate::codes;
use crate::plan::Plan;
use crate::request::Request;

/// The quantity of an axis and its units.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    pub(crate) quantity: Quantity,
    /// From its numbers to SI; `None` for numbers without unit.
    unit: Option<WrittenUnit>,
    /// SI unit.
    si: String,
}

/// A varied quantity.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Quantity {
    /// The parameter that the axis names.
    Parameter,
    /// The initial value with this index in the model.
    Initial(usize),
}

impl Input {
    /// A number of the axis in SI.
    pub(crate) fn to_si(&self, number: f64) -> f64 {
        self.unit.map_or(number, |unit| unit.to_si(number))
    }

    /// SI unit of the input, written as those of channels are.
    pub(crate) fn column_unit(&self) -> String {
        self.si.replace(' ', "*")
    }
}

/// The parameters that a case sets.
pub(crate) fn overrides(plan: &Plan, inputs: &[Input], numbers: &[f64]) -> Vec<(String, String)> {
    let axes = plan.axes().iter().zip(inputs).zip(numbers);
    let parameters = axes.filter(|((_, input), _)| input.quantity == Quantity::Parameter);
    parameters.map(|((axis, _), &number)| (axis.name.clone(), axis.text(number))).collect()
}

/// The quantities of all axes.
pub(crate) fn inputs(request: &Request, model: &Model) -> Result<Vec<Input>, Diagnostic> {
    request.plan.axes().iter().map(|axis| input(request, model, axis)).collect()
}

fn input(request: &Request, model: &Model, axis: &Axis) -> Result<Input, Diagnostic> {
    let Axis { name, unit, .. } = axis;
    if request.fixed.iter().any(|(fixed, _)| fixed == name) {
        let message = format!("`{name}` is both given one value and varied");
        return Err(Diagnostic::error(codes::AXIS_TWICE, message).help("leave out one of the two"));
    }

    // A parameter of this name.
    let written = WrittenUnit::parse(unit);
    if let Some(parameter) = model.parameters.iter().find(|p| p.name == *name) {
        // Numbers without unit are in units of the file; without any these are SI.
        let own = if states_units(&request.model) { "" } else { parameter.unit.as_str() };
        let si = written.map_or_else(|| own.to_owned(), |unit| unit.si());
        return Ok(Input { quantity: Quantity::Parameter, unit: written, si });
    }

    // Or a stated initial value, which needs a unit of its kind.
    let Some(initial_idx) = model.initial.iter().position(|i| i.name == *name) else {
        let parameters = model.parameters.iter().map(|p| p.name.as_str());
        let known: Vec<&str> =
            parameters.chain(model.initial.iter().map(|i| i.name.as_str())).collect();
        let message = format!("the model has no parameter or stated initial value `{name}`");
        let fault = Diagnostic::error(codes::UNKNOWN_AXIS, message);
        return Err(fault.help(suggest(name, &known)));
    };
    let si = unit_of(model, &model.initial[initial_idx]);
    if written.map_or_else(String::new, |written| written.si()) != si {
        let (message, help) = if si.is_empty() {
            let message = format!("the axis `{name}` is of numbers without unit");
            (message, format!("write them alone: `{name}=0:1:11`"))
        } else {
            let message = format!("the axis `{name}` needs a unit of the kind {si}");
            (message, format!("write it after the numbers: `{name}=0:1 {si}:11`"))
        };
        return Err(Diagnostic::error(codes::BAD_AXIS, message).help(help));
    }
    Ok(Input { quantity: Quantity::Initial(initial_idx), unit: written, si: si.to_owned() })
}

/// True of a model whose text states the units of bare numbers.
fn states_units(text: &str) -> bool {
    let mut is_top = true;
    text.lines().map(str::trim).any(|line| {
        let header = line.strip_prefix('[');
        is_top &= header.is_none();
        let key = header.or(is_top.then_some(line)).unwrap_or_default().trim_start();
        let rest = key.strip_prefix("units").map(str::trim_start);
        rest.is_some_and(|rest| rest.starts_with([']', '=', '.']))
    })
}

/// SI unit of a parameter or stated initial value, for an [`Axis`] with numbers in SI; `None` when
/// nothing has this name.
pub fn si_unit(model: &Model, name: &str) -> Option<String> {
    let parameter = model.parameters.iter().find(|p| p.name == name);
    let initial = || model.initial.iter().find(|i| i.name == name);
    let of_initial = || Some(unit_of(model, initial()?).to_owned());
    let unit = parameter.map(|parameter| parameter.unit.clone()).or_else(of_initial)?;
    // `1/s` would be read as a number: written, it is rad/s. Units in parentheses would be names.
    let unit = unit.strip_prefix("1/").map_or(unit.clone(), |rest| format!("rad/{rest}"));
    let parts = unit.strip_suffix(')').and_then(|rest| rest.split_once("/("));
    Some(parts.map_or(unit.clone(), |(over, under)| format!("{over}/{}", under.replace(' ', "/"))))
}

/// SI unit of a stated initial value, as written units have it.
fn unit_of<'m>(model: &'m Model, initial: &Initial) -> &'m str {
    match initial.unit(model) {
        "rad/s" => "1/s",
        unit => unit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_section_of_units_states_them() {
        for text in
            ["[units]\nlength = \"mm\"", "x = 1\n[ units ]", "units = {}", "units.angle = \"deg\""]
        {
            assert!(states_units(text), "{text}");
        }
        let table = "# Numbers may carry units\n[tables.pull]\nunits = [\"deg\", \"N\"]\n[unitsx]";
        assert!(!states_units(table));
    }
}
