/* Many copies of a robot: ticks in threads, and motions that start at once. */

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "export.h"
#include "robot.h"

int tool0_run(Robot *robot, int most, int *done);

/* ---- ticks ----------------------------------------------------------------------- */

typedef struct {
    Robot *const *robots;
    int n, most;
    int64_t *left, *ticks, *untold;
    int32_t *results;
    int next; /* the copy that the next free thread takes */
} Work;

/* Threads that wait for work: creating them costs more than many a call, and on a busy
   machine a new thread is the last in the queue. */
typedef struct {
    pthread_mutex_t lock;
    pthread_cond_t changed; /* there is work, or the pool closes */
    pthread_cond_t finished; /* no thread is busy */
    Work work;
    int has_work, n_busy, n_threads, is_closed;
    pid_t process; /* which has the threads */
} Pool;

static void take_copies(Work *work)
{
    for (;;) {
        int i = __atomic_fetch_add(&work->next, 1, __ATOMIC_RELAXED);
        if (i >= work->n)
            return;
        int64_t left = work->left[i];
        work->results[i] = RUN_DONE;
        if (!work->robots[i] || left <= 0)
            continue;
        int done = 0, most = left < work->most ? (int)left : work->most;
        work->results[i] = tool0_run(work->robots[i], most, &done);
        work->left[i] -= done;
        work->ticks[i] += done;
        work->untold[i] += done;
    }
}

static void free_pool(Pool *pool)
{
    pthread_mutex_destroy(&pool->lock);
    pthread_cond_destroy(&pool->changed);
    pthread_cond_destroy(&pool->finished);
    free(pool);
}

static void *serve(void *argument)
{
    Pool *pool = argument;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->has_work && !pool->is_closed)
            pthread_cond_wait(&pool->changed, &pool->lock);
        if (pool->is_closed)
            break;
        pool->n_busy++;
        pthread_mutex_unlock(&pool->lock);
        take_copies(&pool->work);
        pthread_mutex_lock(&pool->lock);
        pool->has_work = 0; /* every copy is taken */
        if (!--pool->n_busy)
            pthread_cond_signal(&pool->finished);
    }
    int is_last = !--pool->n_threads;
    pthread_mutex_unlock(&pool->lock);
    if (is_last)
        free_pool(pool);
    return NULL;
}

/* Return a pool of so many threads, the caller's included, or NULL without memory. */
TOOL0_EXPORT void *tool0_open_pool(int threads)
{
    Pool *pool = calloc(1, sizeof(Pool));
    if (!pool)
        return NULL;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->changed, NULL);
    pthread_cond_init(&pool->finished, NULL);
    pool->process = getpid();
    pthread_t thread;
    pthread_mutex_lock(&pool->lock);
    while (pool->n_threads < threads - 1 && !pthread_create(&thread, NULL, serve, pool)) {
        pthread_detach(thread);
        pool->n_threads++; /* with fewer threads than wanted, it takes longer */
    }
    pthread_mutex_unlock(&pool->lock);
    return pool;
}

/* A fork copies a pool without its threads, and its lock and conditions as they were at
   that moment: held, or with waiters that do not exist.  Nothing may wait for them. */
static int is_copy(const Pool *pool)
{
    return pool->process != getpid();
}

