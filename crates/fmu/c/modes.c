/* ---- What switches: kinks, stops, dry friction, clocks and latches ----------------------------------------
 *
 *     kink       sigma u >= 0             the branch taken is that of the side
 *     stop       phi <= 0, lambda >= 0    apart or in contact, pushing but never pulling
 *     friction   |lambda| <= F0           while it sticks; lambda = -sign(p') F while it slides
 *
 * Between two events all modes are numbers. At an event those that the state leaves open are tried in a fixed
 * order until the motion that follows agrees with them; in an impact velocities change at once by Newton's law of
 * restitution. Source: Glocker and Pfeiffer (1996), sections 5.2, 5.3 and 8.2. */

#define BK_POSITION_BAND 1.4210854715202004e-14
#define BK_RATE_BAND (1e-3 * BK_ATOL)
#define BK_MODES (BK_NP - BK_NOWN)
#define BK_MOST_SETS 4096

#if BK_NZ > 0
/* u of every switch, then four numbers of every contact. */
static void bk_indicate(bk_model *m, const double *lambda) {
    double x[1 + 2 * BK_NQ + BK_ROOM(BK_NC)] = {0};
    x[0] = m->s.t;
    bk_copy(x + 1, m->s.q, BK_NQ);
    bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
    bk_copy(x + 1 + 2 * BK_NQ, lambda, BK_NC);
    bk_indicators(x, m->s.p, m->w.indicators);
}

static int bk_is_active(const bk_model *m, int contact) {
    return m->s.p[bk_contact_at[contact]] != 0.0;
}

/* Each indicator with the sign that is positive while its mode lasts. */
static void bk_signed(bk_model *m, double *z) {
    int k;
    bk_indicate(m, m->s.lambda);
    for (k = 0; k < BK_NK; k++) {
        z[k] = m->s.p[BK_NOWN + k] * m->w.indicators[k];
    }
    for (k = 0; k < BK_NT; k++) {
        const double *four = m->w.indicators + BK_NK + 4 * k;
        const double force = m->s.lambda[bk_contact_row[k]];
        double *out = z + BK_NK + k;
        if (bk_is_friction[k]) {
            *out = bk_is_active(m, k) ? fmax(four[3], 0.0) - fabs(force) : m->s.p[bk_contact_at[k] + 1] * four[1];
        } else {
            *out = bk_is_active(m, k) ? force : -four[0];
        }
    }
}

/* The event indicators: an event is where one of them falls to zero. */
static void bk_events(bk_model *m, double *z) {
    int i;
    bk_signed(m, z);
    for (i = 0; i < BK_NZ; i++) {
        z[i] += m->s.raise[i];
        if (z[i] == 0.0) {
            z[i] = DBL_MIN;
        }
    }
}

/* Raises every indicator by its rounding, and by what it lacks to zero now; `fired` are those that fell below zero. */
static void bk_raise(bk_model *m, const char *fired) {
    double z[BK_ROOM(BK_NZ)] = {0};
    double size = 0.0;
    int k;
    bk_signed(m, z);
    for (k = 0; k < BK_NT; k++) {
        if (bk_is_active(m, k)) {
            size = fmax(size, fmax(fabs(m->s.lambda[bk_contact_row[k]]), fmax(m->w.indicators[BK_NK + 4 * k + 2], 0.0)));
        }
    }
    for (k = 0; k < BK_NK; k++) {
        m->s.raise[k] = (bk_is_timed[k] ? 0.0 : BK_RATE_BAND + 1e-12 * fabs(z[k])) + fmax(-z[k], 0.0);
    }
    for (k = 0; k < BK_NT; k++) {
        const double band = bk_is_active(m, k) ? 1e-9 * size : bk_is_friction[k] ? BK_RATE_BAND : BK_POSITION_BAND;
        double *raise = m->s.raise + BK_NK + k;
        /* A gap that opens slowly falls below zero again by the errors of the integrator, without an impact: from
         * event to event it gets more room, until that covers them. */
        const int is_again = fired[BK_NK + k] && !bk_is_active(m, k) && !bk_is_friction[k];
        const double room = is_again ? fmin(4.0 * *raise, 1e-6 * fmax(bk_largest(m->s.q, BK_NQ), 1.0)) : 0.0;
        *raise = fmax(band, room) + fmax(-z[BK_NK + k], 0.0);
    }
}

/* Accelerations in the present modes; rows that follow from others must agree with them. */
static int bk_try_modes(bk_model *m) {
    int i, j;
    double size;
    bk_choose_rows(m);
    if (bk_complete(m) != BK_OK) {
        return 0;
    }
    size = 1.0 + bk_largest(m->s.a, BK_NQ) + bk_largest(m->w.gamma, BK_NC);
    for (i = 0; i < BK_NC; i++) {
        double rest = m->w.gamma[i];
        for (j = 0; j < BK_NQ; j++) {
            rest += m->w.g[i * BK_NQ + j] * m->s.a[j];
        }
        if (!(fabs(rest) <= 1e-6 * size)) {
            return 0;
        }
    }
    return 1;
}

