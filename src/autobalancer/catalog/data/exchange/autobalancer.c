/* A whole machine, as declared in autobalancer.h, around the compiled kernels. */

#define CHUNK 20000
#define AHEAD 16
#define MOST_STEPS 10000000 /* in one call */
enum { TIME, STEP, END, LONGEST, ERROR, TAKEN };                /* of the clock */
enum { ACCEPTED, REJECTED, EVALUATIONS, NEXT_SAMPLE, FRESH = 7 }; /* of the counts */
enum { RUNNING, FINISHED };
enum { INDICATE = 6, HAPPEN }; /* of a switch */

/* The integration may be ahead of what is shown: its steps do not depend on where somebody looks. */
#define AB_FURTHER                                                                                            \
    double ahead_times[AHEAD], ahead[AHEAD * AB_STATE_COUNT]; /* where somebody will look if he goes on as now */ \
    int64_t count;                                                                                            \
    int64_t before[AB_SPAN_WORDS]; /* what a step changes, as the last one began */

#include "block.c"

/* Kernels: int32_t name(result *, void **, arguments); a function as an argument is three words. */
typedef int32_t ab_rates_function(void *, void **, double, const double *, double *, void *);
typedef int32_t ab_switch_function(double *, void **, int64_t, double, void *, void *, void *, void *, void *);
extern ab_rates_function ab_kernel_rates;
extern ab_switch_function ab_kernel_switch;
extern int32_t ab_kernel_advance(int64_t *, void **, void *, void *, void *, void *, void *, void *, void *, void *, void *,
                                 void *, int64_t);
extern int32_t ab_kernel_observe(void *, void **, void *, void *, void *, void *, int64_t, int64_t, double *, int64_t, int64_t,
                                 int64_t, int64_t, int64_t, int64_t, int64_t, void *);

/* The state that the integration has reached is the one that is shown. */
static void show(ab_machine *m) {
    m->time = floats(m, AB_CLOCK)[TIME];
    memcpy(m->state, at(m, AB_STATE), sizeof m->state);
    m->count = 0;
}

/* The integration goes on from what is shown, with whatever is changed now. */
static void settle(ab_machine *m) {
    if (m->time < floats(m, AB_CLOCK)[TIME]) {
        floats(m, AB_CLOCK)[TIME] = m->time;
        memcpy(at(m, AB_STATE), m->state, sizeof m->state);
        m->count = 0;
    }
    m->words[AB_COUNTS + FRESH] = 0;
}

int64_t ab_steps_taken(const ab_machine *m) { return m->words[AB_COUNTS + ACCEPTED]; }

int ab_set_state(ab_machine *m, double time, const double *state) {
    for (int i = 0; i < AB_STATE_COUNT; i++)
        if (!isfinite(state[i])) return AB_WRONG;
    if (!isfinite(time)) return AB_WRONG;
    memcpy(at(m, AB_STATE), state, sizeof m->state);
    if (time < floats(m, AB_CLOCK)[TIME]) m->words[AB_SEGMENT_NOW] = 0; /* the drive begins anew, and is found again */
    floats(m, AB_CLOCK)[TIME] = time;
    m->words[AB_COUNTS + FRESH] = 0;
    show(m);
    return AB_OK;
}

static void enter_segment(ab_machine *m, double time) {
    while (!m->held && m->words[AB_SEGMENT_NOW] + 1 < AB_SEGMENT_COUNT &&
           *floats(m, AB_SEGMENTS + (m->words[AB_SEGMENT_NOW] + 1) * AB_SEGMENT_WORDS) <= time)
        m->words[AB_SEGMENT_NOW]++;
}

int ab_derivatives(ab_machine *m, double time, const double *state, double *rates) {
    void *wrong = NULL, *nothing;
    double *work = floats(m, AB_TRIAL), *first = floats(m, AB_STAGES), kept[AB_STATE_COUNT]; /* whole lanes are read */
    memcpy(work, state, sizeof kept);
    memcpy(kept, first, sizeof kept); /* the rates where the next step begins */
    enter_segment(m, time);
    ab_kernel_rates(&nothing, &wrong, time, work, first, at(m, AB_SYSTEM));
    memcpy(rates, first, sizeof kept);
    memcpy(first, kept, sizeof kept);
    return wrong != NULL ? AB_NOT_FINITE : AB_OK;
}

/* Ask the equations that switch, of balls that stick or touch rigidly, in a state that is not that of the own integration. */
static int ask_switch(ab_machine *m, int ask, double time, const double *state, double *said) {
    void *rates = (void *)ab_kernel_rates, *wrong = NULL;
    enter_segment(m, time);
    memcpy(at(m, AB_STATE), state, sizeof m->state);
    m->words[AB_COUNTS + FRESH] = 0;
    ab_kernel_switch(said, &wrong, ask, time, rates, rates, rates, at(m, AB_SYSTEM), at(m, AB_PAIR));
    return wrong != NULL ? AB_NOT_FINITE : AB_OK;
}

