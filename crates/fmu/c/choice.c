/* ---- Free coordinates: the states of model exchange ---------------------------------------------------------
 *
 * Of nq coordinates that keep r conditions, nq - r are free and are the states, with their rates; the others follow
 * by Newton's method from the pose of the last completed step. Which are free is chosen by pivots, and chosen again
 * where others have become much better. */

#define BK_R BK_RANK
#define BK_NX (2 * BK_NF)

/* Factors the columns of G that belong to the coordinates that follow. */
static int bk_factor_followers(bk_model *m) {
    int i, j, n = 0;
    for (i = 0; i < BK_NB; i++) {
        if (!m->s.active[i]) {
            continue;
        }
        for (j = 0; j < BK_R; j++) {
            m->w.k[n * BK_R + j] = m->w.g[i * BK_NQ + m->s.follows[j]];
        }
        n++;
    }
    return bk_factor(m->w.k, m->w.pivot, BK_R);
}

/* Gathers the rows that take part. */
static void bk_independent(const bk_model *m, const double *all, double *rows) {
    int i, n = 0;
    for (i = 0; i < BK_NB; i++) {
        if (m->s.active[i]) {
            rows[n++] = all[i];
        }
    }
}

/* The largest change of a follower by one free coordinate, lengths in those of the longest link; infinite in a pose where these cannot be free. */
static double bk_spread(bk_model *m) {
    double column[BK_ROOM(BK_NC)] = {0}, rows[BK_ROOM(BK_NC)] = {0};
    double most = 0.0;
    int i, j;
    bk_constrain(m, m->s.t, m->s.q);
    if (BK_R == 0) {
        return 0.0;
    }
    if (!bk_factor_followers(m)) {
        return HUGE_VAL;
    }
    for (j = 0; j < BK_NF; j++) {
        for (i = 0; i < BK_NC; i++) {
            column[i] = m->w.g[i * BK_NQ + m->s.free[j]];
        }
        bk_independent(m, column, rows);
        bk_solve(m->w.k, m->w.pivot, BK_R, rows);
        for (i = 0; i < BK_R; i++) {
            most = fmax(most, fabs(rows[i]) * bk_size[m->s.free[j]] / bk_size[m->s.follows[i]]);
        }
    }
    return most;
}

/* Chooses the free coordinates by elimination with the largest pivots. */
static void bk_choose_free(bk_model *m) {
    char is_follower[BK_NQ], is_used[BK_ROOM(BK_NC)] = {0};
    int i, j, k, n = 0;
    memset(is_follower, 0, sizeof is_follower);
    memset(is_used, 0, sizeof is_used);
    bk_constrain(m, m->s.t, m->s.q);
    for (k = 0; k < BK_R; k++) {
        double most = -1.0;
        int row = 0, column = 0;
        for (i = 0; i < BK_NB; i++) {
            for (j = 0; j < BK_NQ; j++) {
                const double size = fabs(m->w.g[i * BK_NQ + j]) * bk_size[j];
                /* Among equal ones, the last coordinate follows. */
                if (!is_used[i] && m->s.active[i] && !is_follower[j] && size >= most * (1.0 + 1e-9)) {
                    most = size;
                    row = i;
                    column = j;
                }
            }
        }
        is_used[row] = 1;
        is_follower[column] = 1;
        for (i = 0; i < BK_NB; i++) {
            if (!is_used[i] && m->s.active[i] && most > 0.0) {
                const double factor = m->w.g[i * BK_NQ + column] / m->w.g[row * BK_NQ + column];
                for (j = 0; j < BK_NQ; j++) {
                    m->w.g[i * BK_NQ + j] -= factor * m->w.g[row * BK_NQ + j];
                }
            }
        }
    }
    k = 0;
    for (j = 0; j < BK_NQ; j++) {
        if (is_follower[j]) {
            m->s.follows[n++] = j;
        } else {
            m->s.free[k++] = j;
        }
    }
}

/* 1 where other coordinates have become much better ones. */
static int bk_wants_others(bk_model *m) {
    const double now = bk_spread(m);
    double best;
    bk_state *kept = &m->w.from;
    if (now < 2.5) {
        return 0;
    }
    *kept = m->s;
    bk_choose_free(m);
    best = bk_spread(m);
    m->s = *kept;
    return !(best > 0.7 * now);
}

/* Takes the pose of now as the one that later ones are found from. */
static void bk_base(bk_model *m) {
    m->s.base_t = m->s.t;
    bk_copy(m->s.base_q, m->s.q, BK_NQ);
}

/* The states that belong to the coordinates. */
static void bk_states(bk_model *m) {
    int i;
    for (i = 0; i < BK_NF; i++) {
        m->s.x[i] = m->s.q[m->s.free[i]];
        m->s.x[BK_NF + i] = m->s.v[m->s.free[i]];
    }
}

/* Finds the followers in q; 0 where they are not near. */
static int bk_close(bk_model *m, double t, double *q) {
    double rows[BK_ROOM(BK_NC)] = {0};
    double last = HUGE_VAL;
    int round, i, is_last = 0;
    if (BK_R == 0) {
        return 1;
    }
    for (round = 0; round < 12; round++) {
        double size, scale = 1.0 + bk_largest(q, BK_NQ);
        bk_constrain(m, t, q);
        if (!bk_factor_followers(m)) {
            return 0;
        }
        bk_independent(m, m->w.gap, rows);
        bk_solve(m->w.k, m->w.pivot, BK_R, rows);
        size = bk_largest(rows, BK_R);
        if (!(size < 0.5 * scale) || (!is_last && size > 0.5 * last)) {
            return 0;
        }
        for (i = 0; i < BK_R; i++) {
            q[m->s.follows[i]] -= rows[i];
        }
        if (is_last || size == 0.0) {
            return 1;
        }
        is_last = size < 1e-8 * scale;
        last = size;
    }
    return 0;
}

