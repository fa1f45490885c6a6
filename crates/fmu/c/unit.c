/* ---- What both versions of the interface share ---------------------------------------------------------------
 *
 * Value references, one after the other: time; states; their rates; event indicators; outputs; values that can be
 * set, inputs first; parameters that follow from others. */

enum { BK_INSTANTIATED, BK_INITIALIZATION, BK_EVENT, BK_CONTINUOUS, BK_STEP, BK_TERMINATED };
enum { BK_VR_X = 1, BK_VR_DX = BK_VR_X + BK_NX, BK_VR_Z = BK_VR_DX + BK_NX, BK_VR_Y = BK_VR_Z + BK_NZ,
       BK_VR_V = BK_VR_Y + BK_NY, BK_VR_C = BK_VR_V + BK_NV, BK_VR_END = BK_VR_C + BK_NCALCULATED };

typedef struct bk_unit bk_unit;
struct bk_unit {
    bk_model m;
    int is_exchange, uses_events, may_return;
    void *environment;
    void (*say)(const bk_unit *u, const char *text);
    void *callbacks[2];
    const char *name;
};

static const char *bk_words(int fault) {
    switch (fault) {
    case BK_NO_MOTION: return "there are no finite accelerations in this state";
    case BK_NO_POSE: return "the loops cannot be closed at these states, near the last completed step";
    case BK_NO_MODES: return "no modes of stops and friction are consistent here";
    case BK_NO_START: return "the loops cannot be closed at these parameters and start values";
    case BK_NO_STEP: return "steps become too small, or events follow each other without end";
    default: return "the call is not allowed here";
    }
}

static int bk_fails(const bk_unit *u, int fault) {
    if (fault != BK_OK && u->say) {
        u->say(u, bk_words(fault));
    }
    return fault != BK_OK;
}

static void bk_begin(bk_unit *u) {
    BK(init)(&u->m);
    u->m.s.phase = BK_INSTANTIATED;
    u->m.s.is_stale = 1;
}

/* The start, once all values are known. */
static int bk_start_unit(bk_unit *u) {
    int found;
    if (!u->m.s.is_stale) {
        return BK_OK;
    }
    u->m.s.t = u->m.s.t_start;
    found = BK(start)(&u->m);
    if (found == BK_OK) {
        bk_choose_free(&u->m);
        bk_base(&u->m);
        bk_states(&u->m);
        u->m.s.is_stale = 0;
        u->m.s.has_changed = 0;
    }
    return found;
}

/* Everything up to date with time, states and values. */
static int bk_refresh(bk_unit *u) {
    int found = BK_OK;
    if (!u->m.s.is_stale) {
        return BK_OK;
    }
    if (u->m.s.phase <= BK_INITIALIZATION) {
        return bk_start_unit(u);
    }
    bk_apply_values(&u->m);
    if (u->is_exchange) {
        found = bk_place(&u->m);
    }
    if (found == BK_OK) {
        found = bk_complete(&u->m);
    }
    u->m.s.is_stale = found != BK_OK;
    return found;
}

static int bk_get(bk_unit *u, unsigned vr, double *value) {
    int found;
    if (vr >= BK_VR_END) {
        return -1;
    }
    if (vr >= BK_VR_V && vr < BK_VR_C) {
        *value = u->m.s.value[vr - BK_VR_V];
        return BK_OK;
    }
    if (vr >= BK_VR_C) {
        bk_apply_values(&u->m);
        *value = u->m.s.p[bk_calculated[vr - BK_VR_C]];
        return BK_OK;
    }
    if (vr == 0) {
        *value = u->m.s.phase <= BK_INITIALIZATION ? u->m.s.t_start : u->m.s.t;
        return BK_OK;
    }
    found = bk_refresh(u);
    if (found != BK_OK) {
        return found;
    }
    if (vr < BK_VR_DX) {
        *value = u->m.s.x[vr - BK_VR_X];
    } else if (vr < BK_VR_Z) {
        const unsigned i = vr - BK_VR_DX;
        *value = i < BK_NF ? u->m.s.v[u->m.s.free[i]] : u->m.s.a[u->m.s.free[(i - BK_NF) % BK_ROOM(BK_NF)]];
    } else if (vr < BK_VR_Y) {
#if BK_NZ > 0
        double z[BK_NZ];
        bk_events(&u->m, z);
        *value = z[vr - BK_VR_Z];
#endif
    } else {
        if (!u->m.w.has_outputs || memcmp(&u->m.w.outputs_of, &u->m.s, sizeof u->m.s) != 0) {
            BK(outputs)(&u->m, u->m.w.outputs);
            memcpy(&u->m.w.outputs_of, &u->m.s, sizeof u->m.s);
            u->m.w.has_outputs = 1;
        }
        *value = u->m.w.outputs[vr - BK_VR_Y];
    }
    return BK_OK;
}

/* The rates of the states. At states that an integrator tries and that do not close they are those of the last pose
 * on the way there: its step then fails by its own error, and a completed one is refused. */
