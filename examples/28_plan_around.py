"""Move around obstacles: check a motion, plan a path, and carry an object along it."""

import math

import tool0
from tool0.scene import Pose

# in the tool0 frame, with the pads 45 mm apart
between_pads = Pose(xyz=(0.0, 0.0, 0.1418))

with tool0.bringup(scene="shelf", realtime=False) as robot:
    arm, gripper = robot.arm, robot.gripper

    # The shelf is on the left.  The tool's z axis points into the shelf, and the pads
    # are level.
    x, y, z = robot.scene.pose("cube").position
    into_shelf = (-math.pi / 2, math.pi / 2, 0.0)
    before = Pose(xyz=(x, y - 0.15, z), rpy=into_shelf)
    arm.execute(arm.plan(before, tool=between_pads)).wait()
    arm.move_linear(Pose(xyz=(x, y, z), rpy=into_shelf), tool=between_pads).wait()
    gripper.move(opening=0.0, speed=0.05, force=40.0)
    print(gripper.wait().motion)
    for dy, dz in ((0.0, 0.02), (-0.2, 0.02)):
        out = Pose(xyz=(x, y + dy, z + dz), rpy=into_shelf)
        arm.move_linear(out, tool=between_pads, speed=0.2).wait()

    # A wall separates the cube from the bin.  The straight motion is refused.
    above_bin = Pose(xyz=(0.48, -0.34, 0.2), rpy=(math.pi, 0.0, math.pi / 2))
    checked = arm.check(above_bin, tool=between_pads)
    print(f"free: {checked.is_free}; {checked.reason}")
    try:
        arm.move_to(above_bin, tool=between_pads)
    except tool0.CollisionError as error:
        print("refused:", error)

    # Plan a path with the cube, 10 mm from all obstacles, that avoids a person's area.
    plan = arm.plan(
        above_bin,
        tool=between_pads,
        clearance=0.01,
        keep_out=(
            tool0.KeepOut(name="person", xyz=(1.0, 0.0, 0.5), size=(0.4, 1.0, 1.4)),
        ),
        seed=1,
    )
    print(f"{len(plan.waypoints) - 2} corners, {plan.duration:.1f} s")
    print(f"least: {1e3 * plan.clearance:.1f} mm, {plan.nearest}")
    print(arm.execute(plan).wait())

    # Plan and move back to the shelf in one call, in any posture, without the cube.
    gripper.move(opening=0.085).wait()
    robot.run(0.5)
    print("in the bin:", robot.scene.pose("cube").position[2] < 0.1)
    print(arm.move_to(before, tool=between_pads, plan=True).wait())
