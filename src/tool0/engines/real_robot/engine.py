"""Engine ``hardware``, which uses a real UR and its gripper instead of a simulator.

The state of the engine is the state that the robot reports.  The robot sends one report
in each period of its controller.  The engine does not write efforts, because the
robot's drives follow motions.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple, final

from msgspec.structs import replace

from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.parts import ArmParts, find_arms, find_grippers
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.description.scene_state import Wrench
from tool0.devices.robotiq_counts import FULL, Counts
from tool0.devices.robotiq_registers import ObjectStatus
from tool0.engines.real_robot.connection import RobotConnection
from tool0.engines.real_robot.control_program import (
    REGISTERS,
    CommandKind,
    ProgramMode,
    StopCause,
)
from tool0.engines.real_robot.curve import CurveSender
from tool0.engines.real_robot.declared_world import DeclaredWorld
from tool0.engines.real_robot.flange_frames import FlangeFrames
from tool0.engines.real_robot.options import RealRobotOptions
from tool0.engines.real_robot.robot_state import StateReader, first_package
from tool0.engines.real_robot.rtde_fields import program_state
from tool0.errors import ConfigError
from tool0.hardware.engine import JointState, NativeStepper, World
from tool0.hardware.own_drives import (
    OwnDrives,
    RobotReport,
    Wanted,
    WantedGrip,
    WantedMotion,
)
from tool0.protocol.control_box_state import Pose6, ProgramState, RobotLink

logger = logging.getLogger(__name__)

_HOLDING: Final = frozenset({ObjectStatus.MET_CLOSING, ObjectStatus.MET_OPENING})
LOST: Final = "the connection to the robot was lost"
STREAM_LOOK: Final = 0.1
"""Time between two checks of the extrapolated motion of a stream [s]."""
CAUSES: Final = {
    StopCause.SILENT: "the robot received nothing from tool0 for 0.1 s",
    StopCause.RAN_OUT: "the robot ran out of knots: tool0 or the network was late",
    StopCause.TOO_FAR: "a new motion was too far from the present one",
}
AT_REST: Final = "the arm stopped on its own"
RESTART_TIME: Final = 0.1
"""Longest time until the program reports that it follows motions again [s]."""
ENDED: Final = "tool0's program on the robot has ended"
GRIPPER_DELAY: Final = 0.3
"""Longest time until the readings of the gripper show the effect of a command [s].
The value is an estimate for several exchanges with the URCap and the start of the
motor."""


class _Fingers(NamedTuple):
    """A gripper and its driven joint."""

    geometry: ParallelGripper
    counts: Counts
    place: int
    """Index of the driven joint in the order of the engine's joints."""


