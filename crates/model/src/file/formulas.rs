//! Formulas that are read with a model but are no part of its text.

use super::Formula;
use super::reader::Reader;
use super::tree::Quoted;
use super::units::Quantity;
use super::value::Scope;
use crate::diagnostic::Diagnostic;

impl Reader<'_> {
    /// Reads the formulas. Their faults come without positions: the text of the model is another one.
    pub(super) fn read_formulas(&mut self) {
        let own = std::mem::take(&mut self.faults);
        for formula in self.formulas {
            self.formula_of_time(formula);
        }
        let found = std::mem::replace(&mut self.faults, own);
        let without_place = |fault: Diagnostic| Diagnostic { labels: Vec::new(), ..fault };
        self.faults.extend(found.into_iter().map(without_place));
    }

    fn formula_of_time(&mut self, &Formula { what, text, unit }: &Formula<'_>) {
        let quantity = match unit {
            "rad" => Quantity::ANGLE,
            "m" => Quantity::LENGTH,
            _ => Quantity::NUMBER,
        };
        // No position of the model's text is meant: the last one has none after it.
        let end = self.text.len();
        let quoted = Quoted { text, whole: end..end, start: None };
        let Some(syntax) = self.parse(&quoted, what, quantity.example) else { return };
        let Some(lowered) = self.lower(&syntax, &quoted, what, Scope::Time) else { return };
        if let Some((expr, _)) = self.accept(&lowered, quantity, what) {
            self.found.push(expr);
        }
    }
}
