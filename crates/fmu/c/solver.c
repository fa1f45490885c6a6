/* ---- The solver: what the header declares -------------------------------------------------------------------- */

/* Passes a change of inputs, and moves by h; with `locates` 0 events are taken at the ends of steps. */
BK_API int BK(step)(BK(model) *m, double h) {
    int is_event;
    int found;
    const double end = m->s.t + h;
    bk_apply_values(m);
    m->s.fixed = h;
    found = bk_complete(m);
    if (found == BK_OK && m->s.has_changed) {
        found = bk_pass(m);
        m->s.has_changed = 0;
    }
    return found != BK_OK ? found : bk_advance_until(m, end, 0, &is_event);
}

/* Moves to `t_end` by steps that keep the tolerance. */
BK_API int BK(advance)(BK(model) *m, double t_end) {
    int is_event;
    int found;
    bk_apply_values(m);
    m->s.fixed = 0.0;
    found = bk_complete(m);
    if (found == BK_OK && m->s.has_changed) {
        found = bk_pass(m);
        m->s.has_changed = 0;
    }
    return found != BK_OK ? found : bk_advance_until(m, t_end, 0, &is_event);
}

/* Sets an input, a parameter or a start value by its number in the header. Parameters of bodies and joints, and
 * start values, count from the next start on. */
BK_API void BK(set)(BK(model) *m, int value, double x) {
    if (value >= 0 && value < BK_NV) {
        m->s.value[value] = x;
        m->s.has_changed = 1;
    }
}

BK_API double BK(get)(const BK(model) *m, int value) {
    return value >= 0 && value < BK_NV ? m->s.value[value] : (double)NAN;
}

BK_API double BK(time)(const BK(model) *m) {
    return m->s.t;
}
