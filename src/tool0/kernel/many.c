/* Execution of the ticks of many copies of a robot in threads. */

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
    int n;
    const int32_t *most;
    int64_t *left, *ticks, *untold;
    int32_t *results;
    int next; /* the copy that the next free thread processes */
} Work;

/* A pool of threads that wait for work.  Creating threads would take longer than many
   calls, and on a busy machine a new thread is the last thread in the queue. */
typedef struct {
    pthread_mutex_t lock;
    pthread_cond_t changed; /* signaled if there is work, or if the pool is closed */
    pthread_cond_t finished; /* signaled if no thread is busy */
    Work work;
    int has_work, n_busy, n_threads, is_closed;
    pid_t process; /* the process that has the threads */
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
        int done = 0, most = left < work->most[i] ? (int)left : work->most[i];
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
        pool->has_work = 0; /* all copies are being processed */
        if (!--pool->n_busy)
            pthread_cond_signal(&pool->finished);
    }
    int is_last = !--pool->n_threads;
    pthread_mutex_unlock(&pool->lock);
    if (is_last)
        free_pool(pool);
    return NULL;
}

/* Return a pool of `threads` threads, including the caller's thread, or NULL if there
   is no memory. */
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
        pool->n_threads++; /* with fewer threads, a run takes longer */
    }
    pthread_mutex_unlock(&pool->lock);
    return pool;
}

/* A fork copies a pool without its threads.  The lock and the conditions are copied in
   their states at the fork: they can be held, or have waiters that do not exist.
   Therefore the copy must not wait for them. */
static int is_copy(const Pool *pool)
{
    return pool->process != getpid();
}

/* End the threads; the last thread frees the pool. */
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

/* Execute the work of a batch in the threads of a pool.

   The function does not wait for threads that wake up after the last copy was taken.
   In a process that was forked after the pool was opened, the caller does all the work. */
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

/* Execute the ticks that are left of each robot, up to most[i], as tool0_run does.
   Robots that are NULL are left out.  The numbers of executed ticks are subtracted from
   `left`, and added to `ticks` and `untold`.  Returns whether an event ended a run, or
   whether ticks are left. */
TOOL0_EXPORT int tool0_run_many(void *pool, Robot *const *robots, int n,
                                const int32_t *most, int64_t *left, int64_t *ticks,
                                int64_t *untold, int32_t *results)
{
    Work work = {robots, n, most, left, ticks, untold, results, 0};
    run(pool, &work);
    for (int i = 0; i < n; i++)
        if (robots[i] && (results[i] != RUN_DONE || left[i] > 0))
            return 1;
    return 0;
}

/* Copy positions, velocities and efforts of the joints to an array of shape (3, n,
   n_joints), for the robots for which is_read is true. */
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
