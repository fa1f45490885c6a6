//! The tree of a robot: which joints carry links, which close loops, and which a format does not have.

use std::collections::VecDeque;

use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_model::{Joint, JointKind, Model, MotionKind};

use crate::Format;
use crate::codes;

use super::numbers::Numbers;
use super::parts::{Connection, Link, Report};

/// True if a format has this joint where it carries a link.
fn carries(format: Format, kind: &JointKind) -> bool {
    let n_slides = kind.motions().iter().filter(|of| **of == MotionKind::Translation).count();
    let is_elementary = kind.is_free() || !kind.is_always_cut() && n_slides < 3;
    match format {
        Format::Mjcf => is_elementary,
        Format::Urdf => {
            is_elementary && kind.lead().is_none() && (!kind.turns_freely() || kind.is_free())
        }
        _ => kind.is_free() || closes(format, kind, true),
    }
}

/// True if a format has this joint where it closes a loop.
fn closes(format: Format, kind: &JointKind, is_planar: bool) -> bool {
    if kind.is_pin() || kind.is_weld() || kind.is_ball() {
        return format != Format::Urdf;
    }
    let has_sdf = kind.is_slide() || kind.lead().is_some() || kind.is_cross() && is_planar;
    format == Format::Sdf && has_sdf
}

/// The links in the order of a tree, and the connections: those of the tree and those that close loops.
///
/// A joint that no loop can have and one in which loads act come into the tree first, one that the author cuts last.
pub(super) fn tree(
    model: &Model,
    format: Format,
    links: &mut [Link],
    report: &mut Report,
) -> Result<(Vec<usize>, Vec<Connection>), Rejected> {
    let is_planar = model.space == bksim_model::Space::Planar;
    let acted = model.loads.iter().filter_map(|load| load.kind.joint_motion());
    let acted: Vec<usize> = acted.map(|(joint, _)| joint.0).collect();
    let rank = |idx: usize| {
        let joint = &model.joints[idx];
        let is_easy = closes(format, &joint.kind, is_planar) && !acted.contains(&idx);
        let is_ball = is_easy && joint.kind.is_ball();
        let is_free = joint.kind.is_free();
        (is_free, !carries(format, &joint.kind), joint.cut == Some(true), is_easy, is_ball)
    };
    let mut sorted: Vec<usize> = (0..model.joints.len()).collect();
    sorted.sort_by_key(|&idx| rank(idx));
    let mut group: Vec<usize> = (0..links.len()).collect();
    let mut near = vec![Vec::new(); links.len()];
    for idx in sorted {
        let joint = &model.joints[idx];
        let ends = [joint.predecessor.body.0, joint.successor.body.0];
        let [a, b] = ends.map(|end| group[end]);
        if a == b || joint.kind.is_always_cut() {
            continue;
        }
        group.iter_mut().filter(|of| **of == b).for_each(|of| *of = a);
        for end in ends {
            near[end].push(idx);
        }
    }
    for of in &mut near {
        of.sort_unstable();
    }

    let mut order = Vec::new();
    let mut connections = Vec::new();
    let mut faults = Vec::new();
    let mut is_reached = vec![false; links.len()];
    let mut is_used = vec![false; model.joints.len()];
    let mut frontier = VecDeque::new();
    for seed in 0..links.len() {
        if is_reached[seed] {
            continue;
        }
        is_reached[seed] = true;
        frontier.push_back(seed);
        if seed > 0 {
            order.push(seed);
            links[seed].carrier = Some(connections.len());
            let body = &model.bodies[seed];
            connections.push(connection(
                None,
                format!("{}_free", body.name),
                [0, seed],
                body.span.clone(),
            ));
        }
        while let Some(parent) = frontier.pop_front() {
            for &idx in &near[parent] {
                let joint = &model.joints[idx];
                let ends = [joint.predecessor.body.0, joint.successor.body.0];
                let child = if ends[0] == parent { ends[1] } else { ends[0] };
                if is_reached[child] {
                    continue;
                }
                (is_reached[child], is_used[idx]) = (true, true);
                if !carries(format, &joint.kind) {
                    faults.push(not_held(joint, format));
                }
                order.push(child);
                frontier.push_back(child);
                links[child].carrier = Some(connections.len());
                connections.push(of_joint(model, idx, [parent, child]));
            }
        }
    }
    if !faults.is_empty() {
        return Err(Rejected(faults));
    }
    for (idx, joint) in model.joints.iter().enumerate() {
        if is_used[idx] || joint.kind.is_free() {
            continue;
        }
        let ends = [joint.predecessor.body.0, joint.successor.body.0];
        if closes(format, &joint.kind, is_planar) {
            let ends = if ends[1] == 0 { [ends[1], ends[0]] } else { ends };
            let closing = of_joint(model, idx, ends);
            connections.push(Connection { is_loop: true, ..closing });
        } else {
            report.faults.push(open_loop(joint, format));
            report.leave_out(format!("joint {}, which closes a loop", joint.name), &joint.span);
        }
    }
    Ok((order, connections))
}

fn connection(
    joint: Option<usize>,
    name: String,
    [parent, child]: [usize; 2],
    span: Span,
) -> Connection {
    Connection {
        joint,
        name,
        word: "free",
        parent,
        child,
        center: [0.0; 3],
        axes: Vec::new(),
        has_ball: false,
        lead: None,
        is_loop: false,
        span,
    }
}

fn of_joint(model: &Model, idx: usize, ends: [usize; 2]) -> Connection {
    let joint = &model.joints[idx];
    let lead = joint.kind.lead().and_then(|lead| Numbers(model).value(lead));
    let has_ball = joint.kind.turns_freely() && !joint.kind.is_free();
    let plain = connection(Some(idx), joint.name.clone(), ends, joint.span.clone());
    Connection { word: joint.kind.word(), has_ball, lead, ..plain }
}

/// The fault of a joint that carries a body, and that the format does not have.
fn not_held(joint: &Joint, format: Format) -> Diagnostic {
    let others: Vec<&str> = [Format::Mjcf, Format::Sdf, Format::Urdf]
        .into_iter()
        .filter(|other| carries(*other, &joint.kind))
        .map(Format::name)
        .collect();
    let help = if others.is_empty() {
        "no robot format has it: connect the body by joints that turn or slide".to_owned()
    } else {
        format!("write the model as {}", others.join(" or "))
    };
    let word = joint.kind.word();
    let message = format!(
        "{} has no joint of type `{word}`, which carries a body in `{}`",
        format.name(),
        joint.name
    );
    Diagnostic::error(codes::NOT_HELD, message).at(joint.span.clone(), "").help(help)
}

/// The warning of a loop that stays open in the file.
fn open_loop(joint: &Joint, format: Format) -> Diagnostic {
    let help = if format == Format::Urdf {
        "write the model as SDF or MJCF, which close loops; robots in URDF are trees"
    } else {
        "close the loop there by a revolute, spherical or weld joint to have it in the file"
    };
    let message = format!(
        "joint `{}` closes a loop that {} cannot close: the file leaves it open",
        joint.name,
        format.name()
    );
    Diagnostic::warning(codes::OPEN_LOOP, message).at(joint.span.clone(), "left out").help(help)
}
