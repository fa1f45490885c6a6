//! Vectors and rotations with expressions as components.
//!
//! A [`Rotation`] is a product of turns about fixed axes and by quaternions. Neighbouring turns about one
//! axis merge into one turn by the sum of their angles, so a mechanism whose axes are all parallel keeps a
//! single angle per body and its equations come out as short as if written in two dimensions.

use bksim_expr::{Expr, Pool};

use crate::quaternion::Quaternion;
use bksim_model::{FixedTurn, Vector};

/// Unit vector along z, the rotation axis of planar motion.
pub fn z_axis(pool: &Pool) -> Vector {
    [pool.zero(), pool.zero(), pool.one()]
}

/// Unit vectors along x, y and z.
pub fn axes(pool: &Pool) -> [Vector; 3] {
    let [zero, one] = [pool.zero(), pool.one()];
    [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
}

/// The zero vector.
pub fn zero(pool: &Pool) -> Vector {
    [pool.zero(); 3]
}

/// a + b.
pub fn add(pool: &Pool, a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| pool.add(a[i], b[i]))
}

/// a − b.
pub fn sub(pool: &Pool, a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| pool.sub(a[i], b[i]))
}

/// s a.
pub fn scale(pool: &Pool, s: Expr, a: &Vector) -> Vector {
    a.map(|component| pool.mul(s, component))
}

/// −a.
pub fn neg(pool: &Pool, a: &Vector) -> Vector {
    a.map(|component| pool.neg(component))
}

/// a · b.
pub fn dot(pool: &Pool, a: &Vector, b: &Vector) -> Expr {
    pool.sum((0..3).map(|i| pool.mul(a[i], b[i])).collect::<Vec<_>>())
}

