"""Requests to the controller manager, and to read a controller."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from tool0.control.config import ControllerConfig, ControllerSpec
from tool0.control.manager import ControllerStatus, Strictness
from tool0.control.trajectory import JointsMotion, TrajectoryState
from tool0.requests.fields import Name
from tool0.requests.table import Request, handles
from tool0.runtime.simulation import Simulation

Names = Annotated[tuple[Name, ...], Meta(max_length=100)]


class ListControllers(Request[tuple[ControllerStatus, ...]], frozen=True):
    """Every loaded controller with its state and claims."""


class LoadController(Request[None], frozen=True):
    """Load a controller that the bring-up's configuration defines."""

    name: Name


class LoadControllerWith(Request[None], frozen=True):
    """Load a controller with parameters of its own."""

    unchecked = ("config",)

    name: Name
    config: ControllerConfig


class UnloadController(Request[None], frozen=True):
    """Unload a controller that is not running."""

    name: Name


class SwitchControllers(Request[None], frozen=True):
    """Stop and start controllers at one instant."""

    start: Names = ()
    stop: Names = ()
    strict: bool = True
    """Whether one impossible change refuses all; otherwise it is skipped."""


class ReadController(Request[TrajectoryState], frozen=True):
    """Desired, actual and error of a trajectory controller."""

    controller: Name


class QueryState(Request[JointsMotion], frozen=True):
    """The setpoint of a trajectory controller at a time."""

    controller: Name
    time: float | None = None
    """Simulated time [s]; now, if left out."""


class ReadControllerSpec(Request[ControllerSpec], frozen=True):
    """The parameters that a controller was loaded with."""

    controller: Name


@handles(ListControllers)
def _list(
    simulation: Simulation, request: ListControllers
) -> tuple[ControllerStatus, ...]:
    return simulation.snapshot.controllers


@handles(LoadController, in_tick=True)
def _load(simulation: Simulation, request: LoadController) -> None:
    simulation.core.manager.load(request.name)


@handles(LoadControllerWith, in_tick=True, local=True)
def _load_with(simulation: Simulation, request: LoadControllerWith) -> None:
    simulation.core.manager.load(request.name, request.config)


@handles(UnloadController, in_tick=True)
def _unload(simulation: Simulation, request: UnloadController) -> None:
    simulation.core.manager.unload(request.name)


@handles(SwitchControllers, in_tick=True)
def _switch(simulation: Simulation, request: SwitchControllers) -> None:
    core = simulation.core
    strictness = Strictness.STRICT if request.strict else Strictness.BEST_EFFORT
    core.manager.switch(request.start, request.stop, strictness, core.state)


@handles(ReadController, in_tick=True, publishes=False)
def _state(simulation: Simulation, request: ReadController) -> TrajectoryState:
    return simulation.core.trajectory_controller(request.controller).setpoint().state()


@handles(QueryState, in_tick=True, publishes=False)
def _query(simulation: Simulation, request: QueryState) -> JointsMotion:
    core = simulation.core
    time = core.time if request.time is None else request.time
    return core.trajectory_controller(request.controller).query_state(time)


@handles(ReadControllerSpec, in_tick=True, publishes=False, local=True)
def _spec(simulation: Simulation, request: ReadControllerSpec) -> ControllerSpec:
    return simulation.core.manager.spec(request.controller)
