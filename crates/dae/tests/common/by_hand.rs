//! Andrews' squeezer in index-2 form as a person would write it: no allocation, every derivative
//! taken by hand. The cost of a run then is the integrator's own.

use bksim_dae::{Index, Layout, NotFinite, Pattern, System};

use super::reference::Reference;

const NQ: usize = 7;
const N: usize = 20;

/// Sines, cosines and products of parameters; names as in the data file.
pub struct AndrewsByHand {
    layout: Layout,
    pattern: Pattern,
    explicit: Vec<(usize, usize)>,
    /// Where the entries of the Jacobian are stored, by row and column.
    slots: Vec<usize>,
    c2: f64,
    c4: f64,
    c6: f64,
    mass: [f64; 9],
    mom: f64,
    c0: f64,
    l0: f64,
    sc: f64,
    sd: f64,
    anchor: [f64; 2],
    rr: f64,
    d: f64,
    ss: f64,
    e: f64,
    zt: f64,
    zf: f64,
    u: f64,
}

/// Sine and cosine of every angle that occurs.
struct Angles {
    be: (f64, f64),
    th: (f64, f64),
    ga: (f64, f64),
    ph: (f64, f64),
    de: (f64, f64),
    om: (f64, f64),
    ep: (f64, f64),
    be_th: (f64, f64),
    ph_de: (f64, f64),
    om_ep: (f64, f64),
}

impl Angles {
    fn of(q: &[f64]) -> Self {
        Self {
            be: q[0].sin_cos(),
            th: q[1].sin_cos(),
            ga: q[2].sin_cos(),
            ph: q[3].sin_cos(),
            de: q[4].sin_cos(),
            om: q[5].sin_cos(),
            ep: q[6].sin_cos(),
            be_th: (q[0] + q[1]).sin_cos(),
            ph_de: (q[3] + q[4]).sin_cos(),
            om_ep: (q[5] + q[6]).sin_cos(),
        }
    }
}

/// Entries of both Jacobians that are not zero, `(row, column)`; the diagonal is added.
fn entries() -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    for i in 0..NQ {
        all.extend([(i, i), (i, NQ + i), (NQ + i, NQ + i)]);
    }
    for (i, j) in [(0, 1), (1, 0), (3, 4), (4, 3), (5, 6), (6, 5)] {
        all.push((NQ + i, NQ + j));
        all.push((NQ + i, j));
    }
    all.extend((0..NQ).map(|i| (NQ + i, i)));
    for k in 0..6 {
        let loop_columns = [vec![2], vec![3, 4], vec![5, 6]][k / 2].clone();
        for j in [0, 1].into_iter().chain(loop_columns) {
            all.extend([(14 + k, j), (14 + k, NQ + j), (NQ + j, 14 + k)]);
        }
    }
    all
}

impl AndrewsByHand {
    pub fn from(data: &Reference) -> Self {
        let p = |name| data.parameter(name);
        let (m2, m4, m6) = (p("m2"), p("m4"), p("m6"));
        let (e_ea, zf_fa) = (p("e") - p("ea"), p("zf") - p("fa"));
        let m11 = p("m1") * p("ra").powi(2)
            + m2 * (p("rr").powi(2) + p("da").powi(2))
            + p("i1")
            + p("i2");
        let m22 = m2 * p("da").powi(2) + p("i2");
        let m33 = p("m3") * (p("sa").powi(2) + p("sb").powi(2)) + p("i3");
        let m44 = m4 * e_ea * e_ea + p("i4");
        let m55 = m4 * (p("zt").powi(2) + e_ea * e_ea)
            + p("m5") * (p("ta").powi(2) + p("tb").powi(2))
            + p("i4")
            + p("i5");
        let m66 = m6 * zf_fa * zf_fa + p("i6");
        let m77 = m6 * (zf_fa * zf_fa + p("u").powi(2))
            + p("m7") * (p("ua").powi(2) + p("ub").powi(2))
            + p("i6")
            + p("i7");
        let pattern = Pattern::new(N, entries()).expect("entries lie inside");
        let slots =
            (0..N * N).map(|k| pattern.position(k / N, k % N).unwrap_or(usize::MAX)).collect();
        Self {
            layout: Layout::from_groups(&[(14, Index::One), (6, Index::Two)]),
            pattern,
            explicit: (0..NQ).map(|i| (i, NQ + i)).collect(),
            slots,
            c2: m2 * p("da") * p("rr"),
            c4: m4 * p("zt") * e_ea,
            c6: m6 * p("u") * zf_fa,
            mass: [m11, m22, m22, m33, m44, m44, m55, m66, m77],
            mom: p("mom"),
            c0: p("c0"),
            l0: p("l0"),
            sc: p("sc"),
            sd: p("sd"),
            anchor: [p("xb") - p("xc"), p("yb") - p("yc")],
            rr: p("rr"),
            d: p("d"),
            ss: p("ss"),
            e: p("e"),
            zt: p("zt"),
            zf: p("zf"),
            u: p("u"),
        }
    }

