"""What a URScript program needs of the robot: a ``Box`` and its ``Moves``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from tool0.hardware.control_box import ControlBoxState
from tool0.interfaces.ur.messages import Messages
from tool0.interfaces.ur.registers import Registers
from tool0.kinematics.chain import ArmChain
from tool0.requests.table import Request
from tool0.requests.updates import ArmUpdate, Six

if TYPE_CHECKING:
    from tool0.interfaces.ur.robotiq.gripper import RobotiqGripper

R = TypeVar("R")


class Slot(Protocol):
    """The state of the program, which clients can pause."""

    @property
    def is_paused(self) -> bool: ...

    def pause(self) -> None: ...

    async def gate(self) -> None: ...


class Robot(Protocol):
    """A control box, as programs see it.  Poses are in UR's base frame."""

    arm: str
    chain: ArmChain
    rate: float
    arm_update: ArmUpdate
    state: ControlBoxState
    registers: Registers
    messages: Messages
    gripper: RobotiqGripper | None
    when_updated: set[Callable[[], None]]

    @property
    def programs(self) -> Slot: ...

    @property
    def time(self) -> float: ...

    @property
    def q(self) -> Six: ...

    @property
    def qd(self) -> Six: ...

    @property
    def effort(self) -> Six: ...

    @property
    def tcp(self) -> Six: ...

    def tcp_pose(self, *, target: bool = False) -> Six: ...

    def tcp_speed(self, *, target: bool = False) -> Six: ...

    def tcp_wrench(self) -> Six: ...

    def forward(
        self, q: Sequence[float], tcp: Sequence[float] | None = None
    ) -> Six: ...

    def inverse(
        self,
        pose: Sequence[float],
        near: Sequence[float] | None = None,
        tcp: Sequence[float] | None = None,
    ) -> Six: ...

    async def next_update(self) -> None: ...

    async def sleep(self, duration: float) -> None: ...

    async def call(self, request: Request[R]) -> R: ...

    def send(self, request: Request[Any]) -> None: ...


class Mover(Protocol):
    """Moves of the arm, as URScript's functions of the same names describe them."""

    async def movej(
        self, q: Sequence[float], a: float, v: float, t: float, r: float
    ) -> None: ...

    async def movel(
        self, pose: Sequence[float], a: float, v: float, t: float, r: float
    ) -> None: ...

    async def movep(
        self, pose: Sequence[float], a: float, v: float, r: float
    ) -> None: ...

    async def movec(
        self,
        pose_via: Sequence[float],
        pose_to: Sequence[float],
        a: float,
        v: float,
        r: float,
        mode: int,
    ) -> None: ...

    async def servoj(
        self, q: Sequence[float], t: float, lookahead_time: float, gain: float
    ) -> None: ...

    async def servoc(
        self, pose: Sequence[float], a: float, v: float, r: float
    ) -> None: ...

    async def speedj(self, qd: Sequence[float], a: float, t: float | None) -> None: ...

    async def speedl(
        self, xd: Sequence[float], a: float, t: float | None, a_rot: float | None
    ) -> None: ...

    async def stopj(self, a: float) -> None: ...

    async def stopl(self, a: float, a_rot: float | None) -> None: ...
