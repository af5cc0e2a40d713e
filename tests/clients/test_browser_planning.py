"""A person sends the arm to a target behind a wall."""

import pytest
from browser import Tab, comes_to_rest, eventually, time_passes
from playwright.sync_api import FloatRect
from test_browser_tool import READY, opens_the_tool, position

import tool0

BEHIND = -0.35
"""y of a place behind the wall [m]; the tool begins at 0.11 m."""


def aims_behind_the_wall(tab: Tab) -> None:
    opens_the_tool(tab)
    tab.get("tool-frame-world").click()
    tab.get("tool-1").fill(str(1000 * BEHIND))
    tab.get("tool-1").press("Enter")
    tab.get("tool-posture").wait_for()


def plans_a_way_around(tab: Tab) -> None:
    aims_behind_the_wall(tab)
    tab.get("tool-go").click()
    tab.see("[data-testid=plan][data-state=found]")


def slides_to(tab: Tab, key: str) -> None:
    """Move the slider over the plan to its begin (Home) or its end (End)."""
    tab.get("plan-time").focus()
    tab.page.keyboard.press(key)


def above_the_card(tab: Tab) -> bytes:
    """Return a picture of the scene without what is written over it."""
    scene, card = tab.get("scene").bounding_box(), tab.get("plan").bounding_box()
    assert scene is not None
    assert card is not None
    bars = 100
    clip: FloatRect = {
        "x": scene["x"],
        "y": scene["y"] + bars,
        "width": scene["width"],
        "height": card["y"] - scene["y"] - bars,
    }
    return tab.page.screenshot(clip=clip)


def still_above_the_card(tab: Tab) -> bytes:
    """Return such a picture once the scene has stopped changing."""
    last = above_the_card(tab)

    def is_still() -> bool:
        nonlocal last
        before, last = last, above_the_card(tab)
        return last == before

    eventually(is_still, "the scene stands still")
    return last


def test_the_arm_goes_around_a_wall_on_the_way_that_is_shown(
    tab: Tab, walled: tool0.Robot
) -> None:
    tab.see(READY)
    start = position(walled)
    plans_a_way_around(tab)
    tab.text("plan-obstacle", "wall")
    tab.text("plan-figures", "mm between")
    at_end = still_above_the_card(tab)
    slides_to(tab, "Home")
    eventually(lambda: above_the_card(tab) != at_end, "the ghost moves")
    slides_to(tab, "End")
    eventually(lambda: above_the_card(tab) == at_end, "the ghost is at the target")
    assert position(walled) == pytest.approx(start, abs=1e-3)  # nothing has moved

    highest, touched = start[2], set()
    tab.get("plan-move").click()
    tab.get("plan").wait_for(state="detached")

    def has_arrived() -> bool:
        nonlocal highest
        highest = max(highest, position(walled)[2])
        touched.update(
            pair
            for contact in walled.contacts()
            if "wall" in (pair := (contact.first, contact.second))
        )
        return abs(position(walled)[1] - BEHIND) < 1e-3

    eventually(has_arrived, "the tool is behind the wall")
    comes_to_rest(walled)
    assert position(walled)[1] == pytest.approx(BEHIND, abs=1e-3)
    assert not touched
    assert "another client" not in (tab.get("driving-state").text_content() or "")
    tab.get("tool-forget").wait_for(state="detached")  # the target is reached


def test_a_named_pose_behind_a_wall_is_gone_to_the_same_way(
    tab: Tab, walled: tool0.Robot
) -> None:
    walled.save_pose("here")
    plans_a_way_around(tab)
    tab.get("plan-move").click()
    eventually(lambda: abs(position(walled)[1] - BEHIND) < 1e-3, "it is there")
    comes_to_rest(walled)
    tab.get("pose-go-here").click()
    tab.see("[data-testid=plan][data-state=found]")
    tab.get("plan-move").click()
    eventually(lambda: position(walled)[1] > 0.1, "it is back")


def test_a_plan_is_discarded_or_outdated_and_nothing_moves(
    tab: Tab, walled: tool0.Robot
) -> None:
    start = position(walled)
    plans_a_way_around(tab)
    tab.get("plan-discard").click()
    tab.get("plan").wait_for(state="detached")
    tab.get("tool-go").click()
    tab.see("[data-testid=plan][data-state=found]")
    walled.scene.place("wall", (0.55, -0.13, 0.225))
    tab.get("plan").wait_for(state="detached")
    tab.get("notice").filter(has_text="The scene has changed").wait_for()
    tab.get("tool-go").click()
    tab.see("[data-testid=plan][data-state=found]")
    tab.page.keyboard.press("Escape")
    tab.get("plan").wait_for(state="detached")
    tab.get("estop-banner").wait_for()
    time_passes(walled, 0.5)
    assert position(walled) == pytest.approx(start, abs=5e-3)  # the brakes give way
