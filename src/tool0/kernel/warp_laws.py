"""Control laws and drives as Warp kernels, for many robots.

The kernels implement ``laws.c`` and ``drives.c``.  The operations are in the same order
as in the C code, but in single precision.  Time has double precision, so that motions
start and end in the same tick as in the C code.  Units and names are those of the C
structs.  Arrays have one row per robot: shape (n, …).
"""

import math

import warp as wp

TURN = wp.constant(math.tau)
JUST_AFTER = wp.constant(wp.float64(2.3e-16))
"""Relative distance from a number to the next larger number."""


@wp.struct
class Body:
    """Body, corresponding to ``DriveBody``; ``master`` is a joint number."""

    parent: int
    is_prismatic: int
    master: int
    joint: int
    multiplier: float
    mass: float
    rotation: wp.mat33
    position: wp.vec3
    center: wp.vec3
    tensor: wp.mat33
    """Inertia tensor about the center of mass [kg·m²]."""


@wp.struct
class Spring:
    """Spring, corresponding to ``DriveSpring``, with joint numbers."""

    joint: int
    master: int
    factor: float
    """Product of the joint's multiplier and the spring's stiffness."""
    reference: float


@wp.struct
class Drive:
    """Limits of a drive (``DriveBounds``), and the pad geometry of ``DriveGoal``."""

    joint: int
    is_soft: int
    is_linear: int
    is_governed: int
    """Whether the speed governor limits the joint's speed."""
    effort: float
    velocity: float
    lower: float
    upper: float
    rotor: float
    ease: float
    k_velocity: float
    k_position: float
    soft_lower: float
    soft_upper: float
    pad_cos: float
    pad_sin: float
    pad_slope: float


@wp.struct
class Goal:
    """A joint that is moved by a command."""

    source: int
    """Column of the joint in the command array."""
    column: int
    """Number of the joint among the controlled joints."""
    drive: int
    lower: float
    upper: float


@wp.struct
class Gripper:
    """Parallel gripper, corresponding to ``ParallelGripper``, and its pad motion."""

    column: int
    """Number of the gripper's joint among the controlled joints."""
    drive: int
    is_linear: int
    pad_offset: float
    pad_cos: float
    pad_sin: float
    pad_slope: float
    widest: float
    fastest: float
    ramp_time: float
    shortest: float
    """Shortest duration of a motion [s]."""


@wp.kernel
def run_laws(
    steps: wp.array[int],
    dt: wp.float64,
    period: float,
    joints: wp.array[int],
    wraps: wp.array[int],
    gains: wp.array2d[float],
    feed_forward: wp.array[float],
    until: wp.array3d[wp.float64],
    origin: wp.array3d[wp.float64],
    coefficients: wp.array3d[wp.vec4],
    position: wp.array2d[float],
    velocity: wp.array2d[float],
    integrals: wp.array2d[float],
    command: wp.array2d[float],
) -> None:
    """Write the commands for all controlled joints of each robot in one tick."""
    robot, k = wp.tid()
    time = wp.float64(steps[robot]) * dt
    j = int(0)
    while time >= until[robot, k, j]:  # ``until`` of the last piece is infinite
        j += 1
    t = wp.float32(time - origin[robot, k, j])
    c = coefficients[robot, k, j]
    i = joints[k]
    error = c[0] + t * (c[1] + t * (c[2] + t * c[3])) - position[robot, i]
    rate = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]) - velocity[robot, i]
    if wraps[k] != 0:
        error = error - TURN * wp.rint(error / TURN)
    integral = integrals[robot, k] + period * error
    term = gains[k, 1] * integral
    clamped = wp.min(wp.max(term, gains[k, 3]), gains[k, 4])
    if clamped != term and gains[k, 5] != 0.0:
        integral = clamped / gains[k, 1]
    integrals[robot, k] = integral
    effort = gains[k, 0] * error + clamped + gains[k, 2] * rate
    command[robot, i] = effort + feed_forward[k] * (rate + velocity[robot, i])


