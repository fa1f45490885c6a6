//! Vectors, rotations and poses as numbers.
//!
//! Poses read from right to left: `x_a_from_b` takes coordinates in b to those in a. Quaternions are w, x, y, z.

use nalgebra::Matrix3;

/// Three components.
pub(crate) type Vector = [f64; 3];

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(s: f64, a: Vector) -> Vector {
    a.map(|c| s * c)
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The unit vector along `a`; `None` of a vector without direction.
pub(crate) fn unit(a: Vector) -> Option<Vector> {
    let length = norm(a);
    (length > 0.0 && length.is_finite()).then(|| scale(1.0 / length, a))
}

/// A unit vector across `a`.
pub(crate) fn across(a: Vector) -> Vector {
    let least = (0..3).min_by(|&i, &j| a[i].abs().total_cmp(&a[j].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    unit(cross(a, axis)).unwrap_or([1.0, 0.0, 0.0])
}

/// Size below which parts of a rotation are rounding.
const ROUNDING: f64 = 1e-15;

/// A rotation as a unit quaternion w, x, y, z.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Rotation(pub(crate) [f64; 4]);

impl Rotation {
    pub(crate) const NONE: Self = Self([1.0, 0.0, 0.0, 0.0]);

    /// The rotation of a quaternion of any length; `None` of length zero.
    pub(crate) fn of_quaternion(q: [f64; 4]) -> Option<Self> {
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        (length > 0.0 && length.is_finite()).then(|| Self(q.map(|c| c / length)))
    }

    /// The turn by an angle, rad, about a unit axis.
    pub(crate) fn about(axis: Vector, angle: f64) -> Self {
        let (s, c) = (angle / 2.0).sin_cos();
        Self([c, s * axis[0], s * axis[1], s * axis[2]])
    }

    /// Rz(yaw) Ry(pitch) Rx(roll).
    pub(crate) fn of_rpy([roll, pitch, yaw]: Vector) -> Self {
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self::about(z, yaw).then(Self::about(y, pitch)).then(Self::about(x, roll))
    }

    /// The rotation whose matrix has these columns, which are perpendicular unit vectors.
    pub(crate) fn of_axes([x, y, z]: [Vector; 3]) -> Self {
        let trace = x[0] + y[1] + z[2];
        let q = if trace > 0.0 {
            [1.0 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]]
        } else if x[0] >= y[1] && x[0] >= z[2] {
            [y[2] - z[1], 1.0 + x[0] - y[1] - z[2], x[1] + y[0], z[0] + x[2]]
        } else if y[1] >= z[2] {
            [z[0] - x[2], x[1] + y[0], 1.0 + y[1] - x[0] - z[2], y[2] + z[1]]
        } else {
            [x[1] - y[0], z[0] + x[2], y[2] + z[1], 1.0 + z[2] - x[0] - y[1]]
        };
        Self::of_quaternion(q).unwrap_or(Self::NONE)
    }

    /// The smallest turn that takes z to the direction `to`.
    pub(crate) fn z_to(to: Vector) -> Self {
        let Some(to) = unit(to) else { return Self::NONE };
        if to[2] < -1.0 + 1e-15 {
            return Self([0.0, 1.0, 0.0, 0.0]);
        }
        Self::of_quaternion([1.0 + to[2], -to[1], to[0], 0.0]).unwrap_or(Self::NONE)
    }

    /// This rotation after `inner`: the product of their matrices.
    pub(crate) fn then(self, inner: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, inner.0);
        Self([
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ])
    }

    pub(crate) fn inverse(self) -> Self {
        let [w, x, y, z] = self.0;
        Self([w, -x, -y, -z])
    }

    /// Columns of the matrix.
    pub(crate) fn axes(self) -> [Vector; 3] {
        let [w, x, y, z] = self.0;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    pub(crate) fn apply(self, v: Vector) -> Vector {
        let axes = self.axes();
        std::array::from_fn(|i| axes[0][i] * v[0] + axes[1][i] * v[1] + axes[2][i] * v[2])
    }

    /// True where it turns nothing, up to rounding.
    pub(crate) fn is_none(self) -> bool {
        self.0[1..].iter().all(|c| c.abs() < ROUNDING)
    }
}

/// A position and a rotation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Pose {
    pub(crate) at: Vector,
    pub(crate) turn: Rotation,
}

impl Pose {
    pub(crate) const NONE: Self = Self { at: [0.0; 3], turn: Rotation::NONE };

    pub(crate) fn at(at: Vector) -> Self {
        Self { at, turn: Rotation::NONE }
    }

    /// This pose after `inner`: `x_a_from_b.then(x_b_from_c)` is `x_a_from_c`.
    pub(crate) fn then(self, inner: Self) -> Self {
        Self { at: add(self.at, self.turn.apply(inner.at)), turn: self.turn.then(inner.turn) }
    }

    pub(crate) fn inverse(self) -> Self {
        let turn = self.turn.inverse();
        Self { at: scale(-1.0, turn.apply(self.at)), turn }
    }

    pub(crate) fn apply(self, p: Vector) -> Vector {
        add(self.at, self.turn.apply(p))
    }
}

/// A symmetric tensor xx, yy, zz, xy, yz, zx with its off-diagonal entries.
pub(crate) type Tensor = [f64; 6];

/// R I Rᵀ.
pub(crate) fn turned(turn: Rotation, tensor: Tensor) -> Tensor {
    if turn.is_none() {
        return tensor;
    }
    let [xx, yy, zz, xy, yz, zx] = tensor;
    let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    let axes = turn.axes();
    let r = |i: usize, k: usize| axes[k][i];
    let entry = |i: usize, j: usize| -> f64 {
        let pairs = (0..3).flat_map(|k| (0..3).map(move |l| (k, l)));
        pairs.map(|(k, l)| r(i, k) * rows[k][l] * r(j, l)).sum()
    };
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(2, 0)]
}

