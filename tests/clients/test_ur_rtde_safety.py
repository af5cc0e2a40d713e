"""Contacts, stops and connections of programs of ur_rtde, on another process."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ur_rtde_rig import HOME, Station, station_of, until

from tool0.scene import Box, Pose, SceneObject

DOWN = [0.0, 0.0, -1.0, 0.0, 0.0, 0.0]
BLOCK = SceneObject(
    name="block",
    geometry=Box(size=(0.3, 0.3, 0.1)),
    pose=Pose(xyz=(0.49, 0.13, 0.23)),
)
"""Fixed, a few centimetres below the gripper at home."""
NOT_READY = r"(?i)in use"
DONE = 2
"""What ur_rtde reads in the first register when its command was executed."""
PROTECTIVE_STOP = 1 << 2
"""Bit of RTDE's ``safety_status_bits``."""


@pytest.fixture(scope="module")
def station() -> Iterator[Station]:
    with station_of("--arm", "ur5e") as station:
        station.robot.scene.add(BLOCK)
        yield station


@pytest.fixture
def ur(station: Station) -> Station:
    station.home()
    return station


def height(ur: Station) -> float:
    z: float = ur.receive.getActualTCPPose()[2]
    return z


# ---- contacts ------------------------------------------------------------------------


def test_a_move_until_contact_ends_at_the_contact(ur: Station) -> None:
    until(ur.control.isSteady, "rest")
    assert ur.control.zeroFtSensor()
    until(lambda: ur.control.toolContact(DOWN) == 0, "air")  # polled: late by one
    start = height(ur)
    assert ur.control.moveUntilContact([0.0, 0.0, -0.05, 0.0, 0.0, 0.0], DOWN, 0.5)
    assert 0.005 < start - height(ur) < 0.12
    until(lambda: not any(ur.receive.getTargetQd()), "rest")
    assert np.abs(ur.receive.getActualTCPForce()[:3]).max() < 40.0


def test_a_detected_contact_stops_an_asynchronous_move(ur: Station) -> None:
    control = ur.control
    until(control.isSteady, "rest")
    assert control.zeroFtSensor()
    assert control.startContactDetection(DOWN)
    pose = ur.home_pose
    assert control.moveL([*pose[:2], pose[2] - 0.12, *pose[3:]], 0.05, 0.5, True)
    until(control.readContactDetection, "contact")
    assert control.stopContactDetection()
    until(lambda: not any(ur.receive.getTargetQd()), "rest")
    assert height(ur) > pose[2] - 0.115


def test_force_mode_presses_with_the_given_force(ur: Station) -> None:
    control, force = ur.control, 15.0
    until(control.isSteady, "rest")
    assert control.zeroFtSensor()
    wrench = [0.0, 0.0, -force, 0.0, 0.0, 0.0]
    limits = [0.1, 0.1, 0.05, 0.2, 0.2, 0.2]
    assert control.forceModeSetDamping(0.05)
    assert control.forceModeSetGainScaling(1.0)
    assert control.forceMode([0.0] * 6, [0, 0, 1, 0, 0, 0], wrench, 2, limits)
    try:
        until(lambda: ur.receive.getActualTCPForce()[2] > force - 2.0, "contact")
        until(lambda: max(map(abs, ur.receive.getActualQd())) < 1e-3, "rest")
        assert abs(ur.receive.getActualTCPForce()[2] - force) < 2.0
    finally:
        assert control.forceModeStop()
    until(lambda: not any(ur.receive.getTargetQd()), "rest")


def test_freedrive_is_a_mode_of_the_robot(ur: Station) -> None:
    control, receive = ur.control, ur.receive
    assert control.teachMode()
    until(lambda: receive.getRobotMode() == 6, "backdrive")
    assert control.endTeachMode()
    until(lambda: receive.getRobotMode() == 7, "running")
    assert control.freedriveMode([1, 0, 0, 0, 0, 0], [0.0] * 6)
    assert control.getFreedriveStatus() == 0
    assert control.endFreedriveMode()
    until(lambda: receive.getRobotMode() == 7, "running")


# ---- stops ---------------------------------------------------------------------------


def recover(ur: Station) -> None:
    """Wait until the stop may be unlocked, and unlock it."""
    from dashboard_client import DashboardClient

    dashboard = DashboardClient(ur.host)
    dashboard.connect()
    began = ur.receive.getTimestamp()
    ur.robot.set_speed(4.0)
    try:
        until(lambda: ur.receive.getTimestamp() > began + 5.1, "5 s of simulated time")
    finally:
        ur.robot.set_speed(1.0)
    dashboard.unlockProtectiveStop()
    until(lambda: not ur.receive.isProtectiveStopped(), "unlocked arm")
    dashboard.disconnect()


def test_a_protective_stop_and_the_way_out_of_it(ur: Station) -> None:
    control, receive = ur.control, ur.receive
    control.triggerProtectiveStop()
    until(receive.isProtectiveStopped, "protective stop")
    until(lambda: not control.isProgramRunning(), "end of the program")
    assert receive.getSafetyMode() == 3
    assert not control.moveJ(HOME)
    recover(ur)
    assert control.reuploadScript()
    until(control.isProgramRunning, "program")
    assert control.moveJ([0.1, *HOME[1:]], 1.0, 4.0)


