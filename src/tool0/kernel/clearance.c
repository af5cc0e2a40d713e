/* Checks whether shapes stay apart, by conservative advancement.  From a pose with
   known distances, a motion is free as long as no point can approach by this distance
   (Mirtich, PhD thesis, UC Berkeley 1996). */

#include "clearance.h"

#include <math.h>
#include <stddef.h>

#include "export.h"

/* largest number of steps of the projection onto the tool's tilt */
#define UPRIGHT_STEPS 20
/* margin of the tilt in projected poses, since the tilt is larger between two poses
   [rad] */
#define UPRIGHT_MARGIN 5e-3
/* motion of the leading joint between the poses that are checked first [rad] */
#define PROBE 0.1
/* step of the leading joint below which the exact distance is computed [rad] */
#define CLOSELY 0.1
/* motion of the leading joint between two checks of the tilt [rad] */
#define TILT_STEP 0.02

static double square(double x)
{
    return x * x;
}

static void put(Clearances *c, const double *q)
{
    for (int32_t j = 0; j < c->n_joints; j++)
        c->position[c->addresses[j]] = q[j];
    c->kinematics(c->model, c->data);
    c->poses++;
}

/* Return a fast lower bound of the distance of a pair.  The first shape is bounded by a
   sphere and the second shape by a box.  If the distance is larger than `most`, the
   second shape is bounded by a sphere, too. */
static double bound(const Clearances *c, int32_t pair, double most)
{
    const int32_t first = c->first[pair], second = c->second[pair];
    const double *p = c->centres + 3 * first, *o = c->centres + 3 * second;
    const double *R = c->rotations + 9 * second, *box = c->boxes + 6 * second;
    const double d[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]};
    const double radius = c->radii[first];
    if (c->radii[second] == 0.0) /* a plane */
        return d[0] * R[2] + d[1] * R[5] + d[2] * R[8] - radius;
    const double both = radius + c->radii[second];
    const double apart = square(d[0]) + square(d[1]) + square(d[2]);
    if (apart > square(both + most))
        return sqrt(apart) - both;
    double outside = 0.0;
    for (int k = 0; k < 3; k++) {
        const double x = d[0] * R[k] + d[1] * R[3 + k] + d[2] * R[6 + k] - box[k];
        const double beyond = fabs(x) - box[3 + k];
        if (beyond > 0.0)
            outside += beyond * beyond;
    }
    return sqrt(outside) - radius;
}

/* Return a better lower bound: the largest gap between the boxes of both shapes along
   the axes of their faces and of pairs of their edges (Gottschalk et al., SIGGRAPH
   1996).  `n` is set to the axis of the largest gap, which points from the first shape
   to the second shape. */
