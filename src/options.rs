//! The options of a run: other values in place of the model's, and all of them in words.

use bksim_model::{Formulation, Jit, Method, Model, Outputs, SolveOptions};
use bksim_sim::sensitivity::Sensitive;

/// The words for the forms of the equations.
pub const FORMULATIONS: [(&str, Formulation); 4] = [
    ("ggl", Formulation::Ggl),
    ("index2", Formulation::Index2),
    ("index3", Formulation::Index3),
    ("index1", Formulation::Index1),
];

/// The words for the integrators.
pub const METHODS: [(&str, Method); 3] =
    [("auto", Method::Auto), ("radau", Method::Radau), ("explicit", Method::Explicit)];

/// The words for the use of machine code.
pub const JITS: [(&str, Jit); 3] = [("auto", Jit::Auto), ("on", Jit::On), ("off", Jit::Off)];

/// The smallest relative tolerance that numbers of 16 digits can keep through a step.
const SMALLEST_RTOL: f64 = 1e-13;

/// Options in place of the model's; those that are `None` stay.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct SolveChanges {
    /// End time, s: any but the start.
    pub t_end: Option<f64>,
    /// Relative tolerance, 1e-13 … 1.
    pub rtol: Option<f64>,
    /// Absolute tolerance, in the SI unit of each coordinate.
    pub atol: Option<f64>,
    /// Fixed step, s.
    pub step: Option<f64>,
    /// Interval of the output, s.
    pub every: Option<f64>,
    /// The integrator.
    pub method: Option<Method>,
    /// The form of the equations that Radau IIA integrates.
    pub formulation: Option<Formulation>,
    /// Whether the equations run as machine code.
    pub jit: Option<Jit>,
}

/// A value that an option cannot have.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("`{option}` is {} and not {range}", in_words(*.value))]
pub struct BadOption {
    /// Name as a key of `[solve]`.
    pub option: &'static str,
    /// The value.
    pub value: f64,
    /// The values that it may have: `greater than zero`.
    pub range: String,
}

/// A number as a person writes it.
pub fn in_words(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 { format!("{value:e}") } else { value.to_string() }
}

impl SolveChanges {
    /// Checks the ranges of all values; runs begin at `t_start`, s.
    ///
    /// # Errors
    /// [`BadOption`], the first.
    pub fn check(&self, t_start: f64) -> Result<(), BadOption> {
        let other_than_start = |t: f64| t.is_finite() && t != t_start;
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let useful = |rtol: f64| (SMALLEST_RTOL..1.0).contains(&rtol);
        let beyond = format!("other than the start, {t_start} s");
        let rtol_range = format!("between {SMALLEST_RTOL:e} and 1");
        let above = "greater than zero";
        for (option, value, fits, range) in [
            ("t_end", self.t_end, &other_than_start as &dyn Fn(f64) -> bool, beyond.as_str()),
            ("rtol", self.rtol, &useful, &rtol_range),
            ("atol", self.atol, &positive, above),
            ("step", self.step, &positive, above),
            ("every", self.every, &positive, above),
        ] {
            if let Some(value) = value.filter(|&value| !fits(value)) {
                return Err(BadOption { option, value, range: range.to_owned() });
            }
        }
        Ok(())
    }

    /// Puts these options in place of those of `solve`.
    pub fn apply(&self, solve: &mut SolveOptions) {
        solve.t_end = self.t_end.unwrap_or(solve.t_end);
        solve.rtol = self.rtol.unwrap_or(solve.rtol);
        solve.atol = self.atol.unwrap_or(solve.atol);
        solve.step = self.step.or(solve.step);
        if self.every.is_some() {
            (solve.every, solve.outputs) = (self.every, Outputs::Even);
        }
        solve.method = self.method.unwrap_or(solve.method);
        solve.formulation = self.formulation.unwrap_or(solve.formulation);
        solve.jit = self.jit.unwrap_or(solve.jit);
    }
}

/// All options of a run as they are used, for the log.
pub fn described(model: &Model, sensitive: &[Sensitive]) -> Vec<(String, String)> {
    let solve = &model.solve;
    let formulation = word(&FORMULATIONS, solve.formulation);
    let method = word(&METHODS, solve.method);
    let exact = |value: f64| format!("{value:?}");
    let every = match solve.outputs {
        Outputs::Steps => "step".to_owned(),
        _ => solve.every.map_or("default".to_owned(), exact),
    };
    let mut options: Vec<(String, String)> = vec![
        ("method".into(), method.into()),
        ("formulation".into(), formulation.into()),
        ("t_start".into(), exact(solve.t_start)),
        ("t_end".into(), exact(solve.t_end)),
        ("every".into(), every),
        ("rtol".into(), exact(solve.rtol)),
        ("atol".into(), exact(solve.atol)),
        ("step".into(), solve.step.map_or("adaptive".to_owned(), exact)),
    ];
    if !sensitive.is_empty() {
        let names: Vec<&str> = sensitive.iter().map(|by| by.name(model)).collect();
        options.push(("sensitivity".into(), names.join(" ")));
    }
    if let Outputs::Times(times) = &solve.outputs {
        let times: Vec<_> = times.iter().copied().map(exact).collect();
        options.push(("times".into(), times.join(" ")));
    }
    options
}

/// The word of a choice.
pub fn word<T: PartialEq + Copy>(words: &[(&'static str, T)], choice: T) -> &'static str {
    words.iter().find(|(_, known)| *known == choice).map_or("", |(word, _)| word)
}

/// The choice that a word stands for.
pub fn choice<T: Copy>(words: &[(&'static str, T)], word: &str) -> Option<T> {
    words.iter().find(|(known, _)| *known == word).map(|&(_, choice)| choice)
}
