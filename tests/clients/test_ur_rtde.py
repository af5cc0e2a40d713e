"""Programs of ur_rtde, the client of PyPI, on a bring-up in another process."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from rtde_rig import Recorder, RtdeClient
from ur_rtde_rig import (
    HOME,
    PLAYING,
    Array,
    Station,
    assert_trapezoid,
    station_of,
    until,
)

from tool0.description.bodies import JointDynamics


@pytest.fixture(scope="module")
def station() -> Iterator[Station]:
    with station_of("--arm", "ur5e") as station:
        yield station


@pytest.fixture
def ur(station: Station) -> Station:
    station.home()
    return station


def joint_way(record: Recorder, joint: int) -> Array:
    q = record["target_q"][:, joint]
    return np.abs(q - q[0])


def tool_way(record: Recorder) -> Array:
    p = record["target_TCP_pose"][:, :3]
    return np.linalg.norm(p - p[0], axis=1)


# ---- moves ---------------------------------------------------------------------------


def test_move_j_is_a_trapezoid_of_the_leading_joint(ur: Station) -> None:
    target = np.add(HOME, [0.5, 0.1, 0.0, -0.2, 0.0, 0.3])
    with ur.record("target_q", "target_qd", "actual_q") as record:
        assert ur.control.moveJ(target.tolist(), 1.0, 4.0)
    assert_trapezoid(
        record.time, joint_way(record, 0), distance=0.5, speed=1.0, acceleration=4.0
    )
    shares = record["target_q"] - HOME
    np.testing.assert_allclose(
        shares[:, 5], 0.6 * shares[:, 0], atol=1e-9, err_msg="in proportion"
    )
    np.testing.assert_allclose(record["target_q"][-1], target, atol=1e-9)
    np.testing.assert_allclose(record["actual_q"][-1], target, atol=2e-3)


def test_move_l_is_a_trapezoid_on_a_line(ur: Station) -> None:
    pose = ur.home_pose
    goal = [pose[0] + 0.06, pose[1] - 0.04, pose[2] + 0.05, *pose[3:]]
    with ur.record("target_TCP_pose") as record:
        assert ur.control.moveL(goal, 0.25, 1.0)
    distance = float(np.linalg.norm(np.subtract(goal, pose)[:3]))
    assert_trapezoid(
        record.time, tool_way(record), distance=distance, speed=0.25, acceleration=1.0
    )
    poses = record["target_TCP_pose"]
    way = np.subtract(goal, pose)[:3] / distance
    aside = np.cross(poses[:, :3] - pose[:3], way)
    assert np.linalg.norm(aside, axis=1).max() < 1e-4
    np.testing.assert_allclose(poses[-1], goal, atol=1e-8)


def test_poses_and_joints_are_targets_of_both_kinds_of_move(ur: Station) -> None:
    pose = ur.home_pose
    goal = [*pose[:2], pose[2] + 0.05, *pose[3:]]
    assert ur.control.moveJ_IK(goal, 3.0, 20.0)
    np.testing.assert_allclose(ur.receive.getTargetTCPPose(), goal, atol=1e-8)
    assert ur.control.moveL_FK(HOME, 1.0, 5.0)
    np.testing.assert_allclose(ur.receive.getTargetQ(), HOME, atol=1e-8)


def test_a_path_of_joints_does_not_stop_at_blends(ur: Station) -> None:
    """The client writes six digits of its numbers into the program."""
    middle, end = [0.25, *HOME[1:]], [0.25, -1.3708, *HOME[2:]]
    path = [[*middle, 1.0, 4.0, 0.05], [*end, 1.0, 4.0, 0.0]]
    with ur.record("target_q", "target_qd", "runtime_state") as record:
        assert ur.control.moveJ(path)
    first = np.flatnonzero(record["runtime_state"] != PLAYING)[-1] + 1
    q, speed = (
        record["target_q"][first:],
        np.abs(record["target_qd"][first:]).max(axis=1),
    )
    np.testing.assert_allclose(q[-1], end, atol=1e-5)
    gap = np.linalg.norm(q - middle, axis=1).min()
    assert 1e-3 < gap < 0.1, "it cuts the corner"
    moving = np.flatnonzero(speed > 1e-6)
    assert speed[moving[0] + 5 : moving[-1] - 5].min() > 0.02, "without a stop"


def test_a_path_of_the_tool_is_blended_within_its_radius(ur: Station) -> None:
    pose = ur.home_pose
    corner = [pose[0] + 0.08, *pose[1:]]
    end = [pose[0] + 0.08, pose[1], pose[2] + 0.08, *pose[3:]]
    from rtde_control import Path, PathEntry

    path = Path()
    for place, radius in ((corner, 0.03), (end, 0.0)):
        path.addEntry(
            PathEntry(
                PathEntry.MoveL,
                PathEntry.PositionTcpPose,
                [*place, 0.2, 1.0, radius],
            )
        )
    with ur.record("target_TCP_pose", "target_TCP_speed", "runtime_state") as record:
        assert ur.control.movePath(path)
    first = np.flatnonzero(record["runtime_state"] != PLAYING)[-1] + 1
    points = record["target_TCP_pose"][first:, :3]
    np.testing.assert_allclose(points[0], pose[:3], atol=1e-6)
    np.testing.assert_allclose(points[-1], end[:3], atol=1e-5)
    outside = np.linalg.norm(points - corner[:3], axis=1) > 0.0301
    assert (~outside).sum() > 3
    lines = ((points[0], corner[:3]), (corner[:3], end[:3]))
    aside = np.min([_distances(points, *line) for line in lines], axis=0)
    assert aside[outside].max() < 1e-4, "on its lines outside of the blend"
    speed = np.linalg.norm(record["target_TCP_speed"][first:, :3], axis=1)
    assert speed[~outside].min() > 0.05


def _distances(points: Array, start: ArrayLike, end: ArrayLike) -> Array:
    """Return how far points are from a line between two others, shape (n,)."""
    way = np.subtract(end, start)
    s = np.clip((points - start) @ way / (way @ way), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - s[:, None] * way, axis=1))


def test_asynchronous_moves_show_their_progress(ur: Station) -> None:
    control = ur.control
    path = [
        [*HOME[:k], HOME[k] + 0.2, *HOME[k + 1 :], 1.0, 4.0, 0.0] for k in (0, 3, 5)
    ]
    operation = control.getAsyncOperationProgressEx().operationId()
    assert control.moveJ(path, True)
    seen = [control.getAsyncOperationProgress()]

    def has_ended() -> bool:
        progress = control.getAsyncOperationProgress()
        if progress != seen[-1]:
            seen.append(progress)
        return not control.getAsyncOperationProgressEx().isAsyncOperationRunning()

    until(has_ended, "end of the path")
    assert seen[:3] == [0, 1, 2]
    assert seen[3] < 0
    assert control.getAsyncOperationProgressEx().operationId() != operation


def test_a_move_replaces_an_asynchronous_one(ur: Station) -> None:
    control = ur.control
    assert control.moveJ([1.0, *HOME[1:]], 1.0, 4.0, True)
    until(lambda: ur.receive.getTargetQd()[0] > 0.5, "motion")
    with ur.record("target_q", "target_qd") as record:
        assert control.moveJ(HOME, 1.0, 4.0)
    np.testing.assert_allclose(record["target_q"][-1], HOME, atol=1e-9)
    rates = np.diff(record["target_qd"][:, 0]) / np.diff(record.time)
    assert np.abs(rates).max() < 4.001, "speed does not jump"


@pytest.mark.parametrize("name", ["stopJ", "stopL"])
def test_stops_slow_down_as_asked(ur: Station, name: str) -> None:
    """The first joint alone: the tool turns as fast as it does, and stopL limits both.

    Per m/s², stopL slows down the rotation by as many rad/s².
    """
    control = ur.control
    assert control.moveJ([1.0, *HOME[1:]], 0.8, 4.0, True)
    until(lambda: ur.receive.getTargetQd()[0] > 0.79, "top speed")
    with ur.record("target_qd") as record:
        getattr(control, name)(2.0)
    speed = record["target_qd"][:, 0]
    assert speed[0] > 0.7
    assert speed[-1] == 0.0
    falling = np.flatnonzero((speed > 0.1) & (speed < 0.7))
    rates = np.diff(speed[falling]) / np.diff(record.time[falling])
    np.testing.assert_allclose(rates, -2.0, rtol=1e-3)


# ---- streams -------------------------------------------------------------------------


def test_speed_j_ramps_and_goes_on_until_it_is_stopped(ur: Station) -> None:
    with ur.record("target_qd") as record:
        assert ur.control.speedJ([0.4, 0.0, 0.0, 0.0, 0.0, -0.2], 2.0, 0.1)
        until(lambda: ur.receive.getTargetQ()[0] > 0.1, "way")
        assert ur.control.speedStop(4.0)
    qd = record["target_qd"]
    np.testing.assert_allclose(qd.max(axis=0)[0], 0.4, atol=1e-9)
    np.testing.assert_allclose(qd[:, 5], -0.5 * qd[:, 0], atol=1e-9)
    rates = np.diff(qd[:, 0]) / np.diff(record.time)
    assert abs(rates.max() - 2.0) < 0.01
    assert abs(rates.min() + 4.0) < 0.02
    assert qd[-1, 0] == 0.0


def test_speed_l_moves_the_tool_straight(ur: Station) -> None:
    with ur.record("target_TCP_pose", "target_TCP_speed") as record:
        assert ur.control.speedL([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], 1.0, 0.0)
        until(lambda: ur.receive.getTargetTCPSpeed()[2] > 0.0999, "top speed")
        assert ur.control.speedStop(2.0)
    speed = record["target_TCP_speed"]
    np.testing.assert_allclose(speed[:, 2].max(), 0.1, atol=1e-4)
    assert np.abs(speed[:, [0, 1, 3, 4, 5]]).max() < 1e-3
    points = record["target_TCP_pose"][:, :3]
    assert np.ptp(points[:, :2], axis=0).max() < 2e-4


@pytest.mark.parametrize("feature", ["FEATURE_BASE", "FEATURE_TOOL"])
def test_jogging_moves_along_the_axes_of_a_frame(ur: Station, feature: str) -> None:
    """At home, the tool looks down: its z axis is the base's, reversed."""
    control = ur.control
    start = ur.home_pose
    sign = -1.0 if feature == "FEATURE_BASE" else 1.0
    assert control.jogStart(
        [0.0, 0.0, sign * 0.1, 0.0, 0.0, 0.0], getattr(control, feature)
    )
    until(lambda: start[2] - ur.receive.getTargetTCPPose()[2] > 0.01, "way down")
    assert control.jogStop()
    end = ur.receive.getTargetTCPPose()
    np.testing.assert_allclose(end[:2], start[:2], atol=1e-3)
    until(lambda: not any(ur.receive.getTargetQd()), "rest")


