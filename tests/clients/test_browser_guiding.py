"""A person drags the arm in the scene, and it stays where it is left."""

import numpy as np
from browser import Tab, eventually, time_passes
from numpy.typing import NDArray

import tool0

READY = "[data-testid=scene][data-ready=true]"
GUIDING = "[data-testid=guide-toggle][aria-pressed={}]"


def tool(robot: tool0.Robot) -> NDArray[np.float64]:
    """Return where the tool is [m]."""
    return np.array(robot.arm.pose().position)


def is_at_rest(robot: tool0.Robot) -> bool:
    return all(abs(v) < 1e-3 for v in robot.joint_state.velocity.values())


def point_on_tool(tab: Tab) -> tuple[float, float]:
    """Return where the picture shows the gripper [px], found by its name."""
    tab.see(READY)
    tab.get("scene-view-tool").click()
    box = tab.get("scene").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tip = tab.page.locator(".scene-tip")

    def is_over_it() -> bool:
        tab.page.mouse.move(x, y)
        tab.page.mouse.move(x + 1, y)
        tip.wait_for(timeout=2000)
        return "gripper" in (tip.text_content() or "").lower()

    eventually(is_over_it, "the gripper is in the middle")
    return x, y


def test_the_arm_is_dragged_and_stays(tab: Tab, robot: tool0.Robot) -> None:
    assert tab.get("guide-toggle").is_disabled()
    tab.drive()
    tab.get("guide-toggle").click()
    tab.see(GUIDING.format("true"))
    assert robot.arm.control_box.state.taken_by == "hand guiding"
    tab.page.get_by_text("Guided by hand").wait_for()
    chosen = tab.page.locator("[data-testid=controller-select] option:checked")
    assert "not running" not in (chosen.text_content() or "")
    x, y = point_on_tool(tab)
    start = tool(robot)
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x + 200, y - 150, steps=4)
    tab.text("guide-text", "N")
    eventually(lambda: np.linalg.norm(tool(robot) - start) > 0.03, "the arm follows")
    tab.page.mouse.up()
    tab.text("guide-text", "Drag")
    eventually(lambda: is_at_rest(robot), "it comes to rest")
    left = tool(robot)
    time_passes(robot, 1.0)
    assert np.linalg.norm(tool(robot) - left) < 1e-3
    tab.page.keyboard.press("w")
    tab.text("notice", "step 1")
    taught = dict(robot.joint_state.position)
    tab.get("guide-toggle").click()
    tab.see(GUIDING.format("false"))
    eventually(lambda: not robot.arm.control_box.state.taken_by, "it is released")
    time_passes(robot, 0.5)
    assert np.linalg.norm(tool(robot) - left) < 1e-3
    tab.get("tab-program").click()
    tab.get("program-step-1").click()
    for joint in ("elbow_joint", "wrist_3_joint"):
        shown = float(tab.get(f"step-joint-{joint}").input_value())
        assert abs(shown - taught[joint]) < 1e-3