int ab_indicators(ab_machine *m, double time, const double *state, double *indicators) {
    double own[AB_STATE_COUNT], found = 0.0;
    memcpy(own, at(m, AB_STATE), sizeof own);
    int status = AB_INDICATOR_COUNT ? ask_switch(m, INDICATE, time, state, &found) : AB_OK;
    memcpy(at(m, AB_STATE), own, sizeof own);
    for (int i = 0; i < AB_INDICATOR_COUNT; i++) indicators[i] = i < found ? floats(m, AB_STAGES)[i] : 1.0;
    return status;
}

int ab_event(ab_machine *m, double time, double *state) {
    double changed;
    int status = AB_INDICATOR_COUNT ? ask_switch(m, HAPPEN, time, state, &changed) : AB_OK;
    if (AB_INDICATOR_COUNT) memcpy(state, at(m, AB_STATE), sizeof m->state);
    return status;
}

void ab_set_tolerance(ab_machine *m, double tolerance) {
    double factor = tolerance / AB_TOLERANCE;
    for (int i = 0; i < AB_STATE_COUNT; i++) {
        double first[2];
        memcpy(first, ab_words + AB_ABSOLUTE + i, sizeof(double));
        memcpy(first + 1, ab_words + AB_RELATIVE + i, sizeof(double));
        floats(m, AB_ABSOLUTE)[i] = factor * first[0];
        floats(m, AB_RELATIVE)[i] = factor * first[1];
    }
}

/* Up to so many steps towards a time, by the explicit pair of the package; states at ascending times go into rows. */
static int advance(ab_machine *m, double end, int64_t steps, const double *times, int64_t count, double *states) {
    void *rates = (void *)ab_kernel_rates, *toggle = (void *)ab_kernel_switch, *wrong = NULL;
    int64_t status = RUNNING, first = m->words[AB_COUNTS + ACCEPTED], *kept_times = m->words + AB_SAMPLE_TIMES, *kept = m->words + AB_SAMPLES;
    kept_times[2] = kept_times[5] = kept[5] = count;
    kept[2] = count * AB_STATE_COUNT;
    kept_times[4] = (int64_t)(intptr_t)times, kept[4] = (int64_t)(intptr_t)states;
    m->words[AB_COUNTS + NEXT_SAMPLE] = 0;
    floats(m, AB_CLOCK)[END] = end;
    do {
        ab_kernel_advance(&status, &wrong, rates, rates, rates, toggle, toggle, toggle, at(m, AB_SYSTEM), at(m, AB_PAIR),
                          at(m, AB_RECORD), at(m, AB_MEMORY), steps);
    } while (status == RUNNING && wrong == NULL && steps == CHUNK && m->words[AB_COUNTS + ACCEPTED] - first < MOST_STEPS);
    kept_times[2] = kept_times[5] = kept[2] = kept[5] = 0;
    kept_times[4] = kept[4] = (int64_t)(intptr_t)m->words;
    if (wrong != NULL) return AB_NOT_FINITE;
    if (status == RUNNING && steps == CHUNK) return AB_TOO_MANY_STEPS;
    return status == RUNNING || status == FINISHED ? AB_OK : (int)status;
}

static void follow_input(ab_machine *m, double end) {
    double *segment = floats(m, AB_SEGMENTS);
    if (AB_INPUT[0] == 's') {
        segment[0] = m->time;
        segment[2] = m->state[5];
        segment[3] = m->has_input && end > m->time ? (m->input[0] - m->state[5]) / (end - m->time) : 0.0;
        settle(m);
    } else if (m->has_input) {
        segment[0] = m->time;
        segment[2] = m->input[0];
        segment[3] = 0.0;
        settle(m);
    }
}

/* What a step changes in the block, kept or brought back. */
static void copy_spans(ab_machine *m, int keep) {
    int64_t *kept = m->before;
    for (size_t i = 0; i < sizeof ab_spans / sizeof *ab_spans; kept += ab_spans[i++].count) {
        int64_t *here = m->words + ab_spans[i].word;
        memcpy(keep ? kept : here, keep ? here : kept, ab_spans[i].count * sizeof *kept);
    }
}

