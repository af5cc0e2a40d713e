"""The controller manager: loads, starts, stops and updates controllers."""

from __future__ import annotations

import enum
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

from tool0.control.config import Controller, ControllerConfig, ControllerSpec
from tool0.control.parameters import Gains, RobotJoints
from tool0.control.trajectory import Setpoint
from tool0.description.model import Joint
from tool0.errors import ClaimError, ControlError, GoalRejectedError, did_you_mean
from tool0.hardware.engine import JointState, as_slice
from tool0.hardware.robot_hardware import RobotHardware

TRAJECTORY_KIND: Final = "JointTrajectoryController"
GRIPPER_KIND: Final = "GripperActionController"


class Strictness(enum.Enum):
    """How a switch handles requests that it cannot fulfil; numbers as in ROS."""

    BEST_EFFORT = 1
    """Do the rest."""
    STRICT = 2
    """Do nothing, and raise."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerStatus:
    """A loaded controller: controller_manager_msgs/ControllerState."""

    name: str
    """Its namespace in the YAML."""
    type: str
    """As in the YAML: ``effort_controllers/JointTrajectoryController``."""
    state: str
    """``initialized`` after loading, then ``running`` or ``stopped``."""
    claimed: tuple[tuple[str, tuple[str, ...]], ...]
    """Each command interface with the joints; claims count while it is running."""

    @property
    def joints(self) -> frozenset[str]:
        """The joints that it drives while it is running."""
        return frozenset(joint for _, joints in self.claimed for joint in joints)

    @property
    def kind(self) -> str:
        """The type without its package: ``JointTrajectoryController``."""
        return self.type.rpartition("/")[2]


def why_not_driven(
    statuses: Sequence[ControllerStatus],
    joints: Collection[str],
    kinds: Collection[str] = (TRAJECTORY_KIND,),
) -> str:
    """Return why no running controller of these kinds drives ``joints``, and a remedy.

    The message is for a request that needs one.
    """
    able = [status for status in statuses if status.kind in kinds]
    known = frozenset[str]().union(*(status.joints for status in able))
    names = ", ".join(f"'{joint}'" for joint in joints)
    problem = f"no running {' or '.join(kinds)} drives {names}"
    stopped = next((s for s in able if s.joints.issuperset(joints)), None)
    if stopped is None:
        unknown = next((joint for joint in joints if joint not in known), "")
        return problem + (did_you_mean(unknown, known) if unknown else "")
    name = stopped.name
    for other in statuses:
        if other.state == "running" and other.joints & stopped.joints:
            return (
                f"{problem}: '{other.name}' is running instead of '{name}'; switch "
                f"with `tool0 controllers switch --stop {other.name} --start {name}` "
                f"or robot.switch(start=['{name}'], stop=['{other.name}'])"
            )
    return (
        f"{problem}: controller '{name}' is {stopped.state}; start it with "
        f"{start_command(name)}"
    )


def start_command(name: str) -> str:
    """Return how to start a loaded controller, for a message."""
    return f"`tool0 controllers start {name}` or robot.switch(start=['{name}'])"


@final
class _Loaded:
    """A controller's parameters, and the controller while it runs."""

    def __init__(self, spec: ControllerSpec, indices: tuple[int, ...]) -> None:
        self.spec = spec
        self.indices = indices
        self.controller: Controller | None = None
        self.state = "initialized"
        self.is_waiting = False
        """Whether the brakes hold its joints until its first command."""

    @property
    def claims(self) -> tuple[str, ...]:
        return () if self.spec.interface is None else self.spec.joints