@pytest.mark.flaky(reruns=3)  # three programs at 500 Hz on two cores
def test_servo_j_follows_500_targets_a_second_for_ten_seconds(ur: Station) -> None:
    """With UR's law, the arm is late by the lookahead time, for targets as slow.

    What the targets were, and when, is read from the registers that they come through.
    """
    lookahead, gain, rate, swing = 0.03, 2000.0, 0.2 * np.pi, 0.15
    control, receive = ur.control, ur.receive
    fields = ("target_q", "target_qd", "actual_q", "input_double_register_0")
    began = receive.getTimestamp()
    with ur.record(*fields) as record:
        while (now := receive.getTimestamp() - began) < 10.0:
            cycle = control.initPeriod()
            target = [swing * (1.0 - np.cos(rate * now)), *HOME[1:]]
            assert control.servoJ(target, 0.0, 0.0, 0.002, lookahead, gain)
            control.waitPeriod(cycle)
        assert control.servoStop(10.0)
    t, q = record.time - began, record["target_q"][:, 0]
    wanted = record["input_double_register_0"]
    assert t[-1] > 9.99
    assert np.ptp(wanted) > 1.99 * swing
    moving = (t > 1.0) & (t < 9.9)
    errors = [
        np.quantile(np.abs(np.interp(t[moving] - delay, t, wanted) - q[moving]), 0.98)
        for delay in np.arange(lookahead, lookahead + 0.015, 0.001)
    ]
    assert min(errors) < 0.005
    rates = np.diff(record["target_qd"][:, 0]) / np.diff(t)
    assert np.abs(rates).max() < 40.001, "within the limits of the joint"
    assert np.abs(record["actual_q"] - record["target_q"]).max() < 0.01


