//! Common beginning of all questions: the model, its quantities that vary, and their texts.

use bksim::SolveChanges;
use bksim::model::Model;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{self, Limits, WrittenUnit, read, suggest};
use bksim_edit::{Edit, edited};
use bksim_sweep::{Axis, Design, NeedsSlopes, Plan, Request, Study, Values, si_unit};

use crate::codes;
use crate::error::DesignError;

/// The text of a model, and how it is read.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Text of the model.
    pub text: String,
    /// Name of the model unless the text states one.
    pub name: String,
    /// Parameters with one other value.
    pub fixed: Vec<(String, String)>,
    /// Deepest nesting of brackets; 64 unless given.
    pub nesting: Option<usize>,
    /// Settings of runs; tolerances are 1e-10, relative, and 1e-12 unless given, so that differences are good.
    pub changes: SolveChanges,
}

/// Tolerances of runs unless given.
const RTOL: f64 = 1e-10;
const ATOL: f64 = 1e-12;

/// Callbacks that stop an answer and show how far it is.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Asked between evaluations.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Called with what is under way and the share of it that is done.
    pub reached: &'a (dyn Fn(&str, f64) + Sync),
    /// Called as soon as a stop leaves an answer.
    pub kept: &'a (dyn Fn() + Sync),
}

impl Default for Watch<'_> {
    /// Nobody.
    fn default() -> Self {
        Self { stop: &|| false, reached: &|_, _| (), kept: &|| () }
    }
}

/// A parameter or initial value that varies, as the model states it.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Stated {
    pub(crate) name: String,
    /// SI unit.
    pub(crate) unit: String,
    /// Value in the model, SI.
    pub(crate) value: f64,
}

impl Source {
    fn limits(&self) -> Limits {
        self.nesting.map_or_else(Limits::default, |nesting| Limits { nesting })
    }

    /// The model, as it is written, with these values as parameters besides.
    pub(crate) fn model(
        &self,
        promoted: &[String],
        is_geometry: bool,
    ) -> Result<Model, DesignError> {
        let source = file::Source {
            overrides: &self.fixed,
            promoted,
            limits: self.limits(),
            is_geometry,
            ..file::Source::new(&self.text, &self.name)
        };
        let reading = read(&source);
        reading.model.ok_or_else(|| bksim::Rejected(reading.diagnostics).into())
    }

    /// Parameters and initial values of these names.
    pub(crate) fn stated(
        &self,
        names: &[String],
        is_geometry: bool,
    ) -> Result<Vec<Stated>, DesignError> {
        let plain = self.model(&[], is_geometry)?;
        let is_initial = |name: &String| plain.initial.iter().any(|i| i.name == **name);
        let promoted: Vec<String> =
            names.iter().filter(|name| name.contains('.') && !is_initial(name)).cloned().collect();
        let model = if promoted.is_empty() { plain } else { self.model(&promoted, is_geometry)? };
        names.iter().map(|name| stated(&model, name)).collect()
    }

    /// The sweep of these quantities, with outputs.
    pub(crate) fn study(
        &self,
        varied: &[Stated],
        fixed: &[(String, String)],
        outputs: &[String],
        is_geometry: bool,
    ) -> Result<Study, DesignError> {
        let axis = |one: &Stated| Axis::new(&one.name, Values::List(vec![one.value]), &one.unit);
        let axes = varied.iter().map(axis).collect::<Result<Vec<_>, Diagnostic>>()?;
        let mut request = Request::new(&self.text, &self.name, Plan::new(axes, Design::Pairs)?);
        request.fixed = [self.fixed.as_slice(), fixed].concat();
        request.limits = self.limits();
        request.outputs = outputs.to_vec();
        request.is_geometry = is_geometry;
        request.changes = self.changes;
        request.changes.rtol = request.changes.rtol.or(Some(RTOL));
        request.changes.atol = request.changes.atol.or(Some(ATOL));
        request.slopes = if is_geometry { NeedsSlopes::No } else { NeedsSlopes::Yes };
        Ok(Study::prepare(request)?)
    }

