//! Axes that rounding has tilted: those of a loop, if all of them are all but parallel, are made parallel.
//!
//! A flat loop in space moves only while its axes are parallel. Files round axes and orientations to some digits, by which
//! such a loop is a rigid frame; nobody builds one on purpose with axes that differ by less than a hundredth of a degree.

use std::collections::VecDeque;

use crate::codes;
use crate::draft::{Axes, Draft, Table, vector};
use crate::job::{Job, Place};
use crate::spatial::{Pose, Rotation, Vector, cross, dot, norm, scale, sub, unit};

/// Axes at a smaller angle are meant to be parallel or square, rad.
const MEANT: f64 = 1e-4;
/// Loops whose axes are all at smaller angles stay as their files have them, rad: they close around the pose of the file.
const CLOSING: f64 = 1e-6;
/// Loops that such angles would lock are straightened from here on, rad: smaller ones are none for the ranks of an analysis.
const LOCKING: f64 = 1e-9;
/// Axes at a smaller angle stay as they are, rad: arithmetic leaves as much.
const ROUNDING: f64 = 1e-12;

/// Joints that hold two frames upon each other at zero.
const FRAMED: [&str; 8] =
    ["revolute", "prismatic", "cylindrical", "universal", "spherical", "free", "weld", "screw"];
/// Joints of loops that move only while all their axes are parallel; balls let others close around the pose of the file.
const STIFF: [&str; 4] = ["revolute", "cylindrical", "prismatic", "weld"];
/// Joints that turn about their axis.
const TURNING: [&str; 2] = ["revolute", "cylindrical"];

/// A joint between two bodies: bodies, counted from one, the ground being zero, and the frames on them.
struct Edge {
    ends: [usize; 2],
    frames: [Pose; 2],
    is_framed: bool,
}

/// An axis in the axes of the ground, while all joints are at zero.
#[derive(Clone, Copy)]
struct Line {
    along: Vector,
    /// From the axes in which the joint states it.
    turn: Rotation,
}

/// Makes axes of loops parallel that are all but parallel, and guides square to them that are all but square.
pub(crate) fn straighten(draft: &mut Draft, job: &mut Job<'_>) {
    let edges: Vec<Option<Edge>> = draft.joints.iter().map(|joint| edge(draft, joint)).collect();
    let (poses, loops) = walk(draft, &edges);
    let line = |(joint, edge): (&Table, &Option<Edge>)| {
        let edge = edge.as_ref()?;
        let turn = poses[edge.ends[0]].then(edge.frames[0]).turn;
        let along = unit(turn.apply(axis(joint)?))?;
        Some(Line { along, turn })
    };
    let lines: Vec<Option<Line>> = draft.joints.iter().zip(&edges).map(line).collect();
    let is = |joint: usize, kinds: &[&str]| kinds.iter().any(|kind| draft.joints[joint].is(kind));

    // Axes that are parallel within a loop, over all loops.
    let mut group: Vec<usize> = (0..lines.len()).collect();
    let angle = |a: usize, b: usize| match (&lines[a], &lines[b]) {
        (Some(one), Some(other)) => norm(cross(one.along, other.along)),
        _ => f64::INFINITY,
    };
    for members in &loops {
        let turning: Vec<usize> = members.iter().copied().filter(|&j| is(j, &TURNING)).collect();
        let pairs = turning.iter().flat_map(|&a| turning.iter().map(move |&b| (a, b)));
        let largest = pairs.map(|(a, b)| angle(a, b)).fold(0.0, f64::max);
        let least = if members.iter().all(|&j| is(j, &STIFF)) { LOCKING } else { CLOSING };
        if !(least..MEANT).contains(&largest) {
            continue;
        }
        for pair in turning.windows(2) {
            let (from, to) =
                (group[pair[0]].max(group[pair[1]]), group[pair[0]].min(group[pair[1]]));
            group.iter_mut().filter(|of| **of == from).for_each(|of| *of = to);
        }
    }
    let mut changed: Vec<(usize, Vector, f64)> = Vec::new();
    for first in 0..lines.len() {
        let members: Vec<(usize, Line)> = (first..lines.len())
            .filter(|&j| group[j] == first)
            .filter_map(|j| Some((j, lines[j]?)))
            .collect();
        if members.len() < 2 {
            continue;
        }
        let Some(normal) = middle(&members) else { continue };
        changed.extend(members.iter().filter_map(|&(j, line)| {
            let sense = if dot(line.along, normal) < 0.0 { -1.0 } else { 1.0 };
            moved(j, line, scale(sense, normal))
        }));
        // Guides in the loops of these axes.
        let is_own = |members: &&Vec<usize>| members.iter().any(|&j| group[j] == first);
        let mut guides: Vec<usize> = loops.iter().filter(is_own).flatten().copied().collect();
        guides.sort_unstable();
        guides.dedup();
        for guide in guides.into_iter().filter(|&j| is(j, &["prismatic"])) {
            let Some(line) = lines[guide] else { continue };
            let along = dot(line.along, normal);
            let square = unit(sub(line.along, scale(along, normal)));
            changed.extend(
                square.filter(|_| along.abs() < MEANT).and_then(|to| moved(guide, line, to)),
            );
        }
    }
    tell(draft, job, &changed);
    for (joint, to, angle) in changed {
        let table = &mut draft.joints[joint];
        table.set("axis", vector(to));
        table.notes.push(format!("its axis is straightened by {angle:.1e} rad"));
    }
}

