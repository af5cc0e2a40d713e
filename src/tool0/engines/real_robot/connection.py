"""Connections to a robot: RTDE, dashboard server, gripper, and tool0's program."""

from __future__ import annotations

import contextlib
import logging
import threading
from typing import Final, final

from tool0.devices.dashboard_client import PORT as DASHBOARD_PORT
from tool0.devices.dashboard_client import DashboardClient
from tool0.devices.gripper_links import (
    URCAP_PORT,
    GripperLink,
    ModbusLink,
    ModbusRtu,
    ModbusTcp,
    UrcapLink,
)
from tool0.devices.polled_gripper import PolledGripper
from tool0.devices.rtde_client import RtdeClient
from tool0.devices.rtde_packets import PORT as RTDE_PORT
from tool0.devices.scripts import PORT as SCRIPT_PORT
from tool0.devices.scripts import send_script
from tool0.engines.real_robot.motion_link import MotionLink
from tool0.engines.real_robot.options import RealRobotOptions
from tool0.engines.real_robot.rtde_fields import EFFORTS, INPUTS, MOTION, STATUS
from tool0.errors import ConfigError, TransportError

logger = logging.getLogger(__name__)

RETRY: Final = 0.5
"""Pause between attempts to reconnect [s]."""


@final
class RobotConnection:
    """Connections to one robot; the RTDE connection is reopened after a loss."""

    def __init__(self, options: RealRobotOptions, *, has_gripper: bool) -> None:
        """Connect to the robot for reading only.

        Raises:
            TransportError: If the robot cannot be reached.
            ConfigError: If an option is invalid.
        """
        self.options = options
        base = options.port_base
        self.host: Final = options.address
        self.rtde = self._connected()
        self.dashboard = DashboardClient(self.host, base + DASHBOARD_PORT)
        local = self.rtde.local_address
        with contextlib.ExitStack() as failed:
            failed.callback(self.rtde.close)
            self.link = MotionLink(local, options.callback_port)
            failed.callback(self.link.close)
            self.gripper = self._gripper(has_gripper=has_gripper)
            failed.pop_all()
        self._again: RtdeClient | None = None
        self._lost = threading.Event()
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=self._reconnect, name="tool0 reconnect", daemon=True
        )
        self._thread.start()

    def _connected(self) -> RtdeClient:
        client = RtdeClient(
            self.host,
            self.options.port_base + RTDE_PORT,
            outputs=(*MOTION, *STATUS, EFFORTS[1]),
            optional=EFFORTS[:1],
            inputs=INPUTS,
        )
        client.start()
        return client

    def _gripper(self, *, has_gripper: bool) -> PolledGripper | None:
        kind, _, place = self.options.gripper.partition(":")
        if not has_gripper or kind == "none":
            return None
        host, base = self.host, self.options.port_base

        def connect() -> GripperLink:
            if kind == "modbus":
                at, _, port = place.partition(":")
                return ModbusLink(ModbusTcp(at or host, int(port or 502)))
            if kind == "rtu":
                return ModbusLink(ModbusRtu(place))
            return UrcapLink(host, base + URCAP_PORT)

        if kind == "rtu" and not place:
            raise ConfigError("Modbus RTU needs a serial port: rtu:/dev/ttyUSB0")
        return PolledGripper(connect, "gripper")

    def run_beside(self, name: str, *lines: str) -> None:
        """Execute statements on the controller in parallel with the running program.

        Raises:
            TransportError: If the robot cannot be reached.
        """
        body = "\n".join(f"  {line}" for line in lines)
        self.send(f"sec tool0_{name}():\n{body}\nend\n")

    def send(self, script: str) -> None:
        """Send a program to the controller of the robot."""
        send_script(self.host, script, self.options.port_base + SCRIPT_PORT)

    def note_loss(self) -> None:
        """Reopen RTDE in another thread; ``reconnected`` returns the new client."""
        self._lost.set()

    def reconnected(self) -> RtdeClient | None:
        """Return a new connection once; otherwise, return None."""
        client, self._again = self._again, None
        if client is not None:
            self.rtde = client
        return client

    def _reconnect(self) -> None:
        while not self._closing.is_set():
            self._lost.wait()
            if self._closing.is_set():
                return
            self.rtde.close()
            try:
                self._again = self._connected()
            except TransportError as error:
                logger.debug("not connected again: %s", error)
                self._closing.wait(RETRY)
            else:
                self._lost.clear()

    def close(self) -> None:
        """Stop the arm, and close all connections."""
        self._closing.set()
        self._lost.set()
        self.link.end()
        self.link.close()
        if self.gripper is not None:
            self.gripper.close()
        self.dashboard.close()
        self._thread.join()
        self.rtde.close()
        if self._again is not None:
            self._again.close()
