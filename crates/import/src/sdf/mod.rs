//! SDF: models within models, frames relative to each other, joints that may close loops.
//!
//! Coordinates are zero where the file has the bodies, so the frames of a joint on both bodies are that of the joint
//! in the file's pose. A link that is the child of two joints closes a loop; which joint becomes a constraint is left
//! to the model. Axes are in the frame of the joint unless they say `expressed_in`; up to version 1.4, and with
//! `use_parent_model_frame`, in that of the model.

mod frames;
mod joints;
mod links;

use std::collections::BTreeMap;

use crate::codes;
use crate::draft::Draft;
use crate::job::{Job, Place, short};
use crate::names::Names;
use crate::spatial::{Pose, Rotation, Vector};
use crate::urdf::GRAVITY;
use crate::xml::{NodeId, Tree};
use frames::{Frame, FrameId};

/// Deepest nesting of models, and most files that include each other.
const MAX_DEPTH: usize = 50;

/// A model: the names in it, and the frames that they are.
#[derive(Debug)]
struct Scope {
    /// Before the names in it: `arm::`.
    prefix: String,
    node: NodeId,
    parent: Option<usize>,
    frames: BTreeMap<String, FrameId>,
    /// The frame of the model itself.
    own: FrameId,
    is_static: bool,
    /// Links in the order of the file, and their frames.
    first_link: Option<FrameId>,
}

/// A link of the file.
#[derive(Debug)]
struct Link {
    frame: FrameId,
    /// Index in the draft.
    body: usize,
    is_static: bool,
    written: String,
}

struct Reader<'r, 'a> {
    job: &'r mut Job<'a>,
    names: &'r mut Names,
    tree: Tree,
    draft: Draft,
    /// 1.6 is 106.
    version: u32,
    scopes: Vec<Scope>,
    frames: Vec<Frame>,
    links: Vec<Link>,
    /// Motions of joints by their axes: frame of the joint, tag of the axis.
    motions: BTreeMap<(FrameId, String), Moving>,
    gravity: Vector,
    has_loops: bool,
}

/// The motion of one axis, and what it follows.
struct Moving {
    joint: String,
    /// The motion in expressions, and whether it is a length.
    scalar: (String, bool),
    mimic: Option<NodeId>,
}

/// Reads the models at `root`.
pub(crate) fn draft(job: &mut Job<'_>, names: &mut Names, tree: Tree, root: NodeId) -> Draft {
    let heading = vec![
        format!("From {}, a model in SDF.", job.sources[0].name),
        "Metres, kilograms, seconds and radians. The frame of a body is that of its link."
            .to_owned(),
        "Coordinates of joints are zero where the file has the bodies.".to_owned(),
    ];
    let draft = Draft { heading, is_relative: true, ..Draft::default() };
    let version = tree.value(root, "version").map_or(111, version_of);
    let mut reader = Reader {
        job,
        names,
        tree,
        draft,
        version,
        scopes: Vec::new(),
        frames: vec![Frame::world()],
        links: Vec::new(),
        motions: BTreeMap::new(),
        gravity: GRAVITY,
        has_loops: false,
    };
    reader.all_models(root);
    reader.resolve();
    if reader.job.has_errors() {
        return reader.draft;
    }
    reader.all_links();
    reader.all_joints();
    reader.all_mimics();
    reader.draft.gravity = Some(reader.gravity);
    reader.draft
}

/// `1.6` as 106.
fn version_of(text: &str) -> u32 {
    let (major, minor) = text.split_once('.').unwrap_or((text, "0"));
    let minor: u32 = minor.parse().unwrap_or(11);
    major.parse::<u32>().unwrap_or(1) * 100 + minor
}

impl Reader<'_, '_> {
    fn place(&self, node: NodeId) -> Place {
        self.tree.place(node).clone()
    }

    fn leave_out(&mut self, node: NodeId, of: &str) {
        let tag = self.tree.tag(node);
        let name = self.tree.value(node, "name").map_or(String::new(), |name| format!(" {name}"));
        let of = if of.is_empty() { String::new() } else { format!(" of {of}") };
        let what = format!("{tag}{name}{of}");
        let place = self.place(node);
        self.job.leave_out(what, &place);
    }

    /// The number in a child element.
    fn number(&mut self, node: NodeId, tag: &str) -> Option<f64> {
        let (text, place) = self.tree.text_of(node, tag)?;
        let (text, place) = (text.to_owned(), place.clone());
        // Limits may be infinite.
        if let Ok(value) = text.parse::<f64>() {
            return Some(value);
        }
        self.job.exactly::<1>(&text, &place, &format!("`{tag}`")).map(|[value]| value)
    }

    fn vector(&mut self, node: NodeId, tag: &str) -> Option<Vector> {
        let (text, place) = self.tree.text_of(node, tag)?;
        let (text, place) = (text.to_owned(), place.clone());
        self.job.exactly::<3>(&text, &place, &format!("`{tag}`"))
    }

