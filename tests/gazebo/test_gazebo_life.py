"""gzserver's life cycle, and above all its end."""

import os
import signal
import time
from pathlib import Path

import pytest
from in_gazebo import PATIENCE, BringUp, gazebo_with, process_with_a_robot
from processes import Watch, descendants, listening, program

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import EngineError, EngineUnavailableError

REPORTED_WITHIN = 2.0
"""Until a loss is reported [wall s]."""
CUBE = Scene(
    objects=(
        SceneObject(
            name="cube",
            geometry=Box(size=(0.1, 0.1, 0.1)),
            pose=Pose(xyz=(0.6, 0.0, 0.0)),
            mass=0.1,
        ),
    )
)


def end_of(robot: tool0.Robot) -> tuple[str, float]:
    """Wait until a robot in real time stands still; return why, and after what time."""
    began = time.monotonic()
    reader = robot.subscribe()
    while (snapshot := reader.next(PATIENCE)) is not None:
        if snapshot.fault is not None:
            return snapshot.fault, time.monotonic() - began
    raise AssertionError("never told")


@pytest.mark.parametrize(
    ("number", "reported"),
    [
        (signal.SIGKILL, "SIGKILL"),
        (signal.SIGSTOP, "1.5 s"),
    ],
)
def test_a_server_that_dies_or_hangs_is_reported_and_leaves_nothing(
    number: signal.Signals, reported: str, bring_up: BringUp
) -> None:
    robot, engine = bring_up(realtime=True, scene=CUBE)
    (pid,) = engine.server.process_ids
    watch = Watch([pid])
    os.kill(pid, number)
    fault, took = end_of(robot)
    assert took < REPORTED_WITHIN
    with pytest.raises(EngineUnavailableError) as error:
        robot.run(0.1)
    assert reported in str(error.value)
    assert watch.all_ended(0.0)
    assert not engine.server.folder.exists()
    # The robot is still there to be asked; what is impossible says why.
    assert robot.snapshot.objects[0].name == "cube"
    with pytest.raises(EngineUnavailableError) as error:
        robot.reset()
    assert reported in str(error.value)
    assert robot.snapshot.fault == fault


def test_a_script_gets_the_error_too(bring_up: BringUp) -> None:
    robot, engine = bring_up()
    robot.run(0.05)
    os.kill(engine.server.process_ids[0], signal.SIGKILL)
    with pytest.raises(EngineUnavailableError) as error:
        robot.run(0.05)
    assert "SIGKILL" in str(error.value)


def test_the_end_of_its_log_is_in_the_error(tmp_path: Path, bring_up: BringUp) -> None:
    world = tmp_path / "complains.world"
    world.write_text(
        '<sdf version="1.6"><world name="w">'
        '<plugin name="p" filename="libnowhere.so"/></world></sdf>'
    )
    robot, engine = bring_up(engine_options={"world": world})
    os.kill(engine.server.process_ids[0], signal.SIGKILL)
    with pytest.raises(EngineError) as caught:
        robot.run(0.05)
    _, *log = str(caught.value).splitlines()
    assert any("[Err]" in line and "libnowhere.so" in line for line in log)
    assert "\x1b" not in str(caught.value)
    assert "Copyright" not in str(caught.value)


def test_closing_ends_it_and_closing_twice_is_allowed(bring_up: BringUp) -> None:
    robot, engine = bring_up()
    watch = Watch(engine.server.process_ids)
    robot.close()
    assert watch.all_ended(0.0)
    assert not engine.server.folder.exists()
    robot.close()


def test_what_cannot_be_brought_up_leaves_nothing(tmp_path: Path) -> None:
    world = tmp_path / "taken.world"
    world.write_text(
        '<sdf version="1.6"><world name="w"><model name="ur5_robot">'
        '<link name="l"/></model></world></sdf>'
    )
    with pytest.raises(EngineError) as error:
        tool0.bringup(simulation=gazebo_with(world=world))
    assert "'ur5_robot'" in str(error.value)
    assert not [pid for pid in descendants(os.getpid()) if "gz" in program(pid)]


def test_two_run_side_by_side(bring_up: BringUp) -> None:
    left, its_engine = bring_up(initial_pose={"elbow_joint": 1.2})
    right, other_engine = bring_up(initial_pose={"elbow_joint": 1.7})
    for robot in (left, right, left, right):
        robot.run(0.1)
    assert left.joint_state.position["elbow_joint"] == pytest.approx(1.2, abs=0.02)
    assert right.joint_state.position["elbow_joint"] == pytest.approx(1.7, abs=0.02)
    assert its_engine.server.master_uri != other_engine.server.master_uri
    left.close()
    right.run(0.1)
    assert right.time == pytest.approx(0.3)


def test_nobody_else_reaches_it(bring_up: BringUp) -> None:
    _, engine = bring_up()
    (pid,) = engine.server.process_ids
    assert set(listening(pid)) == {"tcp", "udp"}
    for protocol, addresses in listening(pid).items():
        assert addresses == {"0100007F"}, protocol  # 127.0.0.1


def test_it_ends_with_a_process_that_is_killed(bring_up: BringUp) -> None:
    with process_with_a_robot() as (ours, folder):
        servers = [pid for pid in descendants(ours.pid) if "gzserver" in program(pid)]
        watch = Watch(servers)
        ours.kill()
    assert watch.all_ended(PATIENCE)
    # Nobody is left to remove its folder; the next one does.
    assert folder.is_dir()
    _, engine = bring_up()
    assert not folder.exists()
    assert engine.server.folder.is_dir()
