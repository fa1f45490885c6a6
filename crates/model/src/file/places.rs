//! Where two shapes of a contact may touch.

use bksim_expr::Expr;

use crate::body::Anchor;
use crate::contact::{Base, EdgesForm, Place, Reach, Round, Shape};

/// Where the points of bodies are in their own axes, m.
pub(super) type Points<'a> = &'a dyn Fn(Anchor) -> [f64; 2];

/// A corner, point or disc of a shape, with the corners before and after it.
type Tip = (Round, [Option<Anchor>; 2]);

/// The places where two shapes may touch, and those that rub together.
pub(super) fn places_of(
    shapes: &[Shape; 2],
    points: Points<'_>,
    zero: Expr,
) -> (Vec<Place>, Vec<Vec<usize>>) {
    let (mut places, mut tracks) = (Vec::new(), Vec::new());
    let mut add = |together: Vec<Place>, are_straight: bool| {
        let numbers: Vec<usize> = (places.len()..places.len() + together.len()).collect();
        places.extend(together);
        if are_straight && !numbers.is_empty() {
            tracks.push(numbers);
        } else {
            tracks.extend(numbers.into_iter().map(|number| vec![number]));
        }
    };
    for (of_base, is_second) in [(0, true), (1, false)] {
        let (base, mover) = (&shapes[of_base], &shapes[1 - of_base]);
        let tips = tips(mover, points, zero);
        let place = |tip: &Tip, base: Base| Place {
            mover: tip.0,
            neighbors: tip.1.iter().flatten().copied().collect(),
            base,
            is_second,
        };
        match base {
            &Shape::Curve { joint, anchor } => {
                let base = Base::Curve { joint, anchor };
                add(tips.iter().map(|tip| place(tip, base.clone())).collect(), false);
            }
            &Shape::Plane(plane) => {
                add(tips.iter().map(|tip| place(tip, Base::Plane(plane))).collect(), false);
            }
            Shape::Points(_) => (),
            Shape::Ring(ring) | Shape::Bowl(ring) => {
                let all = tips.iter().map(|tip| place(tip, Base::Ring(*ring))).collect();
                add(all, false);
            }
            Shape::Ball(ball) => {
                // Two balls meet once.
                if is_second || !matches!(mover, Shape::Ball(_)) {
                    let base = Base::Round { round: *ball, wedge: [None; 2] };
                    add(tips.iter().map(|tip| place(tip, base.clone())).collect(), false);
                }
            }
            Shape::Round(round) => {
                // A disc meets a disc or point once; edges have it as their tip.
                let Shape::Round(other) = mover else { continue };
                let is_pair = is_second && !(round.radius == zero && other.radius == zero);
                let base = Base::Round { round: *round, wedge: [None; 2] };
                add(
                    tips.iter().filter(|_| is_pair).map(|tip| place(tip, base.clone())).collect(),
                    false,
                );
            }
            Shape::Edges { corners, form } => {
                let edges = edges_of(corners, *form);
                let is_convex = is_convex(corners, *form, points);
                for (k, &ends) in edges.iter().enumerate() {
                    let reach = |tip: &Tip| match form {
                        EdgesForm::Line => Reach::Endless,
                        EdgesForm::Outline if is_convex && tip.0.radius == zero => {
                            let others = edges.iter().enumerate().filter(|&(at, _)| at != k);
                            Reach::Within(others.map(|(_, &ends)| ends).collect())
                        }
                        _ => Reach::Ends,
                    };
                    let on_edge = |tip: &Tip| place(tip, Base::Edge { ends, reach: reach(tip) });
                    add(tips.iter().map(on_edge).collect(), true);
                }
                // Around its corners.
                let Shape::Round(disc) = mover else { continue };
                if disc.radius == zero {
                    continue;
                }
                let corners = self::tips(base, points, zero).into_iter();
                let around = corners
                    .map(|(round, wedge)| place(&(*disc, [None; 2]), Base::Round { round, wedge }));
                add(around.collect(), false);
            }
        }
    }
    (places, tracks)
}

/// Points, discs, and corners that stand out: all of a shape that meets edges and rings.
fn tips(shape: &Shape, points: Points<'_>, zero: Expr) -> Vec<Tip> {
    match shape {
        Shape::Ring(_)
        | Shape::Bowl(_)
        | Shape::Plane(_)
        | Shape::Curve { .. }
        | Shape::Edges { form: EdgesForm::Line, .. } => Vec::new(),
        Shape::Round(round) | Shape::Ball(round) => vec![(*round, [None; 2])],
        Shape::Points(points) => {
            points.iter().map(|&center| (Round { center, radius: zero }, [None; 2])).collect()
        }
        Shape::Edges { corners, form } => {
            let n = corners.len();
            let is_closed = *form == EdgesForm::Outline;
            let next_to = |k: usize| {
                let before = (is_closed || k > 0).then(|| corners[(k + n - 1) % n]);
                let after = (is_closed || k + 1 < n).then(|| corners[(k + 1) % n]);
                [before, after]
            };
            let stands_out = |&k: &usize| match next_to(k) {
                [Some(before), Some(after)] => turn(points, [before, corners[k], after]) < 0.0,
                _ => true,
            };
            let round = |k: usize| Round { center: corners[k], radius: zero };
            (0..n).filter(stands_out).map(|k| (round(k), next_to(k))).collect()
        }
    }
}

fn edges_of(corners: &[Anchor], form: EdgesForm) -> Vec<[Anchor; 2]> {
    let mut edges: Vec<[Anchor; 2]> = corners.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    if form == EdgesForm::Outline {
        edges.push([corners[corners.len() - 1], corners[0]]);
    }
    edges
}

/// True of a closed outline that turns one way at every corner.
fn is_convex(corners: &[Anchor], form: EdgesForm, points: Points<'_>) -> bool {
    let n = corners.len();
    let turns = |k: usize| turn(points, [corners[k], corners[(k + 1) % n], corners[(k + 2) % n]]);
    form == EdgesForm::Outline && (0..n).all(|k| turns(k) <= 0.0)
}

/// Twice the area of three points, positive where they turn left.
fn turn(points: Points<'_>, at: [Anchor; 3]) -> f64 {
    let [a, b, c] = at.map(points);
    cross([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]])
}

/// The product a × b along z.
pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
