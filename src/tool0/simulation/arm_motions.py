"""The motions of arms that a program has taken from the controllers of ROS."""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from functools import partial
from typing import Final, final

from tool0.control.arm.compliance import ComplianceTask
from tool0.control.arm.motion import ArmMotionController, ArmMotionSpec
from tool0.control.arm.path import ArmPath
from tool0.control.controller import TrajectoryFollower
from tool0.control.manager import ControllerManager
from tool0.description.model import FLANGE, Interface, RobotModel
from tool0.description.parts import find_arms
from tool0.errors import ControlError
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.state import ArmSample, Wrench
from tool0.simulation.arm_mechanics import ArmMechanics
from tool0.simulation.arm_modes import ArmModes
from tool0.simulation.control_boxes import ControlBoxes

logger = logging.getLogger(__name__)

RETURN_BRAKE: Final = 4.0
"""Change of a path's speed when its arm is given back while it moves [1/s²]: a path at
full speed ends within 0.25 s."""
RETURN_DECELERATION: Final = 4.0
"""Of any other motion then, at least [rad/s²]: a stream of velocities ends as soon as
with its own acceleration."""
SETTLING: Final = 0.1
"""From when the setpoint of an arm rests until the arm does [s]: its servos lag by some
20 ms."""
STIFFENING: Final = 10.0
"""Deceleration when force mode or freedrive ends while the arm moves, or a motion fails
[rad/s²]."""


_Supervised = tuple[
    object,
    tuple[ControlBoxState, ...],
    tuple[tuple[str, ArmMotionController], ...],
]
"""Running controllers, control boxes, and what follows from them until they change."""