def test_a_move_that_a_stop_ends_is_never_reported_as_done(ur: Station) -> None:
    x, y, z, *rotation = ur.receive.getActualTCPPose()
    with ur.record("output_int_register_0", "safety_status_bits") as record:
        assert not ur.control.moveL([x, y, z - 0.15, *rotation], 0.25, 1.2)
        until(lambda: not ur.control.isProgramRunning(), "end of the program")
    is_stopped = (record["safety_status_bits"].astype(int) & PROTECTIVE_STOP) > 0
    assert is_stopped.any()
    assert not (record["output_int_register_0"][is_stopped] == DONE).any()
    ur.robot.scene.remove(BLOCK.name)  # a pressed arm would stop again
    recover(ur)
    ur.home()
    ur.robot.scene.add(BLOCK)


def test_a_move_that_another_client_stops_is_not_done(ur: Station) -> None:
    """As the page's button does, which stops the program."""
    x, y, z, *rotation = ur.receive.getActualTCPPose()
    with ThreadPoolExecutor() as threads:
        move = threads.submit(ur.control.moveL, [x, y, z + 0.1, *rotation], 0.05, 1.2)
        until(lambda: ur.receive.getActualTCPSpeed()[2] > 0.02, "the arm to move")
        ur.robot.arm.control_box.stop()
        assert not move.result(timeout=10.0)
    assert ur.control.reuploadScript()
    until(ur.control.isProgramRunning, "program")
    ur.home()


def test_an_emergency_stop_is_seen_and_survived(ur: Station) -> None:
    ur.robot.emergency_stop()
    until(ur.receive.isEmergencyStopped, "emergency stop")
    until(lambda: not ur.control.isProgramRunning(), "end of the program")
    assert not ur.control.moveJ(HOME)
    ur.robot.emergency_stop(False)
    until(lambda: not ur.receive.isEmergencyStopped(), "release")


def test_an_impossible_pose_ends_the_program(ur: Station) -> None:
    """As an error of the script's ``get_inverse_kin`` does."""
    pose = ur.home_pose
    assert not ur.control.moveJ_IK([3.0, *pose[1:]])
    assert not ur.control.isProgramRunning()


def test_the_watchdog_stops_the_program_of_a_silent_client(ur: Station) -> None:
    control, receive = ur.control, ur.receive
    assert control.setWatchdog(5.0)
    assert control.speedJ([0.2, 0.0, 0.0, 0.0, 0.0, 0.0], 2.0, 0.0)
    for _ in range(3):
        assert control.kickWatchdog()
    until(lambda: not control.isProgramRunning(), "end of the program")
    until(lambda: max(map(abs, receive.getActualQd())) < 1e-3, "rest")


# ---- connections ---------------------------------------------------------------------


def test_disconnects_and_connects_again(ur: Station) -> None:
    ur.control.disconnect()
    assert not ur.control.isConnected()
    assert ur.control.reconnect()
    assert ur.control.moveJ([0.1, *HOME[1:]], 1.0, 4.0)
    ur.receive.disconnect()
    assert ur.receive.reconnect()
    until(lambda: abs(ur.receive.getTargetQ()[0] - 0.1) < 1e-9, "positions")


def test_two_clients_control_the_robot_by_turns(ur: Station) -> None:
    """They need the same registers: from PolyScope 5.23 on, whatever the flags say."""
    from rtde_control import RTDEControlInterface
    from rtde_receive import RTDEReceiveInterface

    flags = RTDEControlInterface.FLAG_UPLOAD_SCRIPT
    upper = (
        flags
        | RTDEControlInterface.FLAG_UPPER_RANGE_REGISTERS
        | RTDEControlInterface.FLAG_NO_EXT_FT
    )
    for tried in (flags, upper):
        with pytest.raises(RuntimeError, match=NOT_READY):
            RTDEControlInterface(ur.host, 500.0, tried)
    ur.control.stopScript()
    ur.control.disconnect()
    second = RTDEControlInterface(ur.host, 500.0, flags)
    other = RTDEReceiveInterface(ur.host, 125.0)
    assert second.moveJ([0.15, *HOME[1:]], 1.0, 4.0)
    until(lambda: abs(other.getTargetQ()[0] - 0.15) < 1e-9, "motion")
    second.stopScript()
    second.disconnect()
    other.disconnect()
    assert ur.control.reconnect()


def test_functions_of_urscript_run_between_two_uploads(ur: Station) -> None:
    script = "movej([0.2, -1.5708, 1.5708, -1.5708, -1.5708, 0.0], a=4, v=1)\n"
    assert ur.control.sendCustomScriptFunction("further", script)
    assert abs(ur.receive.getTargetQ()[0] - 0.2) < 0.01
    until(ur.control.isProgramRunning, "the control program again")
    assert ur.control.moveJ(HOME, 1.0, 4.0)
