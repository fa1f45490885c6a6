//! Closed outlines out of lines and bows whose ends meet, and their forms.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{along, between, distance, dot, scaled, sub};

use super::pieces::{Pieces, Ring, skew, turned, unit};

/// Most pairs of ends or lines that are held against each other.
const MAX_PAIRS: usize = 400_000;

/// Form of an outline.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Form {
    /// Two straight sides with a half circle at either end: a bar or a slot.
    Round {
        ends: [Point; 2],
        half: f64,
    },
    /// A rectangle: its middle line along the longer side, and half the shorter one.
    Box {
        ends: [Point; 2],
        half: f64,
    },
    Triangle,
    Other,
}

impl Ring {
    pub(super) fn form(&self) -> Form {
        match (self.sides.as_slice(), self.arcs.as_slice()) {
            ([_, _], [first, second]) if (first.1 - second.1).abs() < 0.15 * first.1 => {
                let half = 0.5 * (first.1 + second.1);
                let reach = distance(first.0, second.0);
                let along_axis = unit(sub(second.0, first.0));
                let is_parallel =
                    |side: &[Point; 2]| skew(unit(sub(side[1], side[0])), along_axis) < 0.12;
                if reach > 0.3 * half && self.sides.iter().all(is_parallel) {
                    return Form::Round { ends: [first.0, second.0], half };
                }
                Form::Other
            }
            ([_, _, _], []) => Form::Triangle,
            ([a, b, c, d], []) => rectangle([*a, *b, *c, *d]).unwrap_or(Form::Other),
            _ => Form::Other,
        }
    }
}

fn rectangle(sides: [[Point; 2]; 4]) -> Option<Form> {
    let vector = |k: usize| sub(sides[k][1], sides[k][0]);
    let lengths: Vec<f64> = sides.iter().map(|side| distance(side[0], side[1])).collect();
    let is_even = |a: f64, b: f64| (a - b).abs() < 0.12 * a.max(b);
    let is_square_cornered = dot(unit(vector(0)), unit(vector(1))).abs() < 0.1;
    if !is_square_cornered || !is_even(lengths[0], lengths[2]) || !is_even(lengths[1], lengths[3]) {
        return None;
    }
    let middle = |k: usize| between(sides[k][0], sides[k][1], 0.5);
    let (ends, half) = if lengths[0] >= lengths[1] {
        ([middle(1), middle(3)], 0.5 * lengths[1])
    } else {
        ([middle(0), middle(2)], 0.5 * lengths[0])
    };
    Some(Form::Box { ends, half })
}

/// An edge of the graph of ends: a line or a bow, with its direction out of either end.
struct Edge {
    is_line: bool,
    idx: usize,
    ends: [Point; 2],
    out: [Point; 2],
}

