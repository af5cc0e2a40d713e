"""A real robot, on tool0's own UR controller in another process: reading and moving."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from raises_naming import raises_naming
from real_robot_rig import RealRobotRig, real_robot
from ros import Bringup
from ur_address import free_host
from waits import until

import tool0
from tool0.errors import ControlError, NotOfferedError
from tool0.protocol.control_box_state import ProgramState, RobotMode, SafetyMode
from tool0.protocol.goals import GoalStatus
from tool0.recording.simulated_run import simulate_beside

ELBOW = "elbow_joint"
SUCCEEDED = GoalStatus.SUCCEEDED

pytestmark = pytest.mark.flaky(reruns=3)  # three programs in real time on two cores


@pytest.fixture(scope="module")
def rig() -> Iterator[RealRobotRig]:
    with real_robot() as made:
        yield made


@pytest.fixture
def moving(rig: RealRobotRig) -> RealRobotRig:
    """The rig, with its motion enabled and at rest in the same pose."""
    until(lambda: not rig.state.taken_by, "the end of what moved it before")
    link = rig.state.link
    assert link is not None
    if not link.is_enabled:
        rig.enable()
    elif rig.state.program is not ProgramState.PLAYING:
        rig.box.play()
    for _ in range(3):  # a busy machine may be too late for the simulated controller
        (goal,) = rig.robot.move_joints({ELBOW: 1.57}, speed=0.3)
        if goal.wait(30.0).status is SUCCEEDED:
            return rig
        rig.box.play()
    raise AssertionError(rig.state.motion_failure)


def test_it_only_reads_until_somebody_enables_its_motion(rig: RealRobotRig) -> None:
    link = rig.state.link
    assert link is not None
    assert (link.model, link.software) == ("UR5", "3.15.8")
    assert not link.is_enabled
    assert not link.obstacles
    with rig.twin() as twin:
        joints = twin.snapshot.positions
    here = rig.robot.snapshot.positions
    arm = rig.robot.arm.joint_names
    assert [here[k] for k in arm] == pytest.approx([joints[k] for k in arm], abs=1e-3)
    assert here["finger_joint"] == pytest.approx(joints["finger_joint"], abs=0.02)
    currents = rig.robot.arm.motion.state.currents
    assert len(currents) == 6
    assert abs(currents[1]) > 10.0 * abs(currents[5])  # the shoulder carries the arm
    with raises_naming(ControlError, "only reads the robot", "enable"):
        rig.robot.move_joints({ELBOW: 1.0})
    with raises_naming(ControlError, "only reads the robot"):
        rig.box.play()
    with raises_naming(ControlError, "serial number is not '1'", "nameplate"):
        rig.box.enable_motion("1")
    with raises_naming(NotOfferedError, "reset", "cannot be put into a pose"):
        rig.robot.reset()
    with raises_naming(NotOfferedError, "pause", "cannot be held"):
        rig.robot.pause()


def test_a_move_ends_where_it_was_sent(moving: RealRobotRig) -> None:
    with moving.twin() as twin:
        (goal,) = moving.robot.move_joints({ELBOW: 1.2}, speed=0.5)
        assert goal.wait(30.0).status is SUCCEEDED
        until(
            lambda: abs(twin.snapshot.positions[ELBOW] - 1.2) < 1e-3,
            lambda: f"the elbow at 1.2, not {twin.snapshot.positions[ELBOW]}",
        )
    # the other joints have stayed
    pan = moving.robot.snapshot.positions["shoulder_pan_joint"]
    assert pan == pytest.approx(0.0, abs=1e-3)


def test_a_motion_that_is_too_fast_for_the_slider_is_scaled(
    moving: RealRobotRig,
) -> None:
    moving.box.set_speed_slider(0.25)
    until(lambda: moving.state.speed_scaling == 0.25, "the slider")
    fastest = 0.0
    states = moving.robot.subscribe()
    (goal,) = moving.robot.move_joints({ELBOW: 1.2}, speed=1.0)
    while not goal.status.is_terminal:
        states.next(5.0)
        velocity = moving.robot.joint_state.velocity[ELBOW]
        fastest = max(fastest, abs(velocity))
    states.close()
    limit = moving.robot.joint_limits[ELBOW].velocity
    assert 0.05 * limit < fastest < 0.27 * limit
    moving.box.set_speed_slider(1.0)
    until(lambda: moving.state.speed_scaling == 1.0, "the slider")


def test_pins_payload_and_tool_are_those_of_the_robot(moving: RealRobotRig) -> None:
    with moving.twin() as twin:
        box = twin.arm.control_box
        moving.box.set_digital_output(3, True)
        until(lambda: box.state.digital_outputs[3], "pin 3 of the robot")
        moving.box.set_digital_output(3, False)
        box.set_digital_input(5, True)
        until(lambda: moving.state.digital_inputs[5], "the input")
        moving.box.set_payload(1.5, (0.0, 0.0, 0.05))
        assert box.state.payload.mass == pytest.approx(1.5)
        moving.box.clear_payload()
        assert moving.state.payload.mass == pytest.approx(0.92, abs=0.01)
        moving.box.set_tool_voltage(24)
        until(lambda: box.state.tool_voltage == 24, "the tool's voltage")
    with raises_naming(ControlError, "what their wires say"):
        moving.box.set_digital_input(5, False)


def test_the_gripper_moves(moving: RealRobotRig) -> None:
    gripper = moving.robot.gripper
    gripper.move(opening=0.03)
    until(lambda: abs(gripper.opening - 0.03) < 2e-3, "the gripper at 30 mm")
    gripper.move(opening=0.08)
    until(lambda: abs(gripper.opening - 0.08) < 2e-3, "the gripper at 80 mm")


PROGRAM = """\
name: around
tool: {xyz: [0, 0, 0.1418]}
steps:
  - {kind: move_joint, pose: {xyz: [0.55, 0.11, 0.2], rpy: [180deg, 0, 0]}, blend: 0.03}
  - {kind: move_linear, pose: {xyz: [0.55, 0.11, 0.05], rpy: [180deg, 0, 0]}}
  - {kind: gripper, opening: 0.03, force: 40}
  - {kind: move_linear, pose: {xyz: [0.55, 0.11, 0.2], rpy: [180deg, 0, 0]}}
  - {kind: move_joint, named_pose: home}
