#include "laws.h"

#include <math.h>
#include <string.h>

#define PI 3.141592653589793
#define TAU 6.283185307179586

/* description/model.shortest_turn(0, error) */
static double wrapped(double error)
{
    double turn = remainder(error, TAU);
    return turn == -PI ? PI : turn;
}

static const Piece *active(const Law *law, int k)
{
    return &law->pieces[k * law->max_pieces + law->piece[k]];
}

/* Find the pieces that are active at `time`; return 0 if a piece is not known. */
static int advance(const Law *law, double time, int32_t *active_piece,
                   int32_t *is_any_moving, double *next)
{
    int is_moving = 0;
    double next_change = INFINITY;
    for (int k = 0; k < law->n; k++) {
        const Piece *piece = &law->pieces[k * law->max_pieces + active_piece[k]];
        while (time >= piece->until) {
            if (active_piece[k] + 1 >= law->n_pieces[k])
                return 0;
            active_piece[k]++;
            piece++;
        }
        for (int j = 1; j < 6; j++)
            is_moving |= piece->c[j] != 0.0;
        if (piece->until < next_change)
            next_change = piece->until;
    }
    *is_any_moving = is_moving;
    *next = next_change;
    return 1;
}

/* Find the pieces of the errors and of the command at `time`; return 0 if a piece is
   not known. */
static int find_pieces(Law *law, double time)
{
    if (time >= law->next_change
        && !advance(law, time, law->piece, &law->is_moving, &law->next_change))
        return 0;
    double ahead = time + law->lead;
    return law->lead == 0.0 || ahead < law->next_change_ahead
        || advance(law, ahead, law->piece_ahead, &law->is_moving_ahead,
                   &law->next_change_ahead);
}

static void sample(Law *law, double time, const double *position, const double *velocity)
{
    for (int k = 0; k < law->n; k++) {
        const Piece *piece = active(law, k);
        const double *c = piece->c, *d = piece->d;
        int i = law->joints[k];
        if (!law->is_moving) {
            law->errors[k] = c[0] - position[i];
            law->rates[k] = -velocity[i];
            continue;
        }
        double t = time - piece->origin;
        double at = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
        law->errors[k] = at - position[i];
        double speed = c[1] + t * (d[0] + t * (d[1] + t * (d[2] + t * d[3])));
        law->rates[k] = speed - velocity[i];
    }
}

static int is_within(const double *tolerance, double error, double rate)
{
    return (tolerance[0] <= 0.0 || fabs(error) <= tolerance[0])
        && (tolerance[1] <= 0.0 || fabs(rate) <= tolerance[1]);
}

static int allows(const Piece *piece, double error, double rate)
{
    double tolerance[] = {piece->position_tolerance, piece->velocity_tolerance};
    return is_within(tolerance, error, rate);
}

/* Return whether all joints are within their tolerances on the path (0) or at the goal
   (2). */
static int are_all_within(const Law *law, int which)
{
    for (int k = 0; k < law->n; k++)
        if (!is_within(&law->tolerances[4 * k + which], law->errors[k], law->rates[k]))
            return 0;
    return 1;
}

/* Return whether a trajectory continues:
   control/trajectory_monitor.TrajectoryMonitor.check */
static int trajectory_continues(const Law *law, double time)
{
    int is_moving = time + law->lead < law->end;
    int is_first = law->start && law->start->is_first;
    if ((is_moving || is_first) && !are_all_within(law, 0))
        return 0;
    if (is_moving)
        return 1;
    double past = time - law->end;
    if (are_all_within(law, 2) ? law->has_goal : past > law->goal_time)
        return 0;
    return !(past > law->timeout);
}

/* Return whether an active goal continues, and note the joints that have arrived. */
static int goal_continues(Law *law, double time)
{
    int n_arrived = 0;
    for (int k = 0; k < law->n; k++) {
        const Piece *piece = active(law, k);
        n_arrived += law->arrived[k];
        if (piece->check == CHECK_PATH) {
            if (!allows(piece, law->errors[k], law->rates[k]))
                return 0;
        } else if (piece->check == CHECK_GOAL && !law->arrived[k]) {
            if (allows(piece, law->errors[k], law->rates[k]))
                n_arrived++;
            else if (!(time < piece->end + law->goal_time))
                return 0;
        }
    }
    if (n_arrived == law->n)
        return 0;
    for (int k = 0; k < law->n; k++) {
        const Piece *piece = active(law, k);
        if (piece->check == CHECK_GOAL && allows(piece, law->errors[k], law->rates[k]))
            law->arrived[k] = 1;
    }
    return 1;
}

static void compare_commands(Law *law, const double *measured)
{
    for (int k = 0; law->has_pid && k < law->n; k++) {
        double error = law->values[k] - measured[law->joints[k]];
        law->errors[k] = law->wraps[k] ? wrapped(error) : error;
    }
}

/* Return whether a gripper's goal has not succeeded and does not stall for too long. */
static int grip_continues(const Grip *grip, double time, double position)
{
    return !(fabs(grip->target - position) < grip->tolerance)
        && (fabs(position - grip->stall_position) > grip->stall_range
            || !(time - grip->stall_since > grip->stall_timeout));
}

/* Return whether Python need not execute the tick.  The end of a goal without a handle
   is noted here. */