static double gap(const Clearances *c, int32_t pair, double *n)
{
    const int32_t first = c->first[pair], second = c->second[pair];
    const double *A = c->rotations + 9 * first, *B = c->rotations + 9 * second;
    const double *a = c->boxes + 6 * first, *b = c->boxes + 6 * second;
    if (c->radii[second] == 0.0) { /* a plane */
        double reach = 0.0, centre = 0.0;
        const double *p = c->centres + 3 * first, *o = c->centres + 3 * second;
        for (int k = 0; k < 3; k++) {
            const double along = A[k] * B[2] + A[3 + k] * B[5] + A[6 + k] * B[8];
            centre += along * a[k] + (p[k] - o[k]) * B[3 * k + 2];
            reach += fabs(along) * a[3 + k];
            n[k] = -B[3 * k + 2];
        }
        return centre - reach;
    }
    double R[3][3], Q[3][3], d[3], t[3], best = -INFINITY, sign = 1.0;
    /* the best axis: of the first box, of the second box, or of an edge pair */
    int one = -1, two = -1;
    for (int k = 0; k < 3; k++) {
        d[k] = c->centres[3 * second + k] - c->centres[3 * first + k];
        for (int m = 0; m < 3; m++)
            d[k] += B[3 * k + m] * b[m] - A[3 * k + m] * a[m];
    }
    for (int k = 0; k < 3; k++) {
        t[k] = A[k] * d[0] + A[3 + k] * d[1] + A[6 + k] * d[2];
        for (int m = 0; m < 3; m++) {
            R[k][m] = A[k] * B[m] + A[3 + k] * B[3 + m] + A[6 + k] * B[6 + m];
            Q[k][m] = fabs(R[k][m]);
        }
    }
    const double *ha = a + 3, *hb = b + 3;
    for (int k = 0; k < 3; k++) {
        const double far = ha[k] + Q[k][0] * hb[0] + Q[k][1] * hb[1] + Q[k][2] * hb[2];
        if (fabs(t[k]) - far > best) {
            best = fabs(t[k]) - far;
            one = k;
            sign = t[k];
        }
    }
    for (int m = 0; m < 3; m++) {
        const double along = t[0] * R[0][m] + t[1] * R[1][m] + t[2] * R[2][m];
        const double far = hb[m] + Q[0][m] * ha[0] + Q[1][m] * ha[1] + Q[2][m] * ha[2];
        if (fabs(along) - far > best) {
            best = fabs(along) - far;
            one = -1;
            two = m;
            sign = along;
        }
    }
    for (int k = 0; k < 3; k++) {
        const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        for (int m = 0; m < 3; m++) {
            const int m1 = (m + 1) % 3, m2 = (m + 2) % 3;
            const double square_length = 1.0 - R[k][m] * R[k][m];
            if (square_length < 1e-3)
                continue;
            const double far = ha[k1] * Q[k2][m] + ha[k2] * Q[k1][m]
                + hb[m1] * Q[k][m2] + hb[m2] * Q[k][m1];
            const double along = t[k2] * R[k1][m] - t[k1] * R[k2][m];
            const double size = sqrt(square_length);
            if (fabs(along) - far > best * size) {
                best = (fabs(along) - far) / size;
                one = k;
                two = m;
                sign = along;
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        if (two < 0)
            n[k] = A[3 * k + one];
        else if (one < 0)
            n[k] = B[3 * k + two];
    }
    if (one >= 0 && two >= 0) {
        double size = 0.0;
        for (int k = 0; k < 3; k++) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            n[k] = A[3 * k1 + one] * B[3 * k2 + two] - A[3 * k2 + one] * B[3 * k1 + two];
            size += square(n[k]);
        }
        for (int k = 0; k < 3; k++)
            n[k] /= sqrt(size);
    }
    if (sign < 0.0)
        for (int k = 0; k < 3; k++)
            n[k] = -n[k];
    return best;
}

static double exact(Clearances *c, int32_t pair, double most, double *ends)
{
    c->calls++;
    return c->distance(
        c->model, c->data, c->first[pair], c->second[pair], fmax(most, 1e-6), ends);
}

/* Return whether the boxes of a pair can be closer than `than`. */
static int is_suspicious(const Clearances *c, int32_t pair, double than)
{
    double n[3];
    return bound(c, pair, than) < than && gap(c, pair, n) < than;
}

/* Return the largest speed along `n` of a shape that is moved by the joints in `mask`
   [m per way]. */
static double speed_along(
    const Clearances *c, int32_t shape, uint32_t mask, const double *way, const double *n)
{
    const double *p = c->centres + 3 * shape, *R = c->rotations + 9 * shape;
    const double *box = c->boxes + 6 * shape;
    double speed = 0.0, w[3] = {0.0, 0.0, 0.0};
    for (int32_t j = 0; j < c->n_joints; j++) {
        if (!(mask >> j & 1u))
            continue;
        const double *a = c->axes + 3 * c->axis_rows[j];
        if (c->sliding >> j & 1u) {
            speed += way[j] * (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]);
            continue;
        }
        const double *o = c->anchors + 3 * c->axis_rows[j];
        const double r[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]};
        speed += way[j]
            * (n[0] * (a[1] * r[2] - a[2] * r[1]) + n[1] * (a[2] * r[0] - a[0] * r[2])
               + n[2] * (a[0] * r[1] - a[1] * r[0]));
        for (int k = 0; k < 3; k++)
            w[k] += way[j] * a[k];
    }
    const double u[3] = {
        n[1] * w[2] - n[2] * w[1],
        n[2] * w[0] - n[0] * w[2],
        n[0] * w[1] - n[1] * w[0],
    };
    for (int k = 0; k < 3; k++) {
        const double along = u[0] * R[k] + u[1] * R[3 + k] + u[2] * R[6 + k];
        speed += along * box[k] + fabs(along) * box[3 + k];
    }
    return speed;
}

