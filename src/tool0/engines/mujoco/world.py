"""Objects, attachments and contact forces around the robot in MuJoCo."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np
from numpy.typing import NDArray

from tool0.description.flat_frames import rotate
from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import Contact, ObjectState
from tool0.description.shapes import kind_of
from tool0.description.transform import Quaternion, Vector3
from tool0.engines.mujoco.model import MIMIC_SOLIMP, MIMIC_SOLREF
from tool0.engines.mujoco.objects import (
    ObjectStates,
    change_body,
    change_friction,
    compile_with_scene,
    free_joint_name,
)
from tool0.errors import EngineError
from tool0.hardware.engine import (
    Wrench,
    check_attachable,
    check_new_name,
    check_placement,
    find_object,
    immovable,
)

logger = logging.getLogger(__name__)

OVERLAP_WARNING = 0.002
"""Penetration depth of two shapes above which a warning is logged [m]."""


@final
@dataclass(frozen=True, slots=True)
class SavedWorld:
    """The part of a world's state that is not in ``MjData``."""

    objects: Mapping[str, SceneObject]
    """Objects by name, with their sizes, masses and friction coefficients."""
    static: Mapping[str, ObjectState]
    contacts: tuple[float, tuple[Contact, ...]]


@final
class MujocoWorld:
    """A ``World`` that contains the compiled model of robot and scene, and the data.

    Objects and attachments are part of the model.  When an object or attachment is
    added or removed, the model is compiled again (about 2 ms) and the state is
    transferred.
    """

    def __init__(
        self,
        robot: RobotModel,
        robot_spec: Any,
        scene: Scene,
        *,
        ground: float | None,
        on_compiled: Callable[[Any, Any], None],
    ) -> None:
        """Compile robot and scene.

        ``robot_spec`` is the ``MjSpec`` of the robot, including the ground at height
        ``ground`` [m]; None means no ground.  ``on_compiled`` is called with each new
        ``MjModel`` and ``MjData``.
        """
        self.ground = ground
        self._robot = robot
        self._robot_spec = robot_spec
        self._n_joints = len(robot.movable_joints)
        self._on_compiled = on_compiled
        self._scene = scene
        self._mesh_files: Mapping[str, bytes] = {}
        self._contacts: tuple[float, tuple[Contact, ...]] = (0.0, ())
        """Simulated time at which contacts were last read [s], and the contacts at this
        time."""
        self._compile(scene, {})

    @property
    def gravity(self) -> Vector3:
        x, y, z = map(float, self._model.opt.gravity)
        return x, y, z

    @property
    def data(self) -> Any:
        """The ``MjData`` of robot and scene, valid until the next compilation."""
        return self._data

    @property
    def has_no_contact(self) -> bool:
        """Whether contacts are impossible, since no step followed the last reset."""
        return self._contacts == (self._data.time, ())

    def reset(self, position: Sequence[float], time: float) -> None:
        """Move joints to ``position`` [rad | m] and objects to their start poses."""
        if self._attached:
            self._compile(self._scene, {})
        mujoco.mj_resetData(self._model, self._data)
        self.states.reset()
        self._data.qpos[: self._n_joints] = position
        self._data.time = time
        self._contacts = (time, ())
        mujoco.mj_forward(self._model, self._data)
        self._warn_of_overlaps()

    def object_states(self) -> Sequence[ObjectState]:
        return self.states.record()

    def spawn(self, item: SceneObject) -> None:
        check_new_name(self._objects, item.name)
        scene = Scene((*self._scene.objects, item), self._scene.locations)
        self._recompile(scene, self._attached)
        # This call does not change the state.
        mujoco.mj_fwdPosition(self._model, self._data)
        self._warn_of_overlaps(of=item.name)

    def delete(self, name: str) -> None:
        find_object(self._objects, name)
        left = tuple(item for item in self._scene.objects if item.name != name)
        self._recompile(Scene(left, self._scene.locations), self._attached_but(name))

    def place(self, state: ObjectState) -> None:
        self.detach(state.name)
        check_placement(self._objects, state)
        self.states.place(state)

    def change(self, item: SceneObject) -> None:
        """Set the size, mass and friction of an object to those of ``item``.

        The other properties of ``item`` must be those of the object, and its shape must
        be of the same kind.

        The resulting model is bit-identical to a model that was compiled with ``item``.
        """
        old = find_object(self._objects, item.name)
        self._objects[item.name] = item
        scene = Scene(tuple(self._objects.values()), self._scene.locations)
        if (item.mass, item.geometry) != (old.mass, old.geometry):
            change_body(self._model, item, scene, self._mesh_files)
        if item.friction != old.friction:
            change_friction(self._model, self._robot, item, scene)
        self._scene = scene

    def saved(self) -> SavedWorld:
        """Return the part of the state that is not in ``MjData``.

        Raises:
            EngineError: If an object is attached to a link.
        """
        for name, attachment in self._attached.items():
            raise EngineError(
                f"object '{name}' is attached to '{attachment.link}'; detach it first"
            )
        return SavedWorld(dict(self._objects), self.states.static, self._contacts)

    def check_saved(self, saved: SavedWorld, data: Any) -> None:
        """Raise EngineError if a state is that of another robot or of other objects."""
        shapes = [
            {name: kind_of(item.geometry) for name, item in objects.items()}
            for objects in (saved.objects, self._objects)
        ]
        if shapes[0] != shapes[1] or self._data.qpos.shape != data.qpos.shape:
            raise EngineError(
                "the saved state is of another robot or of other objects: "
                f"{', '.join(saved.objects) or 'none'}; here are "
                f"{', '.join(self._objects) or 'none'}"
            )

    def resume(self, saved: SavedWorld, data: Any) -> None:
        """Continue from a saved state and the corresponding ``MjData``."""
        for name in self._attached:
            self.detach(name)
        for item in saved.objects.values():
            self.change(item)
        mujoco.mj_copyData(self._data, self._model, data)
        self.states.resume_static(saved.static)
        self._contacts = saved.contacts

    def normal_forces(self, links: Sequence[str]) -> list[float]:
        """Return the sum of the normal forces on each link in the last step [N]."""
        contacts = self._data.contact
        rows = contacts.efc_address
        if not (rows >= 0).any():
            return [0.0] * len(links)
        forces = np.where(rows >= 0, self._data.efc_force[rows], 0.0)
        geoms = contacts.geom
        return [float(forces @ self._is_of(link)[geoms].any(axis=1)) for link in links]

    def wrench_on(self, links: frozenset[str], at: str) -> tuple[float, ...]:
        """Return the force [N] and torque [N·m] of external contacts on ``links``.

        The wrench is that of the last step; it refers to the origin of the link ``at``
        and is in the axes of that link.
        """
        data, contacts = self._data, self._data.contact
        is_inside = self.are_of(links)[contacts.geom]
        rows = np.flatnonzero(is_inside[:, 0] != is_inside[:, 1])
        if not rows.size:
            return (0.0,) * 6
        found = np.empty((len(rows), 6))
        for number, wrench in zip(rows.tolist(), found, strict=True):
            mujoco.mj_contactForce(self._model, data, number, wrench)
        # The wrenches act on the second shape and are in the axes of the contact.
        found[is_inside[rows, 0]] *= -1.0
        site = data.site(at)
        R_world_tool = site.xmat.reshape(3, 3)
        R_contact_world = contacts.frame[rows].reshape(-1, 3, 3)
        R_tool_contact = R_world_tool.T @ R_contact_world.swapaxes(1, 2)
        force = (R_tool_contact @ found[:, :3, None])[..., 0]
        torque = (R_tool_contact @ found[:, 3:, None])[..., 0]
        x, y, z = ((contacts.pos[rows] - site.xpos) @ R_world_tool).T
        fx, fy, fz = force.T
        torque += np.stack([y * fz - z * fy, z * fx - x * fz, x * fy - y * fx], axis=1)
        return (*force.sum(axis=0).tolist(), *torque.sum(axis=0).tolist())

    def _is_of(self, link: str) -> NDArray[np.bool_]:
        """Return for each geom whether it belongs to ``link``."""
        return self.are_of(frozenset((link,)))

    def are_of(self, links: frozenset[str]) -> NDArray[np.bool_]:
        """Return for each geom whether it belongs to one of the links or objects."""
        if links not in self._masks:
            owners = self.geom_owners
            self._masks[links] = np.array([owner in links for owner in owners])
        return self._masks[links]

    def contacts(self) -> tuple[Contact, ...]:
        model, data = self._model, self._data
        if self._contacts[0] != data.time:
            points = itertools.chain(
                contact_points(model, data, self.geom_owners),
                attachment_points(model, data, self._attached),
            )
            self._contacts = (data.time, merge_by_pair(points))
        return self._contacts[1]

    def is_touched(self, links: frozenset[str]) -> bool:
        data = self._data
        if self._attached and any(
            item.link in links for item in self._attached.values()
        ):
            return True
        return bool(data.ncon) and bool(self.are_of(links)[data.contact.geom].any())

    def center_of_mass(self, name: str) -> Vector3:
        body = self._body(name)
        # Before this call, the frames are those of the previous step.
        mujoco.mj_kinematics(self._model, self._data)
        return _vector(self._data.xipos[body])

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        bodies = {name: self._body(name) for name in wrenches}
        applied = self._data.xfrc_applied
        applied[:] = 0.0
        for name, (force, torque) in wrenches.items():
            applied[bodies[name]] += (*force, *torque)

    def _body(self, name: str) -> int:
        """Return the number of the body that contains a link or object."""
        if name in self._robot.link_by_name:
            body = int(self._model.site(name).bodyid[0])
        else:
            find_object(self._objects, name)
            body = self._model.body(name).id
        if self._model.body_weldid[body] == 0:
            raise immovable(name)
        return body

    def attach(self, name: str, link: str) -> None:
        self._robot.link(link)
        check_attachable(self._objects, name)
        if name in self._attached:
            link = self._attached[name].link
            raise EngineError(
                f"object '{name}' is already attached to '{link}'; detach it first"
            )
        attachment = attachment_now(self._model, self._data, name, link)
        self._recompile(self._scene, {**self._attached, name: attachment})

    def detach(self, name: str) -> None:
        if name in self._attached:
            self._recompile(self._scene, self._attached_but(name))

    def _attached_but(self, name: str) -> Mapping[str, Attachment]:
        return {other: it for other, it in self._attached.items() if other != name}

    def _compile(self, scene: Scene, attached: Mapping[str, Attachment]) -> None:
        """Compile and use robot and scene, or raise ModelError without changes."""
        spec = self._robot_spec.copy()
        add_attachments(spec, attached)
        model, files = compile_with_scene(spec, self._robot, scene, self._mesh_files)
        self._model, self._data = model, mujoco.MjData(model)
        self._mesh_files = files
        self._scene = scene
        self._objects: dict[str, SceneObject] = {
            item.name: item for item in scene.objects
        }
        self._attached = attached
        self.geom_owners = geom_owners(model)
        """Name of the link or object of each geom, by the geom's number."""
        self._masks: dict[frozenset[str], NDArray[np.bool_]] = {}
        self.states = ObjectStates(model, self._data, scene)
        self._on_compiled(model, self._data)

    def _recompile(self, scene: Scene, attached: Mapping[str, Attachment]) -> None:
        """Use another scene; items that are in both scenes keep their exact state."""
        model, data, states = self._model, self._data, self.states
        self.contacts()  # the new data does not contain the contacts of the last step
        self._compile(scene, attached)
        _transfer_state(model, data, self._model, self._data)
        self.states.resume_static(states.static)

    def _warn_of_overlaps(self, of: str | None = None) -> None:
        """Log a warning for each overlap, or only for those of the object ``of``."""
        deepest: dict[tuple[str, str], float] = {}
        contacts = self._data.contact
        for i in np.flatnonzero(contacts.dist < -OVERLAP_WARNING).tolist():
            contact = contacts[i]
            # The message states the moving body first and the static body second.
            geoms = [self._model.geom(int(geom)) for geom in contact.geom]
            geoms.sort(key=self._mobility, reverse=True)
            first, second = (self.geom_owners[geom.id] for geom in geoms)
            depth = max(-contact.dist, deepest.get((first, second), 0.0))
            deepest[first, second] = depth
        for (first, second), depth in deepest.items():
            if of in (None, first, second):
                logger.warning(
                    "the pose puts '%s' %.1f mm into '%s'; expect it to be pushed out",
                    first,
                    1000.0 * depth,
                    second,
                )

    def _mobility(self, geom: Any) -> tuple[bool, int]:
        """Return a key that sorts moving shapes after static shapes."""
        body = int(geom.bodyid[0])
        return bool(self._model.body_weldid[body]), body


