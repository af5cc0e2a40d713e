"""Poses and objects that cannot be are refused, with the contact, on every engine."""

from __future__ import annotations

import pytest
from conformance_types import BringUp

from tool0.errors import PenetrationError
from tool0.scene import Box

INTO_THE_GROUND = {"shoulder_lift_joint": 0.2}


def test_a_pose_in_the_ground_is_refused_and_nothing_changes(bring_up: BringUp) -> None:
    with bring_up() as robot:
        robot.run(0.02)
        before = robot.snapshot
        with pytest.raises(PenetrationError, match=r"'\w+_link' .* into 'ground'"):
            robot.reset(INTO_THE_GROUND)
        assert robot.snapshot == before
        robot.reset({"shoulder_lift_joint": -1.8})
        robot.run(0.1)
        assert max(map(abs, robot.snapshot.velocity)) < 0.5


def test_who_forces_a_pose_gets_it(bring_up: BringUp) -> None:
    with bring_up() as robot:
        robot.reset(INTO_THE_GROUND, allow_penetration=True)
        assert robot.joint_state.position["shoulder_lift_joint"] == pytest.approx(0.2)


def test_an_initial_pose_in_the_ground_is_refused(bring_up: BringUp) -> None:
    with pytest.raises(PenetrationError, match="into 'ground'"):
        bring_up(initial_pose=INTO_THE_GROUND)
    with bring_up(initial_pose=INTO_THE_GROUND, allow_penetration=True) as robot:
        assert robot.joint_state.position["shoulder_lift_joint"] == pytest.approx(0.2)


def test_the_outstretched_arm_is_accepted(bring_up: BringUp) -> None:
    zeros = dict.fromkeys(("shoulder_lift_joint", "elbow_joint", "wrist_1_joint"), 0.0)
    with bring_up(initial_pose=zeros) as robot:
        robot.reset(zeros)
        robot.run(0.1)
        assert max(map(abs, robot.snapshot.velocity)) < 0.5


def test_an_object_inside_a_link_is_refused(bring_up: BringUp) -> None:
    box = Box(size=(0.05, 0.05, 0.05))
    with bring_up() as robot:
        inside = robot.pose("forearm_link").position
        with pytest.raises(PenetrationError, match=r"object .box. would be .* in ."):
            robot.scene.add("box", box, xyz=inside, mass=0.1)
        assert "box" not in robot.scene
        robot.scene.add("box", box, xyz=(0.0, 1.0, 0.5), mass=0.1)
        before = robot.scene.pose("box")
        with pytest.raises(PenetrationError, match=r"object .box. would be .* in ."):
            robot.scene.place("box", inside)
        assert robot.scene.pose("box") == before
        robot.scene.place("box", inside, allow_penetration=True)
        assert robot.scene.pose("box").position == pytest.approx(inside)


def test_a_pose_inside_an_object_is_refused(bring_up: BringUp) -> None:
    with bring_up() as robot:
        wrist = robot.pose("wrist_2_link").position
        robot.reset({"shoulder_pan_joint": 1.5})
        robot.scene.add("post", Box(size=(0.1, 0.1, 0.1)), xyz=wrist)
        with pytest.raises(PenetrationError, match="into 'post'"):
            robot.reset({"shoulder_pan_joint": 0.0})
