"""Conversion of the robot model to MuJoCo's ``MjSpec``.

Fixed links are merged into their moving parent body, and the names of these links
remain as geom and site names.  ``<mimic>`` is converted to a joint equality, a loop to
a connection of two points, and ``<transmission>`` to a motor.  A link with a
``<gazebo>`` surface gets the contact parameters of a pad.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from tool0.description.bodies import (
    Matrix,
    MovingBody,
    check_masses,
    fixed_to_world,
    moving_bodies,
)
from tool0.description.model import (
    Collision,
    Joint,
    JointType,
    Link,
    LoopJoint,
    RobotModel,
    Visual,
)
from tool0.description.scene import GROUND
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.description.transform import pose_matrix
from tool0.engines.mujoco.convex_parts import Points, convex_parts
from tool0.engines.mujoco.self_collisions import (
    body_at_rest,
    excluded_pairs,
    self_colliding,
)
from tool0.errors import ModelError

GRIP_SOLREF = (0.002, 1.0)
"""Time constant [s] and damping ratio of contacts with pads.  The time constant is two
steps, and the damping is critical."""
GRIP_SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)
"""Impedance of contacts with pads.  With this impedance, an elliptic cone and impratio
100, pads hold a 45 mm cube of 0.1 kg while it is shaken.  With MuJoCo's defaults, the
pads drop this cube (description/README.md)."""
SPINNING, ROLLING = 0.005, 0.0001
"""Coefficients of spinning friction about the normal and of rolling friction [m], which
are MuJoCo's defaults."""
GRIP_CONDIM = 4
"""Contact dimension that includes sliding and spinning friction, since a pad touches
objects over an area."""
IMPRATIO = 100.0
MIMIC_SOLREF = (0.002, 1.0)
"""Time constant [s] and damping ratio of mimic joints.  The values are the stiffest
setting for a step of 1 ms.  With these values, mimic joints follow within the step,
loops stay closed, and passive joints do not move beyond their stops."""
MIMIC_SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)
STIFF_SOLIMP = (0.995, 0.999, 0.001, 0.5, 2.0)
"""Impedance of loops, of passive joints' stops and of prismatic mimic joints.  In these
constraints, forces of several hundred newtons act on links of a few grams.  With the
impedance of revolute mimic joints, loops would open by 1 mm at 235 N, and a sliding
finger of 38 g would lag by 0.5 mm at 130 N.  With ``STIFF_SOLIMP``, the corresponding
distances are 0.15 mm and 0.07 mm.  With a stiffer impedance, the closed pads of a
linkage vibrate."""

MESH_SUFFIXES = (".stl", ".obj", ".msh")
"""Suffixes of the mesh files that MuJoCo can read."""

VISUAL_GROUP, _COLLISION_GROUP = 2, 3  # the same groups as in mujoco_menagerie


def build_spec(
    model: RobotModel, *, dt: float, visuals: bool = False, ground: float | None = 0.0
) -> Any:  # MjSpec has no type annotations
    """Return a ``mujoco.MjSpec`` of the robot.

    Args:
        model: The robot.
        dt: Length of a step [s].
        visuals: Whether to add the visual meshes, which the physics does not use.
        ground: Height of the ground in the robot's root [m]; None means no ground.

    Raises:
        ModelError: If MuJoCo does not support the robot.
    """
    spec = mujoco.MjSpec()
    spec.modelname = model.name
    spec.compiler.degree = False
    spec.compiler.autolimits = True
    spec.option.timestep = dt
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = IMPRATIO
    # A diverged state must be reported, not silently reset.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    if ground is not None:
        spec.worldbody.add_geom(
            name=GROUND,
            pos=[0.0, 0.0, ground],
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 0.05],
            rgba=[0.85, 0.86, 0.88, 1.0],
        )
    bodies = moving_bodies(model)
    colliding = self_colliding(model, bodies)
    bases = {body.joint.parent for body in bodies if body.parent < 0}
    at_rest = []
    for name, frame in fixed_to_world(model):
        link, handle = model.link(name), spec.worldbody
        if link.collisions and (name in bases or not model.self_collide):
            handle = handle.add_body(name=body_at_rest(name))
            at_rest.append(link)
        _add_shapes(
            spec,
            handle,
            link,
            frame,
            visuals=visuals,
            is_colliding=name in colliding,
        )
    check_masses(model, bodies)
    handles: list[Any] = []
    for body in bodies:
        parent = spec.worldbody if body.parent < 0 else handles[body.parent]
        handle = _add_body(spec, parent, model, body)
        for name, frame in body.links:
            _add_shapes(
                spec,
                handle,
                model.link(name),
                frame,
                visuals=visuals,
                is_colliding=name in colliding,
            )
        handles.append(handle)
    for joint in model.movable_joints:
        _add_mimic(spec, joint)
    for loop in model.loops:
        _add_loop(spec, loop, bodies)
    for first, second in excluded_pairs(model, bodies, at_rest, colliding):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    return spec