/* Coordinates and velocities from the states, by as many steps from the last pose as it takes; BK_NO_POSE with the last
 * pose on the way that closes. */
static int bk_place(bk_model *m) {
    double q[BK_NQ], from[BK_NQ], rows[BK_ROOM(BK_NC)] = {0}, rates[BK_ROOM(BK_NC)] = {0};
    double done = 0.0, part = 1.0;
    const double t = m->s.t;
    int i, j, found = BK_OK;
    bk_copy(from, m->s.base_q, BK_NQ);
    while (done < 1.0) {
        const double next = fmin(1.0, done + part);
        bk_copy(q, from, BK_NQ);
        for (i = 0; i < BK_NF; i++) {
            const double base = m->s.base_q[m->s.free[i]];
            q[m->s.free[i]] = next == 1.0 ? m->s.x[i] : base + next * (m->s.x[i] - base);
        }
        if (bk_close(m, m->s.base_t + next * (t - m->s.base_t), q)) {
            bk_copy(from, q, BK_NQ);
            done = next;
        } else {
            part *= 0.5;
            if (part < 1.0 / 128.0) {
                found = BK_NO_POSE;
                break;
            }
        }
    }
    bk_copy(m->s.q, from, BK_NQ);
    for (i = 0; i < BK_NF; i++) {
        m->s.v[m->s.free[i]] = m->s.x[BK_NF + i];
    }
    if (BK_R > 0) {
        bk_constrain(m, t, m->s.q);
        if (!bk_factor_followers(m)) {
            return BK_NO_POSE;
        }
        for (i = 0; i < BK_NC; i++) {
            rates[i] = m->w.g_rate[i];
            for (j = 0; j < BK_NF; j++) {
                rates[i] += m->w.g[i * BK_NQ + m->s.free[j]] * m->s.x[BK_NF + j];
            }
        }
        bk_independent(m, rates, rows);
        bk_solve(m->w.k, m->w.pivot, BK_R, rows);
        for (i = 0; i < BK_R; i++) {
            m->s.v[m->s.follows[i]] = -rows[i];
        }
    }
    return found;
}

/* Followers of a change: rows of G have what is needed of them. */
static void bk_follow_on(bk_model *m, const double *needed, double *change) {
    double rates[BK_ROOM(BK_NC)] = {0}, rows[BK_ROOM(BK_NC)] = {0};
    int i, j;
    if (BK_R == 0) {
        return;
    }
    for (i = 0; i < BK_NC; i++) {
        rates[i] = needed[i];
        for (j = 0; j < BK_NF; j++) {
            rates[i] += m->w.g[i * BK_NQ + m->s.free[j]] * change[m->s.free[j]];
        }
    }
    bk_independent(m, rates, rows);
    bk_solve(m->w.k, m->w.pivot, BK_R, rows);
    for (i = 0; i < BK_R; i++) {
        change[m->s.follows[i]] = -rows[i];
    }
}

/* The change of rates of the states, and of outputs, along a change of time, states and inputs. */
static int bk_along(bk_model *m, double dt, const double *dx, const double *du, double *ddx, double *dy) {
    double dq[BK_NQ], dv[BK_NQ], da[BK_NQ], dlambda[BK_ROOM(BK_NC)] = {0}, needed[BK_ROOM(BK_NC)] = {0};
    double x[2 + 6 * BK_NQ + 2 * BK_NC + BK_ROOM(BK_NU)] = {0};
    int i;
    if (bk_complete(m) != BK_OK) {
        return BK_NO_MOTION;
    }
    memset(dq, 0, sizeof dq);
    memset(dv, 0, sizeof dv);
    for (i = 0; i < BK_NF; i++) {
        dq[m->s.free[i]] = dx[i];
        dv[m->s.free[i]] = dx[BK_NF + i];
    }
    bk_constrain(m, m->s.t, m->s.q);
    if (BK_R > 0 && !bk_factor_followers(m)) {
        return BK_NO_POSE;
    }
    for (i = 0; i < BK_NC; i++) {
        needed[i] = m->w.g_rate[i] * dt;
    }
    bk_follow_on(m, needed, dq);
    if (bk_complete(m) != BK_OK) {
        return BK_NO_MOTION;
    }
    bk_follow(m, dt, dq, m->w.zeros, du, da, dlambda);
    bk_copy(needed, m->w.drift, BK_NC);
    bk_constrain(m, m->s.t, m->s.q);
    if (BK_R > 0 && !bk_factor_followers(m)) {
        return BK_NO_POSE;
    }
    bk_follow_on(m, needed, dv);
    if (bk_complete(m) != BK_OK) {
        return BK_NO_MOTION;
    }
    bk_follow(m, dt, dq, dv, du, da, dlambda);
    for (i = 0; i < BK_NF; i++) {
        ddx[i] = dx[BK_NF + i];
        ddx[BK_NF + i] = da[m->s.free[i]];
    }
    bk_gather(m, x);
    x[1 + 3 * BK_NQ + BK_NC] = dt;
    bk_copy(x + 2 + 3 * BK_NQ + BK_NC, dq, BK_NQ);
    bk_copy(x + 2 + 4 * BK_NQ + BK_NC, dv, BK_NQ);
    bk_copy(x + 2 + 5 * BK_NQ + BK_NC, da, BK_NQ);
    bk_copy(x + 2 + 6 * BK_NQ + BK_NC, dlambda, BK_NC);
    bk_copy(x + 2 + 6 * BK_NQ + 2 * BK_NC, du, BK_NU);
    bk_output_change(x, m->s.p, dy);
    return BK_OK;
}
