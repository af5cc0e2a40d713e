"""Engine that simulates the robot's joints in MuJoCo."""

from __future__ import annotations

import copy
import logging
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from tool0.description.model import RobotModel
from tool0.description.scene import Scene
from tool0.engines.mujoco.library import address_of, mujoco_library, variable_of
from tool0.engines.mujoco.model import build_spec
from tool0.engines.mujoco.world import MujocoWorld, SavedWorld
from tool0.errors import ConfigError, DivergenceError, ModelError
from tool0.hardware.engine import (
    BRAKE_STANDSTILL,
    JointState,
    NativeStepper,
    check_dt,
    effort_divergence,
    fastest,
    has_diverged,
    joint_selector,
)

logger = logging.getLogger(__name__)

_BRAKE_SOLREF = (0.002, 1.0)
"""Time constant [s] and damping ratio of a brake's friction.  The values are the
stiffest setting for steps of 1 ms."""
_BRAKE_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of a brake's friction.  The impedance is MuJoCo's maximum, since a brake
does not yield."""
_BRAKE_MOBILITY = 1000.0
"""Upper bound on the product of a joint's mobility and its brake's torque [rad/s²].
MuJoCo scales the yielding of friction by this mobility.  With this bound, a brake that
exerts its full torque creeps at no more than 1e-4 rad/s, regardless of the joint's
inertia without load."""
_MOST_FRICTION = 1e6
"""Dry friction of the brake of a drive without effort limit [N·m | N]."""


def _log_warning(message: str) -> None:
    """Log a warning from MuJoCo.

    Without this function, MuJoCo would write warnings to a file in the working
    directory.
    """
    logger.debug("MuJoCo: %s", message)


@final
@dataclass(frozen=True, slots=True)
class SavedEngine:
    """State of an engine at one instant, including the contacts of the last step."""

    data: Any
    """Copy of the engine's ``MjData`` that is never stepped."""
    steps: int
    effort: tuple[float, ...]
    world: SavedWorld


