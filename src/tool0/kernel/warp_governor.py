"""The joint speed governor of ``hardware/speed_governor.py`` as a Warp kernel.

The kernel processes many robots in parallel, in single precision.  Arrays have one row
per robot: shape (n, …).  The f free joints are the joints that are not held by a brake,
starting with the governed joints.
"""

import warp as wp

from tool0.hardware.speed_governor import LARGEST_TURN, SWEEPS, TOLERANCE
from tool0.kernel.warp_laws import Body, place_bodies

MOST_SWEEPS = wp.constant(SWEEPS)
MOST_TURN = wp.constant(LARGEST_TURN)
LEAST_EXCESS = wp.constant(TOLERANCE)


@wp.struct
class Governed:
    """Drive with a governed speed, corresponding to ``GovernedDrive``."""

    joint: int
    speed: float
    fast: float
    effort: float


@wp.struct
class Scratch:
    """Working memory of ``govern`` for each robot."""

    rotations: wp.array2d[wp.mat33]
    positions: wp.array2d[wp.vec3]
    """Rotations and origins of the bodies' frames."""
    linear: wp.array2d[wp.vec3]
    angular: wp.array2d[wp.vec3]
    """Linear and angular velocities of a body per unit velocity of each free joint."""
    coming: wp.array2d[float]
    wanted: wp.array2d[float]
    used: wp.array2d[float]
    """Velocities and efforts of the free joints."""


@wp.struct
class Remembered:
    """Data that ``govern`` stores between steps."""

    has_before: wp.array[int]
    before: wp.array2d[float]
    """Velocities of the joints in the last step."""
    has_mobility: wp.array[int]
    mobility: wp.array3d[float]
    posture: wp.array2d[float]
    """Positions of the free joints for which the mobility was computed."""


@wp.kernel
def govern(
    dt: float,
    drives: wp.array[Governed],
    free: wp.array[int],
    free_of: wp.array[int],
    rotors: wp.array[float],
    bodies: wp.array[Body],
    compensates: wp.array[float],
    loads: wp.array2d[float],
    command: wp.array2d[float],
    position: wp.array2d[float],
    velocity: wp.array2d[float],
    applied: wp.array2d[float],
    scratch: Scratch,
    remembered: Remembered,
    requested: wp.array2d[float],
) -> None:
    """Request each joint's command and load, limited by the speeds of the joints.

    ``free_of`` contains each joint's number among the free joints, or -1.  ``rotors``
    contains the rotor inertias of the free joints.  ``compensates`` is 1 for joints
    with a drive that compensates for the load.
    """
    robot = wp.tid()
    for i in range(requested.shape[1]):
        requested[robot, i] = command[robot, i] + compensates[i] * loads[robot, i]
    is_fast = int(0)
    for k in range(drives.shape[0]):
        if wp.abs(velocity[robot, drives[k].joint]) > drives[k].fast:
            is_fast = 1
    if is_fast != 0 and remembered.has_before[robot] != 0:
        is_due = 1 - remembered.has_mobility[robot]
        for k in range(free.shape[0]):
            turn = position[robot, free[k]] - remembered.posture[robot, k]
            if wp.abs(turn) > MOST_TURN:
                is_due = 1
        if is_due != 0:
            place_bodies(robot, bodies, position, scratch.rotations, scratch.positions)
            find_mobility(
                robot, dt, free_of, rotors, bodies, scratch, remembered.mobility
            )
            remembered.has_mobility[robot] = 1
            for k in range(free.shape[0]):
                remembered.posture[robot, k] = position[robot, free[k]]
        limit(
            robot,
            drives,
            free,
            velocity,
            remembered.before,
            applied,
            remembered.mobility,
            scratch,
            requested,
        )
    for i in range(remembered.before.shape[1]):
        remembered.before[robot, i] = velocity[robot, i]
    remembered.has_before[robot] = 1


