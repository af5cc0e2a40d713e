/* Start of motions in the kernel: JointTrajectoryController.command of ROS 1 and ROS 2. */

#include <math.h>
#include <string.h>

#include "export.h"
#include "robot.h"

/* control/spline.IMPLAUSIBLE */
static const double IMPLAUSIBLE = 1e9;

/* control/ros2/trajectory_check.EPSILON */
static const double EPSILON = 1.1920929e-07;

enum { STARTED = 0, UNKNOWN = 1, REFUSED = 2 };

/* Compute the desired motion of a joint (control/spline.Segment.sample); return 0 if it
   is not known. */
static int desired(const Law *law, int k, double time, double *q, double *qd)
{
    const Piece *pieces = &law->pieces[k * law->max_pieces];
    int j = law->piece[k];
    while (time >= pieces[j].until)
        if (++j >= law->n_pieces[k])
            return 0;
    const double *c = pieces[j].c;
    double t = time - pieces[j].origin;
    *q = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
    *qd = c[1] + t * (2 * c[2] + t * (3 * c[3] + t * (4 * c[4] + t * 5 * c[5])));
    return 1;
}

/* control/spline._fit, for an end without an acceleration. */
static void fit(double q0, double v0, double q1, const double *v1, double T, double *c)
{
    memset(c, 0, 6 * sizeof(double));
    c[0] = q0;
    if (v1 == NULL) {
        c[1] = (q1 - q0) / T;
        return;
    }
    double d = q1 - q0;
    c[1] = v0;
    c[2] = (3.0 * d - (2.0 * v0 + *v1) * T) / T / T;
    c[3] = (-2.0 * d + (v0 + *v1) * T) / T / T / T;
}

/* control/spline.Segment.is_bounded */
static int is_bounded(const double *c, double T)
{
    double a[6];
    for (int j = 0; j < 6; j++)
        a[j] = fabs(c[j]);
    double position = a[0] + T * (a[1] + T * (a[2] + T * (a[3] + T * (a[4] + T * a[5]))));
    double speed =
        a[1] + T * (2 * a[2] + T * (3 * a[3] + T * (4 * a[4] + T * 5 * a[5])));
    return position <= IMPLAUSIBLE && speed <= IMPLAUSIBLE;
}

/* control/spline.wrap_offset */
static double wrap_offset(double previous, double following)
{
    const double PI = 3.141592653589793, TAU = 6.283185307179586;
    double turn = remainder(following - previous, TAU);
    if (turn == -PI)
        turn = PI;
    if (fabs(turn) > PI - 1e-9)
        turn = copysign(turn, following - previous);
    return previous + turn - following;
}

/* The part of a trajectory for one joint.  Its points are `stride` numbers apart. */
typedef struct {
    double now; /* [s] */
    int n_points;
    const double *times; /* times of the points relative to `now` [s] */
    const double *positions, *velocities; /* velocities may be NULL */
    int stride;
} Course;

/* Compute the polynomials of a joint's segments from the motion q, qd:
   control/spline.Knots. */
static int segments(const Course *course, int wraps, double q, double qd, double (*c)[6])
{
    double begin = course->now, offset = 0.0;
    if (wraps)
        offset = wrap_offset(q, course->positions[0]);
    for (int m = 0; m < course->n_points; m++) {
        double end = course->now + course->times[m], T = end - begin;
        double position = course->positions[m * course->stride];
        const double *velocity = NULL;
        if (course->velocities != NULL)
            velocity = &course->velocities[m * course->stride];
        if (wraps)
            position = position + offset;
        if (!(T > 0.0))
            return UNKNOWN;
        fit(q, qd, position, velocity, T, c[m]);
        if (!is_bounded(c[m], T))
            return REFUSED;
        q = position;
        qd = velocity == NULL ? 0.0 : *velocity; /* lines do not need a velocity */
        begin = end;
    }
    return STARTED;
}

static void set_piece(Piece *piece, double origin, double end, double until,
                      const double *c)
{
    memset(piece, 0, sizeof(Piece));
    piece->origin = origin;
    memcpy(piece->c, c, sizeof piece->c);
    for (int i = 0; i < 4; i++)
        piece->d[i] = (i + 2) * c[i + 2];
    piece->end = end;
    piece->until = until;
}

/* Set the pieces of the segments and of the following rest:
   control/sampler.pieces_from. */
