"""A real robot without a network: its engine on reports that a test writes."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.engines.real_robot import engine as engine_module
from tool0.engines.real_robot.control_program import REGISTERS, ProgramMode
from tool0.engines.real_robot.engine import RealRobotEngine
from tool0.engines.real_robot.rtde_fields import EFFORTS, MOTION, STATUS
from tool0.protocol.control_box_state import (
    ControlBoxState,
    RobotMode,
    SafetyMode,
)
from tool0.simulation.arms.arm import Arm
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.core import Core
from tool0.simulation.setup import Setup

PERIOD = 0.008
PLAYING = 2
_SIZES = {
    **dict.fromkeys(("actual_q", "actual_qd", "actual_current", EFFORTS[1]), 6),
    **dict.fromkeys(("actual_TCP_pose", "actual_TCP_force", "tcp_offset"), 6),
    "payload_cog": 3,
}


class StillRobot:
    """The connection to a robot that stays where it is, one period a report."""

    rate = 1.0 / PERIOD

    def __init__(self) -> None:
        self.columns: dict[str, slice] = {}
        place = 0
        for name in (*MOTION, *STATUS, EFFORTS[1]):
            size = _SIZES.get(name, 1)
            self.columns[name] = slice(place, place + size)
            place += size
        self._values: list[Any] = [0.0] * place
        for name in STATUS:
            if name not in _SIZES:
                self._values[self.columns[name]] = [0]
        self.write("robot_mode", RobotMode.RUNNING.value)
        self.write("safety_mode", SafetyMode.NORMAL.value)
        self.write("runtime_state", PLAYING)
        self.write("target_speed_fraction", 1.0)
        self.write(REGISTERS[0], 1)
        self.write(REGISTERS[1], ProgramMode.RESTING)
        self.rtde = self
        self.version = (5, 16, 0)
        self.gripper = None
        self.link = SimpleNamespace(
            is_connected=True,
            brake=lambda: None,
            send_knots=lambda *_: None,
            disconnect=lambda: None,
        )

    def write(self, name: str, value: Any) -> None:
        """Change a number of the following reports."""
        self._values[self.columns[name]] = [value]

    def receive(self, timeout: float) -> list[tuple[Any, ...]]:
        """Return the report of the next period."""
        place = self.columns["timestamp"].start
        self._values[place] += PERIOD
        return [tuple(self._values)]

    def reconnected(self) -> None:
        """Return no new connection."""

    def close(self) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class StillRobotRig:
    """A core on such a robot, whose motion is enabled and whose controllers hold it."""

    core: Core
    engine: RealRobotEngine
    arm: Arm
    robot: StillRobot

    @property
    def state(self) -> ControlBoxState:
        """The state of the arm's control box."""
        return self.arm.box.state

    def ticks(self, n: int) -> None:
        """Execute n ticks."""
        for _ in range(n):
            self.core.tick()


def still_robot(patch: pytest.MonkeyPatch) -> StillRobotRig:
    """Return a robot whose motion is enabled."""
    robot = StillRobot()
    patch.setattr(engine_module, "RobotConnection", lambda *_, **__: robot)
    description = load_description(DescriptionConfig(arm="ur5e", gripper=None))
    options = {"address": "192.0.2.1"}
    simulation = SimulationConfig(engine="hardware", engine_options=options)
    setup = Setup.of(description, ControlConfig(), simulation)
    engine = setup.make_engine()
    assert isinstance(engine, RealRobotEngine)
    core = setup.make_core(engine)
    arm = core.arms.find(None)
    engine.set_enabled(True)
    core.arms.follow(engine.report, core.state)
    arm.play(core.state)
    rig = StillRobotRig(core, engine, arm, robot)
    rig.ticks(2)
    return rig
