/* ---- Steps --------------------------------------------------------------------------------------------------
 *
 * Explicit: Dormand and Prince, order 5, on q' = v, v' = a(t, q, v), then projection onto the constraints.
 * Implicit: Radau IIA with three stages, order 5, for stiff mechanisms; its Jacobian is exact.
 * Sources: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5; II, IV.8. */

/* The change of a and lambda along a change of t, q, v and the inputs, with the factors of bk_complete. */
static void bk_follow(bk_model *m, double dt, const double *dq, const double *dv, const double *du, double *da,
                      double *dlambda) {
    double x[1 + 3 * BK_NQ + BK_NC + 1 + 2 * BK_NQ + BK_ROOM(BK_NU)] = {0};
    double out[BK_ROOM(BK_NQ + 2 * BK_NC)] = {0}, rhs[BK_ROOM(BK_N)] = {0};
    int i;
    bk_gather(m, x);
    x[1 + 3 * BK_NQ + BK_NC] = dt;
    bk_copy(x + 2 + 3 * BK_NQ + BK_NC, dq, BK_NQ);
    bk_copy(x + 2 + 4 * BK_NQ + BK_NC, dv, BK_NQ);
    bk_copy(x + 2 + 5 * BK_NQ + BK_NC, du, BK_NU);
    bk_change(x, m->s.p, out);
    for (i = 0; i < BK_N; i++) {
        rhs[i] = i < BK_NQ || m->s.active[i - BK_NQ] ? -out[i] : 0.0;
    }
    bk_solve(m->w.k, m->w.pivot, BK_N, rhs);
    bk_copy(da, rhs, BK_NQ);
    bk_copy(dlambda, rhs + BK_NQ, BK_NC);
    /* What velocities need to stay on the constraints: d(G v + dg/dt). */
    bk_copy(m->w.drift, out + BK_NQ + BK_NC, BK_NC);
}

