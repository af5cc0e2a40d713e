"""UR's controllers of freedrive and of force mode, by their topic and services."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Message, Topic
from ros2_manager import BEST_EFFORT, Manager
from ros2_rig import JTC, LOG, SUCCESSFUL, follow, trajectory
from ur5_rig import ARM_JOINTS
from waits import until

import tool0

PASSTHROUGH = "passthrough_trajectory_controller"
SCALED = "scaled_joint_trajectory_controller"
FORCE, FREEDRIVE = "force_mode_controller", "freedrive_mode_controller"
BENT = (0.0, -1.2, 1.5, -1.87, -1.57, 0.0)
POSE = [f"{name}={q}" for name, q in zip(ARM_JOINTS, BENT, strict=True)]
OPTIONS = ("--arm", "ur5e", "--initial-pose", *POSE)
ENABLE = f"/{FREEDRIVE}/enable_freedrive_mode"
STATIC = "/tf_static"
SET = "ur_msgs/srv/SetForceMode"
TRIGGER = "std_srvs/srv/Trigger"
POSE_TOPIC = "/tcp_pose_broadcaster/pose"
QUARTER = math.sqrt(0.5)
RUNNING, BACKDRIVE = 7, 6


@pytest.fixture(scope="module")
def manager(client: Client, bringup: Bringup) -> Manager:
    return Manager(client)


@pytest.fixture(scope="module")
def poses(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening(POSE_TOPIC, "geometry_msgs/msg/PoseStamped") as topic:
        yield topic


@pytest.fixture(scope="module")
def log(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening("/rosout", LOG, wait=False) as log:
        yield log


@pytest.fixture(scope="module")
def modes(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening(
        "/io_and_status_controller/robot_mode",
        "ur_dashboard_msgs/msg/RobotMode",
        latched=True,
    ) as topic:
        yield topic


@pytest.fixture(autouse=True)
def usual_controllers(manager: Manager) -> Iterator[None]:
    """Have the usual controllers after a test, also after one that failed."""
    yield
    manager.switch([JTC], [FORCE, PASSTHROUGH, FREEDRIVE], BEST_EFFORT)


@pytest.fixture
def force_mode(manager: Manager) -> Iterator[None]:
    """Have its controller active, and nothing else that moves the arm."""
    assert manager.switch([FORCE], [JTC])
    yield
    assert manager.switch([JTC], [FORCE, PASSTHROUGH], BEST_EFFORT)


@pytest.fixture
def freedrive(manager: Manager) -> Iterator[None]:
    assert manager.switch([FREEDRIVE], [JTC])
    yield
    assert manager.switch([JTC], [FREEDRIVE], BEST_EFFORT)


@pytest.fixture
def robot(bringup: Bringup, monkeypatch: pytest.MonkeyPatch) -> Iterator[tool0.Robot]:
    """Return the robot of the bring-up, which a hand may push."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
    with tool0.connect() as robot:
        yield robot


def place(poses: Topic) -> np.ndarray:
    """Return where the flange is now, in the base [m]."""
    (now,) = poses.next()
    at = now.pose.position
    return np.array([at.x, at.y, at.z])


def axes(poses: Topic) -> np.ndarray:
    """Return the axes of the flange in the base, as columns."""
    turn = poses.last.pose.orientation
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def start(
    client: Client,
    frame: str = "base",
    *,
    turn: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0),
    push: float = 10.0,
    speed: float = 0.05,
    **fields: object,
) -> bool:
    """Let the arm push along z of a frame, which is turned by a quaternion (xyzw)."""
    x, y, z, w = turn
    reply = client.call(
        f"/{FORCE}/start_force_mode",
        SET,
        **{
            "task_frame": {
                "header": {"frame_id": frame},
                "pose": {"orientation": {"x": x, "y": y, "z": z, "w": w}},
            },
            "selection_vector_z": True,
            "wrench": {"force": {"z": push}},
            "speed_limits": {"linear": {"z": speed}},
            **fields,
        },
    )
    return bool(reply.success)


def stop(client: Client) -> Message:
    return client.call(f"/{FORCE}/stop_force_mode", TRIGGER)


def moves(poses: Topic, way: np.ndarray, least: float = 0.02) -> np.ndarray:
    """Wait until the flange has moved along ``way`` [m]; return its motion."""
    before = place(poses)
    until(lambda: bool((place(poses) - before) @ way > least), f"motion along {way}")
    moved: np.ndarray = place(poses) - before
    return moved


