//! Sine and cosine of an angle as operations of machine code: those of [`sincos`](crate::sincos), one by one.

use super::Extra;
use super::assembler::Opcode;
use super::program::{Kind, Program};
use crate::tape::Action;

impl Program {
    /// Writes down the sine and the cosine of an angle of at most [`LARGEST`](crate::sincos::LARGEST).
    pub(super) fn turn(&mut self, x: usize) -> [usize; 2] {
        // The angle less k π/2, and the rounding error of that.
        let scaled = self.times(x, self.extra(Extra::TwoOverPi));
        let rounded = self.plus(scaled, self.extra(Extra::Round));
        let k = self.minus(rounded, self.extra(Extra::Round));
        let part = self.times(k, self.extra(Extra::HalfPi0));
        let first = self.minus(x, part);
        let part = self.times(k, self.extra(Extra::HalfPi1));
        let second = self.minus(first, part);
        let left = self.minus(first, second);
        let left = self.minus(left, part);
        let part = self.times(k, self.extra(Extra::HalfPi2));
        let part = self.minus(part, left);
        let y = self.minus(second, part);
        let e = self.minus(second, y);
        let e = self.minus(part, e);

        // The polynomials.
        let rest = self.times(k, self.extra(Extra::RestOfHalfPi));
        let near = self.minus(first, rest);
        let y2 = self.times(near, near);
        let y4 = self.times(y2, y2);
        let (y3, y8) = (self.times(y2, near), self.times(y4, y4));
        let half = self.times(self.extra(Extra::Half), y2);
        let lead = self.minus(self.extra(Extra::One), half);
        let powers = [y2, y4, y8];
        let sine = self.polynomial(Extra::SINE, powers);
        let cosine = self.polynomial(Extra::COSINE, powers);
        let sine = self.times(y3, sine);
        let of_error = self.times(e, lead);
        let sine = self.minus(of_error, sine);
        let sine = self.minus(y, sine);
        let of_lead = self.minus(self.extra(Extra::One), lead);
        let of_lead = self.minus(of_lead, half);
        let cosine = self.times(y4, cosine);
        let of_error = self.times(y, e);
        let cosine = self.plus(cosine, of_error);
        let cosine = self.plus(of_lead, cosine);
        let cosine = self.plus(lead, cosine);

        // The quadrant is in the lowest bits: odd ones swap the two, the second bit of it and of the next one are signs.
        let odd = self.push(Kind::ShiftLeft(63), [rounded; 3]);
        let odd = self.push(Kind::Bits(Opcode::Or), [odd, self.extra(Extra::One), odd]);
        let [of_sine, of_cosine] = [[cosine, sine], [sine, cosine]]
            .map(|[swapped, plain]| self.push(Kind::IfNegative, [odd, swapped, plain]));
        let next = self.plus(rounded, self.extra(Extra::One));
        [(of_sine, rounded), (of_cosine, next)].map(|(value, quadrant)| {
            let sign = self.push(Kind::ShiftLeft(62), [quadrant; 3]);
            let sign =
                self.push(Kind::Bits(Opcode::And), [sign, self.extra(Extra::SignMask), sign]);
            self.push(Kind::Bits(Opcode::Xor), [value, sign, value])
        })
    }

    /// c₀ + c₁x + … + c₅x⁵ from x, x² and x⁴.
    fn polynomial(&mut self, c: [Extra; 6], [x, x2, x4]: [usize; 3]) -> usize {
        let [low, middle, high] = [0, 2, 4].map(|i| {
            let product = self.times(x, self.extra(c[i + 1]));
            self.plus(self.extra(c[i]), product)
        });
        let middle = self.times(x2, middle);
        let sum = self.plus(low, middle);
        let high = self.times(x4, high);
        self.plus(sum, high)
    }

    fn times(&mut self, a: usize, b: usize) -> usize {
        self.push(Kind::Action(Action::Multiply), [a, b, a])
    }

    fn plus(&mut self, a: usize, b: usize) -> usize {
        self.push(Kind::Action(Action::Add), [a, b, a])
    }

    fn minus(&mut self, a: usize, b: usize) -> usize {
        self.push(Kind::Action(Action::Subtract), [a, b, a])
    }
}
