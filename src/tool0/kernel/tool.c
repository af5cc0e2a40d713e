/* Kinematics of the tool of n copies of an arm: gym/tool.py is the reference. */
#include <math.h>
#include <stdint.h>

#include "export.h"

enum { JOINTS = 6, STEPS = 2 };

/* A rotation matrix by rows, and a position [m]. */
typedef struct {
    double R[9];
    double p[3];
} Frame;

typedef struct {
    Frame base;           /* pose of the arm in the root */
    Frame joints[JOINTS]; /* pose of each joint at position 0 in the previous joint */
    double axes[JOINTS][3];
    Frame tool; /* pose of the tool in the last joint */
    double damping;
} Arm;

typedef struct {
    Frame tool;
    double axes[JOINTS][3];
    double points[JOINTS][3];
} Posture;

static void multiply(const double *a, const double *b, double *out)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + k] =
                a[3 * i] * b[k] + a[3 * i + 1] * b[3 + k] + a[3 * i + 2] * b[6 + k];
}

static void turn(const double *R, const double *v, double *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

static void compose(const Frame *a, const Frame *b, Frame *out)
{
    multiply(a->R, b->R, out->R);
    turn(a->R, b->p, out->p);
    for (int i = 0; i < 3; i++)
        out->p[i] += a->p[i];
}

/* Compute the rotation about a unit vector by Rodrigues' formula. */
static void about(const double *axis, double angle, double *R)
{
    double s = sin(angle), c = cos(angle), x = axis[0], y = axis[1], z = axis[2];
    double t = 1.0 - c;
    R[0] = t * x * x + c, R[1] = t * x * y - s * z, R[2] = t * x * z + s * y;
    R[3] = t * x * y + s * z, R[4] = t * y * y + c, R[5] = t * y * z - s * x;
    R[6] = t * x * z - s * y, R[7] = t * y * z + s * x, R[8] = t * z * z + c;
}

static void forward(const Arm *arm, const double *q, Posture *out)
{
    Frame frame = arm->base, placed;
    for (int k = 0; k < JOINTS; k++) {
        double R[9];
        compose(&frame, &arm->joints[k], &placed);
        turn(placed.R, arm->axes[k], out->axes[k]);
        about(arm->axes[k], q[k], R);
        multiply(placed.R, R, frame.R);
        for (int i = 0; i < 3; i++)
            frame.p[i] = out->points[k][i] = placed.p[i];
    }
    compose(&frame, &arm->tool, &out->tool);
}

/* Solve A x = b for a symmetric positive definite A; A and b are overwritten. */
static void solve(double A[JOINTS][JOINTS], double *b)
{
    for (int k = 0; k < JOINTS; k++) {
        for (int i = 0; i < k; i++)
            A[k][k] -= A[k][i] * A[k][i];
        A[k][k] = sqrt(A[k][k]);
        for (int j = k + 1; j < JOINTS; j++) {
            for (int i = 0; i < k; i++)
                A[j][k] -= A[j][i] * A[k][i];
            A[j][k] /= A[k][k];
        }
    }
    for (int k = 0; k < JOINTS; k++) {
        for (int i = 0; i < k; i++)
            b[k] -= A[k][i] * b[i];
        b[k] /= A[k][k];
    }
    for (int k = JOINTS - 1; k >= 0; k--) {
        for (int i = k + 1; i < JOINTS; i++)
            b[k] -= A[i][k] * b[i];
        b[k] /= A[k][k];
    }
}

/* Compute the way to a pose: a displacement and a chord of the rotation, in the root's
   axes. */
static void way(const Frame *from, const double *p, const double *R, double *out)
{
    double E[9];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            E[3 * i + k] = R[3 * i] * from->R[3 * k] +
                           R[3 * i + 1] * from->R[3 * k + 1] +
                           R[3 * i + 2] * from->R[3 * k + 2];
    double scale = sqrt(fmax(1.0 + E[0] + E[4] + E[8], 0.04));
    for (int i = 0; i < 3; i++)
        out[i] = p[i] - from->p[i];
    out[3] = (E[7] - E[5]) / scale;
    out[4] = (E[2] - E[6]) / scale;
    out[5] = (E[3] - E[1]) / scale;
}

static void newton_step(const Arm *arm, const double *p, const double *R, double *q)
{
    Posture posture;
    double J[JOINTS][JOINTS], A[JOINTS][JOINTS], error[JOINTS];
    forward(arm, q, &posture);
    way(&posture.tool, p, R, error);
    /* J by joints: a row of this matrix is a column of the usual Jacobian */
    for (int k = 0; k < JOINTS; k++) {
        const double *a = posture.axes[k];
        double r[3];
        for (int i = 0; i < 3; i++)
            r[i] = posture.tool.p[i] - posture.points[k][i], J[k][3 + i] = a[i];
        J[k][0] = a[1] * r[2] - a[2] * r[1];
        J[k][1] = a[2] * r[0] - a[0] * r[2];
        J[k][2] = a[0] * r[1] - a[1] * r[0];
    }
    for (int i = 0; i < JOINTS; i++)
        for (int j = 0; j < JOINTS; j++) {
            A[i][j] = i == j ? arm->damping : 0.0;
            for (int k = 0; k < JOINTS; k++)
                A[i][j] += J[k][i] * J[k][j];
        }
    solve(A, error);
    for (int k = 0; k < JOINTS; k++)
        for (int i = 0; i < JOINTS; i++)
            q[k] += J[k][i] * error[i];
}

/* Compute the poses of the tool in the root: positions (n, 3) and rotations (n, 3, 3). */
TOOL0_EXPORT void tool0_tool_poses(const Arm *arm, int32_t n, const double *q,
                                   double *positions, double *rotations)
{
    Posture posture;
    for (int32_t i = 0; i < n; i++) {
        forward(arm, q + JOINTS * i, &posture);
        for (int k = 0; k < 3; k++)
            positions[3 * i + k] = posture.tool.p[k];
        for (int k = 0; k < 9; k++)
            rotations[9 * i + k] = posture.tool.R[k];
    }
}

/* Compute joint positions closer to a pose; the change of each joint is limited. */
static void approach(const Arm *arm, const double *from, const double *position,
                     const double *rotation, const double *limit, double *to)
{
    double excess = 1.0;
    for (int k = 0; k < JOINTS; k++)
        to[k] = from[k];
    for (int step = 0; step < STEPS; step++)
        newton_step(arm, position, rotation, to);
    for (int k = 0; k < JOINTS; k++)
        excess = fmax(excess, fabs(to[k] - from[k]) / limit[k]);
    for (int k = 0; k < JOINTS; k++)
        to[k] = from[k] + (to[k] - from[k]) / excess;
}

/* Tool.approach for n copies. */
TOOL0_EXPORT void tool0_approach(const Arm *arm, int32_t n, const double *q,
                                 const double *positions, const double *rotations,
                                 const double *limit, double *found)
{
    for (int32_t i = 0; i < n; i++)
        approach(arm, q + JOINTS * i, positions + 3 * i, rotations + 9 * i, limit,
                 found + JOINTS * i);
}

/* Tool.steered for n copies; moves have shape (n, 4). */
TOOL0_EXPORT void tool0_steer(const Arm *arm, int32_t n, const double *q,
                              const double *moves, double lowest, const double *limit,
                              double *found)
{
    Posture posture;
    for (int32_t i = 0; i < n; i++) {
        const double *move = moves + 4 * i, *from = q + JOINTS * i;
        forward(arm, from, &posture);
        const double *p = posture.tool.p, *R = posture.tool.R;
        double to[3] = {p[0] + move[0], p[1] + move[1], p[2] + move[2]};
        to[2] = fmax(to[2], fmin(p[2], lowest));
        double yaw = atan2(R[3], R[0]) + move[3], c = cos(yaw), s = sin(yaw);
        double down[9] = {c, s, 0.0, s, -c, 0.0, 0.0, 0.0, -1.0};
        approach(arm, from, to, down, limit, found + JOINTS * i);
    }
}

/* Compute unit quaternions (w, x, y, z) with w >= 0, (n, 4), from rotations (n, 3, 3):
   quats_wxyz of description/transform_arrays.py. */
TOOL0_EXPORT void tool0_quats(int32_t n, const double *rotations, double *quats)
{
    for (int32_t i = 0; i < n; i++) {
        const double *R = rotations + 9 * i;
        double x = R[7] - R[5], y = R[2] - R[6], z = R[3] - R[1];
        double xy = R[1] + R[3], xz = R[2] + R[6], yz = R[5] + R[7];
        double table[4][4] = {
            {1 + R[0] + R[4] + R[8], x, y, z},
            {x, 1 + R[0] - R[4] - R[8], xy, xz},
            {y, xy, 1 - R[0] + R[4] - R[8], yz},
            {z, xz, yz, 1 - R[0] - R[4] + R[8]},
        };
        int largest = 0;
        for (int k = 1; k < 4; k++)
            if (table[k][k] > table[largest][largest])
                largest = k;
        const double *row = table[largest];
        double norm = sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]
                           + row[3] * row[3]);
        if (row[0] < 0.0)
            norm = -norm;
        for (int k = 0; k < 4; k++)
            quats[4 * i + k] = row[k] / norm;
    }
}
