//! MJCF: bodies within bodies, whose joints move them one after the other.
//!
//! A joint turns or shifts the body's frame about or along an axis of this frame, from the place that the file states
//! (`qpos0`), where its coordinate has the value `ref`. A body with several joints becomes a chain of bodies without
//! mass. Equalities are soft in MuJoCo; here `connect` and `weld` are joints that close loops, and equalities of
//! joints and tendons are exact relations.

mod actuators;
mod bodies;
mod defaults;
mod equality;
mod inertia;
mod joints;
mod meshes;
mod orientation;
mod tendons;

use std::collections::BTreeMap;

use crate::codes;
use crate::draft::Draft;
use crate::job::{Job, Place, short};
use crate::names::Names;
use crate::spatial::{Pose, Vector};
use crate::urdf::GRAVITY;
use crate::xml::{NodeId, Tree};
use defaults::{ClassId, Defaults};

/// Most files that include each other.
const MAX_INCLUDES: usize = 500;

/// The settings of `compiler`.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an attribute of the format")]
struct Compiler {
    in_degrees: bool,
    euler: Vec<char>,
    has_auto_limits: bool,
    /// `None` for `auto`.
    from_geoms: Option<bool>,
    total_mass: Option<f64>,
    bound_mass: f64,
    bound_inertia: f64,
    is_balanced: bool,
    groups: [f64; 2],
    mesh_folder: String,
    strips_paths: bool,
}

impl Default for Compiler {
    fn default() -> Self {
        Self {
            in_degrees: true,
            euler: vec!['x', 'y', 'z'],
            has_auto_limits: true,
            from_geoms: None,
            total_mass: None,
            bound_mass: 0.0,
            bound_inertia: 0.0,
            is_balanced: false,
            groups: [0.0, 5.0],
            mesh_folder: String::new(),
            strips_paths: false,
        }
    }
}

/// A body of the file.
#[derive(Clone, Debug)]
struct MadeBody {
    /// Index in the draft.
    body: usize,
    /// Pose at `qpos0` in the world.
    world: Pose,
}

/// A joint of the file that has one motion or several.
#[derive(Clone, Debug)]
struct MadeJoint {
    name: String,
    /// `hinge`, `slide`, `ball` or `free`.
    kind: String,
    /// Coordinate in the file's pose.
    reference: f64,
}

/// A tendon that is a sum of coordinates.
#[derive(Clone, Debug)]
struct FixedTendon {
    /// Joints and their coefficients.
    parts: Vec<(MadeJoint, f64)>,
}

struct Reader<'r, 'a> {
    job: &'r mut Job<'a>,
    names: &'r mut Names,
    tree: Tree,
    draft: Draft,
    compiler: Compiler,
    defaults: Defaults,
    gravity: Vector,
    bodies: BTreeMap<String, MadeBody>,
    joints: BTreeMap<String, MadeJoint>,
    sites: BTreeMap<String, (Option<usize>, Pose)>,
    tendons: BTreeMap<String, FixedTendon>,
    meshes: BTreeMap<String, NodeId>,
}

/// Reads the model at `root`.
pub(crate) fn draft(job: &mut Job<'_>, names: &mut Names, mut tree: Tree, root: NodeId) -> Draft {
    include_files(job, &mut tree, root);
    let name = tree.value(root, "model").unwrap_or("model").to_owned();
    let heading = vec![
        format!("From {}, a model in MJCF.", job.sources[0].name),
        "Metres, kilograms, seconds and radians. The frame of a body is that of the file."
            .to_owned(),
        "Coordinates of joints count as in MuJoCo, from `ref` in the file's pose.".to_owned(),
    ];
    let draft = Draft { name, heading, is_relative: true, ..Draft::default() };
    let mut reader = Reader {
        job,
        names,
        tree,
        draft,
        compiler: Compiler::default(),
        defaults: Defaults::default(),
        gravity: GRAVITY,
        bodies: BTreeMap::new(),
        joints: BTreeMap::new(),
        sites: BTreeMap::new(),
        tendons: BTreeMap::new(),
        meshes: BTreeMap::new(),
    };
    reader.settings(root);
    reader.defaults(root);
    reader.all_bodies(root);
    reader.scale_masses();
    reader.draft.gravity = Some(reader.gravity);
    reader.all_tendons(root);
    reader.all_equalities(root);
    reader.all_actuators(root);
    reader.rest(root);
    reader.draft
}

