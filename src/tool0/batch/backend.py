"""Interface of the backends that simulate the copies of a batch on a CPU or a GPU."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Indices
from tool0.description.drive_limits import DriveLimits
from tool0.description.scene import SceneObject
from tool0.description.shapes import resized
from tool0.errors import ConfigError, ControlError, EngineUnavailableError
from tool0.kernel.memory import IntArray
from tool0.kernel.motions import JointGoal
from tool0.kinematics.chain import Array

if TYPE_CHECKING:
    from tool0.batch.copy_sensor import CopySensor
    from tool0.batch.saved import SavedCopy
    from tool0.engines.mujoco.contact_arrays import ContactArrays
    from tool0.engines.mujoco.copies import ObjectArrays
    from tool0.simulation.executor import Executor

ObjectField = Literal["mass", "friction", "size"]
"""Field of a ``SceneObject`` that may differ between copies; ``size`` is the size of
the object's geometry."""

Names = frozenset[str]
"""Names of links and objects; ``ground`` is also valid."""

CPU = "cpu"
_DEVICE = re.compile(r"cpu|cuda(:\d+)?|warp:cpu")


class DeviceArrays(NamedTuple):
    """State of n copies in the memory of the computing device.

    The fields are Warp arrays in single precision; ``torch.from_dlpack`` and similar
    functions share their memory.  Do not write to the arrays; they change as time
    advances.
    """

    position: Any
    """Joint positions [rad | m], shape (n, n_joints), in the order of
    ``Batch.joint_names``."""
    velocity: Any
    """Joint velocities [rad/s | m/s], shape (n, n_joints)."""
    effort: Any
    """Efforts that the drives applied in the last step [N·m | N], (n, n_joints)."""
    object_position: Any
    """Positions of the m movable objects in the root frame [m], shape (n, m, 3)."""
    object_quat: Any
    """Orientations of the objects in the root frame (w, x, y, z), shape (n, m, 4)."""
    object_linear: Any
    """Linear velocities of the objects in the root's axes [m/s], shape (n, m, 3)."""
    object_angular: Any
    """Angular velocities of the objects, each in the object's own axes [rad/s], shape
    (n, m, 3)."""
    diverged: Any
    """1 for each copy that stopped because its physics failed, and 0 for the others;
    int32, shape (n,)."""