def _transfer_state(
    old_model: Any, old_data: Any, new_model: Any, new_data: Any
) -> None:
    """Copy the state of joints and bodies that are in both models.

    The solver's warm start is also copied, so that later steps are identical.
    """
    new_data.time = old_data.time
    # Only the robot has controls and activations.
    new_data.ctrl[:], new_data.act[:] = old_data.ctrl, old_data.act
    for name in _joint_names(old_model) & _joint_names(new_model):
        before, after = old_data.joint(name), new_data.joint(name)
        after.qpos[:], after.qvel[:] = before.qpos, before.qvel
        after.qacc_warmstart[:] = before.qacc_warmstart
        after.qfrc_applied[:] = before.qfrc_applied
    for name in _body_names(old_model) & _body_names(new_model):
        new_data.body(name).xfrc_applied[:] = old_data.body(name).xfrc_applied


def _joint_names(model: Any) -> set[str]:
    return {model.joint(i).name for i in range(model.njnt)}


def _body_names(model: Any) -> set[str]:
    return {model.body(i).name for i in range(model.nbody)}


ContactPoint = tuple[Vector3, float, Vector3, Vector3]
"""Position of a contact point, weight of the point in the mean, and force and torque at
the point."""
MIN_WEIGHT = 1e-12
"""Smallest weight of a contact point [N].  With this weight, the mean is also defined
if all forces are zero."""


