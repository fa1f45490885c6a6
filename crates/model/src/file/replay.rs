//! The replay of values: those of a file that depend on parameters only, with the steps that led to
//! them. Other values of some parameters then give theirs, and the checks on them, without reading
//! the file again.
//!
//! A [`Constant`] that depends on no varied parameter is a number and nothing else, so a reading that
//! records nothing costs nothing. A number may be looked at for messages and warnings; whatever the
//! model is made of depends on it through [`Constants::is_above`] and its like, or pins it.

use bksim_expr::{Function, Number, Pool};

use super::units::Scale;
use crate::SolveOptions;

/// A value of the file, and its index in the recording if it depends on a varied parameter.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Constant {
    value: f64,
    slot: Option<usize>,
}

/// One step of the arithmetic of a value that varies.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Step {
    /// A varied parameter, SI.
    Varied(usize),
    Negate(Constant),
    Add(Constant, Constant),
    Subtract(Constant, Constant),
    Multiply(Constant, Constant),
    Divide(Constant, Constant),
    Power(Constant, Constant),
    Scale(Constant, Scale),
    Call(Function, [Constant; 3]),
}

/// A condition under which the model stays the same but for its numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Guard {
    Above(Constant, Constant),
    NotBelow(Constant, Constant),
    Differ(Constant, Constant),
    /// The value is unchanged.
    Pinned(Constant),
}

/// A number among the settings of the solution.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Setting {
    Start,
    End,
    Every,
    Step,
}

/// The recording while a file is read.
#[derive(Debug, Default)]
pub(super) struct Constants {
    /// Parameters that vary.
    varied: Vec<String>,
    steps: Vec<Step>,
    guards: Vec<Guard>,
    settings: Vec<(Setting, Constant)>,
}

/// Parameters and settings of a model as functions of some of its parameters; see
/// [`read_recorded`](super::read_recorded).
#[derive(Clone, Debug)]
pub struct Recording {
    steps: Vec<Step>,
    guards: Vec<Guard>,
    settings: Vec<(Setting, Constant)>,
    /// By parameter of the model.
    parameters: Vec<Constant>,
}

impl Constant {
    /// A written number.
    pub(super) fn written(value: f64) -> Self {
        Self { value, slot: None }
    }

    /// Number of the constant, for messages and warnings; nothing else may depend on it.
    pub(super) fn look(self) -> f64 {
        self.value
    }

    fn among(self, values: &[f64]) -> f64 {
        self.slot.map_or(self.value, |slot| values[slot])
    }
}

impl Step {
    /// Arithmetic of a step, for a reading and for its recording.
    fn value(self, of: impl Fn(Constant) -> f64, varied: &[f64]) -> f64 {
        match self {
            Self::Varied(idx) => varied[idx],
            Self::Negate(a) => -of(a),
            Self::Add(a, b) => of(a) + of(b),
            Self::Subtract(a, b) => of(a) - of(b),
            Self::Multiply(a, b) => of(a) * of(b),
            Self::Divide(a, b) => of(a) / of(b),
            Self::Power(a, b) => of(a).powf(of(b)),
            Self::Scale(a, scale) => scale.apply(of(a)),
            Self::Call(function, arguments) => {
                call(function, &arguments.map(of)[..function.arity().min(3)])
            }
        }
    }

    fn operands(self) -> [Constant; 3] {
        let none = Constant::written(0.0);
        match self {
            Self::Varied(_) => [none; 3],
            Self::Negate(a) | Self::Scale(a, _) => [a, none, none],
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Power(a, b) => [a, b, none],
            Self::Call(_, arguments) => arguments,
        }
    }
}

/// The value of a function, as expressions have it.
fn call(function: Function, arguments: &[f64]) -> f64 {
    let pool = Pool::new();
    let numbers: Vec<_> = arguments.iter().map(|&x| pool.number(Number::float(x))).collect();
    let value = pool.call(function, &numbers).and_then(|e| pool.evaluate(e, &|_| None).ok());
    value.unwrap_or(f64::NAN)
}

impl Constants {
    /// Nothing recorded yet; these parameters vary.
    pub(super) fn new(varied: &[String]) -> Self {
        Self { varied: varied.to_vec(), ..Self::default() }
    }

    /// Records where a value comes from if that varies.
    fn take(&mut self, step: Step) -> Constant {
        let value = step.value(Constant::look, &[]);
        if step.operands().iter().all(|operand| operand.slot.is_none()) {
            return Constant::written(value);
        }
        self.steps.push(step);
        Constant { value, slot: Some(self.steps.len() - 1) }
    }

    /// The value of a parameter that was evaluated: an input of the recording if it is varied.
    pub(super) fn parameter(&mut self, name: &str, constant: Constant) -> Constant {
        let Some(idx) = self.varied.iter().position(|varied| varied == name) else {
            return constant;
        };
        self.steps.push(Step::Varied(idx));
        Constant { value: constant.value, slot: Some(self.steps.len() - 1) }
    }

    pub(super) fn negate(&mut self, a: Constant) -> Constant {
        self.take(Step::Negate(a))
    }

