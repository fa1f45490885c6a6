//! Answers of questions of design in words.

use bksim::model::file::ShownUnits;
use bksim::model::message::counted;
use bksim::model::{Measure, Model};
use bksim::report::number;
use bksim_cli::output;
use bksim_design::{Candidate, Cheapest, Fit, Optimized, Synthesis, Tolerance};

/// Rows with a head, columns two spaces apart.
fn table(head: &[&str], rows: Vec<Vec<String>>) -> String {
    let head = head.iter().map(|&cell| cell.to_owned()).collect();
    output::table(&std::iter::once(head).chain(rows).collect::<Vec<_>>())
}

/// Answers in the units that are asked for.
pub(super) struct Words<'a> {
    pub(super) name: &'a str,
    pub(super) model: &'a Model,
    pub(super) units: &'a ShownUnits,
}

impl Words<'_> {
    fn in_unit(&self, value: f64, unit: &str) -> String {
        let own = self.units.of(unit);
        let value = number(own.of_si(value));
        if own.unit.is_empty() { value } else { format!("{value} {}", own.unit) }
    }

    /// A derivative, which is by one unit of SI.
    fn slope(&self, value: f64, by: &str) -> f64 {
        value / self.units.of(by).of_si(1.0)
    }

    fn per(&self, worth: f64, of: &str, by: &str) -> String {
        if worth == 0.0 {
            return String::new();
        }
        let worth = self.in_unit(self.slope(worth, by), of);
        let by = self.units.of(by).unit;
        format!("{worth} per {}", if by.is_empty() { "1" } else { &by })
    }

    /// A position, angles and lengths with their units.
    fn position(&self, (name, value): (&String, &f64)) -> String {
        let unit = Measure::named(self.model, name).map_or("", |m| m.fixed_unit(self.model));
        format!("{name} = {}", self.in_unit(*value, unit))
    }
}

pub(super) fn optimized(words: &Words<'_>, found: &Optimized) -> String {
    let name = words.name;
    let before =
        found.before.map_or("nothing".to_owned(), |before| words.in_unit(before, &found.unit));
    let quantities = found
        .quantities
        .iter()
        .map(|q| {
            vec![
                q.name.clone(),
                words.in_unit(q.before, &q.unit),
                words.in_unit(q.after, &q.unit),
                q.at_bound.clone().unwrap_or_default().into_owned(),
                words.per(q.worth, &found.unit, &q.unit),
            ]
        })
        .collect();
    let conditions: Vec<Vec<String>> = found
        .conditions
        .iter()
        .map(|c| {
            vec![
                c.condition.clone(),
                words.in_unit(c.after, &c.unit),
                if c.is_active { "active" } else { "" }.to_owned(),
                words.per(c.worth, &found.unit, &c.unit),
            ]
        })
        .collect();
    let conditions = if conditions.is_empty() {
        String::new()
    } else {
        format!(
            "\n\n{}",
            table(&["condition", "left less right", "", "worth of the right side"], conditions)
        )
    };
    let chosen = choices(words, found) + &front(words, found);
    let [followed, same] = found.starts;
    let how = match (found.stopped, found.converged) {
        (true, _) => "stopped: the best so far",
        (_, true) => "a minimum by its slopes",
        (..) => "not settled: slopes do not vanish, as where a number has a kink",
    };
    format!(
        "{name}: {} {}\n  from {before} to {}\n\n{}{conditions}{chosen}\n\n  {how}; {same} of {followed} starts ended here; {} evaluations, slopes by {}",
        found.goal,
        found.objective,
        words.in_unit(found.after, &found.unit),
        table(&["quantity", "before", "after", "at bound", "worth of the bound"], quantities),
        found.evaluations,
        found.slopes,
    )
}

/// Rows of catalogues that are shown.
const MOST_CHOICES: usize = 12;

/// The best combinations of rows.
fn choices(words: &Words<'_>, found: &Optimized) -> String {
    let Some(first) = found.choices.first() else { return String::new() };
    let heads: Vec<&str> =
        first.rows.keys().map(String::as_str).chain([found.objective.as_str()]).collect();
    let row = |choice: &bksim_design::Choice| {
        let after = choice.after.map(|after| words.in_unit(after, &found.unit));
        let after = after.or(choice.why_not.clone()).unwrap_or_default();
        choice.rows.values().cloned().chain([after]).collect()
    };
    let rows = found.choices.iter().take(MOST_CHOICES).map(row).collect();
    let n_left = found.choices.len().saturating_sub(MOST_CHOICES);
    let more = if n_left > 0 { format!("\n  and {n_left} more") } else { String::new() };
    format!("\n\n{}{more}", table(&heads, rows))
}