@final
class ArmMotions:
    """Gives arms to programs and back, and finds what moves them.

    Only the thread of the tick may use it.  A taken arm is moved by an
    ArmMotionController, which exists until the arm is given back.
    """

    def __init__(
        self,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        boxes: ControlBoxes,
        modes: ArmModes,
    ) -> None:
        self._manager, self._boxes, self._modes = manager, boxes, modes
        self._hardware = hardware
        limits, self._index = hardware.limits, hardware.index
        self.specs = {
            name: ArmMotionSpec(
                name=f"{prefix}arm_motion",
                joint_models=tuple(
                    replace(joint, limits=limits.get(joint.name, joint.limits))
                    for joint in arm.joints
                ),
                speed_scaling=partial(hardware.speed_scaling.__getitem__, prefix),
                model=ArmMechanics(model, name, hardware),
            )
            for name, arm in find_arms(model).items()
            for prefix in [arm.flange.removesuffix(FLANGE)]
        }
        """What moves each arm while it is taken, by the arm's name."""
        self._taken: dict[str, bool] = {}
        """The taken arms, and whether a failed motion of each is a protective stop."""
        self._returning: dict[str, float] = {}
        """The arms that are given back once they rest, and from when they do [s]."""
        self._supervised: _Supervised | None = None
        self._paths = dict.fromkeys(self.specs, 0)
        """How many paths each arm was given."""
        modes.when_stopped = self.abort

    @property
    def is_idle(self) -> bool:
        """Whether ``tick`` has nothing to do."""
        return not self._returning

    @property
    def has_taken(self) -> bool:
        """Whether a program has taken an arm."""
        return bool(self._taken)

    def tick(self, state: JointState) -> None:
        """Give back the arms that have come to rest."""
        now = state.time
        for arm, rests_at in list(self._returning.items()):
            if not self._controller(arm).is_done(now):
                continue
            if now >= rests_at:
                self._release(arm, state)
            else:
                self._returning[arm] = min(rests_at, now + SETTLING)

    # ---- requests, between ticks ----------------------------------------------------

    def take(
        self, arm: str | None, by: str, now: JointState, *, protected: bool = False
    ) -> str:
        """Let a program move an arm; return the name of the controller that does.

        The arm holds still, and its controllers stop.  If the arm is taken already,
        the program's name changes, and it may move again after a failed motion.
        ``protected`` makes a failed motion a protective stop.

        Raises:
            ControlError: If the arm may not move.
        """
        held = self._desired(self._boxes.find(arm).arm, now)
        name = self._modes.take(arm, by, now).arm
        if self._returning.pop(name, None) is not None:
            controller = self._controller(name)
            if controller.motion(now.time).is_at_rest:
                controller.hold(now.time)
        if name not in self._taken:
            self._manager.start_own(self.specs[name], now)
            if held is not None:
                self._controller(name).rest_at(held, now.time)
        self._taken[name] = protected
        self._boxes.change(self._boxes.find(name), motion_failure="")
        return self.specs[name].name

    def release(self, arm: str | None, now: JointState) -> None:
        """Stop an arm, and start its controllers again once it rests."""
        name = self._boxes.find(arm).arm
        if name not in self._taken or name in self._returning:
            return
        controller = self._controller(name)
        self._stiffen(name, now)
        if controller.motion(now.time).is_at_rest and controller.mode != "path":
            self._release(name, now)
            return
        on_path = controller.mode == "path"
        rate = max(RETURN_DECELERATION, controller.stream_deceleration())
        rate = RETURN_BRAKE if on_path else rate
        controller.stop_motion(rate, now.time, along_path=on_path)
        self._returning[name] = math.inf

    def is_returning(self, arm: str) -> bool:
        """Return whether an arm stops in order to be given back."""
        return arm in self._returning

    def abort(self, arm: str, now: JointState) -> None:
        """Take an arm from its program at once: the brakes stop it."""
        self._returning.pop(arm, None)
        if self._taken.pop(arm, None) is not None:
            self._manager.stop_own(self.specs[arm].name, now)
            self._boxes.change(self._boxes.find(arm), motion_failure="")

    def supervised(self) -> tuple[tuple[str, ArmMotionController], ...]:
        """Return the taken arms whose motion has not failed, and what moves them."""
        running, boxes = self._manager.running_controllers, self._boxes.states
        known = self._supervised
        if known is None or running is not known[0] or boxes is not known[1]:
            found = tuple(
                (box.arm, self._controller(box.arm))
                for box in boxes
                if box.arm in self._taken and not box.motion_failure
            )
            self._supervised = known = running, boxes, found
        return known[2]

    def fail(self, arm: str, reason: str, now: JointState) -> None:
        """End the motion of a taken arm: it rests where it is, and pushes no more.

        What comes from its program is refused, with the reason, until the program
        takes the arm again.
        """
        if self._taken[arm]:
            self._modes.stop_protectively(arm, reason, now)
            return
        logger.warning("arm '%s' stops where it is: %s", arm, reason)
        self._rest(arm, now)
        self._refuse(arm, reason)

    def find(self, arm: str | None) -> ArmMotionController:
        """Return what moves a taken arm that may move, and whose motion did not fail.

        Raises:
            ControlError: If the arm is not taken, or may not move.
        """
        controller = self.find_to_stop(arm)
        box = self._boxes.find(arm)
        if box.motion_failure:
            raise ControlError(
                f"the arm '{box.arm}' has stopped: {box.motion_failure}; take it "
                "again with `take_arm` before you move it"
            )
        return controller

    def find_to_stop(self, arm: str | None) -> ArmMotionController:
        """Return what moves a taken arm that may move.

        Raises:
            ControlError: If the arm is not taken, or may not move.
        """
        name = self._modes.require_ready(arm).arm
        if name not in self._taken:
            raise ControlError(
                f"no program moves the arm '{name}'; take it first with `take_arm`"
            )
        if name in self._returning:
            raise ControlError(
                f"the arm '{name}' stops and is given back; take it again first"
            )
        return self._controller(name)

    def execute(
        self,
        arm: str | None,
        path: ArmPath,
        now: float,
        *,
        after: int | None = None,
        at: float | None = None,
    ) -> int:
        """Let an arm follow a path; return the path's number.

        It starts ``now`` [s], or replaces path ``after`` from that one's time ``at``
        [s] on.

        Raises:
            ControlError: If it is not possible; the arm's motion then continues.
        """
        controller = self.find(arm)
        name = self._boxes.find(arm).arm
        number = self._paths[name] + 1
        if after is None or at is None:
            controller.execute(path, number, now)
        else:
            controller.replace(path, number, after=after, at=at, now=now)
        self._paths[name] = number
        return number

    def rest(self, arm: str, now: JointState) -> tuple[float, ...]:
        """Return where an arm that rests is commanded to be, or is [rad]."""
        if arm in self._taken:
            return tuple(self._controller(arm).motion(now.time).positions)
        spec = self.specs[arm]
        measured = tuple(now.position[self._index[name]] for name in spec.joints)
        return self._desired(arm, now) or measured

    def sample(self, arm: str, now: float, wrench: Wrench) -> ArmSample:
        """Return what moves an arm ``now`` [s]; ``wrench`` is that on its tool."""
        joints = self.specs[arm].joints
        if arm not in self._taken:
            last = self._paths[arm]
            return ArmSample(
                "free", None, last, 0.0, True, False, wrench, joint_names=joints
            )
        controller = self._controller(arm)
        number, time = controller.progress(now)
        failure = self._boxes.find(arm).motion_failure
        return ArmSample(
            controller.mode,
            controller.unknown_setpoint(now),
            number,
            time,
            not failure and controller.is_done(now),
            controller.is_in_force_mode,
            wrench,
            failure,
            joints,
        )

    # ---- force mode and freedrive ---------------------------------------------------

    def comply(self, arm: str | None, task: ComplianceTask, now: JointState) -> None:
        """Let a taken arm push with a force, or give way to a hand.

        Raises:
            ControlError: If the arm is not taken, or may not move.
        """
        controller, name = self.find(arm), self._boxes.find(arm).arm
        if controller.is_guided and not task.is_freedrive:
            raise ControlError(
                f"the arm '{name}' is in freedrive; end that before force mode"
            )
        law = controller.start_compliance(task, now)
        self._manager.drive_efforts(self.specs[name].name, law, now)
        self._modes.set_freedrive(name, task.is_freedrive, now)

    def stiffen(self, arm: str | None, now: JointState, *, is_freedrive: bool) -> None:
        """End force mode, or freedrive: the arm stops where it is.

        Without it, nothing changes.

        Raises:
            ControlError: If the arm is not taken, or may not move.
        """
        controller, name = self.find_to_stop(arm), self._boxes.find(arm).arm
        if controller.is_guided == is_freedrive:
            self._stiffen(name, now)

    def note_restart(self, now: JointState, stopped: str = "") -> None:
        """Note that controllers were restarted: freedrive and force mode have ended.

        ``stopped`` is why no program may go on as if nothing had happened.
        """
        self._returning = dict.fromkeys(self._returning, now.time)
        for arm in self._taken:
            self._modes.set_freedrive(arm, False, now)
            if stopped:
                self._refuse(arm, stopped)

    def _desired(self, arm: str, now: JointState) -> tuple[float, ...] | None:
        """Return where a controller wants an arm to rest, if one does.

        A controller of efforts that has just started lets the arm sag until its
        integral carries it.  To hold where the arm is then would lower it a little
        more whenever it is taken.
        """
        joints = self.specs[arm].joints
        for status in self._manager.list():
            if not (status.is_running and status.joints >= frozenset(joints)):
                continue
            controller = self._manager.running(status.name)
            if not isinstance(controller, TrajectoryFollower):
                continue
            names = controller.spec.joints
            desired = controller.query_state(now.time)
            order = [names.index(joint) for joint in joints]
            if not any(desired.velocities[k] for k in order):
                return tuple(desired.positions[k] for k in order)
        return None

    def _stiffen(self, arm: str, now: JointState) -> None:
        if self._controller(arm).is_compliant:
            self._rest(arm, now)
            self._modes.set_freedrive(arm, False, now)

    def _rest(self, arm: str, now: JointState) -> None:
        """Ramp to rest from the measured motion, with servos that have no past."""
        self._manager.drive_efforts(self.specs[arm].name, None, now)
        self._controller(arm).end_compliance(now, STIFFENING)

    def _refuse(self, arm: str, reason: str) -> None:
        box = self._boxes.find(arm)
        self._boxes.change(box, motion_failure=box.motion_failure or reason)

    def _controller(self, arm: str) -> ArmMotionController:
        running = self._manager.running(self.specs[arm].name)
        assert isinstance(running, ArmMotionController)  # it has this spec
        return running

    def _release(self, arm: str, now: JointState) -> None:
        wanted = self._controller(arm).at_rest(now)
        self.abort(arm, now)
        self._modes.release(arm, wanted)
        self._preload_integrals(arm, now)

    def _preload_integrals(self, arm: str, now: JointState) -> None:
        """Let controllers of efforts start with those that hold the arm now.

        With an integral of 0 the arm would sag until it has built up.
        """
        joints, claimed = set(self.specs[arm].joints), self._hardware.claimed
        for status in self._manager.list():
            if not (status.is_running and status.joints & joints):
                continue
            controller = self._manager.running(status.name)
            if not isinstance(controller, TrajectoryFollower) or not controller.pid:
                continue
            for k, name in enumerate(controller.spec.joints):
                if name not in joints or claimed.get(name) is not Interface.EFFORT:
                    continue
                if not self._hardware.compensates_gravity(name):
                    effort = now.effort[self._index[name]]
                    controller.pid.set_contribution(k, effort)
