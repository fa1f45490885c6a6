//! The test problems: pendulum, car axis, Andrews' squeezer, slider-crank, a chain, stiff
//! equations.

use bksim_dae::Layout;

use super::dual::Real;
use super::mechanism::{Mechanism, Terms};
use super::reference::Reference;
use super::{Residual, uniform};

fn numbers<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::from(x)).collect()
}

fn diagonal<T: Real>(x: &[f64]) -> Vec<T> {
    let n = x.len();
    (0..n * n).map(|k| T::from(if k / n == k % n { x[k / n] } else { 0.0 })).collect()
}

/// Point mass on a rigid massless bar: `(x² + y² − L²)/2 = 0`.
pub struct Pendulum {
    pub m: f64,
    pub length: f64,
    pub g: f64,
}

impl Pendulum {
    pub fn from(data: &Reference) -> Self {
        Self { m: data.parameter("m"), length: data.parameter("L"), g: data.parameter("g") }
    }
}

impl Mechanism for Pendulum {
    fn nq(&self) -> usize {
        2
    }
    fn nc(&self) -> usize {
        1
    }
    fn terms<T: Real>(&self, _t: f64, q: &[T], _v: &[T]) -> Terms<T> {
        let squares = q[0] * q[0] + q[1] * q[1] - T::from(self.length * self.length);
        Terms {
            mass: diagonal(&[self.m, self.m]),
            force: numbers(&[0.0, -self.m * self.g]),
            constraint: vec![squares * T::from(0.5)],
            jacobian: q.to_vec(),
            constraint_rate: numbers(&[0.0]),
        }
    }
    fn acceleration_bias<T: Real>(&self, _t: f64, _q: &[T], v: &[T]) -> Vec<T> {
        vec![v[0] * v[0] + v[1] * v[1]]
    }
}

/// Car axis, with its multipliers as in the data file: stiff springs on a moving base.
pub struct CarAxis {
    pub data: Reference,
}

impl Mechanism for CarAxis {
    fn nq(&self) -> usize {
        4
    }
    fn nc(&self) -> usize {
        2
    }
    fn terms<T: Real>(&self, t: f64, q: &[T], _v: &[T]) -> Terms<T> {
        let p = |name| self.data.parameter(name);
        let k = p("M") * p("eps") * p("eps") / 2.0;
        let (l0, r, w) = (p("L0"), p("r"), p("w"));
        let weight = k * p("g");
        let length2 = p("L") * p("L");

        let yb = r * (w * t).sin();
        let xb = (length2 - yb * yb).sqrt();
        let yb_rate = r * w * (w * t).cos();
        let xb_rate = -yb * yb_rate / xb;
        let [xl, yl, xr, yr] = [q[0], q[1], q[2], q[3]];
        let (base_x, base_y) = (T::from(xb), T::from(yb));

        let left = (xl * xl + yl * yl).sqrt();
        let (dx, dy) = (xr - base_x, yr - base_y);
        let right = (dx * dx + dy * dy).sqrt();
        let spring_left = (T::from(l0) - left) / left;
        let spring_right = (T::from(l0) - right) / right;
        let (ex, ey) = (xl - xr, yl - yr);
        let two = T::from(2.0);
        let zero = T::from(0.0);
        Terms {
            mass: diagonal(&[k; 4]),
            force: vec![
                spring_left * xl,
                spring_left * yl - T::from(weight),
                spring_right * dx,
                spring_right * dy - T::from(weight),
            ],
            constraint: vec![xl * base_x + yl * base_y, ex * ex + ey * ey - T::from(length2)],
            // The data's multipliers have the opposite sign.
            jacobian: vec![
                base_x,
                base_y,
                zero,
                zero, //
                two * ex,
                two * ey,
                -two * ex,
                -two * ey,
            ],
            constraint_rate: vec![xl * T::from(xb_rate) + yl * T::from(yb_rate), zero],
        }
    }
}

/// Andrews' squeezing mechanism (HW2 §VII.7).
pub struct Andrews {
    pub data: Reference,
}