@final
class ControllerManager:
    """Owns the controllers over one robot's hardware, with ros_control's rules.

    Only the thread that owns the tick may call it.
    """

    def __init__(
        self,
        hardware: RobotHardware,
        config: ControllerConfig,
        joints: Mapping[str, Joint],
    ) -> None:
        """Load nothing yet; ``config`` has the controllers that can be loaded."""
        self._hardware = hardware
        self._config = config
        self._robot = RobotJoints(joints, hardware.interfaces)
        self._loaded: dict[str, _Loaded] = {}
        self._running: list[tuple[str, Controller, slice | None, tuple[int, ...]]] = []
        """Name and controller, and its slots of the command."""
        self.running_controllers: tuple[tuple[Controller, tuple[int, ...]], ...] = ()
        """In load order, with the joints that they command; another tuple whenever a
        controller starts or stops."""
        self.running_specs: tuple[ControllerSpec, ...] = ()
        """Their parameters; the same ones when a controller restarts."""
        self._observers: tuple[Callable[[JointState], None], ...] = ()
        self._setpoints: tuple[tuple[str, Callable[[], Setpoint | None]], ...] = ()
        """Name of each running controller, and what returns its setpoint."""
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
        """Tell the running controllers the state of the last tick."""
        for observe in self._observers:
            observe(state)

    def _refresh(self) -> None:
        self._running = [
            (name, item.controller, as_slice(claims), claims)
            for name, item in self._loaded.items()
            if item.controller is not None
            for claims in [item.indices if item.claims else ()]
        ]
        self.running_controllers = tuple(
            (controller, claims) for _, controller, _, claims in self._running
        )
        self.running_specs = tuple(self._loaded[item[0]].spec for item in self._running)
        self._observers = tuple(item[1].observe for item in self._running)
        self._setpoints = tuple(
            (name, controller.setpoint) for name, controller, *_ in self._running
        )
        self._statuses = tuple(map(self.status, self._loaded))

    # ---- loading ------------------------------------------------------------------

    def load(self, name: str, config: ControllerConfig | None = None) -> None:
        """Check a controller's parameters, from the manager's config or this one.

        Raises:
            ControlError: If it is loaded already.
            ConfigError: If it is unknown, or its parameters are wrong.
        """
        if name in self._loaded:
            raise ControlError(
                f"A controller named '{name}' was already loaded; unload it first"
            )
        spec = (config or self._config).spec(name, self._robot)
        indices = tuple(self._hardware.index[joint] for joint in spec.joints)
        self._loaded[name] = _Loaded(spec, indices)
        self._refresh()

    def unload(self, name: str) -> None:
        """Forget a controller that is not running."""
        if self._find(name).controller is not None:
            raise ControlError(
                f"Could not unload controller '{name}' because it is still running; "
                "stop it first"
            )
        del self._loaded[name]
        self._refresh()

    # ---- switching ----------------------------------------------------------------

    def switch(
        self,
        start: Sequence[str],
        stop: Sequence[str],
        strictness: Strictness,
        state: JointState,
    ) -> tuple[str, ...]:
        """Stop and start controllers at one instant; return why others were skipped.

        Started controllers hold the measured ``state``.

        Raises:
            ControlError: If the switch is impossible; nothing has changed then.
            ClaimError: If two running controllers would claim one joint.
        """
        skipped: list[str] = []
        to_stop, to_start = self._plan(start, stop, strictness, skipped)
        running = [
            name
            for name, item in self._loaded.items()
            if (item.controller is not None and name not in to_stop) or name in to_start
        ]
        self._check_claims(running)
        started = {
            name: self._loaded[name].spec.start(self._loaded[name].indices, state)
            for name in to_start
        }
        self._stop(to_stop, state)
        for name, controller in started.items():
            item = self._loaded[name]
            item.controller = controller
            item.state = "running"
            self._engage(item, state)
        self._refresh()
        return tuple(skipped)

    def _plan(
        self,
        start: Sequence[str],
        stop: Sequence[str],
        strictness: Strictness,
        skipped: list[str],
    ) -> tuple[list[str], list[str]]:
        """Return the controllers to stop and to start, checked in ROS's order."""

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
        for name in self._loaded:
            is_running = self._loaded[name].controller is not None
            if is_running and name in plans["start"] and name in plans["stop"]:
                raise ControlError(
                    f"Controller '{name}' is to be both started and stopped; a running "
                    "controller cannot be restarted by one switch"
                )
            if not is_running and name in plans["stop"]:
                refuse(f"Could not stop controller '{name}' since it is not running")
                plans["stop"].remove(name)
            if is_running and name in plans["start"]:
                refuse(f"Controller '{name}' is already running")
                plans["start"].remove(name)
        return plans["stop"], plans["start"]

    def _check_claims(self, running: Sequence[str]) -> None:
        owners: dict[str, str] = {}
        for name in running:
            for joint in self._loaded[name].claims:
                other = owners.setdefault(joint, name)
                if other != name:
                    raise ClaimError(
                        f"controllers '{other}' and '{name}' both claim joint "
                        f"'{joint}'; stop one of them"
                    )

    def _stop(self, names: Sequence[str], state: JointState) -> None:
        for name in names:
            item = self._loaded[name]
            controller, item.controller = item.controller, None
            item.state = "stopped"
            if controller is not None:
                controller.stop()
            self._disengage(item, state)

    def _engage(self, item: _Loaded, state: JointState) -> None:
        """Hand a started controller its joints, unless it waits for a command."""
        item.is_waiting = item.spec.waits_for_command
        if item.claims and not item.is_waiting:
            self._hardware.claim(item.claims, state)

    def _disengage(self, item: _Loaded, state: JointState) -> None:
        """Take a stopped controller's joints back."""
        if item.claims and not item.is_waiting:
            self._hardware.release(item.claims, state)

    def release_brakes(self, name: str, state: JointState) -> None:
        """Hand a running controller its joints: its first command has arrived."""
        item = self._find(name)
        if item.is_waiting and item.controller is not None:
            item.is_waiting = False
            self._hardware.claim(item.claims, state)

    def restart(self, state: JointState) -> None:
        """Restart every running controller, holding ``state``.

        For jumps of the state or of time: a reset, or the end of an emergency stop.
        """
        for item in self._loaded.values():
            if item.controller is None:
                continue
            old = item.controller
            item.controller = item.spec.start(item.indices, state)
            old.stop()
            self._disengage(item, state)
            self._engage(item, state)
        self._refresh()

    def stop_all(self, state: JointState) -> None:
        """Stop every running controller; the brake holds all joints."""
        self._stop(
            [n for n, item in self._loaded.items() if item.controller is not None],
            state,
        )
        self._refresh()

    # ---- queries ------------------------------------------------------------------

    def running(self, name: str) -> Controller:
        """Return a running controller.

        Raises:
            GoalRejectedError: If it is loaded, but not running.
            ControlError: If it is not loaded.
        """
        item = self._find(name)
        if item.controller is None:
            raise GoalRejectedError(
                f"controller '{name}' is {item.state}, not running; start it with "
                f"{start_command(name)}"
            )
        return item.controller

    def status(self, name: str) -> ControllerStatus:
        """Return the state of a loaded controller."""
        item = self._find(name)
        interface = item.spec.interface
        return ControllerStatus(
            name=name,
            type=item.spec.type,
            state=item.state,
            claimed=() if interface is None else ((interface.value, item.claims),),
        )

    def list(self) -> tuple[ControllerStatus, ...]:
        """Return every loaded controller, in load order."""
        return self._statuses

    def setpoints(self) -> Mapping[str, Setpoint]:
        """Return the setpoints of the running controllers that command a position."""
        return {
            name: setpoint
            for name, current in self._setpoints
            if (setpoint := current()) is not None
        }

    def spec(self, name: str) -> ControllerSpec:
        """Return the parameters of a loaded controller."""
        return self._find(name).spec

    def set_gains(self, name: str, joint: str, **changes: float | bool) -> Gains:
        """Change fields of ``Gains`` of one joint, and return them all.

        A running controller continues with them; they hold until it is unloaded.

        Raises:
            ControlError: If there is no such controller or joint, or it has no gains.
            ConfigError: If the gains are impossible.
        """
        item = self._find(name)
        spec, joints = item.spec, item.spec.joints
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

    def _find(self, name: str) -> _Loaded:
        item = self._loaded.get(name)
        if item is not None:
            return item
        valid = list(self._loaded)
        if name in self._config.names:
            raise ControlError(
                f"controller '{name}' is not loaded; load it with "
                f"`tool0 controllers load {name}` or robot.load('{name}')"
            )
        raise ControlError(f"unknown controller '{name}'{did_you_mean(name, valid)}")
