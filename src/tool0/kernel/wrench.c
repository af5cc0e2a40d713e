/* Wrenches of tools on their flanges: ToolDynamics.forces of hardware/tool_dynamics.py. */

#include <stdint.h>

#include "drives.h"
#include "export.h"

typedef struct {
    int32_t body, unused; /* body: n_bodies for the world */
    double mass, center[3], tensor[9];
} ToolPart;

typedef struct {
    int32_t n_bodies, n_parts, carrier, unused; /* carrier: number of a body, or n_bodies */
    double dt;
    double rise[3], flange[12];
    const DriveBody *bodies;
    const ToolPart *parts;
} Tool;

/* A physics step: positions and velocities before it, and velocities after it. */
typedef struct {
    const double *position, *velocity, *after;
} Step;

/* Motion of a body in the axes of the root; the acceleration is that of the body's
   origin. */
typedef struct {
    double angular_velocity[3], angular_acceleration[3], acceleration[3];
} Motion;

static void rotate(const double *f, const double *v, double *out)
{
    for (int k = 0; k < 3; k++)
        out[k] = f[k] * v[0] + f[3 + k] * v[1] + f[6 + k] * v[2];
}

static void rotate_back(const double *f, const double *v, double *out)
{
    for (int k = 0; k < 9; k += 3)
        out[k / 3] = f[k] * v[0] + f[k + 1] * v[1] + f[k + 2] * v[2];
}

static void compose(const double *outer, const double *inner, double *out)
{
    for (int k = 0; k < 12; k += 3)
        rotate(outer, &inner[k], &out[k]);
    for (int k = 9; k < 12; k++)
        out[k] = out[k] + outer[k];
}

static void acceleration_at(const Motion *body, const double *r, double *out)
{
    const double *w = body->angular_velocity, *e = body->angular_acceleration;
    const double *a = body->acceleration;
    double x = r[0], y = r[1], z = r[2];
    double ux = w[1] * z - w[2] * y, uy = w[2] * x - w[0] * z, uz = w[0] * y - w[1] * x;
    out[0] = a[0] + e[1] * z - e[2] * y + w[1] * uz - w[2] * uy;
    out[1] = a[1] + e[2] * x - e[0] * z + w[2] * ux - w[0] * uz;
    out[2] = a[2] + e[0] * y - e[1] * x + w[0] * uy - w[1] * ux;
}

/* Compute the motion of a body on its carrier; f and before are the frames of both. */
static void moved(const DriveBody *body, const Motion *carrier, const double *f,
                  const double *before, double qd, double qdd, Motion *motion)
{
    const double *w = carrier->angular_velocity, *axis = &f[6];
    double lever[] = {f[9] - before[9], f[10] - before[10], f[11] - before[11]};
    *motion = *carrier;
    acceleration_at(carrier, lever, motion->acceleration);
    double turn[] = {w[1] * axis[2] - w[2] * axis[1], w[2] * axis[0] - w[0] * axis[2],
                     w[0] * axis[1] - w[1] * axis[0]};
    for (int k = 0; k < 3; k++) {
        double *a = &motion->acceleration[k], *e = &motion->angular_acceleration[k];
        if (body->is_prismatic) {
            *a = *a + 2.0 * qd * turn[k] + qdd * axis[k];
            continue;
        }
        *e = *e + qd * turn[k] + qdd * axis[k];
        motion->angular_velocity[k] = w[k] + qd * axis[k];
    }
}

/* Compute the torque that accelerates a rotating body (Euler), in the body's axes. */
static void inertial_torque(const double *t, const double *w, const double *e, double *out)
{
    double h[3];
    for (int k = 0; k < 3; k++)
        h[k] = t[3 * k] * w[0] + t[3 * k + 1] * w[1] + t[3 * k + 2] * w[2];
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = t[3 * k] * e[0] + t[3 * k + 1] * e[1] + t[3 * k + 2] * e[2]
                 + w[i] * h[j] - w[j] * h[i];
    }
}

static void add_part(const ToolPart *part, const double *frame, const Motion *motion,
                     const double *flange, double *force, double *torque)
{
    double r[3], a[3], w[3], dw[3], spun[3], n[3], mass = part->mass;
    rotate(frame, part->center, r);
    acceleration_at(motion, r, a);
    for (int k = 0; k < 3; k++)
        a[k] = -mass * a[k];
    rotate_back(frame, motion->angular_velocity, w);
    rotate_back(frame, motion->angular_acceleration, dw);
    inertial_torque(part->tensor, w, dw, spun);
    rotate(frame, spun, n);
    for (int k = 0; k < 3; k++) {
        r[k] = r[k] + frame[9 + k] - flange[9 + k];
        force[k] += a[k];
    }
    torque[0] += r[1] * a[2] - r[2] * a[1] - n[0];
    torque[1] += r[2] * a[0] - r[0] * a[2] - n[1];
    torque[2] += r[0] * a[1] - r[1] * a[0] - n[2];
}

static void forces(const Tool *tool, const Step *step, double *sums, double *flange)
{
    int n = tool->n_bodies;
    double frames[n + 1][12];
    Motion motions[n + 1];
    static const double ROOT[12] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    drives_frames(tool->bodies, n, step->position, frames);
    motions[n] = (Motion){{0.0}, {0.0}, {tool->rise[0], tool->rise[1], tool->rise[2]}};
    for (int k = 0; k < 12; k++)
        frames[n][k] = ROOT[k];
    for (int i = 0; i < n; i++) {
        const DriveBody *body = &tool->bodies[i];
        int carrier = body->parent >= 0 ? body->parent : n;
        double qd = step->velocity[body->joint];
        double qdd = (step->after[body->joint] - qd) / tool->dt;
        moved(body, &motions[carrier], frames[i], frames[carrier], qd, qdd, &motions[i]);
    }
    compose(frames[tool->carrier], tool->flange, flange);
    for (int k = 0; k < 6; k++)
        sums[k] = 0.0;
    for (int j = 0; j < tool->n_parts; j++) {
        const ToolPart *part = &tool->parts[j];
        add_part(part, frames[part->body], &motions[part->body], flange, sums, &sums[3]);
    }
}

/* Compute force and torque on the flange without contacts, in n steps of copies of a
   robot.  The results are the wrenches in the root's axes, (n, 6), the frames of the
   flange, (n, 12), and the wrenches in the flange's axes, (n, 6). */
TOOL0_EXPORT void tool0_tool_forces(const Tool *tool, const Step *steps, int n,
                                    double *sums, double *flanges, double *wrenches)
{
    for (int i = 0; i < n; i++) {
        double *sum = &sums[6 * i], *flange = &flanges[12 * i];
        forces(tool, &steps[i], sum, flange);
        rotate_back(flange, sum, &wrenches[6 * i]);
        rotate_back(flange, &sum[3], &wrenches[6 * i + 3]);
    }
}
