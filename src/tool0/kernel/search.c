/* RRT-Connect (Kuffner and LaValle, ICRA 2000) between a pose and several goals, with
   balanced trees and dynamic domains (Yershova et al., ICRA 2005), and shortcuts.  The
   same seed gives the same path. */

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "clearance.h"
#include "export.h"

#define NARROW 0.7        /* fraction of the samples near the start and a goal */
/* distance beyond which samples do not extend nodes that could not be extended [rad] */
#define FAR 4.0
/* length of an extension along which the tool stays upright [rad] */
#define UPRIGHT_RANGE 0.15

/* largest ratio of lengths at which a part of the way is replaced */
#define SHORTER 0.995

enum { FOUND = 0, NO_WAY = 1, TIMEOUT = 2, CANCELLED = 3, NO_MEMORY = 4 };

typedef struct {
    const double *start;  /* (n_joints) */
    const double *goals;  /* (n_goals, n_joints) */
    int32_t n_goals;
    int32_t most_nodes;   /* largest number of nodes of each tree */
    const double *lower, *upper; /* (n_joints), bounds of the samples */
    /* largest distance of most samples from the range between the start and a goal */
    double beside;
    double range;         /* longest extension [rad] */
    double deadline;      /* time of CLOCK_MONOTONIC [s] */
    uint64_t seed;
    volatile int32_t *cancelled;
    int64_t samples;      /* out: number of samples */
} Search;