/// Finds rings among what is left, and takes their pieces away.
pub(super) fn close_rings(pieces: &mut Pieces, pins: &[Point]) {
    let edges = edges(pieces);
    // Pairs of ends that continue each other, the straightest first at forks.
    let mut pairs: Vec<(f64, [(usize, usize); 2])> = Vec::new();
    let near = 1.2 * pieces.tolerance;
    let is_pin = |p: Point| pins.iter().any(|pin| distance(*pin, p) < near);
    for (i, first) in edges.iter().enumerate() {
        for (k, second) in edges.iter().enumerate().skip(i) {
            for (e, f) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                if i == k && (e, f) != (0, 1) {
                    continue;
                }
                let gap = distance(first.ends[e], second.ends[f]);
                // Lines that end at a pin are links of their own.
                if gap > near || first.is_line && second.is_line && is_pin(first.ends[e]) {
                    continue;
                }
                // Thousands of ends in one place are no outline.
                if pairs.len() >= MAX_PAIRS {
                    continue;
                }
                let bend = 1.0 + dot(first.out[e], second.out[f]);
                pairs.push((bend + gap / near, [(i, e), (k, f)]));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut next: Vec<[Option<(usize, usize)>; 2]> = vec![[None; 2]; edges.len()];
    for (_, [(i, e), (k, f)]) in pairs {
        if next[i][e].is_none() && next[k][f].is_none() && (i, e) != (k, f) {
            next[i][e] = Some((k, f));
            next[k][f] = Some((i, e));
        }
    }
    let mut seen = vec![false; edges.len()];
    for start in 0..edges.len() {
        if let Some(walk) = walk(&edges, &next, &mut seen, start) {
            take_ring(pieces, &edges, &walk);
        }
    }
}

fn edges(pieces: &Pieces) -> Vec<Edge> {
    let lines = pieces.lines.iter().enumerate().filter(|(_, line)| !line.is_used);
    let lines = lines.map(|(idx, line)| {
        let d = line.direction();
        Edge { is_line: true, idx, ends: line.ends, out: [scaled(d, -1.0), d] }
    });
    let bows = pieces.bows.iter().enumerate().filter(|(_, bow)| !bow.is_used);
    let bows = bows.map(|(idx, bow)| {
        let p = &bow.points;
        let n = p.len();
        let out = [unit(sub(p[0], p[1])), unit(sub(p[n - 1], p[n - 2]))];
        Edge { is_line: false, idx, ends: bow.ends, out }
    });
    lines.chain(bows).collect()
}

/// The edges of the ring through `start` with the ends at which they are entered.
fn walk(
    edges: &[Edge],
    next: &[[Option<(usize, usize)>; 2]],
    seen: &mut [bool],
    start: usize,
) -> Option<Vec<(usize, usize)>> {
    if seen[start] {
        return None;
    }
    let mut walk = vec![(start, 0)];
    seen[start] = true;
    let mut at = (start, 1);
    for _ in 0..edges.len() {
        let (edge, entered) = next[at.0][at.1]?;
        if edge == start {
            return (entered == 0).then_some(walk);
        }
        if seen[edge] {
            return None;
        }
        seen[edge] = true;
        walk.push((edge, entered));
        at = (edge, 1 - entered);
    }
    None
}

fn take_ring(pieces: &mut Pieces, edges: &[Edge], walk: &[(usize, usize)]) {
    let mut ring = Ring {
        points: Vec::new(),
        sides: Vec::new(),
        arcs: Vec::new(),
        from: Vec::new(),
        is_used: false,
    };
    for &(edge, entered) in walk {
        let edge = &edges[edge];
        if edge.is_line {
            let line = &mut pieces.lines[edge.idx];
            line.is_used = true;
            let side = [line.ends[entered], line.ends[1 - entered]];
            ring.sides.push(side);
            ring.points.push(side[0]);
            ring.from.extend(&line.from);
        } else {
            let bow = &mut pieces.bows[edge.idx];
            bow.is_used = true;
            let mut points = bow.points.clone();
            if entered == 1 {
                points.reverse();
            }
            ring.points.extend(&points[..points.len() - 1]);
            if let Some((centre, radius)) = bow.circle {
                ring.arcs.push((centre, radius, bow.ends));
            }
            ring.from.push(bow.from);
        }
    }
    pieces.rings.push(ring);
}

/// Middle lines of pairs of parallel lines of one length, with half their distance: bars without ends.
pub(super) fn pairs(pieces: &Pieces) -> Vec<([usize; 2], [Point; 2], f64)> {
    let mut found = Vec::new();
    let free: Vec<usize> =
        (0..pieces.lines.len()).filter(|&idx| !pieces.lines[idx].is_used).collect();
    for (n, &i) in free.iter().enumerate() {
        for &k in &free[n + 1..] {
            let (first, second) = (&pieces.lines[i], &pieces.lines[k]);
            let direction = first.direction();
            if skew(direction, second.direction()) > 0.04 {
                continue;
            }
            let other = if dot(direction, second.direction()) > 0.0 {
                second.ends
            } else {
                [second.ends[1], second.ends[0]]
            };
            let across = turned(direction);
            let off = [0, 1].map(|e| sub(other[e], first.ends[e]));
            let gap = 0.5 * (dot(off[0], across) + dot(off[1], across));
            let shift = off.map(|off| dot(off, direction).abs());
            let is_even = shift.iter().all(|shift| *shift < 1.5 * pieces.tolerance);
            let wide = gap.abs();
            if is_even
                && wide > 0.5 * pieces.pin
                && wide < 9.0 * pieces.pin
                && first.length() > 1.4 * wide
                && found.len() < MAX_PAIRS
            {
                let ends = [0, 1].map(|e| along(first.ends[e], 0.5, off[e]));
                found.push(([i, k], ends, 0.5 * wide));
            }
        }
    }
    // The narrowest pairs first: neighbours, not sides of different bars.
    found.sort_by(|a, b| a.2.total_cmp(&b.2));
    found
}
