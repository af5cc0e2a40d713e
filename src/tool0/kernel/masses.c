/* Mass matrices of many robots: JointDynamics.mass_matrix of description/bodies.py. */

#include <string.h>

#include "export.h"
#include "robot.h"

/* Compute mass, first moment and inertia (xx xy xz yy yz zz) about the root. */
static void about_root(const double *f, const DriveBody *body, double *carried)
{
    const double *c = body->center, *t = body->tensor;
    double mass = body->mass, p[3], turned[3][3];
    for (int r = 0; r < 3; r++) {
        double a = f[r], b = f[3 + r], d = f[6 + r];
        p[r] = a * c[0] + b * c[1] + d * c[2] + f[9 + r];
        for (int k = 0; k < 3; k++)
            turned[r][k] = a * t[k] + b * t[3 + k] + d * t[6 + k];
    }
    double inertia[3][3], x = p[0], y = p[1], z = p[2];
    for (int r = 0; r < 3; r++)
        for (int k = r; k < 3; k++)
            inertia[r][k] = turned[r][0] * f[k] + turned[r][1] * f[3 + k]
                            + turned[r][2] * f[6 + k];
    carried[0] = mass;
    carried[1] = mass * x;
    carried[2] = mass * y;
    carried[3] = mass * z;
    carried[4] = inertia[0][0] + mass * (y * y + z * z);
    carried[5] = inertia[0][1] - mass * (x * y);
    carried[6] = inertia[0][2] - mass * (x * z);
    carried[7] = inertia[1][1] + mass * (x * x + z * z);
    carried[8] = inertia[1][2] - mass * (y * z);
    carried[9] = inertia[2][2] + mass * (x * x + y * y);
}

static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Compute linear and angular momentum about the root at unit joint velocity. */
static void momentum_of(const DriveBody *body, const double *f, const double *carried,
                        double *momentum)
{
    double m = carried[0];
    const double *h = &carried[1], *I = &carried[4], *axis = &f[6], *origin = &f[9];
    if (body->is_prismatic) {
        for (int k = 0; k < 3; k++)
            momentum[k] = m * axis[k];
        cross(h, axis, &momentum[3]);
        return;
    }
    double v[3], turning[3], moved[3], x = axis[0], y = axis[1], z = axis[2];
    cross(origin, axis, v);
    cross(axis, h, turning);
    cross(h, v, moved);
    for (int k = 0; k < 3; k++)
        momentum[k] = m * v[k] + turning[k];
    momentum[3] = moved[0] + (I[0] * x + I[1] * y + I[2] * z);
    momentum[4] = moved[1] + (I[1] * x + I[3] * y + I[4] * z);
    momentum[5] = moved[2] + (I[2] * x + I[4] * y + I[5] * z);
}

/* Return the component of a momentum along a joint's axis. */
static double along(const DriveBody *body, const double *f, const double *momentum)
{
    const double *axis = &f[6], *p = momentum, *l = &momentum[3];
    if (body->is_prismatic)
        return axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    double v[3];
    cross(&f[9], axis, v);
    return (v[0] * p[0] + v[1] * p[1] + v[2] * p[2])
           + (axis[0] * l[0] + axis[1] * l[1] + axis[2] * l[2]);
}

static void mass_matrix(const DriveTable *table, const double *position, double *matrix)
{
    int n = table->n_bodies;
    const DriveBody *bodies = table->bodies;
    double frames[n][12], carried[n][10];
    drives_frames(bodies, n, position, frames);
    memset(matrix, 0, (size_t)n * n * sizeof(double));
    for (int i = 0; i < n; i++) {
        about_root(frames[i], &bodies[i], carried[i]);
        matrix[i * n + i] = bodies[i].armature;
    }
    for (int i = n - 1; i >= 0; i--) {
        const DriveBody *body = &bodies[i];
        double momentum[6];
        momentum_of(body, frames[i], carried[i], momentum);
        for (int j = i; j >= 0; j = bodies[j].parent) {
            const DriveBody *other = &bodies[j];
            double value = along(other, frames[j], momentum);
            value = body->multiplier * other->multiplier * value;
            matrix[body->master * n + other->master] += value;
            if (j != i)
                matrix[other->master * n + body->master] += value;
        }
        if (body->parent >= 0)
            for (int k = 0; k < 10; k++)
                carried[body->parent][k] += carried[i][k];
    }
}

/* Compute the mass matrices of n robots, shape (n, n_bodies, n_bodies), and copy the
   positions of their bodies' joints, shape (n, n_bodies). */
TOOL0_EXPORT void tool0_masses_many(Robot *const *robots, int n, double *matrices,
                                    double *positions)
{
    for (int i = 0; i < n; i++) {
        const DriveTable *table = robots[i]->drives->table;
        int n_bodies = table->n_bodies;
        mass_matrix(table, robots[i]->position, &matrices[i * n_bodies * n_bodies]);
        for (int k = 0; k < n_bodies; k++)
            positions[i * n_bodies + k] = robots[i]->position[table->bodies[k].joint];
    }
}

/* Set the masses, shape (n, n_servos, n_servos), and the largest accelerations, shape
   (n, n_servos), of the servos of n robots for the next step. */
TOOL0_EXPORT void tool0_set_masses_many(Robot *const *robots, int n, const double *masses,
                                        const double *fastest)
{
    for (int i = 0; i < n; i++) {
        Drives *drives = robots[i]->drives;
        int n_servos = drives->n_servos;
        memcpy(drives->masses, &masses[i * n_servos * n_servos],
               (size_t)n_servos * n_servos * sizeof(double));
        for (int k = 0; k < n_servos; k++)
            drives->servos[k].fastest = fastest[i * n_servos + k];
        drives->has_masses = 1;
        drives->masses_at = drives->steps;
    }
}

/* Copy the numbers of n robots' free joints, shape (n, n_bodies); unused elements are
   -1. */
TOOL0_EXPORT void tool0_free_many(Robot *const *robots, int n, int32_t *joints)
{
    for (int i = 0; i < n; i++) {
        const DriveGovernor *governor = &robots[i]->drives->governor;
        int n_bodies = robots[i]->drives->table->n_bodies;
        for (int k = 0; k < n_bodies; k++)
            joints[i * n_bodies + k] = k < governor->n_free ? governor->free[k] : -1;
    }
}

/* Set the mobilities of n robots' free joints, shape (n, n_free, n_free), at their
   current positions. */
TOOL0_EXPORT void tool0_set_mobility_many(Robot *const *robots, int n,
                                          const double *mobility)
{
    for (int i = 0; i < n; i++) {
        DriveGovernor *governor = &robots[i]->drives->governor;
        int n_free = governor->n_free;
        memcpy(governor->mobility, &mobility[i * n_free * n_free],
               (size_t)n_free * n_free * sizeof(double));
        for (int k = 0; k < n_free; k++)
            governor->posture[k] = robots[i]->position[governor->free[k]];
        governor->has_mobility = governor->is_new = 1;
    }
}