/// The tensor of a mass at `arm` about the origin.
pub(crate) fn of_point(mass: f64, [x, y, z]: Vector) -> Tensor {
    let [xx, yy, zz] = [y * y + z * z, x * x + z * z, x * x + y * y];
    [xx, yy, zz, -x * y, -y * z, -z * x].map(|entry| mass * entry)
}

/// The mass, centre of mass and central tensor of a body, in the axes of its frame.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct Inertia {
    pub(crate) mass: f64,
    pub(crate) com: Vector,
    pub(crate) tensor: Tensor,
}

impl Inertia {
    /// A part in a frame of its own, as seen from the frame that has it at `pose`.
    pub(crate) fn seen(self, pose: Pose) -> Self {
        let com = pose.apply(self.com);
        Self { mass: self.mass, com, tensor: turned(pose.turn, self.tensor) }
    }

    /// All parts as one body.
    pub(crate) fn sum(parts: &[Self]) -> Self {
        let mass: f64 = parts.iter().map(|part| part.mass).sum();
        if mass == 0.0 || parts.len() == 1 {
            return parts.first().copied().unwrap_or_default();
        }
        let moment = parts.iter().fold([0.0; 3], |sum, part| add(sum, scale(part.mass, part.com)));
        let com = scale(1.0 / mass, moment);
        let mut tensor = [0.0; 6];
        for part in parts {
            let steiner = of_point(part.mass, sub(part.com, com));
            for (entry, (own, moved)) in tensor.iter_mut().zip(part.tensor.iter().zip(steiner)) {
                *entry += own + moved;
            }
        }
        Self { mass, com, tensor }
    }

    /// Why no body has these numbers; `None` where one can.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        const ROUNDING: f64 = 1e-9;
        let [least, middle, largest] = principal_moments(self.tensor);
        if self.mass < 0.0 {
            Some("the mass is negative")
        } else if least < -ROUNDING * largest.abs() {
            Some("a principal moment is negative")
        } else if largest > (least + middle) * (1.0 + ROUNDING) {
            Some("one principal moment exceeds the sum of the other two")
        } else {
            None
        }
    }
}

