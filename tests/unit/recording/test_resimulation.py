"""A recorded session repeats to the bit, and a changed file is found out."""

from __future__ import annotations

import math
import struct
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import NonSeekingReader
from mcap.writer import Writer

import tool0
from tool0.control.config import ControllerConfig
from tool0.description.config import DescriptionConfig
from tool0.description.shapes import Box
from tool0.errors import RecordingError, Tool0Error
from tool0.kernel import library
from tool0.protocol.arm_motion import SpeedTool
from tool0.protocol.control_box_state import SafetyMode
from tool0.protocol.controllers import SetControllerParameters
from tool0.protocol.motion import SteerJoints
from tool0.protocol.objects import AddModel
from tool0.protocol.recordings import StartRecording, StopRecording
from tool0.recording.journal import REQUESTS
from tool0.recording.reading import open_recording
from tool0.recording.resimulation import Resimulation, resimulate
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.handlers.table import post

Session = Callable[[tool0.Robot], None]

MODEL = """
<sdf version="1.6"><model name="can"><link name="can">
  <inertial><mass>0.2</mass></inertial>
  <collision name="c"><geometry><cylinder><radius>0.03</radius><length>0.1</length>
  </cylinder></geometry></collision></link></model></sdf>
"""
ARM = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint")


def sliders_and_goals(robot: tool0.Robot) -> None:
    """Streams of setpoints, goals that are replaced, cancelled and reached."""
    name = "eff_joint_traj_controller"
    for n in range(20):
        robot.channel.call(
            SteerJoints(controller=name, positions={"elbow_joint": 1.5 + 0.01 * n})
        )
        robot.run(0.013)
    (goal,) = robot.move_joints({"shoulder_pan_joint": 0.4}, speed=1.0)
    robot.run(0.21)
    goal.cancel()
    robot.gripper.move(opening=0.03, force=20.0, speed=0.05)
    robot.run(0.1)
    robot.go_to_pose("up", speed=1.0)
    robot.run(0.3)
    robot.arm.move_to(robot.arm.pose(), speed=1.0)
    robot.controller(name).set_gains("elbow_joint", p=500.0)
    robot.run(0.2)


def grasps(robot: tool0.Robot) -> None:
    """A cube between the pads: contacts, friction, and a drive at its limit."""
    pads = robot.arm.pose(tool=robot.gripper.tcp())
    robot.scene.add("cube", Box(size=(0.04,) * 3), xyz=pads.position, mass=0.1)
    robot.gripper.move(opening=0.02, force=40.0)
    robot.run(0.8)
    robot.move_joints({"wrist_3_joint": 0.5, "elbow_joint": 1.3}, speed=1.0)
    robot.run(0.5)
    robot.gripper.move(opening=0.08)
    robot.run(0.3)


def objects_and_resets(robot: tool0.Robot) -> None:
    """Objects that come, are pushed, placed and go; resets with and without time."""
    robot.scene.add("box", Box(size=(0.1, 0.1, 0.1)), xyz=(0.6, 0.0, 0.3), mass=0.5)
    robot.channel.call(AddModel(name="tin", model=MODEL, xyz=(0.4, 0.5, 0.2)))
    robot.run(0.2)
    robot.apply_wrench("box", force=(2.0, 0.0, 0.0), duration=0.1)
    robot.scene.place("tin", (0.3, 0.4, 0.5), linear=(0.0, 0.1, 0.0))
    with pytest.raises(Tool0Error):
        robot.scene.remove("nothing")
    robot.run(0.3)
    robot.reset({"elbow_joint": 1.0}, keep_time=True)
    robot.run(0.1)
    robot.scene.remove("box")
    robot.run(0.1)


def stops(robot: tool0.Robot) -> None:
    """Emergency stop, protective stop by a path error, power, slider and payload."""
    box = robot.arm.control_box
    robot.subscribe(500.0)  # what a reader sees changes nothing
    box.set_safety_limits(enabled=True)
    robot.move_joints({"shoulder_pan_joint": 1.0}, speed=0.5)
    robot.run(0.15)
    robot.emergency_stop()
    robot.run(0.1)
    robot.emergency_stop(engaged=False)
    box.set_payload(1.5, (0.0, 0.0, 0.05))
    robot.move_joints({"elbow_joint": 1.0})
    robot.apply_wrench("forearm_link", force=(0.0, 0.0, -2000.0), duration=0.2)
    robot.run(0.3)
    assert box.state.safety_mode is SafetyMode.PROTECTIVE_STOP
    robot.run(5.0)
    box.unlock()
    box.power_off()
    robot.run(0.05)
    box.power_on()
    box.release_brakes()
    box.play()
    box.set_speed_slider(0.5)
    robot.run(0.1)