@wp.func
def setpoint(
    until: wp.array3d[wp.float64],
    origin: wp.array3d[wp.float64],
    coefficients: wp.array3d[wp.vec4],
    robot: int,
    joint: int,
    now: wp.float64,
) -> wp.vec2:
    """Return the desired position and velocity of a controlled joint."""
    j = int(0)
    while now >= until[robot, joint, j]:
        j += 1
    t = wp.float32(now - origin[robot, joint, j])
    c = coefficients[robot, joint, j]
    q = c[0] + t * (c[1] + t * (c[2] + t * c[3]))
    return wp.vec2(q, c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]))


@wp.func
def cubic(start: wp.vec2, way: float, speed: float, T: float) -> wp.vec4:
    """Return a cubic of duration T, given its start, displacement and final speed."""
    c2 = (3.0 * way - (2.0 * start[1] + speed) * T) / T / T
    c3 = (-2.0 * way + (start[1] + speed) * T) / T / T / T
    return wp.vec4(start[0], start[1], c2, c3)


@wp.func
def start_motion(
    until: wp.array3d[wp.float64],
    origin: wp.array3d[wp.float64],
    coefficients: wp.array3d[wp.vec4],
    robot: int,
    joint: int,
    now: wp.float64,
    duration: wp.float64,
    polynomial: wp.vec4,
    end: float,
) -> None:
    """Start a motion of a joint along a polynomial, followed by rest at ``end``."""
    last = now + duration
    # The motion is still active at its end.
    until[robot, joint, 0] = last + last * JUST_AFTER
    until[robot, joint, 1] = wp.float64(wp.inf)
    origin[robot, joint, 0] = now
    coefficients[robot, joint, 0] = polynomial
    coefficients[robot, joint, 1] = wp.vec4(end, 0.0, 0.0, 0.0)


@wp.kernel
def start_motions(
    is_chosen: wp.array[int],
    steps: wp.array[int],
    dt: wp.float64,
    duration: wp.float64,
    goals: wp.array[Goal],
    wraps: wp.array[int],
    positions: wp.array2d[float],
    velocities: wp.array2d[float],
    until: wp.array3d[wp.float64],
    origin: wp.array3d[wp.float64],
    coefficients: wp.array3d[wp.vec4],
    grips: wp.array2d[wp.vec3],
    has_diverged: wp.array[int],
) -> None:
    """Start motions from the setpoints to ``positions``, as ``Motions.start`` does.

    A motion is a line, or a cubic if ``velocities`` is not empty, followed by rest.
    Positions beyond a limit are clamped.  A robot with a number that is not finite is
    marked as diverged.
    """
    robot, k = wp.tid()
    if is_chosen[robot] == 0:
        return
    goal = goals[k]
    target = positions[robot, goal.source]
    speed = float(0.0)
    if velocities.shape[0] > 0:
        speed = velocities[robot, goal.source]
    if not wp.isfinite(target) or not wp.isfinite(speed):
        has_diverged[robot] = 1
        return
    i = goal.column
    now = wp.float64(steps[robot]) * dt
    start = setpoint(until, origin, coefficients, robot, i, now)
    way = wp.clamp(target, goal.lower, goal.upper) - start[0]
    if wraps[i] != 0:
        way = way - TURN * wp.rint(way / TURN)
    T = wp.float32(duration)
    polynomial = wp.vec4(start[0], way / T, 0.0, 0.0)
    if velocities.shape[0] > 0:
        polynomial = cubic(start, way, speed, T)
    end = start[0] + way
    start_motion(until, origin, coefficients, robot, i, now, duration, polynomial, end)
    grips[robot, goal.drive] = wp.vec3(0.0, 0.0, 0.0)


