"""What the UR process shows of itself in the panel, and how it guards the arm."""

from __future__ import annotations

import math

import pytest
from browser import eventually
from ur_rig import ur_rig

import tool0
from tool0.protocol.control_box_state import UrReport

rtde_io = pytest.importorskip("rtde_io")
OVER_TABLE = tool0.Pose(xyz=(0.45, 0.15, 0.2), rpy=(math.pi, 0.0, 0.0))
IN_TABLE = tool0.Pose(xyz=(0.45, 0.15, -0.1), rpy=(math.pi, 0.0, 0.0))


@pytest.fixture(scope="module")
def rig():
    with ur_rig(speed=4.0, scene="table_and_cubes") as rig:
        yield rig


def reported(rig) -> UrReport:
    report = rig.robot.arm.control_box.state.ur
    return UrReport() if report is None else report


def test_clients_popups_and_registers_are_reported(rig) -> None:
    eventually(lambda: rig.robot.arm.control_box.state.ur is not None, "a report")
    dashboard = rig.dashboard()
    eventually(lambda: reported(rig).clients == 1, "the client is counted")
    dashboard.ask("popup Place a part")
    eventually(lambda: reported(rig).popup == "Place a part", "the popup is shown")
    client = rtde_io.RTDEIOInterface(rig.host)
    assert client.setInputIntRegister(20, 7)
    expected = {"input_int_register_20": 7}
    eventually(
        lambda: expected.items() <= dict(reported(rig).registers).items(),
        "the register is shown",
    )
    client.disconnect()
    dashboard.ask("close popup")
    eventually(lambda: reported(rig).popup is None, "the popup is closed")
    dashboard.close()
    eventually(lambda: reported(rig).clients == 0, "the clients have left")


def test_a_collision_stops_the_arm(rig) -> None:
    robot, dashboard = rig.robot, rig.dashboard()
    robot.arm.move_to(OVER_TABLE).wait()
    eventually(
        lambda: max(map(abs, robot.joint_state.velocity.values())) < 1e-3, "it rests"
    )
    robot.arm.move_linear(IN_TABLE, speed=0.2, collision="ignore").wait()
    assert "touches 'table'" in robot.arm.control_box.state.protective_stop
    dashboard.until("safetymode", "Safetymode: PROTECTIVE_STOP")
    dashboard.close()