    fn is_true(&self, node: NodeId, tag: &str) -> Option<bool> {
        self.tree.text_of(node, tag).map(|(text, _)| matches!(text, "true" | "1"))
    }

    /// The `pose` of an element and the frame that it is relative to.
    fn pose(&mut self, node: NodeId) -> (Pose, Option<(String, Place)>) {
        let Some(pose) = self.tree.child(node, "pose") else { return (Pose::NONE, None) };
        let place = self.place(pose);
        let relative =
            ["relative_to", "frame"].iter().find_map(|key| self.tree.attribute(pose, key));
        let relative = relative.filter(|of| !of.value.is_empty());
        let relative = relative.map(|of| (of.value.clone(), of.place.clone()));
        let text = self.tree.node(pose).text.clone();
        if text.is_empty() {
            return (Pose::NONE, relative);
        }
        let in_degrees = self.tree.value(pose, "degrees") == Some("true");
        let is_quaternion = self.tree.value(pose, "rotation_format") == Some("quat_xyzw");
        let pose = if is_quaternion {
            let numbers = self.job.exactly::<7>(&text, &place, "`pose`");
            numbers.map(|[x, y, z, i, j, k, w]| {
                let turn = Rotation::of_quaternion([w, i, j, k]).unwrap_or(Rotation::NONE);
                Pose { at: [x, y, z], turn }
            })
        } else {
            let numbers = self.job.exactly::<6>(&text, &place, "`pose`");
            numbers.map(|[x, y, z, roll, pitch, yaw]| {
                let rpy = [roll, pitch, yaw];
                let rpy = if in_degrees { rpy.map(f64::to_radians) } else { rpy };
                Pose { at: [x, y, z], turn: Rotation::of_rpy(rpy) }
            })
        };
        (pose.unwrap_or(Pose::NONE), relative)
    }

    /// Reads models, those in them and those that are included.
    fn all_models(&mut self, root: NodeId) {
        let mut open: Vec<(NodeId, Option<usize>, usize)> = Vec::new();
        let mut tops = Vec::new();
        match self.tree.tag(root) {
            "model" => tops.push(root),
            "world" => tops.extend(self.in_world(root)),
            _ => {
                for child in self.tree.children(root) {
                    match self.tree.tag(child) {
                        "model" | "include" => tops.push(child),
                        "world" => tops.extend(self.in_world(child)),
                        _ => self.leave_out(child, ""),
                    }
                }
            }
        }
        if let [only] = tops[..] {
            self.draft.name = self.tree.value(only, "name").unwrap_or("model").to_owned();
        } else {
            self.draft.name = self.tree.value(root, "name").unwrap_or("world").to_owned();
        }
        let is_single = tops.len() == 1;
        open.extend(tops.into_iter().rev().map(|node| (node, None, 0)));
        while let Some((node, parent, depth)) = open.pop() {
            if depth > MAX_DEPTH {
                let place = self.place(node);
                let help = "let no model include itself, also by way of others";
                self.job.error(
                    codes::CIRCLE,
                    "models are within each other without end".to_owned(),
                    (&place, ""),
                    help,
                );
                return;
            }
            let is_include = self.tree.tag(node) == "include";
            let model = if is_include { self.included(node) } else { Some(node) };
            let Some(model) = model else { continue };
            let scope = self.scope((node, model), parent, is_single && parent.is_none());
            let nested = self.contents(scope);
            open.extend(nested.into_iter().rev().map(|node| (node, Some(scope), depth + 1)));
        }
    }

    /// Models of a world, and its gravity.
    fn in_world(&mut self, world: NodeId) -> Vec<NodeId> {
        if let Some(gravity) = self.vector(world, "gravity") {
            self.gravity = gravity;
        }
        let mut models = Vec::new();
        for child in self.tree.children(world) {
            match self.tree.tag(child) {
                "model" | "include" => models.push(child),
                "gravity" => (),
                _ => self.leave_out(child, ""),
            }
        }
        models
    }

    /// The model of an included file.
    fn included(&mut self, node: NodeId) -> Option<NodeId> {
        let place = self.place(node);
        let uri =
            self.tree.text_of(node, "uri").map(|(text, _)| text.to_owned()).unwrap_or_default();
        let candidates = [uri.clone(), format!("{uri}/model.sdf")];
        let found =
            candidates.into_iter().find_map(|name| Some((name.clone(), self.job.bytes(&name)?)));
        let Some((name, bytes)) = found else {
            let message = format!("there is no model `{}`", short(&uri));
            let help = "say with `--path` where the folders of models are";
            self.job.error(codes::NO_FILE, message, (&place, "included here"), help);
            return None;
        };
        let file = self.job.add(&name, &bytes);
        let root = self.tree.read(self.job, file)?;
        let model = if self.tree.tag(root) == "model" {
            Some(root)
        } else {
            self.tree.child(root, "model")
        };
        if model.is_none() {
            let place = self.place(root);
            let help = "include a file with one `model`";
            self.job.error(
                codes::MISSING,
                "the included file has no `model`".to_owned(),
                (&place, ""),
                help,
            );
        }
        model
    }
}
