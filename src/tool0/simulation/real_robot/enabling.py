"""Enables a real arm's motion after checking the conditions."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from typing import Final, final

import numpy as np

from tool0.description.payload_bodies import modelled_payload
from tool0.engines.real_robot.control_program import control_program
from tool0.engines.real_robot.engine import RealRobotEngine
from tool0.engines.real_robot.flange_frames import FlangeFrames
from tool0.errors import ControlError
from tool0.installation import garbage
from tool0.protocol.control_box_state import (
    POWERED,
    UNSTOPPED,
    ControlBoxState,
    RobotLink,
)
from tool0.protocol.real_robot import EnableMotion
from tool0.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

FIRST_SLIDER: Final = 0.25
"""Largest value of the speed slider when motion is enabled; a lower value is kept."""
CALIBRATION_TOLERANCE: Final = 0.5e-3
"""Largest distance between the flange position that the robot reports and the flange
position in the description [m].  Beyond the tolerance, the kinematics are considered
different.  The calibrations of UR robots differ by one or two millimeters."""
PAYLOAD_TOLERANCE: Final = (0.1, 0.1)
"""Largest differences between payloads that are considered equal: the absolute
difference [kg], and the relative difference."""
CB3_ARMS: Final = frozenset({"UR3", "UR5", "UR10"})
PROGRAM_END: Final = 1.0
"""Longest wait for the end of a program on the robot [s]."""
PROGRAM_TIMEOUT: Final = 5.0
"""Longest wait for the start of tool0's program on the robot [s]."""
CHANGE_TIMEOUT: Final = 10.0
"""Longest wait for a requested change of the robot's state [s].  Releasing the brakes
takes several seconds."""
_POLL: Final = 0.02