/* End the threads; the last one frees the pool. */
TOOL0_EXPORT void tool0_close_pool(void *opened)
{
    Pool *pool = opened;
    if (is_copy(pool)) {
        free(pool);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    pool->is_closed = 1;
    pthread_cond_broadcast(&pool->changed);
    int is_last = !pool->n_threads;
    pthread_mutex_unlock(&pool->lock);
    if (is_last)
        free_pool(pool);
}

/* Execute a batch's work, in the threads of a pool.

   A thread that wakes up after the last copy was taken is not waited for.  In a process
   that was forked after the pool was opened, the caller does all the work. */
static void run(Pool *pool, const Work *work)
{
    if (is_copy(pool)) {
        pool->work = *work;
        take_copies(&pool->work);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    pool->work = *work;
    pool->has_work = 1;
    for (int i = 1; i < work->n && i <= pool->n_threads; i++)
        pthread_cond_signal(&pool->changed);
    pthread_mutex_unlock(&pool->lock);
    take_copies(&pool->work);
    pthread_mutex_lock(&pool->lock);
    pool->has_work = 0;
    while (pool->n_busy)
        pthread_cond_wait(&pool->finished, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}

/* Execute the ticks that are left of each robot, up to `most`, as tool0_run; robots that
   are NULL are left out.  Their numbers are subtracted from `left`, and added to `ticks`
   and `untold`.  Returns whether an event ended a run, or ticks are left. */
TOOL0_EXPORT int tool0_run_many(void *pool, Robot *const *robots, int n, int most,
                                int64_t *left, int64_t *ticks, int64_t *untold,
                                int32_t *results)
{
    Work work = {robots, n, most, left, ticks, untold, results, 0};
    run(pool, &work);
    for (int i = 0; i < n; i++)
        if (robots[i] && (results[i] != RUN_DONE || left[i] > 0))
            return 1;
    return 0;
}

/* Copy positions, velocities and efforts of the joints of those robots for which is_read
   is true to an array of shape (3, n, n_joints). */
TOOL0_EXPORT void tool0_read_many(Robot *const *robots, int n, int n_joints,
                                  const char *is_read, double *found)
{
    double *position = found, *velocity = position + n * n_joints;
    double *effort = velocity + n * n_joints;
    size_t size = (size_t)n_joints * sizeof(double);
    for (int i = 0; i < n; i++) {
        if (!is_read[i])
            continue;
        int at = i * n_joints;
        memcpy(&position[at], robots[i]->position, size);
        memcpy(&velocity[at], robots[i]->velocity, size);
        memcpy(&effort[at], robots[i]->effort, size);
    }
}

/* ---- motions: JointTrajectoryController.command ------------------------------------ */

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

/* One joint's part of a trajectory: its points are `stride` numbers apart. */
typedef struct {
    double now; /* [s] */
    int n_points;
    const double *times; /* of the points after now [s] */
    const double *positions, *velocities; /* velocities may be NULL */
    int stride;
} Course;

/* The polynomials of a joint's segments from the motion q, qd; control/spline.Knots. */
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
        qd = velocity == NULL ? 0.0 : *velocity; /* lines need none */
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

/* The pieces of the segments and of the rest after them: control/sampler.pieces_from. */
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
    law->piece[k] = 0;
    law->started[k] = last + 1;
}

/* Start a motion of n_joints joints of each law, by their numbers there, through points.

   `now` [s] has shape (n), `times` [s] (n, n_points), `positions` (n, n_points, n_joints),
   and so have `velocities`, unless they are NULL.  If a law does not know its motion, or
   Python must start it (UNKNOWN), or a motion is implausible (REFUSED), *which is its
   number and nothing has changed. */
TOOL0_EXPORT int tool0_start_many(Law *const *laws, int n, int n_joints,
                                  const int32_t *joints, int n_points, const double *now,
                                  const double *times, const double *positions,
                                  const double *velocities, int32_t *which)
{
    double c[n_points][6];
    for (int is_checked = 0; is_checked < 2; is_checked++)
        for (int i = 0; i < n; i++) {
            Law *law = laws[i];
            *which = i;
            if (law->lead != 0.0 || n_points + 2 > law->max_pieces)
                return UNKNOWN; /* it starts with the measured motion, or is too long */
            for (int j = 0; j < n_joints; j++) {
                int k = joints[j], at = i * n_points * n_joints + j;
                Course course = {now[i],   n_points, &times[i * n_points], &positions[at],
                                 velocities == NULL ? NULL : &velocities[at], n_joints};
                double q, qd;
                if (!desired(law, k, now[i], &q, &qd))
                    return UNKNOWN;
                int result = segments(&course, law->wraps[k], q, qd, c);
                if (result != STARTED)
                    return result;
                if (is_checked)
                    set_pieces(law, k, &course, c);
            }
            if (!is_checked)
                continue;
            law->next_change = -INFINITY;
            law->is_monitored = 0;
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