impl Andrews {
    fn mass<T: Real>(&self, q: &[T]) -> Vec<T> {
        let p = |name| self.data.parameter(name);
        let n = |x: f64| T::from(x);
        let (sin_ph, cos_th, sin_om) = (q[3].sin(), q[1].cos(), q[5].sin());
        let (da, rr, zt, u) = (p("da"), p("rr"), p("zt"), p("u"));
        let (e_ea, zf_fa) = (p("e") - p("ea"), p("zf") - p("fa"));
        let (m2, m4, m6) = (p("m2"), p("m4"), p("m6"));
        let mut m = vec![T::from(0.0); 49];
        let mut set = |row: usize, col: usize, value: T| {
            m[row * 7 + col] = value;
            m[col * 7 + row] = value;
        };
        let m11 = p("m1") * p("ra").powi(2) + m2 * (rr * rr + da * da) + p("i1") + p("i2");
        set(0, 0, n(m11) - n(2.0 * m2 * da * rr) * cos_th);
        set(1, 0, n(m2 * da * da + p("i2")) - n(m2 * da * rr) * cos_th);
        set(1, 1, n(m2 * da * da + p("i2")));
        set(2, 2, n(p("m3") * (p("sa").powi(2) + p("sb").powi(2)) + p("i3")));
        let m44 = m4 * e_ea * e_ea + p("i4");
        set(3, 3, n(m44));
        set(4, 3, n(m44) + n(m4 * zt * e_ea) * sin_ph);
        let fifth = m4 * (zt * zt + e_ea * e_ea)
            + p("m5") * (p("ta").powi(2) + p("tb").powi(2))
            + p("i4")
            + p("i5");
        set(4, 4, n(fifth) + n(2.0 * m4 * zt * e_ea) * sin_ph);
        let m66 = m6 * zf_fa * zf_fa + p("i6");
        set(5, 5, n(m66));
        set(6, 5, n(m66) - n(m6 * u * zf_fa) * sin_om);
        let seventh = m6 * (zf_fa * zf_fa + u * u)
            + p("m7") * (p("ua").powi(2) + p("ub").powi(2))
            + p("i6")
            + p("i7");
        set(6, 6, n(seventh) - n(2.0 * m6 * u * zf_fa) * sin_om);
        m
    }

    fn force<T: Real>(&self, q: &[T], v: &[T]) -> Vec<T> {
        let p = |name| self.data.parameter(name);
        let n = |x: f64| T::from(x);
        let two = n(2.0);
        let (sc, sd) = (n(p("sc")), n(p("sd")));
        let (sin_ga, cos_ga) = (q[2].sin(), q[2].cos());
        let dx = sd * cos_ga + sc * sin_ga + n(p("xb") - p("xc"));
        let dy = sd * sin_ga - sc * cos_ga + n(p("yb") - p("yc"));
        let length = (dx * dx + dy * dy).sqrt();
        let spring = -n(p("c0")) * (length - n(p("l0"))) / length;
        let (fx, fy) = (spring * dx, spring * dy);
        let c2 = n(p("m2") * p("da") * p("rr"));
        let c4 = n(p("m4") * p("zt") * (p("e") - p("ea")));
        let c6 = n(p("m6") * p("u") * (p("zf") - p("fa")));
        vec![
            n(p("mom")) - c2 * v[1] * (v[1] + two * v[0]) * q[1].sin(),
            c2 * v[0] * v[0] * q[1].sin(),
            fx * (sc * cos_ga - sd * sin_ga) + fy * (sd * cos_ga + sc * sin_ga),
            c4 * v[4] * v[4] * q[3].cos(),
            -c4 * v[3] * (v[3] + two * v[4]) * q[3].cos(),
            -c6 * v[6] * v[6] * q[5].cos(),
            c6 * v[5] * (v[5] + two * v[6]) * q[5].cos(),
        ]
    }
}

