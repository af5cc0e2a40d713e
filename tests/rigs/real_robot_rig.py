"""A real robot for tests: tool0's own UR controller, in another process."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Any

import pytest
from link_proxy import LinkProxy, link_proxy
from pendant import Pendant, pendant
from ros import Bringup
from ur_address import free_host
from ur_rig import DashboardLines
from waits import until

import tool0
from tool0.api.control_box import ControlBox
from tool0.protocol.control_box_state import ControlBoxState
from tool0.simulation.config import SimulationConfig

CB3_ARMS = ("ur3", "ur5", "ur10")
PORTS = (29999, 30001, 30004, 63352)


@dataclass(frozen=True)
class RealRobotRig:
    """tool0 with its "real" robot, and the network between them."""

    robot: tool0.Robot
    host: str
    """Where the robot is, without the proxy."""
    simulated: Bringup
    proxy: LinkProxy
    pendant: Pendant
    """Only an e-Series has one."""

    @property
    def box(self) -> ControlBox:
        """The control box of the arm."""
        return self.robot.arm.control_box

    @property
    def state(self) -> ControlBoxState:
        """What is known of it now."""
        return self.robot.snapshot.control_boxes[0]

    def enable(self, speed: float = 1.0) -> None:
        """Let the robot move, at a part of its speed."""
        link = self.state.link
        assert link is not None
        self.box.enable_motion(link.serial_number)
        self.box.set_speed_slider(speed)
        until(lambda: self.state.speed_scaling == speed, "the speed slider")

    def twin(self) -> tool0.Robot:
        """Return a connection to the simulated robot behind the controller."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("XDG_RUNTIME_DIR", self.simulated.runtime_folder)
            return tool0.connect()

    def dashboard(self) -> DashboardLines:
        """Return another client's connection to the dashboard server."""
        return DashboardLines(socket.create_connection((self.host, 29999), 20.0))


@contextmanager
def real_robot(arm: str = "ur5", *words: str, **options: Any) -> Iterator[RealRobotRig]:
    """Bring up a robot's controller, and tool0 on it, which only reads at first.

    Args:
        arm: One of ``CB3_ARMS`` has 125 periods a second, others 500.
        words: Further ones of the controller's command line.
        options: Of tool0's bring-up.
    """
    host, near = free_host(), free_host()
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    routes = {(near, number): (host, number) for number in PORTS}
    routes[near, port] = ("127.0.0.1", port)
    usual = ("--ur-active-gripper", "--dt", "0.002")  # half of the processor time
    command = ("--ur", *usual, "--arm", arm, "--ur-host", host)
    with (
        closing(Bringup(os.environ, *command, *words)) as simulated,
        pendant(host) as its_pendant,
    ):
        simulated.wait()
        if arm not in CB3_ARMS:
            routes[near, 29999] = its_pendant.address
        engine = {"callback_host": near, "callback_port": port}
        simulation = SimulationConfig(engine_options=engine)
        with (
            link_proxy(routes) as proxy,
            tool0.bringup(
                arm=arm, hardware=near, simulation=simulation, **options
            ) as robot,
        ):
            yield RealRobotRig(robot, host, simulated, proxy, its_pendant)
