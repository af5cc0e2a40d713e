"""Plans through the API: what they keep to, how they fail, how they are executed."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import msgspec
import numpy as np
import pytest

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import (
    CollisionError,
    ControlError,
    PlanningError,
    Tool0Error,
    UnreachableError,
)
from tool0.kinematics.chain import Array, find_chains
from tool0.protocol.planning import KeepOut, Plan, Upright
from tool0.simulation.config import SimulationConfig

NAMES = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
LOW = dict(zip(NAMES, (-1.0, -0.9, 1.6, -2.2, -1.57, 0.0), strict=True))
HIGH = LOW | {"shoulder_lift_joint": -1.4, "wrist_1_joint": -1.7}
BEYOND = {"shoulder_pan_joint": 0.7}
WALL = SceneObject(
    name="wall", geometry=Box(size=(0.5, 0.03, 0.6)), pose=Pose(xyz=(0.6, 0.0, 0.3))
)

NO_WAY = {
    "keep_out": (KeepOut(name="fence", xyz=(1.3, 0, 0.5), size=(2.0, 0.02, 3.0)),),
    "joint_ranges": {
        "shoulder_pan_joint": (-1.2, 0.9),
        "shoulder_lift_joint": (-1.2, -0.5),
        "elbow_joint": (1.3, 1.9),
    },
}
"""The arm cannot be folded so far that it passes the fence."""


def bring_up(*objects: SceneObject, **options: object) -> tool0.Robot:
    return tool0.bringup(
        scene=Scene(objects),
        initial_pose=LOW,
        realtime=False,
        **options,  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    """At one side of a wall; nothing moves."""
    with bring_up(WALL) as robot:
        yield robot


def dense(plan: Plan, n: int = 400) -> Array:
    """Return positions along a plan, straight from knot to knot, (n, n_joints)."""
    times = np.linspace(0.0, plan.duration, n)
    columns = np.array(plan.positions).T
    return np.array([np.interp(times, plan.times, each) for each in columns]).T


def tools(robot: tool0.Robot, plan: Plan) -> Array:
    """Return the flange in the arm's base along a plan, shape (n, 4, 4)."""
    (chain,) = find_chains(robot.description.model).values()
    return chain.forward(dense(plan)).T_base_tip


def test_it_goes_around_the_wall_where_the_straight_way_does_not(
    robot: tool0.Robot,
) -> None:
    found = robot.arm.check(BEYOND)
    assert not found.is_free
    assert "'wall'" in found.reason
    assert 0.0 < found.part < 1.0
    with pytest.raises(CollisionError, match=r"would collide after .*'wall'"):
        robot.move_joints(BEYOND)
    plan = robot.arm.plan(BEYOND)
    assert not plan.is_direct
    assert plan.clearance >= 0.005
    assert plan.positions[-1][0] == pytest.approx(0.7)
    assert plan.duration > 0.0
    again = robot.arm.plan(BEYOND)
    assert again.positions == plan.positions
    assert again.times == plan.times


def test_a_large_clearance_is_that_of_other_things(robot: tool0.Robot) -> None:
    # the base and the upper arm are never more than 8 mm apart
    plan = robot.arm.plan({"shoulder_lift_joint": -1.2}, clearance=0.05)
    assert plan.is_direct
    assert 0.005 <= plan.clearance < 0.009


def test_what_may_be_touched_does_not_count_as_clearance(robot: tool0.Robot) -> None:
    plan = robot.arm.plan(BEYOND, may_touch=("wall",))
    assert "wall" not in plan.nearest
    assert plan.clearance >= 0.005


def test_a_check_looks_at_the_posture_that_a_motion_would_take(
    robot: tool0.Robot,
) -> None:
    posture = robot.arm.inverse_kinematics(robot.arm.pose())[0].positions
    assert robot.arm.check(robot.arm.pose()) == robot.arm.check(posture)