@wp.kernel
def start_grips(
    is_chosen: wp.array[int],
    steps: wp.array[int],
    dt: wp.float64,
    gripper: Gripper,
    openings: wp.array[float],
    speeds: wp.array[float],
    forces: wp.array[float],
    until: wp.array3d[wp.float64],
    origin: wp.array3d[wp.float64],
    coefficients: wp.array3d[wp.vec4],
    grips: wp.array2d[wp.vec3],
    has_diverged: wp.array[int],
) -> None:
    """Start pad motions with speeds and forces; see ``motion.gripper.direct_path``.

    Openings out of range are clamped.  A robot with an opening that is not finite is
    marked as diverged.
    """
    robot = wp.tid()
    if is_chosen[robot] == 0:
        return
    if not wp.isfinite(openings[robot]):
        has_diverged[robot] = 1
        return
    opening = wp.clamp(openings[robot], 0.0, gripper.widest)
    now = wp.float64(steps[robot]) * dt
    start = setpoint(until, origin, coefficients, robot, gripper.column, now)
    q = start[0]
    if gripper.is_linear != 0:
        here = 2.0 * (gripper.pad_offset + gripper.pad_slope * q)
        end = (opening / 2.0 - gripper.pad_offset) / gripper.pad_slope
    else:
        x = gripper.pad_cos
        y = gripper.pad_sin
        here = 2.0 * (gripper.pad_offset + x * wp.cos(q) + y * wp.sin(q))
        side = (opening / 2.0 - gripper.pad_offset) / wp.sqrt(x * x + y * y)
        end = wp.atan2(y, x) + wp.acos(wp.clamp(side, -1.0, 1.0))
    distance = wp.abs(opening - here)
    T = wp.max(
        gripper.shortest,
        wp.max(
            1.5 * distance / speeds[robot],
            wp.sqrt(6.0 * distance * gripper.ramp_time / gripper.fastest),
        ),
    )
    polynomial = cubic(start, end - q, 0.0, T)
    start_motion(
        until,
        origin,
        coefficients,
        robot,
        gripper.column,
        now,
        wp.float64(T),
        polynomial,
        end,
    )
    grips[robot, gripper.drive] = wp.vec3(forces[robot], speeds[robot], 1.0)


