/* ---- Impacts: M (v+ - v-) + G' L + J' P = 0, J v+ = -eps J v- of the stops that take an impulse ------------------ */

#if BK_NT > 0
/* One impact: 1 passed, 0 none, -1 without an answer. */
static int bk_impact(bk_model *m, bk_instant *at) {
    char is_closed[BK_ROOM(BK_NT)] = {0}, active[BK_ROOM(BK_NC)] = {0}, all[BK_ROOM(BK_NC)] = {0};
    double epsilon[BK_ROOM(BK_NT)] = {0}, approach[BK_ROOM(BK_NT)] = {0}, pressing[BK_ROOM(BK_NT)] = {0};
    double modes[BK_ROOM(BK_MODES)] = {0}, x[BK_ROOM(BK_N)] = {0}, v[BK_NQ], rates[BK_ROOM(BK_NC)] = {0};
    double worst = 0.0, fastest = 0.0;
    int closed[BK_ROOM(BK_NT)] = {0};
    int i, j, k, n = 0, is_hit = 0, knows_pressing;
    unsigned long set;
    bk_indicate(m, m->w.zeros);
    for (k = 0; k < BK_NT; k++) {
        const double rate = m->w.indicators[BK_NK + 4 * k + 1];
        is_closed[k] = (char)(!bk_is_friction[k] && bk_is_closed(m, k));
        if (is_closed[k]) {
            is_hit |= rate > 4.0 * at->rate_band && !bk_is_kept(m, at, k, rate);
            epsilon[n] = m->w.indicators[BK_NK + 4 * k + 2];
            closed[n++] = k;
        }
    }
    knows_pressing = n > 0 && bk_free_rates(m, is_closed, pressing);
    bk_copy(modes, m->s.p + BK_NOWN, BK_MODES);
    for (k = 0; k < BK_NT; k++) {
        if (is_closed[k]) {
            bk_set_contact(m, k, 1.0, 0.0, 0.0);
        } else if (bk_is_friction[k] && bk_is_active(m, k)) {
            bk_set_contact(m, k, 0.0, 0.0, 0.0);
        }
    }
    /* Onto the stops themselves, which the event has passed by rounding. */
    bk_choose_rows(m);
    bk_copy(v, m->s.v, BK_NQ);
    if (bk_largest(m->w.gap, BK_NC) > 1e-6 * fmax(bk_largest(m->s.q, BK_NQ), 1.0) || bk_project(m) != BK_OK) {
        return -1;
    }
    bk_copy(m->s.v, v, BK_NQ);
    bk_evaluate(m, m->s.t, m->s.q, m->s.v, m->w.zeros);
    bk_constrain(m, m->s.t, m->s.q);
    /* The rows that hold throughout, and whether the velocities break them. */
    bk_copy(m->w.rows, m->w.g, BK_NC * BK_NQ);
    for (i = 0; i < BK_NC; i++) {
        int is_out = i < BK_NB && !m->s.active[i];
        for (k = 0; k < n; k++) {
            is_out |= bk_contact_row[closed[k]] == i;
        }
        rates[i] = m->w.g_rate[i];
        for (j = 0; j < BK_NQ; j++) {
            rates[i] += m->w.g[i * BK_NQ + j] * v[j];
            m->w.rows[i * BK_NQ + j] *= is_out ? 0.0 : 1.0;
        }
    }
    bk_least(m->w.rows, rates, BK_NC, x, all);
    for (i = 0; i < BK_NC; i++) {
        worst = all[i] ? fmax(worst, fabs(rates[i])) : worst;
    }
    if (!is_hit && !(worst > 1e-5 * (1.0 + bk_largest(v, BK_NQ)))) {
        bk_copy(m->s.p + BK_NOWN, modes, BK_MODES);
        return 0;
    }
    for (k = 0; k < n; k++) {
        const double rate = rates[bk_contact_row[closed[k]]], back = epsilon[k] * rate;
        const double push = knows_pressing ? pressing[closed[k]] : 0.0;
        approach[k] = rate;
        fastest = fmax(fastest, fabs(rate));
        /* No restitution where the bounces to come are too small to be seen. */
        if ((rate <= BK_ATOL && back * back <= 2.0 * push * BK_ATOL) || back * back <= 2e3 * push * BK_POSITION_BAND) {
            epsilon[k] = 0.0;
        }
    }
    if (n > 20) {
        return -1;
    }
    for (i = 0; i < BK_NL * BK_NQ; i++) {
        m->w.slopes[i] = 0.0;
    }
    /* The stops that take an impulse, all of them first. */
    for (set = 0; set < 1ul << n; set++) {
        double largest = 0.0, speed = fastest;
        int is_right = 1;
        for (i = 0; i < BK_NC; i++) {
            active[i] = all[i];
        }
        for (k = 0; k < n; k++) {
            active[bk_contact_row[closed[k]]] = (char)!(set >> k & 1);
        }
        if (!bk_factor_system(m, active)) {
            continue;
        }
        for (i = 0; i < BK_NQ; i++) {
            x[i] = 0.0;
            for (j = 0; j < BK_NQ; j++) {
                x[i] += m->w.mass[i * BK_NQ + j] * v[j];
            }
        }
        for (i = 0; i < BK_NC; i++) {
            x[BK_NQ + i] = active[i] ? -m->w.g_rate[i] : 0.0;
        }
        for (k = 0; k < n; k++) {
            const int row = bk_contact_row[closed[k]];
            x[BK_NQ + row] = active[row] ? -m->w.g_rate[row] - epsilon[k] * approach[k] : 0.0;
        }
        bk_solve(m->w.k, m->w.pivot, BK_N, x);
        if (!(bk_largest(x, BK_N) < HUGE_VAL)) {
            continue;
        }
        for (k = 0; k < n; k++) {
            largest = fmax(largest, fabs(x[BK_NQ + bk_contact_row[closed[k]]]));
        }
        for (k = 0; k < n; k++) {
            const int row = bk_contact_row[closed[k]];
            double rate = m->w.g_rate[row];
            for (j = 0; j < BK_NQ; j++) {
                rate += m->w.g[row * BK_NQ + j] * x[j];
            }
            speed = fmax(speed, fabs(rate));
            is_right &= rate + epsilon[k] * approach[k] <= 1e-9 * speed;
            is_right &= x[BK_NQ + row] >= -1e-9 * largest;
        }
        if (is_right) {
            bk_copy(m->s.v, x, BK_NQ);
            bk_copy(m->s.p + BK_NOWN, modes, BK_MODES);
            /* Bodies between two stops would else hit them by turns without end. */
            bk_indicate(m, m->w.zeros);
            for (k = 0; k < n; k++) {
                rates[k] = m->w.indicators[BK_NK + 4 * closed[k] + 1];
            }
            if (bk_free_rates(m, is_closed, pressing)) {
                for (k = 0; k < n; k++) {
                    at->grazes[closed[k]] = rates[k] < 0.0
                        && rates[k] * rates[k] <= 2e3 * pressing[closed[k]] * BK_POSITION_BAND;
                }
            }
            return 1;
        }
    }
    return -1;
}
#endif
