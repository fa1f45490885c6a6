//! A run with its data, ready to be compared.

use std::f64::consts::TAU;

use bksim::expr::{Expr, SymbolId, Tape};
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{code, suggest};
use bksim::model::{Measure, Model};
use bksim::report::number;

use super::{Compared, EXAMPLE, FitWish, Kind, Run, names_in, value_of};
use crate::base::{Source, Stated};
use crate::codes;
use crate::data::{Columns, DataFile, columns};
use crate::error::DesignError;
use crate::formula::formula;
use crate::poses::Poses;
use crate::spec::located;

/// Warnings of columns that are angles, go beyond a turn as degrees do, and are radians as they have no unit.
fn like_degrees(file: &str, columns: &Columns, wish: &FitWish, model: &Model) -> Vec<Diagnostic> {
    let compared = wish.compare.iter().map(|(column, formula)| (column, formula));
    let driven = wish.drive.iter().map(|(measure, column)| (column, measure));
    let mut all = Vec::new();
    for (column, formula) in compared.chain(driven) {
        let Some(at) = columns.named(column).filter(|&at| columns.units[at].is_none()) else {
            continue;
        };
        if !turns(formula, model) {
            continue;
        }
        let values = columns.rows.iter().map(|row| row[at].abs());
        let most = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
        if most > TAU {
            let shown = number(most);
            let message = format!(
                "`{column}` of `{file}` goes as far as {shown} rad = {:.1} turns",
                most / TAU
            );
            let help = format!(
                "write the unit in the heading, `{column} [deg]`, or `{column} [rad]` if it is right"
            );
            all.push(Diagnostic::warning(code::LOOKS_LIKE_DEGREES, message).help(help));
        }
    }
    all
}

/// True where all that a formula measures is angles.
fn turns(text: &str, model: &Model) -> bool {
    let mut measured = names_in(text).into_iter().filter_map(|name| Measure::named(model, &name));
    measured.next().is_some_and(|m| m.unit(model) == "rad")
        && measured.all(|m| m.unit(model) == "rad")
}