    /// Spring force along γ and its derivative: `−c0 (L − l0) L′`.
    fn spring(&self, (s, c): (f64, f64)) -> (f64, f64) {
        let (dx, dy) = (
            self.sd * c + self.sc * s + self.anchor[0],
            self.sd * s - self.sc * c + self.anchor[1],
        );
        let (a, b) = (self.sc * c - self.sd * s, self.sd * c + self.sc * s);
        let length = (dx * dx + dy * dy).sqrt();
        let rate = (dx * a + dy * b) / length;
        let second = (a * a + b * b - dx * b + dy * a - rate * rate) / length;
        let excess = length - self.l0;
        (-self.c0 * excess * rate, -self.c0 * (rate * rate + excess * second))
    }
}

impl System for AndrewsByHand {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn explicit_rows(&self) -> &[(usize, usize)] {
        &self.explicit
    }

    fn residual(
        &mut self,
        _t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        let (v, l, a) = (&y[NQ..14], &y[14..20], &ydot[NQ..14]);
        let at = Angles::of(&y[..NQ]);
        let Self { c2, c4, c6, rr, d, ss, e, zt, zf, u, .. } = *self;
        for i in 0..NQ {
            out[i] = ydot[i] - v[i];
        }
        let ((s_th, c_th), (s_ph, c_ph), (s_om, c_om)) = (at.th, at.ph, at.om);
        let [m11, m21, m22, m33, m44, m54, m55, m66, m77] = self.mass;
        let m21_now = m21 - c2 * c_th;
        let m54_now = m54 + c4 * s_ph;
        let m76_now = m66 - c6 * s_om;
        let (lx, ly) = (l[0] + l[2] + l[4], l[1] + l[3] + l[5]);
        let (ds1, dc1) = (d * at.be_th.0, d * at.be_th.1);
        let (rsb, rcb) = (rr * at.be.0, rr * at.be.1);
        let arm = ds1 * lx - dc1 * ly;
        let (es, ec) = (e * at.ph_de.0, e * at.ph_de.1);
        let (zs, zc) = (zf * at.om_ep.0, zf * at.om_ep.1);
        let third = -ec * l[2] - es * l[3];
        let fifth = zs * l[4] - zc * l[5];
        let (force, _) = self.spring(at.ga);
        out[7] = (m11 - 2.0 * c2 * c_th) * a[0] + m21_now * a[1] - self.mom
            + c2 * v[1] * (v[1] + 2.0 * v[0]) * s_th
            + arm
            - rsb * lx
            + rcb * ly;
        out[8] = m21_now * a[0] + m22 * a[1] - c2 * v[0] * v[0] * s_th + arm;
        out[9] = m33 * a[2] - force - ss * (at.ga.1 * l[0] + at.ga.0 * l[1]);
        out[10] = m44 * a[3] + m54_now * a[4] - c4 * v[4] * v[4] * c_ph + third;
        out[11] = m54_now * a[3]
            + (m55 + 2.0 * c4 * s_ph) * a[4]
            + c4 * v[3] * (v[3] + 2.0 * v[4]) * c_ph
            + third
            + zt * (at.de.0 * l[2] - at.de.1 * l[3]);
        out[12] = m66 * a[5] + m76_now * a[6] + c6 * v[6] * v[6] * c_om + fifth;
        out[13] = m76_now * a[5] + (m77 - 2.0 * c6 * s_om) * a[6]
            - c6 * v[5] * (v[5] + 2.0 * v[6]) * c_om
            + fifth
            - u * (at.ep.1 * l[4] + at.ep.0 * l[5]);
        let w = v[0] + v[1];
        let (x, y) = (ds1 * w - rsb * v[0], -dc1 * w + rcb * v[0]);
        let (w3, w5) = (v[3] + v[4], v[5] + v[6]);
        out[14] = x - ss * at.ga.1 * v[2];
        out[15] = y - ss * at.ga.0 * v[2];
        out[16] = x - ec * w3 + zt * at.de.0 * v[4];
        out[17] = y - es * w3 - zt * at.de.1 * v[4];
        out[18] = x + zs * w5 - u * at.ep.1 * v[6];
        out[19] = y - zc * w5 - u * at.ep.0 * v[6];
        Ok(())
    }