impl Mechanism for Andrews {
    fn nq(&self) -> usize {
        7
    }
    fn nc(&self) -> usize {
        6
    }
    fn terms<T: Real>(&self, _t: f64, q: &[T], v: &[T]) -> Terms<T> {
        let n = |name| T::from(self.data.parameter(name));
        let [rr, d, ss, e, zt, zf, u] = ["rr", "d", "ss", "e", "zt", "zf", "u"].map(n);
        let [xa, ya, xb, yb] = ["xa", "ya", "xb", "yb"].map(n);
        let [be, th, ga, ph, de, om, ep] = [q[0], q[1], q[2], q[3], q[4], q[5], q[6]];
        // The common arm of all three loops, and its derivatives by β; those by Θ lack `rr`.
        let arm_x = rr * be.cos() - d * (be + th).cos();
        let arm_y = rr * be.sin() - d * (be + th).sin();
        let (by_th_x, by_th_y) = (d * (be + th).sin(), -d * (be + th).cos());
        let (by_be_x, by_be_y) = (by_th_x - rr * be.sin(), by_th_y + rr * be.cos());
        let mut jacobian = vec![T::from(0.0); 42];
        for loop_idx in 0..3 {
            let (x, y) = (14 * loop_idx, 14 * loop_idx + 7);
            (jacobian[x], jacobian[x + 1]) = (by_be_x, by_th_x);
            (jacobian[y], jacobian[y + 1]) = (by_be_y, by_th_y);
        }
        jacobian[2] = -ss * ga.cos();
        jacobian[7 + 2] = -ss * ga.sin();
        jacobian[14 + 3] = -e * (ph + de).cos();
        jacobian[14 + 4] = -e * (ph + de).cos() + zt * de.sin();
        jacobian[21 + 3] = -e * (ph + de).sin();
        jacobian[21 + 4] = -e * (ph + de).sin() - zt * de.cos();
        jacobian[28 + 5] = zf * (om + ep).sin();
        jacobian[28 + 6] = zf * (om + ep).sin() - u * ep.cos();
        jacobian[35 + 5] = -zf * (om + ep).cos();
        jacobian[35 + 6] = -zf * (om + ep).cos() - u * ep.sin();
        Terms {
            mass: self.mass(q),
            force: self.force(q, v),
            constraint: vec![
                arm_x - ss * ga.sin() - xb,
                arm_y + ss * ga.cos() - yb,
                arm_x - e * (ph + de).sin() - zt * de.cos() - xa,
                arm_y + e * (ph + de).cos() - zt * de.sin() - ya,
                arm_x - zf * (om + ep).cos() - u * ep.sin() - xa,
                arm_y - zf * (om + ep).sin() + u * ep.cos() - ya,
            ],
            jacobian,
            constraint_rate: numbers(&[0.0; 6]),
        }
    }
}

/// Planar slider-crank in absolute coordinates `x1 y1 φ1 x2 y2 φ2 x3`.
pub struct SliderCrank {
    pub data: Reference,
}

impl SliderCrank {
    /// Positions and velocities from the crank angle and rate of the data.
    pub fn initial(&self) -> (Vec<f64>, Vec<f64>) {
        let (l1, l2) = (self.data.parameter("L1"), self.data.parameter("L2"));
        let (p1, w1) = (0.3f64, 20.0);
        let p2 = (-l1 * p1.sin() / l2).asin();
        let w2 = -l1 * p1.cos() * w1 / (l2 * p2.cos());
        let (c1, s1, c2, s2) = (p1.cos(), p1.sin(), p2.cos(), p2.sin());
        let x2 = l1 * c1 + l2 / 2.0 * c2;
        let y2 = l1 * s1 + l2 / 2.0 * s2;
        let x2_rate = -l1 * s1 * w1 - l2 / 2.0 * s2 * w2;
        let y2_rate = l1 * c1 * w1 + l2 / 2.0 * c2 * w2;
        let q = vec![l1 / 2.0 * c1, l1 / 2.0 * s1, p1, x2, y2, p2, x2 + l2 / 2.0 * c2];
        let v = vec![
            -l1 / 2.0 * s1 * w1,
            l1 / 2.0 * c1 * w1,
            w1,
            x2_rate,
            y2_rate,
            w2,
            x2_rate - l2 / 2.0 * s2 * w2,
        ];
        (q, v)
    }
}

