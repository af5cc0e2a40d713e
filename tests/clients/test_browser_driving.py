"""A person drives the robot in a real browser, and it moves in the physics."""

import pytest
from browser import Tab, comes_to_rest, eventually
from playwright.sync_api import Browser

import tool0
from conftest import OpenTab
from tool0.panel.server import Panel

MONITOR = "[data-testid=joint-slider-elbow_joint][disabled]"
NEAR = 0.03
"""What the arm's PID leaves of a goal [rad]."""


def position(robot: tool0.Robot, joint: str = "elbow_joint") -> float:
    return robot.joint_state.position[joint]


def arrives(robot: tool0.Robot, joint: str, goal: float) -> None:
    eventually(
        lambda: (
            abs(position(robot, joint) - goal) < NEAR
            and abs(robot.joint_state.velocity[joint]) < 1e-2
        ),
        f"{joint} is at {goal}",
    )


def test_a_number_moves_its_joint_in_the_physics(tab: Tab, robot: tool0.Robot) -> None:
    tab.drive()
    tab.send_joint("elbow_joint", 1.4)
    arrives(robot, "elbow_joint", 1.4)
    tab.shows_joint("elbow_joint", 1.4, NEAR)


def test_arrow_keys_on_a_slider_move_its_joint(tab: Tab, robot: tool0.Robot) -> None:
    tab.drive()
    before = position(robot, "wrist_1_joint")
    slider = tab.get("joint-slider-wrist_1_joint")
    start = float(slider.input_value())
    for _ in range(5):
        slider.press("Shift+ArrowRight")
    goal = float(slider.input_value())
    assert goal > start
    arrives(robot, "wrist_1_joint", goal)
    assert position(robot, "wrist_1_joint") > before + 0.01


def test_a_slider_is_dragged_with_the_mouse(tab: Tab, robot: tool0.Robot) -> None:
    tab.drive()
    slider = tab.get("joint-slider-shoulder_pan_joint")
    box = slider.bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    tab.page.mouse.move(box["x"] + box["width"] / 2, middle)
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + box["width"] * 0.55, middle, steps=10)
    tab.page.mouse.up()
    goal = float(slider.input_value())
    assert goal > 0.1
    arrives(robot, "shoulder_pan_joint", goal)


def swipe(tab: Tab, start: tuple[float, float], by: tuple[float, float]) -> None:
    """Move a finger over the page."""
    touch = tab.context.new_cdp_session(tab.page)
    steps = 20
    for step in range(steps + 1):
        x, y = (a + d * step / steps for a, d in zip(start, by, strict=True))
        kind = "touchMove" if step else "touchStart"
        points = [{"x": x, "y": y}]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_a_swipe_scrolls_and_only_a_sideways_one_drives(
    browser: Browser, panel: Panel, robot: tool0.Robot
) -> None:
    tab = Tab(browser, panel.url, width=390, height=844, has_touch=True)
    tab.drive()
    slider = tab.get("joint-slider-elbow_joint")
    slider.scroll_into_view_if_needed()
    before = float(slider.input_value())
    box = slider.bounding_box()
    assert box is not None
    at = (box["x"] + 0.1 * box["width"], box["y"] + box["height"] / 2)
    scrolled = tab.page.evaluate("window.scrollY")
    swipe(tab, at, (20.0, -200.0))
    tab.page.wait_for_function("before => window.scrollY > before + 50", arg=scrolled)
    assert float(slider.input_value()) == before

    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    assert box is not None
    at = (box["x"] + 0.1 * box["width"], box["y"] + box["height"] / 2)
    tab.page.touchscreen.tap(*at)
    assert float(slider.input_value()) == before
    swipe(tab, at, (0.2 * box["width"], 3.0))
    goal = float(slider.input_value())
    assert 0.3 < goal - before < 1.5
    arrives(robot, "elbow_joint", goal)
    tab.close()


