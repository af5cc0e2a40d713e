"""The port to a physics engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, final

from tool0.hardware.joint_state import JointState


@final
@dataclass(frozen=True, slots=True)
class ObjectPose:
    """Where an object of the scene is, in the robot's root."""

    name: str
    position: tuple[float, float, float]
    """[m]"""
    quat_wxyz: tuple[float, float, float, float]


class Engine(Protocol):
    """Physics, as the control loop sees it: read, write, step, in that order.

    Every sequence has shape (n_joints,), ordered as ``joint_names``: all movable
    joints of the robot, mimic joints included.
    """

    @property
    def name(self) -> str:
        """What a person calls the engine: ``mujoco``, ``gazebo``."""

    @property
    def joint_names(self) -> tuple[str, ...]: ...

    @property
    def dt(self) -> float:
        """Length of one step [s]."""

    def reset(self, position: Sequence[float]) -> None:
        """Put the joints at ``position`` [rad | m], at rest, at time zero."""

    def read(self) -> JointState:
        """Return the measured state: a copy, never a view into the engine.

        Raises:
            DivergenceError: If the state is not finite.
        """

    def write(self, effort: Sequence[float]) -> None:
        """Hold ``effort`` [N·m | N] until the next call.

        Raises:
            DivergenceError: If it is not finite.
        """

    def step(self) -> None:
        """Advance simulated time by ``dt``."""

    def object_poses(self) -> tuple[ObjectPose, ...]:
        """Return where the objects of the scene are now, in the scene's order."""

    def close(self) -> None:
        """End the engine and what it started; closing twice is allowed."""