@wp.func
def find_mobility(
    robot: int,
    dt: float,
    free_of: wp.array[int],
    rotors: wp.array[float],
    bodies: wp.array[Body],
    scratch: Scratch,
    mobility: wp.array3d[float],
) -> None:
    """Set the mobility of a robot with placed bodies, as ``DriveDynamics`` does."""
    n = rotors.shape[0]
    for i in range(n):
        for j in range(n):
            mobility[robot, i, j] = 0.0
        mobility[robot, i, i] = rotors[i]
    for b in range(bodies.shape[0]):
        for i in range(n):
            scratch.linear[robot, i] = wp.vec3(0.0, 0.0, 0.0)
            scratch.angular[robot, i] = wp.vec3(0.0, 0.0, 0.0)
        R_body = scratch.rotations[robot, b]
        center = R_body @ bodies[b].center + scratch.positions[robot, b]
        a = int(b)
        while a >= 0:
            i = free_of[bodies[a].master]
            if i >= 0:
                R = scratch.rotations[robot, a]
                axis = bodies[a].multiplier * wp.vec3(R[0, 2], R[1, 2], R[2, 2])
                way = axis
                if bodies[a].is_prismatic == 0:
                    way = wp.cross(axis, center - scratch.positions[robot, a])
                    scratch.angular[robot, i] = scratch.angular[robot, i] + axis
                scratch.linear[robot, i] = scratch.linear[robot, i] + way
            a = bodies[a].parent
        tensor = R_body @ bodies[b].tensor @ wp.transpose(R_body)
        for i in range(n):
            momentum = bodies[b].mass * scratch.linear[robot, i]
            spin = tensor @ scratch.angular[robot, i]
            for j in range(n):
                mobility[robot, i, j] += wp.dot(momentum, scratch.linear[robot, j])
                mobility[robot, i, j] += wp.dot(spin, scratch.angular[robot, j])
    for k in range(n):  # Gauss-Jordan elimination; the mass matrix is positive definite
        pivot = 1.0 / mobility[robot, k, k]
        mobility[robot, k, k] = 1.0
        for j in range(n):
            mobility[robot, k, j] *= pivot
        for i in range(n):
            if i != k:
                factor = mobility[robot, i, k]
                mobility[robot, i, k] = 0.0
                for j in range(n):
                    mobility[robot, i, j] -= factor * mobility[robot, k, j]
    for i in range(n):
        for j in range(n):
            mobility[robot, i, j] *= dt


@wp.func
def change(
    robot: int,
    mobility: wp.array3d[float],
    row: int,
    by: float,
    coming: wp.array2d[float],
) -> None:
    """Add the effect of a change in one effort to the velocities after the step."""
    for j in range(coming.shape[1]):
        coming[robot, j] += mobility[robot, row, j] * by


@wp.func
def limit(
    robot: int,
    drives: wp.array[Governed],
    free: wp.array[int],
    velocity: wp.array2d[float],
    before: wp.array2d[float],
    applied: wp.array2d[float],
    mobility: wp.array3d[float],
    scratch: Scratch,
    requested: wp.array2d[float],
) -> None:
    """Limit the requested efforts of a robot, as ``SpeedGovernor.limit`` does."""
    m = drives.shape[0]
    for k in range(free.shape[0]):
        i = free[k]
        scratch.coming[robot, k] = 2.0 * velocity[robot, i] - before[robot, i]
        u = requested[robot, i]
        if k < m:
            u = wp.clamp(u, -drives[k].effort, drives[k].effort)
        scratch.wanted[robot, k] = u
        scratch.used[robot, k] = u
    for k in range(free.shape[0]):
        by = scratch.wanted[robot, k] - applied[robot, free[k]]
        change(robot, mobility, k, by, scratch.coming)
    is_within = int(1)
    for k in range(m):
        if wp.abs(scratch.coming[robot, k]) > drives[k].speed:
            is_within = 0
    if is_within != 0:
        return
    has_changed = int(1)
    sweep = int(0)
    while has_changed != 0 and sweep < MOST_SWEEPS:
        has_changed = int(0)
        for k in range(m):
            own = mobility[robot, k, k]
            old = scratch.used[robot, k]
            coming = scratch.coming[robot, k]
            reached = coming + own * (scratch.wanted[robot, k] - old)
            reached = wp.clamp(reached, -drives[k].speed, drives[k].speed)
            best = old + (reached - coming) / own
            best = wp.clamp(best, -drives[k].effort, drives[k].effort)
            scratch.used[robot, k] = best
            if best != old:
                has_changed = 1
                change(robot, mobility, k, best - old, scratch.coming)
        sweep += 1
    share_excess(robot, drives, mobility, scratch)
    for k in range(m):
        requested[robot, drives[k].joint] = scratch.used[robot, k]


@wp.func
def share_excess(
    robot: int,
    drives: wp.array[Governed],
    mobility: wp.array3d[float],
    scratch: Scratch,
) -> None:
    """Distribute braking effort that exceeds a drive's limit among all drives."""
    m = drives.shape[0]
    is_within = int(0)
    sweep = int(0)
    while is_within == 0 and sweep < MOST_SWEEPS:
        is_within = int(1)
        for k in range(m):
            coming = scratch.coming[robot, k]
            excess = coming - wp.clamp(coming, -drives[k].speed, drives[k].speed)
            if wp.abs(excess) > LEAST_EXCESS:
                is_within = 0
                norm = float(0.0)
                for j in range(m):
                    norm += mobility[robot, k, j] * mobility[robot, k, j]
                for j in range(m):
                    old = scratch.used[robot, j]
                    best = old - excess * mobility[robot, k, j] / norm
                    best = wp.clamp(best, -drives[j].effort, drives[j].effort)
                    scratch.used[robot, j] = best
                    change(robot, mobility, j, best - old, scratch.coming)
        sweep += 1
