//! Bodies bounded by triangles, and their mass properties.
//!
//! By the divergence theorem the integrals over the solid are sums over its faces: each triangle (a, b, c) makes,
//! with a fixed point o, a tetrahedron of signed volume v = (a − o) · (b − o) × (c − o)/6, and with
//! s = a + b + c (from o)
//!
//! ```text
//! V = Σ v,    ∫ x dV = Σ v s/4,    ∫ x xᵀ dV = Σ v (s sᵀ + a aᵀ + b bᵀ + c cᵀ)/20
//! ```

use std::collections::{BTreeMap, HashMap};

/// Volumes below this part of the box around the mesh are rounding.
const FLAT: f64 = 1e-12;

/// Triangles between corners; of a closed mesh the corners of each are counter-clockwise as seen from outside.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Mesh {
    /// Corners, m.
    pub corners: Vec<[f64; 3]>,
    /// Faces by the indices of their corners.
    pub faces: Vec<[usize; 3]>,
}

/// Integrals over the solid that a mesh encloses, of density one.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MeshMoments {
    /// V, m³.
    pub volume: f64,
    /// The centre of mass, m.
    pub middle: [f64; 3],
    /// The inertia tensor about the centre of mass, m⁵.
    pub inertia: [[f64; 3]; 3],
}

impl MeshMoments {
    /// Moments of an empty mesh.
    pub const NONE: Self = Self { volume: 0.0, middle: [0.0; 3], inertia: [[0.0; 3]; 3] };
}

/// The reason why a mesh encloses no volume.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum MeshFault {
    /// There is a face on one side only of the edge between two points, m.
    Open([[f64; 3]; 2]),
    /// Faces do not agree at the edge between two points, m, on which side of them is outside.
    Turned([[f64; 3]; 2]),
    /// All faces are turned over: the volume, m³, is below zero.
    InsideOut(f64),
    /// The volume is zero.
    Flat,
}

impl Mesh {
    /// The mesh of triangles whose equal corners are one; triangles without an area of their own, two of their
    /// corners being equal, are left out.
    pub fn of_triangles(triangles: impl IntoIterator<Item = [[f64; 3]; 3]>) -> Self {
        let mut mesh = Self::default();
        let mut known: HashMap<[u64; 3], usize> = HashMap::new();
        for triangle in triangles {
            let face = triangle.map(|corner| {
                // −0 and 0 are one place.
                let corner = corner.map(|x| x + 0.0);
                *known.entry(corner.map(f64::to_bits)).or_insert_with(|| {
                    mesh.corners.push(corner);
                    mesh.corners.len() - 1
                })
            });
            let [a, b, c] = face;
            if a != b && b != c && c != a {
                mesh.faces.push(face);
            }
        }
        mesh
    }

    /// Volume, middle and inertia of the solid inside.
    ///
    /// # Errors
    /// [`MeshFault`] where the faces do not enclose a volume, or do not agree on which side of them it is.
    pub fn moments(&self) -> Result<MeshMoments, MeshFault> {
        self.check_edges()?;
        let [low, high] = self.bounds();
        let size: [f64; 3] = std::array::from_fn(|i| high[i] - low[i]);
        let origin: [f64; 3] = std::array::from_fn(|i| low[i] + 0.5 * size[i]);

        // Sums over the tetrahedra, from the middle of the box around the mesh.
        let (mut volume, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
        for face in &self.faces {
            let corners =
                face.map(|k| std::array::from_fn::<f64, 3, _>(|i| self.corners[k][i] - origin[i]));
            let [a, b, c] = corners;
            let v = (0..3)
                .map(|i| a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3]))
                .sum::<f64>()
                / 6.0;
            volume += v;
            let sum: [f64; 3] = std::array::from_fn(|i| a[i] + b[i] + c[i]);
            for i in 0..3 {
                first[i] += 0.25 * v * sum[i];
                for (j, entry) in second[i].iter_mut().enumerate() {
                    let own: f64 = corners.iter().map(|p| p[i] * p[j]).sum();
                    *entry += 0.05 * v * (sum[i] * sum[j] + own);
                }
            }
        }
        if volume.abs() <= FLAT * size.iter().product::<f64>() || !volume.is_finite() {
            return Err(MeshFault::Flat);
        }
        if volume < 0.0 {
            return Err(MeshFault::InsideOut(volume));
        }

        // About the centre of mass: ∫ (x·x 1 − x xᵀ) dV.
        let arm = first.map(|x| x / volume);
        let about = |i: usize, j: usize| second[i][j] - volume * arm[i] * arm[j];
        let trace: f64 = (0..3).map(|i| about(i, i)).sum();
        let inertia = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { trace - about(i, i) } else { -about(i, j) })
        });
        Ok(MeshMoments { volume, middle: std::array::from_fn(|i| origin[i] + arm[i]), inertia })
    }

    /// Each edge is between two faces, which run along it in opposite directions; where more than two meet, as
    /// many run one way as the other.
    fn check_edges(&self) -> Result<(), MeshFault> {
        let mut balance: BTreeMap<[usize; 2], (i64, u32)> = BTreeMap::new();
        for &[a, b, c] in &self.faces {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let (net, count) = balance.entry([from.min(to), from.max(to)]).or_default();
                *net += if from < to { 1 } else { -1 };
                *count += 1;
            }
        }
        let Some((edge, (_, count))) = balance.into_iter().find(|(_, (net, _))| *net != 0) else {
            return Ok(());
        };
        let ends = edge.map(|k| self.corners[k]);
        Err(if count % 2 == 1 { MeshFault::Open(ends) } else { MeshFault::Turned(ends) })
    }

    /// Opposite corners of the box around the mesh.
    fn bounds(&self) -> [[f64; 3]; 2] {
        let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        self.corners.iter().fold(start, |[low, high], p| {
            [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
        })
    }
}
