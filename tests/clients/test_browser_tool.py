"""A person moves the tool by buttons, keys, numbers, and the gizmo."""

import numpy as np
import pytest
from browser import Tab, comes_to_rest, eventually, time_passes

import tool0

READY = "[data-testid=scene][data-ready=true]"
BRAKING = 0.1
"""Within which a jogged tool stops [s]."""


def opens_the_tool(tab: Tab) -> None:
    """Switch *Drive* on, and unfold what moves the tool."""
    tab.drive()
    tab.get("tool-toggle").click()


def position(robot: tool0.Robot) -> np.ndarray:
    return np.array(robot.arm.pose().position)


def speed(robot: tool0.Robot) -> float:
    """Return the largest speed of a joint [rad/s]."""
    return max(map(abs, robot.joint_state.velocity.values()))


def moves_on(robot: tool0.Robot, axis: int, by: float) -> None:
    start = position(robot)
    eventually(
        lambda: (position(robot) - start)[axis] * np.sign(by) > abs(by),
        f"tool0 moves by {by} m along axis {axis}",
    )


def stops(robot: tool0.Robot) -> None:
    """Wait until the arm is released, and check that its controllers hold it there.

    It is released when it has rested for a while.
    """
    there = position(robot)

    def is_released() -> bool:
        nonlocal there
        if robot.arm.control_box.state.taken_by:
            there = position(robot)
            return False
        return True

    eventually(is_released, "the arm is released")
    comes_to_rest(robot)
    assert np.linalg.norm(position(robot) - there) < 1e-3  # no jump


def test_the_tool_is_jogged_by_buttons_and_keys(tab: Tab, robot: tool0.Robot) -> None:
    opens_the_tool(tab)
    button = tab.get("jog-z-minus")
    button.scroll_into_view_if_needed()
    comes_to_rest(robot)
    button.hover()
    place = button.bounding_box()
    tab.page.mouse.down()
    moves_on(robot, 2, -0.03)  # half a second and more, at 50 mm/s
    assert button.bounding_box() == place  # else it would leave the pointer, and stop
    with robot.record(rate=500) as record:
        tab.page.mouse.up()
        eventually(lambda: speed(robot) < 2e-3, "the tool rests")
    fastest = np.abs(record.velocity).max(axis=1)
    braking = np.flatnonzero((fastest < 0.9 * fastest.max()) & (fastest > 0.05))
    assert len(braking) / 500 < BRAKING
    stops(robot)

    tab.get("jog-frame-world").click()
    tab.get("jog-keyboard").click()
    tab.page.keyboard.down("w")
    time_passes(robot, 0.2)
    assert robot.arm.control_box.state.taken_by == ""  # without the dead-man key
    tab.page.keyboard.up("w")
    tab.page.keyboard.down("Shift")
    tab.page.keyboard.down("W")
    moves_on(robot, 0, 0.005)
    tab.page.keyboard.up("Shift")
    stops(robot)
    tab.page.keyboard.up("W")
    tab.get("jog-keyboard").click()


def test_a_finger_that_slides_off_a_button_stops_the_tool(
    tab: Tab, robot: tool0.Robot
) -> None:
    opens_the_tool(tab)
    button = tab.get("jog-z-minus")
    button.scroll_into_view_if_needed()
    comes_to_rest(robot)
    place = button.bounding_box()
    assert place is not None
    x, y = place["x"] + place["width"] / 2, place["y"] + place["height"] / 2
    fingers = tab.page.context.new_cdp_session(tab.page)

    def touch(kind: str, *points: dict[str, float]) -> None:
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", {"x": x, "y": y})
    moves_on(robot, 2, -0.005)
    touch("touchMove", {"x": x - 200.0, "y": y + 100.0})
    stops(robot)
    touch("touchEnd")


def test_a_step_is_as_long_as_chosen(tab: Tab, robot: tool0.Robot) -> None:
    opens_the_tool(tab)
    comes_to_rest(robot)
    start = position(robot)
    tab.get("jog-step").select_option("2")
    tab.get("jog-z-plus").click()
    eventually(lambda: (position(robot) - start)[2] > 0.009, "it moves")
    stops(robot)
    assert position(robot) - start == pytest.approx([0.0, 0.0, 0.01], abs=7e-4)


def test_dragging_the_gizmo_moves_the_tool_to_the_ghost(
    tab: Tab, robot: tool0.Robot
) -> None:
    tab.see(READY)
    opens_the_tool(tab)
    tab.get("jog-frame-world").click()
    tab.get("tool-gizmo").click()
    tab.get("tool-frame-world").click()
    comes_to_rest(robot)
    start = position(robot)
    scene = tab.see("[data-testid=scene][data-gizmo]")
    box = scene.bounding_box()
    place = scene.get_attribute("data-gizmo")
    assert box is not None
    assert place is not None
    x, y = np.add((box["x"], box["y"]), [float(part) for part in place.split()])
    tab.page.mouse.move(x, y)
    tab.page.mouse.move(x, y - 1)
    tab.page.mouse.down()
    tab.page.mouse.move(x, y + 40, steps=8)
    tab.see("[data-testid=tool-pose].aimed")
    wanted = [float(tab.get(f"tool-{k}").input_value()) / 1000 for k in range(3)]
    assert position(robot) == pytest.approx(start, abs=1e-3)  # only the ghost is there
    tab.page.mouse.up()
    eventually(
        lambda: np.linalg.norm(position(robot) - wanted) < 1e-3, "tool0 is there"
    )
    assert np.linalg.norm(np.subtract(wanted, start)) > 0.02
    comes_to_rest(robot)
    assert np.linalg.norm(position(robot) - wanted) < 1e-3


def test_an_unreachable_target_is_refused_with_a_reason(
    tab: Tab, robot: tool0.Robot
) -> None:
    opens_the_tool(tab)
    tab.get("tool-0").fill("2000")
    tab.get("tool-0").press("Enter")
    tab.text("tool-unreachable", "out of reach")
    assert tab.get("tool-go").is_disabled()
    tab.get("tool-forget").click()
    tab.get("tool-unreachable").wait_for(state="detached")
    tab.get("tool-2").fill("350")
    tab.get("tool-2").press("Enter")
    tab.get("tool-posture").wait_for()
    tab.get("tool-way-linear").click()
    tab.get("tool-go").click()
    eventually(lambda: abs(position(robot)[2] - 0.35) < 1e-3, "tool0 is there")
