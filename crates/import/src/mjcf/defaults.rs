//! Default classes: attributes that elements have unless they state them.

use crate::codes;
use crate::job::short;
use crate::xml::{Attribute, NodeId, Tree};

use super::Reader;

/// Elements of actuators, which share their defaults.
pub(super) const ACTUATORS: [&str; 10] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
];

/// Handle to a class of [`Defaults`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct ClassId(usize);

impl ClassId {
    /// The class of all elements.
    pub(super) const MAIN: Self = Self(0);
}

struct Class {
    name: String,
    parent: Option<ClassId>,
    /// Elements with attributes, those written last at the end.
    elements: Vec<NodeId>,
}

/// All classes.
pub(super) struct Defaults {
    classes: Vec<Class>,
}

impl Default for Defaults {
    fn default() -> Self {
        let main = Class { name: "main".to_owned(), parent: None, elements: Vec::new() };
        Self { classes: vec![main] }
    }
}

impl Defaults {
    pub(super) fn find(&self, name: &str) -> Option<ClassId> {
        self.classes.iter().position(|class| class.name == name).map(ClassId)
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.classes.iter().map(|class| class.name.as_str())
    }

    /// A class and those around it.
    pub(super) fn chain(&self, class: ClassId) -> impl Iterator<Item = ClassId> + '_ {
        std::iter::successors(Some(class), |class| self.classes[class.0].parent)
    }

    /// The elements of one class with a tag, the last one first.
    pub(super) fn own<'t>(
        &'t self,
        tree: &'t Tree,
        class: ClassId,
        tag: &'t str,
    ) -> impl Iterator<Item = NodeId> + 't {
        let is_actuator = ACTUATORS.contains(&tag);
        let fits = move |id: &&NodeId| {
            let known = tree.tag(**id);
            known == tag || is_actuator && ACTUATORS.contains(&known)
        };
        self.classes[class.0].elements.iter().rev().filter(fits).copied()
    }

    /// An attribute of the elements with a tag in a class.
    pub(super) fn attribute<'t>(
        &'t self,
        tree: &'t Tree,
        class: ClassId,
        tag: &'t str,
        name: &str,
    ) -> Option<&'t Attribute> {
        let mut elements = self.chain(class).flat_map(|class| self.own(tree, class, tag));
        elements.find_map(|id| tree.attribute(id, name))
    }
}

impl Reader<'_, '_> {
    /// Reads all classes of the file.
    pub(super) fn defaults(&mut self, root: NodeId) {
        let mut open: Vec<(NodeId, Option<ClassId>)> =
            self.tree.all(root, "default").into_iter().map(|node| (node, None)).collect();
        open.reverse();
        while let Some((node, parent)) = open.pop() {
            for extra in self.tree.node(node).attributes.clone() {
                if extra.name != "class" {
                    let message = format!("`default` has no attribute `{}`", short(&extra.name));
                    let help = "remove it; the model is imported without it";
                    self.job.warn(codes::UNKNOWN_WORD, message, (&extra.place, "not used"), help);
                }
            }
            let name = self.tree.value(node, "class").map(str::to_owned);
            let class = match (name, parent) {
                (Some(name), None) => {
                    self.defaults.classes[0].name = name;
                    ClassId::MAIN
                }
                (None, None) => ClassId::MAIN,
                (name, Some(parent)) => {
                    let name = name.unwrap_or_default();
                    self.defaults.classes.push(Class {
                        name,
                        parent: Some(parent),
                        elements: Vec::new(),
                    });
                    ClassId(self.defaults.classes.len() - 1)
                }
            };
            let children = self.tree.children(node);
            let (nested, elements): (Vec<_>, Vec<_>) =
                children.into_iter().partition(|&child| self.tree.tag(child) == "default");
            self.defaults.classes[class.0].elements.extend(elements);
            open.extend(nested.into_iter().rev().map(|child| (child, Some(class))));
        }
    }
}
