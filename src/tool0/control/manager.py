"""The controller manager: loads, starts, stops and updates controllers."""

from __future__ import annotations

import copy
import enum
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import fields, replace
from typing import Final, NamedTuple, final

from tool0.control.config import ControllerConfig, ControllerParameters
from tool0.control.controller import Adjustable, Controller, ControllerSpec
from tool0.control.loaded import LoadedController
from tool0.control.parameters import RobotJoints
from tool0.control.trajectory import Setpoint
from tool0.description.finding import quoted
from tool0.description.model import Joint, RobotModel
from tool0.description.parts import arm_joints
from tool0.description.yaml_values import Value
from tool0.errors import (
    ClaimError,
    ConfigError,
    ControlError,
    GoalRejectedError,
    did_you_mean,
)
from tool0.hardware.engine import JointState, as_slice
from tool0.hardware.robot_hardware import EffortLaw, RobotHardware
from tool0.protocol.controllers import ControllerStatus, Gains, Role, start_command

_KIND: Final[Mapping[type, str]] = {
    bool: "bool",
    int: "integer",
    float: "double",
    str: "string",
    tuple: "array",
}
"""Names of the parameter types in ROS."""


class SavedController(NamedTuple):
    """The state of a running controller at one point in time."""

    spec: ControllerSpec
    controller: Controller
    """A copy of the controller; the copy itself never runs."""
    is_waiting: bool
    """Whether the brakes hold the controller's joints until its first command."""


class Strictness(enum.Enum):
    """Handling of requests that a switch cannot fulfill; the values are from ROS."""

    BEST_EFFORT = 1
    """Skip requests that cannot be fulfilled, and fulfill the other requests."""
    STRICT = 2
    """Raise an error, and change nothing."""