/* Return the largest relative acceleration of the points of a pair [m per way²].  It is
   twice the product of each joint's motion and the motions of the joints before it. */
static double bend(const Clearances *c, int32_t pair, const double *way)
{
    const uint32_t one = c->moved_by[c->first[pair]], two = c->moved_by[c->second[pair]];
    const double *reach = c->reach + pair * c->n_joints;
    const uint32_t sides[2] = {one & ~two, two & ~one};
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        double before = 0.0;
        for (int32_t j = 0; j < c->n_joints; j++) {
            if (!(sides[side] >> j & 1u))
                continue;
            const double own = fabs(way[j]);
            const int slides = c->sliding >> j & 1u;
            sum += reach[j] * own * (2.0 * before + (slides ? 0.0 : own));
            before += slides ? 0.0 : own;
        }
    }
    return sum;
}

/* Return the fraction of the way for which a pair can approach by at most `room` [m]
   along `n`, a unit vector from the first shape to the second shape. */
static double free_for(
    const Clearances *c, int32_t pair, double room, const double *n, const double *way)
{
    const double crude = room / c->rates[pair];
    const uint32_t one = c->moved_by[c->first[pair]], two = c->moved_by[c->second[pair]];
    const double back[3] = {-n[0], -n[1], -n[2]};
    const double speed = speed_along(c, c->first[pair], one & ~two, way, n)
        + speed_along(c, c->second[pair], two & ~one, way, back);
    /* speed t + bend t² / 2 = room */
    const double a = 0.5 * bend(c, pair, way);
    const double root = sqrt(speed * speed + 4.0 * a * room);
    const double t = speed + root > 0.0 ? 2.0 * room / (speed + root) : INFINITY;
    return fmax(crude, t);
}

/* Return the cosine of the angle between the tool's axis and `up`; `axis` is set to the
   tool's axis in the world. */
static double uprightness(const Clearances *c, double *axis)
{
    const double *R = c->bodies + 9 * c->tool, *a = c->tool_axis;
    double cosine = 0.0;
    for (int k = 0; k < 3; k++) {
        axis[k] = R[3 * k] * a[0] + R[3 * k + 1] * a[1] + R[3 * k + 2] * a[2];
        cosine += axis[k] * c->up[k];
    }
    return fmin(fmax(cosine, -1.0), 1.0);
}

static int is_tilted(const Clearances *c)
{
    double axis[3];
    return c->tool >= 0 && acos(uprightness(c, axis)) > c->tilt;
}

static int is_too_near(Clearances *c, int32_t pair)
{
    const double least = c->least[pair];
    return is_suspicious(c, pair, least) && exact(c, pair, least + 1e-9, NULL) < least;
}

/* Return FREE, TILTED, or a pair that is too close in a pose. */
int32_t clearances_at(Clearances *c, const double *q)
{
    put(c, q);
    if (is_tilted(c))
        return TILTED;
    for (int32_t pair = 0; pair < c->n_pairs; pair++)
        if (is_too_near(c, pair))
            return pair;
    return FREE;
}

/* Return whether a pose is free.  The pair that was too close in the last violation is
   checked first. */
static int is_free(Clearances *c, const double *q)
{
    put(c, q);
    if (is_tilted(c))
        return 0;
    if (c->suspect < c->n_pairs && is_too_near(c, c->suspect))
        return 0;
    for (int32_t pair = 0; pair < c->n_pairs; pair++)
        if (is_too_near(c, pair)) {
            c->suspect = pair;
            return 0;
        }
    return 1;
}

/* Move an element down in the heap of the pairs that must be checked again.  The pair
   with the smallest fraction of the way is the first element. */
