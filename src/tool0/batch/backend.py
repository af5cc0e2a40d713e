"""The backends that simulate the copies of a batch: CPU and GPU."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Indices
from tool0.description.drive_limits import DriveLimits
from tool0.errors import ConfigError, ControlError, EngineUnavailableError
from tool0.kinematics.chain import Array

if TYPE_CHECKING:
    from tool0.batch.copies import SavedCopy
    from tool0.engines.mujoco.copies import ObjectArrays
    from tool0.simulation.core import Core
    from tool0.simulation.executor import Executor

CPU = "cpu"
_DEVICE = re.compile(r"cpu|cuda(:\d+)?|warp:cpu")


class BatchBackend(Protocol):
    """n copies of a robot and its scene; arguments have been checked.

    Arrays have one row per copy, or one per row of ``rows`` where a method has these.
    """

    @property
    def time(self) -> Array:
        """Simulated time of each copy since its reset [s]."""

    @property
    def has_diverged(self) -> NDArray[np.bool_]:
        """Copies whose physics failed, until ``reset``."""

    def step(self, ticks: int, rows: Indices) -> None:
        """Advance these copies, but for those that have diverged."""

    def reset(self, rows: Indices, starts: Mapping[str, Array]) -> None:
        """Reset copies, at the initial pose changed by ``starts`` [rad | m]."""

    def save(self) -> Sequence[SavedCopy]:
        """Return the state of each copy; ControlError if one cannot be saved."""

    def restore(self, rows: Indices, saved: Sequence[SavedCopy]) -> None:
        """Let copies continue with saved states, one per row.

        Raises:
            Tool0Error: If one is of another robot, other objects or controllers.
        """

    def states(self) -> tuple[Array, Array, Array]:
        """Return positions, velocities and efforts, each of shape (n, n_joints)."""

    def objects(self) -> ObjectArrays:
        """Return poses and velocities of the objects."""

    def pad_forces(self, pads: Sequence[str]) -> Array:
        """Return the normal force on each pad in the last step [N], (n, n_pads)."""

    def wrenches(self, links: frozenset[str], at: str) -> Array:
        """Return force [N] and torque [N·m] on links by contacts with others, (n, 6).

        They act at the origin of the link ``at``, in its axes, in the last step.
        """

    def place(self, rows: Indices, name: str, position: Array, quat: Array) -> None:
        """Place an object, at rest; ControlError if that is impossible."""

    def executor(self, i: int) -> Executor:
        """Return what moves one copy, whose core is up to date.

        Raises:
            ControlError: If this is no CPU.
        """

    def observed(self, i: int) -> Core:
        """Return the core of one copy, up to date, only to read it.

        It raises as ``executor``.
        """

    def desired(self, rows: Indices, controller: int, joint: int) -> Array | None:
        """Return the desired positions of a joint [rad | m]; None if only Python can.

        ``controller`` and ``joint`` are their numbers, among the running controllers
        and in the controller.
        """

    def start(
        self,
        rows: Indices,
        controller: int,
        joints: Sequence[int],
        *,
        times: Array,
        positions: Array,
        velocities: Array | None,
        lifts_limits: bool,
    ) -> bool:
        """Start motions of r copies to points; return False if only Python can.

        Args:
            rows: The copies.
            controller: Its number among the running controllers.
            joints: The k of its joints that move, by number.
            times: Of the points after now [s], shape (r, m).
            positions: [rad | m], shape (r, m, k).
            velocities: [rad/s | m/s], the same shape; None makes linear motions.
            lifts_limits: Whether the drives of the joints may have limits of a goal,
                which end.

        Raises:
            GoalRejectedError: If no joint can move so; nothing has changed.
        """

    def set_drive_limits(
        self, rows: Indices, joint: int, limits: Sequence[DriveLimits]
    ) -> None:
        """Limit the drive of a joint, by its number, after its motion has started."""


def needs_cpu(what: str, device: str) -> ControlError:
    """Return the error for something that only the CPU can do."""
    return ControlError(f"{what} works with device='cpu' only; this is '{device}'")


def checked_device(device: str, threads: int | None) -> str:
    """Return ``device``, or raise ConfigError if it is unknown or needs no threads.

    Raises:
        EngineUnavailableError: If MuJoCo Warp is needed and not installed.
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
