/* The balls alone, for a shaft that a host moves, as declared in autobalancer.h. Inputs are deflections, velocities and
   accelerations of the rows of the shaft, then angle, speed and acceleration of the rotor. With all accelerations a,

       force = force0 - mass a,    ball accelerations = push - lean a. */

#define AB_FURTHER int64_t steps;
#include "block.c"

#define ROWS AB_ROWS
#define ALL (ROWS + 1)        /* and the rotor angle */
#define BALLS (AB_STATE_COUNT / 2)
#define TURN 0.05             /* rad in a step, of rotor and balls */
#define DECAY 0.25            /* step over the fastest decay */

#define VECTOR void *, void *, int64_t, int64_t, double *, int64_t, int64_t
#define MATRIX void *, void *, int64_t, int64_t, double *, int64_t, int64_t, int64_t, int64_t
extern int32_t ab_kernel_element(void *, void **, double, VECTOR, VECTOR, VECTOR, void *, VECTOR, MATRIX, VECTOR, MATRIX);
#define vector(data, count) NULL, NULL, (count), 8, (data), (count), 8
#define matrix(data, rows, columns) NULL, NULL, (rows) * (columns), 8, (data), (rows), (columns), 8 * (columns), 8

typedef struct {
    double force[ALL], mass[ALL * ALL], push[BALLS + 1], lean[(BALLS + 1) * ALL];
} forms;

static void show(ab_machine *m) {
    memcpy(m->state, at(m, AB_STATE), sizeof m->state);
    m->steps = 0;
}
static void settle(ab_machine *m) { memcpy(at(m, AB_STATE), m->state, sizeof m->state); }

int64_t ab_steps_taken(const ab_machine *m) { return m->steps; }

int ab_set_state(ab_machine *m, double time, const double *state) {
    for (int i = 0; i < AB_STATE_COUNT; i++)
        if (!isfinite(state[i])) return AB_WRONG;
    if (!isfinite(time)) return AB_WRONG;
    memcpy(m->state, state, sizeof m->state);
    settle(m);
    m->time = time;
    return AB_OK;
}

static int look(ab_machine *m, double time, const double *shaft, const double *rotor, const double *state, forms *f) {
    void *wrong = NULL, *nothing;
    ab_kernel_element(&nothing, &wrong, time, vector((double *)shaft, 2 * ROWS), vector((double *)rotor, 2),
                      vector((double *)state, AB_STATE_COUNT), at(m, AB_SYSTEM), vector(f->force, ALL),
                      matrix(f->mass, ALL, ALL), vector(f->push, BALLS), matrix(f->lean, BALLS, ALL));
    return wrong != NULL ? AB_NOT_FINITE : AB_OK;
}

int ab_element(ab_machine *m, double time, const double *shaft, const double *rotor, const double *balls, double *force,
               double *mass, double *push, double *lean) {
    forms f;
    int status = look(m, time, shaft, rotor, balls, &f);
    memcpy(force, f.force, sizeof f.force), memcpy(mass, f.mass, sizeof f.mass);
    memcpy(push, f.push, BALLS * sizeof *push), memcpy(lean, f.lean, BALLS * ALL * sizeof *lean);
    return status;
}

/* The motion of the shaft a while after the inputs were given, as if its accelerations stayed. */
static void follow(const ab_machine *m, double after, double *shaft, double *rotor) {
    const double *q = m->input, *v = q + ROWS, *a = v + ROWS, *turn = a + ROWS;
    for (int i = 0; i < ROWS; i++) {
        shaft[i] = q[i] + after * (v[i] + 0.5 * after * a[i]);
        shaft[ROWS + i] = v[i] + after * a[i];
    }
    rotor[0] = turn[0] + after * (turn[1] + 0.5 * after * turn[2]);
    rotor[1] = turn[1] + after * turn[2];
}

