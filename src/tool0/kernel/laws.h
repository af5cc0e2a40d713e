/* Control laws: what a controller does until something happens.

   The reference is Python: the controllers in control/ros1 and control/ros2, and
   control/gripper_action.py.  Every operation here is the same, in the same order. */

#ifndef TOOL0_LAWS_H
#define TOOL0_LAWS_H

#include <stdint.h>

#include "drives.h"

enum { LAW_TRAJECTORY = 0, LAW_COMMAND = 1, LAW_GRIPPER = 2 };
enum { UNWINDING_NONE = 0, UNWINDING_CONDITIONAL = 1, UNWINDING_BACK_CALCULATION = 2 };
enum { CHECK_NOTHING = 0, CHECK_PATH = 1, CHECK_GOAL = 2 };

/* The desired motion of one joint until an instant. */
typedef struct {
    double until; /* when the next piece begins [s] */
    double origin, c[6], d[4]; /* as control/spline.Polynomial */
    double check; /* what an active goal checks: CHECK_... */
    double position_tolerance, velocity_tolerance; /* 0 is not checked */
    double end; /* of the segment [s] */
} Piece;

typedef struct {
    double p, i, d, i_min, i_max, antiwindup;
    double u_min, u_max, error_deadband, unwinding, tracking_time;
} Gains;

/* control/gripper_action.py: parameters, and what changes in the tick. */
typedef struct {
    double target, tolerance, max_effort, stall_range, stall_timeout;
    double ramp, effort, stall_position, stall_since;
    double position;   /* in the last tick */
    double is_unheard; /* nobody waits for the end of the goal */
} Grip;

/* How a trajectory of all joints without a goal starts: control/law.TrajectoryStart. */
typedef struct {
    int32_t is_known; /* else Python must start it */
    int32_t is_spliced, from_desired, reads_velocity, may_end_moving;
    int32_t has_points; /* several, in the motion that is executed */
    int32_t is_first;   /* the coming tick is the first one of a motion */
    int32_t n_points;   /* of a trajectory that starts with the coming tick; 0: none */
    int32_t has_velocities, is_following; /* it: with the desired motion */
    double now;                           /* when it was commanded [s] */
    double goal_time, timeout;            /* [s] */
    const double *tolerances;             /* as those of Law */
    double *times;                        /* (max_pieces) */
    double *positions, *velocities;       /* (max_pieces, n) */
} Start;

typedef struct {
    int32_t kind;
    int32_t n; /* joints */
    int32_t has_pid;
    int32_t is_monitored; /* by an active goal */
    int32_t measures_velocity; /* LAW_COMMAND: the commands are velocities */
    int32_t has_feed_forward;
    int32_t max_pieces; /* per joint, in pieces */
    int32_t is_moving;
    int32_t is_moving_ahead; /* the same of the commanded motion, if that leads */
    int32_t watches_all; /* the monitor is a TrajectoryMonitor: of all joints together */
    int32_t has_goal; /* then, too, whether it is for a goal */
    int32_t unused;
    const int32_t *joints; /* their numbers, shape (n) as all below */
    const int32_t *wraps;  /* whether errors go the shortest way round */
    const Gains *gains;
    double *integrals;
    const double *feed_forward;
    Piece *pieces; /* shape (n, max_pieces) */
    int32_t *n_pieces;
    int32_t *piece; /* the active one */
    int32_t *piece_ahead; /* the commanded one, if that leads */
    int32_t *arrived;
    double *tolerances; /* shape (n, 4): position and velocity on the path, and at the
                           goal, if all joints are watched together */
    int32_t *started; /* segments of a motion that the kernel started: Python lacks it */
    double *times; /* (n, max_pieces): when they end after the start of that motion [s] */
    const double *values; /* LAW_COMMAND: the commands */
    double *last_errors;  /* LAW_COMMAND with a PID */
    double *errors, *rates; /* scratch */
    Grip *grip;              /* LAW_GRIPPER */
    const DriveGoal *bounds; /* LAW_GRIPPER: of the goal; may be null */
    Start *start; /* null where motions start at once, or Python starts them */
    double next_change; /* of a piece [s] */
    double next_change_ahead;
    double goal_time; /* grace after the end of a goal [s] */
    double end, timeout; /* of a trajectory whose joints are watched together [s] */
    double lead; /* how far the commanded motion is ahead of that of the errors [s] */
    double since, lag, slip; /* control/law.TrajectoryClock [s] */
} Law;

/* The time of the trajectory at simulated `time`. */
double law_time(const Law *law, double time);

/* Start the trajectory that is to start at the trajectory's `time`: starts.c.  Returns 0,
   with nothing changed, if Python must. */
int law_start(Law *law, double time, const double *position, const double *velocity);

/* Prepare the tick at `time`; return 0 if Python must execute it. */
int law_prepare(Law *law, double time, const double *position, const double *velocity);

/* Write the commands of the prepared tick. */
void law_execute(Law *law, double time, double period, const double *position,
                 const double *velocity, double *command);

#endif