/// a × b.
pub fn cross(pool: &Pool, a: &Vector, b: &Vector) -> Vector {
    let minor = |i: usize, j: usize| pool.sub(pool.mul(a[i], b[j]), pool.mul(a[j], b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// Two unit vectors perpendicular to the unit vector `n` and to each other, right-handed with it: `(k × n, n × (k × n))`
/// with k = z, so that an axis in the plane gives its in-plane normal first and z second.
pub fn perpendicular(pool: &Pool, n: &Vector) -> [Vector; 2] {
    if pool.is_zero(n[0]) && pool.is_zero(n[1]) {
        let [zero, one] = [pool.zero(), pool.one()];
        return [[one, zero, zero], [zero, n[2], zero]];
    }
    // z × n is normal to n; it has unit length only when n lies in the plane z = 0.
    let sideways = [pool.neg(n[1]), n[0], pool.zero()];
    if pool.is_zero(n[2]) {
        return [sideways, z_axis(pool)];
    }
    let length = pool.sqrt(pool.add(pool.mul(n[0], n[0]), pool.mul(n[1], n[1])));
    let first = scale(pool, pool.div(pool.one(), length), &sideways);
    let second = cross(pool, n, &first);
    [first, second]
}

/// A part of a rotation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Turn {
    /// By an angle about a fixed axis.
    About {
        /// Unit vector.
        axis: Vector,
        /// rad.
        angle: Expr,
    },
    /// By a quaternion.
    By(Quaternion),
}

/// A product of turns, read left to right: the first is the outermost.
#[derive(Clone, Debug, Default)]
pub struct Rotation {
    turns: Vec<Turn>,
    /// Columns of the matrices of all turns up to the fourth, up to the fifth, and so on: a product of
    /// many turns is then as long as the matrix before it and one turn.
    matrices: Vec<[Vector; 3]>,
}

/// The product of fixed turns.
pub fn turned(pool: &Pool, turns: &[FixedTurn]) -> Rotation {
    turns.iter().fold(Rotation::default(), |rotation, turn| {
        rotation.then(pool, &Rotation::about(pool, &turn.axis, turn.angle))
    })
}

/// Quaternions of rotations, one asked for after the other: the turns that a rotation begins with as the one before
/// it are not multiplied again, so that those of the bodies of a chain take time in proportion to their number.
#[derive(Debug, Default)]
pub struct Quaternions {
    /// The turns of the last rotation, each with the product of all up to it.
    products: Vec<(Turn, Quaternion)>,
}

impl Quaternions {
    /// The quaternion of a rotation, one of the two, of unit length where all of its parts are.
    pub fn of(&mut self, pool: &Pool, rotation: &Rotation) -> Quaternion {
        let turns = rotation.turns();
        let alike = |((known, _), turn): &(&(Turn, Quaternion), &Turn)| known == *turn;
        let n_known = self.products.iter().zip(turns).take_while(alike).count();
        self.products.truncate(n_known);
        for turn in &turns[n_known..] {
            let before = self.products.last().map(|(_, product)| *product);
            let before = before.unwrap_or_else(|| Quaternion::identity(pool));
            self.products.push((turn.clone(), before.then(pool, &turn.quaternion(pool))));
        }
        let whole = self.products.last().map(|(_, product)| *product);
        whole.unwrap_or_else(|| Quaternion::identity(pool))
    }
}

/// Number of turns that are applied one after the other; more are applied as a matrix.
const MAX_CHAINED_TURNS: usize = 3;

impl Rotation {
    /// A single turn.
    pub fn about(pool: &Pool, axis: &Vector, angle: Expr) -> Self {
        let mut rotation = Self::default();
        rotation.push(pool, Turn::About { axis: *axis, angle });
        rotation
    }

    /// The rotation by a quaternion.
    pub fn by(pool: &Pool, quaternion: Quaternion) -> Self {
        let mut rotation = Self::default();
        rotation.push(pool, Turn::By(quaternion));
        rotation
    }

    /// `self` followed, in the turned frame, by `inner`: r_a_from_c = r_a_from_b r_b_from_c.
    #[must_use]
    pub fn then(&self, pool: &Pool, inner: &Self) -> Self {
        let mut product = self.clone();
        for turn in &inner.turns {
            product.push(pool, turn.clone());
        }
        product
    }

    /// The opposite rotation.
    #[must_use]
    pub fn inverse(&self, pool: &Pool) -> Self {
        let mut inverse = Self::default();
        for turn in self.turns.iter().rev() {
            inverse.push(pool, turn.inverse(pool));
        }
        inverse
    }

    /// The turns, outermost first.
    pub fn turns(&self) -> &[Turn] {
        &self.turns
    }

    /// The angle when this is a rotation about `axis` alone.
    pub fn angle_about(&self, pool: &Pool, axis: &Vector) -> Option<Expr> {
        match self.turns.as_slice() {
            [] => Some(pool.zero()),
            [Turn::About { axis: own, angle }] if own == axis => Some(*angle),
            [Turn::About { axis: own, angle }] if *own == neg(pool, axis) => Some(pool.neg(*angle)),
            _ => None,
        }
    }

    /// The quaternion of the whole rotation, one of the two, of unit length where all of its parts are.
    pub fn quaternion(&self, pool: &Pool) -> Quaternion {
        Quaternions::default().of(pool, self)
    }

    /// Rows of R.
    pub fn matrix(&self, pool: &Pool) -> [Vector; 3] {
        let columns = axes(pool).map(|axis| self.apply(pool, &axis));
        std::array::from_fn(|i| columns.map(|column| column[i]))
    }

    /// `R v`.
    pub fn apply(&self, pool: &Pool, v: &Vector) -> Vector {
        match self.matrices.last() {
            Some(columns) => combination(pool, columns, v),
            None => self.turns.iter().rev().fold(*v, |v, turn| turn.apply(pool, &v)),
        }
    }

    /// `Rᵀ v`.
    pub fn apply_inverse(&self, pool: &Pool, v: &Vector) -> Vector {
        match self.matrices.last() {
            Some(columns) => columns.map(|column| dot(pool, &column, v)),
            None => self.inverse(pool).apply(pool, v),
        }
    }

    fn push(&mut self, pool: &Pool, turn: Turn) {
        let merged = match (self.turns.last(), &turn) {
            (Some(Turn::About { axis: a, angle: last }), Turn::About { axis: b, angle }) => {
                if a == b {
                    Some((*a, pool.add(*last, *angle)))
                } else if *a == neg(pool, b) {
                    Some((*a, pool.sub(*last, *angle)))
                } else {
                    None
                }
            }
            (Some(last), by) if last.inverse(pool) == *by => Some((z_axis(pool), pool.zero())),
            _ => None,
        };
        let turn = match merged {
            None => turn,
            Some((axis, angle)) => {
                self.turns.pop();
                self.matrices.truncate(self.turns.len().saturating_sub(MAX_CHAINED_TURNS));
                Turn::About { axis, angle }
            }
        };
        if !matches!(turn, Turn::About { angle, .. } if pool.is_zero(angle)) {
            self.append(pool, turn);
        }
    }

    /// Adds a turn that merges with none before it.
    fn append(&mut self, pool: &Pool, turn: Turn) {
        let unit =
            |i: usize| std::array::from_fn(|j| if i == j { pool.one() } else { pool.zero() });
        let turned = [0, 1, 2].map(|i| turn.apply(pool, &unit(i)));
        if self.turns.len() >= MAX_CHAINED_TURNS {
            self.matrices.push(turned.map(|column| self.apply(pool, &column)));
        }
        self.turns.push(turn);
    }
}

/// Σ v_j a_j of three columns.
fn combination(pool: &Pool, columns: &[Vector; 3], v: &Vector) -> Vector {
    std::array::from_fn(|i| {
        pool.sum((0..3).map(|j| pool.mul(columns[j][i], v[j])).collect::<Vec<_>>())
    })
}

impl Turn {
    fn inverse(&self, pool: &Pool) -> Self {
        match self {
            Self::About { axis, angle } => Self::About { axis: *axis, angle: pool.neg(*angle) },
            Self::By(quaternion) => Self::By(quaternion.inverse(pool)),
        }
    }

    fn quaternion(&self, pool: &Pool) -> Quaternion {
        match self {
            Self::About { axis, angle } => Quaternion::about(pool, axis, *angle),
            Self::By(quaternion) => *quaternion,
        }
    }

    /// Rodrigues' formula, R v = c v + s n × v + (1 − c) (n · v) n; about z the plain 2-D turn.
    fn apply(&self, pool: &Pool, v: &Vector) -> Vector {
        let (axis, angle) = match self {
            Self::About { axis, angle } => (axis, *angle),
            Self::By(quaternion) => {
                let rows = quaternion.matrix(pool, quaternion.scale(pool));
                return rows.map(|row| dot(pool, &row, v));
            }
        };
        let (s, c) = (pool.sin(angle), pool.cos(angle));
        if *axis == z_axis(pool) {
            return [
                pool.sub(pool.mul(c, v[0]), pool.mul(s, v[1])),
                pool.add(pool.mul(s, v[0]), pool.mul(c, v[1])),
                v[2],
            ];
        }
        let along = pool.mul(pool.sub(pool.one(), c), dot(pool, axis, v));
        let turned = add(pool, &scale(pool, c, v), &scale(pool, s, &cross(pool, axis, v)));
        add(pool, &turned, &scale(pool, along, axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_about_one_axis_merge_into_one_angle() {
        let pool = Pool::new();
        let (a, b) = (pool.symbol("a"), pool.symbol("b"));
        let z = z_axis(&pool);
        let outer = Rotation::about(&pool, &z, a);
        let both = outer.then(&pool, &Rotation::about(&pool, &z, b));
        assert_eq!(both.angle_about(&pool, &z), Some(pool.add(a, b)));
        let back = both.then(&pool, &both.inverse(&pool));
        assert!(back.turns().is_empty(), "R Rᵀ = 1");
    }

    #[test]
    fn rodrigues_about_x_is_the_elementary_matrix() {
        let pool = Pool::new();
        let a = pool.symbol("a");
        let [zero, one] = [pool.zero(), pool.one()];
        let turned = Rotation::about(&pool, &[one, zero, zero], a).apply(&pool, &[zero, one, zero]);
        assert_eq!(turned, [zero, pool.cos(a), pool.sin(a)]);
    }

    #[test]
    fn quaternions_asked_one_after_the_other_are_those_asked_alone() {
        let pool = Pool::new();
        let [x, y, z] = axes(&pool);
        let about = |axis: &Vector, name: &str| Rotation::about(&pool, axis, pool.symbol(name));
        let trunk = about(&x, "a").then(&pool, &about(&y, "b"));
        let branches =
            [about(&z, "c"), about(&x, "d"), about(&y, "e")].map(|turn| trunk.then(&pool, &turn));
        let mut quaternions = Quaternions::default();
        // A branch, one that is longer, what both have in common, one about the last axis, and none.
        let long = branches[0].then(&pool, &about(&x, "f"));
        let asked = [&branches[0], &long, &trunk, &branches[1], &branches[2], &Rotation::default()];
        for rotation in asked {
            let alone = rotation.turns().iter().fold(Quaternion::identity(&pool), |whole, turn| {
                whole.then(&pool, &turn.quaternion(&pool))
            });
            assert_eq!(quaternions.of(&pool, rotation), alone, "{} turns", rotation.turns().len());
        }
    }
}
