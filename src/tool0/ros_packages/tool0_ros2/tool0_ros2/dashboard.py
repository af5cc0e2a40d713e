"""The services of UR's dashboard_client.  Each arm has its own node.

A service that has no counterpart in the simulation is refused with a reason.
"""

from collections.abc import Callable, Sequence
from functools import partial
from types import ModuleType
from typing import Any

from std_srvs.srv import Trigger

from tool0_ros2 import requests
from tool0_ros2.bridge import Context, Reporter, Update
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.control_box import (
    NORMAL_MODES,
    ROBOT_EMERGENCY_STOP,
    ControlBox,
    is_program_running,
    read_boxes,
)
from tool0_ros2.messages import fill, optional_module
from tool0_ros2.requests import Request

NODE_NAME = "dashboard_client"

_REFUSED = {
    "clear_operational_mode": "the simulation has no operational modes",
    "quit": "there is no dashboard server to disconnect from",
    "shutdown": "end the bring-up instead",
}
_QUERIES_REFUSED = {
    "download_program": "DownloadProgram",
    "generate_flight_report": "GenerateFlightReport",
    "generate_support_file": "GenerateSupportFile",
    "get_operational_mode": "GetOperationalMode",
    "get_polyscope_version": "GetPolyScopeVersion",
    "get_programs": "GetPrograms",
    "get_serial_number": "GetSerialNumber",
    "get_user_role": "GetUserRole",
    "load_installation": "Load",
    "load_program": "Load",
    "popup": "Popup",
    "raw_request": "RawRequest",
    "set_operational_mode": "SetOperationalMode",
    "set_user_role": "SetUserRole",
    "update_program": "UploadProgram",
    "upload_program": "UploadProgram",
}
"""Services of ur_dashboard_msgs that a simulated arm cannot answer."""


class DashboardPart:
    """Services ``dashboard_client/…`` for the program, modes and safety of each arm."""

    def __init__(self, context: Context) -> None:
        messages = optional_module(context, "ur_dashboard_msgs.srv", NODE_NAME)
        for box in read_boxes(context):
            name = f"{context.names.to_ros(box['prefix'])}{NODE_NAME}"
            node = context.new_node(name)
            _Dashboard(context, node, ControlBox(context, box["prefix"]), messages)

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Publish nothing, because this part has only services."""

    def close(self) -> None:
        """Do nothing, because the services end together with their nodes."""


class _Dashboard:
    """The dashboard of one arm."""

    def __init__(
        self, context: Context, node: Any, box: ControlBox, messages: ModuleType | None
    ) -> None:
        self._context, self._node, self._box = context, node, box
        self._report = Reporter(node.get_logger())
        changes = {
            "brake_release": (
                requests.release_brakes(arm=box.arm),
                "the arm is powered, and its brakes are released",
            ),
            "pause": (requests.pause_program(arm=box.arm), "the program is paused"),
            "play": (requests.play_program(arm=box.arm), "the program is playing"),
            "power_off": (requests.power_off(arm=box.arm), "the arm is powered off"),
            "power_on": (requests.power_on(arm=box.arm), "the arm is powered"),
            "stop": (requests.stop_program(arm=box.arm), "the program is stopped"),
            "unlock_protective_stop": (
                requests.unlock_protective_stop(arm=box.arm),
                "the arm is unlocked",
            ),
        }
        triggers: dict[str, Callable[[], str]] = {
            "close_popup": lambda: "there is no popup",
            "close_safety_popup": lambda: "there is no popup",
            "connect": lambda: "connected to the simulation",
            "restart_safety": self._restart_safety,
        }
        for name, (request, effect) in changes.items():
            triggers[name] = partial(self._change, request, effect)
        for name, reason in _REFUSED.items():
            triggers[name] = partial(_refuse, reason)
        for name, action in triggers.items():
            self._offer(Trigger, name, partial(_triggered, action))
        if messages is None:
            return
        queries: dict[str, tuple[str, Callable[[Any, Any], str]]] = {
            "add_to_log": ("AddToLog", self._add_to_log),
            "get_loaded_program": ("GetLoadedProgram", self._no_program),
            "get_robot_mode": ("GetRobotMode", self._robot_mode),
            "get_safety_mode": ("GetSafetyMode", self._safety_mode),
            "is_in_remote_control": ("IsInRemoteControl", self._remote_control),
            "program_running": ("IsProgramRunning", self._program_running),
            "program_saved": ("IsProgramSaved", self._no_program),
            "program_state": ("GetProgramState", self._program_state),
        }
        for name, kind in _QUERIES_REFUSED.items():
            queries[name] = (kind, _no_answer)
        for name, (kind, query) in queries.items():
            service = getattr(messages, kind, None)
            if service is not None:  # this distribution has the service
                self._offer(service, name, query)

    def _offer(self, kind: Any, name: str, handler: Callable[[Any, Any], str]) -> None:
        def answer(request: Any, response: Any) -> Any:
            try:
                text = handler(request, response)
            except RequestFailedError as error:
                text = self._context.names.text(error)
                self._report.error(f"{name}: {text}")
                return fill(response, success=False, message=text, answer=text)
            return fill(response, success=True, message=text, answer=text)

        self._node.create_service(kind, f"~/{name}", answer)

    # ---- what has an effect ---------------------------------------------------------

    def _change(self, request: Request[None], effect: str) -> str:
        self._context.connection.call(request)
        return effect

    def _restart_safety(self) -> str:
        mode = self._box.read()["safety_mode"]
        if mode == ROBOT_EMERGENCY_STOP:
            release = requests.emergency_stop(engaged=False)
            return self._change(release, "the emergency stop is released")
        if mode in NORMAL_MODES:
            return "the safety system has stopped nothing"
        restart = requests.restart_safety(arm=self._box.arm)
        return self._change(restart, "the arm is powered off")

    def _add_to_log(self, request: Any, response: Any) -> str:
        self._node.get_logger().info(request.message)
        return "the message is logged"

    # ---- what is asked --------------------------------------------------------------

    def _robot_mode(self, request: Any, response: Any) -> str:
        response.robot_mode.mode = mode = self._box.read()["robot_mode"]
        return f"robot mode {mode}"

    def _safety_mode(self, request: Any, response: Any) -> str:
        response.safety_mode.mode = mode = self._box.read()["safety_mode"]
        return f"safety mode {mode}"

    def _program_running(self, request: Any, response: Any) -> str:
        response.program_running = is_running = is_program_running(self._box.read())
        return f"program running: {str(is_running).lower()}"

    def _program_state(self, request: Any, response: Any) -> str:
        response.state.state = state = self._box.read()["program"]
        return str(state)

    def _no_program(self, request: Any, response: Any) -> str:
        return _refuse("no program file is loaded: ROS controls the arm")

    def _remote_control(self, request: Any, response: Any) -> str:
        response.remote_control = True
        return "true"


def _triggered(action: Callable[[], str], request: Any, response: Any) -> str:
    return action()


def _no_answer(request: Any, response: Any) -> str:
    return _refuse("the simulated arm has no teach pendant and no program files")


def _refuse(reason: str) -> str:
    raise RequestFailedError("ControlError", reason)
