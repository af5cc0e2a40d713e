#include <float.h>
#include <math.h>
#include <string.h>

#include "drives.h"
#include "export.h"

/* Python's min and max: the first argument, unless the second argument is smaller or
   larger. */
static inline double least(double a, double b) { return b < a ? b : a; }
static inline double greatest(double a, double b) { return b > a ? b : a; }

/* ---- gravity: JointDynamics in description/bodies.py -------------------------------- */

static void frame_of(const DriveBody *body, double (*frames)[12], int i, double q)
{
    double *f = frames[i];
    memcpy(f, body->placement, sizeof body->placement);
    if (body->parent >= 0) {
        const double *r = frames[body->parent];
        for (int k = 0; k < 9; k += 3) {
            double x = f[k], y = f[k + 1], z = f[k + 2];
            f[k] = r[0] * x + r[3] * y + r[6] * z;
            f[k + 1] = r[1] * x + r[4] * y + r[7] * z;
            f[k + 2] = r[2] * x + r[5] * y + r[8] * z;
        }
        double x = f[9], y = f[10], z = f[11];
        f[9] = r[0] * x + r[3] * y + r[6] * z + r[9];
        f[10] = r[1] * x + r[4] * y + r[7] * z + r[10];
        f[11] = r[2] * x + r[5] * y + r[8] * z + r[11];
    }
    if (body->is_prismatic) {
        for (int k = 0; k < 3; k++)
            f[9 + k] = f[9 + k] + q * f[6 + k];
        return;
    }
    double c = cos(q), s = sin(q);
    for (int k = 0; k < 3; k++) {
        double a = f[k], b = f[3 + k];
        f[k] = c * a + s * b;
        f[3 + k] = c * b - s * a;
    }
}

void drives_frames(const DriveBody *bodies, int n, const double *position,
                   double (*frames)[12])
{
    for (int i = 0; i < n; i++)
        frame_of(&bodies[i], frames, i, position[bodies[i].joint]);
}

/* Set loads, by joint, to the efforts that balance gravity and springs. */
static void static_effort(const DriveTable *table, const double *position, double *loads)
{
    const DriveBody *bodies = table->bodies;
    int n = table->n_bodies;
    double frames[n][12], mass[n], moment_x[n], moment_y[n];
    drives_frames(bodies, n, position, frames);
    for (int i = 0; i < n; i++) {
        const double *f = frames[i], *c = bodies[i].center;
        double m = mass[i] = bodies[i].mass;
        moment_x[i] = m * (f[0] * c[0] + f[3] * c[1] + f[6] * c[2] + f[9]);
        moment_y[i] = m * (f[1] * c[0] + f[4] * c[1] + f[7] * c[2] + f[10]);
    }
    for (int i = 0; i < table->n_joints; i++)
        loads[i] = 0.0;
    double g = table->gravity;
    for (int i = n - 1; i >= 0; i--) {
        const DriveBody *body = &bodies[i];
        const double *f = frames[i];
        double load;
        if (body->is_prismatic) {
            load = g * mass[i] * f[8];
        } else {
            double lever_x = moment_x[i] - mass[i] * f[9];
            double lever_y = moment_y[i] - mass[i] * f[10];
            load = g * (f[6] * lever_y - f[7] * lever_x);
        }
        loads[bodies[body->master].joint] += body->multiplier * load;
        if (body->parent >= 0) {
            mass[body->parent] += mass[i];
            moment_x[body->parent] += moment_x[i];
            moment_y[body->parent] += moment_y[i];
        }
    }
    for (int k = 0; k < table->n_springs; k++) {
        const DriveSpring *spring = &table->springs[k];
        double q = position[bodies[spring->joint].joint];
        loads[bodies[spring->master].joint] +=
            spring->multiplier * spring->stiffness * (q - spring->reference);
    }
}

/* ---- servos: hardware/servos.py -------------------------------------------------- */

static void velocity_window(const DriveWindow *window, double position, double *slowest,
                            double *fastest)
{
    double most = window->velocity;
    *slowest = -most;
    *fastest = most;
    if (window->is_soft) {
        double lower = -window->k_position * (position - window->soft_lower);
        double upper = -window->k_position * (position - window->soft_upper);
        *slowest = least(greatest(lower, -most), most);
        *fastest = least(greatest(upper, -most), most);
    }
}