static const double bk_dp_a[6][6] = {
    {1.0 / 5.0, 0, 0, 0, 0, 0},
    {3.0 / 40.0, 9.0 / 40.0, 0, 0, 0, 0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0, 0, 0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0, 0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0},
    {35.0 / 384.0, 0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
};
static const double bk_dp_c[6] = {1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0};
static const double bk_dp_e[7] = {71.0 / 57600.0,       0, -71.0 / 16695.0, 71.0 / 1920.0,
                                  -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};

/* One explicit step; `error` is the largest part of the tolerance that it errs by. */
static int bk_explicit(bk_model *m, double h, double *error) {
    double k[7][2 * BK_NQ], y[2 * BK_NQ], start[2 * BK_NQ];
    double lambda[BK_ROOM(BK_NC)] = {0};
    const double t = m->s.t;
    int stage, i, j, found;
    bk_copy(start, m->s.q, BK_NQ);
    bk_copy(start + BK_NQ, m->s.v, BK_NQ);
    bk_copy(k[0], m->s.v, BK_NQ);
    bk_copy(k[0] + BK_NQ, m->s.a, BK_NQ);
    for (stage = 0; stage < 6; stage++) {
        for (i = 0; i < 2 * BK_NQ; i++) {
            double sum = 0.0;
            for (j = 0; j <= stage; j++) {
                sum += bk_dp_a[stage][j] * k[j][i];
            }
            y[i] = start[i] + h * sum;
        }
        if (stage < 5) {
            bk_copy(k[stage + 1], y + BK_NQ, BK_NQ);
            found = bk_accelerate(m, t + bk_dp_c[stage] * h, y, y + BK_NQ, k[stage + 1] + BK_NQ, lambda);
            if (found != BK_OK) {
                return found;
            }
        }
    }
    m->s.t = t + h;
    bk_copy(m->s.q, y, BK_NQ);
    bk_copy(m->s.v, y + BK_NQ, BK_NQ);
    if (bk_project(m) != BK_OK || bk_complete(m) != BK_OK) {
        return BK_NO_MOTION;
    }
    bk_copy(k[6], m->s.v, BK_NQ);
    bk_copy(k[6] + BK_NQ, m->s.a, BK_NQ);
    *error = 0.0;
    for (i = 0; i < 2 * BK_NQ; i++) {
        double sum = 0.0;
        for (j = 0; j < 7; j++) {
            sum += bk_dp_e[j] * k[j][i];
        }
        sum = fabs(h * sum) / (m->s.tolerance * (1.0 + fmax(fabs(start[i]), fabs(y[i]))));
        *error = fmax(*error, sum);
    }
    return BK_OK;
}

/* One implicit step, by Newton's method on the accelerations of the stages. */
static int bk_implicit(bk_model *m, double h) {
    const double r = 2.449489742783178;
    const double c[3] = {(4.0 - r) / 10.0, (4.0 + r) / 10.0, 1.0};
    const double a[3][3] = {
        {(88.0 - 7.0 * r) / 360.0, (296.0 - 169.0 * r) / 1800.0, (-2.0 + 3.0 * r) / 225.0},
        {(296.0 + 169.0 * r) / 1800.0, (88.0 + 7.0 * r) / 360.0, (-2.0 - 3.0 * r) / 225.0},
        {(16.0 - r) / 36.0, (16.0 + r) / 36.0, 1.0 / 9.0},
    };
    double aa[3][3], stage[3 * BK_NQ], rest[3 * BK_NQ], q[BK_NQ], v[BK_NQ], found[BK_NQ];
    double lambda[BK_ROOM(BK_NC)] = {0}, unit[BK_NQ], zero[BK_ROOM(BK_NQ + BK_NU)] = {0}, d[BK_NQ];
    const int n = 3 * BK_NQ;
    int i, j, s, l, round;
    for (s = 0; s < 3; s++) {
        for (l = 0; l < 3; l++) {
            aa[s][l] = a[s][0] * a[0][l] + a[s][1] * a[1][l] + a[s][2] * a[2][l];
        }
    }
    memset(zero, 0, sizeof zero);
    memset(m->w.newton, 0, sizeof m->w.newton);
    for (j = 0; j < BK_NQ; j++) {
        int of_v;
        memset(unit, 0, sizeof unit);
        unit[j] = 1.0;
        for (of_v = 0; of_v < 2; of_v++) {
            bk_follow(m, 0.0, of_v ? zero : unit, of_v ? unit : zero, zero, d, lambda);
            for (s = 0; s < 3; s++) {
                for (l = 0; l < 3; l++) {
                    const double factor = of_v ? h * a[s][l] : h * h * aa[s][l];
                    for (i = 0; i < BK_NQ; i++) {
                        m->w.newton[(s * BK_NQ + i) * n + l * BK_NQ + j] -= factor * d[i];
                    }
                }
            }
        }
    }
    for (i = 0; i < n; i++) {
        m->w.newton[i * n + i] += 1.0;
        stage[i] = m->s.a[i % BK_NQ];
    }
    if (!bk_factor(m->w.newton, m->w.newton_pivot, n)) {
        return BK_NO_STEP;
    }
    for (round = 0;; round++) {
        double moved, size;
        for (s = 0; s < 3; s++) {
            for (i = 0; i < BK_NQ; i++) {
                q[i] = m->s.q[i] + c[s] * h * m->s.v[i];
                v[i] = m->s.v[i];
                for (l = 0; l < 3; l++) {
                    q[i] += h * h * aa[s][l] * stage[l * BK_NQ + i];
                    v[i] += h * a[s][l] * stage[l * BK_NQ + i];
                }
            }
            if (round == BK_NEWTON_STEPS) {
                continue;
            }
            if (bk_accelerate(m, m->s.t + c[s] * h, q, v, found, lambda) != BK_OK) {
                return BK_NO_MOTION;
            }
            for (i = 0; i < BK_NQ; i++) {
                rest[s * BK_NQ + i] = found[i] - stage[s * BK_NQ + i];
            }
        }
        if (round == BK_NEWTON_STEPS) {
            break;
        }
        bk_solve(m->w.newton, m->w.newton_pivot, n, rest);
        moved = bk_largest(rest, n);
        for (i = 0; i < n; i++) {
            stage[i] += rest[i];
        }
        size = bk_largest(stage, n);
        if (!(moved < HUGE_VAL)) {
            return BK_NO_STEP;
        }
        if (m->s.fixed == 0.0 && round == BK_NEWTON_STEPS - 1 && moved > 1e-6 * (1.0 + size)) {
            return BK_NO_STEP;
        }
    }
    m->s.t += h;
    bk_copy(m->s.q, q, BK_NQ);
    bk_copy(m->s.v, v, BK_NQ);
    return bk_project(m) != BK_OK || bk_complete(m) != BK_OK ? BK_NO_MOTION : BK_OK;
}

/* One step of size h by the method of the model; an implicit one is measured against two halves. */
static int bk_attempt(bk_model *m, double h, double *error) {
    double once[2 * BK_NQ];
    int i, found;
    *error = 0.0;
    if (m->s.method == 0) {
        return bk_explicit(m, h, error);
    }
    if (m->s.fixed > 0.0) {
        return bk_implicit(m, h);
    }
    m->w.before = m->s;
    found = bk_implicit(m, h);
    if (found != BK_OK) {
        return found;
    }
    bk_copy(once, m->s.q, BK_NQ);
    bk_copy(once + BK_NQ, m->s.v, BK_NQ);
    m->s = m->w.before;
    bk_complete(m);
    if (bk_implicit(m, 0.5 * h) != BK_OK || bk_implicit(m, 0.5 * h) != BK_OK) {
        return BK_NO_STEP;
    }
    for (i = 0; i < BK_NQ; i++) {
        const double q = m->s.q[i], v = m->s.v[i];
        *error = fmax(*error, fabs(q - once[i]) / (31.0 * m->s.tolerance * (1.0 + fabs(q))));
        *error = fmax(*error, fabs(v - once[BK_NQ + i]) / (31.0 * m->s.tolerance * (1.0 + fabs(v))));
    }
    m->s.t = m->w.before.t + h;
    return BK_OK;
}

#if BK_NZ > 0
/* 1 where an indicator is below zero now. */
static int bk_has_fallen(bk_model *m) {
    double z[BK_NZ];
    int i;
    bk_events(m, z);
    for (i = 0; i < BK_NZ; i++) {
        if (z[i] < 0.0) {
            return 1;
        }
    }
    return 0;
}

/* The part of the step from `from` to now at which an indicator is first found below zero; 1 without any. */
static double bk_fallen_between(bk_model *m, const bk_state *from) {
    const bk_state to = m->s;
    const double h = to.t - from->t;
    int part, i;
    for (part = 1; part < 4; part++) {
        const double x = 0.25 * part;
        for (i = 0; i < BK_NQ; i++) {
            /* The cubic through positions and rates at both ends, and through rates and accelerations. */
            const double d = to.q[i] - from->q[i], e = to.v[i] - from->v[i];
            m->s.q[i] = from->q[i] + x * d
                + x * (1.0 - x) * ((1.0 - x) * (h * from->v[i] - d) - x * (h * to.v[i] - d));
            m->s.v[i] = from->v[i] + x * e
                + x * (1.0 - x) * ((1.0 - x) * (h * from->a[i] - e) - x * (h * to.a[i] - e));
        }
        m->s.t = from->t + x * h;
        for (i = 0; i < BK_NC; i++) {
            m->s.lambda[i] = (1.0 - x) * from->lambda[i] + x * to.lambda[i];
        }
        if (bk_has_fallen(m)) {
            m->s = to;
            return x;
        }
    }
    m->s = to;
    return 1.0;
}
#endif

/* Goes to the first event up to `t_end`, or there; `is_event` says which. The event itself is not passed yet. */
static int bk_move(bk_model *m, double t_end, int *is_event) {
    double error = 0.0;
    *is_event = 0;
    while (m->s.t < t_end) {
        const double left = t_end - m->s.t;
        double h = m->s.fixed > 0.0 ? left / ceil(left / m->s.fixed - 1e-9) : m->s.step > 0.0 ? m->s.step : 1e-3;
        bk_state *from = &m->w.from;
        int is_last, found;
        h = fmin(h, BK_LONGEST_STEP);
        is_last = h >= left * (1.0 - 1e-12);
        h = is_last ? left : h > 0.5 * left && m->s.fixed == 0.0 ? 0.5 * left : h;
        *from = m->s;
        found = bk_attempt(m, h, &error);
        if (m->s.fixed == 0.0) {
            const double factor = found != BK_OK ? 0.25 : 0.9 * pow(fmax(error, 1e-6), -0.2);
            if (found != BK_OK || !(error <= 1.0)) {
                m->s = *from;
                m->s.step = h * fmax(0.2, fmin(factor, 0.9));
                if (!(m->s.step > 1e-12 * (1.0 + fabs(m->s.t)))) {
                    return found != BK_OK ? found : BK_NO_STEP;
                }
                bk_complete(m);
                continue;
            }
            /* A short last step says little about the next one. */
            m->s.step = fmax(h * fmin(factor, 5.0), is_last ? from->step : 0.0);
        } else if (found != BK_OK) {
            return found;
        }
        m->s.t = is_last ? t_end : m->s.t;
        if (bk_renew(m) != BK_OK) {
            return BK_NO_MOTION;
        }
#if BK_NZ > 0
        if (m->s.locates) {
            double low = 0.0, high = h, part = bk_fallen_between(m, from);
            int round;
            if (part == 1.0 && !bk_has_fallen(m)) {
                continue;
            }
            high = part * h;
            for (round = 0; round < 80; round++) {
                const double middle = round == 0 ? high : 0.5 * (low + high);
                const double step = m->s.step;
                if (round > 0 && (middle <= low || middle >= high || high - low <= 2e-16 * fmax(fabs(from->t), h))) {
                    break;
                }
                m->s = *from;
                bk_complete(m);
                found = bk_attempt(m, middle, &error);
                m->s.step = step;
                if (found != BK_OK) {
                    return found;
                }
                if (bk_has_fallen(m)) {
                    high = middle;
                    m->w.fallen = m->s;
                } else if (round == 0) {
                    /* It rose again: what the cubic saw is not on the motion. */
                    m->s.step = fmax(middle, 1e-9);
                    break;
                } else {
                    low = middle;
                }
            }
            if (round > 0) {
                m->s = m->w.fallen;
                m->s.step = fmax(m->s.step, 1e-6);
                *is_event = 1;
                return BK_OK;
            }
            continue;
        }
        if (bk_has_fallen(m)) {
            *is_event = 1;
            return BK_OK;
        }
#endif
    }
    return BK_OK;
}

/* Moves to `t_end` and passes the events on the way; stops at the first one where `stops` is not 0, before it is
 * passed, and says so in `is_event`. */
static int bk_advance_until(bk_model *m, double t_end, int stops, int *is_event) {
    int found, count = 0;
    *is_event = 0;
    found = bk_complete(m);
    while (found == BK_OK) {
        double next = t_end;
        int is_tick = 0;
#if BK_NCLOCKS > 0
        const double tick = bk_next_tick(m);
        is_tick = tick <= t_end;
        next = is_tick ? fmax(tick, m->s.t) : t_end;
#endif
        found = bk_move(m, next, is_event);
        if (found != BK_OK || (!*is_event && !is_tick)) {
            return found;
        }
        if (stops) {
            *is_event = 1;
            return BK_OK;
        }
        found = bk_pass(m);
        *is_event = 0;
        /* Events without end: bounces that come ever faster. */
        if (++count > BK_MOST_EVENTS) {
            return BK_NO_STEP;
        }
    }
    return found;
}