/// A tensor whose principal moments are at least `least`, about the same axes.
pub(crate) fn with_least_moment([xx, yy, zz, xy, yz, zx]: Tensor, least: f64) -> Tensor {
    let mut found = Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz).symmetric_eigen();
    found.eigenvalues.apply(|moment| *moment = moment.max(least));
    let m = found.recompose();
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(0, 2)]]
}

/// Principal moments in ascending order, by Jacobi's rotations.
pub(crate) fn principal_moments([xx, yy, zz, xy, yz, zx]: Tensor) -> Vector {
    let mut a = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    for _ in 0..60 {
        let pairs = [(0, 1), (1, 2), (0, 2)];
        let (p, q) = pairs
            .into_iter()
            .max_by(|&(i, j), &(k, l)| a[i][j].abs().total_cmp(&a[k][l].abs()))
            .unwrap_or((0, 1));
        let size = a[0][0].abs() + a[1][1].abs() + a[2][2].abs();
        if a[p][q].abs() <= 1e-18 * size {
            break;
        }
        let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let t = if theta == 0.0 { 1.0 } else { t };
        let c = 1.0 / (t * t + 1.0).sqrt();
        let s = t * c;
        let mut turn = [[0.0; 3]; 3];
        for (i, row) in turn.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        (turn[p][p], turn[q][q], turn[p][q], turn[q][p]) = (c, c, s, -s);
        let times = |m: [[f64; 3]; 3], n: [[f64; 3]; 3]| -> [[f64; 3]; 3] {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..3).map(|k| m[i][k] * n[k][j]).sum())
            })
        };
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| turn[j][i]));
        a = times(transposed, times(a, turn));
    }
    let mut moments = [a[0][0], a[1][1], a[2][2]];
    moments.sort_by(f64::total_cmp);
    moments
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: &[f64], b: &[f64]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14), "{a:?} is not {b:?}");
    }

    #[test]
    fn rpy_turns_about_the_fixed_axes_in_their_order() {
        let turn = Rotation::of_rpy([0.1, 0.2, 0.3]);
        let expected = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let [z, y, x] = expected.map(|axis| axis);
        let step =
            Rotation::about(z, 0.3).then(Rotation::about(y, 0.2)).then(Rotation::about(x, 0.1));
        close(&turn.0, &step.0);
        // The last row of Rz Ry Rx.
        let axes = turn.axes();
        close(&[axes[0][2]], &[-0.2_f64.sin()]);
        close(&Rotation::of_axes(axes).0, &turn.0);
    }

    #[test]
    fn z_is_taken_to_a_direction() {
        for to in [[0.3, -0.4, 0.5], [0.0, 0.0, -2.0], [0.0, 0.0, 1.0]] {
            close(&Rotation::z_to(to).apply([0.0, 0.0, 1.0]), &unit(to).expect("a direction"));
        }
    }

    #[test]
    fn a_turned_tensor_keeps_its_principal_moments() {
        let tensor = [2.0, 3.0, 4.0, 0.2, -0.1, 0.3];
        let turn = Rotation::of_rpy([0.4, -1.1, 2.0]);
        close(&principal_moments(turned(turn, tensor)), &principal_moments(tensor));
        close(&principal_moments([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]), &[1.0, 2.0, 3.0]);
    }

    #[test]
    fn two_halves_of_a_rod_are_the_rod() {
        // m l²/12 about the middle.
        let half = |x| Inertia {
            mass: 1.0,
            com: [x, 0.0, 0.0],
            tensor: [0.0, 1.0 / 12.0, 1.0 / 12.0, 0.0, 0.0, 0.0],
        };
        let rod = Inertia::sum(&[half(0.5), half(1.5)]);
        close(&rod.com, &[1.0, 0.0, 0.0]);
        close(&rod.tensor, &[0.0, 2.0 * 4.0 / 12.0, 2.0 * 4.0 / 12.0, 0.0, 0.0, 0.0]);
    }
}