def test_sliders_follow_until_driving_is_enabled(tab: Tab, robot: tool0.Robot) -> None:
    tab.see(MONITOR)
    robot.move_joints({"elbow_joint": 0.9}, speed=1.0)
    tab.shows_joint("elbow_joint", 0.9, NEAR)
    arrives(robot, "elbow_joint", 0.9)
    for control in ("slider", "field"):
        follower = tab.get(f"joint-{control}-elbow_joint")
        eventually(
            lambda of=follower: abs(float(of.input_value()) - position(robot)) < 2e-3,
            f"the {control} follows",
        )


def test_enabling_moves_nothing(tab: Tab, robot: tool0.Robot) -> None:
    robot.move_joints({"elbow_joint": 0.9}, speed=1.0)
    arrives(robot, "elbow_joint", 0.9)
    comes_to_rest(robot)
    before = dict(robot.joint_state.position)
    tab.drive()
    until = robot.time + 1.0
    strayed = 0.0

    def has_stayed() -> bool:
        nonlocal strayed
        now = robot.joint_state.position
        strayed = max(strayed, *(abs(now[name] - before[name]) for name in before))
        return robot.time > until

    eventually(has_stayed, "a second passes")
    assert strayed < 1e-3


def test_a_pose_is_gone_to_and_the_present_one_saved(
    tab: Tab, robot: tool0.Robot
) -> None:
    tab.drive()
    tab.get("speed-scale").press("End")
    tab.get("pose-go-zero").click()
    arrives(robot, "elbow_joint", 0.0)
    arrives(robot, "shoulder_lift_joint", 0.0)
    tab.get("pose-name").fill("stretched")
    tab.get("pose-save").click()
    tab.get("pose-go-stretched").wait_for()
    assert robot.poses()["stretched"].saved
    tab.get("pose-go-home").click()
    home = robot.poses()["home"].positions["elbow_joint"]
    arrives(robot, "elbow_joint", home)
    tab.get("pose-go-stretched").click()
    arrives(robot, "elbow_joint", 0.0)


def test_the_gripper_closes_and_opens(tab: Tab, robot: tool0.Robot) -> None:
    assert tab.get("gripper-close").is_disabled()
    tab.drive()
    tab.get("gripper-close").click()
    eventually(lambda: robot.gripper.opening < 1e-3, "the gripper closes")
    tab.text("gripper-state", "target")
    tab.get("gripper-open").click()
    eventually(lambda: robot.gripper.opening > 0.084, "the gripper opens")


def test_the_gripper_goes_at_the_chosen_speed(tab: Tab, robot: tool0.Robot) -> None:
    tab.drive()
    slider = tab.get("gripper-speed")
    assert (slider.get_attribute("min"), slider.get_attribute("max")) == ("20", "150")
    slider.press("Home")
    tab.get("gripper-close").click()
    eventually(lambda: robot.gripper.opening < 0.075, "the gripper closes")
    time, opening = robot.time, robot.gripper.opening
    eventually(lambda: robot.gripper.opening < opening - 0.01, "it goes on")
    passed = robot.time - time
    assert 0.01 / passed == pytest.approx(0.02, rel=0.2)
    tab.get("gripper-open").click()


@pytest.mark.parametrize("ros2_control", [False, True], ids=["ros1", "ros2"])
def test_the_stop_button_stops_the_arm(open_tab: OpenTab, ros2_control: bool) -> None:
    with tool0.bringup(ros2_control=ros2_control) as robot, Panel(robot) as panel:
        tab = open_tab(panel.url)
        tab.drive()
        goal = position(robot) - 1.5
        tab.get("speed-scale").fill("10")
        tab.send_joint("elbow_joint", goal)
        eventually(
            lambda: abs(robot.joint_state.velocity["elbow_joint"]) > 0.1, "it moves"
        )
        tab.get("hold-still").click()
        eventually(
            lambda: abs(robot.joint_state.velocity["elbow_joint"]) < 1e-3, "it rests"
        )
        assert position(robot) > goal + 0.2