@final
@dataclass(frozen=True, slots=True)
class Attachment:
    """Pose of an object that is fixed to a link."""

    link: str
    body: str
    """Name of the MuJoCo body that contains the link."""
    position: Vector3
    """Position of the object in the body [m]."""
    quat_wxyz: Quaternion


def attachment_now(model: Any, data: Any, name: str, link: str) -> Attachment:
    """Return the attachment of the object ``name`` to ``link`` at the current pose."""
    # Before this call, the frames are those before the last step.
    mujoco.mj_kinematics(model, data)
    body = int(model.site(link).bodyid[0])
    item = data.body(name)
    inverse, inverse_quat = np.zeros(3), np.zeros(4)
    mujoco.mju_negPose(inverse, inverse_quat, data.xpos[body], data.xquat[body])
    position, quat = np.zeros(3), np.zeros(4)
    mujoco.mju_mulPose(position, quat, inverse, inverse_quat, item.xpos, item.xquat)
    x, y, z = position.tolist()
    qw, qx, qy, qz = quat.tolist()
    return Attachment(link, model.body(body).name, (x, y, z), (qw, qx, qy, qz))


def add_attachments(spec: Any, attachments: Mapping[str, Attachment]) -> None:
    """Add a weld for each attached object, with the stiffness of mimic joints."""
    for name, attachment in attachments.items():
        weld = spec.add_equality(
            name=_weld_name(name),
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=attachment.body,
            name2=name,
            solref=MIMIC_SOLREF,
            solimp=MIMIC_SOLIMP,
        )
        # The data consists of the anchor in the object, the pose of the object in the
        # body, and the weight of rotation [m].
        data = np.zeros_like(weld.data)
        data[3:11] = *attachment.position, *attachment.quat_wxyz, 1.0
        weld.data = data