static int rates_after(ab_machine *m, double time, double after, const double *state, double *rates) {
    double shaft[2 * ROWS], rotor[2];
    const double *a = m->input + 2 * ROWS, acceleration = m->input[3 * ROWS + 2];
    forms f;
    follow(m, after, shaft, rotor);
    if (look(m, time, shaft, rotor, state, &f)) return AB_NOT_FINITE;
    for (int b = 0; b < BALLS; b++) {
        rates[b] = state[BALLS + b];
        double rate = f.push[b] - f.lean[b * ALL + ROWS] * acceleration;
        for (int i = 0; i < ROWS; i++) rate -= f.lean[b * ALL + i] * a[i];
        rates[BALLS + b] = rate;
        if (!isfinite(rate)) return AB_NOT_FINITE;
    }
    return AB_OK;
}

int ab_derivatives(ab_machine *m, double time, const double *state, double *rates) {
    return rates_after(m, time, 0.0, state, rates);
}

int ab_step(ab_machine *m, double time) {
    if (!isfinite(time) || time < m->time) return AB_WRONG;
    double way = time - m->time, fastest = fabs(m->input[3 * ROWS + 1]);
    for (int b = 0; b < BALLS; b++) fastest = fmax(fastest, fabs(m->input[3 * ROWS + 1]) + fabs(m->state[BALLS + b]));
    double count = ceil(way * fmax(fastest / TURN, AB_DECAY / DECAY));
    if (!(count < 1e7)) return AB_TOO_MANY_STEPS;
    int64_t steps = count < 1.0 ? 1 : (int64_t)count;
    double h = way / steps, k[4][AB_STATE_COUNT], trial[AB_STATE_COUNT];
    for (int64_t s = 0; s < steps && way > 0.0; s++) { /* the classical method of Runge and Kutta */
        double after = s * h;
        static const double part[] = {0.0, 0.5, 0.5, 1.0};
        for (int stage = 0; stage < 4; stage++) {
            for (int i = 0; i < AB_STATE_COUNT; i++)
                trial[i] = m->state[i] + (stage ? part[stage] * h * k[stage - 1][i] : 0.0);
            if (rates_after(m, m->time + after + part[stage] * h, after + part[stage] * h, trial, k[stage])) return AB_NOT_FINITE;
        }
        for (int i = 0; i < AB_STATE_COUNT; i++)
            m->state[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
    }
    double shaft[2 * ROWS], rotor[2]; /* the inputs go on with the shaft, until new ones are given */
    follow(m, way, shaft, rotor);
    memcpy(m->input, shaft, sizeof shaft), memcpy(m->input + 3 * ROWS, rotor, sizeof rotor);
    m->time = time, m->steps += steps;
    settle(m);
    return AB_OK;
}

void ab_set_tolerance(ab_machine *m, double tolerance) { (void)m, (void)tolerance; }

/* Forces on the rows and torque on the rotor, balls, then the mass matrix and the forces without accelerations. */
void ab_outputs(ab_machine *m, double *outputs) {
    double shaft[2 * ROWS], rotor[2], acceleration[ALL], *next = outputs;
    forms f;
    follow(m, 0.0, shaft, rotor);
    memcpy(acceleration, m->input + 2 * ROWS, ROWS * sizeof(double));
    acceleration[ROWS] = m->input[3 * ROWS + 2];
    if (look(m, m->time, shaft, rotor, m->state, &f))
        for (int i = 0; i < ALL; i++) f.force[i] = NAN;
    for (int i = 0; i < ALL; i++) {
        double force = f.force[i];
        for (int j = 0; j < ALL; j++) force -= f.mass[i * ALL + j] * acceleration[j];
        *next++ = force;
    }
    memcpy(next, m->state, sizeof m->state), next += AB_STATE_COUNT;
    memcpy(next, f.force, sizeof f.force), next += ALL;
    memcpy(next, f.mass, sizeof f.mass);
}

#ifdef FMI_VERSION

static int host_rates(ab_machine *m, double time, const double *state, double *rates) {
    return ab_derivatives(m, time, state, rates);
}
static double corner_after(ab_machine *m, double time) { return (void)m, (void)time, INFINITY; }
static double size_of(int i) { return i < BALLS ? 1.0 : 10.0; }

#endif
