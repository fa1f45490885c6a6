//! Questions of design under Python: a model's text and a question as a section of it; answers as JSON. Ctrl-C ends a search
//! with the best so far.

use bksim_design::{DataFile, DesignError, FitWish, OptimizeWish, Source, ToleranceWish, Watch};
use bksim_load::Text;
use pyo3::prelude::*;
use serde::Serialize;

use crate::fault::{Fault, warn};
use crate::sweep::watched;

/// A file of measurements: name, text, parameters of its run.
type Measured = (String, String, Vec<(String, String)>);

/// The answer to `optimize`, `fit`, `tolerance` or `synthesize` as JSON, with the model that it gives, if it gives one.
/// `question` is the section of that name; of `synthesize` `text` is. `data` are measurements, of `optimize` the unfinished
/// front of an earlier answer.
#[pyfunction]
pub(crate) fn design_answer(
    py: Python<'_>,
    kind: String,
    text: String,
    name: String,
    question: Option<String>,
    data: Vec<Measured>,
) -> PyResult<(String, Vec<(String, String)>)> {
    let about = Text::new(format!("{name}.toml"), text.clone());
    let mut warnings = Vec::new();
    let (found, raised) = watched(py, None, |monitor| {
        let asked = question.as_deref().unwrap_or(&text);
        let source = Source { text: text.clone(), name, ..Source::default() };
        let watch = Watch { stop: monitor.stop, ..Watch::default() };
        let model = |text: &str| vec![(source.name.clone(), text.to_owned())];
        let found = match kind.as_str() {
            "optimize" => OptimizeWish::of_model(asked)
                .and_then(|wish| match &wish {
                    // Where to begin alone: the question is that of the model.
                    OptimizeWish { minimize: None, maximize: None, .. } if question.is_some() => {
                        let of_model = OptimizeWish::of_model(&text)?;
                        Ok(OptimizeWish { from: wish.from, starts: wish.starts, ..of_model })
                    }
                    _ => Ok(wish),
                })
                .map(|wish| {
                    let front = data.first().and_then(|(_, of, _)| serde_json::from_str(of).ok());
                    OptimizeWish { resume: front, ..wish }
                })
                .and_then(|wish| bksim_design::optimize(&source, &wish, watch))
                .map(|found| (json(&found), model(&found.model))),
            "fit" => {
                let data: Vec<DataFile> = data
                    .into_iter()
                    .map(|(name, text, set)| DataFile { name, text, set })
                    .collect();
                FitWish::of_model(asked)
                    .and_then(|wish| bksim_design::fit(&source, &data, &wish, watch))
                    .map(|found| {
                        warnings.clone_from(&found.warnings);
                        (json(&found), model(&found.model))
                    })
            }
            "tolerance" => ToleranceWish::of_model(asked)
                .and_then(|wish| bksim_design::tolerance(&source, &wish, watch))
                .map(|found| {
                    let models = found.model.as_deref().map(&model).unwrap_or_default();
                    (json(&found), models)
                }),
            _ => bksim_design::synthesize(asked).map(|found| {
                let models = found.candidates.iter().map(|c| (c.name.clone(), c.model.clone()));
                (json(&found), models.collect())
            }),
        };
        found.map_err(|error| fault(&about, &error))
    })?;
    warn(py, &about, &warnings, 3)?;
    raised.map_or(Ok(found), |error| {
        Python::attach(|py| Err(PyErr::from_value(error.into_bound(py))))
    })
}

fn json(found: &impl Serialize) -> String {
    serde_json::to_string(found).unwrap_or_default()
}

fn fault(source: &Text, error: &DesignError) -> Fault {
    match error.diagnostics() {
        faults if faults.is_empty() => Fault::Limit(error.to_string()),
        faults => Fault::model(source, &faults),
    }
}
