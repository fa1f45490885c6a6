//! The tree of bodies.

use crate::codes;
use crate::draft::{Body, Table, list, number};
use crate::job::short;
use crate::spatial::{Inertia, Pose, scale};
use crate::xml::NodeId;

use super::defaults::ClassId;
use super::{MadeBody, Reader};

/// A body to read: its element, its parent in the draft, the class around it, its frame's pose in the parent and the
/// parent's in the world.
struct Task {
    node: NodeId,
    parent: Option<usize>,
    class: ClassId,
    frame: Pose,
    world: Pose,
}

/// An element in a body with the class around it and the pose of the frames around it.
pub(super) struct Item {
    pub(super) node: NodeId,
    pub(super) class: ClassId,
    pub(super) frame: Pose,
}

impl Reader<'_, '_> {
    /// Reads all bodies, parents first, in the order of the file.
    pub(super) fn all_bodies(&mut self, root: NodeId) {
        for asset in self.tree.all(root, "asset") {
            for mesh in self.tree.all(asset, "mesh") {
                let file = self.tree.value(mesh, "file").unwrap_or_default();
                let stem = file.rsplit(['/', '\\']).next().unwrap_or_default();
                let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
                let name = self.tree.value(mesh, "name").unwrap_or(stem).to_owned();
                self.meshes.insert(name, mesh);
            }
        }
        let mut tasks = Vec::new();
        for world in self.tree.all(root, "worldbody") {
            let (items, found) = self.items(world, ClassId::MAIN);
            self.in_world(&items);
            tasks.extend(found.into_iter().map(|item| Task {
                node: item.node,
                parent: None,
                class: item.class,
                frame: item.frame,
                world: Pose::NONE,
            }));
        }
        tasks.reverse();
        let mut count = 0;
        while let Some(task) = tasks.pop() {
            count += 1;
            let inner = self.body(&task, count);
            tasks.extend(inner.into_iter().rev());
        }
    }

    /// Elements of a body with those in its frames, in order; bodies apart.
    fn items(&mut self, node: NodeId, class: ClassId) -> (Vec<Item>, Vec<Item>) {
        let (mut items, mut bodies) = (Vec::new(), Vec::new());
        let children = |reader: &Self, node: NodeId, class, frame| {
            let children = reader.tree.children(node).into_iter().rev();
            children.map(|node| Item { node, class, frame }).collect::<Vec<_>>()
        };
        let mut open = children(self, node, class, Pose::NONE);
        while let Some(item) = open.pop() {
            match self.tree.tag(item.node) {
                "body" => bodies.push(item),
                "frame" => {
                    let class = self.class_of(item.node, item.class, "childclass");
                    let frame = item.frame.then(self.pose(item.node, ClassId::MAIN));
                    open.extend(children(self, item.node, class, frame));
                }
                "replicate" | "composite" | "flexcomp" | "attach" | "flex" => {
                    self.generated(item.node);
                }
                _ => items.push(item),
            }
        }
        (items, bodies)
    }

    /// Elements that stand for many bodies.
    fn generated(&mut self, node: NodeId) {
        let tag = self.tree.tag(node).to_owned();
        let place = self.tree.place(node).clone();
        let message = format!("`{tag}` makes bodies that the model does not have");
        let help = "save the compiled model with MuJoCo (`mj_saveLastXML`), which writes them out, and import that";
        self.job.warn(codes::NOT_MODELLED, message, (&place, "left out"), help);
        self.leave_out(node);
    }

    /// Elements of the world itself: sites, and shapes that nothing is done with.
    fn in_world(&mut self, items: &[Item]) {
        for item in items {
            if self.tree.tag(item.node) == "site" {
                self.site(item, None);
            } else {
                self.leave_out(item.node);
            }
        }
    }

    fn site(&mut self, item: &Item, body: Option<usize>) {
        let class = self.class_of(item.node, item.class, "class");
        let pose = item.frame.then(self.pose(item.node, class));
        if let Some(name) = self.tree.value(item.node, "name") {
            self.sites.insert(name.to_owned(), (body, pose));
        }
    }

    /// Reads a body; returns the bodies in it.
    fn body(&mut self, task: &Task, count: usize) -> Vec<Task> {
        let class = self.class_of(task.node, task.class, "childclass");
        let pose = task.frame.then(self.pose(task.node, ClassId::MAIN));
        let written = self.tree.value(task.node, "name").map(str::to_owned);
        let name = match &written {
            Some(name) => self.names.take("body", name),
            None => self.names.coin(&format!("body{count}")),
        };
        if let Some(name) = written.as_ref().filter(|name| self.bodies.contains_key(*name)) {
            let message = format!("two bodies are called `{}`", short(name));
            let place = self.tree.place(task.node).clone();
            self.job.error(codes::TWICE, message, (&place, ""), "give each body a name of its own");
        }
        let (items, inner) = self.items(task.node, class);
        let of = |reader: &Self, tags: &[&str]| -> Vec<usize> {
            let indices = 0..items.len();
            indices.filter(|&idx| tags.contains(&reader.tree.tag(items[idx].node))).collect()
        };
        let joints: Vec<&Item> =
            of(self, &["joint", "freejoint"]).into_iter().map(|idx| &items[idx]).collect();
        let body = self.joints_of(&name, &joints, task.parent, pose);

        // Mass, shapes, sites.
        let (inertia, shapes) = self.inertia_of(&items);
        let made = &mut self.draft.bodies[body];
        made.inertia = inertia;
        made.shapes = shapes;
        made.place = Some(self.tree.place(task.node).clone());
        if written.is_none() {
            made.notes.push(format!("without a name in the file: its body {count}"));
        }
        for item in &items {
            match self.tree.tag(item.node) {
                "site" => self.site(item, Some(body)),
                "joint" | "freejoint" | "inertial" | "geom" => (),
                _ => self.leave_out(item.node),
            }
        }
        self.lift(task.node, body);
        let world = task.world.then(pose);
        self.bodies.insert(written.unwrap_or_else(|| name.clone()), MadeBody { body, world });
        let task_of = |item: Item| Task {
            node: item.node,
            parent: Some(body),
            class: item.class,
            frame: item.frame,
            world,
        };
        inner.into_iter().map(task_of).collect()
    }

    /// Gravity compensation as a force.
    fn lift(&mut self, node: NodeId, body: usize) {
        let Some(part) = self.number(node, ClassId::MAIN, "gravcomp").filter(|part| *part != 0.0)
        else {
            return;
        };
        let of = &self.draft.bodies[body];
        let (name, inertia) = (of.name.clone(), of.inertia);
        if inertia.mass == 0.0 || self.gravity == [0.0; 3] {
            return;
        }
        let at = self.draft.frame(Some(body), "com", Pose::at(inertia.com));
        let force = scale(-part * inertia.mass, self.gravity);
        let load = self.names.coin(&format!("{name}_lift"));
        let table = Table::new(load, "force").text("on", &at).key("vector", list(&force));
        self.draft.loads.push(table.note(format!("gravcomp {} of the file", number(part))));
    }

    /// A body of the draft without mass, for a joint among several.
    pub(super) fn massless(&mut self, name: &str, joint: &str) -> usize {
        let name = self.names.coin(&format!("{name}_after_{joint}"));
        let mut body = Body::new(name, Inertia::default());
        body.notes.push("between two joints of one body".to_owned());
        self.draft.bodies.push(body);
        self.draft.bodies.len() - 1
    }
}