@final
class ControllerManager:
    """Manages the controllers of one robot's hardware, with the rules of ros_control.

    All controllers have the same dialect, which is ROS 1 or ROS 2.  Only the thread
    that executes the tick may call the manager.
    """

    def __init__(
        self,
        hardware: RobotHardware,
        config: ControllerConfig,
        joints: Mapping[str, Joint],
        model: RobotModel | None = None,
    ) -> None:
        """Store the hardware and the config; no controllers are loaded.

        ``config`` contains the controllers that can be loaded.  ``joints`` contains the
        limits of the joints.  ``model`` contains the hardware, the grippers and the
        arms of the robot.
        """
        self._hardware = hardware
        self.config = config
        self.dialect = config.dialect
        self._stages = config.dialect.stages
        self._robot = RobotJoints(
            joints,
            hardware.interfaces,
            hardware=() if model is None else model.hardware,
            grippers=() if model is None else model.grippers,
            speed_scaling=hardware.speed_scaling,
            arms={} if model is None else arm_joints(model),
            gripper_delay=hardware.gripper_delay,
        )
        self.when_switched: Callable[[JointState], None] = lambda state: None
        """Callback that receives the state after controllers were started or
        stopped."""
        self._loaded: dict[str, LoadedController] = {}
        self._blocked: dict[str, str] = {}
        """Joint → reason why controllers that claim it cannot be started."""
        self._running: list[tuple[str, Controller, slice | None, tuple[int, ...]]] = []
        """Name and instance of each running controller, and its command indices."""
        self.running_controllers: tuple[tuple[Controller, tuple[int, ...]], ...] = ()
        """The running controllers in load order, with their joints.  The tuple is
        replaced whenever a controller starts or stops."""
        self.running_specs: tuple[ControllerSpec, ...] = ()
        """Parameters of the running controllers; a restart of a controller keeps its
        parameters."""
        self._observers: tuple[Callable[[JointState], None], ...] = ()
        self._setpoints: tuple[tuple[str, Callable[[], Setpoint | None]], ...] = ()
        """Name and setpoint function of each running controller."""
        self._statuses: tuple[ControllerStatus, ...] = ()

    # ---- the tick -----------------------------------------------------------------

    def update(self, state: JointState, period: float) -> None:
        """Update the running controllers, in load order, and write their commands."""
        command = self._hardware.command
        for _, controller, run, indices in self._running:
            values = controller.update(state, period)
            if run is not None:
                command[run] = values
            else:
                for index, value in zip(indices, values, strict=True):
                    command[index] = value

    def observe(self, state: JointState) -> None:
        """Pass the state of the last tick to the running controllers."""
        for observe in self._observers:
            observe(state)

    def _refresh(self) -> None:
        self._running = [
            (name, item.controller, as_slice(claims), claims)
            for name, item in self._loaded.items()
            if item.controller is not None
            for claims in [item.indices if item.commands else ()]
        ]
        self.running_controllers = tuple(
            (controller, claims) for _, controller, _, claims in self._running
        )
        self.running_specs = tuple(
            self._loaded[item[0]].configured for item in self._running
        )
        self._observers = tuple(item[1].observe for item in self._running)
        self._setpoints = tuple(
            (name, controller.setpoint) for name, controller, *_ in self._running
        )
        self._statuses = tuple(map(self.status, self._loaded))

    # ---- loading ------------------------------------------------------------------

    def load(
        self,
        name: str,
        config: ControllerConfig | None = None,
        *,
        configure: bool = True,
    ) -> None:
        """Load a controller from ``config``, and configure it.

        If ``config`` is None, the manager's config is used.  If ``configure`` is False,
        the controller stays unconfigured, as it does after the load service of ROS 2.

        Raises:
            ControlError: If the controller is already loaded.
            ConfigError: If the controller is unknown, or its parameters are invalid.
        """
        if name in self._loaded:
            raise ControlError(
                f"A controller named '{name}' was already loaded; unload it first"
            )
        config = config or self.config
        if config.dialect is not self.dialect:
            raise ConfigError(
                f"'{name}' is a controller of {config.dialect.title}, but those of "
                f"this bring-up are of {self.dialect.title}"
            )
        item = LoadedController(name, config.type_of(name), self._stages, config)
        if configure:
            self._configure(item)
        self._loaded[name] = item
        self._refresh()

    def configure(self, name: str) -> None:
        """Check the parameters of a loaded controller, so that it can be started.

        Raises:
            ControlError: If the controller is already configured.
            ConfigError: If the controller's parameters are invalid; the controller
                stays unconfigured.
        """
        item = self._find(name)
        if item.spec is not None:
            raise ControlError(
                f"controller '{name}' is {item.state}; only an unconfigured one can be "
                "configured"
            )
        self._configure(item)
        self._refresh()

    def _configure(self, item: LoadedController) -> None:
        self._use(item, item.require_config().spec(item.name, self._robot))

    def _use(self, item: LoadedController, spec: ControllerSpec) -> None:
        item.indices = tuple(self._hardware.index[joint] for joint in spec.joints)
        item.spec, item.state = spec, self._stages.configured

    def cleanup(self, name: str) -> None:
        """Unconfigure a controller that is not running."""
        item = self._find(name)
        if item.controller is not None:
            raise ControlError(
                f"controller '{name}' is {item.state}; stop it before its cleanup"
            )
        item.spec, item.indices = None, ()
        item.state = self._stages.unconfigured
        self._refresh()

    def unload(self, name: str) -> None:
        """Unload a controller that is not running."""
        if self._find(name).controller is not None:
            raise ControlError(
                f"Could not unload controller '{name}' because it is still running; "
                "stop it first"
            )
        del self._loaded[name]
        self._refresh()

    # ---- internal controllers of tool0 ----------------------------------------------

    def start_own(self, spec: ControllerSpec, state: JointState) -> None:
        """Load and start an internal controller of tool0, which has no YAML.

        The servos of the joints follow positions, regardless of the interfaces that the
        drives offer.

        Raises:
            ControlError: If a controller with the same name is already loaded.
            ClaimError: If another running controller claims one of the joints.
        """
        if spec.name in self._loaded:
            raise ControlError(
                f"a controller named '{spec.name}' is loaded already; unload it first"
            )
        item = LoadedController(spec.name, spec.type, self._stages, None)
        self._use(item, spec)
        self._loaded[spec.name] = item
        try:
            self._check_claims([*self._names_running(), spec.name])
        except ClaimError:
            del self._loaded[spec.name]
            raise
        item.controller, item.state = item.started(state), self._stages.running
        self._engage(item, state)
        self._refresh()

    def stop_own(self, name: str, state: JointState) -> None:
        """Stop and unload an internal controller of tool0.

        After the stop, the brakes hold the joints.
        """
        self._stop([name], state)
        del self._loaded[name]
        self._refresh()

    def drive_efforts(
        self,
        name: str,
        law: EffortLaw | None,
        state: JointState,
        *,
        with_rotors: bool = False,
    ) -> None:
        """Drive a running controller's joints with a law instead of its commands.

        If ``law`` is None, the joints follow the commands again.
        ``RobotHardware.claim_efforts`` documents ``with_rotors``.
        """
        item = self._find(name)
        self._disengage(item, state)
        item.effort_law, item.has_rotors = law, with_rotors
        self._engage(item, state)
        self._refresh()

    def _names_running(self) -> list[str]:
        return [n for n, item in self._loaded.items() if item.controller is not None]

    # ---- switching ----------------------------------------------------------------

    def switch(
        self,
        start: Sequence[str],
        stop: Sequence[str],
        strictness: Strictness,
        state: JointState,
    ) -> tuple[str, ...]:
        """Stop and start controllers in one step.

        The result contains the reasons why controllers were skipped.

        Started controllers hold the measured ``state``.

        Raises:
            ControlError: If the switch is impossible; in this case, nothing changes.
            ClaimError: If two running controllers would claim the same joint.
        """
        skipped: list[str] = []
        to_stop, to_start = self._plan(start, stop, strictness, skipped)
        running = [
            name
            for name, item in self._loaded.items()
            if (item.controller is not None and name not in to_stop) or name in to_start
        ]
        self._check_claims(running)
        started = {name: self._loaded[name].started(state) for name in to_start}
        self._stop(to_stop, state)
        for name, controller in started.items():
            item = self._loaded[name]
            item.controller = controller
            item.state = self._stages.running
            self._take_shared(item, state)
            self._engage(item, state)
        self._refresh()
        self.when_switched(state)
        return tuple(skipped)

    def _take_shared(self, item: LoadedController, state: JointState) -> None:
        """Release the joints of an arm mode that shares them with a new controller."""
        for other in self._loaded.values():
            if other.arm_mode is not None and set(other.held) & set(item.claims):
                self._disengage(other, state)
                other.effort_law = None

    def _plan(
        self,
        start: Sequence[str],
        stop: Sequence[str],
        strictness: Strictness,
        skipped: list[str],
    ) -> tuple[list[str], list[str]]:
        """Return the controllers to stop and to start.

        The checks are performed in the same order as in ROS.
        """

        def refuse(message: str) -> None:
            if strictness is Strictness.STRICT:
                raise ControlError(message)
            skipped.append(message)

        plans: dict[str, list[str]] = {"stop": [], "start": []}
        for verb, names in (("stop", stop), ("start", start)):
            for name in dict.fromkeys(names):
                if name in self._loaded:
                    plans[verb].append(name)
                else:
                    refuse(
                        f"Could not {verb} controller with name '{name}' because no "
                        "controller with this name is loaded"
                        + did_you_mean(name, list(self._loaded))
                    )
            if names and not plans[verb] and self.dialect.needs_known_controller:
                raise ControlError("; ".join(skipped))
        for name in self._loaded:
            item = self._loaded[name]
            is_running = item.controller is not None
            is_restarted = is_running and all(name in each for each in plans.values())
            if item.is_own and name in (*plans["start"], *plans["stop"]):
                refuse(item.why_fixed)
                plans = {k: [n for n in v if n != name] for k, v in plans.items()}
                continue
            if is_restarted and not self.dialect.restarts_by_switch:
                raise ControlError(
                    f"Controller '{name}' is to be both started and stopped; a running "
                    "controller cannot be restarted by one switch"
                )
            if not is_running and name in plans["stop"]:
                refuse(
                    f"Could not stop controller '{name}' since it is not "
                    f"{self._stages.running}"
                )
                plans["stop"].remove(name)
            if is_running and name in plans["start"] and not is_restarted:
                refuse(f"Controller '{name}' is already {self._stages.running}")
                plans["start"].remove(name)
            if item.spec is None and name in plans["start"]:
                refuse(
                    f"Could not start controller '{name}' since it is {item.state}; "
                    "configure it first"
                )
                plans["start"].remove(name)
            elif name in plans["start"] and (reason := self._why_blocked(item)):
                refuse(f"Could not start controller '{name}': {reason}")
                plans["start"].remove(name)
        return plans["stop"], plans["start"]

    def block(self, joints: Collection[str], reason: str) -> None:
        """Prevent the start of controllers that claim ``joints``.

        An empty ``reason`` allows such controllers to start again.

        Controllers that are already running continue.
        """
        for joint in joints:
            self._blocked.pop(joint, None)
            if reason:
                self._blocked[joint] = reason
        self._refresh()

    def _why_blocked(self, item: LoadedController) -> str:
        """Return the reason why a controller cannot be started, or an empty string."""
        return next(filter(None, map(self._blocked.get, item.claims)), "")

    def _check_claims(self, running: Sequence[str]) -> None:
        """Raise ClaimError if two controllers claim the same joint or interface.

        A drive follows only one interface at a time.  A controller for an arm mode,
        however, shares the joints with its companions.
        """
        owners: dict[str, str] = {}
        for name in running:
            item = self._loaded[name]
            further = () if item.spec is None else item.spec.further_interfaces
            joints = (f"joint '{joint}'" for joint in item.claims)
            for claim in (*joints, *(f"'{each}'" for each in further)):
                other = owners.setdefault(claim, name)
                if other != name and not self._may_share(item, self._loaded[other]):
                    raise ClaimError(
                        f"controllers '{other}' and '{name}' both claim {claim}; "
                        f"stop one of them{_sharing(item, self._loaded[other])}"
                    )

    @staticmethod
    def _may_share(first: LoadedController, second: LoadedController) -> bool:
        """Return whether either controller is an arm mode that may share its joints."""
        return any(
            one.arm_mode is not None and other.type in one.arm_mode.companions
            for one, other in ((first, second), (second, first))
        )

    def _stop(self, names: Sequence[str], state: JointState) -> None:
        for name in names:
            item = self._loaded[name]
            controller, item.controller = item.controller, None
            item.state = self._stages.stopped
            if controller is not None:
                controller.stop()
            self._disengage(item, state)
            item.effort_law = None

    def _engage(self, item: LoadedController, state: JointState) -> None:
        """Claim the joints of a started controller, unless it waits for a command."""
        item.is_waiting = item.configured.waits_for_command
        if not item.is_waiting:
            self._claim(item, state)

    def _claim(self, item: LoadedController, state: JointState) -> None:
        interface = item.configured.interface
        if item.effort_law is not None:
            self._hardware.claim_efforts(
                item.claims, item.effort_law, state, with_rotors=item.has_rotors
            )
        elif item.is_own:
            self._hardware.claim_servos(item.claims, state)
        elif interface is not None:
            self._hardware.claim(item.claims, interface, state)

    def _disengage(self, item: LoadedController, state: JointState) -> None:
        """Release the joints of a stopped controller."""
        if item.held:
            self._hardware.release(item.held, state)

    def release_brakes(self, name: str, state: JointState) -> None:
        """Claim the joints of a controller that has received its first command."""
        item = self._find(name)
        if item.is_waiting and item.controller is not None:
            item.is_waiting = False
            self._claim(item, state)

    def restart(self, state: JointState) -> None:
        """Restart every running controller, so that it holds ``state``.

        A restart is needed when the state or the time jumps, for example after a reset
        or at the end of an emergency stop.
        """
        for item in self._loaded.values():
            if item.controller is None:
                continue
            old = item.controller
            item.controller = item.started(state)
            old.stop()
            self._disengage(item, state)
            item.effort_law = None
            self._engage(item, state)
        self._refresh()

    def saved(self) -> Mapping[str, SavedController]:
        """Return the current state of the running controllers, by name.

        Raises:
            ControlError: If a goal or an effort law moves the joints of a controller.
        """
        found = {}
        for name in self._names_running():
            item = self._loaded[name]
            if item.effort_law is not None:
                raise ControlError(
                    f"the state of '{name}' cannot be saved: a law drives its joints"
                )
            found[name] = SavedController(
                item.configured, _copied(item), item.is_waiting
            )
        return found

    def check_saved(self, saved: Mapping[str, SavedController]) -> None:
        """Raise ControlError unless the running controllers match ``saved``.

        The parameters of the controllers must also match.
        """
        specs = {name: self._loaded[name].configured for name in self._names_running()}
        if specs != {name: one.spec for name, one in saved.items()}:
            raise ControlError(
                f"the saved state is of controllers {quoted(saved)}, but these run: "
                f"{quoted(specs)}; they must have the same parameters, too"
            )

    def resume(self, saved: Mapping[str, SavedController]) -> None:
        """Continue from the saved states of the running controllers.

        The state of the hardware, including the claims, must be restored separately.
        """
        for name, one in saved.items():
            item = self._loaded[name]
            item.controller = _copied_controller(one.controller, item.configured)
            item.is_waiting = one.is_waiting
        self._refresh()

    def stop_all(self, state: JointState) -> None:
        """Stop every running controller.

        After the stop, the brakes hold all joints.
        """
        self._stop(self._names_running(), state)
        self._refresh()

    # ---- queries ------------------------------------------------------------------

    def running(self, name: str) -> Controller:
        """Return a running controller.

        Raises:
            GoalRejectedError: If the controller is loaded but not running.
            ControlError: If the controller is not loaded.
        """
        item = self._find(name)
        if item.controller is None:
            others = [
                other
                for other in self._names_running()
                if not {*item.claims}.isdisjoint(self._loaded[other].claims)
            ]
            command = start_command(name, others)
            reason = self._why_blocked(item) or f"start it with {command}"
            raise GoalRejectedError(
                f"controller '{name}' is {item.state}, not {self._stages.running}; "
                f"{reason}"
            )
        return item.controller

    def status(self, name: str) -> ControllerStatus:
        """Return the state of a loaded controller."""
        item = self._find(name)
        spec = item.spec
        return ControllerStatus(
            name=name,
            type=item.type,
            role=Role.MOTION if item.is_own else self.dialect.role(item.type),
            state=item.state,
            is_running=item.controller is not None,
            claimed=item.claimed,
            command_interfaces=item.command_interfaces,
            state_interfaces=() if spec is None else spec.state_interfaces,
            blocked=self._why_blocked(item),
        )

    def list(self) -> tuple[ControllerStatus, ...]:
        """Return the state of every loaded controller, in load order."""
        return self._statuses

    def setpoints(self) -> Mapping[str, Setpoint]:
        """Return the setpoints of the running controllers that command positions."""
        return {
            name: setpoint
            for name, current in self._setpoints
            if (setpoint := current()) is not None
        }

    def is_overruled(self, name: str) -> bool:
        """Return whether an effort law overrides a controller's commands."""
        item = self._loaded[name]
        return item.effort_law is not None and not item.is_own

    def spec(self, name: str) -> ControllerSpec:
        """Return the parameters of a configured controller."""
        return self._find(name).configured

    def set_gains(self, name: str, joint: str, **changes: float | bool) -> Gains:
        """Change some of a joint's ``Gains``, and return all of its gains.

        A running controller continues with the new gains.  The gains apply until the
        controller is unloaded.

        Raises:
            ControlError: If there is no such controller or joint, or the controller has
                no gains.
            ConfigError: If the gains are not valid.
        """
        item = self._find(name)
        spec = item.configured
        joints = spec.joints
        if not spec.gains:
            raise ControlError(f"controller '{name}' has no gains: it is {spec.type}")
        if joint not in joints:
            hint = did_you_mean(joint, joints)
            raise ControlError(f"joint '{joint}' is not one of '{name}'{hint}")
        k = joints.index(joint)
        gains = replace(spec.gains[k], **changes)  # type: ignore[arg-type]
        every = (*spec.gains[:k], gains, *spec.gains[k + 1 :])
        item.spec = replace(spec, gains=every)  # type: ignore[type-var]  # dataclasses
        if item.controller is not None and item.controller.pid is not None:
            item.controller.pid.set_gains(k, gains)
        return gains

    def parameters(self, name: str) -> ControllerParameters:
        """Return every parameter of a loaded controller."""
        config = self._find(name).config
        if config is None:
            return ControllerParameters({}, frozenset())
        return config.parameters_of(name, self._robot)

    def set_parameters(self, name: str, changes: Mapping[str, Value]) -> None:
        """Change adjustable parameters of a loaded controller, by dotted name.

        A running controller continues with the new values.  The values apply until the
        controller is unloaded.

        Raises:
            ControlError: If a parameter is unknown or read-only, or if a value has the
                wrong type or is invalid; in this case, nothing changes.
        """
        item = self._find(name)
        given = item.require_config()
        current = given.parameters_of(name, self._robot)
        for parameter, value in changes.items():
            _check_change(name, current, parameter, value)
        config = given.with_parameters(name, changes)
        if item.spec is not None:
            old = item.spec
            try:
                item.spec = spec = config.spec(name, self._robot)
            except ConfigError as error:
                raise ControlError(error.message) from None
            if item.controller is not None:
                _adjust(item.controller, old, spec)
        item.config = config
        self._refresh()

    def _find(self, name: str) -> LoadedController:
        item = self._loaded.get(name)
        if item is not None:
            return item
        valid = list(self._loaded)
        if name in self.config.names:
            raise ControlError(
                f"controller '{name}' is not loaded; load it with "
                f"`tool0 controllers load {name}` or robot.load('{name}')"
            )
        raise ControlError(f"unknown controller '{name}'{did_you_mean(name, valid)}")