static void set_pieces(Law *law, int k, const Course *course, double (*c)[6])
{
    Piece *pieces = &law->pieces[k * law->max_pieces];
    int last = course->n_points - 1;
    double begin = course->now, end = begin;
    for (int m = 0; m <= last; m++) {
        begin = m == 0 ? course->now : end;
        end = course->now + course->times[m];
        set_piece(&pieces[m], begin, end, end, c[m]);
        law->times[k * law->max_pieces + m] = course->times[m];
    }
    set_piece(&pieces[last + 1], begin, end, nextafter(end, INFINITY), c[last]);
    const double *a = c[last];
    double t = end - begin, rest[6] = {0.0};
    rest[0] = a[0] + t * (a[1] + t * (a[2] + t * (a[3] + t * (a[4] + t * a[5]))));
    set_piece(&pieces[last + 2], 0.0, end, INFINITY, rest);
    law->n_pieces[k] = last + 3;
    law->piece[k] = law->piece_ahead[k] = 0;
    law->started[k] = last + 1;
}

/* Motions of n_joints joints of one law through points.  The joints are given by their
   numbers in the law. */
typedef struct {
    double now; /* [s] */
    int n_joints, n_points;
    const int32_t *joints;
    const double *times;                  /* (n_points) */
    const double *positions, *velocities; /* (n_points, n_joints); may be NULL */
} Motion;

static Course course_of(const Motion *motion, int j, double now)
{
    const double *velocities = motion->velocities;
    return (Course){now, motion->n_points, motion->times, &motion->positions[j],
                    velocities == NULL ? NULL : &velocities[j], motion->n_joints};
}

/* ---- ROS 1: a motion starts immediately, from the desired motion ------------------ */

static int start_at_once(Law *law, const Motion *motion, int is_checked)
{
    double c[motion->n_points][6];
    for (int j = 0; j < motion->n_joints; j++) {
        int k = motion->joints[j];
        Course course = course_of(motion, j, motion->now);
        double q, qd;
        if (!desired(law, k, motion->now, &q, &qd))
            return UNKNOWN;
        int result = segments(&course, law->wraps[k], q, qd, c);
        if (result != STARTED)
            return result;
        if (is_checked)
            set_pieces(law, k, &course, c);
    }
    if (is_checked) {
        law->next_change = -INFINITY;
        law->is_monitored = 0;
    }
    return STARTED;
}

/* ---- ROS 2: a trajectory of all joints starts in the next tick -------------------- */

/* JointTrajectoryController._can_follow, for a trajectory without a goal */
static int can_follow(const Law *law)
{
    const Start *start = law->start;
    return start->is_spliced && start->has_points && law->is_monitored && !start->n_points;
}

/* Return whether another trajectory may follow the trajectory that is due to start. */
static int will_have_points(const Start *start)
{
    return start->is_following || start->n_points > 1;
}

/* Return whether Python must accept the trajectory, or has more data of the motion
   before it. */
static int is_left_to_python(const Law *law, const Motion *motion)
{
    const Start *start = law->start;
    if (!start->is_known || motion->n_joints != law->n
        || (law->is_monitored && law->watches_all && law->has_goal))
        return 1;
    if (start->n_points
        && (start->from_desired || (start->is_spliced && will_have_points(start))))
        return 1;
    if (motion->velocities == NULL || start->may_end_moving)
        return 0;
    int last = (motion->n_points - 1) * motion->n_joints;
    for (int j = 0; j < motion->n_joints; j++)
        if (fabs(motion->velocities[last + j]) > EPSILON)
            return 1; /* Python rejects the trajectory */
    return 0;
}

/* Set the motion from which a trajectory of joint k starts; return 0 if it is not
   known. */
static int origin(const Law *law, int k, int is_following, double time,
                  const double *position, const double *velocity, double *q, double *qd)
{
    if (is_following || law->start->from_desired)
        return desired(law, k, time, q, qd);
    *q = position[law->joints[k]];
    *qd = law->start->reads_velocity ? velocity[law->joints[k]] : 0.0;
    return 1;
}

static void keep_points(Law *law, const Motion *motion, int is_following)
{
    Start *start = law->start;
    int n = law->n, has_velocities = motion->velocities != NULL;
    for (int m = 0; m < motion->n_points; m++) {
        start->times[m] = motion->times[m];
        for (int j = 0; j < n; j++) {
            int from = m * n + j, to = m * n + motion->joints[j];
            start->positions[to] = motion->positions[from];
            start->velocities[to] = has_velocities ? motion->velocities[from] : 0.0;
        }
    }
    start->now = motion->now;
    start->n_points = motion->n_points;
    start->has_velocities = has_velocities;
    start->is_following = is_following;
}

