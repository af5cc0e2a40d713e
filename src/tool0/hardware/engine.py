"""The port to a physics engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, final

from tool0.description.scene import SceneObject
from tool0.description.transform import Vector3
from tool0.hardware.joint_state import JointState


@final
@dataclass(frozen=True, slots=True)
class ObjectState:
    """Where an object of the scene is and how it moves, in the robot's root."""

    name: str
    position: tuple[float, float, float]
    """[m]"""
    quat_wxyz: tuple[float, float, float, float]
    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity of its origin [m/s]."""
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """[rad/s]"""


@final
@dataclass(frozen=True, slots=True)
class Contact:
    """What one thing does to another where they touch: all their points as one.

    Links and objects go by their names, also links that are fixed to others; the
    engine's own ground is ``ground``.  Vectors are in the axes of the robot's root.
    """

    first: str
    second: str
    point: tuple[float, float, float]
    """Where, on average, weighted by how hard the points press [m]."""
    force: tuple[float, float, float]
    """That ``first`` exerts on ``second`` [N]."""
    torque: tuple[float, float, float]
    """That it exerts beside that, about ``point`` [N·m]."""


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

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall [m/s²], in the axes of the robot's root."""

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        """Put joints at ``position`` [rad | m], at rest, and objects where they began.

        Simulated time is ``time`` [s] then.
        """

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

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return how the objects of the scene are now.

        In the scene's order: what was spawned comes last.
        """

    def spawn(self, item: SceneObject) -> None:
        """Put a further object into the scene, at rest; what moves goes on moving.

        If it is refused, nothing has changed.

        Raises:
            ModelError: If the engine cannot have such an object.
            EngineError: If the name is taken, or the engine refuses.
        """

    def delete(self, name: str) -> None:
        """Take an object out of the scene, or raise EngineError if there is none."""

    def place(self, state: ObjectState) -> None:
        """Put an object somewhere, moving so; its quaternion has length one.

        A reset puts it back where it was spawned, or began.

        Raises:
            EngineError: If there is none, or it stands still and is to move.
        """

    def contacts(self) -> tuple[Contact, ...]:
        """Return the forces of the last step's contacts, one item for each pair.

        What is attached counts as touched by what it is attached to.  None before the
        first step after a reset.  An engine may begin to look with the first call,
        which then returns none.
        """

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link as it is now, until it is detached.

        No hand does so: this is for who asks to cheat (``--grasp-assist``).  A reset,
        a deletion and a placement detach it.

        Raises:
            ModelError: If there is no such link.
            EngineError: If there is no such object, it stands still, or it is
                attached already.
        """

    def detach(self, name: str) -> None:
        """Let an object go; one that is attached to nothing is left alone."""

    def close(self) -> None:
        """End the engine and what it started; closing twice is allowed."""
