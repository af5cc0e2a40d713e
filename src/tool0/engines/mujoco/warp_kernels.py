"""Warp kernels that read or change the state of MuJoCo Warp.

Arrays have one row per world.  A world is a copy of the robot and its scene.
"""

import warp as wp

vec5 = wp.types.vector(length=5, dtype=float)
"""Friction coefficients of a pair of geoms."""


@wp.kernel
def finish_step(
    most_squares: float,
    failures: int,
    overflow: wp.array[int],
    parked: wp.array[float],
    position: wp.array2d[float],
    velocity: wp.array2d[float],
    warm_start: wp.array2d[float],
    measured: wp.array2d[float],
    has_diverged: wp.array[int],
    steps: wp.array[int],
) -> None:
    """Count the step of each world, and stop the worlds that diverge.

    A world diverges if the sum of its squared speeds is not below ``most_squares``, or
    if its overflow has one of the bits of ``failures``.  A world that diverges keeps
    its last positions in ``measured``.  The physics of the world continues at
    ``parked``, so that the contacts of stopped worlds cannot fill the memory that all
    worlds share.
    """
    world = wp.tid()
    squares = float(0.0)
    for i in range(velocity.shape[1]):
        squares += velocity[world, i] * velocity[world, i]
    # This condition is also true for NaN.
    if not squares < most_squares or (overflow[world] & failures) != 0:
        has_diverged[world] = 1
    if has_diverged[world] == 0:
        for i in range(position.shape[1]):
            measured[world, i] = position[world, i]
        steps[world] += 1
        return
    for i in range(position.shape[1]):
        position[world, i] = parked[i]
    for i in range(velocity.shape[1]):
        velocity[world, i] = 0.0
        warm_start[world, i] = 0.0


@wp.kernel
def set_state(
    is_chosen: wp.array[int],
    start: wp.array2d[float],
    position: wp.array2d[float],
    velocity: wp.array2d[float],
    warm_start: wp.array2d[float],
    control: wp.array2d[float],
    measured: wp.array2d[float],
    time: wp.array[float],
    overflow: wp.array[int],
    has_diverged: wp.array[int],
    steps: wp.array[int],
) -> None:
    """Set the chosen worlds to rest at ``start``, with time 0."""
    world = wp.tid()
    if is_chosen[world] == 0:
        return
    for i in range(position.shape[1]):
        position[world, i] = start[world, i]
        measured[world, i] = start[world, i]
    for i in range(velocity.shape[1]):
        velocity[world, i] = 0.0
        warm_start[world, i] = 0.0
    for i in range(control.shape[1]):
        control[world, i] = 0.0
    time[world] = 0.0
    overflow[world] = 0
    has_diverged[world] = 0
    steps[world] = 0


@wp.kernel
def place_object(
    is_chosen: wp.array[int],
    first: wp.vec2i,
    pose: wp.array2d[float],
    position: wp.array2d[float],
    measured: wp.array2d[float],
    velocity: wp.array2d[float],
    warm_start: wp.array2d[float],
) -> None:
    """Place an object at rest at ``pose``.

    ``first`` contains the indices of the object's first position and first velocity.
    """
    world = wp.tid()
    if is_chosen[world] == 0:
        return
    for i in range(7):
        position[world, first[0] + i] = pose[world, i]
        measured[world, first[0] + i] = pose[world, i]
    for i in range(6):
        velocity[world, first[1] + i] = 0.0
        warm_start[world, first[1] + i] = 0.0


@wp.kernel
def set_body_mass(
    is_chosen: wp.array[int],
    body: int,
    first_dof: int,
    given: wp.array[float],
    mass: wp.array2d[float],
    subtree_mass: wp.array2d[float],
    inertia: wp.array2d[wp.vec3],
    body_weight: wp.array2d[wp.vec2],
    dof_weight: wp.array2d[float],
) -> None:
    """Set the masses of a free body and the values that depend on them.

    The dependent values are those of ``mj_setConst``.  The body's inertias are
    proportional to the mass, since the shape does not change.  ``…_weight`` are inverse
    inertias.
    """
    world = wp.tid()
    if is_chosen[world] == 0:
        return
    ratio = given[world] / mass[world, body]
    subtree_mass[world, 0] = subtree_mass[world, 0] + given[world] - mass[world, body]
    subtree_mass[world, body] = given[world]
    mass[world, body] = given[world]
    inertia[world, body] = ratio * inertia[world, body]
    body_weight[world, body] = body_weight[world, body] / ratio
    for i in range(6):
        dof_weight[world, first_dof + i] = dof_weight[world, first_dof + i] / ratio


@wp.kernel
def set_geom_friction(
    is_chosen: wp.array[int],
    geoms: wp.array[int],
    pairs: wp.array[int],
    ends: wp.array[wp.vec2i],
    given: wp.array[float],
    friction: wp.array2d[wp.vec3],
    pair_friction: wp.array2d[vec5],
) -> None:
    """Set the sliding friction of geoms; each pair gets the smaller value.

    ``ends`` contains the two geoms of each pair in ``pairs``.
    """
    world = wp.tid()
    if is_chosen[world] == 0:
        return
    for k in range(geoms.shape[0]):
        own = friction[world, geoms[k]]
        friction[world, geoms[k]] = wp.vec3(given[world], own[1], own[2])
    for k in range(pairs.shape[0]):
        first = friction[world, ends[k][0]]
        second = friction[world, ends[k][1]]
        found = pair_friction[world, pairs[k]]
        found[0] = wp.min(first[0], second[0])
        found[1] = found[0]
        pair_friction[world, pairs[k]] = found


@wp.kernel
def sum_normal_forces(
    n_contacts: wp.array[int],
    world_of: wp.array[int],
    geoms: wp.array[wp.vec2i],
    rows: wp.array2d[int],
    forces: wp.array2d[float],
    owner: wp.array2d[int],
    found: wp.array2d[float],
) -> None:
    """Add the normal force of each contact to the forces of the touching links.

    An element of ``owner`` is 1 if the geom of the row belongs to the link of the
    column.
    """
    contact = wp.tid()
    if contact >= n_contacts[0] or rows[contact, 0] < 0:
        return
    world = world_of[contact]
    pair = geoms[contact]
    force = forces[world, rows[contact, 0]]
    for link in range(owner.shape[1]):
        if owner[pair[0], link] != 0 or owner[pair[1], link] != 0:
            wp.atomic_add(found, world, link, force)


@wp.kernel
def find_touching(
    n_contacts: wp.array[int],
    world_of: wp.array[int],
    geoms: wp.array[wp.vec2i],
    rows: wp.array2d[int],
    forces: wp.array2d[float],
    steps: wp.array[int],
    side: wp.array2d[int],
    found: wp.array[int],
) -> None:
    """Set 1 for each world in which geoms of the two sides press on each other.

    An element of ``side`` is 1 if the geom of the row belongs to the side of the
    column.  A world has no contacts before its first step.
    """
    contact = wp.tid()
    if contact >= n_contacts[0] or rows[contact, 0] < 0:
        return
    world = world_of[contact]
    if steps[world] == 0 or forces[world, rows[contact, 0]] == 0.0:
        return
    a = geoms[contact][0]
    b = geoms[contact][1]
    if side[a, 0] * side[b, 1] + side[b, 0] * side[a, 1] != 0:
        found[world] = 1
