//! Frames by their names, and where they are in the world.

use std::collections::BTreeMap;

use crate::codes;
use crate::job::{Place, short, suggestion};
use crate::spatial::Pose;
use crate::xml::NodeId;

use super::{Reader, Scope};

/// Handle to a frame.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct FrameId(pub(super) usize);

impl FrameId {
    /// The frame of the world.
    pub(super) const WORLD: Self = Self(0);
}

/// The part of a file that a frame is of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Of {
    World,
    Model,
    Link,
    Joint,
    Plain,
}

/// A frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) of: Of,
    pub(super) node: Option<NodeId>,
    pub(super) scope: usize,
    pub(super) name: String,
    /// In the frame that it is relative to.
    pub(super) pose: Pose,
    /// Frame as written, with its place; `None` for what is usual.
    relative_to: Option<(String, Place)>,
    /// The frame or link that it moves with, as written.
    attached_to: Option<(String, Place)>,
    /// The frame of a model that the stated pose is about.
    placed_by: Option<(String, Place)>,
    /// Once resolved.
    pub(super) base: Option<FrameId>,
    pub(super) world: Option<Pose>,
}

impl Frame {
    pub(super) fn world() -> Self {
        Self {
            of: Of::World,
            node: None,
            scope: 0,
            name: "world".to_owned(),
            pose: Pose::NONE,
            relative_to: None,
            attached_to: None,
            placed_by: None,
            base: None,
            world: Some(Pose::NONE),
        }
    }
}

impl Reader<'_, '_> {
    /// A scope for a model; `stated` is the element with its name and pose, `model` that with its contents.
    pub(super) fn scope(
        &mut self,
        (stated, model): (NodeId, NodeId),
        parent: Option<usize>,
        is_only: bool,
    ) -> usize {
        let own_name = |reader: &Self, node| {
            let by_text = reader.tree.text_of(node, "name").map(|(text, _)| text.to_owned());
            by_text.or_else(|| reader.tree.value(node, "name").map(str::to_owned))
        };
        let name = own_name(self, stated)
            .or_else(|| own_name(self, model))
            .unwrap_or_else(|| "model".to_owned());
        let before = parent.map_or(String::new(), |parent| self.scopes[parent].prefix.clone());
        let prefix = if is_only { String::new() } else { format!("{before}{name}::") };
        let has_pose = self.tree.child(stated, "pose").is_some();
        let (pose, relative_to) = self.pose(if has_pose { stated } else { model });
        let by_text = self
            .tree
            .text_of(stated, "placement_frame")
            .map(|(text, place)| (text.to_owned(), place.clone()));
        let placed_by = by_text.or_else(|| {
            let found = self.tree.attribute(model, "placement_frame")?;
            Some((found.value.clone(), found.place.clone()))
        });
        let is_static = self.is_true(stated, "static").or_else(|| self.is_true(model, "static"));
        let is_static =
            is_static == Some(true) || parent.is_some_and(|parent| self.scopes[parent].is_static);
        let scope = self.scopes.len();
        let own = self.add_frame(Frame {
            of: Of::Model,
            node: Some(model),
            scope: parent.unwrap_or(usize::MAX),
            name: name.clone(),
            pose,
            relative_to,
            placed_by,
            ..Frame::world()
        });
        if let Some(parent) = parent {
            self.declare(parent, &name, own, stated);
        }
        self.scopes.push(Scope {
            prefix,
            node: model,
            parent,
            frames: BTreeMap::new(),
            own,
            is_static,
            first_link: None,
        });
        scope
    }

    fn add_frame(&mut self, frame: Frame) -> FrameId {
        let world = (frame.of == Of::World).then_some(Pose::NONE);
        self.frames.push(Frame { world, base: None, ..frame });
        FrameId(self.frames.len() - 1)
    }

    /// Gives a frame its name in a scope; two of one name are reported.
    fn declare(&mut self, scope: usize, name: &str, frame: FrameId, node: NodeId) {
        if self.scopes[scope].frames.insert(name.to_owned(), frame).is_some() {
            let place = self.place(node);
            let message = format!("two parts are called `{}`", short(name));
            let help = "give links, joints, frames and models of one model names of their own";
            self.job.error(codes::TWICE, message, (&place, "the second one"), help);
        }
    }

    /// Reads the frames of a model; returns the models in it.
    pub(super) fn contents(&mut self, scope: usize) -> Vec<NodeId> {
        let mut nested = Vec::new();
        let node = self.scopes[scope].node;
        for child in self.tree.children(node) {
            let of = match self.tree.tag(child) {
                "link" => Of::Link,
                "joint" => Of::Joint,
                "frame" => Of::Plain,
                "model" | "include" => {
                    nested.push(child);
                    continue;
                }
                "pose" | "static" | "self_collide" | "allow_auto_disable" | "enable_wind" => {
                    continue;
                }
                _ => {
                    self.leave_out(child, "");
                    continue;
                }
            };
            let Some(name) = self.tree.value(child, "name").map(str::to_owned) else {
                let tag = self.tree.tag(child).to_owned();
                let place = self.place(child);
                let message = format!("a `{tag}` has no name");
                self.job.error(
                    codes::MISSING,
                    message,
                    (&place, ""),
                    &format!("write `<{tag} name=\"…\">`"),
                );
                continue;
            };
            let (pose, relative_to) = self.pose(child);
            let attached_to = match of {
                Of::Joint => self
                    .tree
                    .text_of(child, "child")
                    .map(|(text, place)| (text.to_owned(), place.clone())),
                _ => self
                    .tree
                    .attribute(child, "attached_to")
                    .map(|found| (found.value.clone(), found.place.clone())),
            };
            let frame = Frame {
                of,
                node: Some(child),
                scope,
                name: name.clone(),
                pose,
                relative_to,
                attached_to: attached_to.filter(|(name, _)| !name.is_empty()),
                ..Frame::world()
            };
            let id = self.add_frame(frame);
            if of == Of::Link && self.scopes[scope].first_link.is_none() {
                self.scopes[scope].first_link = Some(id);
            }
            self.declare(scope, &name, id, child);
        }
        nested
    }

