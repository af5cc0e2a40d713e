"""The server with a real robot, and pages that are real WebSocket clients."""

import json
import math
import socket
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from unittest.mock import patch

import pytest
from page import PATIENCE, Message, Page, page_at, socket_url
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry, Sphere
from tool0.description.transform import Pose
from tool0.errors import TransportError
from tool0.interfaces.panel import client as client_module
from tool0.interfaces.panel import object_requests
from tool0.interfaces.panel.server import Panel

ARM = "eff_joint_traj_controller"


def eventually(is_so: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while not is_so():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def test_a_page_is_greeted_with_all_it_needs(panel: Panel, robot: tool0.Robot) -> None:
    with connect(socket_url(panel.url), compression=None) as ws:
        messages = [json.loads(ws.recv(PATIENCE)) for _ in range(4)]
    kinds = [message["type"] for message in messages]
    assert kinds == ["hello", "scene", "status", "frame"]
    hello, scene, status, frame = messages
    assert (scene["number"], scene["objects"]) == (frame["scene"], frame["objects"])
    assert hello["mode"] == "simulation"
    assert hello["engine"] == "mujoco"
    assert hello["robot"]["title"] == "ur5 + 2f85"
    assert hello["robot"]["ground"] == -0.1
    assert hello["robot"]["part_names"]["elbow_joint"]["zh"]
    joints = [joint["name"] for joint in hello["robot"]["joints"]]
    assert tuple(joints) == robot.snapshot.joint_names
    assert {
        len(frame[key]) for key in ("position", "velocity", "effort", "desired")
    } == {len(joints)}
    states = {item["name"]: item["state"] for item in status["controllers"]}
    assert states.keys() == robot.defined_controllers.keys()
    assert {pose["name"] for pose in status["poses"]} >= {"home", "zero"}
    assert status["targets"].keys() >= {"elbow_joint", "finger_joint"}


def test_pages_see_objects_come_and_go(panel: Panel, robot: tool0.Robot) -> None:
    def box(name: str) -> SceneObject:
        pose = Pose(xyz=(1.5, 0.0, 0.0))
        return SceneObject(name=name, geometry=Box(size=(0.1, 0.1, 0.1)), pose=pose)

    def shown(page: Page, names: list[str]) -> Message:
        """Return a frame with these objects, as the page itself would know them."""

        def has_them(scene: Message) -> bool:
            return [item["name"] for item in scene["objects"]] == names

        number = page.see("scene", has_them)["number"]
        return page.see("frame", lambda frame: frame["scene"] == number)

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
                page.see("frame", lambda frame: frame["objects"][0][0] == [1, 2, 3])


def test_pages_add_place_and_remove_objects(panel: Panel, robot: tool0.Robot) -> None:
    shapes: dict[str, tuple[Message, Geometry]] = {
        "a": ({"kind": "box", "size": [1, 2, 3]}, Box(size=(1.0, 2.0, 3.0))),
        "b": (
            {"kind": "cylinder", "radius": 0.1, "length": 0.2},
            Cylinder(radius=0.1, length=0.2),
        ),
        "c": ({"kind": "sphere", "radius": 0.1}, Sphere(radius=0.1)),
    }
    with page_at(panel.url) as page:
        for name, (shape, geometry) in shapes.items():
            at = {"position": [3.0, 0.0, 2.0], "rpy": [0.0, 0.0, 1.0]}
            assert page.ask("add_object", name=name, shape=shape, **at) is None
            item = robot.scene[name]
            assert (item.geometry, item.mass, item.friction) == (geometry, None, 1.0)
            assert item.pose == Pose(xyz=(3.0, 0.0, 2.0), rpy=(0.0, 0.0, 1.0))
        at = {"position": [1.0, 2.0, 3.0], "rpy": [0.0, 0.0, math.pi]}
        assert page.ask("place_object", name="b", **at) is None
        assert robot.scene.pose("b").position == (1.0, 2.0, 3.0)
        assert robot.scene.pose("b").quat_wxyz == pytest.approx((0, 0, 0, 1))
        assert page.ask("remove_object", name="a") is None
        assert list(robot.scene) == ["b", "c"]


def test_what_objects_cannot_be_is_refused(panel: Panel, robot: tool0.Robot) -> None:
    box = {"name": "a", "shape": {"kind": "box", "size": [1, 1, 1]}}
    here: Message = {"position": [3, 0, 2]}
    long = {"kind": "cylinder", "radius": 0.1}
    refusals: list[tuple[str, Message, str, str]] = [
        ("remove_object", {"name": "x"}, "EngineError", "'x'"),
        ("place_object", {"name": "x", **here}, "EngineError", "'x'"),
        ("add_object", {**box, **here, "shape": long}, "ConfigError", "radius and le"),
        ("add_object", {**box, **here, "name": "tool0"}, "ConfigError", "a link"),
        ("add_object", {**box, **here, "name": "a/b"}, "ConfigError", "cannot name"),
        ("add_object", {**box, **here, "mass": -1}, "TransportError", "mass"),
        ("add_object", {**box, "position": [0, 0, 1e9]}, "TransportError", "position"),
    ]
    mesh = {"kind": "mesh", "url": "/etc/passwd"}
    refusals.append(
        ("add_object", {**box, **here, "shape": mesh}, "TransportError", "")
    )
    with page_at(panel.url) as page:
        for kind, fields, error_kind, text in refusals:
            error = page.ask(kind, **fields)
            assert error is not None, fields
            assert error["kind"] == error_kind, error
            assert text in error["message"], error
        with patch.object(object_requests, "MOST_OBJECTS", 1):
            assert page.ask("add_object", **box, **here) is None
            error = page.ask("add_object", **{**box, "name": "b"}, **here)
        assert error is not None
        assert "1 objects are there already" in error["message"]
    assert list(robot.scene) == ["a"]


def test_each_controller_says_whether_sliders_drive_it(panel: Panel) -> None:
    with page_at(panel.url) as page:
        rows = {row["name"]: row for row in page.next("status")["controllers"]}
        assert rows[ARM]["undrivable"] is None
        assert "only tells" in rows["joint_state_controller"]["undrivable"]
        group = rows["joint_group_eff_controller"]
        assert "JointGroupEffortController" in group["undrivable"]
        assert page.ask("switch_controllers", stop=[ARM]) is None
        stopped = page.see(
            "status",
            lambda status: any(
                row["name"] == ARM and row["state"] == "stopped"
                for row in status["controllers"]
            ),
        )
        (row,) = [row for row in stopped["controllers"] if row["name"] == ARM]
        assert row["undrivable"] == "It is stopped, not running: start it."
        notice = page.next("notice", lambda notice: notice["code"] == "controllers")
        assert notice["text"] == f"{ARM} stopped"


def test_a_slider_moves_the_joint_for_every_page(panel: Panel) -> None:
    with page_at(panel.url) as one, page_at(panel.url) as other:
        one.send("steer", controller=ARM, positions={"elbow_joint": 1.4}, speed=1.0)
        other.wait_for_joint("elbow_joint", 1.4)
        one.wait_for_joint("elbow_joint", 1.4)
        status = other.see(
            "status", lambda status: status["targets"]["elbow_joint"] == 1.4
        )
        assert status["clients"] == 2


def test_of_a_thousand_slider_events_the_newest_counts(robot: tool0.Robot) -> None:
    done: list[dict[str, float]] = []
    from tool0.api.controller import ControllerHandle

    steer = ControllerHandle.steer

    def counted(
        self: ControllerHandle, positions: dict[str, float], *, speed: float = 0.5
    ) -> None:
        done.append(positions)
        steer(self, positions, speed=speed)

    with (
        patch.object(ControllerHandle, "steer", counted),
        Panel(robot) as panel,
        page_at(panel.url) as page,
    ):
        start = time.monotonic()
        page.send("steer", controller=ARM, positions={"wrist_3_joint": 0.3})
        for k in range(1000):
            goal = {"elbow_joint": 1.5 + k / 10_000}
            page.send("steer", controller=ARM, positions=goal, speed=1.0)
        page.wait_for_joint("elbow_joint", 1.5999, within=0.01)
        duration = time.monotonic() - start
        page.wait_for_joint("wrist_3_joint", 0.3)
    assert done[-1]["elbow_joint"] == 1.5999
    assert len(done) <= duration * 10 + 2


def test_a_motion_goes_on_when_its_page_closes(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        for goal in (1.3, 1.2):
            page.send("steer", controller=ARM, positions={"elbow_joint": goal})
    eventually(
        lambda: abs(robot.joint_state.position["elbow_joint"] - 1.2) < 0.02,
        "the last steering is carried out although its page is gone",
    )


def test_what_a_program_asked_before_it_went_is_done(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        page.send("steer", controller=ARM, positions={"wrist_3_joint": 0.2})
        page.send("pause", id=1)
        page.send("step", id=2, ticks=300)
        page.send("save_pose", id=3, name="last")
    eventually(lambda: "last" in robot.poses(), "all requests are carried out")
    assert robot.snapshot.is_paused


def test_a_request_overtakes_no_steering_that_was_sent_before(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        for k in range(20):
            goal = {"elbow_joint": 0.5 + k / 100}
            page.send("steer", controller=ARM, positions=goal)
        assert page.ask("hold_still", controller=ARM) is None
        still = page.see("status", lambda s: s["targets"]["elbow_joint"] > 1.4)
        for _ in range(30):  # half a second: five turns of a stream
            page.next("frame")
        assert robot.snapshot.setpoints[ARM].target()[
            robot.snapshot.setpoints[ARM].joint_names.index("elbow_joint")
        ] == pytest.approx(still["targets"]["elbow_joint"], abs=0.01)


def test_time_poses_and_controllers_are_a_page_s_to_command(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        assert page.ask("pause") is None
        assert robot.snapshot.is_paused
        before = robot.time
        assert page.ask("step", ticks=5) is None
        assert robot.time == pytest.approx(before + 0.005)
        assert page.ask("set_speed", factor=2.0) is None
        assert page.ask("resume") is None
        assert robot.snapshot.speed == 2.0
        assert page.ask("save_pose", name="mine") is None
        assert robot.poses()["mine"].saved
        assert page.ask("go_to_pose", name="mine") is None
        assert page.ask("delete_pose", name="mine") is None
        assert "mine" not in robot.poses()
        group = "joint_group_eff_controller"
        assert page.ask("unload_controller", name=group) is None
        assert page.ask("load_controller", name=group) is None
        assert page.ask("reset") is None
        assert page.next("notice", lambda n: n["code"] == "reset")


def test_the_gripper_tells_what_it_does(panel: Panel) -> None:
    def at(opening: float) -> Callable[[dict[str, list[dict[str, object]]]], bool]:
        return lambda status: (
            status["grippers"][0]["motion"] == "at_target"
            and abs(float(str(status["grippers"][0]["opening"])) - opening) < 0.002
        )

    with page_at(panel.url) as page:
        name = page.hello["robot"]["grippers"][0]["name"]
        assert page.ask("grip", gripper=name, opening=0.04, force=50.0) is None
        page.see("status", at(0.04))
        error = page.ask("grip", gripper=name, opening=0.2)
        assert error is not None
        assert error["kind"] == "ModelError"


def test_a_refusal_says_why(panel: Panel) -> None:
    refusals = [
        ("unload_controller", {"name": ARM}, "ControlError", "stop"),
        ("go_to_pose", {"name": "hom"}, "ControlError", "did you mean 'home'"),
        ("hold_still", {"controller": "x"}, "ControlError", "no controller 'x'"),
        ("step", {}, "ControlError", "pause the simulation"),
        ("grip", {"gripper": "x", "opening": 0.0}, "ControlError", "gripper 'x'"),
        (
            "switch_controllers",
            {"start": ["joint_group_eff_controller"]},
            "ClaimError",
            "claim",
        ),
    ]
    with page_at(panel.url) as page:
        for kind, fields, error_kind, text in refusals:
            error = page.ask(kind, **fields)
            assert error is not None, kind
            assert error["kind"] == error_kind, error
            assert text in error["message"], error


def test_a_refused_steering_is_answered_and_told_once(panel: Panel) -> None:
    with page_at(panel.url) as page, page_at(panel.url) as other:
        for k in range(3):
            page.send("steer", controller=ARM, positions={"elbow_joint": 9.0 + k})
            reply = page.next("reply")
            assert reply["id"] is None
            assert reply["error"]["kind"] == "GoalRejectedError"
        notice = other.next("notice", lambda notice: notice["code"] == "refused")
        assert "'elbow_joint'" in notice["text"]
    with page_at(panel.url) as late:
        kept = [item for item in late.hello["notices"] if item["code"] == "refused"]
        assert len(kept) == 1


def test_the_emergency_stop_waits_behind_nothing(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        page.ask("pause")
        page.send("step", id=100, ticks=10_000)
        page.send("emergency_stop", id=101, engaged=True)
        order = [page.next("reply")["id"] for _ in range(2)]
        assert order == [101, 100]
        assert robot.snapshot.is_stopped
        notice = page.next("notice", lambda n: n["code"] == "emergency_stop")
        assert notice["severity"] == "warning"
        page.send("steer", controller=ARM, positions={"elbow_joint": 1.0})
        assert "emergency stop" in page.next("reply")["error"]["message"]
        assert page.ask("emergency_stop", engaged=False) is None


def test_an_aborted_goal_names_controller_joint_and_error(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        controller = robot.controller(ARM)
        controller.follow(
            [tool0.TrajectoryPoint([0.5] * 6, time_from_start=0.05)],
            path_tolerance={"elbow_joint": 0.01},
        )
        notice = page.next("notice", lambda n: n["code"] == "goal_aborted")
        assert notice["severity"] == "error"
        assert notice["text"].startswith(f"{ARM}: goal aborted: ")
        assert "elbow_joint" in notice["text"]


def test_nothing_is_sent_while_nothing_changes(
    panel: Panel, robot: tool0.Robot
) -> None:
    with page_at(panel.url) as page:
        page.ask("pause")
        page.see("status", lambda status: status["paused"])
        page.see("frame", lambda frame: frame["time"] == round(robot.time, 6))
        with pytest.raises(TimeoutError):
            page.receive(time.monotonic() + 0.5)


WRONG = [
    ("{", None, "no JSON"),
    ("[1]", None, "JSON object"),
    ("null", None, "JSON object"),
    ('{"id": 4}', 4, "'type'"),
    ('{"type": 3, "id": 4}', 4, "'type'"),
    ('{"type": "pauze", "id": 4}', 4, "did you mean 'pause'"),
    ('{"type": "pause"}', None, "`id`"),
    ('{"type": "pause", "id": -1}', None, "$.id"),
    ('{"type": "pause", "id": true}', None, "$.id"),
    ('{"type": "pause", "id": 4, "pleas": 1}', 4, "no field 'pleas'"),
    ('{"type": "step", "id": 4, "ticks": 0}', 4, "$.ticks"),
    ('{"type": "step", "id": 4, "ticks": 1e9}', 4, "$.ticks"),
    ('{"type": "set_speed", "id": 4, "factor": NaN}', None, "no JSON"),
    ('{"type": "set_speed", "id": 4, "factor": 1e999}', None, "out of range"),
    ('{"type": "set_speed", "id": 4, "factor": "1"}', 4, "$.factor"),
    ('{"type": "steer", "positions": {}}', None, "`controller`"),
    ('{"type": "steer", "controller": "", "positions": {}}', None, "$.controller"),
    (
        '{"type": "steer", "controller": "eff_joint_trai_controller", "positions": {}}',
        None,
        f"did you mean '{ARM}'",
    ),
    (
        f'{{"type": "steer", "controller": "{ARM}", "positions": {{"elbow": 1}}}}',
        None,
        "did you mean 'elbow_joint'",
    ),
    ('{"type": "pose_joints", "positions": {"elbow_joint": 1}}', None, "tool0 view"),
    (f'{{"type": "save_pose", "id": 4, "name": "{"x" * 201}"}}', 4, "$.name"),
    (f'{{"type": "pause", "id": 4, "x": "{"y" * 70_000}"}}', None, "65536"),
    ("[" * 60_000, None, "no JSON"),
    (b"\x00\xff", None, "binary"),
]


def test_whatever_comes_is_answered_and_the_server_lives(panel: Panel) -> None:
    with page_at(panel.url) as page:
        for text, number, why in WRONG:
            page.socket.send(text)
            reply = page.next("reply")
            assert reply["id"] == number, (text[:80], reply)
            assert why in reply["error"]["message"], (text[:80], reply)
        assert page.ask("pause") is None


def test_a_monstrous_message_ends_the_connection_only(panel: Panel) -> None:
    with page_at(panel.url) as other:
        # The code may be lost with the rest of the message, which nobody reads.
        with suppress(ConnectionClosed, OSError), page_at(panel.url) as page:
            page.socket.send("x" * (2 << 20))
            assert page.close_code() in (0, 1009)
        other.see("status", lambda status: status["clients"] == 1)
        assert other.ask("pause") is None


def test_a_mistake_of_ours_is_logged_and_answered(
    panel: Panel, robot: tool0.Robot, caplog: pytest.LogCaptureFixture
) -> None:
    def broken() -> None:
        raise ZeroDivisionError

    with page_at(panel.url) as page, patch.object(robot, "pause", broken):
        error = page.ask("pause")
        assert error is not None
        assert error["kind"] == "InternalError"
        assert "ZeroDivisionError" in caplog.text
        assert page.ask("resume") is None


def test_a_page_that_never_reads_hinders_nobody_and_is_given_up(
    robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(client_module, "STUCK_AFTER", 0.5)
    with Panel(robot) as panel, ExitStack() as exits:
        stuck = exits.enter_context(socket.socket())
        stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        host, port = panel.url.removeprefix("http://").rstrip("/").split(":")
        stuck.connect((host, int(port)))
        stuck.sendall(
            f"GET /ws HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
        )
        page = exits.enter_context(page_at(panel.url))
        page.see("status", lambda status: status["clients"] == 2)
        frames = 0
        deadline = time.monotonic() + 30.0
        gone = False
        while not gone:
            message = page.receive(deadline)
            frames += message["type"] == "frame"
            gone = message["type"] == "status" and message["clients"] == 1
        assert frames > 10
        page.send("steer", controller=ARM, positions={"elbow_joint": 1.5})
        page.wait_for_joint("elbow_joint", 1.5)


def test_a_flooding_page_is_slowed_down_and_others_are_not(panel: Panel) -> None:
    is_over = threading.Event()

    def flood(url: str) -> None:
        text = json.dumps({"type": "steer", "controller": ARM, "positions": {}})
        with connect(socket_url(url), compression=None, max_queue=None) as ws:
            while not is_over.is_set():
                ws.send(text)

    thread = threading.Thread(target=flood, args=(panel.url,), daemon=True)
    thread.start()
    with page_at(panel.url) as page:
        page.see("status", lambda status: status["clients"] == 2)
        start = time.monotonic()
        for _ in range(20):
            assert page.ask("hold_still", controller=ARM) is None
        assert time.monotonic() - start < 2.0
    is_over.set()
    panel.close()
    thread.join(PATIENCE)


def test_only_so_many_pages_are_let_in(
    robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.interfaces.panel.hub.MOST_CLIENTS", 1)
    with Panel(robot) as panel, page_at(panel.url) as page:
        with pytest.raises(InvalidStatus) as refused, connect(socket_url(panel.url)):
            pass
        assert refused.value.response.status_code == 503
        assert page.ask("pause") is None


def test_pages_hear_that_the_server_ends_and_find_the_next_one(
    robot: tool0.Robot,
) -> None:
    with Panel(robot) as panel:
        url = panel.url
        port = int(url.rsplit(":", 1)[1].rstrip("/"))
        with page_at(url) as page:
            panel.close()
            assert page.close_code() == 1001
    with Panel(robot, port=port, token="x") as panel, page_at(panel.url) as page:
        assert page.ask("pause") is None


def test_a_port_that_is_taken_is_told_unless_it_is_the_default(
    panel: Panel, robot: tool0.Robot
) -> None:
    with Panel(robot) as other:
        assert other.url != panel.url
    port = int(panel.url.rsplit(":", 1)[1].rstrip("/"))
    with pytest.raises(TransportError, match=f"port {port} of .* is taken"):
        Panel(robot, port=port)
    with pytest.raises(TransportError, match="cannot listen at 203"):
        Panel(robot, host="203.0.113.1")
    with pytest.raises(TransportError, match="port 70000"):
        Panel(robot, port=70000)


def test_no_thread_is_left_behind(robot: tool0.Robot) -> None:
    before = threading.active_count()
    with Panel(robot) as panel, page_at(panel.url) as page:
        page.ask("pause")
    eventually(lambda: threading.active_count() <= before, "threads end")