@final
class MujocoEngine:
    """An ``Engine`` that runs MuJoCo with explicit Euler steps."""

    name = "mujoco"
    has_rotors = True
    stepper: NativeStepper | None

    def __init__(
        self,
        model: RobotModel,
        dt: float = 0.001,
        ground: float | None = 0.0,
        scene: Scene | None = None,
    ) -> None:
        """Compile the robot and its scene for steps of ``dt`` [s].

        ``ground`` is the height of the ground in the robot's root [m]; None means no
        ground.
        """
        check_dt(dt)
        # Without a handler, MuJoCo would write warnings to a file.
        if mujoco.get_mju_user_warning() is None:
            mujoco.set_mju_user_warning(_log_warning)
        if ground is not None and not math.isfinite(ground):
            raise ConfigError(f"the height of the ground must be finite, got {ground}")
        self.joint_names = tuple(joint.name for joint in model.movable_joints)
        self.dt = dt
        self._steps = 0
        n = len(self.joint_names)
        self._effort = [0.0] * n
        self._brakes: Mapping[int, float] = {}
        self._rotors: Mapping[int, float] = {}
        robot_spec = build_spec(model, dt=dt, ground=ground)
        self.world = MujocoWorld(
            model, robot_spec, scene or Scene(), ground=ground, on_compiled=self._use
        )
        compiled = tuple(self.model.joint(i).name for i in range(self.model.njnt))
        if compiled[:n] != self.joint_names:
            raise ModelError("MuJoCo reordered the joints; this mujoco is unsupported")
        # Packing plain floats takes a third of the time that an assignment to the array
        # takes.
        self._pack = struct.Struct(f"{self.model.nu}d").pack_into
        self._motors = joint_selector(self.motor_joints())

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        self.world.reset(position, time)
        self._effort = [0.0] * len(self.joint_names)
        self._steps = round(time / self.dt)

    def saved(self) -> SavedEngine:
        """Return the current state."""
        data = copy.copy(self.data)
        return SavedEngine(data, self._steps, tuple(self._effort), self.world.saved())

    def check_saved(self, saved: SavedEngine) -> None:
        """Raise EngineError if a state is that of another robot or of other objects."""
        self.world.check_saved(saved.world, saved.data)

    def resume(self, saved: SavedEngine) -> None:
        """Continue bit-identically from a saved state of the same robot and objects."""
        self.world.resume(saved.world, saved.data)
        self._steps, self._effort = saved.steps, list(saved.effort)

    def read(self) -> JointState:
        position, velocity = self._position.tolist(), self._velocity.tolist()
        time = self._steps * self.dt
        # If the velocity diverges, the position diverges too.
        if has_diverged(velocity):
            raise self._divergence(time, fastest(velocity))
        if self._has_objects:
            del velocity[len(position) :]
        return JointState(time, position, velocity, self._effort)

    def write(self, effort: Sequence[float]) -> None:
        held = list(effort)
        if not math.isfinite(sum(held)):  # MuJoCo would only log this error
            raise effort_divergence(self.joint_names, held, self._steps * self.dt)
        self._effort = held
        self._pack(self._ctrl, 0, *self._motors(held))

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        self._brakes = torques
        self._engage_brakes()

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        self._rotors = inertias
        self._add_rotors()

    def step(self) -> None:
        if self._braked.size:
            self._step_with_brakes()
        else:
            mujoco.mj_step(self.model, self.data)
        self._steps += 1

    def _step_with_brakes(self) -> None:
        braked = self._braked
        before = self._position[braked]
        mujoco.mj_step(self.model, self.data)
        stands = np.abs(self._velocity[braked]) < BRAKE_STANDSTILL
        self._position[braked[stands]] = before[stands]
        self._velocity[braked[stands]] = 0.0

    def close(self) -> None:
        """Do nothing: MuJoCo runs inside the process."""

    def _use(self, model: Any, data: Any) -> None:
        """Replace the compiled model and its data."""
        self.model, self.data = model, data
        # These arrays are views, since the arrays of one MjData never move in memory.
        # The robot's joints come first.
        n = len(self.joint_names)
        self._position = data.qpos[:n]
        self._velocity = data.qvel
        self._has_objects = model.nv > n  # movable objects
        self._ctrl = memoryview(data.ctrl)
        of_model = (
            model.dof_frictionloss,
            model.dof_solref,
            model.dof_solimp,
            model.dof_invweight0,
        )
        self._friction = tuple(values[:n].copy() for values in of_model)
        self._armature = model.dof_armature[:n].copy()
        self._add_rotors()
        self._engage_brakes()

    def _engage_brakes(self) -> None:
        """Add the friction of the brakes to the friction of the joints."""
        model, n = self.model, len(self.joint_names)
        friction, solref, solimp, mobility = self._friction
        model.dof_frictionloss[:n], model.dof_invweight0[:n] = friction, mobility
        model.dof_solref[:n], model.dof_solimp[:n] = solref, solimp
        for joint, torque in self._brakes.items():
            if not torque:
                continue
            model.dof_frictionloss[joint] += min(torque, _MOST_FRICTION)
            model.dof_solref[joint] = _BRAKE_SOLREF
            model.dof_solimp[joint] = _BRAKE_SOLIMP
            model.dof_invweight0[joint] = min(mobility[joint], _BRAKE_MOBILITY / torque)
        self._braked = np.array(sorted(self._brakes), dtype=np.intp)
        self.stepper = self._stepper()

    def _add_rotors(self) -> None:
        """Increase the armatures in the model by the rotor inertias that were set."""
        armature = self.model.dof_armature
        armature[: len(self._armature)] = self._armature
        for joint, inertia in self._rotors.items():
            armature[joint] += inertia

    def motor_joints(self) -> tuple[int, ...]:
        """Return the joint number of each motor."""
        names = (self.model.actuator(i).name for i in range(self.model.nu))
        return tuple(map(self.joint_names.index, names))

    def _stepper(self) -> NativeStepper | None:
        """Return the data with which compiled code steps the current model."""
        library = mujoco_library()
        if library is None:
            return None

        def note_steps(steps: int, effort: list[float]) -> None:
            self._steps, self._effort = steps, effort

        model, data = self.model, self.data
        return NativeStepper(
            step=address_of(library.mj_step),
            on_error=variable_of(library, "mju_user_error"),
            clock=variable_of(library, "mjcb_time"),
            model=model._address,
            data=data._address,
            position=data.qpos.ctypes.data,
            velocity=data.qvel.ctypes.data,
            n_velocities=model.nv,
            motors=data.ctrl.ctypes.data,
            motor_joints=self.motor_joints(),
            brakes=tuple(self._brakes),
            steps=lambda: self._steps,
            note_steps=note_steps,
        )

    def _divergence(self, time: float, dof: int) -> DivergenceError:
        joint = int(self.model.dof_jntid[dof])
        name = self.model.joint(joint).name
        if joint < len(self.joint_names):
            return DivergenceError(name, time)
        return DivergenceError(name.partition("/")[0], time, kind="object")
