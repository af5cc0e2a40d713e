"""A person jogs towards a wall: how far ahead the page looks is a wall time."""

import numpy as np
from browser import Tab, eventually, time_passes
from test_browser_tool import opens_the_tool, position, stops

import tool0


def test_jogging_stops_in_front_of_a_wall(tab: Tab, walled: tool0.Robot) -> None:
    opens_the_tool(tab)
    tab.get("jog-frame-world").click()
    tab.get("jog-obstacles").click()
    button = tab.get("jog-y-minus")
    button.scroll_into_view_if_needed()
    start = position(walled)
    button.hover()
    tab.page.mouse.down()
    notice = tab.get("notice").filter(has_text="Stopped in front of an obstacle")
    notice.filter(has_text="wall").wait_for()
    stops(walled)
    tab.page.mouse.up()
    there = position(walled)
    assert there[1] < start[1] - 0.03  # it went as far as it was free
    assert not any(
        "wall" in (contact.first, contact.second) for contact in walled.contacts()
    )
    button.hover()
    tab.page.mouse.down()
    time_passes(walled, 0.5)
    tab.page.mouse.up()
    assert np.linalg.norm(position(walled) - there) < 5e-3  # it does not go nearer
    away = tab.get("jog-y-plus")
    away.hover()
    tab.page.mouse.down()
    eventually(lambda: position(walled)[1] > there[1] + 0.02, "it moves away")
    tab.page.mouse.up()
    tab.get("jog-obstacles").click()