    pub(super) fn add(&mut self, a: Constant, b: Constant) -> Constant {
        self.take(Step::Add(a, b))
    }

    pub(super) fn subtract(&mut self, a: Constant, b: Constant) -> Constant {
        self.take(Step::Subtract(a, b))
    }

    pub(super) fn multiply(&mut self, a: Constant, b: Constant) -> Constant {
        self.take(Step::Multiply(a, b))
    }

    pub(super) fn divide(&mut self, a: Constant, b: Constant) -> Constant {
        self.take(Step::Divide(a, b))
    }

    pub(super) fn power(&mut self, a: Constant, b: Constant) -> Constant {
        self.take(Step::Power(a, b))
    }

    pub(super) fn scaled(&mut self, a: Constant, scale: Scale) -> Constant {
        self.take(Step::Scale(a, scale))
    }

    pub(super) fn call(&mut self, function: Function, arguments: &[Constant]) -> Constant {
        let argument = |idx: usize| arguments.get(idx).copied().unwrap_or(Constant::written(0.0));
        self.take(Step::Call(function, std::array::from_fn(argument)))
    }

    /// True if a > b.
    pub(super) fn is_above(&mut self, a: Constant, b: Constant) -> bool {
        self.guard(Guard::Above(a, b), &[a, b])
    }

    /// True if a ≥ b.
    pub(super) fn is_not_below(&mut self, a: Constant, b: Constant) -> bool {
        self.guard(Guard::NotBelow(a, b), &[a, b])
    }

    /// True if a ≠ b.
    pub(super) fn differ(&mut self, a: Constant, b: Constant) -> bool {
        self.guard(Guard::Differ(a, b), &[a, b])
    }

    /// Sign of a constant that is in the model: another one needs a reading of its own.
    pub(super) fn pinned_sign(&mut self, a: Constant) {
        let zero = Constant::written(0.0);
        let sides = if a.value < 0.0 { [zero, a] } else { [a, zero] };
        if a.value == 0.0 {
            self.pinned(a);
        } else {
            self.is_above(sides[0], sides[1]);
        }
    }

    /// Number of a constant that is in the model: another one needs a reading of its own.
    pub(super) fn pinned(&mut self, a: Constant) -> f64 {
        self.guard(Guard::Pinned(a), &[a]);
        a.value
    }

    /// A guard that does not hold now is one for the message that follows: there is no model then.
    fn guard(&mut self, guard: Guard, of: &[Constant]) -> bool {
        let holds = guard.holds(&Constant::look);
        if of.iter().any(|constant| constant.slot.is_some()) {
            self.guards.push(guard);
        }
        holds
    }

    /// A number among the settings.
    pub(super) fn set(&mut self, setting: Setting, constant: Constant) -> f64 {
        if constant.slot.is_some() {
            self.settings.push((setting, constant));
        }
        constant.value
    }

    /// The recording of a model with these parameters.
    pub(super) fn finish(self, parameters: Vec<Constant>) -> Recording {
        let Self { steps, guards, settings, .. } = self;
        Recording { steps, guards, settings, parameters }
    }
}

impl Guard {
    fn holds(self, of: &impl Fn(Constant) -> f64) -> bool {
        match self {
            Self::Above(a, b) => of(a) > of(b),
            Self::NotBelow(a, b) => of(a) >= of(b),
            Self::Differ(a, b) => of(a) != of(b),
            Self::Pinned(a) => of(a).to_bits() == a.value.to_bits(),
        }
    }
}

impl Recording {
    /// True if settings of the solution depend on what varies.
    pub fn has_settings(&self) -> bool {
        !self.settings.is_empty()
    }

    /// Writes what a reading with these values of the varied parameters, SI, would give: the values
    /// of all parameters, and the settings. False when only a reading of its own can decide: the values
    /// may be refused, or the model be another one.
    ///
    /// # Panics
    /// When `varied` or `parameters` have another length than what was recorded.
    pub fn replay(
        &self,
        varied: &[f64],
        values: &mut Vec<f64>,
        parameters: &mut [f64],
        solve: &mut SolveOptions,
    ) -> bool {
        assert_eq!(parameters.len(), self.parameters.len(), "number of parameters");
        values.clear();
        for step in &self.steps {
            let value = step.value(|constant| constant.among(values), varied);
            // The reader refuses every part that is no finite number.
            if !value.is_finite() {
                return false;
            }
            values.push(value);
        }
        let of = |constant: Constant| constant.among(values);
        if !self.guards.iter().all(|guard| guard.holds(&of)) {
            return false;
        }
        for (parameter, &constant) in parameters.iter_mut().zip(&self.parameters) {
            *parameter = of(constant);
        }
        for &(setting, constant) in &self.settings {
            let value = of(constant);
            match setting {
                Setting::Start => solve.t_start = value,
                Setting::End => solve.t_end = value,
                Setting::Every => solve.every = Some(value),
                Setting::Step => solve.step = Some(value),
            }
        }
        true
    }
}