@final
class RealRobotEngine(OwnDrives):
    """Engine that reads a real robot's state and sends motions to the robot.

    Any thread may use ``brake`` and ``connection``; only the thread of the tick may use
    the rest.
    """

    name: Final = "hardware"

    def __init__(
        self,
        description: RobotDescription,
        *,
        ground: float | None,
        scene: Scene,
        options: RealRobotOptions,
    ) -> None:
        """Connect to the robot for reading only.

        Raises:
            TransportError: If the robot cannot be reached.
            ConfigError: If the description does not consist of one arm and at most one
                gripper.
        """
        model = description.model
        self.arm_name, self.arm = _only_arm(model)
        self.joint_names = tuple(joint.name for joint in model.movable_joints)
        index = {name: i for i, name in enumerate(self.joint_names)}
        self._arm_indices = [index[joint.name] for joint in self.arm.joints]
        self._grippers = {
            name: _Fingers(geometry, Counts(geometry), index[geometry.joint])
            for name, geometry in find_grippers(model).items()
        }
        if len(self._grippers) > 1:
            raise ConfigError("a real robot with several grippers is not supported")
        self._followers = [
            (index[joint.name], index[joint.mimic.joint], joint.mimic)
            for joint in model.movable_joints
            if joint.mimic is not None
        ]
        self._frames = FlangeFrames(model, self.arm)
        self._declared = DeclaredWorld(scene, ground)
        self.connection = RobotConnection(options, has_gripper=bool(self._grippers))
        try:
            rtde = self.connection.rtde
            self.reader = StateReader(rtde, first_package(rtde))
            """Reader of the robot's reports."""
        except BaseException:
            self.connection.close()
            raise
        self._period = self.reader.period
        self._curve = CurveSender(self.connection.link, self.arm.joints, self._period)
        self._arm_state = self.reader.state
        self._fields: tuple[Any, ...] = ()
        """Values of which the report was made; empty if the next step must make a new
        report."""
        self._wanted_grips: Mapping[str, WantedGrip] = {}
        self._is_enabled = False
        self._has_followed = False
        self._rests_since = 0
        """Last tick at which the program had not brought the arm to rest."""
        self._patience = round(RESTART_TIME / self._period)
        self._is_guided = False
        """Whether the arm does not follow motions, either because freedrive is active
        or because freedrive or force mode is ending."""
        self._resumes_at: int | None = None
        """Earliest tick at which the arm follows motions again after freedrive or force
        mode."""
        self.guard: Callable[[WantedMotion, float], str] = lambda motion, now: ""
        """Function that returns the reason why a motion must not be sent, or an empty
        text if the motion may be sent."""
        self._key: tuple[object, ...] = ()
        """Key of the last motion that the guard checked."""
        self._looked = -math.inf
        """Time of the last check by the guard [s]."""
        self._failure = ""
        self._report = self._first_report(options)

    # ---- the engine -----------------------------------------------------------------

    @property
    def dt(self) -> float:
        """Period of the robot's controller [s]."""
        return self._period

    @property
    def world(self) -> World:
        return self._declared

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        """Do nothing, since a real robot cannot be reset."""

    def read(self) -> JointState:
        state = self._arm_state
        n = len(self.joint_names)
        position, velocity, effort = [0.0] * n, [0.0] * n, [0.0] * n
        for k, i in enumerate(self._arm_indices):
            position[i] = state.positions[k]
            velocity[i] = state.velocities[k]
            effort[i] = state.efforts[k]
        for fingers in self._grippers.values():
            self._read_gripper(fingers, position, effort)
        for i, leader, mimic in self._followers:
            position[i] = mimic.multiplier * position[leader] + mimic.offset
        return JointState(state.tick * self._period, position, velocity, effort)

    def _read_gripper(
        self, fingers: _Fingers, position: list[float], effort: list[float]
    ) -> None:
        geometry, counts, i = fingers
        gripper = self.connection.gripper
        reading = None if gripper is None else gripper.reading
        count = counts.open if reading is None else reading.position
        position[i] = geometry.position(counts.opening(count))
        if reading is not None and reading.object_status in _HOLDING:
            wanted = self._wanted_grips.get(geometry.name)
            force = geometry.force[1]
            if wanted is not None and wanted.limits and wanted.limits.force:
                force = wanted.limits.force
            closes = reading.object_status is ObjectStatus.MET_CLOSING
            push = force * geometry.lever(position[i])
            effort[i] = push if closes else -push

    def write(self, effort: Sequence[float]) -> None:
        """Do nothing, since the robot controls its efforts."""

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        """Do nothing, since the robot controls its brakes."""

    @property
    def has_rotors(self) -> bool:
        return False

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        """Do nothing, since the rotors of a real robot cannot be set."""

    @property
    def stepper(self) -> NativeStepper | None:
        return None

    def step(self) -> None:
        """Wait for the robot's next period."""
        client = self.connection.reconnected()
        if client is not None:
            self.reader.reconnect(client)
        was_connected = self.reader.is_connected
        self._arm_state = self.reader.next()
        if was_connected and not self.reader.is_connected:
            self._note_loss()
        self._update_report()

    def close(self) -> None:
        self.connection.close()

    # ---- drives of the robot --------------------------------------------------------

    def follow(self, wanted: Wanted) -> None:
        if not self._is_enabled:
            return
        state, arm = self._arm_state, wanted.arm
        self._look_for_end(state.tick)
        if arm is None:
            if self._has_followed:
                self.connection.link.brake()
                self._curve.restart()
                self._has_followed = False
        elif state.step and not self._failure and not self._is_guided:
            if reason := self._objection(arm, wanted.now.time):
                self.connection.link.brake()
                self._fail(reason)
                return
            self._has_followed = True
            self._curve.follow(arm, wanted.now.time, state.step, state.positions)
        if wanted.grips != self._wanted_grips:
            self._grip(wanted.grips)

    def _look_for_end(self, tick: int) -> None:
        """Follow motions again when the program has ended freedrive or force mode."""
        if self._resumes_at is None or tick < self._resumes_at:
            return
        mode = self.reader.fields.number(self.reader.newest, REGISTERS[1])
        if mode != ProgramMode.GUIDED:
            self._is_guided, self._resumes_at = False, None
            self._curve.restart()

    def _objection(self, arm: WantedMotion, now: float) -> str:
        """Return the reason why a motion must not be sent, or an empty text.

        The guard checks each curve once, and checks streams at intervals of
        ``STREAM_LOOK``.
        """
        if arm.is_streamed:
            is_due = now - self._looked >= STREAM_LOOK
        else:
            is_due = arm.key != self._key
        if not is_due:
            return ""
        self._key, self._looked = arm.key, now
        return self.guard(arm, now)

    def _grip(self, grips: Mapping[str, WantedGrip]) -> None:
        """Send each changed command once; a lost command is not repeated."""
        before, self._wanted_grips = self._wanted_grips, grips
        gripper = self.connection.gripper
        for name, fingers in self._grippers.items():
            wanted = grips.get(name)
            if gripper is None or wanted is None or wanted == before.get(name):
                continue
            if name not in before and self._is_there(fingers, wanted):
                continue  # a new controller holds the current position
            geometry, counts, _ = fingers
            speed, force = geometry.speed[1], geometry.force[1]
            if wanted.limits is not None:
                speed = wanted.limits.speed or speed
                force = wanted.limits.force or force
            gripper.move(
                counts.count(wanted.position),
                _count(geometry.speed, speed),
                _count(geometry.force, force),
            )

    def _is_there(self, fingers: _Fingers, wanted: WantedGrip) -> bool:
        gripper = self.connection.gripper
        reading = None if gripper is None else gripper.reading
        count = fingers.counts.count(wanted.position)
        return reading is None or abs(reading.position - count) <= 2

    @property
    def start_delay(self) -> float:
        return self.reader.lateness.start_delay

    @property
    def gripper_delay(self) -> float:
        return GRIPPER_DELAY

    @property
    def report(self) -> RobotReport:
        return self._report

    @property
    def missing(self) -> int:
        """Number of periods without a package while the robot was connected."""
        return self.reader.missing

    @property
    def wrench(self) -> Wrench:
        reader = self.reader
        force = reader.fields.vector(reader.newest, "actual_TCP_force")
        return self._frames.at_flange(
            force, self._report.tcp, self._arm_state.positions
        )

    @property
    def currents(self) -> tuple[float, ...]:
        return self.reader.fields.vector(self.reader.newest, "actual_current")

    @property
    def gripping(self) -> frozenset[str]:
        gripper = self.connection.gripper
        reading = None if gripper is None else gripper.reading
        if reading is None or reading.object_status not in _HOLDING:
            return frozenset()
        return frozenset(fingers.geometry.name for fingers in self._grippers.values())

    @property
    def gripper_problem(self) -> str:
        """Reason why the gripper cannot move; empty if there is no problem."""
        gripper = self.connection.gripper
        return "" if gripper is None else gripper.problem

    def brake(self) -> None:
        self.connection.link.brake()

    def set_digital_outputs(self, pins: Mapping[int, bool]) -> None:
        for kind, first in (("standard", 0), ("configurable", 8)):
            own = {k - first: v for k, v in pins.items() if first <= k < first + 8}
            if own:
                mask = sum(1 << pin for pin in own)
                levels = sum(1 << pin for pin, level in own.items() if level)
                self.connection.rtde.send(kind, (mask, levels))
        for pin in range(16, 18):
            if pin in pins:
                self._command(CommandKind.TOOL_OUTPUT, (pin - 16, pins[pin]))

    def set_analog_output(self, pin: int, value: float, *, is_voltage: bool) -> None:
        kinds = (1 << pin) if is_voltage else 0
        values = [0.0, 0.0]
        values[pin] = value
        self.connection.rtde.send("analog", (1 << pin, kinds, *values))

    def set_speed_slider(self, fraction: float) -> None:
        self.connection.rtde.send("slider", (1, fraction))

    def start_force_mode(
        self,
        frame: Pose6,
        selection: Sequence[bool],
        wrench: Sequence[float],
        kind: int,
        limits: Sequence[float],
    ) -> None:
        numbers = (*frame, *map(float, selection), *wrench, kind, *limits)
        self._command(CommandKind.FORCE_MODE, numbers)

    def end_force_mode(self) -> None:
        self._command(CommandKind.END_FORCE_MODE)
        self._end_mode()

    def start_freedrive(self, axes: Sequence[bool], frame: Pose6) -> None:
        self._has_followed, self._is_guided = False, True
        self._resumes_at = None
        self._command(CommandKind.FREEDRIVE, (*map(float, axes), *frame))

    def end_freedrive(self) -> None:
        self._command(CommandKind.END_FREEDRIVE)
        self._end_mode()

    def _end_mode(self) -> None:
        """Record that the program is ending freedrive or force mode."""
        self._has_followed, self._is_guided = False, True
        self._resumes_at = self._arm_state.tick + self._patience

    def _command(self, kind: CommandKind, arguments: Sequence[float] = ()) -> None:
        self.connection.link.command(kind, arguments)

    @property
    def is_program_running(self) -> bool:
        """Whether a program runs on the controller; all threads may read this."""
        reader = self.reader
        state = reader.fields.number(reader.newest, "runtime_state")
        return program_state(state) is not ProgramState.STOPPED

    @property
    def is_program_ready(self) -> bool:
        """Whether tool0's program counts its periods; all threads may read this."""
        reader = self.reader
        return bool(
            self.is_program_running
            and reader.fields.number(reader.newest, REGISTERS[1])
            == ProgramMode.STARTING
            and reader.state.step
        )

    # ---- permission to move ---------------------------------------------------------

    def set_enabled(self, enabled: bool) -> None:
        """Enable or disable motions; call this method in the tick's thread."""
        self._is_enabled, self._failure = enabled, ""
        self._fields = ()
        self._has_followed = self._is_guided = False
        self._resumes_at = None
        self._wanted_grips = {}
        self._curve.restart()
        self._show(is_enabled=enabled)

    def forgive(self) -> None:
        """Clear the failure that stopped the arm, after the user has been informed."""
        self._failure = ""
        self._fields = ()
        self._curve.restart()

    def show(self, **changes: Any) -> None:
        """Change properties of the reported link, in the tick's thread."""
        self._show(**changes)

    # ---- the report -----------------------------------------------------------------

    def _first_report(self, options: RealRobotOptions) -> RobotReport:
        reader = self.reader
        self._fields = reader.fields.status(reader.newest)
        boxes = reader.fields.boxes(reader.newest)
        boxes["program"] = ProgramState.STOPPED
        version = ".".join(map(str, self.connection.rtde.version[:3]))
        link = RobotLink(address=options.address, software=version)
        return RobotReport(link=link, **boxes)

    def _update_report(self) -> None:
        reader = self.reader
        mode = reader.fields.number(reader.newest, REGISTERS[1])
        self._watch_program(int(mode))
        fields = (
            *reader.fields.status(reader.newest),
            *(mode, reader.is_connected, self.connection.link.is_connected),
            self.gripper_problem,
        )
        if fields == self._fields:
            return
        self._fields = fields
        boxes = reader.fields.boxes(reader.newest)
        is_running = boxes["program"] is not ProgramState.STOPPED
        is_linked = self.connection.link.is_connected
        is_ours = self._is_enabled and is_linked and is_running
        if self._is_enabled and not is_ours:
            self._fail(ENDED if reader.is_connected else LOST)
        if not is_ours:
            boxes["program"] = ProgramState.STOPPED
        link = replace(
            self._report.link,
            is_connected=reader.is_connected,
            gripper_problem=self.gripper_problem,
        )
        self._report = RobotReport(link=link, motion_failure=self._failure, **boxes)

    def _watch_program(self, mode: int) -> None:
        """Report a failure if the program brought the arm to rest without a command."""
        if mode != ProgramMode.RESTING or not self._has_followed or self._failure:
            self._rests_since = self._arm_state.tick
        elif self._arm_state.tick - self._rests_since > self._patience:
            reader = self.reader
            cause = int(reader.fields.number(reader.newest, REGISTERS[2]))
            self._fail(CAUSES.get(StopCause(cause), AT_REST) if cause else AT_REST)

    def _note_loss(self) -> None:
        """Disconnect; no motion resumes automatically after a reconnection."""
        logger.warning("%s", LOST)
        self.connection.link.disconnect()
        self.connection.note_loss()
        if self._is_enabled:
            self._fail(LOST)

    def _fail(self, reason: str) -> None:
        if not self._failure:
            logger.warning("the arm comes to rest: %s", reason)
        self._failure = self._failure or reason
        self._fields = ()
        self._has_followed = False
        if reason in {LOST, ENDED}:
            self._is_enabled = False
            self._show(is_enabled=False)

    def _show(self, **changes: Any) -> None:
        link = replace(self._report.link, **changes)
        self._report = replace(self._report, link=link, motion_failure=self._failure)


def _only_arm(model: RobotModel) -> tuple[str, ArmParts]:
    arms = find_arms(model)
    if len(arms) != 1:
        raise ConfigError(
            f"a real robot is one arm; this description has {len(arms)}: "
            "bring up each arm separately"
        )
    return next(iter(arms.items()))


def _count(span: tuple[float, float], value: float) -> int:
    low, high = span
    return min(max(round(FULL * (value - low) / (high - low)), 0), FULL)