def to_mjcf(model: RobotModel) -> str:
    """Return the robot as MJCF, with absolute paths of the visual meshes."""
    spec = build_spec(model, dt=0.001, visuals=True)
    compile_spec(spec)
    return str(spec.to_xml())


def compile_spec(spec: Any) -> Any:
    """Return the ``mujoco.MjModel`` of ``spec``, or raise ModelError."""
    try:
        return spec.compile()
    except ValueError as error:
        raise ModelError(f"MuJoCo rejects the robot: {error}") from error


def collision_name(link: Link, number: int) -> str:
    """Return the name of the geom for a link's collision shape."""
    return f"{link.name}/collision{number}"


def add_geom(spec: Any, handle: Any, shape: Collision | Visual, frame: Matrix) -> Any:
    """Add ``shape`` of a link at ``frame`` in the body ``handle``; return the geom.

    Raises:
        ModelError: If MuJoCo does not support the shape.
    """
    placed = frame @ pose_matrix(shape.origin)
    geom = handle.add_geom(pos=placed[:3, 3], quat=quat_wxyz(placed))
    geometry: Geometry = shape.geometry
    match geometry:
        case Box():
            geom.type = mujoco.mjtGeom.mjGEOM_BOX
            geom.size = [edge / 2.0 for edge in geometry.size]
        case Cylinder():
            geom.type = mujoco.mjtGeom.mjGEOM_CYLINDER
            geom.size = [geometry.radius, geometry.length / 2.0, 0.0]
        case Sphere():
            geom.type = mujoco.mjtGeom.mjGEOM_SPHERE
            geom.size = [geometry.radius, 0.0, 0.0]
        case Mesh():
            geom.type = mujoco.mjtGeom.mjGEOM_MESH
            geom.meshname = _add_mesh(spec, geometry)
    return geom