def test_a_target_in_something_is_refused_with_its_name(robot: tool0.Robot) -> None:
    with pytest.raises(CollisionError, match=r"the target is in collision: .*'wall'"):
        robot.arm.plan({"shoulder_pan_joint": 0.0})
    inside = Pose(xyz=(0.6, 0.0, 0.3), rpy=(math.pi, 0.0, 0.0))
    with pytest.raises(CollisionError, match=r"no posture of the target is free \(\d"):
        robot.arm.plan(inside)


def test_what_is_out_of_reach_is_refused(robot: tool0.Robot) -> None:
    with pytest.raises(UnreachableError):
        robot.arm.plan(Pose(xyz=(3.0, 0.0, 0.3)))
    with pytest.raises(UnreachableError, match=r"elbow_joint.*its limits are"):
        robot.arm.plan({"elbow_joint": 4.0})
    with pytest.raises(ControlError, match="'knee' is not a joint of the arm"):
        robot.arm.plan({"knee": 0.0})


def test_a_start_in_collision_is_refused_with_both_bodies(robot: tool0.Robot) -> None:
    at = robot.arm.pose().position
    robot.scene.add("lump", Box(size=(0.1,) * 3), xyz=at, allow_penetration=True)
    try:
        with pytest.raises(
            CollisionError, match=r"the start is in collision: .*'lump'"
        ):
            robot.arm.plan(BEYOND)
    finally:
        robot.scene.remove("lump")


def test_no_way_in_the_time_says_how_long_it_searched(robot: tool0.Robot) -> None:
    with pytest.raises(
        PlanningError, match=r"no way found in 0\.[3-9] s, with \d+ sam"
    ):
        robot.arm.plan(BEYOND, timeout=0.3, **NO_WAY)


def test_a_search_can_be_cancelled(robot: tool0.Robot) -> None:
    failures: list[Tool0Error] = []

    def search() -> None:
        with pytest.raises(PlanningError) as failure:
            robot.arm.plan(BEYOND, timeout=60.0, **NO_WAY)
        failures.append(failure.value)

    thread = threading.Thread(target=search)
    thread.start()
    while thread.is_alive():
        robot.cancel_planning()
        thread.join(0.01)
    assert str(failures[0]) == "planning was cancelled"


def test_a_box_and_a_plane_are_kept_out_of(robot: tool0.Robot) -> None:
    aside = {"shoulder_pan_joint": -2.0}
    assert robot.arm.plan(aside).is_direct
    tool = robot.arm.plan(aside)
    middle = tools(robot, tool)[200, :3, 3] * [-1.0, -1.0, 1.0]  # the base is turned
    box = KeepOut(name="post", xyz=tuple(middle), size=(0.1, 0.1, 0.3))
    assert "'post'" in robot.arm.check(aside, keep_out=[box]).reason
    assert not robot.arm.plan(aside, keep_out=(box,)).is_direct

    height = robot.arm.pose().position[2]
    floor = KeepOut(name="floor", xyz=(0, 0, height - 0.19), normal=(0.0, 0.0, 1.0))
    plan = robot.arm.plan(BEYOND, keep_out=(floor,))
    assert (tools(robot, plan)[:, 2, 3] > height - 0.2 + 0.005).all()
    ceiling = KeepOut(name="lid", xyz=(0, 0, height), normal=(0.0, 0.0, 1.0))
    with pytest.raises(CollisionError, match="'lid'"):
        robot.arm.plan(BEYOND, keep_out=(ceiling,))
    with pytest.raises(Tool0Error, match="needs either a size or a normal"):
        robot.arm.plan(BEYOND, keep_out=(KeepOut(name="nothing"),))


def test_the_tool_stays_upright(robot: tool0.Robot) -> None:
    tilt = 0.2

    def largest(plan: Plan) -> float:
        axes = tools(robot, plan)[:, :3, 2]
        return float(np.arccos(np.clip(axes @ axes[0], -1.0, 1.0)).max())

    assert largest(robot.arm.plan(BEYOND)) > tilt
    plan = robot.arm.plan(BEYOND, upright=Upright(tilt=tilt), timeout=30.0)
    assert largest(plan) <= tilt + 1e-3