/// A run ready to be compared.
pub(super) fn run(
    source: &Source,
    file: &DataFile,
    wish: &FitWish,
    varied: &[Stated],
    unknowns: &[String],
) -> Result<Run, DesignError> {
    let columns = columns(file)?;
    let is_geometry = !wish.drive.is_empty();
    let column = |name: &str| {
        columns.named(name).ok_or_else(|| {
            let known: Vec<&str> = columns.names.iter().map(String::as_str).collect();
            let message = format!("`{}` has no column `{name}`", file.name);
            let fault = DesignError::fault(codes::BAD_DATA, message, suggest(name, &known));
            located(fault, &source.text, name)
        })
    };
    let mut compared = Vec::new();
    for (k, (name, _)) in wish.compare.iter().enumerate() {
        let at = column(name)?;
        let sigma = wish.sigma.iter().find(|(of, _)| of == name);
        let sigma = sigma.map_or(Ok(1.0), |(_, text)| value_of(text, source))?;
        if sigma <= 0.0 {
            let message = format!("the standard deviation of `{name}` is not above zero");
            return Err(DesignError::fault(codes::BAD_QUESTION, message, "give one above zero"));
        }
        for (row, values) in columns.rows.iter().enumerate() {
            if values[at].is_finite() {
                compared.push(Compared { row, formula: k, measured: values[at], sigma });
            }
        }
    }

    // Names of the motion: whatever is no column, unknown or parameter.
    let model = source.model(&[], is_geometry)?;
    let is_compared = |name: &str| wish.compare.iter().any(|(column, _)| column == name);
    let is_own = |name: &String| {
        // In what it is compared with, the name of a column is that of the motion: as in an exported log.
        (columns.named(name).is_some() && !is_compared(name))
            || unknowns.contains(name)
            || name == "pi"
            || model.parameters.iter().any(|p| p.name == *name)
    };
    let mut quantities: Vec<String> = Vec::new();
    for (_, text) in &wish.compare {
        quantities.extend(names_in(text).into_iter().filter(|name| !is_own(name)));
    }
    quantities.sort();
    quantities.dedup();
    let in_motion = !quantities.is_empty() && !is_geometry;

    // The motion at the instants of the rows, or on a grid.
    let t_column = ["t", "time"].iter().find_map(|name| columns.named(name));
    let mut times = Vec::new();
    let mut grid = None;
    let mut outputs = Vec::new();
    let mut late = Vec::new();
    let mut source = source.clone();
    if in_motion {
        let Some(t) = t_column else { return Err(column("t").expect_err("there is none")) };
        times = columns.rows.iter().map(|row| row[t]).collect();
        if let Some(row) = times.iter().position(|t| !t.is_finite()) {
            let message = format!("row {} of `{}` has no time", row + 1, file.name);
            return Err(DesignError::fault(codes::BAD_DATA, message, "leave the row out"));
        }
        let t_end = times.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        if t_end > model.solve.t_end {
            source.changes.t_end = Some(t_end);
        }
        late = wish
            .compare
            .iter()
            .map(|(name, _)| {
                let of = wish.delay.iter().find(|(of, _)| of == name)?;
                unknowns.iter().position(|unknown| *unknown == of.1)
            })
            .collect();
        let instants = if late.iter().any(Option::is_some) {
            let n = (8 * times.len()).clamp(400, 4000);
            let t_start = model.solve.t_start;
            let t_end = source.changes.t_end.unwrap_or(model.solve.t_end);
            let step = (t_end - t_start) / n as f64;
            grid = Some([t_start, step]);
            (0..=n).map(|k| if k == n { t_end } else { t_start + step * k as f64 }).collect()
        } else {
            times.clone()
        };
        for quantity in &quantities {
            outputs.extend(instants.iter().map(|t| format!("{quantity}@{t}")));
        }
    }
    if outputs.is_empty() {
        outputs.push("0".to_owned());
    }
    let study = source.study(varied, &file.set, &outputs, is_geometry || !in_motion)?;

    // Formulas as functions.
    let mechanism = study.mechanism();
    let (model, pool) = (&mechanism.model, &mechanism.model.pool);
    let symbol = |name: &String| (name.clone(), pool.symbol(&format!("data {name}")));
    let mut own: Vec<(String, Expr)> = columns.names.iter().map(symbol).collect();
    own.extend(unknowns.iter().map(symbol));
    let of_motion = |name: &String| (name.clone(), pool.symbol(&format!("motion {name}")));
    let of_motion: Vec<(String, Expr)> = quantities.iter().map(of_motion).collect();
    let with_motion = [own.clone(), of_motion].concat();
    let id = |(_, expr): &(String, Expr)| pool.symbol_id(*expr).expect("a symbol");
    let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let read = |all: &[(String, String)], own: &[(String, Expr)]| {
        let one = |(_, text): &(String, String)| {
            let system = is_geometry.then_some(&mechanism.system);
            formula(text, model, system, own).map_err(|fault| located(fault, &source.text, text))
        };
        all.iter().map(one).collect::<Result<Vec<_>, _>>()
    };
    let names = if in_motion { &with_motion } else { &own };
    let first_of_motion = own.len();
    let is_seen =
        |(k, (name, _)): &(usize, &(String, Expr))| *k >= first_of_motion || !is_compared(name);
    let seen: Vec<(String, Expr)> =
        names.iter().enumerate().filter(is_seen).map(|(_, one)| one.clone()).collect();
    let formulas: Vec<Expr> = read(&wish.compare, &seen)?.into_iter().map(|f| f.expr).collect();
    let compile = |formulas: &[Expr], inputs: &[SymbolId]| {
        let jacobian = pool.jacobian(formulas, inputs);
        let entries = jacobian.entries.iter().map(|entry| entry.2);
        let all: Vec<Expr> = formulas.iter().copied().chain(entries).collect();
        let tape = Tape::compile(pool, &all, inputs, &[])
            .map_err(|error| DesignError::fault(codes::BAD_QUESTION, error.to_string(), EXAMPLE))?;
        Ok::<_, DesignError>((
            tape,
            jacobian.entries.iter().map(|&(r, c, _)| (r, c)).collect::<Vec<_>>(),
        ))
    };
    let own_ids: Vec<SymbolId> = own.iter().map(id).collect();
    let (tape, slopes_by, kind) = if is_geometry {
        let mut prescribed = Vec::new();
        for (name, _) in &wish.drive {
            let measure =
                Measure::named(model, name).filter(|m| !m.is_velocity()).ok_or_else(|| {
                    let known: Vec<String> =
                        model.joints.iter().map(|j| format!("{}.angle", j.name)).collect();
                    let known: Vec<&str> = known.iter().map(String::as_str).collect();
                    let message = format!("the model has no position `{name}` to drive");
                    located(
                        DesignError::fault(codes::UNKNOWN_QUANTITY, message, suggest(name, &known)),
                        &source.text,
                        name,
                    )
                })?;
            prescribed.push((name.clone(), measure));
        }
        let targets: Vec<Expr> = read(&wish.drive, &own)?.into_iter().map(|f| f.expr).collect();
        let poses = Poses::new(&mechanism, &prescribed, &formulas, &own_ids)?;
        let inputs = [&own_ids[..], &parameters].concat();
        let (drives, drive_slopes) = compile(&targets, &inputs)?;
        let is_turn = wish.compare.iter().map(|(_, text)| turns(text, model)).collect();
        let (tape, slopes_by) = compile(&[], &[])?;
        (tape, slopes_by, Kind::Positions { poses: Box::new(poses), drives, drive_slopes, is_turn })
    } else {
        let ids: Vec<SymbolId> = names.iter().map(id).collect();
        let (tape, slopes_by) = compile(&formulas, &[&ids[..], &parameters].concat())?;
        let kind = if in_motion {
            Kind::Motion { n_quantities: quantities.len(), times, grid, late }
        } else {
            Kind::Formulas
        };
        (tape, slopes_by, kind)
    };
    Ok(Run {
        warnings: like_degrees(&file.name, &columns, wish, model),
        file: file.name.clone(),
        columns,
        study,
        compared,
        tape,
        slopes_by,
        n_formulas: formulas.len(),
        kind,
    })
}