impl Mechanism for SliderCrank {
    fn nq(&self) -> usize {
        7
    }
    fn nc(&self) -> usize {
        6
    }
    fn terms<T: Real>(&self, _t: f64, q: &[T], _v: &[T]) -> Terms<T> {
        let p = |name| self.data.parameter(name);
        let [m1, m2, m3, l1, l2, g] = ["m1", "m2", "m3", "L1", "L2", "g"].map(p);
        let half = |l: f64| T::from(l / 2.0);
        let (c1, s1) = (half(l1) * q[2].cos(), half(l1) * q[2].sin());
        let (c2, s2) = (half(l2) * q[5].cos(), half(l2) * q[5].sin());
        let constraint = vec![
            q[0] - c1,
            q[1] - s1,
            q[3] - c2 - q[0] - c1,
            q[4] - s2 - q[1] - s1,
            q[6] - q[3] - c2,
            q[4] + s2,
        ];
        let mut jacobian = vec![T::from(0.0); 42];
        let one = T::from(1.0);
        let entries = [
            (0, 0, one),
            (0, 2, s1),
            (1, 1, one),
            (1, 2, -c1),
            (2, 3, one),
            (2, 5, s2),
            (2, 0, -one),
            (2, 2, s1),
            (3, 4, one),
            (3, 5, -c2),
            (3, 1, -one),
            (3, 2, -c1),
            (4, 6, one),
            (4, 3, -one),
            (4, 5, s2),
            (5, 4, one),
            (5, 5, c2),
        ];
        for (row, col, value) in entries {
            jacobian[row * 7 + col] = value;
        }
        let inertia = |m: f64, l: f64| m * l * l / 12.0;
        Terms {
            mass: diagonal(&[m1, m1, inertia(m1, l1), m2, m2, inertia(m2, l2), m3]),
            force: numbers(&[0.0, -m1 * g, 0.0, 0.0, -m2 * g, 0.0, 0.0]),
            constraint,
            jacobian,
            constraint_rate: numbers(&[0.0; 6]),
        }
    }
}

/// A hanging chain of point masses and rigid massless bars of length one, in absolute coordinates.
pub struct Chain {
    pub n_links: usize,
}

impl Mechanism for Chain {
    fn nq(&self) -> usize {
        2 * self.n_links
    }
    fn nc(&self) -> usize {
        self.n_links
    }
    fn terms<T: Real>(&self, _t: f64, q: &[T], _v: &[T]) -> Terms<T> {
        let (n, nq) = (self.n_links, self.nq());
        let zero = T::from(0.0);
        let mut constraint = vec![zero; n];
        let mut jacobian = vec![zero; n * nq];
        for k in 0..n {
            let before = |axis: usize| if k == 0 { zero } else { q[2 * k - 2 + axis] };
            let (dx, dy) = (q[2 * k] - before(0), q[2 * k + 1] - before(1));
            constraint[k] = (dx * dx + dy * dy - T::from(1.0)) * T::from(0.5);
            (jacobian[k * nq + 2 * k], jacobian[k * nq + 2 * k + 1]) = (dx, dy);
            if k > 0 {
                (jacobian[k * nq + 2 * k - 2], jacobian[k * nq + 2 * k - 1]) = (-dx, -dy);
            }
        }
        let force = (0..nq).map(|i| T::from(if i % 2 == 1 { -9.81 } else { 0.0 })).collect();
        let mass = diagonal(&vec![1.0; nq]);
        Terms { mass, force, constraint, jacobian, constraint_rate: vec![zero; n] }
    }
}

/// Van der Pol's oscillator with `ε = 1e-6` (HW2 §IV.10): `y₁′ = y₂, ε y₂′ = (1 − y₁²) y₂ − y₁`.
pub struct VanDerPol;

impl Residual for VanDerPol {
    fn layout(&self) -> Layout {
        uniform(2)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        let slope = (T::from(1.0) - y[0] * y[0]) * y[1] - y[0];
        vec![ydot[0] - y[1], T::from(1e-6) * ydot[1] - slope]
    }
}

/// Robertson's reaction, the third equation as conservation of mass (HW2 §IV.10).
pub struct Robertson;

impl Residual for Robertson {
    fn layout(&self) -> Layout {
        uniform(3)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        let slow = T::from(0.04) * y[0];
        let back = T::from(1e4) * y[1] * y[2];
        let fast = T::from(3e7) * y[1] * y[1];
        vec![ydot[0] + slow - back, ydot[1] - slow + back + fast, y[0] + y[1] + y[2] - T::from(1.0)]
    }
}

/// `0 = y′³ + y′ + y³ + y − t`: nonlinear in `y′`.
pub struct ImplicitCubic;

impl Residual for ImplicitCubic {
    fn layout(&self) -> Layout {
        uniform(1)
    }
    fn residual<T: Real>(&self, t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        let odd = |x: T| x * x * x + x;
        vec![odd(ydot[0]) + odd(y[0]) - T::from(t)]
    }
}
