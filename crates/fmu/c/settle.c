/* ---- The modes that go with a state, and everything that happens at an instant ------------------------------- */

#if BK_NZ > 0
/* The modes that the state leaves open, held first. */
static int bk_open_modes(bk_model *m, const bk_instant *at, bk_open_mode *open) {
    int k, n = 0;
    bk_indicate(m, m->w.zeros);
    for (k = 0; k < BK_NK; k++) {
        const double u = m->w.indicators[k];
        if (fabs(u) <= (bk_is_timed[k] ? 0.0 : BK_RATE_BAND + 1e-12 * fabs(u)) || at->fired[k]) {
            open[n].is_contact = 0;
            open[n].of = k;
            open[n].n_choices = 2;
            open[n].choices[0][0] = m->s.p[BK_NOWN + k];
            open[n].choices[1][0] = -m->s.p[BK_NOWN + k];
            n++;
        }
    }
    for (k = 0; k < BK_NT; k++) {
        const double *before = at->before + bk_contact_at[k] - BK_NOWN;
        bk_open_mode *one = open + n;
        int i, j, count;
        if (!bk_is_at_rest(m, at, k) || (!bk_is_friction[k] && !bk_is_closed(m, k))) {
            continue;
        }
        memset(one->choices, 0, sizeof one->choices);
        count = bk_is_friction[k] ? 3 : 2;
        one->is_contact = 1;
        one->of = k;
        one->n_choices = count;
        /* One that has just let go does not hold, unless nothing else is consistent. */
        j = at->fired[BK_NK + k] && bk_was_active(at, k) ? 1 : 0;
        for (i = 0; i < count; i++) {
            double *choice = one->choices[(i + count - j) % count];
            if (i == 0) {
                choice[0] = 1.0;
                choice[2] = !bk_is_friction[k] ? 0.0 : before[0] != 0.0 ? before[2] : m->w.indicators[BK_NK + 4 * k];
            } else if (bk_is_friction[k]) {
                choice[1] = i == 1 ? 1.0 : -1.0;
            }
        }
        n++;
    }
    return n;
}

