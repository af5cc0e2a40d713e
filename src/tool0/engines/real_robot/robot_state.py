"""State of a real arm in each control period, even if packages are late or lost."""

from __future__ import annotations

import time
from collections import deque
from typing import Final, NamedTuple, final

from tool0.devices.rtde_client import Package, RtdeClient
from tool0.engines.real_robot.control_program import REGISTERS
from tool0.engines.real_robot.lateness import Lateness
from tool0.engines.real_robot.rtde_fields import EFFORTS, Fields
from tool0.errors import TransportError

LOST_AFTER: Final = 0.3
"""Time without a package after which the connection is considered lost [s].  TCP
repeats a lost segment within 0.2 s.  The arm stops earlier, because tool0's program
brings the arm to rest if it does not receive knots."""
OFFSETS: Final = 25
"""Number of periods over which the program's period is compared with the period of the
robot."""
_FIRST_PACKAGE: Final = 2.0
"""Longest wait for the first state [s]."""
MOST_GAP: Final = 1.0
"""Longest gap between packages that is filled with interpolated states [s].  A longer
gap is skipped."""


class ArmState(NamedTuple):
    """State of the arm's joints in one control period."""

    tick: int
    """Number of control periods since the start."""
    positions: tuple[float, ...]
    """Measured joint positions [rad]."""
    velocities: tuple[float, ...]
    """Measured joint velocities [rad/s]."""
    efforts: tuple[float, ...]
    """Torques of the joints [N·m]."""
    step: int
    """Period of tool0's program at this time; 0 if the program is not running."""


@final
class StateReader:
    """Reader that converts packages to one state for each control period.

    Periods follow the robot's clock.  Missing packages are counted, and the states of
    these packages are interpolated.  While no packages are received, the last state is
    repeated at the rate of the wall clock, so that requests are answered.  Only the
    thread of the tick may use the reader.
    """

    def __init__(self, client: RtdeClient, package: Package) -> None:
        """Start with the first package."""
        self.period = 1.0 / client.rate
        """Period of the robot's packages [s]."""
        self.is_connected = True
        """Whether packages are being received."""
        self.missing = 0
        """Number of periods without a package while the robot was connected."""
        self.newest = package
        """Newest package."""
        self.lateness = Lateness()
        """Measurement of the packages' lateness."""
        self._waiting: deque[ArmState] = deque()
        self._heard = time.monotonic()
        self._due = self._heard
        """Time at which the next repeated state is due while no packages are received
        [wall s]."""
        self._offset = 0
        """Difference between the robot's period number and the tick."""
        self._program_offsets: deque[int] = deque(maxlen=OFFSETS)
        """Recent differences between the period numbers of the robot and of tool0's
        program.  The program may write its period number some periods late, but never
        early."""
        self._last_step = 0
        self._use(client)
        self._offset = self._robot_period(package)
        self.state = self._state_of(package, 0)

    def _use(self, client: RtdeClient) -> None:
        self._client = client
        self.fields = Fields(client.columns)
        self._efforts = next(name for name in EFFORTS if name in client.columns)

    def reconnect(self, client: RtdeClient) -> None:
        """Continue with another connection."""
        self._use(client)
        self.is_connected = True
        self._heard = time.monotonic()

    def next(self) -> ArmState:
        """Wait for the next period, and return the state in this period."""
        while not self._waiting:
            if self.is_connected:
                self._receive(LOST_AFTER)
            else:
                self._due = max(self._due + self.period, time.monotonic() - LOST_AFTER)
                time.sleep(max(self._due - time.monotonic(), 0.0))
                still = (0.0,) * len(self.state.positions)
                repeated = self.state._replace(
                    tick=self.state.tick + 1, velocities=still, step=0
                )
                self._waiting.append(repeated)
        self.state = self._waiting.popleft()
        return self.state

    def _receive(self, timeout: float) -> None:
        try:
            packages = self._client.receive(timeout)
        except TransportError:
            packages = []
            self.is_connected = False
        if packages:
            self._heard = time.monotonic()
            newest: float = self.fields.number(packages[-1], "timestamp")
            self.lateness.observe(newest, self._heard)
            for package in packages:
                self._add(package)
        elif not self.is_connected or time.monotonic() - self._heard >= LOST_AFTER:
            self.is_connected = False
            self._due = time.monotonic()

    def _add(self, package: Package) -> None:
        last = self._waiting[-1] if self._waiting else self.state
        tick = self._robot_period(package) - self._offset
        gap = tick - last.tick
        if gap * self.period > MOST_GAP or gap < -MOST_GAP / self.period:
            # The robot was restarted, or was disconnected for a long time.
            self._offset += gap - 1
            tick, gap = last.tick + 1, 1
        if gap <= 0:
            return  # the state of this period has already been repeated
        state = self._state_of(package, tick)
        self.newest = package
        self.missing += gap - 1
        for k in range(1, gap):
            part = k / gap
            self._waiting.append(
                state._replace(
                    tick=last.tick + k,
                    positions=_between(last.positions, state.positions, part),
                    velocities=_between(last.velocities, state.velocities, part),
                    step=state.step - (gap - k) if state.step else 0,
                )
            )
        self._waiting.append(state)

    def _state_of(self, package: Package, tick: int) -> ArmState:
        fields = self.fields
        step = int(fields.number(package, REGISTERS[0]))
        if step:
            if step < self._last_step:  # the program was started again
                self._program_offsets.clear()
            self._last_step = step
            self._program_offsets.append(tick - step)
            step = tick - min(self._program_offsets)
        else:
            self._program_offsets.clear()
        return ArmState(
            tick,
            fields.vector(package, "actual_q"),
            fields.vector(package, "actual_qd"),
            fields.vector(package, self._efforts),
            step,
        )

    def _robot_period(self, package: Package) -> int:
        time: float = self.fields.number(package, "timestamp")
        return round(time / self.period)


def first_package(client: RtdeClient) -> Package:
    """Wait for a package.

    Raises:
        TransportError: If no package arrives.
    """
    packages = client.receive(_FIRST_PACKAGE)
    if not packages:
        raise TransportError(f"{client.peer} sends no states; is the robot booting?")
    return packages[-1]


def _between(
    a: tuple[float, ...], b: tuple[float, ...], part: float
) -> tuple[float, ...]:
    return tuple(x + part * (y - x) for x, y in zip(a, b, strict=True))
