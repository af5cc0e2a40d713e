/* The tick of simulation/core.py without Python: laws, drives and engine. */

#include <math.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export.h"
#include "robot.h"

/* Sum of squares of the velocities above which Python checks whether a state has
   diverged. */
static const double SUSPICIOUS = 0.99e8;

static void copy(double *to, const double *from, int n)
{
    memcpy(to, from, (size_t)n * sizeof(double));
}

static int is_suspicious(const double *velocity, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += velocity[i] * velocity[i];
    return !(sum < SUSPICIOUS); /* also true for NaN */
}

/* Execute the laws of one tick; return 0, without changes, if there is an event. */
static int update(Robot *robot)
{
    double time = (double)robot->steps * robot->dt;
    for (int j = 0; j < robot->n_laws; j++)
        if (!law_prepare(&robot->laws[j], time, robot->position, robot->velocity))
            return 0;
    for (int j = 0; j < robot->n_laws; j++)
        law_execute(&robot->laws[j], time, robot->period, robot->position,
                    robot->velocity, robot->command);
    return 1;
}

/* An error of the engine would end the process.  In the kernel, the error handler
   returns to the step.  Python then repeats the step, so that the engine's bindings
   raise the error. */
static _Thread_local jmp_buf *stepping;
static void (*other_handler)(const char *);

static void return_to_step(const char *message)
{
    if (stepping)
        longjmp(*stepping, 1);
    if (other_handler) {
        other_handler(message);
        return;
    }
    fprintf(stderr, "%s\n", message);
    exit(EXIT_FAILURE);
}

/* MuJoCo reads a clock at the start and at the end of each part of a step, which takes
   a twentieth of the time of the step.  While the kernel steps the engine, this clock
   returns 0. */
static double (*other_clock)(void);

static double stopped_clock(void)
{
    return stepping ? 0.0 : other_clock();
}

/* Step the engine; return 0 if the engine reports an error. */
static int step_engine(Robot *robot)
{
    jmp_buf here;
    if (robot->on_error && *robot->on_error != return_to_step) {
        other_handler = *robot->on_error;
        *robot->on_error = return_to_step;
    }
    if (robot->clock && *robot->clock && *robot->clock != stopped_clock) {
        other_clock = *robot->clock;
        *robot->clock = stopped_clock;
    }
    stepping = &here;
    int is_error = setjmp(here);
    if (!is_error)
        robot->step(robot->model, robot->data);
    stepping = NULL;
    return !is_error;
}

/* Stop the joints that their brakes have brought to rest, since friction alone would
   let them creep. */
static void stick(Robot *robot)
{
    for (int k = 0; k < robot->n_brakes; k++) {
        int i = robot->brakes[k];
        if (fabs(robot->velocity[i]) < robot->standstill) {
            robot->position[i] = robot->step_position[i];
            robot->velocity[i] = 0.0;
        }
    }
}

/* Execute one physics step.  If masses or a mobility are due before the step, return
   the reason. */
static int step(Robot *robot)
{
    int n = robot->n_joints;
    copy(robot->step_position, robot->position, n);
    copy(robot->step_velocity, robot->velocity, n);
    copy(robot->step_effort, robot->effort, n);
    int due = drives_efforts(robot->drives, robot->command, robot->position,
                             robot->velocity, robot->effort);
    if (due == DRIVES_MASSES)
        return RUN_MASSES;
    if (due == DRIVES_MOBILITY)
        return RUN_MOBILITY;
    if (due != DRIVES_OK)
        return RUN_EVENT;
    for (int j = 0; j < robot->n_motors; j++)
        robot->motors[j] = robot->effort[robot->motor_joints[j]];
    if (!step_engine(robot))
        return RUN_EVENT;
    stick(robot);
    robot->steps++;
    return is_suspicious(robot->velocity, robot->n_velocities) ? RUN_CHECK : RUN_DONE;
}

/* Execute up to `most` ticks, and set *done to the number of executed ticks.  Returns
   RUN_...

   If `steps_left` is not 0 afterwards, the laws of one additional tick have been
   executed, and `steps_left` steps of this tick are left.  After RUN_MASSES and
   RUN_MOBILITY, the next call executes these steps first. */
TOOL0_EXPORT int tool0_run(Robot *robot, int most, int *done)
{
    int n = robot->n_joints, left = robot->steps_left;
    for (*done = 0; *done < most; ++*done) {
        robot->steps_left = 0;
        if (!left) {
            if (!update(robot))
                return RUN_EVENT;
            copy(robot->tick_position, robot->position, n);
            copy(robot->tick_velocity, robot->velocity, n);
            copy(robot->tick_effort, robot->effort, n);
            left = robot->steps_per_tick;
        }
        for (; left > 0; left--) {
            int result = step(robot);
            if (result != RUN_DONE) {
                robot->steps_left = result == RUN_CHECK ? left - 1 : left;
                return result;
            }
        }
    }
    return RUN_DONE;
}

/* Sizes of the structs that are also defined in Python.  A test compares both. */
TOOL0_EXPORT const int tool0_struct_sizes[] = {
    sizeof(Robot), sizeof(Law), sizeof(Piece), sizeof(Grip), sizeof(Start), sizeof(Drives),
    sizeof(DriveTable), sizeof(DriveBody), sizeof(DriveBounds), sizeof(DriveGoal),
    sizeof(DriveServo), 0,
};
