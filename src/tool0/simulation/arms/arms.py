"""All arms of a robot, which are found by name and share one tick."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from tool0.control.manager import ControllerManager
from tool0.description.model import RobotModel
from tool0.description.parts import find_arms
from tool0.description.scene_state import Contact
from tool0.errors import ControlError, did_you_mean
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.own_drives import OwnDrives, RobotReport
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.state import ArmSample
from tool0.simulation.arms.arm import Arm
from tool0.simulation.arms.real_arm import RealArm
from tool0.simulation.arms.simulated_arm import SimulatedArm


@final
class Arms:
    """All arms, in the order of the model.

    Only the thread that executes the tick may use ``Arms``.
    """

    def __init__(
        self,
        model: RobotModel,
        engine: Engine,
        hardware: RobotHardware,
        manager: ControllerManager,
    ) -> None:
        found = find_arms(model).items()
        if isinstance(engine, OwnDrives):
            self._real = tuple(
                RealArm(
                    *(name, parts, engine),
                    model=model,
                    hardware=hardware,
                    manager=manager,
                )
                for name, parts in found
            )
            self._arms: tuple[Arm, ...] = self._real
        else:
            self._real = ()
            self._arms = tuple(
                SimulatedArm(
                    *(name, parts),
                    model=model,
                    engine=engine,
                    hardware=hardware,
                    manager=manager,
                )
                for name, parts in found
            )
        self.boxes: tuple[ControlBoxState, ...] = ()
        """State of each control box.  The tuple of states is replaced when a state
        changes."""
        self._note_change()
        for arm in self._arms:
            arm.box.when_changed = self._note_change
        manager.when_switched = self._note_switch

    def __iter__(self) -> Iterator[Arm]:
        return iter(self._arms)

    def find(self, name: str | None) -> Arm:
        """Return an arm by name, or the only arm if no name is given.

        Raises:
            ControlError: If there is no such arm, or if there are several arms and no
                name is given.
        """
        if name is None and len(self._arms) == 1:
            return self._arms[0]
        names = [arm.name for arm in self._arms]
        if name is None:
            raise ControlError(
                "'arm' is needed unless the robot has exactly one, this one has: "
                f"{', '.join(names) or 'none'}"
            )
        if name not in names:
            raise ControlError(f"no arm '{name}'{did_you_mean(name, names)}")
        return self._arms[names.index(name)]

    @property
    def is_idle(self) -> bool:
        """Whether a call to ``tick`` has no effect."""
        return all(arm.is_idle for arm in self._arms)

    def tick(self, state: JointState, period: float) -> None:
        """Advance all arms that are not idle by one tick of ``period`` [s]."""
        for arm in self._arms:
            if not arm.is_idle:
                arm.tick(state, period)

    def follow(self, report: RobotReport, now: JointState) -> None:
        """Publish a real robot's report, and follow the stops of the robot."""
        for arm in self._real:
            arm.follow(report, now)

    def samples(
        self,
        now: float,
        before: JointState,
        after: JointState,
        forces: tuple[Contact, ...],
    ) -> Mapping[str, ArmSample]:
        """Return a sample of each arm's motion and tool wrench at ``now`` [s].

        In the last physics step, the state changed from ``before`` to ``after`` under
        the external ``forces``.
        """
        return {arm.name: arm.sample(now, before, after, forces) for arm in self}

    def _note_switch(self, state: JointState) -> None:
        for arm in self._arms:
            arm.note_switch(state)

    def _note_change(self) -> None:
        self.boxes = tuple(arm.box.state for arm in self._arms)