def test_servo_l_and_servo_c_move_to_poses(ur: Station) -> None:
    pose = ur.home_pose
    goal = [*pose[:2], pose[2] + 0.02, *pose[3:]]
    assert ur.control.servoL(goal, 0.0, 0.0, 0.002, 0.1, 300.0)
    until(lambda: abs(ur.receive.getTargetTCPPose()[2] - goal[2]) < 1e-5, "arrival")
    assert ur.control.servoStop()
    assert ur.control.servoC(pose, 0.25, 1.2, 0.0)
    until(lambda: abs(ur.receive.getTargetTCPPose()[2] - pose[2]) < 1e-6, "arrival")
    assert ur.control.servoStop()


# ---- queries and settings ------------------------------------------------------------


def test_kinematics_agree_with_the_robot(ur: Station) -> None:
    control, q = ur.control, [0.3, -1.2, 1.4, -1.7, -1.5, 0.4]
    tool = [0.0, 0.02, 0.15, 0.0, 0.1, 0.0]
    pose = control.getForwardKinematics(q, tool)
    flange = control.getForwardKinematics(q, [0.0] * 6)
    np.testing.assert_allclose(control.poseTrans(flange, tool), pose, atol=1e-9)
    found = control.getInverseKinematics(flange, q)
    np.testing.assert_allclose(found, q, atol=1e-8)
    assert control.getInverseKinematicsHasSolution(flange, q)
    assert not control.getInverseKinematicsHasSolution([3.0, *flange[1:]], q)
    assert control.isPoseWithinSafetyLimits(flange)
    assert not control.isPoseWithinSafetyLimits([3.0, *flange[1:]])
    assert control.isJointsWithinSafetyLimits(q)
    assert not control.isJointsWithinSafetyLimits([7.0, *q[1:]])