typedef struct {
    double *q;
    int32_t *parent;
    double *radius; /* squared radius of the samples to which a node is extended */
    int32_t n, n_joints;
} Tree;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* splitmix64 */
static double uniform(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static double apart(const double *a, const double *b, int32_t n)
{
    double sum = 0.0;
    for (int32_t j = 0; j < n; j++)
        sum += (a[j] - b[j]) * (a[j] - b[j]);
    return sum;
}

static int32_t nearest(const Tree *tree, const double *q)
{
    int32_t best = 0;
    double least = INFINITY;
    for (int32_t k = 0; k < tree->n; k++) {
        const double distance = apart(tree->q + k * tree->n_joints, q, tree->n_joints);
        if (distance < least) {
            least = distance;
            best = k;
        }
    }
    return best;
}

static int32_t add(Tree *tree, const double *q, int32_t parent)
{
    memcpy(tree->q + tree->n * tree->n_joints, q, sizeof(double) * tree->n_joints);
    tree->parent[tree->n] = parent;
    tree->radius[tree->n] = INFINITY;
    return tree->n++;
}

/* Extend a tree from a node towards a target; return the new node, or -1.  `reached` is
   set to whether the new node is the target. */
static int32_t extend(
    Clearances *c, Tree *tree, int32_t from, const double *target, double range,
    int *reached)
{
    const int32_t n = tree->n_joints;
    const double *here = tree->q + from * n;
    const double way = sqrt(apart(here, target, n));
    double q[MOST_MOVING];
    *reached = way <= range;
    const double part = *reached ? 1.0 : range / way;
    for (int32_t j = 0; j < n; j++)
        q[j] = *reached ? target[j] : here[j] + part * (target[j] - here[j]);
    if (c->tool >= 0 && !*reached) {
        if (!clearances_upright(c, q))
            return -1;
        const double moved = apart(here, q, n);
        /* The projection may move the pose back or aside. */
        if (moved < 1e-4 * range * range || moved > 4.0 * range * range)
            return -1;
        if (apart(q, target, n) >= way * way)
            return -1;
    }
    if (!clearances_are_kept(c, q) || !clearances_connect(c, here, q))
        return -1;
    return add(tree, q, from);
}

/* Write the way from the root of a tree to a node; return the number of poses. */
static int32_t way_to(const Tree *tree, int32_t node, double *way)
{
    int32_t n = 0;
    for (int32_t k = node; k >= 0; k = tree->parent[k])
        n++;
    int32_t row = n;
    for (int32_t k = node; k >= 0; k = tree->parent[k])
        memcpy(
            way + --row * tree->n_joints, tree->q + k * tree->n_joints,
            sizeof(double) * tree->n_joints);
    return n;
}

/* Write the poses of a way from the start to one of the goals to `way`, which has space
   for `most_nodes` poses, and the number of poses to `n_way`. */
TOOL0_EXPORT int32_t tool0_search(
    Clearances *c, Search *s, double *way, int32_t *n_way)
{
    const int32_t n = c->n_joints, most = s->most_nodes;
    const double range = c->tool >= 0 ? fmin(s->range, UPRIGHT_RANGE) : s->range;
    Tree trees[2];
    int32_t result = NO_WAY;
    for (int k = 0; k < 2; k++) {
        trees[k] = (Tree){
            malloc(sizeof(double) * (size_t)(most * n)),
            malloc(sizeof(int32_t) * (size_t)most),
            malloc(sizeof(double) * (size_t)most), 0, n};
        if (!trees[k].q || !trees[k].parent || !trees[k].radius)
            result = NO_MEMORY;
    }
    if (result == NO_MEMORY)
        goto end;
    add(&trees[0], s->start, -1);
    for (int32_t k = 0; k < s->n_goals; k++)
        add(&trees[1], s->goals + k * n, -1);
    uint64_t state = s->seed;
    for (int turn = 0;; turn = trees[0].n > trees[1].n) {
        if (*s->cancelled || now() > s->deadline) {
            result = *s->cancelled ? CANCELLED : TIMEOUT;
            break;
        }
        if (trees[0].n >= most - 1 || trees[1].n >= most - 1)
            break;
        double sample[MOST_MOVING];
        const double *goal =
            s->goals + (int32_t)(uniform(&state) * s->n_goals) * n;
        const int near = uniform(&state) < NARROW;
        for (int32_t j = 0; j < n; j++) {
            double lower = s->lower[j], upper = s->upper[j];
            if (near) {
                lower = fmax(lower, fmin(s->start[j], goal[j]) - s->beside);
                upper = fmin(upper, fmax(s->start[j], goal[j]) + s->beside);
            }
            sample[j] = lower + uniform(&state) * (upper - lower);
        }
        s->samples++;
        /* The smaller tree is extended towards the sample. */
        Tree *here = &trees[turn], *there = &trees[!turn];
        int reached;
        const int32_t from = nearest(here, sample);
        if (apart(here->q + from * n, sample, n) > here->radius[from])
            continue;
        const int32_t grown = extend(c, here, from, sample, range, &reached);
        if (grown < 0) {
            here->radius[from] = FAR * FAR;
            continue;
        }
        const double *target = here->q + grown * n;
        int32_t node = nearest(there, target);
        do {
            node = there->n >= most - 1
                ? -1
                : extend(c, there, node, target, range, &reached);
        } while (node >= 0 && !reached);
        if (node < 0)
            continue;
        /* Both trees contain this pose, and the way contains it once. */
        const int32_t from_start = turn ? node : grown, from_goal = turn ? grown : node;
        int32_t rows = way_to(&trees[0], from_start, way);
        for (int32_t k = trees[1].parent[from_goal]; k >= 0; k = trees[1].parent[k])
            memcpy(way + rows++ * n, trees[1].q + k * n, sizeof(double) * n);
        *n_way = rows;
        result = FOUND;
        break;
    }
end:
    for (int k = 0; k < 2; k++) {
        free(trees[k].q);
        free(trees[k].parent);
        free(trees[k].radius);
    }
    return result;
}

/* Conditions for the end of a search. */
typedef struct {
    double deadline;
    volatile int32_t *cancelled;
} Until;

static int is_over(const Until *until)
{
    return *until->cancelled || now() > until->deadline;
}

/* Return the location at which a way has a length, as the number of the pose before the
   location plus the fraction of the way to the next pose.  `y` is set to the location
   of a larger length. */
static double place_at(
    const double *way, int32_t n_way, int32_t n, double length, double *y, double larger)
{
    double x = n_way - 1, done = 0.0;
    *y = n_way - 1;
    for (int32_t m = 0; m + 1 < n_way; m++) {
        const double part = sqrt(apart(way + m * n, way + (m + 1) * n, n));
        if (x == n_way - 1 && length < done + part)
            x = m + (length - done) / part;
        if (larger < done + part) {
            *y = m + (larger - done) / part;
            break;
        }
        done += part;
    }
    return x;
}

/* Remove poses of a way between which the straight way is free, starting with the
   farthest pose; return the number of remaining poses. */
static int32_t prune(Clearances *c, double *way, int32_t n_way, Until *until)
{
    const int32_t n = c->n_joints;
    for (int32_t i = 0; i + 2 < n_way; i++)
        for (int32_t k = n_way - 1; k > i + 1; k--) {
            if (is_over(until))
                return n_way;
            if (!clearances_connect(c, way + i * n, way + k * n))
                continue;
            memmove(
                way + (i + 1) * n, way + k * n,
                sizeof(double) * (size_t)((n_way - k) * n));
            n_way -= k - i - 1;
            break;
        }
    return n_way;
}

/* Replace parts of a way through `n_way` poses by straight parts: first from pose to
   pose, then `tries` random parts.  Return the number of poses.  `most` is the number
   of poses for which `way` has space. */
TOOL0_EXPORT int32_t tool0_shorten(
    Clearances *c, double *way, int32_t n_way, int32_t most, int32_t tries,
    uint64_t seed, double deadline, volatile int32_t *cancelled)
{
    const int32_t n = c->n_joints;
    uint64_t state = seed;
    Until until = {deadline, cancelled};
    double a[MOST_MOVING], b[MOST_MOVING];
    n_way = prune(c, way, n_way, &until);
    for (int32_t k = 0; k < tries && n_way > 2 && !is_over(&until); k++) {
        /* Two locations on the way, with a uniform distribution over its length. */
        double x = uniform(&state), y = uniform(&state), all = 0.0;
        for (int32_t m = 0; m + 1 < n_way; m++)
            all += sqrt(apart(way + m * n, way + (m + 1) * n, n));
        x = place_at(way, n_way, n, fmin(x, y) * all, &y, fmax(x, y) * all);
        const int32_t i = (int32_t)fmin(floor(x), n_way - 2);
        const int32_t r = (int32_t)fmin(floor(y), n_way - 2);
        if (i == r)
            continue;
        double *p = way + i * n, *o = way + r * n;
        for (int32_t j = 0; j < n; j++) {
            a[j] = p[j] + (x - i) * (p[n + j] - p[j]);
            b[j] = o[j] + (y - r) * (o[n + j] - o[j]);
        }
        double before = sqrt(apart(a, p + n, n)) + sqrt(apart(o, b, n));
        for (int32_t m = i + 1; m < r; m++)
            before += sqrt(apart(way + m * n, way + (m + 1) * n, n));
        /* poses 0 … i, a, b, r + 1 … */
        const int keep_a = x - i > 1e-9, keep_b = r + 1 - y > 1e-9;
        const int32_t head = i + 1 + keep_a, tail = n_way - (r + 1);
        if (head + keep_b + tail > most || sqrt(apart(a, b, n)) > SHORTER * before
            || !clearances_connect(c, a, b))
            continue;
        memmove(
            way + (head + keep_b) * n, way + (r + 1) * n, sizeof(double) * (size_t)(tail * n));
        if (keep_a)
            memcpy(way + (i + 1) * n, a, sizeof(double) * n);
        if (keep_b)
            memcpy(way + head * n, b, sizeof(double) * n);
        n_way = head + keep_b + tail;
    }
    return n_way;
}
