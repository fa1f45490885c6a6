/* ---- State, linear equations, accelerations -------------------------------------------------------------
 *
 *     M a + G' lambda = f        G a + gamma = 0        rows that take part alone
 *
 * Nothing is allocated, and there are no globals: all that changes is in one plain struct without pointers. */

enum { BK_OK = 0, BK_NO_MOTION = 1, BK_NO_POSE = 2, BK_NO_MODES = 3, BK_NO_START = 4, BK_NO_STEP = 5 };

static double bk_largest(const double *x, int n) {
    double most = 0.0;
    int i;
    for (i = 0; i < n; i++) {
        if (!(fabs(x[i]) <= most)) {
            most = fabs(x[i]);
        }
    }
    return most;
}

static void bk_copy(double *to, const double *from, int n) {
    int i;
    for (i = 0; i < n; i++) {
        to[i] = from[i];
    }
}

/* LU factors of an n x n matrix, row by row, with pivots by scaled rows; 0 where it is singular. */
static int bk_factor(double *a, int *pivot, int n) {
    double scale[BK_ROOM(BK_LARGEST)] = {0};
    int i, j, k;
    for (i = 0; i < n; i++) {
        scale[i] = bk_largest(a + i * n, n);
        if (!(scale[i] > 0.0 && scale[i] < HUGE_VAL)) {
            return 0;
        }
    }
    for (k = 0; k < n; k++) {
        int best = k;
        double most = 0.0;
        for (i = k; i < n; i++) {
            const double size = fabs(a[i * n + k]) / scale[i];
            if (size > most) {
                most = size;
                best = i;
            }
        }
        if (!(most > 1e-14)) {
            return 0;
        }
        pivot[k] = best;
        if (best != k) {
            const double swap = scale[k];
            scale[k] = scale[best];
            scale[best] = swap;
            for (j = 0; j < n; j++) {
                const double entry = a[k * n + j];
                a[k * n + j] = a[best * n + j];
                a[best * n + j] = entry;
            }
        }
        for (i = k + 1; i < n; i++) {
            if (a[i * n + k] != 0.0) {
                const double factor = a[i * n + k] / a[k * n + k];
                a[i * n + k] = factor;
                for (j = k + 1; j < n; j++) {
                    a[i * n + j] -= factor * a[k * n + j];
                }
            }
        }
    }
    return 1;
}

static void bk_solve(const double *a, const int *pivot, int n, double *x) {
    int i, j;
    for (i = 0; i < n; i++) {
        const double value = x[pivot[i]];
        x[pivot[i]] = x[i];
        x[i] = value;
    }
    for (i = 0; i < n; i++) {
        for (j = 0; j < i; j++) {
            x[i] -= a[i * n + j] * x[j];
        }
    }
    for (i = n - 1; i >= 0; i--) {
        for (j = i + 1; j < n; j++) {
            x[i] -= a[i * n + j] * x[j];
        }
        x[i] /= a[i * n + i];
    }
}

/* The smallest x with rows[i] x = target[i], by orthogonal rows (Gram and Schmidt, twice); taken[i] is 0 of rows
 * that follow from those before them. Destroys the rows. */
static void bk_least(double *rows, const double *target, int n_rows, double *x, char *taken) {
    double share[BK_ROOM(BK_ROWS)] = {0};
    int i, j, k, pass;
    for (k = 0; k < BK_NQ; k++) {
        x[k] = 0.0;
    }
    for (i = 0; i < n_rows; i++) {
        double *row = rows + i * BK_NQ;
        double before = 0.0, norm = 0.0, known = 0.0;
        for (k = 0; k < BK_NQ; k++) {
            before += row[k] * row[k];
        }
        for (pass = 0; pass < 2; pass++) {
            for (j = 0; j < i; j++) {
                double part = 0.0;
                if (!taken[j]) {
                    continue;
                }
                for (k = 0; k < BK_NQ; k++) {
                    part += row[k] * rows[j * BK_NQ + k];
                }
                for (k = 0; k < BK_NQ; k++) {
                    row[k] -= part * rows[j * BK_NQ + k];
                }
                known += part * share[j];
            }
        }
        for (k = 0; k < BK_NQ; k++) {
            norm += row[k] * row[k];
        }
        taken[i] = norm > 1e-18 * before && before > 0.0;
        if (taken[i]) {
            norm = sqrt(norm);
            share[i] = (target[i] - known) / norm;
            for (k = 0; k < BK_NQ; k++) {
                row[k] /= norm;
                x[k] += share[i] * row[k];
            }
        }
    }
}