def test_the_tcp_moves_the_reported_pose(ur: Station) -> None:
    control, receive = ur.control, ur.receive
    flange, offset = ur.home_pose, [0.0, 0.0, 0.12, 0.0, 0.0, 0.0]
    assert control.setTcp(offset)
    try:
        assert control.getTCPOffset() == offset
        until(lambda: receive.getTargetTCPPose()[2] < flange[2] - 0.1, "the new TCP")
        np.testing.assert_allclose(
            receive.getTargetTCPPose(), control.poseTrans(flange, offset), atol=1e-8
        )
    finally:
        assert control.setTcp([0.0] * 6)


def test_the_payload_and_the_tare_are_those_of_the_robot(ur: Station) -> None:
    control = ur.control
    assert control.setPayload(1.7, [0.0, 0.01, 0.06])
    until(lambda: ur.receive.getPayload() == 1.7, "payload")
    assert ur.receive.getPayloadCog() == [0.0, 0.01, 0.06]
    payload = ur.robot.arm.control_box.state.payload
    assert (payload.mass, payload.center_of_gravity) == (1.7, (0.0, 0.01, 0.06))
    assert control.setPayload(0.92, [0.0, 0.0, 0.047])
    until(control.isSteady, "rest")
    assert control.zeroFtSensor()
    until(lambda: np.abs(ur.receive.getActualTCPForce()[:3]).max() < 0.5, "tare")
    until(lambda: np.abs(control.getJointTorques()).max() < 1.0, "no outer torques")


