"""Freedrive and force mode that a controller starts, as in UR's ROS 2 driver.

If a program controls an arm, the ArmMotionController makes the arm compliant.
``ControllerMode`` is for arms that controllers drive.  In force mode, the arm deviates
from the commands of the passthrough controller if this controller is running.  If the
passthrough controller is not running, the arm deviates from its rest position.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

from tool0.control.arm.compliance import Compliance, ComplianceTask
from tool0.control.arm.mode import ArmModeSpec
from tool0.control.arm.motion import ArmMotionSpec
from tool0.control.arm.path import SplineMotion
from tool0.control.manager import ControllerManager
from tool0.errors import ControlError
from tool0.hardware.engine import JointState, joint_selector
from tool0.hardware.robot_hardware import EffortLaw, RobotHardware
from tool0.protocol.state import ArmSetpoint
from tool0.simulation.arms.motion import STIFFENING

if TYPE_CHECKING:
    from tool0.control.ros2.passthrough_trajectory import (
        PassthroughTrajectoryController,
    )

ENDED: Final = "Force mode has ended: the arm stops where it is."


@final
class ControllerMode:
    """Mode of one arm.

    Only the thread that executes the tick may use ``ControllerMode``.
    """

    def __init__(
        self, spec: ArmMotionSpec, hardware: RobotHardware, manager: ControllerManager
    ) -> None:
        """Start without a mode; ``spec`` contains the arm's joints and model."""
        self._spec, self._manager = spec, manager
        self._select = joint_selector([hardware.index[name] for name in spec.joints])
        self._controller = self._host = ""
        """Names of the mode's controller, and of the controller with the joints that
        the law drives (the host)."""
        self._compliance: Compliance | None = None
        self._rest: SplineMotion | None = None
        """Motion from which the arm deviates if no other controller moves the arm."""
        self._is_ending = False
        """Whether the mode is ending: the arm comes to rest, held by springs along all
        axes."""

    @property
    def is_on(self) -> bool:
        """Whether the arm is compliant."""
        return self._compliance is not None and not self._is_ending

    @property
    def is_freedrive(self) -> bool:
        """Whether the arm can be moved manually."""
        compliance = self._compliance
        return self.is_on and compliance is not None and compliance.task.is_freedrive

    @property
    def is_idle(self) -> bool:
        """Whether a call to ``tick`` has no effect."""
        return self._compliance is None

    def start(self, controller: str, task: ComplianceTask, now: JointState) -> None:
        """Make the arm compliant for an active controller, as a task specifies.

        In force mode, a new task replaces the previous task.

        Raises:
            ControlError: If the controller is inactive, or is for another mode or arm.
        """
        self._require(controller, is_freedrive=task.is_freedrive)
        if task.is_freedrive and self.is_freedrive:
            return
        was_on = self.is_on
        self._controller, self._is_ending = controller, False
        if not was_on or task.is_freedrive:
            self._rest = SplineMotion.holding(self._select(now.position), now.time)
        self._comply(task, now)

    def end(self, controller: str, now: JointState, *, is_freedrive: bool) -> None:
        """End the mode of a controller, so that the arm ramps to rest.

        ``end`` has no effect if the mode is not active.

        Raises:
            ControlError: If the controller is inactive, or is for another mode or arm.
        """
        self._require(controller, is_freedrive=is_freedrive)
        if not self.is_on:
            return
        if self._host != self._controller:
            self._return_joints(now)
            return
        self._rest = self._stopping(now)
        self._is_ending = True
        assert self._compliance is not None  # the mode is on
        self._comply(self._compliance.task.stiffened(), now)

    def note_switch(self, now: JointState) -> None:
        """Change the host or end the mode after a switch of controllers."""
        compliance = self._compliance
        if compliance is None:
            return
        running = {status.name for status in self._manager.list() if status.is_running}
        if self._controller not in running:
            if self._host in running:
                self._return_joints(now)
            self.forget()
        elif self._host != self._find_host():
            if self._is_ending:
                self.forget()
                return
            self._rest = self._stopping(now)
            self._comply(compliance.task, now)

    def tick(self, state: JointState) -> None:
        """Update the motion from which the arm deviates in a tick."""
        compliance, rest = self._compliance, self._rest
        if compliance is None or rest is None:
            return
        if self._is_ending and rest.is_done(state.time):
            self._release(state)
            return
        compliance.follow(self._nominal(state.time), state.time)

    def forget(self) -> None:
        """Leave the mode, so that the controllers drive their joints again."""
        self._compliance = self._rest = None
        self._controller = self._host = ""
        self._is_ending = False

    # ---- the joints -----------------------------------------------------------------

    def _comply(self, task: ComplianceTask, now: JointState) -> None:
        """Drive the joints with the control law of a task."""
        compliance = Compliance(self._spec.model, task, self._select)
        self._compliance, self._host = compliance, self._find_host()
        self._manager.drive_efforts(self._host, self._law(compliance), now)

    def _law(self, compliance: Compliance) -> EffortLaw:
        """Return the control law for the joints of the host, in the host's order."""
        joints = self._manager.spec(self._host).joints
        if joints == self._spec.joints:
            return compliance.efforts
        order = [self._spec.joints.index(name) for name in joints]

        def efforts(state: JointState, dt: float) -> list[float]:
            found = compliance.efforts(state, dt)
            return [found[k] for k in order]

        return efforts

    def _find_host(self) -> str:
        """Return the active companion of the mode's controller.

        If there is no active companion, the mode's controller is returned.
        """
        spec = self._manager.spec(self._controller)
        assert isinstance(spec, ArmModeSpec)  # it was checked
        for status in self._manager.list():
            if (
                status.is_running
                and status.type in spec.companions
                and status.joints == set(self._spec.joints)
            ):
                return status.name
        return self._controller

    def _companion(self) -> PassthroughTrajectoryController:
        """Return the host, which must not be the mode's controller itself."""
        from tool0.control.ros2.passthrough_trajectory import (
            PassthroughTrajectoryController,
        )

        running = self._manager.running(self._host)
        assert isinstance(running, PassthroughTrajectoryController)
        return running

    def _return_joints(self, now: JointState) -> None:
        """Hand the joints back to the companion, at their current positions."""
        self._companion().stop_where_it_is(now, ENDED)
        self._release(now)

    def _release(self, now: JointState) -> None:
        self._manager.drive_efforts(self._host, None, now)
        self.forget()

    # ---- the motion from which the arm deviates -------------------------------------

    def _nominal(self, time: float) -> ArmSetpoint:
        rest = self._rest
        assert rest is not None  # the mode is on
        if self._host == self._controller:
            return rest.setpoint(time)
        setpoint = self._companion().setpoint()
        desired = setpoint.desired_motion(self._spec.joints, time)
        assert desired is not None  # it has these joints
        return desired

    def _stopping(self, now: JointState) -> SplineMotion:
        """Return the motion from the measured state to rest."""
        position, velocity = self._select(now.position), self._select(now.velocity)
        zeros = (0.0,) * len(self._spec.joints)
        start = ArmSetpoint(tuple(position), tuple(velocity), zeros)
        return SplineMotion.stopping(start, now.time, STIFFENING)

    # ---- checks ---------------------------------------------------------------------

    def _require(self, controller: str, *, is_freedrive: bool) -> None:
        """Raise ControlError unless a controller is active and provides this mode."""
        self._manager.running(controller)
        spec = self._manager.spec(controller)
        if not isinstance(spec, ArmModeSpec) or spec.is_freedrive != is_freedrive:
            wanted = (
                "FreedriveModeController" if is_freedrive else "ForceModeController"
            )
            raise ControlError(
                f"controller '{controller}' is a {spec.type}; this needs a "
                f"ur_controllers/{wanted}"
            )
        if spec.joints != self._spec.joints:
            raise ControlError(
                f"controller '{controller}' is of the arm with {spec.joints[0]}, not "
                f"of this one"
            )