"""


def test_a_program_does_what_its_simulation_does(
    moving: RealRobotRig, tmp_path: Path
) -> None:
    """A dry run before it moves, and a recording compared with the simulation."""
    robot, file = moving.robot, tmp_path / "around.yaml"
    file.write_text(PROGRAM)
    before = robot.snapshot.positions
    dry = robot.programs.dry_run(file)
    assert (dry.end.state, dry.touches) == ("succeeded", ())
    assert robot.snapshot.positions == pytest.approx(before, abs=1e-3)
    record = tmp_path / "around.mcap"
    robot.start_recording(record)
    end = robot.run_program(file).wait(60.0)
    robot.stop_recording()
    assert end.state == "succeeded", end.error
    assert end.time == pytest.approx(dry.end.time, abs=2.0)
    run = simulate_beside(record)
    assert not run.notes
    assert run.lag < 0.3
    for name in robot.arm.joint_names:
        # most of it is time: each motion from rest starts as late as the network is
        assert run.joints[name].position_rms < 0.05


def test_force_mode_and_freedrive_are_those_of_the_robot(moving: RealRobotRig) -> None:
    motion = moving.robot.arm.motion
    with moving.twin() as twin:
        box = twin.arm.control_box
        with motion.taken("force"):
            motion.start_force_mode((0, 0, -20, 0, 0, 0), (False, False, True, *NONE))
            until(lambda: twin.arm.motion.state.force_mode, "force mode")
            motion.end_force_mode()
            until(lambda: not twin.arm.motion.state.force_mode, "its end")
        with motion.taken("force, and a stop"):
            motion.start_force_mode((0, 0, -20, 0, 0, 0), (False, False, True, *NONE))
            until(lambda: twin.arm.motion.state.force_mode, "force mode")
            moving.box.stop()
            until(lambda: not twin.arm.motion.state.force_mode, "its end by a stop")
        moving.box.play()
        with motion.taken("hand"):
            motion.start_freedrive()
            until(lambda: box.state.robot_mode is RobotMode.BACKDRIVE, "freedrive")
            motion.end_freedrive()
            until(lambda: box.state.robot_mode is RobotMode.RUNNING, "its end")
    (goal,) = moving.robot.move_joints({ELBOW: 1.4}, speed=0.5)
    assert goal.wait(30.0).status is SUCCEEDED, moving.state.motion_failure


NONE = (False, False, False)


def test_streams_are_followed(moving: RealRobotRig) -> None:
    robot, name = moving.robot, "shoulder_pan_joint"
    states = robot.subscribe(rate=125)
    with moving.twin() as twin, robot.arm.motion.taken("stream") as motion:
        targets = [robot.joint_state.position[k] for k in robot.arm.joint_names]
        for _ in range(200):
            targets[0] += 0.001
            motion.servo_joints(targets)
            states.next(5.0)
        until(
            lambda: abs(twin.joint_state.position[name] - targets[0]) < 2e-3,
            lambda: f"{targets[0]}, not {twin.joint_state.position[name]}",
        )
        motion.speed_joints((-0.2, *NO_SPEED), acceleration=1.0, duration=1.0)
        until(
            lambda: abs(twin.joint_state.position[name] - targets[0] + 0.2) < 0.03,
            lambda: f"0.2 rad less, not {twin.joint_state.position[name]}",
        )
    states.close()
    assert not moving.state.motion_failure


NO_SPEED = (0.0, 0.0, 0.0, 0.0, 0.0)


def test_a_move_into_the_arm_itself_is_refused(moving: RealRobotRig) -> None:
    with raises_naming(tool0.Tool0Error, "collide"):
        moving.robot.move_joints({ELBOW: -2.95, "shoulder_lift_joint": -0.3})
    folded = (0.0, -0.3, -2.95, -1.57, -1.57, 0.0)
    trajectory = [tool0.TrajectoryPoint(positions=folded, time_from_start=30.0)]
    with raises_naming(ControlError, "collide"):
        name = "scaled_joint_trajectory_controller"
        goal = moving.robot.controller(name).follow(
            trajectory, joint_names=moving.robot.arm.joint_names
        )
        goal.wait(30.0)
        raise ControlError(moving.state.motion_failure)
    assert moving.robot.snapshot.positions[ELBOW] == pytest.approx(1.57, abs=0.02)


def test_a_protective_stop_stops_it_until_it_is_unlocked_and_played(
    moving: RealRobotRig,
) -> None:
    with moving.twin() as twin:
        (goal,) = moving.robot.move_joints({ELBOW: 0.8}, speed=0.2)
        until(lambda: moving.robot.snapshot.positions[ELBOW] < 1.5, "motion")
        twin.arm.control_box.stop_protectively("a test")
        assert goal.wait(10.0).status is not SUCCEEDED
        until(
            lambda: moving.state.safety_mode is SafetyMode.PROTECTIVE_STOP, "the stop"
        )
        with raises_naming(ControlError, "protective stop"):
            moving.robot.move_joints({ELBOW: 0.8})
        with raises_naming(ControlError, "refuses 'unlock protective stop'"):
            moving.box.unlock()  # from 5 s on, as on a UR
        here = moving.robot.snapshot.positions[ELBOW]
        twin_box = twin.arm.control_box
        until(lambda: _unlocked(moving), "5 s after the stop", period=0.2)
        assert twin_box.state.safety_mode is SafetyMode.NORMAL
        assert moving.robot.snapshot.positions[ELBOW] == pytest.approx(here, abs=5e-3)
    link = moving.state.link
    assert link is not None
    assert not link.is_enabled  # its program has ended
    moving.enable()


def _unlocked(rig: RealRobotRig) -> bool:
    try:
        rig.box.unlock()
    except ControlError:
        return False
    return True


def test_a_program_that_is_stopped_on_the_pendant_ends_the_motion(
    moving: RealRobotRig,
) -> None:
    (goal,) = moving.robot.move_joints({ELBOW: 0.8}, speed=0.2)
    until(lambda: moving.robot.snapshot.positions[ELBOW] < 1.5, "motion")
    dashboard = moving.dashboard()
    assert dashboard.ask("stop") == "Stopped"
    dashboard.close()
    assert goal.wait(10.0).status is not SUCCEEDED
    until(lambda: moving.state.program is ProgramState.STOPPED, "its program's end")
    assert "program on the robot has ended" in moving.state.motion_failure
    moving.enable()


def test_power_off_and_on(moving: RealRobotRig) -> None:
    moving.box.power_off()
    assert moving.state.robot_mode is RobotMode.POWER_OFF
    with raises_naming(ControlError, "powered off", "release"):
        moving.robot.move_joints({ELBOW: 1.0})
    moving.box.release_brakes()
    assert moving.state.robot_mode is RobotMode.RUNNING
    moving.enable()


def test_an_emergency_stop_on_the_pendant(moving: RealRobotRig) -> None:
    with moving.twin() as twin:
        (goal,) = moving.robot.move_joints({ELBOW: 0.8}, speed=0.2)
        until(lambda: moving.robot.snapshot.positions[ELBOW] < 1.5, "motion")
        twin.emergency_stop()
        assert goal.wait(10.0).status is not SUCCEEDED
        stopped = SafetyMode.ROBOT_EMERGENCY_STOP
        until(lambda: moving.state.safety_mode is stopped, "the stop")
        with raises_naming(ControlError, "emergency stop"):
            moving.robot.move_joints({ELBOW: 0.8})
        twin.emergency_stop(False)
        here = twin.joint_state.position[ELBOW]
        twin.arm.control_box.power_on()
        twin.arm.control_box.release_brakes()
        until(lambda: moving.state.robot_mode is RobotMode.RUNNING, "the brakes")
        with raises_naming(ControlError, "enable"):
            moving.robot.move_joints({ELBOW: 0.8})
        assert twin.joint_state.position[ELBOW] == pytest.approx(here, abs=0.05)
    moving.enable()


def test_the_slider_of_the_pendant_slows_a_motion_down(moving: RealRobotRig) -> None:
    with moving.twin() as twin:
        box = twin.arm.control_box
        (goal,) = moving.robot.move_joints({ELBOW: 0.8}, speed=0.5)
        until(lambda: moving.robot.snapshot.positions[ELBOW] < 1.5, "motion")
        box.set_speed_slider(0.05)
        until(lambda: moving.state.speed_scaling == 0.05, "the slider")
        assert not goal.status.is_terminal
        box.set_speed_slider(1.0)
        assert goal.wait(30.0).status is SUCCEEDED, moving.state.motion_failure


def test_another_payload_than_described_is_an_obstacle(rig: RealRobotRig) -> None:
    rig.box.disable_motion()
    with rig.twin() as twin:
        twin.arm.control_box.set_payload(3.0, (0.0, 0.0, 0.05))
        until(lambda: rig.state.payload.mass == pytest.approx(3.0), "the payload")
        with raises_naming(ControlError, "payload", "3"):
            rig.enable()
        twin.arm.control_box.clear_payload()
        until(lambda: rig.state.payload.mass < 1.0, "the payload")
    rig.enable()


def test_a_second_client_is_refused_with_the_reason(rig: RealRobotRig) -> None:
    with raises_naming(tool0.Tool0Error, "IN_USE", "another client"):
        tool0.bringup(arm="ur5", hardware=rig.host)


def is_local(rig: RealRobotRig) -> bool:
    link = rig.state.link
    return link is not None and link.is_remote is False


def test_an_e_series_under_local_control_is_not_moved() -> None:
    """The pendant has the choice, and the robot 500 periods a second."""
    with real_robot("ur5e") as rig:
        rig.pendant.is_remote = False
        wrong = "the robot is under local control; choose Remote Control"
        with raises_naming(ControlError, wrong):
            rig.enable()
        until(lambda: is_local(rig), "local control")
        rig.pendant.is_remote = True
        rig.enable()
        assert rig.robot.control_period == 0.002
        (goal,) = rig.robot.move_joints({ELBOW: 1.3}, speed=0.3)
        assert goal.wait(30.0).status is SUCCEEDED, rig.state.motion_failure
        with rig.twin() as twin:
            until(lambda: abs(twin.snapshot.positions[ELBOW] - 1.3) < 2e-3, "the goal")


def test_another_arm_than_described_is_not_moved(tmp_path: Path) -> None:
    host, file = free_host(), tmp_path / "session.mcap"
    words = ("--ur", "--arm", "ur10", "--gripper", "none", "--ur-host", host)
    with closing(Bringup(os.environ, *words)) as simulated:
        simulated.wait()
        # A recording holds time at first; the robot is known before the first tick.
        with tool0.bringup(
            arm="ur5e", gripper=None, hardware=host, record=file
        ) as robot:
            link = robot.arm.control_box.state.link
            assert link is not None
            wrong = "the robot is a UR10 (a CB3), not the ur5e of this description"
            assert any(text.startswith(wrong) for text in link.obstacles)
            assert any("calibration" in text for text in link.obstacles)
            with raises_naming(ControlError, wrong, "--arm", "mm from"):
                robot.arm.control_box.enable_motion(link.serial_number)