@final
class Enabling:
    """Finds reasons why the arm may not move, and starts tool0's program on the robot.

    ``Enabling`` queries the robot, which takes time.  ``Enabling`` must never be used
    in the thread of the tick.
    """

    def __init__(self, simulation: Simulation, engine: RealRobotEngine) -> None:
        self._simulation, self._engine = simulation, engine
        self._frames = FlangeFrames(simulation.description.model, engine.arm)

    # ---- state of the robot ---------------------------------------------------------

    @property
    def box(self) -> ControlBoxState:
        """Latest state of the arm's control box."""
        return self._simulation.snapshot.control_boxes[0]

    def look(self) -> RobotLink:
        """Read the robot's identity, and publish it with reasons not to move.

        Raises:
            TransportError: If the dashboard server does not answer.
        """
        dashboard = self._engine.connection.dashboard
        model = dashboard.find("get robot model")
        serial = dashboard.find("get serial number")
        is_remote = dashboard.is_in_remote_control
        loop = self._simulation.loop
        loop.call(
            lambda: self._engine.show(
                model=model, serial_number=serial, is_remote=is_remote
            )
        )
        obstacles = (
            *self._obstacles(model, is_remote=is_remote),
            *self._wrong_calibration(),
        )
        loop.call(lambda: self._engine.show(obstacles=obstacles))
        return self._engine.report.link

    def _obstacles(self, model: str, *, is_remote: bool | None) -> list[str]:
        """Return the reasons why the arm may not move, with one sentence per reason."""
        found, box = [], self.box
        if is_remote is False:
            found.append(
                "the robot is under local control; choose Remote Control on the pendant"
            )
        found += self._wrong_type(model)
        found += self._wrong_payload(box)
        if box.safety_mode not in UNSTOPPED:
            found.append(
                f"the safety mode is {box.safety_mode.name}; the pendant has its cause"
            )
        elif box.robot_mode not in POWERED:
            found.append(
                "the arm is not powered, or its brakes are on; release them with "
                "`tool0 hardware release-brakes`, or on the pendant"
            )
        return found

    def _wrong_type(self, model: str) -> list[str]:
        robots = self._simulation.description.robots
        if not robots or robots[0].arm is None or not model:
            return []
        expected = robots[0].arm.name
        name = expected.upper()
        is_e_series = self._engine.connection.rtde.version.is_e_series
        is_known_cb3 = name in CB3_ARMS
        if model.upper().removesuffix("E") != name.removesuffix("E") or (
            is_known_cb3 == is_e_series
        ):
            series = "an e-Series or later" if is_e_series else "a CB3"
            return [
                f"the robot is a {model} ({series}), not the {expected} of this "
                "description; choose it with `--arm`"
            ]
        return []

    def _wrong_calibration(self) -> list[str]:
        distance = self.calibration_distance()
        if distance <= CALIBRATION_TOLERANCE:
            return []
        return [
            f"the robot's calibration puts the flange {1e3 * distance:.1f} mm from "
            "where the description has it; use a description with its calibration, or "
            "accept that (`--accept-calibration`)"
        ]

    def calibration_distance(self) -> float:
        """Return the distance between the reported and the described flange [m]."""
        reader = self._engine.reader
        package, fields = reader.newest, reader.fields
        reported = self._frames.reported_flange(
            fields.vector(package, "actual_TCP_pose"),
            fields.vector(package, "tcp_offset"),
        )
        modelled = self._frames.flange(fields.vector(package, "actual_q"))
        return float(np.linalg.norm(reported[:3, 3] - modelled[:3, 3]))

    def _wrong_payload(self, box: ControlBoxState) -> list[str]:
        model, flange = self._simulation.description.model, self._engine.arm.flange
        expected = modelled_payload(model, flange).mass
        absolute, relative = PAYLOAD_TOLERANCE
        most = max(absolute, relative * expected)
        if math.isclose(box.payload.mass, expected, abs_tol=most):
            return []
        return [
            f"the robot expects a payload of {box.payload.mass:.2f} kg, and the "
            f"description has {expected:.2f} kg at the flange; set it with "
            "`tool0 hardware payload`, or in the robot's installation"
        ]

    # ---- enabling and disabling -----------------------------------------------------

    def enable(self, request: EnableMotion) -> None:
        """Start tool0's program on the robot, and the controllers that hold the arm.

        Raises:
            ControlError: If there are reasons why the arm may not move; the message
                contains all of them.
            TransportError: If the robot cannot be reached.
        """
        link = self.look()
        if link.is_enabled:
            raise ControlError("the robot's motion is enabled already")
        if request.serial_number.strip() != link.serial_number and link.serial_number:
            raise ControlError(
                f"the serial number is not '{request.serial_number}': read it from the "
                "nameplate of the robot that you want to move"
            )
        obstacles = self._obstacles(link.model, is_remote=link.is_remote)
        if not request.accept_calibration:
            obstacles += self._wrong_calibration()
        if obstacles:
            raise ControlError("the robot may not move: " + "; ".join(obstacles))
        # A previous program of tool0 may be about to end.
        self.wait(
            lambda: not self._engine.is_program_running,
            "another program runs on the robot; stop it on the pendant or with `stop` "
            "on the dashboard server",
            PROGRAM_END,
        )
        if self.box.speed_slider > FIRST_SLIDER:
            self._engine.set_speed_slider(FIRST_SLIDER)
            self.wait(
                lambda: self.box.speed_slider <= FIRST_SLIDER + 0.005,
                "the speed slider did not move to 25 %",
            )
        garbage.leave_alone()  # the robot stops after 0.1 s without messages
        self._start_program()
        core = self._simulation.core

        def begin() -> None:
            self._engine.set_enabled(True)
            core.arms.follow(self._engine.report, core.state)
            core.arms.find(None).play(core.state)

        self._simulation.loop.call(begin)
        logger.info("the motion of %s is enabled", link.address)

    def _start_program(self) -> None:
        connection = self._engine.connection
        options, motion_link = connection.options, connection.link
        host, port = motion_link.address
        script = control_program(
            options.callback_host or host, port, motion_link.token, self._engine.dt
        )
        connection.send(script)
        motion_link.accept(PROGRAM_TIMEOUT)
        try:
            self.wait(
                lambda: self._engine.is_program_ready,
                "tool0's program did not start on the robot; its log says why",
            )
        except ControlError:
            motion_link.disconnect()
            raise

    def disable(self) -> None:
        """Stop the arm, and end tool0's program on the robot."""
        self._engine.connection.link.end()
        simulation = self._simulation

        def end() -> None:
            self._engine.set_enabled(False)
            arm = simulation.core.arms.find(None)
            arm.stop(simulation.core.state)

        simulation.loop.call(end, urgent=True)

    def wait(
        self,
        is_so: Callable[[], bool],
        otherwise: str,
        timeout: float = CHANGE_TIMEOUT,
    ) -> None:
        """Wait until the robot reports the requested state.

        Raises:
            ControlError: If the robot does not report this state in time; the message
                is ``otherwise``.
        """
        end = time.monotonic() + timeout
        bus = self._simulation.bus
        while not is_so():
            if time.monotonic() > end:
                raise ControlError(otherwise)
            bus.newer_than(bus.latest, _POLL)
