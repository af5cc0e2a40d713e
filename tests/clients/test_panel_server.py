"""The server with a real robot, and pages that are real WebSocket clients."""

import json
import math
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from unittest.mock import patch

import pytest
from page import TIMEOUT, Message, Page, page_at, socket_url
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder
from tool0.description.transform import Pose
from tool0.errors import TransportError
from tool0.panel.server import Panel
from tool0.protocol.codec import PROTOCOL

ARM = "eff_joint_traj_controller"
GROUP = "joint_group_eff_controller"


def eventually(is_so: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + TIMEOUT
    while not is_so():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def port_of(panel: Panel) -> int:
    return int(panel.url.rsplit(":", 1)[1].rstrip("/"))


def test_a_page_receives_what_it_shows(panel: Panel, robot: tool0.Robot) -> None:
    with connect(socket_url(panel.url), compression=None) as ws:
        hello = json.loads(ws.recv(TIMEOUT))
        ws.send('{"id": "first", "method": "subscribe_view"}')
        messages = [json.loads(ws.recv(TIMEOUT)) for _ in range(5)]
    assert (hello["protocol"], hello["mode"]) == (PROTOCOL, "simulation")
    kinds = [message["type"] for message in messages]
    assert kinds == ["reply", "view", "scene", "status", "state"]
    reply, view, scene, status, frame = messages
    assert reply["id"] == "first"
    assert (scene["number"], scene["objects"]) == (
        frame["scene_number"],
        frame["objects"],
    )
    assert view["engine"] == "mujoco"
    assert view["robot"]["title"] == "ur5 + 2f85"
    assert view["robot"]["ground"] == -0.1
    assert view["robot"]["part_names"]["elbow_joint"]["zh"]
    joints = [joint["name"] for joint in view["robot"]["joints"]]
    assert tuple(joints) == robot.snapshot.joint_names
    arrays = ("position", "velocity", "effort", "desired")
    assert {len(frame[key]) for key in arrays} == {len(joints)}
    states = {item["name"]: item["state"] for item in status["controllers"]}
    assert states.keys() == robot.info.defined_controllers.keys()
    assert {pose["name"] for pose in status["poses"]} >= {"home", "zero"}
    assert status["targets"].keys() >= {"elbow_joint", "finger_joint"}


def test_only_pages_that_ask_for_forces_get_them(
    panel: Panel, robot: tool0.Robot
) -> None:
    pose = Pose(xyz=(1.5, 0.0, -0.05))
    cube = Box(size=(0.1, 0.1, 0.1))
    robot.scene.add(SceneObject(name="cube", geometry=cube, pose=pose, mass=2.0))
    robot.simulation.loop.run(0.1)
    robot.pause()  # the forces of one instant, also while time is held
    with page_at(panel.url) as asking, page_at(panel.url) as other:
        assert not robot.simulation.bus.wants_contacts
        frame = asking.next("state")
        assert not {"contacts", "wrenches"} & frame.keys()
        assert asking.request("subscribe_view", contacts=True, wrenches=True) is None
        frame = asking.wait_for(
            "state", lambda it: it.get("contacts") and it.get("wrenches")
        )
        (contact,) = robot.contacts()
        assert frame["contacts"] == [
            {
                "first": contact.first,
                "second": contact.second,
                "point": pytest.approx(contact.point, abs=1e-6),
                "force": pytest.approx(contact.force, abs=1e-4),
                "torque": pytest.approx(contact.torque, abs=1e-4),
            }
        ]
        wrench = robot.arm.motion.state.wrench
        assert frame["wrenches"] == {"arm": pytest.approx(wrench, abs=1e-3)}
        frame = other.next("state")
        assert not {"contacts", "wrenches"} & frame.keys()
        assert asking.request("subscribe_view", contacts=True) is None
        frame = asking.next("state", lambda it: "wrenches" not in it)
        assert frame["contacts"]
    eventually(
        lambda: not robot.simulation.bus.wants_contacts, "a page that ended needs them"
    )


def test_pages_see_objects_come_and_go(panel: Panel, robot: tool0.Robot) -> None:
    def box(name: str) -> SceneObject:
        pose = Pose(xyz=(1.5, 0.0, 0.0))
        return SceneObject(name=name, geometry=Box(size=(0.1, 0.1, 0.1)), pose=pose)

    def shown(page: Page, names: list[str]) -> Message:
        """Return a frame with these objects, as the page itself would know them."""

        def has_them(scene: Message) -> bool:
            return [item["name"] for item in scene["objects"]] == names

        number = page.wait_for("scene", has_them)["number"]
        return page.wait_for("state", lambda frame: frame["scene_number"] == number)

    with page_at(panel.url) as old:
        shown(old, [])
        robot.scene.add(box("one"))
        assert shown(old, ["one"])["objects"] == [[[1.5, 0, 0], [1, 0, 0, 0]]]
        robot.scene.add(box("two"))
        with page_at(panel.url) as new:
            for page in (old, new):
                shown(page, ["one", "two"])
            robot.scene.remove("one")
            robot.scene.place("two", (1.0, 2.0, 3.0))
            for page in (old, new):
                shown(page, ["two"])
                page.wait_for(
                    "state", lambda frame: frame["objects"][0][0] == [1, 2, 3]
                )


def test_pages_add_place_and_remove_objects(panel: Panel, robot: tool0.Robot) -> None:
    can = {"kind": "cylinder", "radius": 0.1, "length": 0.2}
    with page_at(panel.url) as page:
        at = {"xyz": [3.0, 0.0, 2.0], "rpy": [0.0, 0.0, 1.0]}
        assert page.request("add_object", name="can", shape=can, **at) is None
        item = robot.scene["can"]
        assert item.geometry == Cylinder(radius=0.1, length=0.2)
        assert (item.mass, item.friction) == (None, 1.0)
        assert item.pose == Pose(xyz=(3.0, 0.0, 2.0), rpy=(0.0, 0.0, 1.0))
        at = {"xyz": [1.0, 2.0, 3.0], "rpy": [0.0, 0.0, math.pi]}
        assert page.request("place_object", name="can", **at) is None
        assert robot.scene.pose("can").position == (1.0, 2.0, 3.0)
        assert robot.scene.pose("can").quat_wxyz == pytest.approx((0, 0, 0, 1))
        assert page.request("remove_object", name="can") is None
        assert list(robot.scene) == []


BOX: Message = {"name": "a", "shape": {"kind": "box", "size": [1, 1, 1]}}
HALF_A_CYLINDER = {"kind": "cylinder", "radius": 0.1}
NO_MESH = {"kind": "mesh", "file": "package://tool0_description/nowhere.stl"}


@pytest.mark.parametrize(
    ("method", "params", "error", "name"),
    [
        ("remove_object", {"name": "x"}, "EngineError", "'x'"),
        ("place_object", {"name": "x", "xyz": [3, 0, 2]}, "EngineError", "'x'"),
        ("add_object", {**BOX, "shape": HALF_A_CYLINDER}, "RequestError", "length"),
        ("add_object", {**BOX, "shape": NO_MESH}, "DescriptionError", "nowhere.stl"),
        ("add_object", {**BOX, "name": "tool0"}, "ConfigError", "'tool0'"),
        ("add_object", {**BOX, "name": "a/b"}, "ConfigError", "'a/b'"),
        ("add_object", {**BOX, "mass": -1}, "RequestError", "mass"),
        ("add_object", {**BOX, "xyz": [0, 0, 1e9]}, "RequestError", "xyz"),
        ("unload_controller", {"name": ARM}, "ControlError", ARM),
        ("go_to_pose", {"name": "hom"}, "ControlError", "'home'"),
        ("command_trajectory", {"controller": "x"}, "ControlError", "'x'"),
        ("step", {}, "ControlError", ""),
        ("grip", {"gripper": "x", "opening": 0.0}, "ControlError", "'x'"),
        ("grip", {"opening": 0.2}, "ModelError", "0.2"),
        ("switch_controllers", {"start": [GROUP]}, "ClaimError", ARM),
    ],
)
def test_a_refusal_has_a_type_and_names_its_cause(
    shared_panel: Panel, method: str, params: Message, error: str, name: str
) -> None:
    with page_at(shared_panel.url) as page:
        refusal = page.request(method, **params)
    assert refusal is not None
    assert refusal["type"] == error, refusal
    assert name in refusal["message"]


def test_a_scene_has_a_largest_number_of_objects(
    panel: Panel, robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.simulation.handlers.objects.MOST_SHAPES", 1)
    with page_at(panel.url) as page:
        assert page.request("add_object", **BOX, xyz=[3, 0, 2]) is None
        error = page.request("add_object", **{**BOX, "name": "b"})
    assert error is not None
    assert error["type"] == "ConfigError"
    assert list(robot.scene) == ["a"]


def test_each_controller_says_whether_sliders_drive_it(panel: Panel) -> None:
    def rows(status: Message) -> dict[str, Message]:
        return {row["name"]: row for row in status["controllers"]}

    with page_at(panel.url) as page:
        first = rows(page.next("status"))
        assert first[ARM]["undrivable"] is None
        assert first["joint_state_controller"]["undrivable"] is not None
        assert "JointGroupEffortController" in first[GROUP]["undrivable"]
        assert page.request("switch_controllers", stop=[ARM]) is None
        stopped = page.wait_for("status", lambda s: rows(s)[ARM]["state"] == "stopped")
        assert "stopped" in rows(stopped)[ARM]["undrivable"]
        notice = page.next("notice", lambda notice: notice["code"] == "controllers")
        assert ARM in notice["text"]


def test_a_slider_moves_the_joint_for_every_page(panel: Panel) -> None:
    with page_at(panel.url) as one, page_at(panel.url) as other:
        goal = {"elbow_joint": 1.4}
        one.send("steer_joints", controller=ARM, positions=goal, speed=1.0)
        other.wait_for_joint("elbow_joint", 1.4)
        one.wait_for_joint("elbow_joint", 1.4)
        status = other.wait_for(
            "status", lambda status: status["targets"]["elbow_joint"] == 1.4
        )
        assert status["clients"] == 2


def test_of_a_thousand_slider_events_the_newest_counts(robot: tool0.Robot) -> None:
    kind = type(robot.simulation.executor)
    with (
        patch.object(kind, "steer", autospec=True, side_effect=kind.steer) as steer,
        Panel(robot) as panel,
        page_at(panel.url) as page,
    ):
        start = time.monotonic()
        page.send("steer_joints", controller=ARM, positions={"wrist_3_joint": 0.3})
        for k in range(1000):
            goal = {"elbow_joint": 1.5 + k / 10_000}
            page.send("steer_joints", controller=ARM, positions=goal, speed=1.0)
        page.wait_for_joint("elbow_joint", 1.5999, within=0.01)
        duration = time.monotonic() - start
        page.wait_for_joint("wrist_3_joint", 0.3)
    assert steer.call_args.args[2]["elbow_joint"] == 1.5999
    assert steer.call_count <= duration * 10 + 2


def test_everything_that_was_sent_is_done_after_the_page_closes(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        for goal in (1.3, 1.2):
            page.send("steer_joints", controller=ARM, positions={"elbow_joint": goal})
        page.start("run", duration=0.3)
        page.start("save_pose", name="last")
    eventually(lambda: "last" in robot.poses(), "the requests are carried out")
    eventually(
        lambda: abs(robot.joint_state.position["elbow_joint"] - 1.2) < 0.02,
        "the last setpoint is carried out",
    )


def test_a_stop_ends_the_setpoints_that_were_sent_before(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        for k in range(20):
            goal = {"elbow_joint": 0.5 + k / 100}
            page.send("steer_joints", controller=ARM, positions=goal)
        assert page.request("command_trajectory", controller=ARM) is None
        still = robot.snapshot.setpoints()["elbow_joint"].target
        assert still > 1.4
        for _ in range(30):  # half a second: five intervals of a stream
            page.next("state")
        assert robot.snapshot.setpoints()["elbow_joint"].target == still
        page.wait_for(
            "status",
            lambda s: s["targets"]["elbow_joint"] == pytest.approx(still, abs=1e-4),
        )


def test_a_page_commands_time_poses_and_controllers(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        assert page.request("pause") is None
        assert robot.snapshot.is_paused
        before = robot.time
        assert page.request("step", ticks=5) is None
        assert robot.time == pytest.approx(before + 0.005)
        assert page.request("set_speed", factor=2.0) is None
        assert page.request("resume") is None
        assert robot.snapshot.speed == 2.0
        assert page.request("save_pose", name="mine") is None
        assert robot.poses()["mine"].saved
        assert page.request("go_to_pose", name="mine") is None
        assert page.request("delete_pose", name="mine") is None
        assert "mine" not in robot.poses()
        assert page.request("unload_controller", name=GROUP) is None
        assert page.request("load_controller", name=GROUP) is None
        assert page.request("reset") is None
        assert page.next("notice", lambda n: n["code"] == "reset")


def test_a_gripper_shows_its_state(panel: Panel) -> None:
    def is_open(status: Message) -> bool:
        (gripper,) = status["grippers"]
        is_there = abs(gripper["opening"] - 0.04) < 0.002
        return bool(gripper["motion"] == "at_target" and is_there)

    with page_at(panel.url) as page:
        name = page.view["robot"]["grippers"][0]["name"]
        assert page.request("grip", gripper=name, opening=0.04, force=50.0) is None
        page.wait_for("status", is_open)
        ended = page.next("goal_finished")
        assert ended["outcome"]["status"] == "SUCCEEDED"


def test_a_refused_setpoint_is_answered_and_noted_once(panel: Panel) -> None:
    with page_at(panel.url) as page, page_at(panel.url) as other:
        for k in range(3):
            goal = {"elbow_joint": 10.0 + k}
            page.send("steer_joints", controller=ARM, positions=goal)
            reply = page.next("reply")
            assert reply["id"] is None
            assert reply["error"]["type"] == "GoalRejectedError"
        notice = other.next("notice", lambda notice: notice["code"] == "refused")
        assert "'elbow_joint'" in notice["text"]
    with page_at(panel.url) as late:
        kept = [item for item in late.view["notices"] if item["code"] == "refused"]
        assert len(kept) == 1


def test_the_emergency_stop_waits_for_no_step_however_long(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        page.request("pause")
        for _ in range(100):
            page.start("step", ticks=1_000_000)
        stop = page.start("emergency_stop")
        assert page.next("reply")["id"] == stop
        assert robot.snapshot.is_stopped
        notice = page.next("notice", lambda n: n["code"] == "emergency_stop")
        assert notice["severity"] == "warning"
        page.send("steer_joints", controller=ARM, positions={"elbow_joint": 1.0})
        refusal = page.next("reply", lambda reply: reply["id"] is None)
        assert refusal["error"]["type"] == "ControlError"
        assert page.request("emergency_stop", engaged=False) is None


def test_an_aborted_goal_names_controller_and_joint(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        robot.controller(ARM).follow(
            [tool0.TrajectoryPoint([0.5] * 6, time_from_start=0.05)],
            path_tolerance={"elbow_joint": 0.01},
        )
        notice = page.next("notice", lambda n: n["code"] == "goal_aborted")
        assert notice["severity"] == "error"
        assert notice["text"].startswith(ARM)
        assert "elbow_joint" in notice["text"]


def test_only_the_last_frame_is_repeated_while_nothing_changes(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        page.request("pause")
        page.wait_for("status", lambda status: status["paused"])
        at = round(robot.time, 6)
        last = page.wait_for("state", lambda frame: frame["time"] == at)
        start = time.monotonic()
        repeated = [page.receive(start + 30.0) for _ in range(4)]
        assert repeated == [last] * 4
        assert time.monotonic() - start > 0.5  # five a second, not sixty


def steer(controller: str = ARM, **positions: float) -> str:
    params = {"controller": controller, "positions": positions}
    return json.dumps({"method": "steer_joints", "params": params})


WRONG = [
    ("{", None, "TransportError", ""),
    ("", None, "TransportError", ""),
    ("[" * 60_000, None, "TransportError", ""),
    (b"\x00\xff", None, "TransportError", ""),
    ('{"id": 4, "method": 3}', 4, "TransportError", "method"),
    ('{"id": 4, "method": "pauze"}', 4, "TransportError", "'pause'"),
    ('{"id": 4, "method": "read_controller_spec"}', 4, "TransportError", ""),
    ('{"id": 4, "method": "set_speed", "params": {"factor": NaN}}', None, "Transp", ""),
    ('{"method": "steer_joints"}', None, "RequestError", "controller"),
    (steer("eff_joint_trai_controller"), None, "ControlError", f"'{ARM}'"),
    (steer(elbow=1.0), None, "ModelError", "'elbow_joint'"),
    (
        '{"method": "pose_joints", "params": {"positions": {"elbow_joint": 1}}}',
        None,
        "NotOfferedError",
        "tool0 view",
    ),
]


def test_whatever_comes_is_answered_and_the_server_lives(panel: Panel) -> None:
    with page_at(panel.url) as page:
        for text, number, error, name in WRONG:
            page.socket.send(text)
            reply = page.next("reply")
            assert reply["id"] == number, (text[:80], reply)
            assert reply["error"]["type"].startswith(error), (text[:80], reply)
            assert name in reply["error"]["message"], (text[:80], reply)
        assert page.request("pause") is None


@pytest.mark.parametrize("size", [70_000, 2 << 20])
def test_a_message_that_is_too_long_ends_the_connection_only(
    panel: Panel, size: int
) -> None:
    with page_at(panel.url) as other:
        # The code may be lost with the rest of the message, which is not read.
        with suppress(ConnectionClosed, OSError), page_at(panel.url) as page:
            page.socket.send("x" * size)
            assert page.close_code() in (0, 1009)
        other.wait_for("status", lambda status: status["clients"] == 1)
        assert other.request("pause") is None


def test_an_internal_error_is_logged_and_answered(
    panel: Panel, robot: tool0.Robot, caplog: pytest.LogCaptureFixture
) -> None:
    loop = type(robot.simulation.loop)
    with (
        page_at(panel.url) as page,
        patch.object(loop, "set_paused", side_effect=ZeroDivisionError),
    ):
        error = page.request("pause")
        assert error is not None
        assert error["type"] == "InternalError"
        assert "ZeroDivisionError" in caplog.text
        assert page.request("set_speed", factor=1.0) is None


def test_a_page_that_never_reads_hinders_nobody_and_is_dropped(
    robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.server.session.STUCK_AFTER", 0.5)
    with Panel(robot) as panel, page_at(panel.url) as page, socket.socket() as sock:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        sock.connect(("127.0.0.1", port_of(panel)))
        options: Message = {"sock": sock, "max_queue": 1, "close_timeout": 0.0}
        with connect(socket_url(panel.url), compression=None, **options) as stuck:
            stuck.send('{"method": "subscribe_view"}')
            page.wait_for("status", lambda status: status["clients"] == 2)
            frames = 0
            is_dropped = False
            while not is_dropped:
                message = page.receive(time.monotonic() + TIMEOUT)
                frames += message["type"] == "state"
                is_dropped = message["type"] == "status" and message["clients"] == 1
        assert frames > 10
        page.send("steer_joints", controller=ARM, positions={"elbow_joint": 1.5})
        page.wait_for_joint("elbow_joint", 1.5)


def test_a_flooding_page_is_slowed_down_and_others_are_not(panel: Panel) -> None:
    is_over = threading.Event()

    def flood(url: str) -> None:
        client = connect(socket_url(url), compression=None, max_queue=None)
        with suppress(ConnectionClosed), client as ws:  # it sends until the end
            ws.send('{"method": "subscribe_view"}')
            while not is_over.is_set():
                ws.send(steer())

    thread = threading.Thread(target=flood, args=(panel.url,), daemon=True)
    thread.start()
    with page_at(panel.url) as page:
        page.wait_for("status", lambda status: status["clients"] == 2)
        start = time.monotonic()
        for _ in range(20):
            assert page.request("command_trajectory", controller=ARM) is None
        assert time.monotonic() - start < TIMEOUT
    is_over.set()
    panel.close()
    thread.join(TIMEOUT)


def test_the_number_of_pages_is_limited(
    robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.panel.server.MAX_PAGES", 1)
    with Panel(robot) as panel, page_at(panel.url) as page:
        with pytest.raises(InvalidStatus) as refused, connect(socket_url(panel.url)):
            pass
        assert refused.value.response.status_code == 503
        assert page.request("pause") is None


def test_pages_hear_that_the_server_ends_and_find_the_next_one(
    robot: tool0.Robot,
) -> None:
    with Panel(robot) as panel:
        port = port_of(panel)
        with page_at(panel.url) as page:
            panel.close()
            assert page.close_code() == 1001
    with Panel(robot, port=port, token="x") as panel, page_at(panel.url) as page:
        assert page.request("pause") is None


def test_a_taken_port_is_refused_unless_it_is_the_default(
    panel: Panel, robot: tool0.Robot
) -> None:
    with Panel(robot) as other:
        assert other.url != panel.url
    port = port_of(panel)
    for host, chosen, name in (
        (None, port, str(port)),
        ("203.0.113.1", None, "203.0.113.1"),
        (None, 70000, "70000"),
    ):
        with pytest.raises(TransportError) as refused:
            Panel(robot, host=host, port=chosen)
        assert name in str(refused.value)


def test_no_thread_is_left_behind(robot: tool0.Robot) -> None:
    before = threading.active_count()
    with Panel(robot) as panel, page_at(panel.url) as page:
        page.request("pause")
    eventually(lambda: threading.active_count() <= before, "threads end")
