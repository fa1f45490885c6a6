/* ---- The start: values, positions that close the loops, velocities, modes -----------------------------------
 *
 * With the values of the model the start is the one that was computed when this file was written. Others are met
 * by the smallest steps from there: Newton's method on the constraints and the stated values. */

#define BK_NEAR 1e-12

/* All parameters follow from the values that can be set. */
static void bk_apply_values(bk_model *m) {
    double out[BK_ROOM(BK_NOWN + BK_NI)] = {0};
    bk_definitions(m->s.value, m->w.zeros, out);
    bk_copy(m->s.p, out, BK_NOWN);
    bk_copy(m->s.target, out + BK_NOWN, BK_NI);
}

/* Default values of everything; the step and the method with them. */
BK_API void BK(init)(BK(model) *m) {
    memset(m, 0, sizeof *m);
    bk_copy(m->s.value, bk_default, BK_NV);
    m->s.tolerance = BK_TOLERANCE;
    m->s.method = BK_METHOD;
    m->s.locates = 1;
    m->s.t = BK_T_START;
    bk_apply_values(m);
}

/* Rows, with their distance, of constraints (0) or their rates (1), then of stated positions or rates. */
static int bk_start_rows(bk_model *m, int level, double *gap) {
    double x[1 + 2 * BK_NQ];
    double out[BK_ROOM(BK_NI * (1 + BK_NQ))] = {0};
    int i, j, n = 0;
    bk_constrain(m, m->s.t, m->s.q);
    for (i = 0; i < BK_NB; i++) {
        double rate = m->w.g_rate[i];
        for (j = 0; j < BK_NQ; j++) {
            rate += m->w.g[i * BK_NQ + j] * m->s.v[j];
        }
        bk_copy(m->w.rows + n * BK_NQ, m->w.g + i * BK_NQ, BK_NQ);
        gap[n++] = level == 0 ? -m->w.gap[i] : -rate;
    }
    x[0] = m->s.t;
    bk_copy(x + 1, m->s.q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
    bk_initial(x, m->s.p, out);
    for (i = 0; i < BK_NI; i++) {
        if (bk_initial_level[i] == level) {
            bk_copy(m->w.rows + n * BK_NQ, out + i * (1 + BK_NQ) + 1, BK_NQ);
            gap[n++] = m->s.target[i] - out[i * (1 + BK_NQ)];
        }
    }
    return n;
}

/* Meets the constraints and stated values of a level; 0 where that fails. */
static int bk_meet(bk_model *m, int level) {
    double gap[BK_ROOM(BK_ROWS)] = {0}, change[BK_NQ];
    char taken[BK_ROOM(BK_ROWS)] = {0};
    double *x = level == 0 ? m->s.q : m->s.v;
    double last = HUGE_VAL;
    int round, i;
    for (round = 0; round < 60; round++) {
        const int n = bk_start_rows(m, level, gap);
        const double rest = bk_largest(gap, n);
        if (rest <= BK_NEAR * (1.0 + bk_largest(x, BK_NQ)) || (round > 8 && rest >= last && rest <= 1e-9)) {
            return 1;
        }
        last = rest;
        bk_least(m->w.rows, gap, n, change, taken);
        {
            /* No step by more than half a radian or half the size of the pose. */
            const double size = bk_largest(change, BK_NQ);
            const double most = level == 0 ? 0.5 * fmax(1.0, bk_largest(x, BK_NQ)) : HUGE_VAL;
            const double part = size > most ? most / size : 1.0;
            if (!(size < HUGE_VAL)) {
                return 0;
            }
            for (i = 0; i < BK_NQ; i++) {
                x[i] += part * change[i];
            }
        }
    }
    return 0;
}

/* Finds the start at these values and at the time of the model. */
BK_API int BK(start)(BK(model) *m) {
    bk_apply_values(m);
    bk_copy(m->s.q, bk_q0, BK_NQ);
    bk_copy(m->s.v, bk_v0, BK_NQ);
    bk_copy(m->s.p + BK_NOWN, bk_modes0, BK_NP - BK_NOWN);
#if BK_NH > 0
    {
        double constants[2 * BK_NCLOCKS + BK_NH];
        int i;
        bk_constants(m->w.zeros, m->s.p, constants);
        bk_copy(m->s.clocks, constants, 2 * BK_NCLOCKS);
        bk_copy(m->s.p + BK_HELD, constants + 2 * BK_NCLOCKS, BK_NH);
        bk_copy(m->s.previous, constants + 2 * BK_NCLOCKS, BK_NH);
        for (i = 0; i < BK_NR; i++) {
            m->s.holding[i] = 0;
        }
    }
#endif
    if (!bk_meet(m, 0) || !bk_meet(m, 1)) {
        return BK_NO_START;
    }
    bk_choose_rows(m);
#if BK_NCLOCKS > 0
    bk_sample(m);
#endif
    m->s.step = 0.0;
#if BK_NZ > 0
    {
        char fired[BK_NZ];
        int i;
        bk_indicate(m, m->w.zeros);
        for (i = 0; i < BK_NT; i++) {
            if (!bk_is_friction[i] && m->w.indicators[BK_NK + 4 * i] > 1e-9 * fmax(bk_largest(m->s.q, BK_NQ), 1.0)) {
                return BK_NO_START;
            }
        }
        memset(fired, 0, sizeof fired);
        return bk_switch(m, fired);
    }
#else
    return bk_switch(m);
#endif
}
