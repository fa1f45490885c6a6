//! Function expressions of Adams as those of a model: pure numbers of the file's units.

use crate::draft::number;

/// Meaning of a function of markers in a model: `DM(1,2)` as an expression without unit; `None` of one without.
pub(super) type Measures<'m> = dyn Fn(&str, &[u64]) -> Option<String> + 'm;

/// Functions that both languages have, with their names here.
const SAME: [(&str, &str); 13] = [
    ("SIN", "sin"),
    ("COS", "cos"),
    ("TAN", "tan"),
    ("ASIN", "asin"),
    ("ACOS", "acos"),
    ("ATAN", "atan"),
    ("ATAN2", "atan2"),
    ("EXP", "exp"),
    ("LOG", "log"),
    ("SQRT", "sqrt"),
    ("ABS", "abs"),
    ("MIN", "min"),
    ("MAX", "max"),
];

/// Deepest nesting of parentheses.
const MAX_DEPTH: usize = 60;

struct Reader<'t, 'm> {
    rest: &'t str,
    /// The time in the file's unit.
    time: &'t str,
    measures: &'t Measures<'m>,
    depth: usize,
}

/// The expression in the words of a model; `None` where it has something else.
pub(super) fn translated(text: &str, time: &str, measures: &Measures<'_>) -> Option<String> {
    let clean: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let mut reader = Reader { rest: &clean, time, measures, depth: 0 };
    let sum = reader.sum()?;
    reader.rest.is_empty().then_some(sum)
}

impl Reader<'_, '_> {
    fn take(&mut self, c: char) -> bool {
        match self.rest.strip_prefix(c) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn sum(&mut self) -> Option<String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return None;
        }
        let mut out = String::new();
        let mut sign = if self.take('-') { "-" } else { "" };
        self.take('+');
        loop {
            let product = self.product()?;
            out = match (out.is_empty(), sign) {
                (true, sign) => format!("{sign}{product}"),
                (false, sign) => format!("{out} {sign} {product}"),
            };
            sign = match () {
                () if self.take('+') => "+",
                () if self.take('-') => "-",
                () => break,
            };
        }
        self.depth -= 1;
        Some(out)
    }

    fn product(&mut self) -> Option<String> {
        let mut out = self.factor()?;
        loop {
            if self.rest.starts_with("**") {
                self.rest = &self.rest[2..];
                out = format!("{out}^{}", self.factor()?);
            } else if self.take('*') {
                out = format!("{out}*{}", self.factor()?);
            } else if self.take('/') {
                out = format!("{out}/{}", self.factor()?);
            } else {
                return Some(out);
            }
        }
    }

    fn factor(&mut self) -> Option<String> {
        if self.take('(') {
            let inner = self.sum()?;
            return self.take(')').then(|| format!("({inner})"));
        }
        if self.take('-') {
            return Some(format!("(-{})", self.factor()?));
        }
        if self.rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return self.number();
        }
        let end = self
            .rest
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(self.rest.len());
        let word = self.rest[..end].to_ascii_uppercase();
        if word.is_empty() {
            return None;
        }
        self.rest = &self.rest[end..];
        match word.as_str() {
            "TIME" => return Some(self.time.to_owned()),
            "PI" => return Some("pi".to_owned()),
            "DTOR" => return Some("(pi/180)".to_owned()),
            "RTOD" => return Some("(180/pi)".to_owned()),
            _ => (),
        }
        self.take('(').then_some(())?;
        self.call(&word)
    }

    fn number(&mut self) -> Option<String> {
        let bytes = self.rest.as_bytes();
        let mut end = 0;
        while end < bytes.len() {
            let c = bytes[end];
            let is_sign =
                matches!(c, b'+' | b'-') && end > 0 && matches!(bytes[end - 1], b'e' | b'E');
            if c.is_ascii_digit()
                || c == b'.'
                || is_sign
                || matches!(c, b'e' | b'E')
                    && bytes
                        .get(end + 1)
                        .is_some_and(|n| n.is_ascii_digit() || matches!(n, b'+' | b'-'))
            {
                end += 1;
            } else {
                break;
            }
        }
        let value: f64 = self.rest[..end].parse().ok()?;
        self.rest = &self.rest[end..];
        let is_degrees = self.rest.starts_with(['D', 'd'])
            && !self.rest[1..].starts_with(|c: char| c.is_ascii_alphanumeric());
        if is_degrees {
            self.rest = &self.rest[1..];
            return Some(format!("({}*pi/180)", number(value)));
        }
        Some(number(value))
    }

    /// Arguments up to the closing parenthesis, divided by commas and colons.
    fn call(&mut self, word: &str) -> Option<String> {
        let mut arguments = Vec::new();
        loop {
            arguments.push(self.sum()?);
            if self.take(')') {
                break;
            }
            (self.take(',') || self.take(':')).then_some(())?;
        }
        if let Some((_, own)) = SAME.iter().find(|(known, _)| *known == word) {
            return Some(format!("{own}({})", arguments.join(", ")));
        }
        match (word, arguments.as_slice()) {
            ("STEP", [x, x0, h0, x1, h1]) => {
                Some(step(x, [x0, x1], [h0, h1], |s| format!("{s}^2*(3 - 2*{s})")))
            }
            ("STEP5", [x, x0, h0, x1, h1]) => {
                Some(step(x, [x0, x1], [h0, h1], |s| format!("{s}^3*(10 - 15*{s} + 6*{s}^2)")))
            }
            ("IF", [x, below, at, above]) => {
                Some(format!("if({x} < 0, {below}, if({x} > 0, {above}, {at}))"))
            }
            _ => {
                let ids: Option<Vec<u64>> = arguments.iter().map(|id| id.parse().ok()).collect();
                (self.measures)(word, &ids?)
            }
        }
    }
}

/// From h0 at x0 to h1 at x1 by a polynomial of the part of the way.
fn step(
    x: &str,
    [x0, x1]: [&String; 2],
    [h0, h1]: [&String; 2],
    law: impl Fn(&str) -> String,
) -> String {
    let part = format!("min(1, max(0, ({x} - ({x0}))/(({x1}) - ({x0}))))");
    format!("(({h0}) + (({h1}) - ({h0}))*{})", law(&part))
}

#[cfg(test)]
mod tests {
    use super::translated;

    #[test]
    fn functions_of_the_time_are_translated() {
        let read = |text: &str| translated(text, "(t/(1 s))", &|_, _| None);
        assert_eq!(read("30.0D * time").as_deref(), Some("(30*pi/180)*(t/(1 s))"));
        assert_eq!(read("-2*(TIME - 1.5E-1)**2").as_deref(), Some("-2*((t/(1 s)) - 0.15)^2"));
        assert_eq!(
            read("IF(TIME-1: 0, 0, 5)").as_deref(),
            Some("if((t/(1 s)) - 1 < 0, 0, if((t/(1 s)) - 1 > 0, 5, 0))")
        );
        assert_eq!(read("AKISPL(TIME, 0, 1)"), None);
        assert_eq!(read("2*("), None);
    }
}