    /// The frame that a name means in a scope.
    pub(super) fn find(&self, scope: usize, name: &str) -> Option<FrameId> {
        if name == "world" {
            return Some(FrameId::WORLD);
        }
        let mut scope = scope;
        let mut rest = name;
        while let Some((head, tail)) = rest.split_once("::") {
            let model = *self.scopes[scope].frames.get(head)?;
            scope = self.scopes.iter().position(|known| known.own == model)?;
            rest = tail;
        }
        match rest {
            "__model__" => Some(self.scopes[scope].own),
            rest => self.scopes[scope].frames.get(rest).copied(),
        }
    }

    /// The frame that a name means; reports one that means none.
    pub(super) fn named(&mut self, scope: usize, (name, place): (&str, &Place)) -> Option<FrameId> {
        let found = self.find(scope, name);
        if found.is_none() {
            let help = suggestion(name, self.scopes[scope].frames.keys().map(String::as_str));
            let message = format!("no link or frame is called `{}`", short(name));
            self.job.error(codes::UNKNOWN_NAME, message, (place, "not in this model"), &help);
        }
        found
    }

    /// Finds where all frames are in the world.
    pub(super) fn resolve(&mut self) {
        // The frame that each one is relative to.
        for idx in 1..self.frames.len() {
            let frame = self.frames[idx].clone();
            let around = if frame.scope == usize::MAX { None } else { Some(frame.scope) };
            let own = around.map_or(FrameId::WORLD, |scope| self.scopes[scope].own);
            let word = match frame.of {
                Of::Joint | Of::Plain => frame.relative_to.clone().or(frame.attached_to.clone()),
                _ => frame.relative_to.clone(),
            };
            let base = match (word, around) {
                (Some((name, place)), Some(scope)) => self.named(scope, (&name, &place)),
                _ => Some(own),
            };
            self.frames[idx].base = base;
        }
        for idx in 1..self.frames.len() {
            self.place_model(idx);
        }
        for idx in 1..self.frames.len() {
            self.resolve_one(idx);
        }
    }

    /// A model whose pose is stated by one of its frames.
    fn place_model(&mut self, idx: usize) {
        let Some((name, place)) = self.frames[idx].placed_by.clone() else { return };
        let Some(scope) = self.scopes.iter().position(|scope| scope.own == FrameId(idx)) else {
            return;
        };
        let Some(frame) = self.named(scope, (&name, &place)) else { return };
        let mut in_model = Pose::NONE;
        let mut at = frame;
        for _ in 0..self.frames.len() {
            if at == FrameId(idx) {
                self.frames[idx].pose = self.frames[idx].pose.then(in_model.inverse());
                return;
            }
            in_model = self.frames[at.0].pose.then(in_model);
            let Some(base) = self.frames[at.0].base else { return };
            at = base;
        }
    }

    fn resolve_one(&mut self, idx: usize) {
        let mut chain = Vec::new();
        let mut at = FrameId(idx);
        let known = loop {
            if let Some(world) = self.frames[at.0].world {
                break world;
            }
            if chain.len() > self.frames.len() {
                self.in_a_circle(idx);
                break Pose::NONE;
            }
            chain.push(at);
            match self.frames[at.0].base {
                Some(base) => at = base,
                None => break Pose::NONE,
            }
        };
        let mut world = known;
        for id in chain.into_iter().rev() {
            world = world.then(self.frames[id.0].pose);
            self.frames[id.0].world = Some(world);
        }
    }

    fn in_a_circle(&mut self, idx: usize) {
        let frame = self.frames[idx].clone();
        let Some(node) = frame.node else { return };
        let place = self.place(node);
        let message = format!("the pose of `{}` follows from itself", short(&frame.name));
        let help = "give one of the poses `relative_to=\"__model__\"`";
        self.job.error(
            codes::CIRCLE,
            message,
            (&place, "by `relative_to` and `attached_to`"),
            help,
        );
    }

    pub(super) fn world(&self, frame: FrameId) -> Pose {
        self.frames[frame.0].world.unwrap_or(Pose::NONE)
    }

    /// The link that a frame moves with; `None` for the world.
    pub(super) fn link_of(&self, frame: FrameId) -> Option<FrameId> {
        let mut at = frame;
        for _ in 0..=self.frames.len() {
            let frame = &self.frames[at.0];
            let next = match frame.of {
                Of::World => return None,
                Of::Link => return Some(at),
                Of::Model => {
                    let scope = self.scopes.iter().position(|scope| scope.own == at)?;
                    self.canonical(scope)
                }
                Of::Joint | Of::Plain => match &frame.attached_to {
                    Some((name, _)) => self.find(frame.scope, name),
                    None => self.canonical(frame.scope),
                },
            };
            at = next?;
        }
        None
    }

    /// The link that a model's own frame moves with.
    fn canonical(&self, scope: usize) -> Option<FrameId> {
        let of = &self.scopes[scope];
        let stated =
            self.tree.value(of.node, "canonical_link").and_then(|name| self.find(scope, name));
        let nested = || {
            let inner = self
                .scopes
                .iter()
                .find(|inner| inner.parent == Some(scope) && inner.first_link.is_some());
            inner.and_then(|inner| inner.first_link)
        };
        stated.or(of.first_link).or_else(nested)
    }
}
