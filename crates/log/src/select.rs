//! Choosing channels by name.

use crate::{Header, LogError, TopicId, header::dotted};

/// One exported signal.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Column {
    /// `topic.field`, such as `state.angle`.
    pub name: String,
    /// SI unit as text, may be empty.
    pub unit: String,
    /// The topic.
    pub topic: TopicId,
    /// Index of the signal among the fields of its topic.
    pub field_idx: usize,
}

/// Topics whose channels need not name them: `mu` for `outputs.mu`, where nothing else is called so.
pub const SHORT: [&str; 3] = ["outputs", "signals", "state"];

/// Signals in the order in which they are exported, each once.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Selection {
    columns: Vec<Column>,
}

impl Selection {
    /// Every signal of the log.
    pub fn all(header: &Header) -> Selection {
        Selection { columns: columns(header) }
    }

    /// The signals that the patterns name, in the order of the patterns.
    ///
    /// A pattern is a signal (`state.angle`), a topic or the beginning of topics (`state`,
    /// `/reactions`), or either with `*` for any text and `?` for any letter (`*.angle`).
    ///
    /// # Errors
    /// [`LogError::UnknownChannel`] for the first pattern that matches nothing.
    pub fn new(
        header: &Header,
        patterns: impl IntoIterator<Item = impl AsRef<str>>,
    ) -> Result<Selection, LogError> {
        let all = columns(header);
        let mut is_taken = vec![false; all.len()];
        let mut chosen = Vec::new();
        for pattern in patterns {
            let pattern = whole(&dotted(pattern.as_ref()), &all);
            let mut is_known = false;
            for (column, is_taken) in all.iter().zip(&mut is_taken) {
                if matches(&pattern, &column.name) {
                    is_known = true;
                    if !std::mem::replace(is_taken, true) {
                        chosen.push(column.clone());
                    }
                }
            }
            if !is_known {
                return Err(unknown(&pattern, header, &all));
            }
        }
        Ok(Selection { columns: chosen })
    }

    /// The signals.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }
}

/// A pattern with the topic that it need not name.
fn whole(pattern: &str, all: &[Column]) -> String {
    let fits = |pattern: &str| all.iter().any(|column| matches(pattern, &column.name));
    if fits(pattern) {
        return pattern.to_owned();
    }
    let longer = SHORT.iter().map(|topic| format!("{topic}.{pattern}"));
    let mut longer = longer.filter(|longer| all.iter().any(|column| column.name == *longer));
    longer.next().unwrap_or_else(|| pattern.to_owned())
}

fn columns(header: &Header) -> Vec<Column> {
    let topics = header.topics_with_ids();
    let of_topic = |(id, topic): (TopicId, &'_ crate::Topic)| {
        let column = |(field_idx, field): (usize, &crate::Field)| Column {
            name: topic.column_name(field),
            unit: field.unit.clone(),
            topic: id,
            field_idx,
        };
        topic.fields.iter().enumerate().map(column).collect::<Vec<_>>()
    };
    topics.flat_map(of_topic).collect()
}

/// Whether the pattern matches the name, or the name up to one of its dots.
fn matches(pattern: &str, name: &str) -> bool {
    let ends = name.match_indices('.').map(|(end, _)| end).chain([name.len()]);
    ends.into_iter().any(|end| glob(pattern, &name[..end]))
}

/// True if a pattern matches a whole name: `*` stands for any text, `?` for any letter.
///
/// Greedy matching that goes back to the last star only, so that it never recurses.
pub fn glob(pattern: &str, name: &str) -> bool {
    let (pattern, name) = (pattern.as_bytes(), name.as_bytes());
    let (mut p, mut n) = (0, 0);
    // Positions after the last star, in the pattern and in the name it has swallowed so far.
    let mut star = None;
    while n < name.len() {
        match pattern.get(p) {
            Some(b'*') => {
                star = Some((p + 1, n));
                p += 1;
            }
            Some(&letter) if letter == b'?' || letter == name[n] => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((after_star, swallowed)) = star else { return false };
                star = Some((after_star, swallowed + 1));
                (p, n) = (after_star, swallowed + 1);
            }
        }
    }
    pattern[p..].iter().all(|&letter| letter == b'*')
}

fn unknown(pattern: &str, header: &Header, all: &[Column]) -> LogError {
    /// Below this likeness a suggestion confuses more than it helps.
    const LIKENESS: f64 = 0.7;
    const N_SUGGESTIONS: usize = 3;
    let topics = header.topics.iter().map(|topic| dotted(&topic.name));
    let names = topics.chain(all.iter().map(|column| column.name.clone()));
    let names: Vec<String> = names.collect();
    let by = |likeness: &dyn Fn(&str) -> f64, least: f64| -> Vec<(f64, String)> {
        let rated = names.iter().map(|name| (likeness(name), name.clone()));
        rated.filter(|(likeness, _)| *likeness >= least).collect()
    };
    let mut close = by(&|name| strsim::jaro_winkler(pattern, name), LIKENESS);
    if close.is_empty() {
        // Nothing is spelled alike: what has most of the names in it, `drives.motor` for `motor.torque`.
        let n_shared = |name: &str| {
            let parts = pattern.split('.');
            parts.filter(|part| name.split('.').any(|own| own == *part)).count() as f64
        };
        close = by(&n_shared, 1.0);
    }
    close.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let close = close.into_iter().map(|(_, name)| name).take(N_SUGGESTIONS).collect();
    LogError::UnknownChannel { name: pattern.into(), close }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Field, Topic};

    fn select(patterns: &[&str]) -> Result<Vec<String>, LogError> {
        let mut header = Header::new("", "toml", "", "");
        let fields = |names: [&str; 2]| names.map(|name| Field::new(name, "", ""));
        header.add_topic(Topic::new("/state", fields(["a_angle", "b_angle"])));
        header.add_topic(Topic::new("/reactions/a", fields(["fx", "fy"])));
        header.add_topic(Topic::new("/reactions/b", fields(["fx", "fy"])));
        let selection = Selection::new(&header, patterns)?;
        Ok(selection.columns().iter().map(|column| column.name.clone()).collect())
    }

    #[track_caller]
    fn check(patterns: &[&str], expected: &[&str]) {
        assert_eq!(select(patterns).expect("known names"), expected);
    }

    #[test]
    fn patterns_name_signals_topics_and_groups() {
        check(&["state.b_angle"], &["state.b_angle"]);
        check(&["/reactions/b"], &["reactions.b.fx", "reactions.b.fy"]);
        check(
            &["reactions.*.fy", "state.?_angle"],
            &["reactions.a.fy", "reactions.b.fy", "state.a_angle", "state.b_angle"],
        );
        check(
            &["reactions.a.fx", "reactions"],
            &["reactions.a.fx", "reactions.a.fy", "reactions.b.fx", "reactions.b.fy"],
        );
        check(&["*a*b*"], &["state.b_angle", "reactions.b.fx", "reactions.b.fy"]);
    }

    #[test]
    fn an_unknown_name_meets_its_neighbours() {
        let error = select(&["state.a_agnle"]).expect_err("misspelt").to_string();
        assert_eq!(
            error,
            "no channel matches `state.a_agnle`, did you mean `state.a_angle`, `state.b_angle`, `state`"
        );
        let error = select(&["b.torque"]).expect_err("no such channel").to_string();
        assert!(error.contains("did you mean `reactions.b`, `reactions.b.fx`"), "{error}");
        assert_eq!(select(&["qqq"]).expect_err("strange").to_string(), "no channel matches `qqq`");
    }
}
