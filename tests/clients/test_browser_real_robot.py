"""The page of a real robot: which one it is, and what it asks before motion."""

from __future__ import annotations

import pytest
from real_robot_rig import real_robot

from conftest import OpenTab
from tool0.panel.server import Panel

pytestmark = pytest.mark.flaky(reruns=3)  # four programs in real time on two cores

MAY_MOVE = "[data-testid=real-robot][data-enabled={}]"


def test_a_page_asks_before_a_real_robot_may_move(open_tab: OpenTab) -> None:
    with real_robot() as rig, Panel(rig.robot) as panel:
        tab = open_tab(panel.url)
        link = rig.state.link
        assert link is not None
        for shown in ("REAL ROBOT", link.model, link.serial_number, link.address):
            tab.text("real-robot", shown)
        tab.text("real-robot-state", "only reads")
        tab.get("real-robot-enable").click()
        tab.text("confirmation", link.serial_number)
        tab.get("confirmation").press("Escape")
        tab.get("confirmation").wait_for(state="hidden")
        assert not rig.state.link.is_enabled
        tab.get("real-robot-enable").click()
        tab.confirm()
        tab.see(MAY_MOVE.format("true"))
        tab.text("real-robot-state", "25 % speed")
        tab.get("real-robot-disable").click()
        tab.see(MAY_MOVE.format("false"))
        tab.close()