typedef struct {
    int is_contact;
    int of;                /* which of the contacts, or of the switches */
    int n_choices;
    double choices[3][3];  /* the numbers of the mode */
} bk_open_mode;

typedef struct {
    double before[BK_ROOM(BK_MODES)];
    char fired[BK_ROOM(BK_NZ)];
    char grazes[BK_ROOM(BK_NT)];
    double rate_band;
} bk_instant;

static int bk_was_active(const bk_instant *at, int contact) {
    return at->before[bk_contact_at[contact] - BK_NOWN] != 0.0;
}

static int bk_is_kept(const bk_model *m, const bk_instant *at, int k, double rate) {
    const double drift = 10.0 * BK_ATOL * fmax(bk_largest(m->s.v, BK_NQ), 1.0);
    return !bk_is_friction[k] && bk_was_active(at, k) && fabs(rate) <= drift;
}

static int bk_is_at_rest(const bk_model *m, const bk_instant *at, int k) {
    const double rate = m->w.indicators[BK_NK + 4 * k + 1];
    return (bk_is_friction[k] && !bk_was_active(at, k) && at->fired[BK_NK + k]) || at->grazes[k]
        || bk_is_kept(m, at, k, rate) || fabs(rate) <= 4.0 * at->rate_band;
}

static int bk_is_closed(const bk_model *m, int k) {
    const double depth = m->w.indicators[BK_NK + 4 * k];
    return (bk_is_active(m, k) && depth > -1e-6 * fmax(bk_largest(m->s.q, BK_NQ), 1.0))
        || depth >= -4.0 * BK_POSITION_BAND;
}

/* Gives a contact its mode: closed or sticking, sign of sliding, place where it sticks. */
static void bk_set_contact(bk_model *m, int k, double holds, double slip, double place) {
    double *mode = m->s.p + bk_contact_at[k];
    mode[0] = holds;
    if (bk_is_friction[k]) {
        mode[1] = slip;
        mode[2] = place;
    }
}

/* Decides every mode that the state decides; a kink inside another comes first. */
static void bk_decide(bk_model *m, const bk_instant *at) {
    int k, round;
    for (round = 0; round <= BK_NK; round++) {
        bk_indicate(m, m->w.zeros);
        for (k = 0; k < BK_NK; k++) {
            const double u = m->w.indicators[k];
            if (fabs(u) > (bk_is_timed[k] ? 0.0 : BK_RATE_BAND + 1e-12 * fabs(u))) {
                m->s.p[BK_NOWN + k] = u < 0.0 ? -1.0 : 1.0;
            } else if (at->fired[k]) {
                m->s.p[BK_NOWN + k] = -at->before[k];
            }
        }
        for (k = 0; k < BK_NT; k++) {
            const double rate = m->w.indicators[BK_NK + 4 * k + 1];
            const int is_at_rest = bk_is_at_rest(m, at, k);
            if (bk_is_friction[k]) {
                if (!is_at_rest) {
                    bk_set_contact(m, k, 0.0, rate < 0.0 ? -1.0 : 1.0, 0.0);
                }
            } else if (!bk_is_closed(m, k) || (rate < 0.0 && !is_at_rest)) {
                bk_set_contact(m, k, 0.0, 0.0, 0.0);
            }
        }
    }
}

#if BK_NT > 0
/* phi'' of all contacts with these open; 0 where there is no motion. */
static int bk_free_rates(bk_model *m, const char *is_closed, double *rates) {
    double modes[BK_ROOM(BK_MODES)] = {0};
    double x[1 + 3 * BK_NQ];
    double out[BK_ROOM(BK_NZ)] = {0};
    int k, found;
    bk_copy(modes, m->s.p + BK_NOWN, BK_MODES);
    for (k = 0; k < BK_NT; k++) {
        if (is_closed[k]) {
            bk_set_contact(m, k, 0.0, 0.0, 0.0);
        }
    }
    found = bk_try_modes(m);
    if (found) {
        x[0] = m->s.t;
        bk_copy(x + 1, m->s.q, BK_NQ);
        bk_copy(x + 1 + BK_NQ, m->s.v, BK_NQ);
        bk_copy(x + 1 + 2 * BK_NQ, m->s.a, BK_NQ);
        bk_rates(x, m->s.p, out);
        bk_copy(rates, out + BK_NK, BK_NT);
    }
    bk_copy(m->s.p + BK_NOWN, modes, BK_MODES);
    return found;
}
#endif
#endif