static int start_with_tick(const Robot *robot, Law *law, const Motion *motion,
                           int is_checked)
{
    double c[motion->n_points][6], time = law_time(law, motion->now);
    if (!is_checked && is_left_to_python(law, motion))
        return UNKNOWN;
    int is_following = can_follow(law);
    if (is_checked) {
        keep_points(law, motion, is_following);
        return STARTED;
    }
    for (int j = 0; j < motion->n_joints; j++) {
        int k = motion->joints[j];
        Course course = course_of(motion, j, time);
        double q, qd;
        if (!origin(law, k, is_following, time, robot->position, robot->velocity, &q, &qd))
            return UNKNOWN;
        int result = segments(&course, law->wraps[k], q, qd, c);
        if (result != STARTED)
            return result;
    }
    return STARTED;
}

int law_start(Law *law, double time, const double *position, const double *velocity)
{
    Start *start = law->start;
    int n = law->n, n_points = start->n_points;
    double c[n][n_points][6];
    Motion motion = {time, n, n_points, NULL, start->times, start->positions,
                     start->has_velocities ? start->velocities : NULL};
    if (law_time(law, start->now) != time)
        return 0;
    for (int k = 0; k < n; k++) {
        Course course = course_of(&motion, k, time);
        double q, qd;
        if (!origin(law, k, start->is_following, time, position, velocity, &q, &qd)
            || segments(&course, law->wraps[k], q, qd, c[k]) != STARTED)
            return 0;
    }
    for (int k = 0; k < n; k++) {
        Course course = course_of(&motion, k, time);
        set_pieces(law, k, &course, c[k]);
    }
    memcpy(law->tolerances, start->tolerances, (size_t)n * 4 * sizeof(double));
    law->is_monitored = law->watches_all = 1;
    law->has_goal = 0;
    law->end = time + start->times[n_points - 1];
    law->goal_time = start->goal_time;
    law->timeout = start->timeout;
    law->next_change = law->next_change_ahead = -INFINITY;
    start->has_points = will_have_points(start);
    start->n_points = 0;
    start->is_first = 1;
    return 1;
}

/* ---- for BatchKernel of many.py ---------------------------------------------------- */

/* Start motions of the same joints of n laws; each law is that of one robot.

   `now` [s] has shape (n), `times` [s] has shape (n, n_points), and `positions` and
   `velocities` have shape (n, n_points, n_joints); `velocities` may be NULL.  The
   function returns UNKNOWN if Python must start a motion, or has more data of the
   motion before it.  The function returns REFUSED if a motion is implausible.  In both
   cases, *which is the number of this motion, and nothing has been changed. */
TOOL0_EXPORT int tool0_start_many(Robot *const *robots, Law *const *laws, int n,
                                  int n_joints, const int32_t *joints, int n_points,
                                  const double *now, const double *times,
                                  const double *positions, const double *velocities,
                                  int32_t *which)
{
    for (int is_checked = 0; is_checked < 2; is_checked++)
        for (int i = 0; i < n; i++) {
            Law *law = laws[i];
            int at = i * n_points * n_joints;
            Motion motion = {now[i], n_joints, n_points, joints, &times[i * n_points],
                             &positions[at], velocities ? &velocities[at] : NULL};
            int result = UNKNOWN; /* too long, or only Python can start the motion */
            if (n_points + 2 > law->max_pieces)
                ;
            else if (law->start)
                result = start_with_tick(robots[i], law, &motion, is_checked);
            else if (law->lead == 0.0)
                result = start_at_once(law, &motion, is_checked);
            *which = i;
            if (result != STARTED)
                return result;
        }
    return STARTED;
}

/* Set the desired positions of one joint of each law at `now`; return UNKNOWN if one is
   not known. */
TOOL0_EXPORT int tool0_desired_many(Law *const *laws, int n, int joint,
                                    const double *now, double *positions)
{
    double velocity;
    for (int i = 0; i < n; i++)
        /* the motion changes in the next tick */
        if ((laws[i]->start && laws[i]->start->n_points)
            || !desired(laws[i], joint, law_time(laws[i], now[i]), &positions[i],
                        &velocity))
            return UNKNOWN;
    return STARTED;
}