def attachment_points(
    model: Any, data: Any, attachments: Mapping[str, Attachment]
) -> Iterator[tuple[tuple[str, str], ContactPoint]]:
    """Yield the wrench of each link on its attached object, at the object's origin.

    The wrench is that of the last step.  The wrench is computed from the generalized
    forces of the object's free joint, which are a force in the world's axes and a
    torque in the object's axes.
    """
    for name, attachment in attachments.items():
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        rows &= data.efc_id == model.equality(_weld_name(name)).id
        effort = np.zeros(model.nv)
        mujoco.mj_mulJacTVec(model, data, effort, np.where(rows, data.efc_force, 0.0))
        start = int(model.joint(free_joint_name(name)).dofadr[0])
        force, torque = effort[start : start + 3], effort[start + 3 : start + 6]
        item = data.body(name)
        weight = max(float(np.linalg.norm(force)), MIN_WEIGHT)
        torque = item.xmat.reshape(3, 3) @ torque
        yield (
            (attachment.link, name),
            (_vector(item.xpos), weight, _vector(force), _vector(torque)),
        )


def _weld_name(name: str) -> str:
    return f"{name}/attachment"  # object names do not contain slashes


def geom_owners(model: Any) -> tuple[str, ...]:
    """Return the name of the link or object of each geom, by the geom's number."""
    return tuple(model.geom(i).name.partition("/")[0] for i in range(model.ngeom))


