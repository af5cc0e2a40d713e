"""The start of a session is plain data, and starts the same robot again."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

import tool0
from tool0.control.config import ControllerConfig
from tool0.errors import RequestError
from tool0.protocol.trajectories import FollowTrajectory, TrajectoryPoint
from tool0.simulation.config import SimulationConfig
from tool0.simulation.handlers.journal_codec import params_of, request_of
from tool0.simulation.handlers.motion import LoadControllerWith
from tool0.simulation.handlers.reproduction import Reproduction, reproduction, restarted


def test_it_starts_the_same_robot_again(tmp_path: Path) -> None:
    options = SimulationConfig(scene="table_and_bin", spawn_z=0.3, realtime=False)
    with tool0.bringup(
        arm="ur3e",
        gripper="hande",
        initial_pose={"elbow_joint": 1.1},
        simulation=options,
    ) as robot:
        robot.run(0.2)
        robot.scene.remove(next(iter(robot.scene)))  # the start counts
        start = reproduction(robot.simulation)
        text = msgspec.json.encode(start)
        again = restarted(msgspec.json.decode(text, type=Reproduction), tmp_path, {})
        try:
            assert reproduction(again) == msgspec.structs.replace(
                start, source=str(tmp_path / "robot.urdf")
            )
            again.loop.run(0.2)
            ours, theirs = robot.snapshot, again.snapshot
            assert ours.position == theirs.position
            assert ours.velocity == theirs.velocity
            assert ours.effort == theirs.effort
            assert ours.objects == theirs.objects[1:]
        finally:
            again.close()


def test_requests_are_read_as_they_were_written() -> None:
    request = FollowTrajectory(
        controller="arm",
        points=(TrajectoryPoint([0.1, 1e-17], [2.0, 3.0], None, 0.1),),
        joint_names=("a", "b"),
        stamp=0.3,
    )
    assert request_of("follow_trajectory", params_of(request)) == request


def test_a_configuration_of_controllers_is_written_with_the_request() -> None:
    config = ControllerConfig.from_text("slow: {type: a/B, gain: 1.0e-5}")
    config = config.with_type("other", "c/D")
    request = LoadControllerWith(name="slow", config=config)
    found = request_of("load_controller_with", params_of(request))
    assert isinstance(found, LoadControllerWith)
    assert found.config is not None
    assert found.config.parameters() == {"slow": {"type": "a/B", "gain": 1e-5}}
    assert found.config.types == {"slow": "a/B", "other": "c/D"}


@pytest.mark.parametrize(
    ("method", "params", "problem"),
    [
        ("fly", b"{}", "does not have this request"),
        ("step", b'{"ticks": 0}', "ticks"),
        ("step", b'{"tocks": 1}', "tocks"),
    ],
)
def test_requests_of_another_version_are_refused(
    method: str, params: bytes, problem: str
) -> None:
    with pytest.raises(RequestError, match=problem):
        request_of(method, params)
