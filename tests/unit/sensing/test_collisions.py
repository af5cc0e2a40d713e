"""Collisions of a pose and of the way to it, before anything moves."""

from __future__ import annotations

import pytest
from flat_options import configured

import tool0
from tool0.errors import LimitsError, ModelError
from tool0.protocol.objects import Collision
from tool0.scene import Box

LIFT = "shoulder_lift_joint"


def bring_up(**options: object) -> tool0.Robot:
    return tool0.bringup(**configured(realtime=False, **options))


def pairs(found: tuple[Collision, ...]) -> set[tuple[str, str]]:
    return {(each.first, each.second) for each in found}


def test_a_free_way_has_no_collisions_and_moves_nothing() -> None:
    with bring_up() as robot:
        before = robot.snapshot
        assert robot.find_collisions({"shoulder_pan_joint": 1.0}) == ()
        assert robot.snapshot == before


def test_a_pose_in_the_ground_collides_with_it_from_some_place_on() -> None:
    with bring_up() as robot:
        found = robot.find_collisions({LIFT: 0.2})
        grounded = [each for each in found if each.second == "ground"]
        assert {each.first for each in grounded} >= {"wrist_2_link", "forearm_link"}
        for each in grounded:
            assert 0.0 < each.begins < 1.0
            assert each.depth >= each.depth_at_end > 0.1


def test_what_is_only_in_the_way_is_not_at_the_end() -> None:
    with bring_up(initial_pose={LIFT: -0.6, "elbow_joint": 0.2}) as robot:
        robot.scene.add("post", Box(size=(0.1, 0.1, 2.0)), xyz=(0.0, 0.7, 1.0))
        found = robot.find_collisions({"shoulder_pan_joint": 3.0})
        assert ("forearm_link", "post") in pairs(found)
        assert all(each.depth_at_end == 0.0 for each in found)


def test_what_the_motion_touches_was_foretold() -> None:
    with bring_up() as robot:
        x, y, z = robot.arm.pose().position
        wall = Box(size=(0.5, 0.02, 0.5))
        robot.scene.add("wall", wall, xyz=(x, y - 0.3, z))
        robot.scene.add("other wall", wall, xyz=(x, y + 0.3, z))
        for end in (1.0, -1.0):
            foretold = pairs(robot.find_collisions({"shoulder_pan_joint": end}))
            robot.move_joints({"shoulder_pan_joint": end}, collision="ignore")
            touched: set[tuple[str, str]] = set()
            while not touched:
                robot.run(0.01)
                touched = {
                    (each.first, each.second)
                    for each in robot.contacts()
                    if "wall" in each.second
                }
                assert robot.time < 2.0
            assert touched & foretold
            robot.reset()


def test_a_held_object_is_carried_along() -> None:
    cube = Box(size=(0.03, 0.03, 0.06))
    with bring_up() as robot:
        x, y, z = robot.arm.pose(tool=robot.gripper.tcp(0.03)).position
        robot.scene.add("stand", Box(size=(0.03, 0.03, 0.1)), xyz=(x, y, z - 0.08))
        robot.scene.add("cube", cube, xyz=(x, y, z), mass=0.05)
        robot.gripper.move(opening=0.0)
        assert robot.gripper.wait().motion == "holding_inside"
        held = robot.find_collisions({LIFT: 0.1})
        assert ("cube", "ground") in pairs(held)
        assert not {p for p in pairs(held) if "cube" in p and "finger" in str(p)}
        assert robot.find_collisions({LIFT: robot.arm.joints[LIFT] - 0.2}) == ()


def test_a_pose_out_of_limits_or_of_unknown_joints_is_refused() -> None:
    with bring_up() as robot:
        with pytest.raises(LimitsError, match="elbow_joint"):
            robot.find_collisions({"elbow_joint": 4.0})
        with pytest.raises(ModelError, match="did you mean 'elbow_joint'"):
            robot.find_collisions({"elbow_join": 1.0})
