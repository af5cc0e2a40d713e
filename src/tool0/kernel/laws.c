#include "laws.h"

#include <math.h>
#include <string.h>

#define PI 3.141592653589793
#define TAU 6.283185307179586

/* control/spline.shortest_turn(0, error) */
static double wrapped(double error)
{
    double turn = remainder(error, TAU);
    return turn == -PI ? PI : turn;
}

static const Piece *active(const Law *law, int k)
{
    return &law->pieces[k * law->max_pieces + law->piece[k]];
}

/* Find the pieces that are active at `time`; return 0 if one is not known. */
static int advance(Law *law, double time)
{
    int is_moving = 0;
    double next_change = INFINITY;
    for (int k = 0; k < law->n; k++) {
        const Piece *piece = active(law, k);
        while (time >= piece->until) {
            if (law->piece[k] + 1 >= law->n_pieces[k])
                return 0;
            law->piece[k]++;
            piece++;
        }
        for (int j = 1; j < 6; j++)
            is_moving |= piece->c[j] != 0.0;
        if (piece->until < next_change)
            next_change = piece->until;
    }
    law->is_moving = is_moving;
    law->next_change = next_change;
    return 1;
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

static int allows(const Piece *piece, double error, double rate)
{
    return (piece->position_tolerance <= 0.0 || fabs(error) <= piece->position_tolerance)
        && (piece->velocity_tolerance <= 0.0 || fabs(rate) <= piece->velocity_tolerance);
}

/* Return whether an active goal continues; note which joints have arrived. */
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

/* Return whether a gripper's goal neither succeeds nor stalls for too long. */
static int grip_continues(const Grip *grip, double time, double position)
{
    return !(fabs(grip->target - position) < grip->tolerance)
        && (fabs(position - grip->stall_position) > grip->stall_range
            || !(time - grip->stall_since > grip->stall_timeout));
}

int law_prepare(Law *law, double time, const double *position, const double *velocity)
{
    if (law->kind == LAW_COMMAND) {
        compare_commands(law, law->measures_velocity ? velocity : position);
        return 1;
    }
    if (law->kind == LAW_GRIPPER)
        return !law->is_monitored
            || grip_continues(law->grip, time, position[law->joints[0]]);
    if (time >= law->next_change && !advance(law, time))
        return 0;
    sample(law, time, position, velocity);
    for (int k = 0; k < law->n; k++)
        if (law->wraps[k])
            law->errors[k] = wrapped(law->errors[k]);
    return !law->is_monitored || goal_continues(law, time);
}

/* control/parameters.Pid.update, for one joint */
static double pid(Law *law, int k, double period)
{
    const Gains *gains = &law->gains[k];
    double error = law->errors[k];
    double integral = law->integrals[k] + period * error;
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
    law->integrals[k] = integral;
    return gains->p * error + term + gains->d * law->rates[k];
}

static double trajectory_command(Law *law, int k, double time, double period,
                                 double velocity)
{
    if (!law->has_pid) { /* a position interface takes the desired position */
        const Piece *piece = active(law, k);
        const double *c = piece->c;
        double t = time - piece->origin;
        if (!law->is_moving)
            return c[0];
        return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
    }
    double command = pid(law, k, period);
    if (law->has_feed_forward)
        command += law->feed_forward[k] * (law->rates[k] + velocity);
    return command;
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
    for (int k = 0; k < law->n; k++) {
        int i = law->joints[k];
        if (law->kind == LAW_TRAJECTORY)
            command[i] = trajectory_command(law, k, time, period, velocity[i]);
        else if (law->kind == LAW_COMMAND)
            command[i] = passed_command(law, k, period);
        else
            command[i] = grip_command(law, time, period, position[i], velocity[i]);
    }
}