static int bk_state_rates(bk_unit *u, double *dx) {
    int found = bk_refresh(u), i;
    if (found == BK_NO_POSE && u->m.s.phase == BK_CONTINUOUS) {
        found = bk_complete(&u->m);
    }
    for (i = 0; i < BK_NF && found == BK_OK; i++) {
        dx[i] = u->m.s.v[u->m.s.free[i]];
        dx[BK_NF + i] = u->m.s.a[u->m.s.free[i]];
    }
    return found;
}

static int bk_put(bk_unit *u, unsigned vr, double value) {
    const int is_begun = u->m.s.phase > BK_INITIALIZATION;
    if (vr < BK_VR_V || vr >= BK_VR_C || (is_begun && vr >= BK_VR_V + BK_NU)) {
        return -1;
    }
    if (u->m.s.value[vr - BK_VR_V] != value) {
        u->m.s.value[vr - BK_VR_V] = value;
        u->m.s.is_stale = 1;
        u->m.s.has_changed = 1;
    }
    return BK_OK;
}

/* Passes what happens at an instant; 1 in `is_moved` where the states are others than before. */
static int bk_update(bk_unit *u, int *is_moved) {
    double before[BK_ROOM(BK_NX)] = {0};
    int found = bk_refresh(u), i;
    *is_moved = 0;
    if (found != BK_OK) {
        return found;
    }
    bk_copy(before, u->m.s.x, BK_NX);
    found = bk_pass(&u->m);
    if (found != BK_OK) {
        return found;
    }
    if (bk_wants_others(&u->m)) {
        bk_choose_free(&u->m);
    }
    bk_base(&u->m);
    bk_states(&u->m);
    for (i = 0; i < BK_NX; i++) {
        *is_moved |= before[i] != u->m.s.x[i];
    }
    u->m.s.has_changed = 0;
    return BK_OK;
}

static int bk_complete_step(bk_unit *u, int *wants_event) {
    int found = bk_refresh(u);
    *wants_event = 0;
    if (found != BK_OK) {
        return found;
    }
    found = bk_renew(&u->m);
    bk_base(&u->m);
    *wants_event = bk_wants_others(&u->m);
#if BK_NT > 0
    {
        int i;
        bk_constrain(&u->m, u->m.s.t, u->m.s.q);
        for (i = BK_NB; i < BK_NC; i++) {
            *wants_event |= u->m.s.active[i] && fabs(u->m.w.gap[i]) > 1e-9 * (1.0 + bk_largest(u->m.s.q, BK_NQ));
        }
    }
#endif
    return found;
}

static int bk_next_time(bk_unit *u, double *t) {
#if BK_NCLOCKS > 0
    *t = bk_next_tick(&u->m);
    return 1;
#else
    (void)u;
    (void)t;
    return 0;
#endif
}

/* One step of co-simulation; `event` says that it ended before an event that is not passed yet. */
static int bk_do_step(bk_unit *u, double t, double h, int *event) {
    int found;
    *event = 0;
    if (!(h > 0.0) || fabs(t - u->m.s.t) > 1e-9 * (1.0 + fabs(t)) + 1e-6 * h) {
        return -1;
    }
    found = bk_refresh(u);
    if (found == BK_OK && (u->m.s.has_changed || u->m.s.is_at_event)) {
        found = bk_pass(&u->m);
        u->m.s.has_changed = 0;
        u->m.s.is_at_event = 0;
    }
    u->m.s.fixed = bk_fixed_step(&u->m);
    if (found == BK_OK) {
        found = bk_advance_until(&u->m, t + h, u->uses_events || u->may_return, event);
        u->m.s.is_at_event = *event;
    }
    return found;
}

static int bk_direction(bk_unit *u, const unsigned *unknown, size_t n_unknown, const unsigned *known, size_t n_known,
                        const double *seed, double *out) {
    double dx[BK_ROOM(BK_NX)] = {0}, du[BK_ROOM(BK_NU)] = {0}, ddx[BK_ROOM(BK_NX)] = {0}, dy[BK_ROOM(BK_NYO)] = {0};
    double dt = 0.0;
    size_t i;
    int found = bk_refresh(u);
    if (found != BK_OK) {
        return found;
    }
    memset(dx, 0, sizeof dx);
    memset(du, 0, sizeof du);
    for (i = 0; i < n_known; i++) {
        const unsigned vr = known[i];
        if (vr == 0) {
            dt += seed[i];
        } else if (vr < BK_VR_DX) {
            dx[vr - BK_VR_X] += seed[i];
        } else if (vr >= BK_VR_V && vr < BK_VR_V + BK_NU) {
            du[vr - BK_VR_V] += seed[i];
        } else {
            return -1;
        }
    }
    found = bk_along(&u->m, dt, dx, du, ddx, dy);
    if (found != BK_OK) {
        return found;
    }
    for (i = 0; i < n_unknown; i++) {
        const unsigned vr = unknown[i];
        if (vr >= BK_VR_DX && vr < BK_VR_Z) {
            out[i] = ddx[vr - BK_VR_DX];
        } else if (vr >= BK_VR_Y && vr < BK_VR_Y + BK_NYO) {
            out[i] = dy[vr - BK_VR_Y];
        } else if (vr >= BK_VR_X && vr < BK_VR_DX) {
            out[i] = dx[vr - BK_VR_X];
        } else {
            return -1;
        }
    }
    return BK_OK;
}
