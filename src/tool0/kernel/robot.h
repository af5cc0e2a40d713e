/* A robot as the kernel executes it: laws, drives, and the engine's memory. */

#ifndef TOOL0_ROBOT_H
#define TOOL0_ROBOT_H

#include <stdint.h>

#include "drives.h"
#include "laws.h"

enum {
    RUN_DONE = 0,  /* all ticks */
    RUN_EVENT = 1, /* Python executes the next tick, or the rest of this one */
    RUN_CHECK = 2, /* Python checks the state; then as RUN_EVENT */
    RUN_MASSES = 3, /* masses of the servos are due: masses.c; then it goes on */
    RUN_MOBILITY = 4, /* the same of the mobility of the governed joints */
};

typedef struct {
    int32_t n_joints;
    int32_t n_velocities; /* of the engine, those of objects included */
    int32_t n_motors;
    int32_t n_laws;
    int32_t n_brakes;
    int32_t steps_per_tick;
    int32_t steps_left; /* of a tick that is not finished */
    int64_t steps;      /* since the time was 0 */
    double dt, period;  /* of a step and of a tick [s] */
    void (*step)(const void *model, void *data); /* mj_step */
    void (**on_error)(const char *); /* what the engine calls on an error; may be null */
    double (**clock)(void); /* what the engine calls to time its parts; may be null */
    const void *model;
    void *data;
    double *position, *velocity; /* of the engine */
    double *motors;              /* efforts that the engine reads */
    const int32_t *motor_joints;
    const int32_t *brakes; /* (n_brakes), joints whose engaged brakes stick ... */
    double standstill;     /* ... below this speed */
    Law *laws;
    Drives *drives;
    double *command, *effort; /* shape (n_joints) as all below */
    /* The state at the start of the last tick, and of its last step: */
    double *tick_position, *tick_velocity, *tick_effort;
    double *step_position, *step_velocity, *step_effort;
} Robot;

#endif