static void sink(Clearances *c, int32_t n, int32_t at)
{
    const int32_t pair = c->heap[at];
    const double until = c->until[pair];
    for (int32_t child = 2 * at + 1; child < n; child = 2 * at + 1) {
        if (child + 1 < n && c->until[c->heap[child + 1]] < c->until[c->heap[child]])
            child++;
        if (until <= c->until[c->heap[child]])
            break;
        c->heap[at] = c->heap[child];
        at = child;
    }
    c->heap[at] = pair;
}

/* Check a pair at the fraction `t` of the way, with higher accuracy in each call.  Set
   the fraction up to which the pair is free.  Return whether the pair is too close. */
static int look(Clearances *c, int32_t pair, const double *way, double t)
{
    const double least = c->least[pair], rate = c->rates[pair], slack = c->slack;
    double ends[6], n[3], size = 0.0, free;
    switch (c->looks[pair]++) {
    case 0:
        free = (bound(c, pair, least + rate * (1.0 - t)) - least) / rate;
        break;
    case 1:
        free = gap(c, pair, n) - least;
        if (free > 0.0)
            free = free_for(c, pair, free + slack, n, way);
        break;
    default: {
        const double most = least + rate * (1.0 - t) + 1e-9;
        const double distance = exact(c, pair, most, ends);
        if (distance < least)
            return 1;
        if (distance >= most - 1e-9) {
            c->until[pair] = INFINITY;
            return 0;
        }
        for (int k = 0; k < 3; k++) {
            n[k] = (ends[3 + k] - ends[k]) / fmax(distance, 1e-12);
            size += square(n[k]);
        }
        /* Between two checks, the pair may approach by the slack. */
        free = distance - least + slack;
        /* otherwise, the engine does not return the closest points */
        if (fabs(size - 1.0) < 1e-3)
            free = free_for(c, pair, free, n, way);
        else
            free /= rate;
    }
    }
    if (free > 0.0)
        c->until[pair] = fmax(c->until[pair], t + free);
    return 0;
}

/* Return FREE if all poses on the straight way between two poses keep their distances,
   including the slack.  Otherwise, return the violation, and set `at` to the fraction
   of the way at which it occurs. */
int32_t clearances_between(Clearances *c, const double *from, const double *to, double *at)
{
    double q[MOST_MOVING], way[MOST_MOVING], leading = 0.0, t = 0.0;
    int32_t n = 0;
    for (int32_t j = 0; j < c->n_joints; j++) {
        way[j] = to[j] - from[j];
        leading = fmax(leading, fabs(way[j]));
    }
    const double most = c->tool >= 0 && leading > 0.0 ? TILT_STEP / leading : 1.0;
    const double closely = leading > 0.0 ? CLOSELY / leading : 1.0;
    *at = 0.0;
    put(c, from);
    if (is_tilted(c))
        return TILTED;
    for (int32_t pair = 0; pair < c->n_pairs; pair++) {
        double rate = 0.0;
        for (int32_t j = 0; j < c->n_joints; j++)
            rate += c->reach[pair * c->n_joints + j] * fabs(way[j]);
        c->rates[pair] = rate;
        const double least = c->least[pair], room = bound(c, pair, least + rate) - least;
        if (room > rate)
            continue; /* free on the whole way */
        c->until[pair] = room > 0.0 ? room / rate : 0.0;
        c->looks[pair] = 1;
        c->heap[n++] = pair;
    }
    for (int32_t k = n / 2 - 1; k >= 0; k--)
        sink(c, n, k);
    for (;;) {
        /* The pair that limits the step is checked with increasing accuracy, until it
           does not limit the step or its highest accuracy is reached. */
        double step = 1.0;
        while (n > 0) {
            const int32_t pair = c->heap[0];
            const int looks = c->looks[pair];
            step = c->until[pair] - t;
            if (looks > 2 || (looks == 2 && step > closely))
                break;
            if (look(c, pair, way, t)) {
                *at = t;
                return pair;
            }
            if (c->until[pair] > 1.0) {
                c->heap[0] = c->heap[--n];
                if (n == 0)
                    break;
            }
            sink(c, n, 0);
        }
        if (n == 0 && c->tool < 0)
            return FREE;
        if (t >= 1.0)
            return FREE;
        t = fmin(n > 0 ? fmin(c->until[c->heap[0]], t + most) : t + most, 1.0);
        for (int32_t j = 0; j < c->n_joints; j++)
            q[j] = from[j] + t * way[j];
        put(c, q);
        *at = t;
        if (is_tilted(c))
            return TILTED;
        for (int32_t k = 0; k < n; k++)
            c->looks[c->heap[k]] = 0;
    }
}