static double to_position(const DriveTable *table, DriveServo *servo, double command,
                          double position, double velocity, int left)
{
    double dt = table->dt, slowest, fastest;
    double previous = servo->target, lag = previous - position;
    int is_stopped = servo->is_stiff && fabs(lag) > table->stopped;
    if (is_stopped && (command - position) * lag < 0.0)
        previous = position;
    velocity_window(&servo->window, previous, &slowest, &fastest);
    slowest = greatest(slowest, -servo->speed);
    fastest = least(fastest, servo->speed);
    double step = least(greatest((command - previous) / left, slowest * dt),
                        fastest * dt);
    double target = least(greatest(previous + step, servo->lower), servo->upper);
    servo->target = target;
    double error = target - position;
    double stiffness = servo->bandwidth * servo->bandwidth;
    int is_blocked =
        fabs(lag) > table->blocked && fabs(velocity) < table->standstill;
    if (is_stopped || is_blocked)
        servo->integral = 0.0;
    else
        servo->integral += stiffness * servo->integral_rate * error * dt;
    double speed_error = (target - previous) / dt - velocity;
    return stiffness * error
           + 2.0 * table->damping_ratio * servo->bandwidth * speed_error
           + servo->integral;
}

static double at_velocity(const DriveTable *table, DriveServo *servo, double command,
                          double position, double velocity)
{
    double slowest, fastest;
    velocity_window(&servo->window, position, &slowest, &fastest);
    double error = least(greatest(command, slowest), fastest) - velocity;
    double gain = 2.0 * table->damping_ratio * table->velocity_bandwidth;
    servo->integral += gain * table->integral_rate * error * table->dt;
    return gain * error + servo->integral;
}

static double acceleration(const DriveTable *table, DriveServo *servo, double command,
                           double position, double velocity, int left)
{
    if (servo->kind == SERVO_POSITION)
        return to_position(table, servo, command, position, velocity, left);
    return at_velocity(table, servo, command, position, velocity);
}

/* ---- limits: hardware/limits.py -------------------------------------------------- */

/* Set the largest effort and velocity of a goal's limits: DriveLimits.at. */
void drives_goal_at(const DriveGoal *goal, double position, double *effort,
                    double *velocity)
{
    double lever;
    if (goal->is_linear)
        lever = 2.0 * fabs(goal->pad_slope);
    else
        lever = 2.0
                * fabs(goal->pad_sin * cos(position)
                       - goal->pad_cos * sin(position));
    *effort = goal->is_force ? goal->grip * lever : goal->grip;
    *velocity = lever <= 0.0 ? INFINITY : goal->speed / lever;
}

/* SpeedLimiter.limit; *before is the velocity in the last step. */
static double limit_speed(const DriveBounds *bounds, const DriveGoal *goal,
                          double *before, double effort, double applied,
                          double gravity, double position, double velocity)
{
    double most = bounds->effort, speed = bounds->velocity, rotor = bounds->rotor;
    if (!goal->is_limited && -most <= effort && effort <= most
        && fabs(velocity) + fabs(effort) / rotor <= speed) {
        *before = NAN;
        return effort;
    }
    if (goal->is_limited) {
        double grip, fastest;
        drives_goal_at(goal, position, &grip, &fastest);
        double lowest = least(gravity - grip, applied + bounds->ease);
        double highest = greatest(gravity + grip, applied - bounds->ease);
        effort = least(greatest(effort, lowest), highest);
        speed = least(speed, fastest);
    }
    effort = least(greatest(effort, -most), most);
    double last = *before;
    *before = velocity;
    if (rotor == INFINITY) {
        int is_too_fast = effort > 0.0 ? velocity > speed : velocity < -speed;
        return is_too_fast ? 0.0 : effort;
    }
    double held_back = 0.0;
    if (!isnan(last))
        held_back = applied - (velocity - last) * rotor;
    if (effort > gravity) {
        double room = (speed - velocity) * rotor + held_back;
        return least(effort, greatest(room, least(0.0, gravity)));
    }
    double room = held_back - (speed + velocity) * rotor;
    return greatest(effort, least(room, greatest(0.0, gravity)));
}

/* One row of EffortLimiter.saturate; speed is infinite if the speed has already been
   limited. */