/// The points of a front, its compromise marked.
fn front(words: &Words<'_>, found: &Optimized) -> String {
    let Some(front) = &found.front else { return String::new() };
    let names: Vec<&str> = found.quantities.iter().map(|q| q.name.as_str()).collect();
    let of_rows = front.points.first().map(|point| point.rows.keys().map(String::as_str));
    let heads: Vec<&str> = [found.objective.as_str(), front.against.as_str()]
        .into_iter()
        .chain(names.iter().copied())
        .chain(of_rows.into_iter().flatten())
        .chain([""])
        .collect();
    let row = |(k, point): (usize, &bksim_design::FrontPoint)| {
        let [a, b] = point.values;
        let values = [words.in_unit(a, &found.unit), words.in_unit(b, &front.unit)];
        let quantity = |q: &bksim_design::Optimum| {
            point.quantities.get(&q.name).map_or_else(String::new, |x| words.in_unit(*x, &q.unit))
        };
        let mark = if k == front.compromise { "compromise" } else { "" };
        let quantities = found.quantities.iter().map(quantity);
        let rows = point.rows.values().cloned();
        values.into_iter().chain(quantities).chain(rows).chain([mark.to_owned()]).collect()
    };
    let rows = front.points.iter().enumerate().map(row).collect();
    format!("\n\n{}", table(&heads, rows))
}

pub(super) fn fitted(words: &Words<'_>, found: &Fit) -> String {
    let name = words.name;
    let rows = found
        .unknowns
        .iter()
        .map(|u| {
            let error =
                u.standard_error.map_or("not found".to_owned(), |e| words.in_unit(e, &u.unit));
            vec![u.name.clone(), words.in_unit(u.estimate, &u.unit), error]
        })
        .collect();
    let mut notes = Vec::new();
    for name in &found.open.without_effect {
        notes.push(format!("  `{name}` has no effect on what is compared"));
    }
    for together in &found.open.unidentifiable_together {
        let names: Vec<String> = together.iter().map(|name| format!("`{name}`")).collect();
        notes.push(format!(
            "  the data cannot tell {} apart: give one of them a value",
            names.join(", ")
        ));
    }
    for vector in &found.open.null_vectors {
        let parts: Vec<String> =
            vector.iter().map(|(name, part)| format!("{name} {}", number(*part))).collect();
        notes.push(format!("  a change that nothing shows: {}", parts.join(", ")));
    }
    let n = found.unknowns.len();
    for i in 0..n {
        for j in i + 1..n {
            let r = found.correlation[i][j];
            if r.abs() > 0.95 {
                let (a, b) = (&found.unknowns[i].name, &found.unknowns[j].name);
                notes.push(format!(
                    "  `{a}` and `{b}` are correlated, {}",
                    number((r * 1e4).round() / 1e4)
                ));
            }
        }
    }
    let notes = if notes.is_empty() { String::new() } else { format!("\n\n{}", notes.join("\n")) };
    let sigma = if found.sigma_known { "given" } else { "estimated from the differences" };
    let how = match (found.stopped, found.converged) {
        (true, _) => "stopped: the best so far",
        (_, true) => "converged",
        (..) => "not converged",
    };
    format!(
        "{name}: {} unknowns from {} values\n\n{}{notes}\n\n  {how} after {} iterations, slopes {}; standard deviations {sigma}; sum of squares per degree of freedom {}",
        n,
        found.n_values,
        table(&["unknown", "estimate", "standard error"], rows),
        found.iterations,
        found.slopes,
        number(found.s2),
    )
}

pub(super) fn toleranced(words: &Words<'_>, found: &Tolerance) -> String {
    let name = words.name;
    let mut parts = vec![format!("{name}: {} samples of each pose", found.samples)];
    parts.extend(found.cheapest.as_ref().map(|of| cheapest(words, found, of)));
    for pose in &found.poses {
        let at: Vec<String> = pose.at.iter().map(|at| words.position(at)).collect();
        let at = if at.is_empty() { "the start".to_owned() } else { at.join(", ") };
        let assembles = match pose.assembles {
            Some(true) => "all parts assemble (proved)".to_owned(),
            Some(false) => format!(
                "within the limits some parts do not assemble: {} ± {} % of the samples",
                number(100.0 * pose.share_without_assembly[0]),
                number(100.0 * pose.share_without_assembly[1])
            ),
            None => "all samples assemble".to_owned(),
        };
        parts.push(match &pose.over {
            Some(over) => format!("Over {over}: {assembles}"),
            None => format!("At {at}: {assembles}"),
        });
        for band in &pose.bands {
            let of = |x: f64| words.in_unit(x, &band.unit);
            let shown = words.units.of(&band.unit);
            let bare = |x: f64| number(shown.of_si(x));
            let proved = if band.proved { "proved" } else { "searched" };
            let rows = vec![
                vec!["nominal".to_owned(), of(band.nominal)],
                vec![
                    format!("least to largest ({proved})"),
                    format!("{} to {}", of(band.exact_interval[0]), of(band.exact_interval[1])),
                ],
                vec![
                    "by slopes alone".to_owned(),
                    format!("{} to {}", of(band.linear_interval[0]), of(band.linear_interval[1])),
                ],
                vec!["root of squares".to_owned(), format!("± {}", of(band.rss))],
                vec![
                    "mean of the samples".to_owned(),
                    format!("{} ± {}", of(band.mean[0]), bare(band.mean[1])),
                ],
                vec![
                    "standard deviation".to_owned(),
                    format!("{} ± {}", of(band.sigma[0]), bare(band.sigma[1])),
                ],
            ];
            let contributors = band
                .contributors
                .iter()
                .map(|c| {
                    let unit = words.units.of(&c.unit);
                    let [least, most] = c.limits.map(|limit| number(unit.of_si(limit)));
                    vec![
                        c.name.clone(),
                        format!("{least} to {most} {}", unit.unit),
                        bare(words.slope(c.sensitivity, &c.unit)),
                        number((c.percent_of_worst * 1e4).round() / 1e4),
                        number((c.percent_of_variance * 1e4).round() / 1e4),
                    ]
                })
                .collect();
            let warning = if band.linear_fails {
                "\n  slopes do not describe this band: use the least and largest value"
            } else {
                ""
            };
            parts.push(format!(
                "{}\n{}{warning}\n{}",
                band.of,
                table(&[], rows).trim_start_matches('\n'),
                table(&["part", "limits", "slope", "% of worst", "% of variance"], contributors)
            ));
        }
    }
    if found.stopped {
        parts.push("stopped before all was done".to_owned());
    }
    parts.join("\n\n")
}