/* Return whether the straight way between two poses is free.  Some poses are checked
   first, starting with the middle, followed by the quarters.  Most violations are found
   in these poses. */
int clearances_connect(Clearances *c, const double *from, const double *to)
{
    double q[MOST_MOVING], leading = 0.0, at;
    for (int32_t j = 0; j < c->n_joints; j++)
        leading = fmax(leading, fabs(to[j] - from[j]));
    for (int32_t parts = 2; leading / parts > PROBE; parts *= 2)
        for (int32_t k = 1; k < parts; k += 2) {
            const double part = (double)k / parts;
            for (int32_t j = 0; j < c->n_joints; j++)
                q[j] = from[j] + part * (to[j] - from[j]);
            if (!is_free(c, q))
                return 0;
        }
    return clearances_between(c, from, to, &at) == FREE;
}

int clearances_are_kept(Clearances *c, const double *q)
{
    return is_free(c, q);
}

/* Rotate the tool by changing `q` until it is upright; return whether it is upright. */
int32_t clearances_upright(Clearances *c, double *q)
{
    for (int k = 0; c->tool >= 0; k++) {
        double axis[3], slope[MOST_MOVING], sum = 0.0;
        put(c, q);
        const double angle = acos(uprightness(c, axis));
        const double excess = angle - (c->tilt - fmin(UPRIGHT_MARGIN, 0.5 * c->tilt));
        if (excess <= 0.0)
            return 1;
        if (k == UPRIGHT_STEPS)
            return 0;
        const double *u = c->up;
        const double n[3] = {
            axis[1] * u[2] - axis[2] * u[1],
            axis[2] * u[0] - axis[0] * u[2],
            axis[0] * u[1] - axis[1] * u[0],
        };
        const double sine = fmax(sqrt(square(n[0]) + square(n[1]) + square(n[2])), 1e-9);
        for (int32_t j = 0; j < c->n_joints; j++) {
            slope[j] = 0.0;
            if (c->tilting >> j & 1u) {
                const double *w = c->axes + 3 * c->axis_rows[j];
                slope[j] = (w[0] * n[0] + w[1] * n[1] + w[2] * n[2]) / sine;
            }
            sum += square(slope[j]);
        }
        if (sum < 1e-9)
            return 0;
        for (int32_t j = 0; j < c->n_joints; j++)
            q[j] += 1.05 * excess * slope[j] / sum;
    }
    return 1;
}

/* Return the result of `clearances_at` for a pose. */
TOOL0_EXPORT int32_t tool0_clearances_at(Clearances *c, const double *q)
{
    return clearances_at(c, q);
}

/* Write the distance of each pair in a pose, limited to `most`. */
TOOL0_EXPORT void tool0_clearances_all(
    Clearances *c, const double *q, double most, double *distances)
{
    put(c, q);
    for (int32_t pair = 0; pair < c->n_pairs; pair++)
        distances[pair] = is_suspicious(c, pair, most) ? exact(c, pair, most, NULL) : most;
}

/* Check a way through `n` poses, and return the result of `clearances_between`.  `row`
   is set to the index of the pose before the violation, and `at` to the fraction of the
   way from this pose to the next pose. */
TOOL0_EXPORT int32_t tool0_clearances_along(
    Clearances *c, const double *poses, int32_t n, int32_t *row, double *at)
{
    for (*row = 0; *row < n - 1; ++*row) {
        const double *from = poses + *row * c->n_joints;
        const int32_t found = clearances_between(c, from, from + c->n_joints, at);
        if (found != FREE)
            return found;
    }
    *at = 0.0;
    return n > 0 ? clearances_at(c, poses + (n - 1) * c->n_joints) : FREE;
}