def an_arm_that_a_program_moves(robot: tool0.Robot) -> None:
    """Paths that replace each other, streams, force mode and hand guiding."""
    motion = robot.arm.motion
    q = [robot.arm.joints[name] for name in robot.arm.joint_names]
    with motion.taken():
        first = motion.execute_path([1.0], [[x + 0.1 for x in q]], [[0.0] * 6])
        robot.run(0.3)
        motion.execute_path(
            [1.0], [[x + 0.05 for x in q]], [[0.0] * 6], after=first, at=0.5
        )
        robot.run(0.4)
        for n in range(50):
            motion.servo_joints([x + 0.05 + 0.0005 * n for x in q])
            robot.run(0.002)
        twist = (0.0, 0.0, 0.05, 0.0, 0.0, 0.1)
        request, failures = SpeedTool(twist=twist, duration=0.1), list[Exception]()
        post(robot.simulation, request, failures.append)
        robot.run(0.2)
        assert not failures
        motion.start_force_mode(
            (0.0, 0.0, -5.0, 0.0, 0.0, 0.0),
            (False, False, True, False, False, False),
            limits=(0.1,) * 6,
        )
        robot.run(0.1)
        motion.end_force_mode()
        motion.start_freedrive()
        robot.apply_wrench("tool0", force=(0.0, 5.0, 0.0), duration=0.1)
        robot.run(0.15)
        motion.end_freedrive()
    robot.run(0.2)


def controllers(robot: tool0.Robot) -> None:
    """Controllers that are loaded from other YAML, switched and unloaded."""
    text = """
slow:
  type: effort_controllers/JointGroupEffortController
  joints: [wrist_3_joint]
"""
    robot.load("slow", ControllerConfig.from_text(text))
    robot.unload("joint_group_eff_controller")
    robot.load("joint_group_eff_controller")
    robot.switch(start=["slow"], stop=["eff_joint_traj_controller"])
    robot.controller("slow").command([0.5])
    robot.run(0.2)
    with pytest.raises(Tool0Error):
        robot.switch(start=["eff_joint_traj_controller"])
    robot.switch(start=["eff_joint_traj_controller"], stop=["slow"])
    robot.run(0.1)


def ros2(robot: tool0.Robot) -> None:
    """Controllers of ROS 2, with scaled trajectories and parameters that change."""
    robot.move_joints({"elbow_joint": 1.0, "shoulder_pan_joint": 0.3}, speed=1.0)
    robot.run(0.1)
    robot.channel.call(
        SetControllerParameters(
            controller="joint_trajectory_controller",
            parameters={"constraints.goal_time": 0.3},
        )
    )
    robot.gripper.move(opening=0.04)
    robot.run(0.3)


def a_cell(robot: tool0.Robot) -> None:
    """Two robots, one of which is stopped while the other goes on."""
    robot.move_joints({"left_elbow_joint": 1.0, "right_elbow_joint": 1.2}, speed=1.0)
    robot.run(0.1)
    robot.arms["left"].control_box.stop_protectively("test")
    robot.grippers["left"].move(opening=0.01)
    robot.run(0.3)


def plans(robot: tool0.Robot) -> None:
    """A plan that is refused, one that is executed, one that a contact stops."""
    robot.scene.add("post", Box(size=(0.1, 0.1, 0.8)), xyz=(-0.6, -0.6, 0.3))
    with pytest.raises(Tool0Error):
        robot.arm.plan({"elbow_joint": 9.0})
    plan = robot.arm.plan({"shoulder_pan_joint": 0.5}, speed=1.0)
    robot.scene.place("post", (-0.6, -0.7, 0.3))
    with pytest.raises(Tool0Error, match="'post' has moved"):
        robot.arm.execute(plan)
    goal = robot.arm.execute(robot.arm.plan({"shoulder_pan_joint": 0.5}, speed=1.0))
    assert goal.wait(timeout=10.0).status is tool0.GoalStatus.SUCCEEDED
    plan = robot.arm.plan({"shoulder_pan_joint": -0.5}, speed=0.5)
    pose = robot.arm.pose()
    goal = robot.arm.execute(plan)
    robot.run(0.2)
    x, y, z = pose.position
    turn = math.atan2(y, x) - 0.6
    at = (math.hypot(x, y) * math.cos(turn), math.hypot(x, y) * math.sin(turn), z)
    robot.scene.add("surprise", Box(size=(0.08,) * 3), xyz=at)
    assert goal.wait(timeout=10.0).status is tool0.GoalStatus.ABORTED
    robot.run(0.2)