static int prepare_grip(Law *law, double time, double position)
{
    return !law->is_monitored || law->grip->is_unheard != 0.0
        || grip_continues(law->grip, time, position);
}

double law_time(const Law *law, double time)
{
    return time - (law->lag + law->slip * (time - law->since));
}

int law_prepare(Law *law, double time, const double *position, const double *velocity)
{
    if (law->kind == LAW_COMMAND) {
        compare_commands(law, law->measures_velocity ? velocity : position);
        return 1;
    }
    if (law->kind == LAW_GRIPPER)
        return prepare_grip(law, time, position[law->joints[0]]);
    time = law_time(law, time);
    if (law->start && law->start->n_points && !law_start(law, time, position, velocity))
        return 0;
    if (!find_pieces(law, time))
        return 0;
    sample(law, time, position, velocity);
    for (int k = 0; k < law->n; k++)
        if (law->wraps[k])
            law->errors[k] = wrapped(law->errors[k]);
    if (!law->is_monitored)
        return 1;
    return law->watches_all ? trajectory_continues(law, time) : goal_continues(law, time);
}

/* control/parameters.Pid.update, for one joint */
static double pid(Law *law, int k, double period)
{
    const Gains *gains = &law->gains[k];
    double error = law->errors[k];
    double integral = law->integrals[k];
    if (!(-gains->error_deadband <= error && error <= gains->error_deadband))
        integral += period * error;
    double term = gains->i * integral;
    if (term > gains->i_max) {
        term = gains->i_max;
        if (gains->antiwindup)
            integral = term / gains->i;
    } else if (term < gains->i_min) {
        term = gains->i_min;
        if (gains->antiwindup)
            integral = term / gains->i;
    }
    double command = gains->p * error + term + gains->d * law->rates[k];
    if (!(gains->u_min <= command && command <= gains->u_max)) {
        double limited = command > gains->u_max ? gains->u_max : gains->u_min;
        if (gains->unwinding == UNWINDING_CONDITIONAL && error * command > 0.0)
            integral -= period * error;
        else if (gains->unwinding == UNWINDING_BACK_CALCULATION && gains->i != 0.0)
            integral += period * (limited - command) / (gains->tracking_time * gains->i);
        command = limited;
    }
    law->integrals[k] = integral;
    return command;
}

static double trajectory_command(Law *law, int k, double time, double period,
                                 double velocity)
{
    int leads = law->lead != 0.0;
    int is_moving = leads ? law->is_moving_ahead : law->is_moving;
    const Piece *piece =
        leads ? &law->pieces[k * law->max_pieces + law->piece_ahead[k]] : active(law, k);
    const double *c = piece->c, *d = piece->d;
    double t = (leads ? time + law->lead : time) - piece->origin;
    if (!law->has_pid) { /* a position interface takes the desired position */
        if (!is_moving)
            return c[0];
        return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
    }
    double command = pid(law, k, period);
    if (!law->has_feed_forward)
        return command;
    if (!leads)
        return command + law->feed_forward[k] * (law->rates[k] + velocity);
    double speed =
        is_moving ? c[1] + t * (d[0] + t * (d[1] + t * (d[2] + t * d[3]))) : -0.0;
    return command + law->feed_forward[k] * speed;
}

static double passed_command(Law *law, int k, double period)
{
    if (!law->has_pid)
        return law->values[k];
    law->rates[k] = (law->errors[k] - law->last_errors[k]) / period;
    law->last_errors[k] = law->errors[k];
    return pid(law, k, period);
}

static double grip_command(Law *law, double time, double period, double position,
                           double velocity)
{
    Grip *grip = law->grip;
    grip->position = position;
    if (law->is_monitored && !grip_continues(grip, time, position))
        law->is_monitored = 0;
    if (law->is_monitored
        && fabs(position - grip->stall_position) > grip->stall_range) {
        grip->stall_position = position;
        grip->stall_since = time;
    }
    if (!law->has_pid) {
        grip->effort = grip->max_effort;
        return grip->target;
    }
    if (law->bounds) {
        double effort, speed;
        drives_goal_at(law->bounds, grip->ramp, &effort, &speed);
        double step = grip->target - grip->ramp, most = speed * period;
        step = -most > step ? -most : step;
        grip->ramp += most < step ? most : step;
    } else {
        grip->ramp = grip->target;
    }
    law->errors[0] = grip->ramp - position;
    law->rates[0] = -velocity;
    double effort = pid(law, 0, period), bound = grip->max_effort;
    if (effort < -bound)
        effort = -bound;
    else if (bound < effort)
        effort = bound;
    grip->effort = effort;
    return effort;
}

void law_execute(Law *law, double time, double period, const double *position,
                 const double *velocity, double *command)
{
    double of_trajectory = law_time(law, time);
    if (law->start)
        law->start->is_first = 0;
    for (int k = 0; k < law->n; k++) {
        int i = law->joints[k];
        if (law->kind == LAW_TRAJECTORY)
            command[i] = trajectory_command(law, k, of_trajectory, period, velocity[i]);
        else if (law->kind == LAW_COMMAND)
            command[i] = passed_command(law, k, period);
        else
            command[i] = grip_command(law, time, period, position[i], velocity[i]);
    }
}