def _copied(item: LoadedController) -> Controller:
    """Return a copy of a running controller.

    ControlError is raised if the controller has a goal.
    """
    assert item.controller is not None
    try:
        return _copied_controller(item.controller, item.configured)
    except ControlError as error:
        raise ControlError(
            f"the state of '{item.name}' cannot be saved: {error}"
        ) from None


def _copied_controller(controller: Controller, spec: ControllerSpec) -> Controller:
    """Return a copy of a controller; the copy shares the parameters ``spec``."""
    parts = [getattr(spec, name.name) for name in fields(spec)]  # type: ignore[arg-type]  # dataclasses
    return copy.deepcopy(controller, {id(part): part for part in (spec, *parts)})


def _sharing(*items: LoadedController) -> str:
    """Return a text that lists the types with which an arm mode shares its joints."""
    return "".join(
        f" ('{item.name}' goes with {quoted(sorted(item.arm_mode.companions))} only)"
        for item in items
        if item.arm_mode is not None and item.arm_mode.companions
    )


def _check_change(
    controller: str, current: ControllerParameters, name: str, value: Value
) -> None:
    """Raise ControlError if a parameter cannot be set to ``value``."""
    before = current.values.get(name)
    if before is None:
        raise ControlError(
            f"controller '{controller}' has no parameter '{name}'"
            + did_you_mean(name, current.values)
        )
    if name not in current.adjustable:
        adjustable = ", ".join(sorted(current.adjustable)) or "(none)"
        raise ControlError(
            f"parameter '{name}' of '{controller}' cannot be set because it is "
            f"read-only; these can be set: {adjustable}"
        )
    if type(value) is not type(before):
        raise ControlError(
            f"parameter '{name}' of '{controller}' has type {{{_KIND[type(before)]}}}; "
            f"setting it to {{{_KIND[type(value)]}}} {value!r} is not allowed"
        )


def _adjust(controller: Controller, old: ControllerSpec, new: ControllerSpec) -> None:
    pid = controller.pid
    for k, (before, after) in enumerate(zip(old.gains, new.gains, strict=True)):
        if pid is not None and before != after:
            pid.set_gains(k, after)
    if isinstance(controller, Adjustable):
        controller.adjust(new)