/// Puts the contents of included files in the place of `include`.
fn include_files(job: &mut Job<'_>, tree: &mut Tree, root: NodeId) {
    let mut open = vec![(root, 0)];
    let mut n_read = 0;
    while let Some((node, depth)) = open.pop() {
        let mut children = Vec::new();
        for child in tree.children(node) {
            if tree.tag(child) != "include" {
                children.push(child);
                open.push((child, depth));
                continue;
            }
            n_read += 1;
            let included = included(job, tree, child, (depth, n_read));
            for part in included.map(|root| tree.children(root)).unwrap_or_default() {
                children.push(part);
            }
        }
        // What was included may include, too.
        let has_more = children.iter().any(|&child| tree.tag(child) == "include");
        tree.node_mut(node).children = children;
        if has_more {
            open.push((node, depth + 1));
        }
    }
}

/// The root of an included file.
fn included(
    job: &mut Job<'_>,
    tree: &mut Tree,
    node: NodeId,
    (depth, n_read): (usize, usize),
) -> Option<NodeId> {
    let place = tree.place(node).clone();
    let Some(file) = tree.attribute(node, "file").cloned() else {
        job.error(
            codes::MISSING,
            "`include` has no `file`".to_owned(),
            (&place, ""),
            "write `<include file=\"…\"/>`",
        );
        return None;
    };
    if depth > 50 || n_read > MAX_INCLUDES {
        let message = format!("`{}` is included without end", short(&file.value));
        job.error(
            codes::CIRCLE,
            message,
            (&file.place, ""),
            "let no file include itself, also by way of others",
        );
        return None;
    }
    // From the folder of the main file, else from that of the file that includes.
    let own = job.sources[place.file].name.clone();
    let own_folder = own.rsplit_once('/').map_or("", |(folder, _)| folder);
    let candidates = [file.value.clone(), format!("{own_folder}/{}", file.value)];
    let Some((name, bytes)) =
        candidates.into_iter().find_map(|name| Some((name.clone(), job.bytes(&name)?)))
    else {
        let message = format!("there is no file `{}`", short(&file.value));
        let help = "put the file there; its place is seen from the folder of the first file";
        job.error(codes::NO_FILE, message, (&file.place, "included here"), help);
        return None;
    };
    let file = job.add(&name, &bytes);
    tree.read(job, file)
}

impl Reader<'_, '_> {
    /// An attribute of an element, or else of its class.
    fn attribute(&self, node: NodeId, class: ClassId, name: &str) -> Option<(String, Place)> {
        let own = self.tree.attribute(node, name);
        let found =
            own.or_else(|| self.defaults.attribute(&self.tree, class, self.tree.tag(node), name));
        found.map(|found| (found.value.clone(), found.place.clone()))
    }

    fn word(&self, node: NodeId, class: ClassId, name: &str) -> Option<String> {
        self.attribute(node, class, name).map(|(value, _)| value)
    }

    fn numbers(&mut self, node: NodeId, class: ClassId, name: &str) -> Option<Vec<f64>> {
        let (value, place) = self.attribute(node, class, name)?;
        self.job.numbers(&value, &place, &format!("`{name}`"))
    }

    fn number(&mut self, node: NodeId, class: ClassId, name: &str) -> Option<f64> {
        self.numbers(node, class, name)?.first().copied()
    }

    fn vector(&mut self, node: NodeId, class: ClassId, name: &str) -> Option<Vector> {
        let (value, place) = self.attribute(node, class, name)?;
        self.job.exactly::<3>(&value, &place, &format!("`{name}`"))
    }

    /// An angle of the file in radians.
    fn radians(&self, angle: f64) -> f64 {
        if self.compiler.in_degrees { angle.to_radians() } else { angle }
    }

    /// The class of an element: its own, or else that of the elements around it.
    fn class_of(&mut self, node: NodeId, around: ClassId, key: &str) -> ClassId {
        let Some(found) = self.tree.attribute(node, key).cloned() else { return around };
        if let Some(class) = self.defaults.find(&found.value) {
            return class;
        }
        let help = crate::job::suggestion(&found.value, self.defaults.names());
        let message = format!("no default class is called `{}`", short(&found.value));
        self.job.error(codes::UNKNOWN_NAME, message, (&found.place, ""), &help);
        around
    }