/// The axis of a joint in the axes in which it is stated, if it is to point elsewhere, and by how much it turns.
fn moved(joint: usize, line: Line, to: Vector) -> Option<(usize, Vector, f64)> {
    let angle = norm(cross(line.along, to));
    (angle > ROUNDING).then(|| (joint, line.turn.inverse().apply(to), angle))
}

/// The direction of the axis that is nearest to all others: rounding spares the axes along those of the file.
fn middle(members: &[(usize, Line)]) -> Option<Vector> {
    let off = |line: &Line| -> f64 {
        members.iter().map(|(_, other)| norm(cross(line.along, other.along))).sum()
    };
    let lines = members.iter().map(|(_, line)| line);
    lines.min_by(|a, b| off(a).total_cmp(&off(b))).map(|line| line.along)
}

/// Says what is changed by more than other arithmetic would leave.
fn tell(draft: &Draft, job: &mut Job<'_>, changed: &[(usize, Vector, f64)]) {
    if changed.is_empty() {
        return;
    }
    let largest = changed.iter().map(|(.., angle)| *angle).fold(0.0, f64::max);
    let names: Vec<String> =
        changed.iter().map(|(joint, ..)| format!("`{}`", draft.joints[*joint].name)).collect();
    let message = format!(
        "axes in loops are all but parallel or square, and are made so, by up to {largest:.1e} rad: {}",
        names.join(", ")
    );
    let help = "give all digits of axes and orientations where they are meant otherwise, or write `axis` in the model";
    let first = changed.first().map_or("", |(joint, ..)| draft.joints[*joint].name.as_str());
    let at = job.sources[0].text.find(&format!("\"{first}\"")).map_or(0, |at| at + 1);
    let span = at..at + if at == 0 { 0 } else { first.len() };
    let label = if at == 0 { "" } else { "one of them" };
    job.warn(codes::STRAIGHTENED, message, (&Place { file: 0, span }, label), help);
}

/// A joint as an edge, if it lies between two bodies.
fn edge(draft: &Draft, joint: &Table) -> Option<Edge> {
    let between = joint.get("between")?.trim_matches(['[', ']']);
    let mut ends = between.split(',').map(|end| located(draft, end.trim().trim_matches('"')));
    let (first, second) = (ends.next()??, ends.next()??);
    let is_framed = FRAMED.iter().any(|kind| joint.is(kind));
    Some(Edge { ends: [first.0, second.0], frames: [first.1, second.1], is_framed })
}

/// A body, counted from one, and the frame of a point on it.
fn located(draft: &Draft, end: &str) -> Option<(usize, Pose)> {
    let (owner, point) = end.split_once('.').map_or((end, None), |(o, p)| (o, Some(p)));
    let (body, points) = if owner == "ground" {
        (0, &draft.ground)
    } else {
        let at = draft.bodies.iter().position(|body| body.name == owner)?;
        (at + 1, &draft.bodies[at].points)
    };
    let Some(point) = point else { return Some((body, Pose::at([0.0; 3]))) };
    let point = points.iter().find(|known| known.name == point)?;
    let turn = match point.axes {
        Axes::Own => Rotation::NONE,
        Axes::Rpy(rpy) => Rotation::of_rpy(rpy),
        Axes::Turned(turn) => turn,
    };
    Some((body, Pose { at: point.at, turn }))
}

/// Poses of ground and bodies while all joints are at zero, and the joints of every loop.
fn walk(draft: &Draft, edges: &[Option<Edge>]) -> (Vec<Pose>, Vec<Vec<usize>>) {
    let n = draft.bodies.len() + 1;
    let mut poses = vec![Pose::at([0.0; 3]); n];
    // The joint to the body before, and how far it is from the first.
    let mut before: Vec<Option<(usize, usize)>> = vec![None; n];
    let mut depth: Vec<Option<usize>> = vec![None; n];
    let is_cut = |joint: usize| draft.joints[joint].get("cut") == Some("true");
    for root in 0..n {
        if depth[root].is_some() {
            continue;
        }
        depth[root] = Some(0);
        let mut due = VecDeque::from([root]);
        while let Some(here) = due.pop_front() {
            for (joint, edge) in edges.iter().enumerate() {
                let Some(edge) = edge else { continue };
                let Some(side) = edge.ends.iter().position(|&end| end == here) else { continue };
                let there = edge.ends[1 - side];
                if !edge.is_framed || is_cut(joint) || depth[there].is_some() {
                    continue;
                }
                let frame = poses[here].then(edge.frames[side]);
                poses[there] = frame.then(edge.frames[1 - side].inverse());
                before[there] = Some((joint, here));
                depth[there] = depth[here].map(|d| d + 1);
                due.push_back(there);
            }
        }
    }
    let in_tree = |joint: usize| before.iter().flatten().any(|(own, _)| *own == joint);
    let closing = edges.iter().enumerate().filter(|(joint, _)| !in_tree(*joint));
    let way = |(joint, edge): (usize, &Option<Edge>)| {
        let [mut a, mut b] = edge.as_ref()?.ends;
        let mut way = vec![joint];
        while a != b {
            let higher = if depth[a] >= depth[b] { &mut a } else { &mut b };
            let (joint, to) = before[*higher]?;
            way.push(joint);
            *higher = to;
        }
        Some(way)
    };
    let loops = closing.filter_map(way).collect();
    (poses, loops)
}

/// The axis that a joint states.
fn axis(joint: &Table) -> Option<Vector> {
    let parts = joint.get("axis")?.trim_matches(['[', ']']).split(',');
    let numbers: Option<Vec<f64>> = parts.map(|part| part.trim().parse().ok()).collect();
    <Vector>::try_from(numbers?).ok()
}