    /// The text with other values of some quantities, each in its unit; every other byte stays.
    pub(crate) fn with_values(&self, values: &[(String, String)]) -> Result<String, DesignError> {
        let mut text = self.text.clone();
        for (name, value) in values {
            let paths = ["parameters.", "initial.", "bodies.", ""].map(|at| format!("{at}{name}"));
            let set = |path: &String| {
                edited(&text, &Edit::Set { path: path.clone(), value: value.clone() })
            };
            // A path of a table that is there: an edit adds keys, so look for the name before.
            let known = paths.iter().find(|path| has_value(&self.text, path)).unwrap_or(&paths[0]);
            text = set(known).map_err(|error| error.diagnostic(&text))?;
        }
        Ok(text)
    }
}

/// True where a text has a value of this path.
fn has_value(text: &str, path: &str) -> bool {
    let Ok(root) = text.parse::<toml::Table>() else { return false };
    let mut keys = path.split('.');
    let Some(first) = keys.next() else { return false };
    let below =
        |value: Option<toml::Value>, key: &str| value.and_then(|value| value.get(key).cloned());
    keys.fold(root.get(first).cloned(), below).is_some()
}

fn stated(model: &Model, name: &str) -> Result<Stated, DesignError> {
    let parameters = &model.parameters;
    let Some(unit) = si_unit(model, name) else {
        let known: Vec<&str> = (parameters.iter().map(|p| p.name.as_str()))
            .chain(model.initial.iter().map(|i| i.name.as_str()))
            .collect();
        let message = format!("the model has no parameter or stated initial value `{name}`");
        return Err(DesignError::fault(codes::UNKNOWN_QUANTITY, message, suggest(name, &known)));
    };
    let known = |symbol| parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    let value = if let Some(parameter) = parameters.iter().find(|p| p.name == name) {
        parameter.value
    } else {
        let initial = model.initial.iter().find(|i| i.name == name);
        initial.and_then(|i| model.pool.evaluate(i.value, &known).ok()).unwrap_or(f64::NAN)
    };
    Ok(Stated { name: name.to_owned(), unit, value })
}

/// A quantity with its unit, such as `80 mm`.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Quantity {
    /// SI.
    pub(crate) value: f64,
    /// Unit as written.
    pub(crate) unit: String,
}

impl Quantity {
    /// Reads `80 mm`, or a number.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        let is_number = |end: &usize| text[..*end].trim().parse::<f64>().is_ok_and(f64::is_finite);
        let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
        let end = ends.collect::<Vec<_>>().into_iter().rev().find(is_number)?;
        let (number, unit) = (text[..end].trim().parse::<f64>().ok()?, text[end..].trim());
        let value = if unit.is_empty() { number } else { WrittenUnit::parse(unit)?.to_si(number) };
        Some(Self { value, unit: unit.to_owned() })
    }

    /// True if it can stand for a quantity of this SI unit.
    pub(crate) fn fits(&self, si: &str) -> bool {
        let pure = Some(WrittenUnit::PURE);
        let own = if self.unit.is_empty() { pure } else { WrittenUnit::parse(&self.unit) };
        let of = if si.is_empty() { pure } else { WrittenUnit::parse(si) };
        self.unit.is_empty() || own.zip(of).is_none_or(|(own, of)| own.is_alike(&of))
    }
}

/// A value in SI as a file writes it in `unit`: the shortest text that reads as it.
pub(crate) fn written(value: f64, unit: &str) -> String {
    let one =
        if unit.is_empty() { 1.0 } else { WrittenUnit::parse(unit).map_or(1.0, |u| u.to_si(1.0)) };
    let number = value / one;
    if unit.is_empty() { format!("{number}") } else { format!("{number} {unit}") }
}
