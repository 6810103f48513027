/* What a machine and a balancer have in common: the block of numbers, parameters, inputs, and copies of all of it. */

#ifdef __x86_64__
#include <cpuid.h>
#endif
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "autobalancer.h"
#include "machine_data.h"

struct ab_machine {
    int64_t *words; /* the block, on a cache line */
    void *memory;   /* as it was allocated */
    double parameters[AB_PARAMETER_COUNT + 1];
    double input[AB_INPUT_COUNT + 1];
    int has_input;  /* a new one was given */
    int held;       /* another program integrates: the drive goes on to its next piece at an event alone */
    double time, state[AB_STATE_COUNT]; /* what is shown */
    AB_FURTHER
};

static void show(ab_machine *m);   /* the state that the block has reached is the one that is shown */
static void settle(ab_machine *m); /* the block goes on from what is shown */

static double *floats(const ab_machine *m, size_t word) { return (double *)(m->words + word); }
static void *at(const ab_machine *m, size_t word) { return m->words + word; }

static void move_addresses(int64_t *words, int64_t by) {
    for (size_t i = 0; i < sizeof ab_addresses / sizeof *ab_addresses; i++) words[ab_addresses[i]] += by;
}

static const struct { ab_variable *list; int count; } lists[] = {
    {(ab_variable *)ab_states, AB_STATE_COUNT},
    {(ab_variable *)ab_output_list, AB_OUTPUT_COUNT},
    {(ab_variable *)ab_parameter_list, AB_PARAMETER_COUNT},
    {(ab_variable *)ab_input_list, AB_INPUT_COUNT},
};

int ab_count(int list) { return list < 0 || list > AB_INPUT_LIST ? 0 : lists[list].count; }
const ab_variable *ab_list(int list) { return list < 0 || list > AB_INPUT_LIST ? NULL : lists[list].list; }
int ab_indicator_count(void) { return AB_INDICATOR_COUNT; }
const char *ab_version(void) { return AB_VERSION; }

/* Terms of the parameters: w = w0 + sum of A (product of f(v / v0) - 1). */
static void apply_parameters(ab_machine *m, int state_too) {
    for (size_t i = 0; i < AB_WORD_COUNT; i++) {
        const ab_changed_word *w = ab_changed_words + i;
        int start = w->word >= AB_STATE && w->word < AB_STATE + AB_STATE_COUNT;
        if (start && !state_too) continue;
        double value, change = 0.0;
        memcpy(&value, ab_words + w->word, sizeof value);
        for (int t = w->first; t < w->last; t++) {
            double product = 1.0;
            for (int f = ab_terms[t].first; f < ab_terms[t].last; f++) {
                const ab_factor *factor = ab_factors + f;
                double x = m->parameters[factor->parameter] / ab_parameter_list[factor->parameter].start - 1.0, sum = 0.0;
                for (int k = factor->last - 1; k >= factor->first; k--) sum = (sum + ab_coefficients[k]) * x;
                product *= 1.0 + sum;
            }
            change += ab_terms[t].amplitude * (product - 1.0);
        }
        *floats(m, w->word) = change == 0.0 ? value : value + change;
    }
}

static void link_functions(ab_machine *m) {
    for (size_t i = 0; i < sizeof ab_functions / sizeof *ab_functions; i++)
        if (ab_functions[i].word) m->words[ab_functions[i].word] = (int64_t)(intptr_t)ab_functions[i].function;
}

static void start(ab_machine *m) {
    memcpy(m->words, ab_words, sizeof ab_words);
    move_addresses(m->words, (int64_t)(intptr_t)m->words);
    apply_parameters(m, 1);
    link_functions(m);
    for (int i = 0; i < AB_INPUT_COUNT; i++) m->input[i] = ab_input_list[i].start;
    m->time = 0.0;
    m->has_input = 0;
    show(m);
}

/* Whether this processor and its system have AVX2 and fused multiplication, which the kernels use. */
static int can_run(void) {
#ifdef __x86_64__
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c >> 12 & 1) || !(c >> 27 & 1)) return 0;
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b >> 5 & 1);
#else
    return 1;
#endif
}

ab_machine *ab_create(void) {
    if (!can_run()) return NULL;
    ab_machine *m = calloc(1, sizeof *m);
    if (m == NULL || (m->memory = malloc(sizeof ab_words + 64)) == NULL) {
        free(m);
        return NULL;
    }
    m->words = (int64_t *)(((uintptr_t)m->memory + 63) & ~(uintptr_t)63);
    for (int i = 0; i < AB_PARAMETER_COUNT; i++) m->parameters[i] = ab_parameter_list[i].start;
    start(m);
    return m;
}

void ab_free(ab_machine *m) {
    if (m != NULL) free(m->memory);
    free(m);
}

void ab_reset(ab_machine *m) { start(m); }

double ab_parameter(const ab_machine *m, int number) {
    return number < 0 || number >= AB_PARAMETER_COUNT ? NAN : m->parameters[number];
}

int ab_set_parameter(ab_machine *m, int number, double value) {
    if (number < 0 || number >= AB_PARAMETER_COUNT) return AB_WRONG;
    const ab_variable *its = ab_parameter_list + number;
    if (!(value >= its->least && value <= its->greatest)) return AB_WRONG;
    m->parameters[number] = value;
    settle(m);
    apply_parameters(m, m->time == 0.0);
    show(m);
    return AB_OK;
}

int ab_set_input(ab_machine *m, int number, double value) {
    if (number < 0 || number >= AB_INPUT_COUNT || !isfinite(value)) return AB_WRONG;
    m->has_input = m->has_input || value != m->input[number];
    m->input[number] = value;
    return AB_OK;
}

double ab_time(const ab_machine *m) { return m->time; }

void ab_state(const ab_machine *m, double *state) { memcpy(state, m->state, sizeof m->state); }

/* Saved are the block with addresses from its begin, and what stands beside it. */
size_t ab_saved_size(void) { return sizeof(int64_t) + sizeof ab_words + sizeof(ab_machine); }

void ab_save(const ab_machine *m, void *bytes) {
    char *place = bytes;
    int64_t identity = AB_IDENTITY;
    memcpy(place, &identity, sizeof identity);
    memcpy(place + sizeof identity, m->words, sizeof ab_words);
    move_addresses((int64_t *)(place + sizeof identity), -(int64_t)(intptr_t)m->words);
    memcpy(place + sizeof identity + sizeof ab_words, m, sizeof *m);
}

int ab_restore(ab_machine *m, const void *bytes) {
    const char *place = bytes;
    int64_t identity, *words = m->words;
    void *memory = m->memory;
    memcpy(&identity, place, sizeof identity);
    if (identity != AB_IDENTITY) return AB_WRONG;
    memcpy(words, place + sizeof identity, sizeof ab_words);
    move_addresses(words, (int64_t)(intptr_t)words);
    memcpy(m, place + sizeof identity + sizeof ab_words, sizeof *m);
    m->words = words, m->memory = memory;
    link_functions(m);
    return AB_OK;
}