def test_polled_queries_are_up_to_date(ur: Station) -> None:
    """The client does not wait for these; a second call has the answer of the first."""
    control = ur.control
    until(lambda: control.getStepTime() == 0.002, "step time")
    here = ur.home_pose
    until(
        lambda: np.allclose(control.getActualToolFlangePose(), here, atol=1e-3),
        "pose of the flange",
    )
    until(
        lambda: np.allclose(control.getActualJointPositionsHistory(5), HOME, atol=1e-3),
        "positions",
    )


def test_direct_torques_control_impedances(ur: Station) -> None:
    """Joint springs turn the base; then moves go on from where the arm is."""
    goal = np.add(HOME, [0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    stiffness = np.array([300.0, 300.0, 200.0, 60.0, 60.0, 60.0])
    damping = np.array([40.0, 40.0, 25.0, 5.0, 5.0, 5.0])

    def is_there() -> bool:
        q, qd = np.array(ur.receive.getActualQ()), np.array(ur.receive.getActualQd())
        torque = stiffness * (goal - q) - damping * qd
        period = ur.control.initPeriod()
        assert ur.control.directTorque(torque.tolist())
        ur.control.waitPeriod(period)
        return bool(np.abs(goal - q).max() < 0.01 and np.abs(qd).max() < 0.01)

    until(is_there, "the spring is relaxed")
    assert ur.control.moveJ(HOME, 3.0, 20.0)
    assert not ur.robot.arm.control_box.state.protective_stop


def test_dynamics_are_those_of_the_present_posture(ur: Station) -> None:
    """The client waits for one state only, so that an answer may be the last one."""

    def answered(ask: Callable[[], ArrayLike], expected: ArrayLike) -> None:
        wanted = np.ravel(expected)
        until(lambda: np.allclose(np.ravel(ask()), wanted, atol=1e-3), f"{wanted}")

    ur.robot.arm.control_box.clear_payload()
    model, measured = ur.robot.description.model, ur.robot.snapshot.positions
    position = [measured[joint.name] for joint in model.movable_joints]
    masses = JointDynamics(model).mass_matrix(position)[:6, :6]
    control, pose = ur.control, ur.home_pose
    answered(control.getMassMatrix, masses)
    answered(control.getCoriolisAndCentrifugalTorques, np.zeros(6))
    answered(control.getTargetJointAccelerations, np.zeros(6))
    answered(control.getJacobianTimeDerivative, np.zeros((6, 6)))
    step = 1e-4
    moved = [
        control.getForwardKinematics(np.add(HOME, turn).tolist(), [0.0] * 6)
        for turn in step * np.eye(6)
    ]
    columns = np.subtract(moved, pose)[:, :3] / step
    answered(lambda: np.reshape(control.getJacobian(), (6, 6))[:, :3], columns)


def test_inputs_and_registers_of_the_io_interface(ur: Station) -> None:
    """It has registers of its own, so that it can be used beside the control."""
    from rtde_io import RTDEIOInterface

    outputs = RTDEIOInterface(ur.host)
    receive = ur.receive
    assert outputs.setStandardDigitalOut(2, True)
    assert outputs.setConfigurableDigitalOut(1, True)
    assert outputs.setToolDigitalOut(0, True)
    pins = 1 << 2 | 1 << 9 | 1 << 16
    until(lambda: receive.getActualDigitalOutputBits() == pins, "pins")
    assert ur.robot.arm.control_box.state.digital_outputs[2]
    assert outputs.setAnalogOutputVoltage(0, 0.25)
    until(lambda: receive.getStandardAnalogOutput0() == 2.5, "voltage")
    assert outputs.setSpeedSlider(0.5)
    until(lambda: receive.getTargetSpeedFraction() == 0.5, "slider")
    assert outputs.setSpeedSlider(1.0)
    assert outputs.setInputIntRegister(20, -7)
    assert outputs.setInputDoubleRegister(21, 0.125)
    fields = ("input_int_register_20", "input_double_register_21")
    with ur.record(*fields) as record:
        pass
    assert record[fields[0]][-1] == -7
    assert record[fields[1]][-1] == 0.125
    assert outputs.setStandardDigitalOut(2, False)
    until(lambda: not receive.getActualDigitalOutputBits() & 1 << 2, "pin")
    until(lambda: receive.getTargetSpeedFraction() == 1.0, "slider")


def test_reported_positions_are_the_robots(ur: Station) -> None:
    """At the same simulated time, to the last digit."""
    target = [0.2, *HOME[1:]]
    with ur.robot.record(rate=500) as robot, ur.record("actual_q", "actual_qd") as rtde:
        assert ur.control.moveJ(target, 1.0, 4.0)
    columns = [robot.joint_names.index(name) for name in ur.robot.arm.joint_names]
    instants, ours, theirs = np.intersect1d(
        np.round(1000.0 * rtde.time), np.round(1000.0 * robot.time), return_indices=True
    )
    assert len(instants) > 10
    for name, values in (("actual_q", robot.position), ("actual_qd", robot.velocity)):
        difference = rtde[name][ours] - values[theirs][:, columns]
        assert np.abs(difference).max() < 1e-9


# ---- packets -------------------------------------------------------------------------


def test_the_first_version_has_neither_rates_nor_recipe_ids(station: Station) -> None:
    with RtdeClient(station.host, version=1) as client:
        assert client.receive(["timestamp", "actual_q"]) == ["DOUBLE", "VECTOR6D"]
        client.start()
        samples = [client.sample() for _ in range(12)]
    assert len(samples[0][1]) == 6
    assert _period(samples) > 7.0, "a busy machine leaves out some"


def _period(samples: list[list[Any]]) -> float:
    """Return the mean time between samples [ms of simulated time]."""
    return 1000.0 * float(samples[-1][0] - samples[1][0]) / (len(samples) - 2)


def test_rates_are_reached_by_leaving_out_updates(station: Station) -> None:
    with RtdeClient(station.host) as client:
        client.receive(["timestamp"], rate=50.0)
        client.start()
        samples = [client.sample() for _ in range(8)]
    assert _period(samples) > 18.0


def test_unknown_and_used_fields_are_told(station: Station) -> None:
    with RtdeClient(station.host) as client:
        types = client.receive(["timestamp", "actual_mood"])
        assert types == ["DOUBLE", "NOT_FOUND"]
        assert client.ask("I", b"input_int_register_0") == b"\0IN_USE"
        assert client.ask("I", b"input_int_register_30,mood") == b"\0INT32,NOT_FOUND"
        assert client.ask("I", b"input_int_register_30") == b"\1INT32"
        assert client.ask("v") == struct.pack(">4I", 5, 25, 1, 0)
        assert client.ask("V", b"\0\7") == b"\0"


def test_a_client_that_breaks_the_protocol_is_told_and_others_go_on(
    station: Station,
) -> None:
    with RtdeClient(station.host) as client:
        client.send("?")
        kind, text = client.read()
        assert kind == "M"
        assert b"unknown packet type" in text
        client.send("U", b"\7\0\0\0\0")
        assert b"not set up" in client.read()[1]
        client.send("O", b"\0")
        assert b"frequency" in client.read()[1]
        assert client.read() == ("", b""), "closed"
    with RtdeClient(station.host) as client:
        client.receive(["timestamp"])
        client.start()
        client.sample()


def test_a_client_that_reads_nothing_delays_nobody(station: Station) -> None:
    names = [f"output_double_register_{k}" for k in range(48)]
    with RtdeClient(station.host) as lazy, RtdeClient(station.host) as client:
        lazy.receive(names)
        lazy.start()
        client.receive(["timestamp"])
        client.start()
        began = client.sample()[0]
        while client.sample()[0] < began + 1.0:
            pass


def test_a_paused_simulation_is_no_lost_connection(station: Station) -> None:
    with RtdeClient(station.host) as client:
        client.receive(["timestamp"])
        client.start()
        client.sample()
        station.robot.pause()
        try:
            times = [client.sample()[0]]
            while len(times) < 2 or times[-1] != times[-2]:
                times.append(client.sample()[0])
        finally:
            station.robot.resume()
