/* Control laws: the behavior of controllers until the next event.

   The reference is Python: the controllers in control/ros1 and control/ros2, and
   control/gripper_action.py.  The operations in C are the same, in the same order. */

#ifndef TOOL0_LAWS_H
#define TOOL0_LAWS_H

#include <stdint.h>

#include "drives.h"

enum { LAW_TRAJECTORY = 0, LAW_COMMAND = 1, LAW_GRIPPER = 2 };
enum { UNWINDING_NONE = 0, UNWINDING_CONDITIONAL = 1, UNWINDING_BACK_CALCULATION = 2 };
enum { CHECK_NOTHING = 0, CHECK_PATH = 1, CHECK_GOAL = 2 };

/* A piece of the desired motion of one joint. */
typedef struct {
    double until; /* start of the next piece [s] */
    double origin, c[6], d[4]; /* the fields of control/spline.Polynomial */
    double check; /* the check of an active goal: CHECK_... */
    double position_tolerance, velocity_tolerance; /* 0: not checked */
    double end; /* end of the segment [s] */
} Piece;

typedef struct {
    double p, i, d, i_min, i_max, antiwindup;
    double u_min, u_max, error_deadband, unwinding, tracking_time;
} Gains;

/* control/gripper_action.py: parameters, and the values that change in the tick. */
typedef struct {
    double target, tolerance, max_effort, stall_range, stall_timeout;
    double ramp, effort, stall_position, stall_since;
    double position;   /* position in the last tick */
    double is_unheard; /* whether the goal has no handle */
} Grip;

/* Data for the start of a trajectory of all joints without a goal:
   control/law.TrajectoryStart. */
typedef struct {
    int32_t is_known; /* 0: Python must start the trajectory */
    int32_t is_spliced, from_desired, reads_velocity, may_end_moving;
    int32_t has_points; /* whether the executed motion has several points */
    int32_t is_first;   /* whether the next tick is the first tick of a motion */
    /* number of points of the trajectory that starts in the next tick; 0: none */
    int32_t n_points;
    /* is_following: whether it continues the desired motion */
    int32_t has_velocities, is_following;
    double now;                           /* time of the command [s] */
    double goal_time, timeout;            /* [s] */
    const double *tolerances;             /* the same as in Law */
    double *times;                        /* (max_pieces) */
    double *positions, *velocities;       /* (max_pieces, n) */
} Start;

typedef struct {
    int32_t kind;
    int32_t n; /* number of joints */
    int32_t has_pid;
    int32_t is_monitored; /* whether an active goal is monitored */
    int32_t measures_velocity; /* LAW_COMMAND: the commands are velocities */
    int32_t has_feed_forward;
    int32_t max_pieces; /* largest number of pieces per joint */
    int32_t is_moving;
    int32_t is_moving_ahead; /* the same for the commanded motion, if it is ahead */
    /* whether the monitor is a TrajectoryMonitor, which watches all joints together */
    int32_t watches_all;
    int32_t has_goal; /* for a TrajectoryMonitor: whether there is a goal */
    int32_t unused;
    const int32_t *joints; /* numbers of the joints, shape (n) like all arrays below */
    const int32_t *wraps;  /* whether errors are reduced to the shortest rotation */
    const Gains *gains;
    double *integrals;
    const double *feed_forward;
    Piece *pieces; /* shape (n, max_pieces) */
    int32_t *n_pieces;
    int32_t *piece; /* the active pieces */
    int32_t *piece_ahead; /* the commanded pieces, if the commanded motion is ahead */
    int32_t *arrived;
    /* shape (n, 4): position and velocity on the path, and at the goal if all joints
       are watched together */
    double *tolerances;
    /* numbers of segments of a motion that the kernel started and Python does not have */
    int32_t *started;
    /* (n, max_pieces): end times of these segments, relative to the motion's start [s] */
    double *times;
    const double *values; /* LAW_COMMAND: the commands */
    double *last_errors;  /* LAW_COMMAND with a PID */
    double *errors, *rates; /* working memory */
    Grip *grip;              /* LAW_GRIPPER */
    const DriveGoal *bounds; /* LAW_GRIPPER: limits of the goal; may be null */
    Start *start; /* null if motions start immediately, or if Python starts motions */
    double next_change; /* start of the next piece [s] */
    double next_change_ahead;
    double goal_time; /* grace time after the end of a goal [s] */
    double end, timeout; /* of a trajectory with joints that are watched together [s] */
    double lead; /* time by which the commanded motion is ahead of that of the errors [s] */
    double since, lag, slip; /* control/law.TrajectoryClock [s] */
} Law;

/* Return the time of the trajectory at the simulated `time`. */
double law_time(const Law *law, double time);

/* Start the trajectory that is due at the trajectory's `time` (starts.c).  Returns 0,
   without changes, if Python must start the trajectory. */
int law_start(Law *law, double time, const double *position, const double *velocity);

/* Prepare the tick at `time`; return 0 if Python must execute it. */
int law_prepare(Law *law, double time, const double *position, const double *velocity);

/* Write the commands of the prepared tick. */
void law_execute(Law *law, double time, double period, const double *position,
                 const double *velocity, double *command);

#endif
