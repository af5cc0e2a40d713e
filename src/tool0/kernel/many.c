/* Many copies of a robot: ticks in threads, and motions that start at once. */

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "export.h"
#include "robot.h"

int tool0_run(Robot *robot, int most, int *done);

/* ---- ticks ----------------------------------------------------------------------- */

enum { MOST_THREADS = 1024 };

typedef struct {
    Robot *const *robots;
    int n;
    const int32_t *most;
    int32_t *done, *results;
    int next; /* the copy that the next free thread takes */
} Work;

static void *take_copies(void *argument)
{
    Work *work = argument;
    for (;;) {
        int i = __atomic_fetch_add(&work->next, 1, __ATOMIC_RELAXED);
        if (i >= work->n)
            return NULL;
        int done = 0;
        work->results[i] = tool0_run(work->robots[i], work->most[i], &done);
        work->done[i] = done;
    }
}

/* Execute up to most[i] ticks of each robot, as tool0_run, in so many threads. */
TOOL0_EXPORT void tool0_run_many(Robot *const *robots, int n, const int32_t *most,
                                 int threads, int32_t *done, int32_t *results)
{
    Work work = {robots, n, most, done, results, 0};
    pthread_t others[MOST_THREADS];
    int n_others = 0;
    while (n_others < threads - 1 && n_others < n - 1 && n_others < MOST_THREADS
           && !pthread_create(&others[n_others], NULL, take_copies, &work))
        n_others++; /* with fewer threads than wanted, it takes longer */
    take_copies(&work);
    for (int i = 0; i < n_others; i++)
        pthread_join(others[i], NULL);
}

/* ---- motions: JointTrajectoryController.command with one point ------------------- */

/* control/spline.IMPLAUSIBLE */
static const double IMPLAUSIBLE = 1e9;

enum { STARTED = 0, UNKNOWN = 1, REFUSED = 2 };

/* The desired motion of a joint: control/spline.Segment.sample; 0 if it is not known. */
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

/* control/spline._fit, to an end without an acceleration. */
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

/* The segment of a joint from the desired motion at `now` to one point. */
static int segment(const Law *law, int k, double now, double end, double position,
                   const double *velocity, double *c)
{
    double q, qd, T = end - now;
    if (law->lead != 0.0) /* it starts with the measured motion */
        return UNKNOWN;
    if (!desired(law, k, now, &q, &qd) || !(T > 0.0))
        return UNKNOWN;
    if (law->wraps[k])
        position = position + wrap_offset(q, position);
    fit(q, qd, position, velocity, T, c);
    return is_bounded(c, T) ? STARTED : REFUSED;
}

/* The pieces of one segment and of the rest after it: control/sampler.pieces_from. */
static void set_pieces(Law *law, int k, double now, double end, const double *c)
{
    Piece *pieces = &law->pieces[k * law->max_pieces];
    memset(pieces, 0, 3 * sizeof(Piece));
    for (int j = 0; j < 2; j++) {
        pieces[j].origin = now;
        memcpy(pieces[j].c, c, sizeof pieces[j].c);
        for (int i = 0; i < 4; i++)
            pieces[j].d[i] = (i + 2) * c[i + 2];
    }
    double t = end - now;
    pieces[2].c[0] =
        c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
    pieces[0].until = end;
    pieces[1].until = nextafter(end, INFINITY);
    pieces[2].until = INFINITY;
    for (int j = 0; j < 3; j++)
        pieces[j].end = end;
    law->n_pieces[k] = 3;
    law->piece[k] = 0;
    law->started[k] = 1;
}

/* Start a motion of n_joints joints of each law, by their numbers there, to one point.

   `now` and `durations` [s] have shape (n), `positions` (n, n_joints), and so have
   `velocities`, unless they are NULL.  If a law does not know its motion (UNKNOWN) or
   a motion is implausible (REFUSED), *which is its number and nothing has changed. */
TOOL0_EXPORT int tool0_start_many(Law *const *laws, int n, int n_joints,
                                  const int32_t *joints, const double *now,
                                  const double *durations, const double *positions,
                                  const double *velocities, int32_t *which)
{
    for (int is_checked = 0; is_checked < 2; is_checked++)
        for (int i = 0; i < n; i++) {
            double end = now[i] + durations[i], c[n_joints][6];
            for (int j = 0; j < n_joints; j++) {
                int at = i * n_joints + j;
                int result =
                    segment(laws[i], joints[j], now[i], end, positions[at],
                            velocities == NULL ? NULL : &velocities[at], c[j]);
                if (result != STARTED) {
                    *which = i;
                    return result;
                }
            }
            if (!is_checked)
                continue;
            for (int j = 0; j < n_joints; j++)
                set_pieces(laws[i], joints[j], now[i], end, c[j]);
            laws[i]->next_change = -INFINITY;
            laws[i]->is_monitored = 0;
        }
    return STARTED;
}

/* Set *positions to the desired position of one joint of each law at `now`. */
TOOL0_EXPORT int tool0_desired_many(Law *const *laws, int n, int joint,
                                    const double *now, double *positions)
{
    double velocity;
    for (int i = 0; i < n; i++)
        if (!desired(laws[i], joint, law_time(laws[i], now[i]), &positions[i], &velocity))
            return UNKNOWN;
    return STARTED;
}