def test_joints_keep_to_narrower_ranges(robot: tool0.Robot) -> None:
    free = dense(robot.arm.plan(BEYOND))
    k = int(np.ptp(free[:, 1:], axis=0).argmax()) + 1
    start, turned = free[0, k], free[np.abs(free[:, k] - free[0, k]).argmax(), k]
    lower, upper = sorted((start + math.copysign(0.1, start - turned), turned))
    middle = (start + turned) / 2.0
    limits = (lower, middle) if turned > start else (middle, upper)
    plan = robot.arm.plan(BEYOND, joint_ranges={NAMES[k]: limits}, timeout=30.0)
    q = dense(plan)[:, k]
    assert q.min() >= limits[0] - 1e-6
    assert q.max() <= limits[1] + 1e-6
    with pytest.raises(ControlError, match="'knee' is not a joint that moves"):
        robot.arm.plan(BEYOND, joint_ranges={"knee": (0.0, 1.0)})


def test_a_pose_is_reached_by_the_nearest_of_all_whole_turns() -> None:
    with tool0.bringup(
        initial_pose=LOW | {"wrist_3_joint": 3.0}, realtime=False
    ) as robot:
        plan = robot.arm.plan(robot.arm.pose())
        assert max(abs(np.array(plan.positions[-1]) - plan.positions[0])) < 1e-3
        turned = Pose(rpy=(0.0, 0.0, 0.5))
        wrist = robot.arm.plan(turned, tip="tool0", relative_to="tool0").positions[-1]
        assert wrist[5] == pytest.approx(3.5)  # and not 3.5 - 2 π


def test_a_plan_is_executed_and_touches_nothing() -> None:
    with bring_up(WALL) as robot:
        goal = robot.arm.execute(robot.arm.plan(BEYOND, speed=1.0))
        while not goal.status.is_terminal:
            robot.run(0.05)
            assert not robot.contacts()
        assert goal.status is tool0.GoalStatus.SUCCEEDED
        assert robot.arm.joints["shoulder_pan_joint"] == pytest.approx(0.7, abs=0.01)


def test_what_is_held_collides_too() -> None:
    """The fingers end above the step; what they hold does not."""
    with tool0.bringup(
        simulation=SimulationConfig(grasp_assist=True, realtime=False),
        initial_pose=HIGH,
    ) as robot:
        x, y, z = robot.arm.pose(tool=robot.gripper.tcp()).position
        bottom, top = -0.1, z + 0.02
        bar = Box(size=(0.03, 0.03, top - bottom))
        robot.scene.add("bar", bar, xyz=(x, y, (top + bottom) / 2.0), mass=0.1)
        robot.gripper.move(opening=0.02, force=40.0)
        robot.run(0.8)
        beyond = {"shoulder_pan_joint": LOW["shoulder_pan_joint"] - 0.9}
        reach, turn = math.hypot(x, y), math.atan2(y, x) - 0.9
        at = (reach * math.cos(turn), reach * math.sin(turn), bottom + 0.05)
        robot.scene.add("step", Box(size=(0.1, 0.1, 0.1)), xyz=at)
        with pytest.raises(
            CollisionError,
            match=r"the target is in collision: '(bar|step)' .* in '(bar|step)'",
        ):
            robot.arm.plan(beyond)
        robot.gripper.move(opening=0.085)
        robot.run(0.5)
        assert robot.arm.plan(beyond).positions


def test_a_plan_is_refused_when_something_has_moved_since() -> None:
    stone = SceneObject(
        name="stone",
        geometry=Box(size=(0.1,) * 3),
        pose=Pose(xyz=(-0.6, 0.0, 0.051)),
        mass=1.0,
    )
    with bring_up(WALL, stone) as robot:
        plan = robot.arm.plan(BEYOND)
        robot.scene.place("stone", (-0.6, 0.1, 0.051))
        with pytest.raises(ControlError, match=r"'stone' has moved by 100\.0 mm"):
            robot.arm.execute(plan)
        plan = robot.arm.plan(BEYOND)
        robot.scene.add("more", Box(size=(0.1,) * 3), xyz=(-0.6, -0.4, 0.3))
        with pytest.raises(ControlError, match="object 'more' was added; plan again"):
            robot.arm.execute(plan)
        plan = robot.arm.plan(BEYOND)
        robot.scene.remove("more")
        with pytest.raises(ControlError, match="object 'more' was removed"):
            robot.arm.execute(plan)
        plan = robot.arm.plan(BEYOND)
        robot.move_joints({"wrist_3_joint": 0.5})[0].wait()
        with pytest.raises(
            ControlError, match=r"joint 'wrist_3_joint' has moved by 0\.5"
        ):
            robot.arm.execute(plan)
        with pytest.raises(ControlError, match="there is no plan 99"):
            robot.arm.execute(_numbered(plan, 99))