class BatchBackend(Protocol):
    """n copies of a robot and its scene; callers must check the arguments first.

    Arrays have one row per copy.  In methods with the argument ``rows``, arrays have
    one row per entry of ``rows``.
    """

    @property
    def time(self) -> Array:
        """Simulated time since the last reset of each copy [s]."""

    @property
    def has_diverged(self) -> NDArray[np.bool_]:
        """Whether each copy's physics has failed since its last ``reset``."""

    def step(self, ticks: int, rows: Indices) -> None:
        """Advance these copies, except those that have diverged."""

    def reset(self, rows: Indices, starts: Mapping[str, Array]) -> None:
        """Reset copies to their initial states.

        ``starts`` replaces the initial positions of the joints that it contains [rad |
        m].
        """

    def save(self) -> Sequence[SavedCopy]:
        """Return the state of each copy.

        Raises:
            ControlError: If a copy cannot be saved.
        """

    def restore(self, rows: Indices, saved: Sequence[SavedCopy]) -> None:
        """Restore saved states of copies, one per row.

        Raises:
            Tool0Error: If the robot, the objects or the controllers of a state differ
                from those of the batch.
        """

    def states(self) -> tuple[Array, Array, Array]:
        """Return positions, velocities and efforts, each of shape (n, n_joints)."""

    def arrays(self) -> DeviceArrays:
        """Return the state in the memory of the computing device.

        Raise ControlError if the copies are on the CPU.
        """

    def objects(self) -> ObjectArrays:
        """Return the poses and velocities of the objects."""

    def pad_forces(self, pads: Sequence[str]) -> Array:
        """Return the normal force on each pad in the last step [N], (n, n_pads)."""

    def wrenches(self, links: frozenset[str], at: str) -> Array:
        """Return the wrench that other bodies exert on links [N, N·m], shape (n, 6).

        The wrench is the sum over the contacts in the last step.  The wrench is
        expressed at the origin and in the axes of the link ``at``.
        """

    def contacts(self, first: Names | None, second: Names | None) -> ContactArrays:
        """Return the contacts between ``first`` and ``second``; None means any body.

        Raises:
            ControlError: If the copies are on a GPU.
        """

    def are_touching(self, first: Names, second: Names | None) -> NDArray[np.bool_]:
        """Return for each copy whether ``first`` and ``second`` touch.

        If ``second`` is None, return whether ``first`` touches any body.
        """

    def start_sensor(self, sensor: CopySensor) -> None:
        """Take a sample in all copies now, and more samples whenever they are due."""

    def stop_sensor(self, sensor: CopySensor) -> None:
        """Stop the sampling of a sensor."""

    def place(self, rows: Indices, name: str, position: Array, quat: Array) -> None:
        """Place an object at rest.

        Raises:
            ControlError: If the object cannot be placed.
        """

    def change(
        self, rows: Indices, name: str, field: ObjectField, values: Array
    ) -> None:
        """Change a field of an object, as if it had been created with the new values.

        Args:
            rows: The copies.
            name: The object.
            field: The field.
            values: Values of the field, shape (len(rows),), or (len(rows), k) for k
                sizes.

        Raises:
            ControlError: If the copies are on a GPU, which cannot change this field.
        """

    def executor(self, i: int) -> Executor:
        """Return the executor of one copy after updating its core.

        Raises:
            ControlError: If the copies are not on the CPU.
        """

    def start(
        self,
        rows: Indices,
        controller: int,
        joints: IntArray,
        *,
        times: Array,
        positions: Array,
        velocities: Array | None,
        lifts_limits: bool,
    ) -> bool:
        """Start motions of r copies through points.

        Return False if the motions can be started only in Python.

        Args:
            rows: The copies.
            controller: Number of the controller among the running controllers.
            joints: Numbers of the k joints that move, counted within the controller.
            times: Times of the points, relative to now [s], shape (r, m).
            positions: Positions [rad | m], shape (r, m, k).
            velocities: Velocities [rad/s | m/s], shape (r, m, k); None for linear
                interpolation.
            lifts_limits: Whether the drives may still have the limits of a gripper's
                goal, which this motion removes.

        Raises:
            GoalRejectedError: If the joints cannot make this motion, in which case the
                copies are unchanged.
        """

    def holds(self, array: object) -> bool:
        """Return whether ``command`` can use an array without a copy to the host."""

    def command(
        self,
        rows: Indices,
        goals: Mapping[int, Sequence[JointGoal]],
        positions: object,
        velocities: object | None,
        duration: float,
    ) -> None:
        """Start motions to positions that are given as arrays on the device.

        Args:
            rows: The copies.
            goals: Goals of the joints that move, by the index of the running
                controller.
            positions: Positions [rad | m], shape (n, k).
            velocities: Velocities [rad/s | m/s], shape (n, k); None for linear
                interpolation.
            duration: Duration of the motion [s].

        Raises:
            ControlError: If an array is not in single precision, or the copies are on
                the CPU.
        """

    def grip(
        self,
        rows: Indices,
        controller: int,
        joint: int,
        openings: object,
        limits: Sequence[DriveLimits],
    ) -> bool:
        """Move a gripper along ``direct_path``; return False if this requires Python.

        Args:
            rows: The copies, of which there must be at least one.
            controller: Number of the controller among the running controllers.
            joint: The number of the gripper's joint in the controller.
            openings: Openings [m], shape (n,), as an array that may be on the device.
            limits: Limits of speed and force, one entry per row.
        """

    def drive(
        self,
        rows: Indices,
        controller: int,
        targets: Sequence[float],
        effort: float | None,
        limits: Sequence[DriveLimits],
    ) -> bool:
        """Start goals of a GripperActionController.

        Return False if the goals can be started only in Python.

        Args:
            rows: The copies, of which there must be at least one.
            controller: Number of the controller among the running controllers.
            targets: Targets of the controller's joint, within its limits, one per row
                [rad | m].
            effort: Largest effort of the controller's joint [N·m | N]; None for the
                controller's default.
            limits: Limits of speed and force, one entry per row.
        """


def changed_object(item: SceneObject, field: ObjectField, value: Any) -> SceneObject:
    """Return a copy of an object with a new value for one field.

    Raises:
        ConfigError: If the object cannot have that value.
    """
    if field == "size":
        numbers = (value,) if isinstance(value, float) else value
        return replace(item, geometry=resized(item.geometry, numbers))
    changes: dict[str, Any] = {field: value}
    return replace(item, **changes)


def needs_cpu(what: str, device: str) -> ControlError:
    """Return the error for a feature ``what`` that only the CPU supports."""
    return ControlError(f"{what} works with device='cpu' only; this is '{device}'")


def needs_gpu(what: str) -> ControlError:
    """Return the error for a feature ``what`` that only a Warp device supports."""
    return ControlError(f"{what} works on a GPU only, with device='cuda'")


def checked_device(device: str, threads: int | None) -> str:
    """Return ``device`` after checking it and ``threads``.

    Raises:
        EngineUnavailableError: If the device needs MuJoCo Warp, which is not installed.
    """
    if not isinstance(device, str) or not _DEVICE.fullmatch(device):
        raise ConfigError(
            f"unknown device {device!r}; valid: 'cpu', 'cuda', 'cuda:0', 'cuda:1' …, "
            "'warp:cpu'"
        )
    if device != CPU:
        if threads is not None:
            raise ConfigError("threads are those of device='cpu'; leave them out")
        try:
            import tool0.engines.mujoco.warp_worlds  # noqa: F401
        except ModuleNotFoundError as error:
            if error.name not in {"warp", "mujoco_warp"}:
                raise
            raise EngineUnavailableError(
                f"device '{device}' needs MuJoCo Warp, which is not installed: "
                "pip install '.[gpu]'"
            ) from None
    return device