@wp.func
def place_bodies(
    robot: int,
    bodies: wp.array[Body],
    position: wp.array2d[float],
    rotations: wp.array2d[wp.mat33],
    positions: wp.array2d[wp.vec3],
) -> None:
    """Compute the frames of all bodies of a robot in the root."""
    for i in range(bodies.shape[0]):
        body = bodies[i]
        R = body.rotation
        p = body.position
        if body.parent >= 0:
            p = rotations[robot, body.parent] @ p + positions[robot, body.parent]
            R = rotations[robot, body.parent] @ R
        q = position[robot, body.joint]
        if body.is_prismatic != 0:
            p = p + q * wp.vec3(R[0, 2], R[1, 2], R[2, 2])
        else:
            c = wp.cos(q)
            s = wp.sin(q)
            R = R @ wp.mat33(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
        rotations[robot, i] = R
        positions[robot, i] = p


@wp.kernel
def balance(
    steps: wp.array[int],
    pose_period: int,
    gravity: float,
    bodies: wp.array[Body],
    springs: wp.array[Spring],
    position: wp.array2d[float],
    rotations: wp.array2d[wp.mat33],
    positions: wp.array2d[wp.vec3],
    moments: wp.array2d[wp.vec3],
    loads: wp.array2d[float],
) -> None:
    """If loads are due, set them to the efforts that balance gravity and springs.

    ``rotations``, ``positions`` and ``moments`` (with the mass as last component) are
    working memory with one element per body.
    """
    robot = wp.tid()
    if steps[robot] % pose_period != 0:
        return
    place_bodies(robot, bodies, position, rotations, positions)
    for i in range(bodies.shape[0]):
        center = rotations[robot, i] @ bodies[i].center + positions[robot, i]
        moments[robot, i] = bodies[i].mass * wp.vec3(center[0], center[1], 1.0)
    for i in range(loads.shape[1]):
        loads[robot, i] = 0.0
    for k in range(bodies.shape[0]):
        i = bodies.shape[0] - 1 - k
        body = bodies[i]
        R = rotations[robot, i]
        p = positions[robot, i]
        moment = moments[robot, i]
        load = gravity * moment[2] * R[2, 2]
        if body.is_prismatic == 0:
            lever_x = moment[0] - moment[2] * p[0]
            lever_y = moment[1] - moment[2] * p[1]
            load = gravity * (R[0, 2] * lever_y - R[1, 2] * lever_x)
        loads[robot, body.master] += body.multiplier * load
        if body.parent >= 0:
            moments[robot, body.parent] = moments[robot, body.parent] + moment
    for k in range(springs.shape[0]):
        spring = springs[k]
        stretch = position[robot, spring.joint] - spring.reference
        loads[robot, spring.master] += spring.factor * stretch


@wp.func
def soft_speed(drive: Drive, position: float, limit: float) -> wp.float32:
    """Return the allowed speed towards a soft limit at ``position``."""
    speed = -drive.k_position * (position - limit)
    return wp.clamp(speed, -drive.velocity, drive.velocity)


@wp.kernel
def run_drives(
    drives: wp.array[Drive],
    compensates: wp.array[float],
    loads: wp.array2d[float],
    grips: wp.array2d[wp.vec3],
    requested: wp.array2d[float],
    position: wp.array2d[float],
    velocity: wp.array2d[float],
    before: wp.array2d[float],
    effort: wp.array2d[float],
    motors: wp.array2d[float],
    motor_of: wp.array[int],
) -> None:
    """Write the efforts of each robot's drives for the next step.

    ``compensates`` is 1 for drives that compensate for their load.  ``motor_of``
    contains the motor number of each drive.  ``grips`` contains three values: the pad
    force and the pad speed of a goal, and 1 if there is a goal.
    """
    robot, k = wp.tid()
    drive = drives[k]
    i = drive.joint
    gravity = compensates[k] * loads[robot, i]
    q = position[robot, i]
    qd = velocity[robot, i]
    u = requested[robot, i]
    most = drive.effort
    speed = drive.velocity
    applied = effort[robot, i]
    grip = grips[robot, k]
    is_limited = grip[2] > 0.0
    has_rotor = drive.rotor < wp.inf
    if is_limited or has_rotor:
        is_free = wp.abs(u) <= most
        if is_limited or not is_free or wp.abs(qd) + wp.abs(u) / drive.rotor > speed:
            if is_limited:
                lever = 2.0 * wp.abs(drive.pad_slope)
                if drive.is_linear == 0:
                    lever = 2.0 * wp.abs(
                        drive.pad_sin * wp.cos(q) - drive.pad_cos * wp.sin(q)
                    )
                force = grip[0] * lever
                lowest = wp.min(gravity - force, applied + drive.ease)
                highest = wp.max(gravity + force, applied - drive.ease)
                u = wp.min(wp.max(u, lowest), highest)
                if lever > 0.0:
                    speed = wp.min(speed, grip[1] / lever)
            u = wp.clamp(u, -most, most)
            last = before[robot, k]
            before[robot, k] = qd
            if has_rotor:
                held_back = float(0.0)
                if not wp.isnan(last):
                    held_back = applied - (qd - last) * drive.rotor
                if u > gravity:
                    room = (speed - qd) * drive.rotor + held_back
                    u = wp.min(u, wp.max(room, wp.min(0.0, gravity)))
                else:
                    room = held_back - (speed + qd) * drive.rotor
                    u = wp.max(u, wp.min(room, wp.max(0.0, gravity)))
            elif (u > 0.0 and qd > speed) or (u <= 0.0 and qd < -speed):
                u = 0.0
        else:
            before[robot, k] = wp.nan
        speed = wp.inf
    if drive.is_governed != 0:
        speed = wp.inf
    if u > 0.0:
        if q > drive.upper or qd > speed:
            u = 0.0
        u = wp.min(u, most)
    elif u < 0.0:
        if q < drive.lower or qd < -speed:
            u = 0.0
        u = wp.max(u, -most)
    if drive.is_soft != 0:
        slowest = soft_speed(drive, q, drive.soft_lower)
        fastest = soft_speed(drive, q, drive.soft_upper)
        lower = wp.clamp(-drive.k_velocity * (qd - slowest), -most, most)
        upper = wp.clamp(-drive.k_velocity * (qd - fastest), -most, most)
        u = wp.min(wp.max(u, lower), upper)
    effort[robot, i] = u
    motors[robot, motor_of[k]] = u


@wp.kernel
def restart(
    is_chosen: wp.array[int],
    integrals: wp.array2d[float],
    command: wp.array2d[float],
    before: wp.array2d[float],
    effort: wp.array2d[float],
    has_before: wp.array[int],
    has_mobility: wp.array[int],
) -> None:
    """Reset the state of laws, drives and governors of the chosen robots."""
    robot = wp.tid()
    if is_chosen[robot] == 0:
        return
    has_before[robot] = 0
    has_mobility[robot] = 0
    for k in range(integrals.shape[1]):
        integrals[robot, k] = 0.0
    for k in range(before.shape[1]):
        before[robot, k] = wp.nan
    for i in range(command.shape[1]):
        command[robot, i] = 0.0
        effort[robot, i] = 0.0