/* Evaluates G, g and dg/dt at a position. */
static void bk_constrain(bk_model *m, double t, const double *q) {
    double x[1 + BK_NQ];
    double out[BK_ROOM(BK_NJ + 2 * BK_NC)] = {0};
    int i;
    x[0] = t;
    bk_copy(x + 1, q, BK_NQ);
    bk_constraints(x, m->s.p, out);
    for (i = 0; i < BK_NC * BK_NQ; i++) {
        m->w.g[i] = 0.0;
    }
    for (i = 0; i < BK_NJ; i++) {
        m->w.g[bk_jacobian_row[i] * BK_NQ + bk_jacobian_column[i]] = out[i];
    }
    bk_copy(m->w.gap, out + BK_NJ, BK_NC);
    bk_copy(m->w.g_rate, out + BK_NJ + BK_NC, BK_NC);
}

/* Evaluates M, G, f and gamma at a state; `pressing` are the multipliers that f depends on. */
static void bk_evaluate(bk_model *m, double t, const double *q, const double *v, const double *pressing) {
    double x[1 + 2 * BK_NQ + BK_ROOM(BK_NL)] = {0};
    double out[BK_ROOM(BK_NM + BK_NJ + BK_NQ + BK_NC)] = {0};
    int i;
    x[0] = t;
    bk_copy(x + 1, q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, v, BK_NQ);
    bk_copy(x + 1 + 2 * BK_NQ, pressing, BK_NL);
    bk_terms(x, m->s.p, out);
    for (i = 0; i < BK_NQ * BK_NQ; i++) {
        m->w.mass[i] = 0.0;
    }
    for (i = 0; i < BK_NM; i++) {
        m->w.mass[bk_mass_row[i] * BK_NQ + bk_mass_column[i]] = out[i];
        m->w.mass[bk_mass_column[i] * BK_NQ + bk_mass_row[i]] = out[i];
    }
    for (i = 0; i < BK_NC * BK_NQ; i++) {
        m->w.g[i] = 0.0;
    }
    for (i = 0; i < BK_NJ; i++) {
        m->w.g[bk_jacobian_row[i] * BK_NQ + bk_jacobian_column[i]] = out[BK_NM + i];
    }
    bk_copy(m->w.force, out + BK_NM + BK_NJ, BK_NQ);
    bk_copy(m->w.gamma, out + BK_NM + BK_NJ + BK_NQ, BK_NC);
}

/* Factors [M G'; G 0] of the rows that take part; the others have 1 in their place. */
static int bk_factor_system(bk_model *m, const char *active) {
    double *k = m->w.k;
    int i, j;
    for (i = 0; i < BK_N * BK_N; i++) {
        k[i] = 0.0;
    }
    for (i = 0; i < BK_NQ; i++) {
        bk_copy(k + i * BK_N, m->w.mass + i * BK_NQ, BK_NQ);
    }
    for (i = 0; i < BK_NC; i++) {
        if (!active[i]) {
            k[(BK_NQ + i) * BK_N + BK_NQ + i] = 1.0;
            continue;
        }
        for (j = 0; j < BK_NQ; j++) {
            k[(BK_NQ + i) * BK_N + j] = m->w.g[i * BK_NQ + j];
            k[j * BK_N + BK_NQ + i] = m->w.g[i * BK_NQ + j];
        }
    }
    for (i = 0; i < BK_NL; i++) {
        for (j = 0; j < BK_NQ; j++) {
            k[j * BK_N + BK_NQ + bk_pressing_row[i]] -= m->w.slopes[j * BK_NL + i];
        }
    }
    return bk_factor(k, m->w.pivot, BK_N);
}

