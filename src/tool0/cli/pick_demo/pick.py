"""Pick an object from above and place it in a bin."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from tool0.cli.pick_demo.bin import Bin
from tool0.cli.pick_demo.picker import Picker, PickFailure, PickOptions
from tool0.cli.pick_demo.report import PickReport
from tool0.cli.pick_demo.witness import Witness
from tool0.errors import ControlError, ModelError
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot


def pick_and_place(
    robot: Robot,
    item: str,
    into: Bin,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Take an object from above and let it go in a bin; report how it went.

    Nothing of the task is known to the physics: the object is held by friction alone
    (unless the robot has grasp assist).

    Args:
        robot: With one arm that has analytic inverse kinematics, and one gripper.
        item: The name of an upright box, cylinder or sphere that can move.
        into: Where it goes.
        options: How.
        on_snapshot: Called with each snapshot meanwhile, for who records them.

    Raises:
        ControlError: If there is no such object, or it cannot be gripped at all.
        EngineError: If the physics fails.
    """
    options = options or PickOptions()
    witness = Witness(robot, robot.gripper, item, on_snapshot)
    try:
        picker = Picker(robot, item, options, witness)
        start, begun, failure = witness.pose().position, robot.time, None
        try:
            picker.take()
            picker.put(into)
        except (PickFailure, ControlError, ModelError) as error:
            failure = f"while {witness.phase}: {error}"
        witness.begin("")
        return PickReport(
            success=failure is None,
            failure=failure,
            item=item,
            start=start,
            end=witness.pose().position if item in robot.scene else None,
            force=options.force,
            grip_force=picker.force,
            peak_force=witness.peak_force,
            width=picker.width,
            slip=witness.slip,
            duration=robot.time - begun,
            phases=witness.phases,
        )
    finally:
        witness.close()