/// The cheapest limits and what they keep.
fn cheapest(words: &Words<'_>, all: &Tolerance, found: &Cheapest) -> String {
    let part = |part: &bksim_design::CheapestPart| {
        vec![
            part.name.clone(),
            format!("± {}", words.in_unit(part.before, &part.unit)),
            format!("± {}", words.in_unit(part.after, &part.unit)),
            number(part.weight),
            number(part.weight / part.after),
        ]
    };
    let how = if found.by == "worst" { "worst case" } else { "root of squares" };
    let bands = all.poses.iter().flat_map(|pose| &pose.bands);
    let kept = found.kept.iter().map(|kept| {
        let unit = bands.clone().find(|band| band.of == kept.of).map_or("", |band| &band.unit);
        let [limit, reached] = [kept.limit, kept.reached].map(|x| words.in_unit(x, unit));
        format!("\n  `{}` keeps ± {limit}: {how} ± {reached}", kept.of)
    });
    format!(
        "The cheapest limits, by the {how}\n{}\n{}\n  cost {}, before {}",
        table(
            &["part", "before", "cheapest", "weight", "cost"],
            found.parts.iter().map(part).collect()
        ),
        kept.collect::<String>(),
        number(found.cost),
        number(found.cost_before)
    )
}

/// Linkages that are printed with all their numbers; of more, some have a row each.
const FEW: usize = 8;

/// The first linkages of many, a row each.
fn listed(all: &[Candidate]) -> String {
    const ROWS: usize = 20;
    let lengths = ["crank", "coupler", "rocker", "ground"];
    let checks: Vec<&String> = all.first().map_or_else(Vec::new, |c| c.checks.keys().collect());
    let yes = |holds: bool| if holds { "yes" } else { "no" }.to_owned();
    let row = |c: &Candidate| {
        let length =
            |name: &&str| c.numbers.get(*name).map_or_else(String::new, |x| format!("{x:.4}"));
        let facts = checks.iter().map(|name| yes(c.checks.get(*name) == Some(&true)));
        let kind = c.kind.clone().unwrap_or_default();
        [c.name.clone(), kind].into_iter().chain(lengths.iter().map(length)).chain(facts).collect()
    };
    let head: Vec<&str> = ["", "type"]
        .into_iter()
        .chain(lengths)
        .chain(checks.iter().map(|name| name.as_str()))
        .collect();
    let rows = table(&head, all.iter().take(ROWS).map(row).collect());
    match all.len().saturating_sub(ROWS) {
        0 => rows,
        rest => format!("{rows}\n\n  and {rest} more, which `--json` and `-o FOLDER` have"),
    }
}

pub(super) fn synthesized(found: &Synthesis) -> String {
    let mut parts =
        vec![format!("{}: {}", found.task, counted(found.candidates.len(), "linkage", "linkages"))];
    let facts: Vec<Vec<String>> = found
        .facts
        .iter()
        .map(|(name, values)| {
            let values: Vec<String> = values.iter().map(|value| number(*value)).collect();
            vec![name.clone(), values.join(", ")]
        })
        .collect();
    if !facts.is_empty() {
        parts.push(table(&[], facts).trim_start_matches('\n').to_owned());
    }
    if found.candidates.len() > FEW {
        parts.push(listed(&found.candidates));
        return parts.join("\n\n");
    }
    for candidate in &found.candidates {
        let numbers =
            candidate.numbers.iter().map(|(name, value)| vec![name.clone(), number(*value)]);
        let checks = candidate
            .checks
            .iter()
            .map(|(name, holds)| vec![name.clone(), if *holds { "yes" } else { "no" }.to_owned()]);
        let kind = candidate.kind.as_ref().map(|kind| vec!["type".to_owned(), kind.clone()]);
        let rows = numbers.chain(checks).chain(kind).collect();
        parts.push(format!("{}\n{}", candidate.name, table(&[], rows).trim_start_matches('\n')));
    }
    parts.join("\n\n")
}