    /// Names an element as the file does, or by its place.
    fn label(&self, node: NodeId) -> String {
        let tag = self.tree.tag(node);
        self.tree.value(node, "name").map_or_else(|| tag.to_owned(), |name| format!("{tag} {name}"))
    }

    fn leave_out(&mut self, node: NodeId) {
        let what = self.label(node);
        let place = self.tree.place(node).clone();
        self.job.leave_out(what, &place);
    }

    /// `compiler` and `option`.
    fn settings(&mut self, root: NodeId) {
        for node in self.tree.all(root, "compiler") {
            self.compiler_settings(node);
        }
        for node in self.tree.all(root, "option") {
            let main = ClassId::MAIN;
            if let Some(gravity) = self.vector(node, main, "gravity") {
                self.gravity = gravity;
            }
            for key in ["density", "viscosity", "wind"] {
                if let Some(found) = self.tree.attribute(node, key).cloned() {
                    self.job.leave_out(format!("{key} of the fluid around"), &found.place);
                }
            }
            for flag in self.tree.all(node, "flag") {
                if self.tree.value(flag, "gravity") == Some("disable") {
                    self.gravity = [0.0; 3];
                }
            }
        }
    }

    fn compiler_settings(&mut self, node: NodeId) {
        let main = ClassId::MAIN;
        let word = |reader: &Self, key: &str| reader.tree.value(node, key).map(str::to_owned);
        if let Some(angle) = word(self, "angle") {
            self.compiler.in_degrees = angle != "radian";
        }
        if let Some(euler) = word(self, "eulerseq") {
            self.compiler.euler = euler.chars().collect();
        }
        if let Some(auto) = word(self, "autolimits") {
            self.compiler.has_auto_limits = auto == "true";
        }
        if let Some(from) = word(self, "inertiafromgeom") {
            self.compiler.from_geoms = (from != "auto").then_some(from == "true");
        }
        if let Some(balance) = word(self, "balanceinertia") {
            self.compiler.is_balanced = balance == "true";
        }
        for key in ["assetdir", "meshdir"] {
            if let Some(folder) = word(self, key) {
                self.compiler.mesh_folder = folder;
            }
        }
        if let Some(strips) = word(self, "strippath") {
            self.compiler.strips_paths = strips == "true";
        }
        if let Some(total) = self.number(node, main, "settotalmass").filter(|total| *total > 0.0) {
            self.compiler.total_mass = Some(total);
        }
        self.compiler.bound_mass =
            self.number(node, main, "boundmass").unwrap_or(self.compiler.bound_mass);
        self.compiler.bound_inertia =
            self.number(node, main, "boundinertia").unwrap_or(self.compiler.bound_inertia);
        if let Some([least, most]) = self.numbers(node, main, "inertiagrouprange").as_deref() {
            self.compiler.groups = [*least, *most];
        }
        if word(self, "coordinate").as_deref() == Some("global") {
            let place = self.tree.place(node).clone();
            let help =
                "save the model once with a MuJoCo before 2.3.4, which writes local coordinates";
            let message = "global coordinates are no longer part of MJCF".to_owned();
            self.job.error(codes::UNKNOWN_WORD, message, (&place, ""), help);
        }
    }

    /// Everything else is left out by name.
    fn rest(&mut self, root: NodeId) {
        const USED: [&str; 7] =
            ["compiler", "option", "default", "worldbody", "equality", "tendon", "actuator"];
        for section in self.tree.children(root) {
            match self.tree.tag(section) {
                used if USED.contains(&used) => (),
                "contact" | "sensor" | "keyframe" | "deformable" => {
                    for child in self.tree.children(section) {
                        self.leave_out(child);
                    }
                }
                "asset" => {
                    for mesh in self.tree.all(section, "mesh") {
                        let file = self.tree.value(mesh, "file").unwrap_or_default().to_owned();
                        let place = self.tree.place(mesh).clone();
                        self.job.leave_out(format!("mesh {file}"), &place);
                    }
                }
                _ => self.leave_out(section),
            }
        }
    }
}
