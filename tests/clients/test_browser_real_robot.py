"""The page of a real robot: which one it is, and what it asks before motion."""

from __future__ import annotations

import pytest
from browser import eventually
from real_robot_rig import real_robot

from conftest import OpenTab
from tool0.panel.server import Panel
from tool0.protocol.control_box_state import ProgramState

pytestmark = pytest.mark.flaky(reruns=3)  # four programs in real time on two cores

ELBOW = "elbow_joint"
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
        with rig.twin() as twin:
            tab.drive()
            start = twin.joint_state.position[ELBOW]
            tab.send_joint(ELBOW, 70.0)  # [°]
            eventually(
                lambda: twin.joint_state.position[ELBOW] < start - 0.05, "motion"
            )
            tab.get("estop").click()
            eventually(lambda: rig.state.program is ProgramState.STOPPED, "the stop")
            eventually(lambda: abs(twin.joint_state.velocity[ELBOW]) < 0.01, "rest")
            assert twin.joint_state.position[ELBOW] > 1.3  # 70° are 1.22 rad
        tab.get("real-robot-disable").click()
        tab.see(MAY_MOVE.format("false"))
