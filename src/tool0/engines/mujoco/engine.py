"""MuJoCo behind the Engine port."""

from __future__ import annotations

import itertools
import logging
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any, final

import mujoco
import numpy as np

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.transform import Vector3
from tool0.engines.mujoco.attachments import (
    Attachment,
    add_attachments,
    attachment_now,
    attachment_touches,
)
from tool0.engines.mujoco.contacts import (
    names_of_geoms,
    one_for_each_pair,
    read_contacts,
)
from tool0.engines.mujoco.model import build_spec
from tool0.engines.mujoco.object_states import ObjectStates
from tool0.engines.mujoco.objects import add_objects, compile_with, object_of
from tool0.engines.mujoco.succession import carry_over, read_meshes
from tool0.errors import ConfigError, DivergenceError, EngineError, ModelError
from tool0.hardware.engine import Contact, ObjectState
from tool0.hardware.joint_state import JointState, joint_selector

logger = logging.getLogger(__name__)

DEEP = 0.002
"""Overlap of two shapes that is worth a warning [m]."""


@final
class MujocoEngine:
    """One robot and its scene in MuJoCo, on the ground, with explicit Euler steps."""

    name = "mujoco"

    def __init__(
        self,
        model: RobotModel,
        dt: float = 0.001,
        ground: float | None = 0.0,
        scene: Scene | None = None,
    ) -> None:
        """Compile the robot and what is around it.

        Args:
            model: The robot.
            dt: Length of a step [s].
            ground: Height of the ground [m], in the robot's root; None for none.
            scene: The objects around it; None for none.
        """
        if not 0.0 < dt < math.inf:
            raise ConfigError(f"the step must be above 0 s and finite, got {dt}")
        if ground is not None and not math.isfinite(ground):
            raise ConfigError(f"the height of the ground must be finite, got {ground}")
        self._robot = model
        self._bare = build_spec(model, dt=dt, ground=ground)
        self._mesh_files: Mapping[str, bytes] = {}
        self._joint_names = tuple(joint.name for joint in model.movable_joints)
        self._dt = dt
        self._steps = 0
        self._contacts: tuple[int, tuple[Contact, ...]] = (0, ())
        """After how many steps they were read last, and what was read."""
        self._effort = [0.0] * len(self._joint_names)
        self._have(scene or Scene(), {})
        n = len(self._joint_names)
        compiled = tuple(self.model.joint(i).name for i in range(self.model.njnt))
        if compiled[:n] != self._joint_names:
            raise ModelError("MuJoCo reordered the joints; this mujoco is unsupported")
        # Packing plain floats costs a third of what assigning to the array does.
        self._pack = struct.Struct(f"{self.model.nu}d").pack_into
        self._motors = joint_selector(
            [
                self._joint_names.index(self.model.actuator(i).name)
                for i in range(self.model.nu)
            ]
        )

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self._joint_names

    @property
    def dt(self) -> float:
        return self._dt

    @property
    def gravity(self) -> Vector3:
        x, y, z = map(float, self.model.opt.gravity)
        return x, y, z

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        """Put joints at ``position`` [rad | m] and objects where they began."""
        if self._attached:
            self._have(self._scene, {})
        mujoco.mj_resetData(self.model, self.data)
        self._objects.put_back()
        self._position[:] = position
        self._effort = [0.0] * len(self._joint_names)
        self._steps = round(time / self._dt)
        self._contacts = (self._steps, ())
        self.data.time = time
        mujoco.mj_forward(self.model, self.data)
        self._warn_of_overlaps()

    def read(self) -> JointState:
        """Return the measured state, or raise DivergenceError."""
        position, velocity = self._position.tolist(), self._velocity.tolist()
        time = self._steps * self._dt
        if not math.isfinite(sum(velocity)):  # what makes a position so, too
            raise self._divergence(time)
        if self._has_more:
            del velocity[len(position) :]
        return JointState(time, position, velocity, self._effort)

    def write(self, effort: Sequence[float]) -> None:
        """Hold ``effort`` [N·m | N] until the next call, or raise DivergenceError."""
        held = list(effort)
        if not math.isfinite(sum(held)):  # MuJoCo would go limp, and only log it
            worst = next((i for i, u in enumerate(held) if not math.isfinite(u)), 0)
            name = self._joint_names[worst]
            raise DivergenceError(name, self._steps * self._dt, "effort")
        self._effort = held
        self._pack(self._ctrl, 0, *self._motors(held))

    def step(self) -> None:
        """Advance simulated time by ``dt``."""
        mujoco.mj_step(self.model, self.data)
        self._steps += 1

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return how the objects of the scene are now."""
        return self._objects.read()

    def spawn(self, item: SceneObject) -> None:
        """Put a further object into the scene, or raise ModelError or EngineError.

        The model is compiled anew, which takes about 2 ms.
        """
        if item.name in self._objects.names:
            raise EngineError(
                f"there is an object '{item.name}' already; "
                "remove it first, or take another name"
            )
        scene = Scene((*self._scene.objects, item), self._scene.locations)
        self._succeed(scene, self._attached)
        mujoco.mj_fwdPosition(self.model, self.data)  # changes no state
        self._warn_of_overlaps(of=item.name)

    def delete(self, name: str) -> None:
        """Take an object out of the scene, or raise EngineError."""
        self._objects.check_there(name)
        left = tuple(item for item in self._scene.objects if item.name != name)
        self._succeed(Scene(left, self._scene.locations), self._all_but(name))

    def place(self, state: ObjectState) -> None:
        """Put an object somewhere, moving so, or raise EngineError."""
        self.detach(state.name)
        self._objects.place(state)

    def contacts(self) -> tuple[Contact, ...]:
        """Return the forces of the last step's contacts, one item for each pair."""
        if self._contacts[0] != self._steps:
            model, data = self.model, self.data
            touches = itertools.chain(
                read_contacts(model, data, self._geom_names),
                attachment_touches(model, data, self._attached),
            )
            self._contacts = (self._steps, one_for_each_pair(touches))
        return self._contacts[1]

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link as it is now, or raise as the port says."""
        self._robot.link(link)
        self._objects.check_movable(name)
        if name in self._attached:
            raise EngineError(
                f"object '{name}' is attached to '{self._attached[name].link}' "
                "already; detach it first"
            )
        attachment = attachment_now(self.model, self.data, name, link)
        self._succeed(self._scene, {**self._attached, name: attachment})

    def detach(self, name: str) -> None:
        """Let an object go; one that is attached to nothing is left alone."""
        if name in self._attached:
            self._succeed(self._scene, self._all_but(name))

    def close(self) -> None:
        """Nothing to end: MuJoCo lives inside the process."""

    def _all_but(self, name: str) -> Mapping[str, Attachment]:
        return {other: it for other, it in self._attached.items() if other != name}

    def _have(self, scene: Scene, attached: Mapping[str, Attachment]) -> None:
        """Compile robot and scene, and look there from now on; or change nothing."""
        spec = self._bare.copy()
        add_objects(spec, self._robot, scene)
        add_attachments(spec, attached)
        files = read_meshes(spec, self._mesh_files)
        model = compile_with(spec, scene)
        self.model, self.data = model, mujoco.MjData(model)
        self._geom_names = names_of_geoms(model)
        self._mesh_files = files
        self._scene = scene
        self._attached = attached
        self._objects = ObjectStates(self.model, self.data, scene)
        # Views: the arrays of one MjData never move.  The robot's joints come first.
        n = len(self._joint_names)
        self._position = self.data.qpos[:n]
        self._velocity = self.data.qvel
        self._has_more = self.model.nv > n  # movable objects
        self._ctrl = memoryview(self.data.ctrl)

    def _succeed(self, scene: Scene, attached: Mapping[str, Attachment]) -> None:
        """Have another scene; everything that stays goes on as it was."""
        model, data, objects = self.model, self.data, self._objects
        self.contacts()  # those of the new model know nothing of the last step
        self._have(scene, attached)
        carry_over(model, data, self.model, self.data)
        self._objects.take_over(objects)

    def _warn_of_overlaps(self, of: str | None = None) -> None:
        """Tell which shapes are put into each other: they will be flung apart.

        Args:
            of: The object whose overlaps matter; None for any.
        """
        deepest: dict[tuple[str, str], float] = {}
        for contact in self.data.contact[: self.data.ncon]:
            if contact.dist < -DEEP:
                # What stands still was there first: the rest is put into it.
                geoms = [self.model.geom(int(geom)) for geom in contact.geom]
                geoms.sort(key=self._moves, reverse=True)
                first, second = (geom.name.partition("/")[0] for geom in geoms)
                depth = max(-contact.dist, deepest.get((first, second), 0.0))
                deepest[first, second] = depth
        for (first, second), depth in deepest.items():
            if of is not None and of not in (first, second):
                continue
            logger.warning(
                "the pose puts '%s' %.1f mm into '%s'; expect it to be pushed out",
                first,
                1000.0 * depth,
                second,
            )

    def _moves(self, geom: Any) -> tuple[bool, int]:  # a view of MjModel, untyped
        """Return what sorts shapes that move after those that stand still."""
        body = int(geom.bodyid[0])
        return bool(self.model.body_weldid[body]), body

    def _divergence(self, time: float) -> DivergenceError:
        n = len(self._joint_names)
        finite = np.isfinite(self._velocity)
        finite[:n] &= np.isfinite(self._position)
        joint = int(self.model.dof_jntid[int(np.argmin(finite))])
        name = self.model.joint(joint).name
        if joint < n:
            return DivergenceError(name, time)
        return DivergenceError(object_of(name), time, kind="object")
