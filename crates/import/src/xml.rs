//! XML as nodes with places.

use roxmltree::{Document, ParsingOptions};

use crate::codes;
use crate::job::{Job, Place};

/// Largest number of nodes of a document.
const MAX_NODES: u32 = 2_000_000;

/// Handle to a node of [`Tree`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct NodeId(pub(crate) usize);

/// An attribute with the place of its value.
#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub(crate) name: String,
    pub(crate) value: String,
    pub(crate) place: Place,
}

/// An element.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) tag: String,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) children: Vec<NodeId>,
    /// Text directly in the element.
    pub(crate) text: String,
    /// Place of the opening tag's name.
    pub(crate) place: Place,
}

/// Elements of one or several documents.
#[derive(Default, Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// Reads the file with index `file` of the job; returns its root element.
    pub(crate) fn read(&mut self, job: &mut Job<'_>, file: usize) -> Option<NodeId> {
        let text = job.sources[file].text.clone();
        let options =
            ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = match Document::parse_with_options(&text, options) {
            Ok(document) => document,
            Err(error) => {
                let (at, message) = fault_of(&text, &error);
                let place = Place { file, span: at..at };
                let help = "mend the file here: each element is closed, each value is in quotes";
                job.error(codes::NOT_XML, message, (&place, ""), help);
                return None;
            }
        };
        Some(self.take(&document, file))
    }

    /// Copies a document; parents come before their children.
    fn take(&mut self, document: &Document<'_>, file: usize) -> NodeId {
        let root = document.root_element();
        let mut open: Vec<(roxmltree::Node<'_, '_>, Option<NodeId>)> = vec![(root, None)];
        let first = NodeId(self.nodes.len());
        while let Some((node, parent)) = open.pop() {
            let id = NodeId(self.nodes.len());
            let start = node.range().start;
            let attribute = |of: roxmltree::Attribute<'_, '_>| Attribute {
                name: of.name().to_owned(),
                value: of.value().to_owned(),
                place: Place { file, span: of.range_value() },
            };
            let tag = node.tag_name().name();
            self.nodes.push(Node {
                tag: tag.to_owned(),
                attributes: node.attributes().map(attribute).collect(),
                children: Vec::new(),
                text: node.text().unwrap_or_default().trim().to_owned(),
                place: Place { file, span: start + 1..start + 1 + tag.len() },
            });
            if let Some(parent) = parent {
                self.nodes[parent.0].children.push(id);
            }
            // The last one is taken first, so they are put in from the end.
            let elements: Vec<_> = node.children().filter(roxmltree::Node::is_element).collect();
            open.extend(elements.into_iter().rev().map(|child| (child, Some(id))));
        }
        first
    }

    pub(crate) fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0]
    }

    pub(crate) fn node_mut(&mut self, id: NodeId) -> &mut Node {
        &mut self.nodes[id.0]
    }

    pub(crate) fn tag(&self, id: NodeId) -> &str {
        &self.nodes[id.0].tag
    }

    pub(crate) fn place(&self, id: NodeId) -> &Place {
        &self.nodes[id.0].place
    }

    pub(crate) fn children(&self, id: NodeId) -> Vec<NodeId> {
        self.nodes[id.0].children.clone()
    }

    /// The children with a tag.
    pub(crate) fn all(&self, id: NodeId, tag: &str) -> Vec<NodeId> {
        let children = self.nodes[id.0].children.iter();
        children.copied().filter(|&child| self.tag(child) == tag).collect()
    }

    /// The first child with a tag.
    pub(crate) fn child(&self, id: NodeId, tag: &str) -> Option<NodeId> {
        self.nodes[id.0].children.iter().copied().find(|&child| self.tag(child) == tag)
    }

    pub(crate) fn attribute(&self, id: NodeId, name: &str) -> Option<&Attribute> {
        self.nodes[id.0].attributes.iter().find(|attribute| attribute.name == name)
    }

    pub(crate) fn value(&self, id: NodeId, name: &str) -> Option<&str> {
        self.attribute(id, name).map(|attribute| attribute.value.as_str())
    }

    /// The text of a child element with its place, as SDF has most of its values.
    pub(crate) fn text_of(&self, id: NodeId, tag: &str) -> Option<(&str, &Place)> {
        self.child(id, tag).map(|child| (self.nodes[child.0].text.as_str(), self.place(child)))
    }
}

/// The message of an error of the library without the position at its end.
fn without_position(message: &str) -> &str {
    message.rsplit_once(" at ").map_or(message, |(head, _)| head)
}

/// Where a text is no XML, a byte, and why.
pub(crate) fn fault_of(text: &str, error: &roxmltree::Error) -> (usize, String) {
    let position = error.pos();
    let lines = text.split_inclusive('\n').take(position.row.saturating_sub(1) as usize);
    let line: usize = lines.map(str::len).sum();
    let mut columns = text[line.min(text.len())..].char_indices();
    let column = columns.nth(position.col.saturating_sub(1) as usize).map_or(0, |(at, _)| at);
    let message = format!("the file is not XML: {}", without_position(&error.to_string()));
    ((line + column).min(text.len()), message)
}