/* Accelerations and multipliers at a state; BK_NO_MOTION where there are none. */
static int bk_accelerate(bk_model *m, double t, const double *q, const double *v, double *a, double *lambda) {
    double x[BK_ROOM(BK_N)] = {0};
    double pressing[BK_ROOM(BK_NL)] = {0};
    const char *active = m->s.active;
    int i, round;
    for (i = 0; i < BK_NL; i++) {
        pressing[i] = 0.0;
    }
    for (i = 0; i < BK_NL * BK_NQ; i++) {
        m->w.slopes[i] = 0.0;
    }
    for (round = 0;; round++) {
        double moved = 0.0, size = 0.0;
        bk_evaluate(m, t, q, v, pressing);
        if (BK_NL > 0 && round > 0) {
            double y[1 + 2 * BK_NQ + BK_ROOM(BK_NL)] = {0};
            y[0] = t;
            bk_copy(y + 1, q, BK_NQ);
            bk_copy(y + 1 + BK_NQ, v, BK_NQ);
            bk_copy(y + 1 + 2 * BK_NQ, pressing, BK_NL);
            bk_slopes(y, m->s.p, m->w.slopes);
        }
        if (!bk_factor_system(m, active)) {
            return BK_NO_MOTION;
        }
        for (i = 0; i < BK_NQ; i++) {
            int j;
            x[i] = m->w.force[i];
            for (j = 0; j < BK_NL; j++) {
                x[i] -= m->w.slopes[i * BK_NL + j] * pressing[j];
            }
        }
        for (i = 0; i < BK_NC; i++) {
            x[BK_NQ + i] = active[i] ? -m->w.gamma[i] : 0.0;
        }
        bk_solve(m->w.k, m->w.pivot, BK_N, x);
        for (i = 0; i < BK_NL; i++) {
            const double found = x[BK_NQ + bk_pressing_row[i]];
            moved = fmax(moved, fabs(found - pressing[i]));
            pressing[i] = found;
        }
        size = bk_largest(x + BK_NQ, BK_NC);
        if (BK_NL == 0 || (round > 0 && moved <= 1e-14 * size)) {
            break;
        }
        if (round > 40 || !(moved < HUGE_VAL)) {
            return BK_NO_MOTION;
        }
    }
    if (!(bk_largest(x, BK_N) < HUGE_VAL)) {
        return BK_NO_MOTION;
    }
    bk_copy(a, x, BK_NQ);
    bk_copy(lambda, x + BK_NQ, BK_NC);
    return BK_OK;
}

/* The rows that take part here: of those that always hold as many as are independent, the clearest first; then those
 * of contacts that are closed and follow from none before them. */
static void bk_choose_rows(bk_model *m) {
    char is_done[BK_ROOM(BK_NC)] = {0};
    double whole[BK_ROOM(BK_NC)] = {0};
    int i, j, k, round, pass;
    bk_constrain(m, m->s.t, m->s.q);
    bk_copy(m->w.rows, m->w.g, BK_NC * BK_NQ);
    for (i = 0; i < BK_NC; i++) {
        m->s.active[i] = 0;
        for (j = 0; j < BK_NQ; j++) {
            whole[i] += m->w.g[i * BK_NQ + j] * m->w.g[i * BK_NQ + j];
        }
    }
    for (round = 0; round < BK_NC; round++) {
        const int is_contact = round >= BK_RANK;
        int best = -1;
        double most = 0.0, norm = 0.0;
        for (i = is_contact ? BK_NB : 0; i < (is_contact ? BK_NC : BK_NB); i++) {
            double rest = 0.0;
            for (j = 0; j < BK_NQ; j++) {
                rest += m->w.rows[i * BK_NQ + j] * m->w.rows[i * BK_NQ + j];
            }
            /* Of those that always hold the largest rest: some vanish in single poses. */
            rest /= is_contact ? fmax(whole[i], DBL_MIN) : 1.0;
            if (!is_done[i] && whole[i] > 0.0 && rest > most * (1.0 + 1e-9)) {
                most = rest;
                rest *= is_contact ? whole[i] : 1.0;
                norm = sqrt(rest);
                best = i;
                if (is_contact && most > 1e-18) {
                    break;
                }
            }
        }
        if (best < 0 || (is_contact && !(most > 1e-18))) {
            if (is_contact) {
                break;
            }
            continue;
        }
        is_done[best] = 1;
        m->s.active[best] = 1;
        for (j = 0; j < BK_NQ; j++) {
            m->w.rows[best * BK_NQ + j] /= norm;
        }
        for (i = 0; i < BK_NC; i++) {
            for (pass = 0; pass < 2 && !is_done[i]; pass++) {
                double part = 0.0;
                for (k = 0; k < BK_NQ; k++) {
                    part += m->w.rows[i * BK_NQ + k] * m->w.rows[best * BK_NQ + k];
                }
                for (k = 0; k < BK_NQ; k++) {
                    m->w.rows[i * BK_NQ + k] -= part * m->w.rows[best * BK_NQ + k];
                }
            }
        }
    }
}

