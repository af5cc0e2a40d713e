"""The objects around the robot in MuJoCo: states, spawning, attachments, contacts."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

import mujoco

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.transform import Vector3
from tool0.engines.checks import (
    check_attachable,
    check_new_name,
    check_placement,
    find_object,
)
from tool0.engines.mujoco.contacts import (
    Attachment,
    add_attachments,
    attachment_now,
    attachment_points,
    contact_points,
    geom_owners,
    merge_by_pair,
)
from tool0.engines.mujoco.objects import ObjectStates, compile_with_scene
from tool0.errors import EngineError
from tool0.hardware.engine import Contact, ObjectState

logger = logging.getLogger(__name__)

OVERLAP_WARNING = 0.002
"""Overlap of two shapes from which on a warning is logged [m]."""


@final
class MujocoWorld:
    """Owns the compiled model of robot and scene, and its data.

    Objects and attachments are part of the model.  When one comes or goes the model is
    compiled again, which takes about 2 ms, and the state is transferred.
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

        ``robot_spec`` is the robot's ``MjSpec``, with the ground at height ``ground``
        [m] or without.  ``on_compiled`` gets each new ``MjModel`` and ``MjData``.
        """
        self.ground = ground
        self._robot = robot
        self._robot_spec = robot_spec
        self._n_joints = len(robot.movable_joints)
        self._on_compiled = on_compiled
        self._mesh_files: Mapping[str, bytes] = {}
        self._contacts: tuple[float, tuple[Contact, ...]] = (0.0, ())
        """Simulated time at which contacts were last read [s], and those contacts."""
        self._compile(scene, {})

    @property
    def gravity(self) -> Vector3:
        x, y, z = map(float, self._model.opt.gravity)
        return x, y, z

    def reset(self, position: Sequence[float], time: float) -> None:
        """Put joints at ``position`` [rad | m] and objects where they began."""
        if self._attached:
            self._compile(self._scene, {})
        mujoco.mj_resetData(self._model, self._data)
        self._states.reset()
        self._data.qpos[: self._n_joints] = position
        self._data.time = time
        self._contacts = (time, ())
        mujoco.mj_forward(self._model, self._data)
        self._warn_of_overlaps()

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return the current state of each object."""
        return self._states.read()

    def spawn(self, item: SceneObject) -> None:
        """Add an object, or raise ModelError or EngineError."""
        check_new_name(self._objects, item.name)
        scene = Scene((*self._scene.objects, item), self._scene.locations)
        self._recompile(scene, self._attached)
        mujoco.mj_fwdPosition(self._model, self._data)  # changes no state
        self._warn_of_overlaps(of=item.name)

    def delete(self, name: str) -> None:
        """Remove an object, or raise EngineError."""
        find_object(self._objects, name)
        left = tuple(item for item in self._scene.objects if item.name != name)
        self._recompile(Scene(left, self._scene.locations), self._attached_but(name))

    def place(self, state: ObjectState) -> None:
        """Set an object's pose and velocity, or raise EngineError."""
        self.detach(state.name)
        check_placement(self._objects, state)
        self._states.place(state)

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts of the last step, one item for each pair."""
        model, data = self._model, self._data
        if self._contacts[0] != data.time:
            points = itertools.chain(
                contact_points(model, data, self._geom_owners),
                attachment_points(model, data, self._attached),
            )
            self._contacts = (data.time, merge_by_pair(points))
        return self._contacts[1]

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link, or raise ModelError or EngineError."""
        self._robot.link(link)
        check_attachable(self._objects, name)
        if name in self._attached:
            link = self._attached[name].link
            raise EngineError(
                f"object '{name}' is attached to '{link}' already; detach it first"
            )
        attachment = attachment_now(self._model, self._data, name, link)
        self._recompile(self._scene, {**self._attached, name: attachment})

    def detach(self, name: str) -> None:
        """Release an object; one that is not attached is left alone."""
        if name in self._attached:
            self._recompile(self._scene, self._attached_but(name))

    def _attached_but(self, name: str) -> Mapping[str, Attachment]:
        return {other: it for other, it in self._attached.items() if other != name}

    def _compile(self, scene: Scene, attached: Mapping[str, Attachment]) -> None:
        """Compile and use robot and scene; change nothing if MuJoCo refuses."""
        spec = self._robot_spec.copy()
        add_attachments(spec, attached)
        model, files = compile_with_scene(spec, self._robot, scene, self._mesh_files)
        self._model, self._data = model, mujoco.MjData(model)
        self._mesh_files = files
        self._scene = scene
        self._objects = {item.name: item for item in scene.objects}
        self._attached = attached
        self._geom_owners = geom_owners(model)
        self._states = ObjectStates(model, self._data, scene)
        self._on_compiled(model, self._data)

    def _recompile(self, scene: Scene, attached: Mapping[str, Attachment]) -> None:
        """Use another scene; everything that is in both keeps its state, bit by bit."""
        model, data, states = self._model, self._data, self._states
        self.contacts()  # the new data has no contacts of the last step
        self._compile(scene, attached)
        _transfer_state(model, data, self._model, self._data)
        self._states.copy_static_poses(states)

    def _warn_of_overlaps(self, of: str | None = None) -> None:
        """Log a warning for each overlap, of the object ``of`` if it is given."""
        deepest: dict[tuple[str, str], float] = {}
        for contact in self._data.contact[: self._data.ncon]:
            if contact.dist < -OVERLAP_WARNING:
                # The moving body is named first, the static one second.
                geoms = [self._model.geom(int(geom)) for geom in contact.geom]
                geoms.sort(key=self._mobility, reverse=True)
                first, second = (self._geom_owners[geom.id] for geom in geoms)
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
        """Return a key that sorts moving shapes after static ones."""
        body = int(geom.bodyid[0])
        return bool(self._model.body_weldid[body]), body


def _transfer_state(
    old_model: Any, old_data: Any, new_model: Any, new_data: Any
) -> None:
    """Copy the state of joints and bodies that are in both models.

    That includes the solver's warm start, so that later steps are identical.
    """
    new_data.time = old_data.time
    new_data.ctrl[:], new_data.act[:] = old_data.ctrl, old_data.act  # the robot's only
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