static double saturate(const DriveBounds *bounds, double speed, double u,
                       double position, double velocity)
{
    double most = bounds->effort;
    if (u > 0.0) {
        int is_over = position > bounds->upper || velocity > speed;
        return is_over ? 0.0 : least(u, most);
    }
    if (u < 0.0) {
        int is_over = position < bounds->lower || velocity < -speed;
        return is_over ? 0.0 : greatest(u, -most);
    }
    return u;
}

static double soften(const DriveBounds *bounds, double effort, double position,
                     double velocity)
{
    double slowest, fastest, most = bounds->effort, k = bounds->k_velocity;
    velocity_window(&bounds->window, position, &slowest, &fastest);
    double lower = least(greatest(-k * (velocity - slowest), -most), most);
    double upper = least(greatest(-k * (velocity - fastest), -most), most);
    return least(greatest(effort, lower), upper);
}

/* ---- speeds: hardware/speed_governor.py ------------------------------------------ */

static int is_fast(const DriveGovernor *governor, const double *velocity)
{
    for (int k = 0; k < governor->n_drives; k++) {
        const DriveGoverned *drive = &governor->drives[k];
        if (fabs(velocity[drive->joint]) > drive->fast)
            return 1;
    }
    return 0;
}

/* SpeedGovernor.is_mobility_due */
static int is_mobility_due(const DriveGovernor *governor, const double *position)
{
    if (!governor->has_mobility)
        return 1;
    for (int k = 0; k < governor->n_free; k++)
        if (fabs(position[governor->free[k]] - governor->posture[k])
            > governor->largest_turn)
            return 1;
    return 0;
}

static void change(double *coming, const double *row, int n, double by)
{
    for (int j = 0; j < n; j++)
        coming[j] += row[j] * by;
}

/* SpeedGovernor._share_excess */
static void share_excess(const DriveGovernor *governor, double *coming, double *used)
{
    int n = governor->n_free, m = governor->n_drives;
    for (int sweep = 0; sweep < governor->sweeps; sweep++) {
        int is_within = 1;
        for (int k = 0; k < m; k++) {
            const double *row = &governor->mobility[k * n];
            double speed = governor->drives[k].speed;
            double excess = coming[k] - least(greatest(coming[k], -speed), speed);
            if (!(fabs(excess) > governor->tolerance))
                continue;
            is_within = 0;
            double norm = 0.0;
            for (int j = 0; j < m; j++)
                norm += row[j] * row[j];
            for (int j = 0; j < m; j++) {
                double old = used[j], most = governor->drives[j].effort;
                double best = old - excess * row[j] / norm;
                used[j] = best = least(greatest(best, -most), most);
                change(coming, &governor->mobility[j * n], n, best - old);
            }
        }
        if (is_within)
            break;
    }
}

/* SpeedGovernor.limit, without the changes of its state. */
static void govern(const DriveGovernor *governor, double *effort, const double *applied,
                   const double *velocity)
{
    int n = governor->n_free, m = governor->n_drives;
    double coming[n], wanted[n], used[n];
    for (int k = 0; k < n; k++) {
        int i = governor->free[k];
        coming[k] = velocity[i] + (velocity[i] - governor->before[i]);
        wanted[k] = effort[i];
        if (k < m) {
            double most = governor->drives[k].effort;
            wanted[k] = least(greatest(wanted[k], -most), most);
        }
        used[k] = wanted[k];
    }
    for (int k = 0; k < n; k++)
        change(coming, &governor->mobility[k * n], n,
               wanted[k] - applied[governor->free[k]]);
    int is_within = 1;
    for (int k = 0; k < m; k++)
        is_within &= fabs(coming[k]) <= governor->drives[k].speed;
    if (is_within)
        return;
    for (int sweep = 0; sweep < governor->sweeps; sweep++) {
        int has_changed = 0;
        for (int k = 0; k < m; k++) {
            const DriveGoverned *drive = &governor->drives[k];
            const double *row = &governor->mobility[k * n];
            double old = used[k], speed = drive->speed;
            double reached = coming[k] + row[k] * (wanted[k] - old);
            reached = least(greatest(reached, -speed), speed);
            double best = old + (reached - coming[k]) / row[k];
            used[k] = best = least(greatest(best, -drive->effort), drive->effort);
            if (best != old) {
                has_changed = 1;
                change(coming, row, n, best - old);
            }
        }
        if (!has_changed)
            break;
    }
    share_excess(governor, coming, used);
    for (int k = 0; k < m; k++)
        effort[governor->drives[k].joint] = used[k];
}

/* ---- RobotHardware.efforts ------------------------------------------------------- */