def _numbered(plan: Plan, number: int) -> Plan:
    return msgspec.structs.replace(plan, number=number)


@pytest.mark.slow
def test_a_scene_that_changes_while_it_is_planned_for(robot: tool0.Robot) -> None:
    """The plan is for the scene at its beginning, and refused in another one."""
    plans: list[Plan] = []
    blocker = threading.Thread(target=lambda: _in_vain(robot))
    blocker.start()  # searches are done one after the other
    planner = threading.Thread(target=lambda: plans.append(robot.arm.plan(BEYOND)))
    planner.start()
    k = 0
    while planner.is_alive():  # at any time of it
        k += 1
        robot.scene.add(f"new{k}", Box(size=(0.02,) * 3), xyz=(-0.9, 0.0, 0.1 * k))
        planner.join(0.1)
    blocker.join()
    robot.scene.add("last", Box(size=(0.02,) * 3), xyz=(-0.9, 0.5, 0.5))
    with pytest.raises(ControlError, match="the scene has changed since plan"):
        robot.arm.execute(plans[0])
    for name in [*robot.scene]:
        if name != "wall":
            robot.scene.remove(name)


def _in_vain(robot: tool0.Robot) -> None:
    with pytest.raises(PlanningError):
        robot.arm.plan(BEYOND, timeout=0.3, **NO_WAY)


def test_a_contact_that_nobody_planned_stops_the_motion() -> None:
    with bring_up(WALL) as robot:
        plan = robot.arm.plan(BEYOND, speed=0.3)
        (chain,) = find_chains(robot.description.model).values()
        half = dense(plan)[200]
        goal = robot.arm.execute(plan)
        robot.run(0.1)
        T = chain.forward(half[None]).T_base_tip[0]
        x, y, z = T[:3, 3]
        robot.scene.add("surprise", Box(size=(0.08,) * 3), xyz=(-x, -y, z))
        result = goal.wait(timeout=30.0)
        assert result.status is tool0.GoalStatus.ABORTED
        assert "surprise" in result.error_string
        assert "which the plan does not expect" in result.error_string
        assert plan.duration > robot.time


def test_two_arms_that_cross_are_planned_together() -> None:
    description = tool0.DescriptionConfig(
        robots=("left=ur5+2f85@0,0.4,0", "right=ur5+2f85@0,-0.4,0")
    )
    low, high = LOW, HIGH
    pans = {"left": -0.6, "right": 0.6}

    def together(left: dict[str, float], right: dict[str, float]) -> dict[str, float]:
        return {
            f"{arm}_{name}": pans[arm] if name == NAMES[0] else value
            for arm, posture in (("left", left), ("right", right))
            for name, value in posture.items()
        }

    start, end = together(high, low), together(low, high)
    with tool0.bringup(
        description=description, initial_pose=start, realtime=False
    ) as robot:
        targets = [
            robot.arms[arm].target({k: end[k] for k in end if k.startswith(arm)})
            for arm in pans
        ]
        with pytest.raises(CollisionError, match=r"'(left|right)_.*'(left|right)_"):
            robot.plan(targets[:1])  # the other one stands there
        plan = robot.plan(targets, speed=1.0, timeout=30.0)
        assert len(plan.joint_names) == 12
        goals = robot.execute(plan)
        while not all(goal.status.is_terminal for goal in goals):
            robot.run(0.1)
            assert not robot.contacts()
        assert [goal.status for goal in goals] == [tool0.GoalStatus.SUCCEEDED] * 2