def quat_wxyz(frame: Matrix) -> Any:
    """Return the rotation of ``frame`` as a quaternion (w, x, y, z), shape (4,)."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(frame[:3, :3]).ravel())
    return quat


def _add_body(spec: Any, parent: Any, model: RobotModel, body: MovingBody) -> Any:
    joint, inertia = body.joint, body.inertia
    tensor = inertia.tensor
    handle = parent.add_body(
        name=joint.child,
        pos=body.placement[:3, 3],
        quat=quat_wxyz(body.placement),
        mass=inertia.mass,
        ipos=inertia.center,
        fullinertia=[*np.diag(tensor), *tensor[[0, 0, 1], [1, 2, 2]]],
        explicitinertial=True,
    )
    transmission = model.transmission_by_joint.get(joint.name)
    limits, force = joint.limits, joint.limits.effort
    bounded = np.isfinite([limits.lower, limits.upper]).all()
    hinge = handle.add_joint(
        name=joint.name,
        type=mujoco.mjtJoint.mjJNT_SLIDE
        if joint.type is JointType.PRISMATIC
        else mujoco.mjtJoint.mjJNT_HINGE,
        axis=joint.axis,
        range=[limits.lower, limits.upper] if bounded else [0.0, 0.0],
        limited=bool(bounded),
        frictionloss=joint.friction,
        armature=transmission.armature if transmission else 0.0,
    )
    # Coefficients of a polynomial in the speed.
    hinge.damping = [joint.damping, 0.0, 0.0]
    if joint.passive:  # the stops are stiff
        hinge.solref_limit, hinge.solimp_limit = MIMIC_SOLREF, STIFF_SOLIMP
    if joint.spring is not None:
        hinge.stiffness = [joint.spring.stiffness, 0.0, 0.0]
        hinge.springref = joint.spring.reference
    if transmission is not None:
        spec.add_actuator(
            name=joint.name,
            target=joint.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrllimited=bool(np.isfinite(force)),
            ctrlrange=[-force, force] if np.isfinite(force) else [0.0, 0.0],
        )
    return handle


def _add_loop(spec: Any, loop: LoopJoint, bodies: tuple[MovingBody, ...]) -> None:
    frames = {name: (body, frame) for body in bodies for name, frame in body.links}
    names = []
    for link, point in zip(loop.links, loop.points, strict=True):
        body, frame = frames[link]
        placed = frame @ [*point, 1.0]
        names.append(f"{loop.name}/{link}")
        handle = spec.body(body.joint.child)
        handle.add_site(name=names[-1], pos=placed[:3], group=4)
    spec.add_equality(
        name=loop.name,
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        name1=names[0],
        name2=names[1],
        solref=MIMIC_SOLREF,
        solimp=STIFF_SOLIMP,
    )


def _add_mimic(spec: Any, joint: Joint) -> None:
    if joint.mimic is None or joint.passive:
        return
    mimic = joint.mimic
    slides = joint.type is JointType.PRISMATIC
    equality = spec.add_equality(
        name=joint.name,
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=joint.name,
        name2=mimic.joint,
        solref=MIMIC_SOLREF,
        solimp=STIFF_SOLIMP if slides else MIMIC_SOLIMP,
    )
    polynomial = np.zeros_like(equality.data)
    polynomial[:2] = mimic.offset, mimic.multiplier
    equality.data = polynomial


def _add_shapes(
    spec: Any,
    handle: Any,
    link: Link,
    frame: Matrix,
    *,
    visuals: bool,
    is_colliding: bool,
) -> None:
    """Add the shapes of a link to a body.

    If the link collides with other links, its collision meshes are split into convex
    parts, since the hulls of links that are close together can overlap even if the
    meshes do not overlap.  If the link does not collide, its meshes are replaced by
    hulls.
    """
    in_parts = is_colliding and link.surface is None
    handle.add_site(name=link.name, pos=frame[:3, 3], quat=quat_wxyz(frame), group=4)
    for geom in _collision_geoms(spec, handle, link, frame, in_parts):
        geom.group = _COLLISION_GROUP
        geom.mass = 0.0
        if link.surface is not None:
            geom.condim, geom.priority = GRIP_CONDIM, 1
            geom.solref, geom.solimp = GRIP_SOLREF, GRIP_SOLIMP
            if link.surface.mu1 is not None:
                geom.friction = [link.surface.mu1, SPINNING, ROLLING]
    for number, visual in enumerate(link.visuals if visuals else ()):
        geom = add_geom(spec, handle, visual, frame)
        geom.name = f"{link.name}/visual{number}"
        geom.group = VISUAL_GROUP
        geom.mass = 0.0
        geom.contype = geom.conaffinity = 0
        if visual.rgba is not None:
            geom.rgba = visual.rgba


def _collision_geoms(
    spec: Any, handle: Any, link: Link, frame: Matrix, in_parts: bool
) -> Iterator[Any]:
    """Add and yield the geoms of a link's collision shapes."""
    for number, collision in enumerate(link.collisions):
        name, mesh = collision_name(link, number), collision.geometry
        parts: Sequence[Points] = ()
        if in_parts and isinstance(mesh, Mesh):
            _require_readable(mesh)
            parts = convex_parts(mesh)
        if len(parts) < 2:
            geom = add_geom(spec, handle, collision, frame)
            geom.name = name
            yield geom
            continue
        placed = frame @ pose_matrix(collision.origin)
        for k, points in enumerate(parts):
            spec.add_mesh(name=f"{name}.{k}", uservert=points.ravel())
            yield handle.add_geom(
                name=f"{name}.{k}",
                pos=placed[:3, 3],
                quat=quat_wxyz(placed),
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=f"{name}.{k}",
            )


def _require_readable(mesh: Mesh) -> None:
    if mesh.path.suffix.lower() not in MESH_SUFFIXES:
        raise ModelError(
            f"MuJoCo cannot read the mesh {mesh.path}; convert it to STL or OBJ"
        )


def _add_mesh(spec: Any, mesh: Mesh) -> str:
    _require_readable(mesh)
    name = f"{mesh.path}:{mesh.scale}"
    if spec.mesh(name) is None:
        spec.add_mesh(name=name, file=str(mesh.path), scale=mesh.scale)
    return name