static int what_is_due(const Drives *drives, const double *command,
                        const double *position, const double *velocity,
                        const double *effort)
{
    const DriveTable *table = drives->table;
    for (int i = 0; i < table->n_joints; i++)
        if (!(fabs(command[i]) <= DBL_MAX) || !(fabs(position[i]) <= DBL_MAX)
            || !(fabs(velocity[i]) <= DBL_MAX) || !(fabs(effort[i]) <= DBL_MAX))
            return DRIVES_EVENT;
    const DriveGovernor *governor = &drives->governor;
    if (is_fast(governor, velocity) && is_mobility_due(governor, position))
        return DRIVES_MOBILITY;
    if (!drives->n_servos || drives->masses_at == drives->steps)
        return DRIVES_OK;
    if (!drives->has_masses || drives->steps % table->pose_period == 0)
        return DRIVES_MASSES;
    return DRIVES_OK;
}

static void run_servos(Drives *drives, const double *loads, const double *command,
                       const double *position, const double *velocity,
                       double *requested)
{
    const DriveTable *table = drives->table;
    int n = drives->n_servos, period = table->steps_per_command;
    int left = period - (int)(drives->steps % period);
    double wanted[n];
    for (int k = 0; k < n; k++) {
        DriveServo *servo = &drives->servos[k];
        int i = servo->joint;
        double most = servo->fastest;
        double a = acceleration(table, servo, command[i], position[i], velocity[i],
                                left);
        wanted[k] = a < -most ? -most : least(a, most);
        const DriveGoal *goal = &drives->goals[i];
        if (!goal->is_limited)
            continue;
        drives->gravity[i] = loads[i];
        if (servo->kind == SERVO_POSITION) {
            double effort;
            drives_goal_at(goal, position[i], &effort, &servo->speed);
        }
    }
    for (int k = 0; k < n; k++) {
        double sum = 0.0;
        for (int j = 0; j < n; j++)
            sum += drives->masses[k * n + j] * wanted[j];
        int i = drives->servos[k].joint;
        requested[i] = loads[i] + sum;
    }
}

TOOL0_EXPORT int drives_efforts(Drives *drives, const double *command,
                                const double *position, const double *velocity,
                                double *effort)
{
    const DriveTable *table = drives->table;
    int due = what_is_due(drives, command, position, velocity, effort);
    if (due != DRIVES_OK)
        return due;
    int n = table->n_joints;
    int is_due = table->n_compensated
                 && (!drives->has_compensation
                     || drives->steps % table->pose_period == 0);
    double requested[n], loads[n];
    memcpy(requested, command, sizeof requested);
    if (is_due || drives->n_servos)
        static_effort(table, position, loads);
    if (is_due) {
        for (int k = 0; k < table->n_compensated; k++) {
            int i = table->compensated[k];
            drives->compensation[k] = drives->gravity[i] = loads[i];
        }
        drives->has_compensation = 1;
    }
    for (int k = 0; k < table->n_compensated; k++)
        requested[table->compensated[k]] += drives->compensation[k];
    if (drives->n_servos)
        run_servos(drives, loads, command, position, velocity, requested);
    DriveGovernor *governor = &drives->governor;
    if (governor->n_drives) {
        if (governor->has_before && is_fast(governor, velocity))
            govern(governor, requested, effort, velocity);
        memcpy(governor->before, velocity, (size_t)n * sizeof(double));
        governor->has_before = 1;
    }
    drives->steps++;
    for (int k = 0; k < table->n_drives; k++) {
        const DriveBounds *bounds = &table->bounds[k];
        int i = bounds->joint;
        const DriveGoal *goal = &drives->goals[i];
        double u = requested[i], q = position[i], qd = velocity[i];
        double speed = drives->governed[i] ? INFINITY : bounds->velocity;
        if (goal->is_limited || bounds->rotor < INFINITY) {
            u = limit_speed(bounds, goal, &drives->before[i], u, effort[i],
                            drives->gravity[i], q, qd);
            speed = INFINITY;
        }
        u = saturate(bounds, speed, u, q, qd);
        requested[i] = bounds->limits_effort ? soften(bounds, u, q, qd) : u;
    }
    for (int k = 0; k < drives->n_brakes; k++)
        requested[drives->brakes[k]] = 0.0;
    memcpy(effort, requested, sizeof requested);
    return DRIVES_OK;
}