def rests(poses: Topic) -> bool:
    first, *_, last = (one.pose.position for one in poses.next(50))
    return math.dist((first.x, first.y, first.z), (last.x, last.y, last.z)) < 1e-6


# ---- force mode ----------------------------------------------------------------------


def test_it_claims_what_the_driver_claims(manager: Manager) -> None:
    assert not manager.switch([FORCE])  # the trajectory controller has the joints
    assert not manager.switch([FORCE, SCALED], [JTC])
    assert manager.switch([FORCE, PASSTHROUGH], [JTC])
    claimed = manager.controllers()[FORCE].claimed_interfaces
    assert len(claimed) == 29
    assert "force_mode/selection_vector_rx" in claimed
    assert not manager.switch([FREEDRIVE], [FORCE])
    assert manager.switch([FREEDRIVE], [FORCE, PASSTHROUGH])
    assert list(manager.controllers()[FREEDRIVE].claimed_interfaces) == [
        f"freedrive_mode/{item}" for item in ("async_success", "enable", "abort")
    ]
    assert manager.switch([JTC], [FREEDRIVE])


def test_an_inactive_controller_refuses(client: Client, log: Topic) -> None:
    since = log.count
    assert not start(client)
    assert not stop(client).success
    log.wait_for(
        lambda line: FORCE in line.name and "is not running" in line.msg, since=since
    )


@pytest.mark.usefixtures("force_mode")
def test_the_arm_gives_way_along_the_axis_of_the_task_frame(
    client: Client, poses: Topic
) -> None:
    place(poses)
    minus_y = -axes(poses)[:, 1]  # the frame is turned by 90° about the tool's x
    assert start(client, "tool0_controller", turn=(QUARTER, 0.0, 0.0, QUARTER))
    moved = moves(poses, minus_y)
    across = moved - (moved @ minus_y) * minus_y
    assert np.abs(across).max() < 1e-3
    reply = stop(client)
    assert reply.success, reply.message
    until(lambda: rests(poses), "rest")


@pytest.mark.usefixtures("force_mode")
def test_frames_are_links_and_what_is_fixed_to_them(
    client: Client, poses: Topic, log: Topic
) -> None:
    def fixed(parent: str, child: str, **turn: float) -> dict[str, object]:
        return {
            "header": {"frame_id": parent},
            "child_frame_id": child,
            "transform": {"rotation": turn},
        }

    client.publish(
        STATIC,
        "tf2_msgs/msg/TFMessage",
        {
            "transforms": [
                fixed("base", "board", y=QUARTER, w=QUARTER),  # its z is x of the base
                fixed("board", "hole", w=1.0),
                fixed("adrift", "boat", w=1.0),
                fixed("boat", "adrift", w=1.0),
                fixed("base", "wrong", w=0.0),
            ]
        },
        latched=True,
    )
    until(lambda: start(client, "hole", push=-10.0), "the frame")
    moves(poses, np.array([-1.0, 0.0, 0.0]))
    assert stop(client).success
    for frame in ("nowhere", "boat", "wrong", ""):
        since = log.count
        assert not start(client, frame)
        log.wait_for(
            lambda line, frame=frame: f"no frame '{frame}'" in line.msg, since=since
        )


@pytest.mark.usefixtures("force_mode")
@pytest.mark.parametrize(
    ("words", "fields"),
    [
        ("the type must be 1, 2 or 3, got 0", {"type": 0}),
        ("the type must be 1, 2 or 3, got 4", {"type": 4}),
        ("damping", {"damping_factor": -0.1}),
        ("damping", {"damping_factor": 1.1}),
        ("gain_scaling", {"gain_scaling": -0.1}),
        ("gain_scaling", {"gain_scaling": 2.1}),
        ("limits", {"deviation_limits": [-0.1] * 6}),
        ("quaternion", {"turn": (0.0, 0.0, 0.0, 0.0)}),
        ("NaN", {"turn": (0.0, math.nan, 0.0, 1.0)}),
    ],
)
def test_wrong_values_are_refused(
    client: Client, log: Topic, words: str, fields: dict[str, object]
) -> None:
    since = log.count
    assert not start(client, **fields)  # type: ignore[arg-type]
    log.wait_for(lambda line: FORCE in line.name and words in line.msg, since=since)


