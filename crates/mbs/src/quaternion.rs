//! [`Quaternion`]: a rotation by four numbers, the Euler parameters, which have no pole.
//!
//! ```text
//! e = (e0, e1, e2, e3) = (cos θ/2, n sin θ/2)          s = 2 / e·e, which is 2 at unit length
//! R = ½ s G Eᵀ,   ω = s G ė (outer axes) = s E ė (inner axes),   ω̇ = s (E ë − (e·ė) ω)
//!
//!     [ −e1   e0   e3  −e2 ]        [ −e1   e0  −e3   e2 ]
//! E = [ −e2  −e3   e0   e1 ]    G = [ −e2   e3   e0  −e1 ]
//!     [ −e3   e2  −e1   e0 ]        [ −e3  −e2   e1   e0 ]
//! ```
//!
//! With s the rotation depends on the direction of e alone: R is orthogonal and ω its rate at every length
//! of e, not only where e·e = 1. A rotation then moves nothing along e, so that generalised forces and
//! constraint rows have no part there, and the multiplier of e·e = 1 is zero.
//!
//! Source: P. E. Nikravesh, *Computer-Aided Analysis of Mechanical Systems* (1988), §6.1 to §6.3, at unit
//! length.

use bksim_expr::{Expr, Pool};

use bksim_model::Vector;

/// A quaternion that is not zero, scalar part first.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Quaternion(pub [Expr; 4]);

impl Quaternion {
    /// The turn by `angle` (rad) about the unit vector `axis`.
    pub fn about(pool: &Pool, axis: &Vector, angle: Expr) -> Self {
        let half = pool.mul(pool.rational(1, 2), angle);
        let (cos, sin) = (pool.cos(half), pool.sin(half));
        let [x, y, z] = axis.map(|part| pool.mul(sin, part));
        Self([cos, x, y, z])
    }

    /// No turn.
    pub fn identity(pool: &Pool) -> Self {
        Self([pool.one(), pool.zero(), pool.zero(), pool.zero()])
    }

    /// `self` followed, in the turned frame, by `inner`: Hamilton's product.
    #[must_use]
    pub fn then(&self, pool: &Pool, inner: &Self) -> Self {
        let ([a, b, c, d], [w, x, y, z]) = (self.0, inner.0);
        let sum = |terms: [(Expr, Expr); 4], signs: [i64; 4]| {
            let products = terms.into_iter().zip(signs);
            let products = products.map(|((a, b), sign)| pool.product([pool.int(sign), a, b]));
            pool.sum(products.collect::<Vec<_>>())
        };
        Self([
            sum([(a, w), (b, x), (c, y), (d, z)], [1, -1, -1, -1]),
            sum([(a, x), (b, w), (c, z), (d, y)], [1, 1, 1, -1]),
            sum([(a, y), (b, z), (c, w), (d, x)], [1, -1, 1, 1]),
            sum([(a, z), (b, y), (c, x), (d, w)], [1, 1, -1, 1]),
        ])
    }

    /// The opposite rotation.
    #[must_use]
    pub fn inverse(&self, pool: &Pool) -> Self {
        let [w, vector @ ..] = self.0;
        let [x, y, z] = vector.map(|part| pool.neg(part));
        Self([w, x, y, z])
    }

    /// e·e.
    pub fn square(&self, pool: &Pool) -> Expr {
        self.dot(pool, &self.0)
    }

    /// e·u.
    pub fn dot(&self, pool: &Pool, u: &[Expr; 4]) -> Expr {
        dot(pool, &self.0, u)
    }

    /// s = 2 / e·e.
    pub fn scale(&self, pool: &Pool) -> Expr {
        pool.div(pool.int(2), self.square(pool))
    }

