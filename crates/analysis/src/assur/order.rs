//! The order in which a linkage closes, group by group, from a part that stands.

use std::collections::BTreeSet;

use super::structure::{Pair, Structure};

/// A group with what it closes beyond need.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) group: Group,
    /// Conditions of its pairs less freedoms of its parts.
    pub(super) n_redundant: usize,
}

/// Parts that close together.
#[derive(Clone, Debug)]
pub(super) enum Group {
    /// A part with a held angle on a pin.
    Turned { part: usize, pin: usize, angle: f64 },
    /// A part on two pairs.
    Single { part: usize, pairs: [Pair; 2] },
    /// Two parts: the pair of the first with what stands, that between them, that of the second.
    Dyad { parts: [usize; 2], pairs: [Pair; 3] },
    /// A platform on three legs.
    Triad { platform: usize, legs: [Leg; 3] },
    /// Parts that close together in another way.
    Larger { parts: Vec<usize> },
}

/// A leg of a platform, with its pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) part: usize,
    pub(super) standing: Pair,
    pub(super) platform: Pair,
}

impl Leg {
    pub(super) fn kind(&self) -> &'static str {
        match (self.standing, self.platform) {
            (Pair::Pin(_), Pair::Pin(_)) => "RR",
            (Pair::Slide(_), Pair::Pin(_)) => "PR",
            (_, Pair::Slide(_)) => "RP",
        }
    }
}

impl Step {
    /// Parts that it places.
    pub(super) fn parts(&self) -> Vec<usize> {
        match &self.group {
            Group::Turned { part, .. } | Group::Single { part, .. } => vec![*part],
            Group::Dyad { parts, .. } => parts.to_vec(),
            Group::Triad { platform, legs } => {
                std::iter::once(*platform).chain(legs.map(|leg| leg.part)).collect()
            }
            Group::Larger { parts } => parts.clone(),
        }
    }
}

/// The part to begin with, and the groups from there; none where no part leads to all others.
pub(super) fn steps(structure: &Structure) -> Option<(usize, Vec<Step>)> {
    // Angles are held against the ground.
    let n_roots = if structure.angles.is_empty() { structure.n_parts } else { 1 };
    let all = |largest: usize| {
        (0..n_roots).find_map(|root| Some((root, Taking::from(structure, root, largest).all()?)))
    };
    // Closed forms first, then the smallest groups that lead to all.
    [0, 4, 6, 8, 10, MOST_PARTS].into_iter().find_map(all)
}

/// Most parts of a group.
const MOST_PARTS: usize = 12;

/// A structure that is being taken apart.
struct Taking<'a> {
    structure: &'a Structure,
    stands: Vec<bool>,
    angles: Vec<usize>,
    /// Most parts of a group that is no dyad or triad.
    largest: usize,
}

impl<'a> Taking<'a> {
    fn from(structure: &'a Structure, root: usize, largest: usize) -> Self {
        let mut stands = vec![false; structure.n_parts];
        stands[root] = true;
        // The angle of what stands is known.
        let angles = structure.angles.iter().copied().filter(|part| *part != root).collect();
        Self { structure, stands, angles, largest }
    }

    fn all(mut self) -> Option<Vec<Step>> {
        let mut steps = Vec::new();
        while self.stands.contains(&false) {
            let mut group = self.turned().or_else(|| self.single());
            group = group.or_else(|| self.dyad()).or_else(|| self.triad());
            group = group.or_else(|| self.larger());
            let mut step = Step { group: group?, n_redundant: 0 };
            let before = self.n_conditions();
            for part in step.parts() {
                self.stands[part] = true;
            }
            let mut n_closed = self.n_conditions() - before;
            if let Group::Turned { .. } | Group::Larger { .. } = step.group {
                let parts = step.parts();
                let n_angles = self.angles.len();
                self.angles.retain(|of| !parts.contains(of));
                n_closed += n_angles - self.angles.len();
            }
            step.n_redundant = n_closed - 3 * step.parts().len();
            steps.push(step);
        }
        self.angles.is_empty().then_some(steps)
    }

    /// Conditions of pairs between parts that stand.
    fn n_conditions(&self) -> usize {
        let of_pin = |pin: &super::structure::Pin| {
            pin.on.iter().filter(|(part, _)| self.stands[*part]).count().saturating_sub(1)
        };
        let slides = self.structure.slides.iter();
        let closed = slides.filter(|slide| slide.parts.iter().all(|part| self.stands[*part]));
        2 * (self.structure.pins.iter().map(of_pin).sum::<usize>() + closed.count())
    }

    fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.structure.n_parts).filter(|part| !self.stands[*part])
    }

    /// Pairs of a part with what stands.
    fn standing(&self, part: usize) -> Vec<Pair> {
        let is_on = |pin: &usize| {
            let on = &self.structure.pins[*pin].on;
            on.iter().any(|(known, _)| *known == part)
                && on.iter().any(|(known, _)| self.stands[*known])
        };
        let pins = (0..self.structure.pins.len()).filter(is_on).map(Pair::Pin);
        let is_by = |slide: &usize| {
            let parts = self.structure.slides[*slide].parts;
            parts.contains(&part) && self.stands[self.structure.other(*slide, part)]
        };
        pins.chain((0..self.structure.slides.len()).filter(is_by).map(Pair::Slide)).collect()
    }

    /// Pairs between two parts that do not stand.
    fn between(&self, a: usize, b: usize) -> Vec<Pair> {
        let is_shared = |pin: &usize| {
            let on = &self.structure.pins[*pin].on;
            let has = |part: usize| on.iter().any(|(known, _)| *known == part);
            has(a) && has(b) && !on.iter().any(|(known, _)| self.stands[*known])
        };
        let pins = (0..self.structure.pins.len()).filter(is_shared).map(Pair::Pin);
        let joins = |slide: &usize| {
            let parts = self.structure.slides[*slide].parts;
            parts.contains(&a) && parts.contains(&b)
        };
        pins.chain((0..self.structure.slides.len()).filter(joins).map(Pair::Slide)).collect()
    }

    fn turned(&self) -> Option<Group> {
        self.free().filter(|part| self.angles.contains(part)).find_map(|part| {
            let pin = self.standing(part).into_iter().find_map(|pair| match pair {
                Pair::Pin(pin) => Some(pin),
                Pair::Slide(_) => None,
            });
            Some(Group::Turned { part, pin: pin?, angle: 0.0 })
        })
    }

    fn single(&self) -> Option<Group> {
        self.free().find_map(|part| match self.standing(part).as_slice() {
            [a, b, ..] => Some(Group::Single { part, pairs: [*a, *b] }),
            _ => None,
        })
    }

    fn dyad(&self) -> Option<Group> {
        let free: Vec<usize> = self.free().collect();
        let ordered = free.iter().flat_map(|&a| free.iter().map(move |&b| (a, b)));
        ordered.filter(|(a, b)| a != b).find_map(|(a, b)| {
            let [first] = self.standing(a).try_into().ok()?;
            let [last] = self.standing(b).try_into().ok()?;
            let between = *self.between(a, b).first()?;
            let pairs = [first, between, last];
            super::dyad::is_known(pairs).then_some(Group::Dyad { parts: [a, b], pairs })
        })
    }

    fn triad(&self) -> Option<Group> {
        self.free().find_map(|platform| {
            let leg = |part: usize| {
                let [standing] = self.standing(part).try_into().ok()?;
                let platform = *self.between(part, platform).first()?;
                let slides = |pair| matches!(pair, Pair::Slide(_));
                (!(slides(standing) && slides(platform))).then_some(Leg {
                    part,
                    standing,
                    platform,
                })
            };
            let legs = self.free().filter(|part| *part != platform).filter_map(leg);
            let legs: Vec<Leg> = legs.take(3).collect();
            Some(Group::Triad { platform, legs: legs.try_into().ok()? })
        })
    }

    /// The smallest parts that hang together and have as many conditions as freedoms.
    fn larger(&self) -> Option<Group> {
        /// Sets of one size that are looked at.
        const MOST_SETS: usize = 30_000;
        let free: Vec<usize> = self.free().collect();
        if free.len() > 64 || self.largest == 0 {
            return None;
        }
        let members = |set: u64| (0..free.len()).filter(move |k| set >> k & 1 == 1);
        let parts = |set: u64| members(set).map(|k| free[k]).collect::<Vec<usize>>();
        let neighbours: Vec<u64> = free
            .iter()
            .map(|&a| {
                let is_next = |k: &usize| free[*k] != a && !self.between(a, free[*k]).is_empty();
                (0..free.len()).filter(is_next).fold(0, |set, k| set | 1 << k)
            })
            .collect();
        let mut sets: BTreeSet<u64> = (0..free.len()).map(|k| 1 << k).collect();
        for _ in 1..self.largest {
            let around = |&set: &u64| {
                let next = members(set).fold(0, |all, k| all | neighbours[k]) & !set;
                (0..free.len()).filter(move |k| next >> k & 1 == 1).map(move |k| set | 1 << k)
            };
            sets = sets.iter().flat_map(around).collect();
            if sets.len() > MOST_SETS {
                return None;
            }
            if let Some(found) = sets.iter().find(|&&set| self.is_closed(&parts(set))) {
                return Some(Group::Larger { parts: parts(*found) });
            }
        }
        None
    }

    /// True of parts with three conditions each.
    fn is_closed(&self, parts: &[usize]) -> bool {
        let here = |part: usize| self.stands[part] || parts.contains(&part);
        let of_pin = |pin: &super::structure::Pin| {
            let count = |is: &dyn Fn(usize) -> bool| pin.on.iter().filter(|(p, _)| is(*p)).count();
            count(&here).saturating_sub(1) - count(&|p| self.stands[p]).saturating_sub(1)
        };
        let slides = self.structure.slides.iter();
        let closed = slides.filter(|slide| {
            slide.parts.iter().all(|p| here(*p)) && slide.parts.iter().any(|p| parts.contains(p))
        });
        let n_held = self.angles.iter().filter(|part| parts.contains(part)).count();
        let n_pairs = self.structure.pins.iter().map(of_pin).sum::<usize>() + closed.count();
        2 * n_pairs + n_held == 3 * parts.len()
    }
}
