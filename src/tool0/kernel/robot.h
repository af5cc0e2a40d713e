/* The data with which the kernel executes a robot: laws, drives and the engine's
   memory. */

#ifndef TOOL0_ROBOT_H
#define TOOL0_ROBOT_H

#include <stdint.h>

#include "drives.h"
#include "laws.h"

enum {
    RUN_DONE = 0,  /* all ticks were executed */
    RUN_EVENT = 1, /* Python executes the next tick, or the remaining steps of this tick */
    RUN_CHECK = 2, /* Python checks the state, and continues as after RUN_EVENT */
    /* masses of the servos must be computed (masses.c) before the run continues */
    RUN_MASSES = 3,
    /* mobility of the governed joints must be computed before the run continues */
    RUN_MOBILITY = 4,
};

typedef struct {
    int32_t n_joints;
    /* number of velocities in the engine, including those of objects */
    int32_t n_velocities;
    int32_t n_motors;
    int32_t n_laws;
    int32_t n_brakes;
    int32_t steps_per_tick;
    int32_t steps_left; /* number of steps that are left of an unfinished tick */
    int64_t steps;      /* number of steps since time 0 */
    double dt, period;  /* length of a step and of a tick [s] */
    void (*step)(const void *model, void *data); /* mj_step */
    void (**on_error)(const char *); /* the engine's error handler; may be null */
    double (**clock)(void); /* the clock for the engine's timers; may be null */
    const void *model;
    void *data;
    double *position, *velocity; /* of the engine */
    double *motors;              /* efforts that the engine reads */
    const int32_t *motor_joints;
    /* (n_brakes), joints with engaged brakes, which stick below `standstill` */
    const int32_t *brakes;
    double standstill;     /* speed below which joints with engaged brakes stick */
    Law *laws;
    Drives *drives;
    double *command, *effort; /* shape (n_joints), like all arrays below */
    /* The state at the start of the last tick, and of the tick's last step: */
    double *tick_position, *tick_velocity, *tick_effort;
    double *step_position, *step_velocity, *step_effort;
} Robot;

#endif