    /// Rows of R, with s or a name for it.
    pub fn matrix(&self, pool: &Pool, s: Expr) -> [Vector; 3] {
        let e = self.0;
        let product = |i: usize, j: usize| pool.mul(e[i], e[j]);
        // 1 − s (e_j² + e_k²) on the diagonal, elsewhere s (e_i e_j ∓ e_0 e_k).
        std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                if row == column {
                    let (j, k) = (1 + (row + 1) % 3, 1 + (row + 2) % 3);
                    let squares = pool.add(product(j, j), product(k, k));
                    return pool.sub(pool.one(), pool.mul(s, squares));
                }
                let k = 3 - row - column;
                let both = product(1 + row, 1 + column);
                let twist = product(0, 1 + k);
                let is_cyclic = (row + 1) % 3 == column;
                let entry = if is_cyclic { pool.sub(both, twist) } else { pool.add(both, twist) };
                pool.mul(s, entry)
            })
        })
    }

    /// E u.
    pub fn to_inner_rate(&self, pool: &Pool, u: &[Expr; 4]) -> Vector {
        self.inner_rows(pool).map(|row| dot(pool, &row, u))
    }

    /// G u.
    pub fn to_outer_rate(&self, pool: &Pool, u: &[Expr; 4]) -> Vector {
        let [e0, e1, e2, e3] = self.0;
        let [m1, m2, m3] = [e1, e2, e3].map(|e| pool.neg(e));
        [[m1, e0, m3, e2], [m2, e3, e0, m1], [m3, m2, e1, e0]].map(|row| dot(pool, &row, u))
    }

    /// Rows of E.
    pub fn inner_rows(&self, pool: &Pool) -> [[Expr; 4]; 3] {
        let [e0, e1, e2, e3] = self.0;
        let [m1, m2, m3] = [e1, e2, e3].map(|e| pool.neg(e));
        [[m1, e0, e3, m2], [m2, m3, e0, e1], [m3, e2, m1, e0]]
    }
}

fn dot(pool: &Pool, a: &[Expr; 4], b: &[Expr; 4]) -> Expr {
    let products = a.iter().zip(b).map(|(&a, &b)| pool.mul(a, b));
    pool.sum(products.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of an expression of e0 … e3 and their rates.
    fn value(pool: &Pool, e: Expr) -> f64 {
        let of = |name: &str| match name {
            "e0" => Some(0.3),
            "e1" => Some(-0.8),
            "e2" => Some(0.5),
            "e3" => Some(1.1),
            "v0" => Some(0.7),
            "v1" => Some(0.2),
            "v2" => Some(-0.4),
            "v3" => Some(0.9),
            _ => None,
        };
        pool.evaluate(e, &|symbol| of(&pool.symbol_name(symbol))).expect("a value")
    }

    #[test]
    fn the_rates_are_those_of_the_rotation_at_every_length() {
        let pool = Pool::new();
        let e = ["e0", "e1", "e2", "e3"].map(|name| pool.symbol(name));
        let v = ["v0", "v1", "v2", "v3"].map(|name| pool.symbol(name));
        let q = Quaternion(e);
        let s = q.scale(&pool);
        let r = q.matrix(&pool, s);
        let rates: Vec<_> =
            e.iter().zip(v).map(|(&e, v)| (pool.symbol_id(e).expect("a symbol"), v)).collect();
        let [outer, inner] = [q.to_outer_rate(&pool, &v), q.to_inner_rate(&pool, &v)]
            .map(|rate| rate.map(|part| value(&pool, pool.mul(s, part))));
        let number = r.map(|row| row.map(|entry| value(&pool, entry)));
        let rate = r.map(|row| row.map(|entry| value(&pool, pool.total_derivative(entry, &rates))));
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| number[i][k] * number[j][k]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14, "R Rᵀ = 1");
                // Ṙ = ω̃ R.
                let crossed = outer[(i + 1) % 3] * number[(i + 2) % 3][j]
                    - outer[(i + 2) % 3] * number[(i + 1) % 3][j];
                assert!((rate[i][j] - crossed).abs() < 1e-14, "{i} {j}");
            }
            let turned: f64 = (0..3).map(|k| number[i][k] * inner[k]).sum();
            assert!((turned - outer[i]).abs() < 1e-14, "ω = R ω′");
        }
    }

    #[test]
    fn products_are_turns_one_after_the_other() {
        let pool = Pool::new();
        let [zero, one] = [pool.zero(), pool.one()];
        let quarter = pool.mul(pool.rational(1, 2), pool.pi());
        let z = Quaternion::about(&pool, &[zero, zero, one], quarter);
        let x = Quaternion::about(&pool, &[one, zero, zero], quarter);
        let both = z.then(&pool, &x);
        let matrix = both.matrix(&pool, both.scale(&pool));
        let matrix = matrix.map(|row| row.map(|entry| value(&pool, entry)));
        // Rz(90°) Rx(90°): x to y, y to z, z to x.
        for (i, row) in matrix.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let expected = f64::from(u8::from(i == (j + 1) % 3));
                assert!((entry - expected).abs() < 1e-15, "{matrix:?}");
            }
        }
    }
}