/* Whether the modes that were chosen agree with the motion that follows. */
static int bk_agrees(bk_model *m, const bk_open_mode *open, int n, double scale) {
    double x[1 + 3 * BK_NQ];
    double rates[BK_ROOM(BK_NZ)] = {0};
    const double a = bk_largest(m->s.a, BK_NQ), lambda = bk_largest(m->s.lambda, BK_NC);
    const double small = 1e-9 * fmax(a, scale) + DBL_MIN;
    int i;
    x[0] = m->s.t;
    bk_copy(x + 1, m->s.q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
    bk_copy(x + 1 + 2 * BK_NQ, m->s.a, BK_NQ);
    bk_rates(x, m->s.p, rates);
    bk_indicate(m, m->s.lambda);
    for (i = 0; i < n; i++) {
        const int k = open[i].of;
        int is_right;
        if (!open[i].is_contact) {
            const double rate = rates[k];
            const double size = fmax(fabs(rate), a + bk_largest(m->s.v, BK_NQ));
            is_right = m->s.p[BK_NOWN + k] * rate >= -1e-9 * size;
        } else {
            const double force = m->s.lambda[bk_contact_row[k]], rate = rates[BK_NK + k];
            const double limit = fmax(m->w.indicators[BK_NK + 4 * k + 3], 0.0);
            if (bk_is_friction[k]) {
                is_right = bk_is_active(m, k) ? fabs(force) <= limit + 1e-9 * fmax(limit, lambda)
                                              : m->s.p[bk_contact_at[k] + 1] * rate >= -small;
            } else {
                is_right = bk_is_active(m, k) ? force >= -1e-9 * lambda : rate <= small;
            }
        }
        if (!is_right) {
            return 0;
        }
    }
    return 1;
}

/* The first consistent combination of the modes that are open. */
static int bk_choose_modes(bk_model *m, const bk_instant *at) {
    bk_open_mode open[BK_ROOM(BK_NZ)];
    int choice[BK_ROOM(BK_NZ)] = {0};
    double largest = 0.0;
    const int n = bk_open_modes(m, at, open);
    int pass, i, j, count;
    for (pass = 0; pass < 3; pass++) {
        memset(choice, 0, sizeof choice);
        for (count = 0; count < BK_MOST_SETS; count++) {
            int is_held = 0;
            for (i = 0; i < n; i++) {
                const double *mode = open[i].choices[choice[i]];
                const int k = open[i].of;
                if (!open[i].is_contact) {
                    m->s.p[BK_NOWN + k] = mode[0];
                } else {
                    bk_set_contact(m, k, mode[0], mode[1], mode[2]);
                    is_held |= mode[0] != 0.0 && at->fired[BK_NK + k] && bk_was_active(at, k);
                }
            }
            if ((pass == 2 || !is_held) && bk_try_modes(m)) {
                if (bk_agrees(m, open, n, pass == 0 ? 0.0 : largest)) {
                    return bk_project(m) == BK_OK && bk_complete(m) == BK_OK;
                }
                largest = fmax(largest, bk_largest(m->s.a, BK_NQ));
            }
            for (i = 0; i < n && choice[i] + 1 == open[i].n_choices; i++) {
            }
            if (i == n) {
                break;
            }
            choice[i]++;
            for (j = 0; j < i; j++) {
                choice[j] = 0;
            }
        }
    }
    return 0;
}

#if BK_NR > 0
/* Takes latched values whose conditions have come to hold; 0 where there are none. */
static int bk_latch(bk_model *m) {
    double now[BK_ROOM(BK_NR)] = {0}, x[1 + 2 * BK_NQ + 2 * BK_ROOM(BK_NH)] = {0}, value;
    int i, is_taken = 0;
    bk_conditions(m->w.zeros, m->s.p, now);
    x[0] = m->s.t;
    bk_copy(x + 1, m->s.q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
    bk_copy(x + 1 + 2 * BK_NQ, m->s.p + BK_HELD, BK_NH);
    bk_copy(x + 1 + 2 * BK_NQ + BK_NH, m->s.previous, BK_NH);
    /* Backwards, so that of several rows of a signal the first counts. */
    for (i = BK_NR - 1; i >= 0; i--) {
        if (now[i] > 0.5 && !m->s.holding[i]) {
            bk_latch_values[i](x, m->s.p, &value);
            m->s.p[BK_HELD + bk_latch_signal[i]] = value;
            is_taken = 1;
        }
        m->s.holding[i] = now[i] > 0.5;
    }
    return is_taken;
}
#endif

/* Consistent modes at this instant; `fired` are the indicators that have just fallen to zero. */
static int bk_switch(bk_model *m, const char *fired) {
    bk_instant at;
    int round, i;
    at.rate_band = fmax(BK_RATE_BAND, 4.440892098500626e-16 * bk_largest(m->s.v, BK_NQ));
    for (i = 0; i < BK_NZ; i++) {
        at.fired[i] = fired[i];
    }
    for (round = 0; round < 16; round++) {
        bk_copy(at.before, m->s.p + BK_NOWN, BK_MODES);
        memset(at.grazes, 0, sizeof at.grazes);
        bk_decide(m, &at);
#if BK_NT > 0
        for (i = 0; i < 8; i++) {
            const int passed = bk_impact(m, &at);
            if (passed < 0) {
                return BK_NO_MODES;
            }
            if (!passed) {
                break;
            }
            bk_decide(m, &at);
        }
#endif
        if (!bk_choose_modes(m, &at)) {
            return BK_NO_MODES;
        }
#if BK_NR > 0
        if (bk_latch(m)) {
            memset(at.fired, 0, sizeof at.fired);
            continue;
        }
#endif
        bk_raise(m, fired);
        return BK_OK;
    }
    return BK_NO_MODES;
}
#else
static int bk_switch(bk_model *m) {
    return bk_complete(m);
}
#endif

#if BK_NCLOCKS > 0
static double bk_tick_after(const bk_model *m, int clock, double t) {
    const double start = m->s.clocks[2 * clock], every = m->s.clocks[2 * clock + 1];
    return start + fmax(floor((t - start) / every + 1e-6) + 1.0, 0.0) * every;
}

/* The first tick after the one that was passed last. */
static double bk_next_tick(const bk_model *m) {
    double next = HUGE_VAL;
    int i;
    for (i = 0; i < BK_NCLOCKS; i++) {
        next = fmin(next, bk_tick_after(m, i, m->s.tick));
    }
    return next;
}

/* Takes the values of the signals whose clocks tick now. */
static void bk_sample(bk_model *m) {
    double x[1 + 2 * BK_NQ + 2 * BK_ROOM(BK_NH)] = {0}, value;
    char is_ticking[BK_ROOM(BK_NS)] = {0};
    int i;
    for (i = 0; i < BK_NS; i++) {
        const double start = m->s.clocks[2 * bk_sampled_clock[i]], every = m->s.clocks[2 * bk_sampled_clock[i] + 1];
        const double k = floor((m->s.t - start) / every + 0.5);
        is_ticking[i] = k >= 0.0 && fabs(start + k * every - m->s.t) <= 1e-6 * every;
        if (is_ticking[i]) {
            m->s.previous[bk_sampled_signal[i]] = m->s.p[BK_HELD + bk_sampled_signal[i]];
        }
    }
    x[0] = m->s.t;
    bk_copy(x + 1, m->s.q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
    for (i = 0; i < BK_NS; i++) {
        if (is_ticking[i]) {
            bk_copy(x + 1 + 2 * BK_NQ, m->s.p + BK_HELD, BK_NH);
            bk_copy(x + 1 + 2 * BK_NQ + BK_NH, m->s.previous, BK_NH);
            bk_sample_values[i](x, m->s.p, &value);
            m->s.p[BK_HELD + bk_sampled_signal[i]] = value;
        }
    }
    m->s.tick = m->s.t;
}
#endif

/* Passes whatever happens at this instant: ticks, events, new values of inputs. */
static int bk_pass(bk_model *m) {
#if BK_NZ > 0
    char fired[BK_ROOM(BK_NZ)] = {0};
    double z[BK_ROOM(BK_NZ)] = {0};
    int i;
    bk_events(m, z);
    for (i = 0; i < BK_NZ; i++) {
        fired[i] = z[i] < 0.0;
    }
#endif
#if BK_NCLOCKS > 0
    if (m->s.t - bk_next_tick(m) >= -1e-9 * fmax(fabs(m->s.t), 1e-3)) {
        bk_sample(m);
    }
#endif
#if BK_NZ > 0
    return bk_switch(m, fired);
#else
    return bk_switch(m);
#endif
}
