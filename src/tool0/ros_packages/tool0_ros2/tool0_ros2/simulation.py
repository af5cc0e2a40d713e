"""Services that pause, step and reset the simulation."""

from collections.abc import Callable, Sequence
from typing import Any

from std_srvs.srv import Empty

from tool0_ros2 import requests
from tool0_ros2.bridge import Context, Update
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.entities import Entities, RefusedError
from tool0_ros2.messages import optional_module
from tool0_ros2.requests import Request

_MOST_TICKS = 1_000_000
"""Largest number of ticks in one request."""
_OK, _INCORRECT_STATE, _FAILED, _UNSUPPORTED = 1, 3, 4, 0
"""Result codes of simulation_interfaces/Result."""


class SimulationPart:
    """Services of gazebo_ros, such as ``pause_physics``, and of simulation_interfaces.

    The services of simulation_interfaces are offered by a node named ``simulation``.
    An example is ``simulation/spawn_entity``.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._node = context.new_node("simulation")
        self._call = context.connection.call
        self._entities = Entities(context)
        self._services = [
            self._offer_empty("pause_physics", requests.pause()),
            self._offer_empty("unpause_physics", requests.resume()),
            self._offer_empty("reset_simulation", requests.reset()),
            self._offer_empty("reset_world", requests.reset(keep_time=True)),
        ]
        services = optional_module(context, "simulation_interfaces.srv", "simulation")
        if services is None:
            return
        entities = self._entities
        for kind, handler in (
            ("GetSimulationState", self._get_state),
            ("SetSimulationState", self._set_state),
            ("ResetSimulation", self._reset),
            ("StepSimulation", self._step),
            ("GetSimulatorFeatures", self._get_features),
            ("SpawnEntity", entities.spawn),
            ("DeleteEntity", entities.delete),
            ("GetEntities", entities.list_names),
            ("GetEntityState", entities.get_state),
            ("GetEntitiesStates", entities.get_states),
            ("SetEntityState", entities.set_state),
        ):
            service = getattr(services, kind, None)
            if service is not None:
                self._services.append(self._offer(service, kind, handler))

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Publish nothing, because this part has only services."""

    def close(self) -> None:
        for service in self._services:
            self._node.destroy_service(service)

    # ---- offering -------------------------------------------------------------------

    def _offer_empty(self, name: str, operation: Request[None]) -> Any:
        def answer(request: Any, response: Any) -> Any:
            try:
                self._call(operation)
            except RequestFailedError as error:
                self._context.report.error(f"{name}: {error}")
            return response

        topic = self._context.names.topic(name)
        return self._node.create_service(Empty, topic, answer)

    def _offer(self, kind: Any, title: str, handler: Callable[[Any, Any], None]) -> Any:
        """Offer a service with a ``result`` that reports whether the call succeeded."""
        name = "".join(f"_{c.lower()}" if c.isupper() else c for c in title)[1:]

        def answer(request: Any, response: Any) -> Any:
            code, text = _OK, ""
            try:
                handler(request, response)
            except RefusedError as error:
                code, text = error.code, str(error)
            except RequestFailedError as error:
                code, text = _FAILED, str(error)
            if hasattr(response, "result"):
                response.result.result = code
                response.result.error_message = text
            return response

        return self._node.create_service(kind, f"~/{name}", answer)

    # ---- simulation_interfaces ------------------------------------------------------

    def _is_paused(self) -> bool:
        return self._call(requests.read_snapshot())["is_paused"]

    def _get_state(self, request: Any, response: Any) -> None:
        state = response.state
        state.state = state.STATE_PAUSED if self._is_paused() else state.STATE_PLAYING

    def _set_state(self, request: Any, response: Any) -> None:
        wanted = request.state
        is_paused = self._is_paused()
        if wanted.state == wanted.STATE_STOPPED:
            self._call(requests.pause())
            self._reset_all()
        elif wanted.state not in (wanted.STATE_PLAYING, wanted.STATE_PAUSED):
            raise RefusedError(
                _UNSUPPORTED, "end the bring-up instead; valid: stop, play, pause"
            )
        elif is_paused == (wanted.state == wanted.STATE_PAUSED):
            raise RefusedError(
                response.ALREADY_IN_TARGET_STATE, "it is in that state already"
            )
        else:
            self._call(requests.resume() if is_paused else requests.pause())

    def _reset(self, request: Any, response: Any) -> None:
        scope = request.scope or request.SCOPE_ALL
        parts = request.SCOPE_TIME | request.SCOPE_STATE | request.SCOPE_SPAWNED
        scope &= parts
        if scope == parts:
            self._reset_all()
            return
        if scope & request.SCOPE_TIME and not scope & request.SCOPE_STATE:
            raise RefusedError(
                _UNSUPPORTED, "the time is reset with the state only: add SCOPE_STATE"
            )
        if scope & request.SCOPE_SPAWNED:
            self._entities.delete_spawned()
        if scope & request.SCOPE_STATE:
            is_kept = not scope & request.SCOPE_TIME
            self._call(requests.reset(keep_time=is_kept))

    def _reset_all(self) -> None:
        self._entities.delete_spawned()
        self._call(requests.reset())

    def _step(self, request: Any, response: Any) -> None:
        if not self._is_paused():
            raise RefusedError(_INCORRECT_STATE, "pause the simulation before a step")
        left = request.steps
        while left > 0:
            ticks = min(left, _MOST_TICKS)
            self._call(requests.step(ticks=ticks), timeout=None)
            left -= ticks

    def _get_features(self, request: Any, response: Any) -> None:
        features = response.features
        names = (
            *("SPAWNING", "DELETING", "SPAWNING_RESOURCE_STRING"),
            *("ENTITY_STATE_GETTING", "ENTITY_STATE_SETTING"),
            *("SIMULATION_RESET", "SIMULATION_RESET_TIME", "SIMULATION_RESET_STATE"),
            *("SIMULATION_RESET_SPAWNED", "SIMULATION_STATE_GETTING"),
            *("SIMULATION_STATE_SETTING", "SIMULATION_STATE_PAUSE"),
            *("STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE"),
        )
        features.features = [getattr(features, name) for name in names]
        features.spawn_formats = ["sdf", "urdf"]