/* Accelerations and multipliers of the state of the model. */
static int bk_complete(bk_model *m) {
    return bk_accelerate(m, m->s.t, m->s.q, m->s.v, m->s.a, m->s.lambda);
}

/* Moves q, then v, onto the rows that take part, by the smallest change in the metric of M. */
static int bk_project(bk_model *m) {
    double x[BK_ROOM(BK_N)] = {0};
    int i, j, round;
    if (BK_NC == 0) {
        return BK_OK;
    }
    for (i = 0; i < BK_NL; i++) {
        for (j = 0; j < BK_NQ; j++) {
            m->w.slopes[j * BK_NL + i] = 0.0;
        }
    }
    bk_evaluate(m, m->s.t, m->s.q, m->s.v, m->w.zeros);
    if (!bk_factor_system(m, m->s.active)) {
        return BK_NO_MOTION;
    }
    for (round = 0; round < 3; round++) {
        bk_constrain(m, m->s.t, m->s.q);
        for (i = 0; i < BK_NQ; i++) {
            x[i] = 0.0;
        }
        for (i = 0; i < BK_NC; i++) {
            x[BK_NQ + i] = m->s.active[i] ? -m->w.gap[i] : 0.0;
        }
        bk_solve(m->w.k, m->w.pivot, BK_N, x);
        for (i = 0; i < BK_NQ; i++) {
            m->s.q[i] += x[i];
        }
    }
    bk_constrain(m, m->s.t, m->s.q);
    for (round = 0; round < 3; round++) {
        for (i = 0; i < BK_NQ; i++) {
            x[i] = 0.0;
        }
        for (i = 0; i < BK_NC; i++) {
            double rate = m->w.g_rate[i];
            for (j = 0; j < BK_NQ; j++) {
                rate += m->w.g[i * BK_NQ + j] * m->s.v[j];
            }
            x[BK_NQ + i] = m->s.active[i] ? -rate : 0.0;
        }
        bk_solve(m->w.k, m->w.pivot, BK_N, x);
        for (i = 0; i < BK_NQ; i++) {
            m->s.v[i] += x[i];
        }
    }
    return bk_largest(m->s.q, BK_NQ) < HUGE_VAL && bk_largest(m->s.v, BK_NQ) < HUGE_VAL ? BK_OK : BK_NO_MOTION;
}

/* Where conditions repeat others, which of them take part is chosen anew along the motion. */
static int bk_renew(bk_model *m) {
    if (BK_RANK == BK_NB) {
        return BK_OK;
    }
    {
        char before[BK_ROOM(BK_NC)] = {0};
        memcpy(before, m->s.active, sizeof before);
        bk_choose_rows(m);
        return memcmp(before, m->s.active, sizeof before) == 0 ? BK_OK : bk_complete(m);
    }
}

/* Time, coordinates, velocities, accelerations and multipliers in one row. */
static void bk_gather(const bk_model *m, double *x) {
    x[0] = m->s.t;
    bk_copy(x + 1, m->s.q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
    bk_copy(x + 1 + 2 * BK_NQ, m->s.a, BK_NQ);
    bk_copy(x + 1 + 3 * BK_NQ, m->s.lambda, BK_NC);
}

/* All outputs, in the order of the names in the header. */
BK_API void BK(outputs)(const BK(model) *m, double *y) {
    double x[1 + 3 * BK_NQ + BK_ROOM(BK_NC)] = {0};
    bk_gather(m, x);
    bk_outputs(x, m->s.p, y);
}
