//! The two members that a coupling is between, and the body that carries them.

use super::codes;
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::words::cut;
use crate::body::Anchor;
use crate::diagnostic::Diagnostic;
use crate::ids::{BodyId, JointId};
use crate::joint::{MotionKind, motion_words};

/// A wheel as `between` names it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Member {
    /// By the joint about which it turns.
    Joint(JointId),
    /// By its body and centre.
    Body(Anchor),
}

impl Reader<'_> {
    /// The two wheels of `between`: joints about which they turn, or bodies with their centres.
    pub(super) fn two_members(&mut self, fields: &Fields<'_>) -> Option<[Member; 2]> {
        let help =
            "write for example `between = [\"A\", \"B\"]` with the joints about which they turn";
        let (node, [first, second]) = self.pair(fields, "an array of two wheels", help)?;
        let what = fields.what("between");
        let mut member = |node: &Node| {
            let quoted = self.text_of(node, &what, "A")?;
            let owner = quoted.text.split('.').next().unwrap_or_default();
            if self.names.joint(quoted.text).is_none() && self.names.body(owner).is_some() {
                return Some(Member::Body(self.anchor(node, &what, &fields.owner)?));
            }
            let joint = self.joint_named(node, fields)?;
            self.only_motion(joint, MotionKind::Rotation, "angle", node, fields)?;
            Some(Member::Joint(joint))
        };
        let members = [member(first), member(second)];
        let [Some(first), Some(second)] = members else { return None };
        if first == second {
            self.coupled_with_itself(node, fields);
            return None;
        }
        Some([first, second])
    }

    /// The carrier of two wheels, the joints about whose axes they turn, and the wheels with their centres.
    pub(super) fn wheels(
        &mut self,
        members: [Member; 2],
        fields: &Fields<'_>,
    ) -> Option<(BodyId, [JointId; 2], [Anchor; 2])> {
        let (carrier, axes) = match members {
            [Member::Joint(first), Member::Joint(second)] => {
                let joints = [first, second];
                (self.carrier(joints, fields)?.0, joints)
            }
            [Member::Joint(joint), Member::Body(_)] | [Member::Body(_), Member::Joint(joint)] => {
                let [from, _] = self.joint_bodies.get(joint.0).copied().flatten()?;
                let stated = match fields.get("carrier") {
                    Some(node) => Some(self.body_of(node, fields)?),
                    None => None,
                };
                (stated.unwrap_or(from), [joint; 2])
            }
            [Member::Body(_), Member::Body(_)] => {
                let node = fields.get("between")?;
                self.report(
                    Diagnostic::error(
                        codes::NO_CARRIER,
                        format!("{} names two bodies and no joint", fields.owner),
                    )
                    .at(node.span.clone(), "none of them has an axis")
                    .help("name the joint about which one of them turns"),
                );
                return None;
            }
        };
        let wheel = |member: Member| match member {
            Member::Body(anchor) => Some(anchor),
            Member::Joint(joint) => {
                let [from, to] = self.joint_ends.get(joint.0).copied().flatten()?;
                Some(if to.body == carrier { from } else { to })
            }
        };
        let wheels = [wheel(members[0])?, wheel(members[1])?];
        if let Some(same) = wheels.iter().find(|wheel| wheel.body == carrier) {
            let name = self.names.bodies[same.body.0].name.clone();
            let node = fields.get("between")?;
            self.report(
                Diagnostic::error(
                    codes::NO_CARRIER,
                    format!("`{name}` is both a wheel of {} and its carrier", fields.owner),
                )
                .at(node.span.clone(), "a wheel does not turn against itself")
                .help("name two wheels that turn against the body that carries their axes"),
            );
            return None;
        }
        Some((carrier, axes, wheels))
    }

    /// The two joints of `between`.
    pub(super) fn two_joints(&mut self, fields: &Fields<'_>, help: &str) -> Option<[JointId; 2]> {
        let (node, [first, second]) = self.pair(fields, "an array of two joints", help)?;
        let joints = [self.joint_named(first, fields), self.joint_named(second, fields)];
        let [Some(first), Some(second)] = joints else { return None };
        if first == second {
            self.coupled_with_itself(node, fields);
            return None;
        }
        Some([first, second])
    }

    /// `between` and its two members.
    fn pair<'f>(
        &mut self,
        fields: &Fields<'f>,
        kind: &str,
        help: &str,
    ) -> Option<(&'f Node, [&'f Node; 2])> {
        let node = fields.require(self, "between", help)?;
        if let Value::Array(nodes) = &node.value
            && let [first, second] = nodes.as_slice()
        {
            return Some((node, [first, second]));
        }
        self.wrong_kind(node, &fields.what("between"), kind, &node.value, help);
        None
    }

    fn coupled_with_itself(&mut self, node: &Node, fields: &Fields<'_>) {
        let message = format!("{} couples a joint with itself", fields.owner);
        self.report(
            Diagnostic::error(codes::BAD_RELATION, message)
                .at(node.span.clone(), "the same twice")
                .help("name two joints"),
        );
    }

    /// The one rotation of a joint that carries a wheel.
    pub(super) fn turning_of(
        &mut self,
        joint: JointId,
        fields: &Fields<'_>,
        at: usize,
    ) -> Option<usize> {
        let node = nth(fields.get("between")?, at);
        self.only_motion(joint, MotionKind::Rotation, "angle", node, fields)
    }

    /// The one translation of a joint that carries a rack or a nut.
    pub(super) fn sliding_of(&mut self, joint: JointId, fields: &Fields<'_>) -> Option<usize> {
        let node = nth(fields.get("between")?, 1);
        self.only_motion(joint, MotionKind::Translation, "position", node, fields)
    }

    fn only_motion(
        &mut self,
        joint: JointId,
        kind: MotionKind,
        word: &str,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<usize> {
        let freedoms = self.names.joints[joint.0].freedoms?;
        let found = (0..freedoms.len())
            .find(|&idx| freedoms[idx] == kind && motion_words(freedoms, idx)[0] == word);
        if found.is_none() {
            self.no_such_motion(joint, word, node, fields);
        }
        found
    }

    /// The body against which both joints move, and the bodies that they move.
    pub(super) fn carrier(
        &mut self,
        joints: [JointId; 2],
        fields: &Fields<'_>,
    ) -> Option<(BodyId, [BodyId; 2])> {
        let ends = joints.map(|joint| self.joint_bodies.get(joint.0).copied().flatten());
        // A joint that could not be read was reported there.
        let [Some(first), Some(second)] = ends else { return None };
        let stated = match fields.get("carrier") {
            Some(node) => Some(self.body_of(node, fields)?),
            None => None,
        };
        let carrier = stated.or_else(|| first.into_iter().find(|body| second.contains(body)));
        let Some(carrier) = carrier else {
            let name = |body: BodyId| format!("`{}`", self.names.bodies[body.0].name);
            let [a, b] = joints.map(|joint| self.names.joints[joint.0].name.clone());
            let candidates: Vec<String> = second.into_iter().chain(first).map(name).collect();
            let node = fields.get("between")?;
            self.report(
                Diagnostic::error(
                    codes::NO_CARRIER,
                    format!(
                        "the joints `{a}` and `{b}` of {} have no body in common",
                        fields.owner
                    ),
                )
                .at(node.span.clone(), "no body carries both axes")
                .note("angles of wheels count against the body that carries their axes")
                .help(format!("write `carrier = …` with one of {}", candidates.join(", "))),
            );
            return None;
        };
        let moved = |[from, to]: [BodyId; 2]| if to == carrier { from } else { to };
        Some((carrier, [moved(first), moved(second)]))
    }

    fn body_of(&mut self, node: &Node, fields: &Fields<'_>) -> Option<BodyId> {
        let quoted = self.text_of(node, &fields.what("carrier"), "crank")?;
        let found = self.names.body(quoted.text);
        if found.is_none() {
            let names = self.owned_names(|names| names.body_names());
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let location = quoted.span_of(&(0..quoted.text.len()));
            let message = format!("{} refers to unknown body `{}`", fields.owner, cut(quoted.text));
            let label = (location, "no body has this name");
            self.unknown(codes::UNKNOWN_BODY, message, label, (quoted.text, &names));
        }
        found
    }
}

/// An element of an array.
fn nth(node: &Node, at: usize) -> &Node {
    match &node.value {
        Value::Array(values) => values.get(at).unwrap_or(node),
        _ => node,
    }
}
