//! Springs: lines that go to and fro across one direction.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{cross, distance, dot, sub};

use super::pieces::{Pieces, unit};

/// A spring between two points.
#[derive(Clone, Debug)]
pub(super) struct Zigzag {
    pub(super) ends: [Point; 2],
    pub(super) from: Vec<usize>,
}

/// Fewest sharp turns of a spring.
const TURNS: usize = 4;

/// Finds springs, and takes their lines away.
pub(super) fn springs(pieces: &mut Pieces) -> Vec<Zigzag> {
    let near = 0.6 * pieces.tolerance;
    let mut found = Vec::new();
    let mut seen = vec![false; pieces.lines.len()];
    for start in 0..pieces.lines.len() {
        if seen[start] || pieces.lines[start].is_used {
            continue;
        }
        // The run of lines through this one, as corners with the lines between them.
        let mut run = vec![start];
        let mut in_run = vec![false; pieces.lines.len()];
        in_run[start] = true;
        let mut corners = pieces.lines[start].ends.to_vec();
        seen[start] = true;
        for side in [1, 0] {
            loop {
                let at = if side == 1 { corners[corners.len() - 1] } else { corners[0] };
                let next: Vec<(usize, usize)> = (0..pieces.lines.len())
                    .filter(|idx| !in_run[*idx] && !pieces.lines[*idx].is_used)
                    .flat_map(|idx| [(idx, 0), (idx, 1)])
                    .filter(|&(idx, end)| distance(pieces.lines[idx].ends[end], at) < near)
                    .collect();
                let [(idx, end)] = next[..] else { break };
                if seen[idx] {
                    break;
                }
                seen[idx] = true;
                in_run[idx] = true;
                let far = pieces.lines[idx].ends[1 - end];
                if side == 1 {
                    run.push(idx);
                    corners.push(far);
                } else {
                    run.insert(0, idx);
                    corners.insert(0, far);
                }
            }
        }
        if let Some([first, last]) = zigzag(&corners) {
            let from =
                run[first..last].iter().flat_map(|&idx| pieces.lines[idx].from.clone()).collect();
            for &idx in &run[first..last] {
                pieces.lines[idx].is_used = true;
            }
            found.push(Zigzag { ends: [corners[first], corners[last]], from });
        }
    }
    found
}

/// The corners where the spring in a run begins and ends, its straight ends included.
fn zigzag(corners: &[Point]) -> Option<[usize; 2]> {
    let n = corners.len();
    let turn = |k: usize| {
        let (a, b) = (unit(sub(corners[k], corners[k - 1])), unit(sub(corners[k + 1], corners[k])));
        (cross(a, b), dot(a, b))
    };
    let mut best: Option<[usize; 2]> = None;
    let mut k = 1;
    while k + 1 < n {
        let first = k;
        // Sharp turns to either side in turn.
        while k + 1 < n && {
            let (side, ahead) = turn(k);
            let is_sharp = ahead < 0.6 && side.abs() > 0.1 || ahead < -0.5;
            is_sharp && (k == first || side * turn(k - 1).0 < 0.0)
        } {
            k += 1;
        }
        let count = k - first;
        if count >= TURNS && best.is_none_or(|[a, b]| count > b - a) {
            best = Some([first, k - 1]);
        }
        k = if count == 0 { k + 1 } else { k };
    }
    let [first, last] = best?;
    // The strokes between the turns have one length, but for those at the ends.
    let lengths: Vec<f64> =
        (first + 1..last.saturating_sub(1)).map(|k| distance(corners[k], corners[k + 1])).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    if lengths.iter().any(|length| *length < 0.7 * longest) {
        return None;
    }
    // A straight lead at either end belongs to it.
    let lead = |from: usize, to: usize| distance(corners[from], corners[to]);
    let begin = if first >= 2 && lead(first - 1, first - 2) < 6.0 * longest {
        first - 2
    } else {
        first - 1
    };
    let end =
        if last + 2 < n && lead(last + 1, last + 2) < 6.0 * longest { last + 2 } else { last + 1 };
    Some([begin, end])
}

#[cfg(test)]
mod tests {
    use super::zigzag;

    #[test]
    fn a_spring_has_sharp_turns_to_either_side() {
        let zig = |k: i32| [f64::from(k), if k % 2 == 0 { 1.0 } else { -1.0 }];
        let mut corners = vec![[-3.0, 0.0], [0.5, 0.0]];
        corners.extend((1..9).map(zig));
        corners.extend([[9.5, 0.0], [12.0, 0.0]]);
        let [first, last] = zigzag(&corners).expect("a spring");
        assert_eq!((first, last), (0, corners.len() - 1));
        // Too few turns, and turns to one side.
        assert_eq!(zigzag(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]), None);
        let ring = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [1.0, 5.0], [1.0, 1.0], [4.0, 1.0]];
        assert_eq!(zigzag(&ring), None);
    }
}