_TABLE = SimulationConfig(scene="table_and_cubes", realtime=False)
SESSIONS: dict[str, tuple[Session, dict[str, Any]]] = {
    "sliders": (sliders_and_goals, {}),
    "grasps": (grasps, {}),
    "grasp assist": (
        grasps,
        {"simulation": SimulationConfig(grasp_assist=True, realtime=False)},
    ),
    "objects": (objects_and_resets, {"simulation": _TABLE}),
    "stops": (stops, {}),
    "arm": (an_arm_that_a_program_moves, {}),
    "plans": (plans, {}),
    "controllers": (controllers, {}),
    "ros2": (
        ros2,
        {"ros2_control": True, "control": ControlConfig(control_period=0.002)},
    ),
    "cell": (
        a_cell,
        {
            "description": DescriptionConfig(
                robots=["left=ur5+2f85@0,0.5,0", "right=ur3@0,-0.5,0"]
            )
        },
    ),
    "linkage": (
        grasps,
        {"description": DescriptionConfig(gripper_model="linkage")},
    ),
}


def recorded(
    file: Path, session: Session, options: dict[str, Any], *, lead: float = 0.05
) -> Path:
    """Record a session that begins ``lead`` [s] after the bring-up."""
    if "simulation" not in options:
        options = {**options, "realtime": False}
    with tool0.bringup(**options) as robot:
        robot.run(lead)
        robot.channel.call(StartRecording(file=str(file)))
        session(robot)
        robot.channel.call(StopRecording())
    return file


def assert_identical(outcome: Resimulation, requests: int = 1) -> None:
    assert outcome.divergence is None
    assert outcome.is_identical
    assert outcome.frames == outcome.total_frames > 10
    assert outcome.requests >= requests
    assert outcome.reasons == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", SESSIONS)
def test_a_session_repeats_to_the_bit(name: str, tmp_path: Path) -> None:
    session, options = SESSIONS[name]
    file = recorded(tmp_path / "session.mcap", session, options)
    assert_identical(resimulate(file))


@pytest.mark.slow
@pytest.mark.parametrize("recorded_with", ["kernel", "python"])
def test_kernel_and_python_repeat_each_other(
    recorded_with: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if library.load() is None:
        pytest.skip("the kernel is not compiled")
    for run in ("kernel", "python"):
        if run == "python":
            monkeypatch.setenv(library.VARIABLE, "python")
        else:
            monkeypatch.delenv(library.VARIABLE, raising=False)
        if run == recorded_with:
            file = recorded(tmp_path / "session.mcap", sliders_and_goals, {})
    if recorded_with == "python":
        monkeypatch.delenv(library.VARIABLE)
    assert_identical(resimulate(file))
    assert open_recording(file).bringup.kernel == (recorded_with == "kernel")


def test_a_session_in_real_time_repeats_with_pauses_and_steps(tmp_path: Path) -> None:
    file = tmp_path / "session.mcap"
    with tool0.bringup(realtime=True, speed=2.0) as robot:
        robot.channel.call(StartRecording(file=str(file)))
        robot.move_joints({"elbow_joint": 1.0}, speed=1.0)
        stream = threading.Thread(
            target=lambda: [
                robot.gripper.move(opening=0.01 * n) and robot.run(0.01)
                for n in range(8)
            ]
        )
        stream.start()
        stream.join()
        robot.pause()
        robot.step(5)
        robot.scene.add("box", Box(size=(0.1,) * 3), xyz=(0.6, 0.0, 0.3), mass=0.5)
        robot.step(20)
        robot.set_speed(4.0)
        robot.resume()
        robot.run(0.3)
        robot.channel.call(StopRecording())
    assert_identical(resimulate(file), requests=10)


def test_each_file_of_a_recording_repeats_also_after_a_reset(tmp_path: Path) -> None:
    def session(robot: tool0.Robot) -> None:
        robot.move_joints({"elbow_joint": 1.0}, speed=1.0)
        robot.run(0.2)
        robot.reset()
        robot.run(0.05)
        robot.reset({"elbow_joint": 1.2})
        robot.gripper.move(opening=0.02)
        robot.run(0.2)

    first = recorded(tmp_path / "session.mcap", session, {})
    files = sorted(tmp_path.glob("*.mcap"))
    assert len(files) == 3
    assert first in files
    for file in files:
        outcome = resimulate(file)
        assert outcome.is_identical, str(outcome.divergence)


def test_meshes_come_from_the_file(tmp_path: Path) -> None:
    cube = tmp_path / "cube.obj"
    faces = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
    corners = "".join(
        f"v {x} {y} {z}\n" for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)
    )
    cube.write_text(corners + faces)

    def session(robot: tool0.Robot) -> None:
        robot.scene.add("cube", cube, xyz=(0.6, 0.0, 0.3), mass=0.5)
        robot.run(0.3)

    file = recorded(tmp_path / "session.mcap", session, {})
    cube.unlink()
    assert_identical(resimulate(file))


