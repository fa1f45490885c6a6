//! Why a motion has no derivative, in the author's terms.

use bksim_expr::TapeError;

use super::Sensitive;
use crate::codes;
use bksim_model::Model;
use bksim_model::diagnostic::Diagnostic;

/// Why there are no sensitivities.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum SensitivityError {
    /// Neither a parameter nor an initial value has this name.
    Unknown(String),
    /// The initial value of this index is a guess.
    Guess(usize),
    /// A stop is closed at the start, and opens or is overrun where this quantity changes.
    Touching(Sensitive),
    /// The model has signals that are sampled.
    Sampled,
    /// The model has conditions on rates.
    Rates,
    /// The model has contacts.
    Contacts,
    /// The model has inputs.
    Inputs,
    /// The constraints and stated values hold for no other value of this quantity.
    NoNeighbour(Sensitive),
    /// A derivative has no finite value at the start.
    NotFinite(Sensitive),
    /// The derivatives could not be compiled.
    Compile(TapeError),
}

impl From<TapeError> for SensitivityError {
    fn from(error: TapeError) -> Self {
        Self::Compile(error)
    }
}

/// The diagnostic of sensitivities that do not exist.
pub fn diagnose_sensitivity(model: &Model, error: &SensitivityError) -> Diagnostic {
    let fault = |message: String| Diagnostic::error(codes::NO_SENSITIVITY, message);
    match error {
        SensitivityError::Unknown(name) => {
            let parameters = model.parameters.iter().map(|p| p.name.as_str());
            let stated = model.initial.iter().filter(|i| !i.is_guess).map(|i| i.name.as_str());
            let known: Vec<&str> = parameters.chain(stated).collect();
            fault(format!("there is no parameter or stated initial value `{name}`"))
                .help(format!("name one of: {}", known.join(", ")))
        }
        SensitivityError::Guess(k) => {
            let initial = &model.initial[*k];
            fault(format!("`{}` is a guess: the start need not obey it", initial.name))
                .at(initial.span.clone(), "guessed here")
                .help("state the value instead of guessing it, if the joints leave it free")
        }
        SensitivityError::Touching(by) => {
            let name = by.name(model);
            fault(format!("the motion starts on a stop, and off it for other values of `{name}`"))
                .help("start apart from the stop: on either side of it the motion is another one")
        }
        SensitivityError::Sampled => {
            fault("the model has signals that take values of the motion and hold them".to_owned())
                .help("let sampled signals follow the motion, without `clock`; let latched ones take constants")
        }
        SensitivityError::Rates => {
            fault("the model has conditions on rates, which leave positions free".to_owned())
                .help("compare runs at two values of the quantity, as `bksim sweep` does")
        }
        SensitivityError::Contacts => {
            let contact = model.contacts.first();
            let found = fault("the model has contacts: derivatives are not followed through them".to_owned())
                .help("compare runs at two values of the quantity, as `bksim sweep` does");
            match contact {
                Some(contact) => found.at(contact.span.clone(), "these outlines may touch"),
                None => found,
            }
        }
        SensitivityError::Inputs => {
            fault("the model has inputs: nothing is known of their derivatives".to_owned())
                .help("write what they do as expressions of the model")
        }
        SensitivityError::NoNeighbour(by) => {
            let name = by.name(model);
            fault(format!("no motion exists for any other value of `{name}` near this one"))
                .help("define quantities that must agree through one parameter, and name that one")
        }
        SensitivityError::NotFinite(by) => {
            let name = by.name(model);
            fault(format!("the derivative by `{name}` has no finite value at the start"))
                .help("start away from poses where a square root or a quotient has no derivative")
        }
        SensitivityError::Compile(error) => fault(error.to_string()),
    }
}
