//! Links as bodies.

use crate::draft::{Body, Table, list};
use crate::job::short;
use crate::shapes::Solid;
use crate::spatial::{Inertia, Pose, scale, turned};
use crate::xml::NodeId;

use super::frames::{FrameId, Of};
use super::{Link, Reader};

/// Density of shapes that state none, kg/m³.
const WATER: f64 = 1000.0;

/// Shapes that have a volume.
const SOLIDS: [&str; 5] = ["box", "sphere", "cylinder", "capsule", "ellipsoid"];

impl Reader<'_, '_> {
    pub(super) fn all_links(&mut self) {
        for idx in 0..self.frames.len() {
            let frame = self.frames[idx].clone();
            let (Of::Link, Some(node)) = (frame.of, frame.node) else { continue };
            let scope = &self.scopes[frame.scope];
            let written = format!("{}{}", scope.prefix, frame.name);
            let is_static = scope.is_static;
            let name = self.names.take("body", &written);
            let mut body = Body::new(name, self.inertia(node));
            if self.tree.child(node, "inertial").is_none() {
                body.notes
                    .push("without `inertial` in the file: SDF takes 1 kg and 1 kg m^2".to_owned());
            }
            body.place = Some(self.place(self.tree.child(node, "inertial").unwrap_or(node)));
            for child in self.tree.children(node) {
                match self.tree.tag(child) {
                    "visual" => self.visual(child, &written, &mut body),
                    "inertial" | "pose" | "gravity" | "self_collide" | "kinematic"
                    | "velocity_decay" | "enable_wind" | "must_be_base_link" => (),
                    _ => self.leave_out(child, &format!("link {written}")),
                }
            }
            self.links.push(Link {
                frame: FrameId(idx),
                body: self.draft.bodies.len(),
                is_static,
                written,
            });
            self.draft.bodies.push(body);
            if self.is_true(node, "gravity") == Some(false) {
                self.lift();
            }
        }
    }

    /// The last body weighs nothing: a force at its centre takes its weight.
    fn lift(&mut self) {
        let body = self.draft.bodies.len() - 1;
        let (name, inertia) =
            (self.draft.bodies[body].name.clone(), self.draft.bodies[body].inertia);
        if inertia.mass == 0.0 || self.gravity == [0.0; 3] {
            return;
        }
        let at = self.draft.frame(Some(body), "com", Pose::at(inertia.com));
        let force = list(&scale(-inertia.mass, self.gravity));
        let load = self.names.coin(&format!("{name}_lift"));
        let table = Table::new(load, "force").text("on", &at).key("vector", force);
        self.draft.loads.push(table.note("gravity is off for this link in the file"));
    }

    fn inertia(&mut self, link: NodeId) -> Inertia {
        let unit = Inertia { mass: 1.0, com: [0.0; 3], tensor: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0] };
        let Some(inertial) = self.tree.child(link, "inertial") else { return unit };
        if matches!(self.tree.value(inertial, "auto"), Some("true" | "1")) {
            return self.inertia_of_shapes(link, inertial).unwrap_or(unit);
        }
        let (pose, _) = self.pose(inertial);
        let mass = self.number(inertial, "mass").unwrap_or(1.0);
        let mut tensor = unit.tensor;
        if let Some(inertia) = self.tree.child(inertial, "inertia") {
            for (entry, key) in tensor.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "iyz", "ixz"]) {
                *entry = self.number(inertia, key).unwrap_or(*entry);
            }
        }
        Inertia { mass, com: pose.at, tensor: turned(pose.turn, tensor) }
    }

    /// The inertia of the shapes with which a link collides, each with its density, that of the link, or that of water.
    fn inertia_of_shapes(&mut self, link: NodeId, inertial: NodeId) -> Option<Inertia> {
        let common = self.number(inertial, "density").unwrap_or(WATER);
        let mut parts = Vec::new();
        for collision in self.tree.children(link) {
            if self.tree.tag(collision) != "collision" {
                continue;
            }
            let density = self.number(collision, "density").unwrap_or(common);
            let (pose, _) = self.pose(collision);
            let Some(geometry) = self.tree.child(collision, "geometry") else { continue };
            for shape in self.tree.children(geometry) {
                let Some(solid) = self.solid(shape).filter(|solid| solid.is_solid()) else {
                    self.leave_out(shape, "the inertia of its link");
                    continue;
                };
                parts.push(solid.inertia(density * solid.volume()).seen(pose));
            }
        }
        // A mass that is stated scales the inertia of the shapes.
        let mut found = (!parts.is_empty()).then(|| Inertia::sum(&parts))?;
        if let Some(mass) = self.number(inertial, "mass") {
            let share = mass / found.mass;
            found = Inertia { mass, tensor: found.tensor.map(|entry| share * entry), ..found };
        }
        Some(found)
    }

    /// A shape of a geometry; `None` of one that is no solid.
    fn solid(&mut self, shape: NodeId) -> Option<Solid> {
        let of = |reader: &mut Self, tag: &str| reader.number(shape, tag).unwrap_or(0.0);
        match self.tree.tag(shape) {
            "box" => self
                .vector(shape, "size")
                .map(|size| Solid::Box { half: size.map(|side| side / 2.0) }),
            "sphere" => Some(Solid::Sphere { radius: of(self, "radius") }),
            "cylinder" => {
                Some(Solid::Cylinder { radius: of(self, "radius"), half: of(self, "length") / 2.0 })
            }
            "capsule" => {
                Some(Solid::Capsule { radius: of(self, "radius"), half: of(self, "length") / 2.0 })
            }
            "ellipsoid" => self.vector(shape, "radii").map(|radii| Solid::Ellipsoid { radii }),
            _ => None,
        }
    }

    fn visual(&mut self, visual: NodeId, link: &str, body: &mut Body) {
        let (pose, _) = self.pose(visual);
        let Some(geometry) = self.tree.child(visual, "geometry") else { return };
        for shape in self.tree.children(geometry) {
            let solid = self.solid(shape);
            if solid.is_none() {
                let tag = self.tree.tag(shape);
                if !SOLIDS.contains(&tag) {
                    let uri = self
                        .tree
                        .text_of(shape, "uri")
                        .map_or(String::new(), |(text, _)| short(text));
                    let what = format!("{tag} {uri} of link {link}");
                    let place = self.place(shape);
                    self.job.leave_out(what, &place);
                }
            }
            if let Some(solid) = solid.filter(|solid| solid.is_solid()) {
                body.shapes.extend(solid.drawn(pose));
            }
        }
    }
}