# ---- changed files ----------------------------------------------------------------

Change = Callable[[str, bytes], bytes]


def rewritten(file: Path, change: Change) -> Path:
    """Return a copy of a recording, with other messages and attachments."""
    copy = file.with_name("changed.mcap")
    with file.open("rb") as source, copy.open("wb") as target:
        reader, writer = NonSeekingReader(source), Writer(target)
        writer.start(profile="ros2", library="test")
        for item in reader.iter_metadata():
            writer.add_metadata(item.name, item.metadata)
        source.seek(0)
        for item in NonSeekingReader(source).iter_attachments():
            data = change(item.name, item.data)
            writer.add_attachment(
                item.create_time, item.log_time, item.name, item.media_type, data
            )
        source.seek(0)
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in NonSeekingReader(source).iter_messages(
            log_time_order=False
        ):
            assert schema is not None
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id]
                )
            writer.add_message(
                channels[channel.id],
                message.log_time,
                change(channel.topic, message.data),
                message.publish_time,
                message.sequence,
            )
        writer.finish()
    return copy


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of one motion."""

    def session(robot: tool0.Robot) -> None:
        robot.move_joints({"elbow_joint": 1.0}, speed=0.50)
        robot.run(0.3)

    return recorded(tmp_path_factory.mktemp("plain") / "plain.mcap", session, {})


def test_a_changed_request_diverges(plain: Path) -> None:
    def faster(name: str, data: bytes) -> bytes:
        return (
            data.replace(b'"speed":0.5', b'"speed":0.6') if name == REQUESTS else data
        )

    outcome = resimulate(rewritten(plain, faster))
    assert not outcome.is_identical
    assert outcome.divergence is not None
    assert 0.05 < outcome.divergence.time < 0.1
    assert 0 < outcome.frames < 10 < outcome.total_frames


def test_one_changed_bit_is_found(plain: Path) -> None:
    frame = 20
    seen = 0

    def last_bit(name: str, data: bytes) -> bytes:
        nonlocal seen
        if name != "/joint_states":
            return data
        seen += 1
        if seen != frame + 1:
            return data
        (bits,) = struct.unpack("<q", data[-8:])
        return data[:-8] + struct.pack("<q", bits ^ 1)

    outcome = resimulate(rewritten(plain, last_bit))
    recording = open_recording(plain)
    assert outcome.frames == frame
    assert outcome.divergence is not None
    assert outcome.divergence.time == recording.time[frame]
    assert outcome.divergence.what == f"effort of {recording.joint_names[-1]}"
    assert outcome.divergence.found == recording.effort[frame, -1]


def test_reasons_for_differences_are_named(plain: Path) -> None:
    def older(name: str, data: bytes) -> bytes:
        if name == "bringup.json":
            here = open_recording(plain).bringup.versions["mujoco"]
            return data.replace(f'"mujoco":"{here}"'.encode(), b'"mujoco":"3.0.1"')
        if name == REQUESTS:
            return data.replace(b'"move_joints"', b'"move_joimts"').replace(
                b'"number":0', b'"number":7'
            )
        return data

    outcome = resimulate(rewritten(plain, older))
    assert outcome.divergence is not None
    version, incomplete, unknown = outcome.reasons
    assert "recorded with mujoco 3.0.1" in version
    assert "first requests were dropped" in incomplete
    assert "move_joimts at 0.050 s cannot be repeated" in unknown


def test_a_request_that_now_fails_diverges(plain: Path) -> None:
    def unknown_joint(name: str, data: bytes) -> bytes:
        if name != REQUESTS:
            return data
        return data.replace(b'"elbow_joint"', b'"elbow_jaint"')

    outcome = resimulate(rewritten(plain, unknown_joint))
    assert outcome.divergence is not None
    assert outcome.divergence.what == "outcome of move_joints"
    assert "elbow_jaint" in str(outcome.divergence.found)


def test_a_recording_without_its_start_is_refused(plain: Path) -> None:
    def no_json(name: str, data: bytes) -> bytes:
        return b"{}" if name == "bringup.json" else data

    with pytest.raises(RecordingError, match=r"bringup\.json"):
        resimulate(rewritten(plain, no_json))