    fn jacobian(
        &mut self,
        _t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        let (v, l, a) = (&y[NQ..14], &y[14..20], &ydot[NQ..14]);
        let at = Angles::of(&y[..NQ]);
        let Self { c2, c4, c6, rr, d, ss, e, zt, zf, u, .. } = *self;
        let ((s_th, c_th), (s_ph, c_ph), (s_om, c_om)) = (at.th, at.ph, at.om);
        let [m11, m21, m22, m33, m44, m54, m55, m66, m77] = self.mass;
        let (_, stiffness) = self.spring(at.ga);
        df_dy.fill(0.0);
        df_dydot.fill(0.0);
        let slots = &self.slots;

        // The mass matrix.
        let mut mass = |i: usize, j: usize, x: f64| {
            df_dydot[slots[(NQ + i) * N + NQ + j]] = x;
            df_dydot[slots[(NQ + j) * N + NQ + i]] = x;
        };
        mass(0, 0, m11 - 2.0 * c2 * c_th);
        mass(0, 1, m21 - c2 * c_th);
        mass(1, 1, m22);
        mass(2, 2, m33);
        mass(3, 3, m44);
        mass(3, 4, m54 + c4 * s_ph);
        mass(4, 4, m55 + 2.0 * c4 * s_ph);
        mass(5, 5, m66);
        mass(5, 6, m66 - c6 * s_om);
        mass(6, 6, m77 - 2.0 * c6 * s_om);

        let mut set = |row: usize, col: usize, x: f64| df_dy[slots[row * N + col]] = x;
        for i in 0..NQ {
            df_dydot[slots[i * N + i]] = 1.0;
            set(i, NQ + i, -1.0);
        }
        // Inertia and forces by positions and velocities, Gᵀλ by positions.
        let (lx, ly) = (l[0] + l[2] + l[4], l[1] + l[3] + l[5]);
        let (ds1, dc1) = (d * at.be_th.0, d * at.be_th.1);
        let (rsb, rcb) = (rr * at.be.0, rr * at.be.1);
        let (es, ec) = (e * at.ph_de.0, e * at.ph_de.1);
        let (zs, zc) = (zf * at.om_ep.0, zf * at.om_ep.1);
        let arm = dc1 * lx + ds1 * ly;
        set(7, 0, arm - rcb * lx - rsb * ly);
        let centrifugal = c2 * v[1] * (v[1] + 2.0 * v[0]) * c_th;
        set(7, 1, c2 * s_th * (2.0 * a[0] + a[1]) + centrifugal + arm);
        set(8, 0, arm);
        set(8, 1, c2 * s_th * a[0] - c2 * v[0] * v[0] * c_th + arm);
        set(7, 7, 2.0 * c2 * v[1] * s_th);
        set(7, 8, 2.0 * c2 * (v[0] + v[1]) * s_th);
        set(8, 7, -2.0 * c2 * v[0] * s_th);
        set(9, 2, -stiffness + ss * (at.ga.0 * l[0] - at.ga.1 * l[1]));
        let third = es * l[2] - ec * l[3];
        set(10, 3, c4 * c_ph * a[4] + c4 * v[4] * v[4] * s_ph + third);
        set(10, 4, third);
        let centrifugal = c4 * v[3] * (v[3] + 2.0 * v[4]) * s_ph;
        set(11, 3, c4 * c_ph * (a[3] + 2.0 * a[4]) - centrifugal + third);
        set(11, 4, third + zt * (at.de.1 * l[2] + at.de.0 * l[3]));
        set(10, 11, -2.0 * c4 * v[4] * c_ph);
        set(11, 10, 2.0 * c4 * (v[3] + v[4]) * c_ph);
        set(11, 11, 2.0 * c4 * v[3] * c_ph);
        let fifth = zc * l[4] + zs * l[5];
        set(12, 5, -c6 * c_om * a[6] - c6 * v[6] * v[6] * s_om + fifth);
        set(12, 6, fifth);
        let centrifugal = c6 * v[5] * (v[5] + 2.0 * v[6]) * s_om;
        set(13, 5, -c6 * c_om * (a[5] + 2.0 * a[6]) + centrifugal + fifth);
        set(13, 6, fifth + u * (at.ep.0 * l[4] - at.ep.1 * l[5]));
        set(12, 13, 2.0 * c6 * v[6] * c_om);
        set(13, 12, -2.0 * c6 * (v[5] + v[6]) * c_om);
        set(13, 13, -2.0 * c6 * v[5] * c_om);

        // G, twice, and G v by positions.
        let w = v[0] + v[1];
        for k in [14, 16, 18] {
            for (col, x, y) in [(0, ds1 - rsb, rcb - dc1), (1, ds1, -dc1)] {
                set(k, NQ + col, x);
                set(NQ + col, k, x);
                set(k + 1, NQ + col, y);
                set(NQ + col, k + 1, y);
            }
            set(k, 0, dc1 * w - rcb * v[0]);
            set(k, 1, dc1 * w);
            set(k + 1, 0, ds1 * w - rsb * v[0]);
            set(k + 1, 1, ds1 * w);
        }
        let (w3, w5) = (v[3] + v[4], v[5] + v[6]);
        let (sg, cg) = (ss * at.ga.0, ss * at.ga.1);
        let (sd, cd) = (zt * at.de.0, zt * at.de.1);
        let (se, ce) = (u * at.ep.0, u * at.ep.1);
        for (row, col, g, by_q) in [
            (14, 2, -cg, sg * v[2]),
            (15, 2, -sg, -cg * v[2]),
            (16, 3, -ec, es * w3),
            (16, 4, -ec + sd, es * w3 + cd * v[4]),
            (17, 3, -es, -ec * w3),
            (17, 4, -es - cd, -ec * w3 + sd * v[4]),
            (18, 5, zs, zc * w5),
            (18, 6, zs - ce, zc * w5 + se * v[6]),
            (19, 5, -zc, zs * w5),
            (19, 6, -zc - se, zs * w5 - ce * v[6]),
        ] {
            set(row, NQ + col, g);
            set(NQ + col, row, g);
            set(row, col, by_q);
        }
        Ok(())
    }
}