int ab_step(ab_machine *m, double time) {
    if (!isfinite(time) || time < m->time) return AB_WRONG;
    double way = time - m->time, *clock = floats(m, AB_CLOCK);
    if (way == 0.0) return AB_OK;
    if (AB_INPUT[0] != 0) return ab_run(m, time, NULL, 0, NULL);
    for (int64_t k = 0; k < m->count; k++) /* a step went beyond this time, and it was expected */
        if (m->ahead_times[k] == time) {
            m->time = time;
            memcpy(m->state, m->ahead + k * AB_STATE_COUNT, sizeof m->state);
            return AB_OK;
        }
    if (time < clock[TIME]) { /* not expected: the same step once more */
        copy_spans(m, 0);
    }
    if (time == clock[TIME]) {
        show(m);
        return AB_OK;
    }
    int status = AB_OK, steps = 0;
    double end = time > AB_DURATION ? INFINITY : AB_DURATION;
    for (int k = 0; k < AHEAD; k++) m->ahead_times[k] = k == 0 ? time : time + k * way;
    m->count = 0;
    while (status == AB_OK && m->count == 0) {
        copy_spans(m, 1);
        status = steps++ == MOST_STEPS ? AB_TOO_MANY_STEPS : advance(m, end, 1, m->ahead_times, AHEAD, m->ahead);
        m->count = m->words[AB_COUNTS + NEXT_SAMPLE];
    }
    if (status != AB_OK) {
        show(m);
        return status;
    }
    m->time = time;
    memcpy(m->state, m->ahead, sizeof m->state);
    return AB_OK;
}

int ab_run(ab_machine *m, double end, const double *times, size_t count, double *states) {
    if (!isfinite(end) || end < m->time) return AB_WRONG;
    if (m->time < floats(m, AB_CLOCK)[TIME]) settle(m);
    if (AB_INPUT[0] != 0) follow_input(m, end);
    if (count > 0 && times[0] == m->time) { /* that is known */
        ab_state(m, states);
        times++, count--, states += AB_STATE_COUNT;
    }
    int status = advance(m, end, CHUNK, times, (int64_t)count, states);
    show(m);
    return status;
}

void ab_outputs(ab_machine *m, double *outputs) {
    void *wrong = NULL, *nothing;
    double *ring = floats(m, AB_RING);
    double shown[AB_STATE_COUNT]; /* differences and lengths are made of words of the block, where the state is that shown */
    memcpy(shown, at(m, AB_STATE), sizeof shown);
    memcpy(at(m, AB_STATE), m->state, sizeof shown);
    ring[0] = m->time;
    memcpy(ring + 1, m->state, sizeof shown);
    ab_kernel_observe(&nothing, &wrong, at(m, AB_SYSTEM), at(m, AB_INPUTS), NULL, NULL, 1 + AB_STATE_COUNT, 8, ring, 1,
                      1 + AB_STATE_COUNT, 8 * (1 + AB_STATE_COUNT), 8, 0, 1, 0, at(m, AB_DESK));
    for (int i = 0; i < AB_OUTPUT_COUNT; i++) {
        const double *one = floats(m, ab_output_places[i].first), *other = floats(m, ab_output_places[i].second);
        switch (ab_output_places[i].kind) {
            case AB_LENGTH: outputs[i] = hypot(*one, *other); break;
            case AB_LESS: outputs[i] = *one - *other; break;
            default: outputs[i] = *one;
        }
    }
    memcpy(at(m, AB_STATE), shown, sizeof shown);
}

#ifdef FMI_VERSION

/* For an importer that integrates itself: rates, events, the next corner of the drive, and the size of a state. */
static void follow_host(ab_machine *m, double time, const double *state) {
    if (!AB_INPUT[0]) return;
    double *segment = floats(m, AB_SEGMENTS); /* a torque, or the acceleration of a given speed */
    segment[0] = time, segment[2] = AB_INPUT[0] == 's' ? state[5] : m->input[0];
    segment[3] = AB_INPUT[0] == 's' ? m->input[1] : 0.0;
}

static int host_rates(ab_machine *m, double time, const double *state, double *rates) {
    follow_host(m, time, state);
    return ab_derivatives(m, time, state, rates);
}


static double corner_after(ab_machine *m, double time) {
    if (AB_INPUT[0]) return INFINITY;
    m->held = 0, m->words[AB_SEGMENT_NOW] = 0;
    enter_segment(m, time + 1e-13 * fmax(1.0, fabs(time)));
    m->held = 1;
    int64_t next = m->words[AB_SEGMENT_NOW] + 1;
    return next < AB_SEGMENT_COUNT ? *floats(m, AB_SEGMENTS + next * AB_SEGMENT_WORDS) : INFINITY;
}

static double size_of(int i) {
    double absolute;
    memcpy(&absolute, ab_words + AB_ABSOLUTE + i, sizeof absolute);
    return absolute / AB_TOLERANCE;
}

#endif
