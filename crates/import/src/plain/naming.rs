//! Names of bodies, joints and springs by the texts next to them.

use bksim_cad::geometry::vector::{between, distance};

use super::bodies::anchor;
use super::joint::{Kind, On};
use super::pieces::to_segment;
use super::{Found, Notes};
use crate::names::Names;

/// Names, in the order of what has them.
#[derive(Clone, Default, Debug)]
pub(super) struct Named {
    /// Texts of bodies.
    pub(super) labels: Vec<Option<String>>,
    pub(super) springs: Vec<String>,
    /// Masses in texts, kg, with the index of the text.
    pub(super) masses: Vec<(f64, usize)>,
    /// Letters of lone circles by pins.
    pub(super) letters: Vec<Option<String>>,
}

/// Gives everything a name.
pub(super) fn name(found: &mut Found, names: &mut Names) -> Named {
    let mut named = Named { masses: masses(found), ..Named::default() };
    let is_free = |notes: &Notes, idx: usize| !notes.taken[idx];
    let words: Vec<(usize, String)> = found
        .sheet
        .words
        .iter()
        .enumerate()
        .filter(|(idx, words)| is_free(&found.notes, *idx) && !words.text.contains(['=', ':']))
        .map(|(idx, words)| (idx, words.text.trim().to_owned()))
        .filter(|(_, text)| !text.is_empty() && text.chars().count() <= 40)
        .collect();
    let reach = 6.0 * found.pieces.pin;

    // Letters of points: the nearest pin, each once.
    let is_letter = |text: &str| {
        let first = text.chars().next().is_some_and(char::is_uppercase);
        first && text.chars().count() <= 3 && !text.chars().skip(1).any(char::is_lowercase)
    };
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (pin, it) in found.pins.iter().enumerate() {
        for (k, (idx, _)) in words.iter().enumerate().filter(|(_, (_, text))| is_letter(text)) {
            let away = distance(found.sheet.words[*idx].at, it.at);
            if away < 1.6 * reach {
                pairs.push((away, pin, k));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    named.letters = vec![None; found.pins.len()];
    let mut is_taken = vec![false; words.len()];
    for (_, pin, k) in pairs {
        if named.letters[pin].is_none() && !is_taken[k] {
            named.letters[pin] = Some(words[k].1.clone());
            is_taken[k] = true;
        }
    }

    // Springs, then bodies, by the nearest text.
    let mut nearest: Vec<(f64, bool, usize, usize)> = Vec::new();
    for (k, (idx, _)) in
        words.iter().enumerate().filter(|(k, (_, text))| !is_taken[*k] && !is_letter(text))
    {
        let words = &found.sheet.words[*idx];
        let at = [words.at[0], words.at[1] + 0.5 * words.height];
        for (spring, it) in found.springs.iter().enumerate() {
            nearest.push((to_segment(at, it.ends) * 0.7, true, spring, k));
        }
        for (body, it) in found.bodies.all.iter().enumerate() {
            let away = it.away(at).min(distance(at, anchor(it)));
            nearest.push((away, false, body, k));
        }
    }
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    named.labels = vec![None; found.bodies.all.len()];
    let mut springs: Vec<Option<String>> = vec![None; found.springs.len()];
    for (away, is_spring, which, k) in nearest {
        let slot = if is_spring { &mut springs[which] } else { &mut named.labels[which] };
        if away < 1.3 * reach && slot.is_none() && !is_taken[k] {
            *slot = Some(words[k].1.clone());
            is_taken[k] = true;
        }
    }
    named.springs = springs
        .iter()
        .map(|label| names.coin(&spelled(label.as_deref().unwrap_or("spring"), "spring")))
        .collect();
    for (body, label) in found.bodies.all.iter_mut().zip(&named.labels) {
        let usual = match body.look {
            super::bodies::Look::Block => "slider",
            super::bodies::Look::Wheel => "wheel",
            super::bodies::Look::Plate => "plate",
            _ => "link",
        };
        body.name = names.coin(&spelled(label.as_deref().unwrap_or(usual), "link"));
    }
    name_joints(found, names, &named);
    named
}

fn name_joints(found: &mut Found, names: &mut Names, named: &Named) {
    let near = found.pieces.tolerance;
    let bodies: Vec<String> = found.bodies.all.iter().map(|body| body.name.clone()).collect();
    let of = |on: &On| match on {
        On::Ground => "ground".to_owned(),
        On::Body(idx) => bodies[*idx].clone(),
    };
    // Pins have the letters; what else is at their places is named after its bodies.
    for joint in &mut found.joints {
        let pin = found.pins.iter().position(|pin| distance(pin.at, joint.at) < near);
        let letter = pin.and_then(|pin| named.letters[pin].clone());
        let by_letter = matches!(joint.kind, Kind::Pin | Kind::Slot { .. });
        let usual = match joint.kind {
            Kind::Pin | Kind::Gear { .. } => {
                format!("{}_{}", of(&joint.on[0]), of(&joint.on[1]))
            }
            Kind::Slide { .. } => format!("{}_slide", of(&joint.on[1])),
            Kind::Slot { .. } => format!("{}_slot", of(&joint.on[1])),
            Kind::Rack { .. } => format!("{}_rack", of(&joint.on[0])),
            Kind::Cam { .. } => format!("{}_contact", of(&joint.on[0])),
        };
        let wanted = letter.filter(|_| by_letter).unwrap_or(usual);
        joint.name = names.coin(&spelled(&wanted, "joint"));
    }
}

/// Masses in texts such as `m = 2 kg`.
fn masses(found: &Found) -> Vec<(f64, usize)> {
    let words = found.sheet.words.iter().enumerate();
    words
        .filter_map(|(idx, words)| {
            let text = words.text.to_lowercase();
            let value = bksim_cad::read::number_in(&text)?;
            let unit = text.trim_end();
            let factor = if unit.ends_with("kg") {
                1.0
            } else if unit.ends_with(" g") {
                1e-3
            } else {
                return None;
            };
            Some((value * factor, idx))
        })
        .collect()
}

/// A text in letters that a name of a model has.
fn spelled(text: &str, kind: &str) -> String {
    let plain = any_ascii::any_ascii(text);
    let letters: String =
        plain.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let words: Vec<&str> = letters.split('_').filter(|word| !word.is_empty()).collect();
    let joined = words.join("_");
    if joined.starts_with(|c: char| c.is_ascii_alphabetic()) {
        joined
    } else {
        format!("{kind}{joined}")
    }
}

/// Middle of a spring.
pub(super) fn middle(spring: &super::Zigzag) -> bksim_cad::geometry::Point {
    between(spring.ends[0], spring.ends[1], 0.5)
}
