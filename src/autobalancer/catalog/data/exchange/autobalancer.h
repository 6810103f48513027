/* A rotor with an automatic ball balancer, or its balls alone (balancer.c), exported by the Python package autobalancer. All numbers are SI.

   One call of ab_create gives one machine with memory of its own. Different machines may be used by different threads at
   once; one machine by one thread at a time. Functions that return a status give AB_OK (0) or one of the values below. */

#ifndef AUTOBALANCER_H
#define AUTOBALANCER_H

#include <stddef.h>
#include <stdint.h>

#ifndef AB_API
#ifdef _WIN32
#define AB_API __declspec(dllexport)
#else
#define AB_API __attribute__((visibility("default")))
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ab_machine ab_machine;

enum {
    AB_OK = 0,
    AB_STEP_TOO_SMALL = 3, /* the step fell below rounding */
    AB_NOT_FINITE = 4,     /* the motion grew without limit */
    AB_WRONG = 5,          /* an argument is not possible: nothing was changed */
    AB_TOO_MANY_STEPS = 6  /* ten million in one call: it stopped on the way; a drive that is far too strong? */
};

typedef struct {
    const char *name;        /* path in the machine file, or name in a run of the package */
    const char *unit;        /* SI */
    const char *description;
    double start;            /* value in the machine file; of states at time 0 */
    double least, greatest;  /* of a parameter */
} ab_variable;

/* What there is; the lists have AB_..._COUNT entries, see ab_count. */
enum { AB_STATES, AB_OUTPUTS, AB_PARAMETERS, AB_INPUT_LIST };
AB_API int ab_count(int list);
AB_API const ab_variable *ab_list(int list);
AB_API const char *ab_version(void);

/* A machine at time 0; NULL without memory, or on a processor without AVX2 and FMA. */
AB_API ab_machine *ab_create(void);
AB_API void ab_free(ab_machine *machine);
AB_API void ab_reset(ab_machine *machine); /* back to time 0, with the parameters as they are */

/* Parameters change the equations from now on; set before time 0 they also change the start. */
AB_API double ab_parameter(const ab_machine *machine, int number);
AB_API int ab_set_parameter(ab_machine *machine, int number, double value);

/* Inputs, as the list says. A speed of the rotor is reached at the end of the next step, a torque acts at once. Of balls alone:
   the motion of the shaft, which goes on with the accelerations that were given until new ones are. */
AB_API int ab_set_input(ab_machine *machine, int number, double value);

AB_API double ab_time(const ab_machine *machine);
AB_API void ab_state(const ab_machine *machine, double *state);
AB_API int ab_set_state(ab_machine *machine, double time, const double *state);

/* The rates of a state at a time. The machine keeps its own state. */
AB_API int ab_derivatives(ab_machine *machine, double time, const double *state, double *rates);
/* For a program that integrates these rates itself: numbers that are positive until a ball stops, leaves or touches. At such an
   instant, and once at the start, ab_event makes what is due: the state may change by an impact, and the rates are those of the
   balls that rest and touch from then on. A machine for this takes no steps of its own. Not of balls alone. */
AB_API int ab_indicator_count(void);
AB_API int ab_indicators(ab_machine *machine, double time, const double *state, double *indicators);
AB_API int ab_event(ab_machine *machine, double time, double *state);

/* Integrate up to a time and stop there. */
AB_API int ab_step(ab_machine *machine, double time);
/* Integrate up to a time, with the states (count rows) at ascending times on the way: the steps do not depend on them, so
   that the numbers are those of the package to the last bit, with resolved balls or forces to rounding. Not of balls
   alone. */
AB_API int ab_run(ab_machine *machine, double end, const double *times, size_t count, double *states);
AB_API void ab_set_tolerance(ab_machine *machine, double tolerance);
AB_API int64_t ab_steps_taken(const ab_machine *machine);

/* Balls alone: with the accelerations a of the R rows and of the rotor angle, forces are  force - mass a  (R + 1 numbers and
   a square matrix, row by row) and accelerations of the n balls  push - lean a. shaft has 2 R numbers, deflections and
   velocities, rotor angle and speed, balls 2 n, angles and speeds in the rotor. The state of the machine does not matter. */
AB_API int ab_element(ab_machine *machine, double time, const double *shaft, const double *rotor, const double *balls,
                      double *force, double *mass, double *push, double *lean);

/* All outputs at the present state. */
AB_API void ab_outputs(ab_machine *machine, double *outputs);

/* All there is of a machine as bytes, for this library in any process. */
AB_API size_t ab_saved_size(void);
AB_API void ab_save(const ab_machine *machine, void *bytes);
AB_API int ab_restore(ab_machine *machine, const void *bytes);

#ifdef __cplusplus
}
#endif

#endif
