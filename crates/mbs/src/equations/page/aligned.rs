//! Text for the terminal: signs in one column, what each line stands for in another.

use super::{Formula, Label, Line};
use crate::equations::arrange::Kind;

/// One formula in lines; signs and terms begin in the same columns for all labels up to `width`.
pub(super) fn aligned(formula: &Formula, width: usize) -> Vec<String> {
    let label = formula.label.plain();
    let columns = |text: &str| bksim_expr::Notation::columns(text);
    let pad = |text: &str, width: usize| {
        format!("{text}{}", " ".repeat(width.saturating_sub(columns(text))))
    };
    let written = |line: &Line| match line.formula.starts_with(['+', '−']) {
        true => line.formula.clone(),
        false if line.formula.starts_with("- ") => line.formula.clone(),
        false => format!("  {}", line.formula),
    };
    let mut sums: Vec<(String, Option<Kind>)> =
        formula.lines.iter().map(|line| (written(line), line.kind)).collect();
    match &formula.label {
        Label::Zero(_) => match sums.as_mut_slice() {
            [(sum, None)] => sum.push_str(" = 0"),
            _ => sums.push(("= 0".to_owned(), None)),
        },
        Label::Left(_) if !formula.remark.is_empty() => {
            if let Some(last) = sums.last_mut() {
                last.0.extend(["    (", &formula.remark, ")"]);
            }
        }
        Label::Left(_) => (),
    }
    let longest = sums.iter().filter(|s| s.1.is_some()).map(|s| columns(&s.0)).max().unwrap_or(0);
    let mut shown = None;
    let line = |(at, (sum, kind)): (usize, &(String, Option<Kind>))| {
        let label = if at == 0 { label.as_str() } else { "" };
        let remark = kind.filter(|kind| shown != Some(*kind)).map_or("", Kind::title);
        shown = kind.or(shown);
        let text = format!("  {} {}  {remark}", pad(label, width), pad(sum, longest));
        text.trim_end().to_owned()
    };
    sums.iter().enumerate().map(line).collect()
}
