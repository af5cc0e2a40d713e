"""The backend of a real robot, which answers, rejects and checks requests."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Final, cast, final

from msgspec.structs import replace

from tool0.description.payload_bodies import modelled_payload
from tool0.engines.real_robot.engine import RealRobotEngine
from tool0.errors import ControlError, TransportError
from tool0.protocol.arm import MoveLinear, MoveTo
from tool0.protocol.arm_motion import DriveTorques, EndTorques, ZeroWrench
from tool0.protocol.control_box import (
    PowerOff,
    PowerOn,
    ReleaseBrakes,
    ReportUr,
    RestartSafety,
    SetAnalogInput,
    SetIO,
    SetPayload,
    SetSafetyLimits,
    SetTcp,
    StopProgram,
    StopProtectively,
    UnlockProtectiveStop,
)
from tool0.protocol.control_box_state import POWERED, UNSTOPPED, RobotMode
from tool0.protocol.gripper import Grip, ReactivateGripper
from tool0.protocol.motion import CommandGripper, CommandJoints, MoveJoints
from tool0.protocol.objects import ApplyWrench, ClearWrenches, PullLink
from tool0.protocol.poses import GoToPose
from tool0.protocol.real_robot import DisableMotion, EnableMotion
from tool0.protocol.request import Request, Response
from tool0.protocol.running import (
    EmergencyStop,
    Pause,
    Reset,
    Resume,
    SetSpeed,
    Step,
    StopMotions,
)
from tool0.protocol.sensors import (
    ReadForceTorque,
    ReadForceTorqueRate,
    ReadForceTorqueSamples,
    StartForceTorque,
    StopForceTorque,
    TareForceTorque,
)
from tool0.simulation.handlers.backend import SimulationBackend
from tool0.simulation.real_robot.enabling import Enabling
from tool0.simulation.real_robot.path_guard import PathGuard
from tool0.simulation.simulation import Simulation

_TIME: Final = "the time of a real robot cannot be held or changed"
_REASONS: Final[Mapping[type[Request[Any]], str]] = {
    **dict.fromkeys((Pause, Resume, Step, SetSpeed), _TIME),
    Reset: "a real robot cannot be put into a pose; move it there",
    **dict.fromkeys(
        (ApplyWrench, PullLink, ClearWrenches),
        "a program cannot apply forces to a real robot",
    ),
    **dict.fromkeys(
        (StartForceTorque, StopForceTorque, TareForceTorque, ReadForceTorque),
        "the wrench of a real arm is that of its own sensor: `robot.arm.motion.read()`",
    ),
    **dict.fromkeys(
        (ReadForceTorqueRate, ReadForceTorqueSamples),
        "the wrench of a real arm is that of its own sensor: `robot.arm.motion.read()`",
    ),
    **dict.fromkeys((DriveTorques, EndTorques), "torques are not sent to a real robot"),
    CommandJoints: "a forwarding controller would let a real arm jump; send a "
    "trajectory or a stream of setpoints",
    SetAnalogInput: "the inputs of a real robot are what their wires say",
    SetSafetyLimits: "the safety limits of a real robot are set on its pendant",
    StopProtectively: "only its safety system stops a real robot protectively; stop "
    "its motions instead",
    ReactivateGripper: "activate a real gripper on the pendant",
    ReportUr: "a real robot has its own interfaces",
}
_DID_NOT: Final = "the robot did not {}"


@final
class RealRobotBackend:
    """A real robot, moved by the same controllers and executor as a simulated robot.

    Requests for the robot's controller (power, payload, tare) are forwarded to it, and
    are answered after the robot has executed them.  The safety system of the UR robot
    is the only safety function.
    """

    mode: Final = "hardware"

    def __init__(self, simulation: Simulation) -> None:
        """Create a backend for ``simulation``, which has the engine ``hardware``."""
        self.simulation = simulation
        engine = simulation.engine
        assert isinstance(engine, RealRobotEngine)
        self._engine = engine
        self._inner = SimulationBackend(simulation)
        self._enabling = Enabling(simulation, engine)
        self._guard: PathGuard | None = None
        """Guard of paths.  The guard is created when motion is first enabled, because
        it imports additional modules."""
        self._handlers: Mapping[type[Request[Any]], Callable[[Any], None]] = {
            EnableMotion: self._enable,
            DisableMotion: lambda _: self._enabling.disable(),
            PowerOn: lambda _: self._power("power on", RobotMode.IDLE),
            PowerOff: lambda _: self._power("power off", RobotMode.POWER_OFF),
            ReleaseBrakes: lambda _: self._power("brake release", RobotMode.RUNNING),
            UnlockProtectiveStop: lambda _: self._clear_stop(
                "unlock protective stop", "Protective stop releasing"
            ),
            RestartSafety: lambda _: self._clear_stop(
                "restart safety", "Restarting safety"
            ),
            SetPayload: self._set_payload,
            SetTcp: self._set_tcp,
            SetIO: self._set_io,
            ZeroWrench: lambda _: self._beside("zero", "zero_ftsensor()"),
        }
        try:
            self._enabling.look()
        except (TransportError, ControlError) as error:
            text = str(error)
            simulation.loop.call(lambda: engine.show(obstacles=(text,)))

    @property
    def states(self) -> Simulation:
        return self.simulation

    def why_missing(self, request: type[Request[Any]]) -> str:
        if request in self._handlers:
            return ""
        return _REASONS.get(request) or self._inner.why_missing(request)

    def answer(self, request: Request[Response]) -> Response:
        if isinstance(request, EmergencyStop | StopMotions | StopProgram):
            self._engine.brake()  # before actions that wait for the tick
        handler = self._handlers.get(type(request))
        if handler is None:
            if isinstance(request, Grip | CommandGripper):
                self._require_gripper()
            return self._inner.answer(_checked(request))
        try:
            return cast(Response, handler(request))
        except TransportError as error:
            raise ControlError(f"the robot is not reached: {error}") from None

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        self._inner.post(request, when_failed)

    def check_setpoint(self, request: Request[Any]) -> None:
        self._inner.check_setpoint(request)

    def superseded(self, request: Request[Any]) -> Collection[str]:
        return self._inner.superseded(request)

    # ---- requests for the robot's controller ----------------------------------------

    def _enable(self, request: EnableMotion) -> None:
        if self._guard is None:
            self._guard = PathGuard(self.simulation, self._engine.arm_name)
            self._engine.guard = self._guard
        self._enabling.enable(request)

    def _power(self, command: str, mode: RobotMode) -> None:
        """Change the mode of the arm, and wait until it has this mode."""
        words = {
            "power on": "Powering on",
            "power off": "Powering off",
            "brake release": "Brake releasing",
        }
        self._engine.connection.dashboard.order(command, words[command])
        box = self._enabling
        wanted = (
            (POWERED if mode is RobotMode.RUNNING else (mode, *POWERED))
            if mode is not RobotMode.POWER_OFF
            else (mode,)
        )
        box.wait(lambda: box.box.robot_mode in wanted, _DID_NOT.format(command))
        box.look()

    def _clear_stop(self, command: str, accepted: str) -> None:
        """Clear a stop of the safety system, and wait until it is over."""
        self._engine.connection.dashboard.order(command, accepted)
        box = self._enabling
        box.wait(lambda: box.box.safety_mode in UNSTOPPED, _DID_NOT.format(command))
        box.look()

    def _set_payload(self, request: SetPayload) -> None:
        mass, center = request.mass, request.center_of_gravity
        if mass is None:
            model = self.simulation.description.model
            expected = modelled_payload(model, self._engine.arm.flange)
            mass, center = expected.mass, expected.center_of_gravity
        x, y, z = center
        self._beside("payload", f"set_payload({mass!r}, [{x!r}, {y!r}, {z!r}])")
        box = self._enabling
        box.wait(
            lambda: abs(box.box.payload.mass - mass) < 1e-3,
            _DID_NOT.format(f"accept a payload of {mass:g} kg"),
        )
        box.look()

    def _set_tcp(self, request: SetTcp) -> None:
        pose = ", ".join(map(repr, request.pose))
        self._beside("tcp", f"set_tcp(p[{pose}])")
        box = self._enabling
        box.wait(
            lambda: (
                max(abs(a - b) for a, b in zip(box.box.tcp, request.pose, strict=True))
                < 1e-4
            ),
            _DID_NOT.format("accept the TCP"),
        )

    def _set_io(self, request: SetIO) -> None:
        if request.tool_voltage is not None:
            volts = request.tool_voltage
            self._beside("voltage", f"set_tool_voltage({volts})")
        self._inner.answer(replace(request, tool_voltage=None))
        box = self._enabling
        box.wait(
            lambda: (
                all(
                    box.box.digital_outputs[pin] == level
                    for pin, level in request.digital_outputs.items()
                )
                and request.tool_voltage in {None, box.box.tool_voltage}
            ),
            _DID_NOT.format("set its outputs"),
        )

    def _require_gripper(self) -> None:
        """Raise ControlError if the gripper cannot receive commands."""
        if problem := self._engine.gripper_problem:
            raise ControlError(f"the gripper does not move: {problem}")

    def _beside(self, name: str, *lines: str) -> None:
        """Execute statements on the robot's controller without stopping its program."""
        self._engine.connection.run_beside(name, *lines)


def _checked(request: Request[Response]) -> Request[Response]:
    """Return the request, with collision checks enabled if it commands a motion."""
    if isinstance(request, MoveJoints | MoveTo | MoveLinear | GoToPose):
        return cast(Request[Response], replace(request, collision="refuse"))
    return request
