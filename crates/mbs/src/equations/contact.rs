//! Stops and friction as a person reads them: the law of each multiplier.

use bksim_expr::{Function, Printer};

use crate::contact::Law;
use crate::system::SymbolicSystem;
use bksim_model::Model;

/// One multiplier that follows a law of contact, its formulas in one notation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ContactText {
    /// Name of the load.
    pub name: String,
    /// The law in words.
    pub law: &'static str,
    /// Penetration of a stop, or the motion that friction acts on.
    pub quantity: String,
    /// The multiplier.
    pub multiplier: String,
    /// Restitution of a stop; friction while it slides and, where it differs, the largest while it
    /// sticks.
    pub limits: Vec<String>,
}

/// The laws of all stops and frictions, in the order of their multipliers.
pub fn contact_texts(
    model: &Model,
    system: &SymbolicSystem,
    printer: &Printer<'_>,
    multipliers: &[String],
) -> Vec<ContactText> {
    let pool = &model.pool;
    let text = |contact: &crate::contact::Contact| {
        let (law, quantity, limits) = match contact.law {
            Law::Stop { restitution, .. } => {
                let law = "stop: penetration <= 0, multiplier >= 0, one of them 0; restitution";
                (law, contact.expression, vec![restitution])
            }
            Law::Friction { sticking, other: Some(_), .. } => {
                let law = "friction in two directions: against the slip while it slides, and no greater in both together while it sticks";
                (law, contact.rate, vec![sticking])
            }
            Law::Friction { sliding, sticking, slip, .. } => {
                let law = "friction: against the rate while it slides, no greater while it sticks";
                let sense = pool.call(Function::Sign, &[contact.rate]);
                let sense: Vec<_> = sense.map(|sense| (slip, sense)).into_iter().collect();
                let mut limits = vec![pool.substitute(sliding, &sense), sticking];
                limits.dedup();
                // Friction of a contact has no position.
                let moving = if contact.joint.is_some() { contact.position } else { contact.rate };
                (law, moving, limits)
            }
        };
        ContactText {
            name: model.loads[contact.load.0].name.clone(),
            law,
            quantity: printer.expr(quantity),
            multiplier: multipliers.get(contact.row).cloned().unwrap_or_default(),
            limits: limits.into_iter().map(|limit| printer.expr(limit)).collect(),
        }
    };
    system.contacts.iter().map(text).collect()
}