@pytest.mark.usefixtures("force_mode")
def test_the_ends_of_the_ranges_are_accepted(client: Client) -> None:
    for fields in (
        *({"type": kind} for kind in (1, 2, 3)),
        *({"damping_factor": value} for value in (0.0, 1.0)),
        *({"gain_scaling": value} for value in (0.0, 2.0)),
        {"selection_vector_z": False, "deviation_limits": [0.0] * 6},
        {"speed_limits": {"linear": {"z": 1e9}}},
    ):
        assert start(client, **{"push": 0.0, **fields}), fields  # type: ignore[arg-type]
        assert stop(client).success


def test_the_arm_deviates_from_the_trajectory_of_the_passthrough_controller(
    client: Client, manager: Manager, poses: Topic
) -> None:
    assert manager.switch([PASSTHROUGH, FORCE], [JTC])
    with client.listening("/joint_states", "sensor_msgs/msg/JointState") as joints:
        state = joints.last
    position = dict(zip(state.name, state.position, strict=True))
    now = np.array([position[name] for name in ARM_JOINTS])
    there = now + np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
    before = place(poses)
    assert start(client, push=10.0)  # z of the base is up
    goal = follow(client, trajectory([(1.5, there)]), PASSTHROUGH)
    status, result = goal.outcome()
    assert (status, result.error_code) == ("succeeded", SUCCESSFUL)
    after = place(poses)
    assert after[2] > before[2] + 0.03
    turn = math.atan2(after[1], after[0]) - math.atan2(before[1], before[0])
    assert turn == pytest.approx(0.4, abs=0.01)
    assert stop(client).success
    until(lambda: rests(poses), "rest")
    assert place(poses)[2] > before[2] + 0.03  # it does not go back
    back = follow(client, trajectory([(1.5, now)]), PASSTHROUGH)
    assert back.outcome()[0] == "succeeded"
    assert manager.switch([JTC], [PASSTHROUGH, FORCE])


def test_deactivation_ends_force_mode(
    client: Client, manager: Manager, poses: Topic
) -> None:
    assert manager.switch([FORCE], [JTC])
    assert start(client)
    moves(poses, np.array([0.0, 0.0, 1.0]))
    assert manager.switch([], [FORCE])
    until(lambda: rests(poses), "rest")
    assert manager.switch([JTC])


# ---- freedrive -----------------------------------------------------------------------


def enable(client: Client, *, data: bool = True) -> None:
    client.publish(ENABLE, "std_msgs/msg/Bool", {"data": data})


@pytest.mark.usefixtures("freedrive")
def test_messages_let_the_arm_be_guided_until_they_end(
    client: Client, robot: tool0.Robot, modes: Topic, poses: Topic, log: Topic
) -> None:
    since, first, before = log.count, modes.count, place(poses)
    robot.apply_wrench("tool0", force=(0.0, 0.0, 20.0), duration=3.0)
    poses.next(100)
    assert place(poses) == pytest.approx(before, abs=1e-3)
    enable(client)
    modes.wait_for(lambda mode: mode.mode == BACKDRIVE, since=first)
    until(lambda: bool(place(poses)[2] > before[2] + 0.01), "motion")
    modes.wait_for(lambda mode: mode.mode == RUNNING, since=first)  # nobody publishes
    log.wait_for(
        lambda line: FREEDRIVE in line.name and "no message came" in line.msg,
        since=since,
    )
    until(lambda: rests(poses), "rest")


@pytest.mark.usefixtures("freedrive")
def test_false_ends_it_and_repeated_messages_keep_it(
    client: Client, modes: Topic, log: Topic
) -> None:
    since, first = log.count, modes.count
    enable(client)
    modes.wait_for(lambda mode: mode.mode == BACKDRIVE, since=first)
    with client.listening("/clock", "rosgraph_msgs/msg/Clock") as clock:
        begin = clock.last.clock
        while clock.last.clock < begin + 2.5:  # the timeout is 1 s
            enable(client)
    assert modes.count == first + 1
    enable(client, data=False)
    modes.wait_for(lambda mode: mode.mode == RUNNING, since=first)
    assert not any("no message came" in line.msg for line in log.since(since))


def test_messages_to_an_inactive_controller_do_nothing(
    client: Client, manager: Manager, modes: Topic
) -> None:
    first = modes.count
    enable(client)
    assert manager.switch([FREEDRIVE], [JTC])  # later than the message
    enable(client)
    modes.wait_for(lambda mode: mode.mode == BACKDRIVE, since=first)
    assert modes.count == first + 1
    assert manager.switch([JTC], [FREEDRIVE])
    modes.wait_for(lambda mode: mode.mode == RUNNING, since=first)