def contact_points(
    model: Any, data: Any, owners: Sequence[str]
) -> Iterator[tuple[tuple[str, str], ContactPoint]]:
    """Yield pairs in contact, and the wrench of the first item on the second item.

    After ``mj_step``, ``data`` still contains the contacts and forces of that step;
    only position and velocity are newer.  Plain floats are used, because they are
    faster and a force-torque sensor reads the contacts up to 1000 times per second.
    ``owners`` contains the link or object of each geom.
    """
    contacts = data.contact
    wrench = np.zeros(6)
    for i, ((one, two), frame, (x, y, z)) in enumerate(
        zip(
            contacts.geom.tolist(),
            contacts.frame.tolist(),
            contacts.pos.tolist(),
            strict=True,
        )
    ):
        mujoco.mj_contactForce(model, data, i, wrench)
        # The wrench is in the frame of the contact.  The frame's x axis points from the
        # first shape to the second shape, and a positive force pushes the second shape
        # away.
        fx, fy, fz, tx, ty, tz = wrench.tolist()
        if fx:
            force, torque = rotate(frame, (fx, fy, fz)), rotate(frame, (tx, ty, tz))
            yield (owners[one], owners[two]), ((x, y, z), fx, force, torque)


def merge_by_pair(
    points: Iterable[tuple[tuple[str, str], ContactPoint]],
) -> tuple[Contact, ...]:
    """Return one contact per pair; points of (a, b) and (b, a) are merged."""
    found: dict[tuple[str, str], list[ContactPoint]] = {}
    for pair, point in points:
        if pair[::-1] in found:
            position, weight, (fx, fy, fz), (tx, ty, tz) = point
            reversed_ = position, weight, (-fx, -fy, -fz), (-tx, -ty, -tz)
            found[pair[::-1]].append(reversed_)
        else:
            found.setdefault(pair, []).append(point)
    return tuple(_resultant(*pair, merged) for pair, merged in found.items())


def _resultant(first: str, second: str, points: list[ContactPoint]) -> Contact:
    total = sum(weight for _, weight, _, _ in points)
    px = sum(weight * x for (x, _, _), weight, _, _ in points) / total
    py = sum(weight * y for (_, y, _), weight, _, _ in points) / total
    pz = sum(weight * z for (_, _, z), weight, _, _ in points) / total
    fx = fy = fz = tx = ty = tz = 0.0
    for (x, y, z), _, (ax, ay, az), (bx, by, bz) in points:
        rx, ry, rz = x - px, y - py, z - pz
        fx, fy, fz = fx + ax, fy + ay, fz + az
        tx += bx + ry * az - rz * ay
        ty += by + rz * ax - rx * az
        tz += bz + rx * ay - ry * ax
    return Contact(first, second, (px, py, pz), (fx, fy, fz), (tx, ty, tz))


def _vector(values: Any) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
