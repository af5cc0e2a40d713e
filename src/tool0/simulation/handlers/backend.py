"""A running simulation as the backend of its clients."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Final, final

from tool0.description.parts import find_grippers
from tool0.errors import ControlError, did_you_mean
from tool0.protocol.arm import MoveLinear, MoveTo
from tool0.protocol.controllers import SwitchControllers
from tool0.protocol.gripper import Grip
from tool0.protocol.motion import MoveJoints, PoseJoints, SteerJoints
from tool0.protocol.poses import GoToPose
from tool0.protocol.real_robot import DisableMotion, EnableMotion
from tool0.protocol.replay import LoopReplay, ReadReplay, SeekReplay
from tool0.protocol.request import Request, Response
from tool0.protocol.running import EmergencyStop, Reset
from tool0.protocol.subscriptions import (
    Subscribe,
    SubscribeView,
    Unsubscribe,
    ViewShown,
)
from tool0.protocol.trajectories import CommandTrajectory, FollowTrajectory
from tool0.simulation.handlers.table import HANDLERS, answer, post
from tool0.simulation.simulation import Simulation

_REASONS: Final[Mapping[type[Request[Any]], str]] = {
    **dict.fromkeys(
        (Subscribe, SubscribeView, Unsubscribe, ViewShown),
        "streams are for connections; here, use robot.subscribe()",
    ),
    **dict.fromkeys(
        (SeekReplay, LoopReplay, ReadReplay),
        "this robot is running; `tool0 replay FILE` replays a recording",
    ),
    **dict.fromkeys(
        (EnableMotion, DisableMotion),
        "only a real robot's motion is enabled; this one is simulated",
    ),
    PoseJoints: "joints are set directly in `tool0 view` only; in a simulation, steer "
    "a trajectory controller",
}
_UNKNOWN: Final = "a running robot has no such operation"


@final
class SimulationBackend:
    """A running simulation."""

    mode: Final = "simulation"

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation

    @property
    def states(self) -> Simulation:
        return self.simulation

    def why_missing(self, request: type[Request[Any]]) -> str:
        return "" if request in HANDLERS else _REASONS.get(request, _UNKNOWN)

    def answer(self, request: Request[Response]) -> Response:
        return answer(self.simulation, request)

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        post(self.simulation, request, when_failed)

    def check_setpoint(self, request: Request[Any]) -> None:
        if not isinstance(request, SteerJoints):
            return
        defined = self.simulation.defined_controllers
        name = request.controller
        if name not in defined:
            raise ControlError(
                f"no controller '{name}' in the YAML{did_you_mean(name, defined)}"
            )
        for joint in request.positions:
            self.simulation.description.model.joint(joint)

    def superseded(self, request: Request[Any]) -> Collection[str]:
        simulation = self.simulation
        match request:
            case CommandTrajectory(controller=name) | FollowTrajectory(controller=name):
                return (name,)
            case SwitchControllers(stop=names):
                return names
            case Grip():
                named = find_grippers(simulation.description.model)
                gripper = named.get(request.gripper or next(iter(named), ""))
                joint = None if gripper is None else gripper.joint
                return [
                    status.name
                    for status in simulation.snapshot.controllers
                    if any(joint in joints for _, joints in status.claimed)
                ]
            case (
                GoToPose()
                | MoveJoints()
                | MoveTo()
                | MoveLinear()
                | Reset()
                | EmergencyStop(engaged=True)
            ):
                return tuple(simulation.defined_controllers)
        return ()
