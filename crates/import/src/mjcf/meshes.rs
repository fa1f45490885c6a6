//! Volumes and inertias of meshes from their files.
//!
//! ```text
//! V = Σ a·(b × c)/6,   ∫ r dV = Σ V (a + b + c)/4,   ∫ r rᵀ dV = Σ V/20 (s sᵀ + a aᵀ + b bᵀ + c cᵀ),   s = a + b + c
//! ```
//!
//! over tetrahedra from the origin to the faces.

use bksim_model::file::triangles;

use crate::codes;
use crate::job::short;
use crate::spatial::{Tensor, Vector, add, cross, dot, of_point, scale};

use super::Reader;
use super::bodies::Item;
use super::defaults::ClassId;

impl Reader<'_, '_> {
    /// Volume, centre and central tensor at density one of the mesh of a shape.
    pub(super) fn mesh_moments(
        &mut self,
        item: &Item,
        class: ClassId,
    ) -> Option<(f64, Vector, Tensor)> {
        let (name, place) = self.attribute(item.node, class, "mesh")?;
        let Some(&mesh) = self.meshes.get(&name) else {
            let help = crate::job::suggestion(&name, self.meshes.keys().map(String::as_str));
            let message = format!("no mesh is called `{}`", short(&name));
            self.job.error(codes::UNKNOWN_NAME, message, (&place, ""), &help);
            return None;
        };
        let mesh_class = self.class_of(mesh, ClassId::MAIN, "class");
        let size = self.vector(mesh, mesh_class, "scale").unwrap_or([1.0; 3]);
        let file = self.tree.value(mesh, "file").unwrap_or_default().to_owned();
        let faces = match self.mesh_faces(&file) {
            Ok(faces) => faces,
            Err(why) => {
                let message = format!("the mesh `{}` {why}", short(&file));
                let place = self.tree.place(mesh).clone();
                let help = "put the file there, or give the body an `inertial`; until then this shape has no mass";
                self.job.warn(codes::NO_FILE, message, (&place, "a mass follows from it"), help);
                return None;
            }
        };
        let scaled = |corner: Vector| std::array::from_fn(|i| size[i] * corner[i]);
        Some(moments(faces.into_iter().map(|face| face.map(scaled))))
    }

    fn mesh_faces(&self, file: &str) -> Result<Vec<[Vector; 3]>, String> {
        let base = file.rsplit(['/', '\\']).next().unwrap_or_default();
        let file = if self.compiler.strips_paths { base } else { file };
        let folder = self.compiler.mesh_folder.trim_end_matches('/');
        let path = if folder.is_empty() { file.to_owned() } else { format!("{folder}/{file}") };
        let bytes = self.job.bytes(&path).ok_or_else(|| "is not there".to_owned())?;
        let faces = triangles(&path, &bytes)?;
        // Files of STL have single precision, and MuJoCo takes it as it is.
        #[expect(clippy::cast_possible_truncation, reason = "the numbers were single ones")]
        let single = |x: f64| f64::from(x as f32);
        Ok(faces.into_iter().map(|face| face.map(|corner| corner.map(single))).collect())
    }
}

fn moments(faces: impl Iterator<Item = [Vector; 3]>) -> (f64, Vector, Tensor) {
    let (mut volume, mut first) = (0.0, [0.0; 3]);
    let mut second = [0.0; 6];
    for [a, b, c] in faces {
        let part = dot(a, cross(b, c)) / 6.0;
        let sum = add(a, add(b, c));
        volume += part;
        first = add(first, scale(part / 4.0, sum));
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        for (entry, (i, j)) in second.iter_mut().zip(pairs) {
            *entry += part / 20.0 * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]);
        }
    }
    if volume == 0.0 {
        return (0.0, [0.0; 3], [0.0; 6]);
    }
    let com = scale(1.0 / volume, first);
    let [xx, yy, zz, xy, yz, zx] = second;
    let about_origin = [yy + zz, xx + zz, xx + yy, -xy, -yz, -zx];
    let moved = of_point(volume, com);
    (volume.abs(), com, std::array::from_fn(|k| (about_origin[k] - moved[k]) * volume.signum()))
}

#[cfg(test)]
mod tests {
    use super::moments;

    #[test]
    fn a_box_away_from_the_origin_has_its_volume_and_inertia() {
        let corner = |k: usize| {
            [1.0 + (k & 1) as f64, 2.0 * ((k >> 1) & 1) as f64, 3.0 * ((k >> 2) & 1) as f64]
        };
        let faces = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        let (volume, com, tensor) = moments(faces.into_iter().map(|face| face.map(corner)));
        assert!((volume - 6.0).abs() < 1e-12, "{volume}");
        assert!((com[0] - 1.5).abs() < 1e-12 && (com[2] - 1.5).abs() < 1e-12, "{com:?}");
        // m (b² + c²)/12.
        let expected = [6.5, 5.0, 2.5, 0.0, 0.0, 0.0];
        assert!(tensor.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{tensor:?}");
    }
}
