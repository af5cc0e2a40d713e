"""The page of ``tool0 view``: no physics, joints stand where they are put."""

from collections.abc import Iterator

import pytest
from page import page_at

from tool0.description.loading import assemble
from tool0.panel.server import Panel
from tool0.panel.view import RobotView

pytestmark = pytest.mark.slow


@pytest.fixture
def view() -> Iterator[Panel]:
    with Panel(RobotView(assemble(), ground=-0.1)) as panel:
        yield panel


def test_joints_stand_where_a_page_puts_them_for_every_page(view: Panel) -> None:
    with page_at(view.url) as one, page_at(view.url) as other:
        assert one.hello["mode"] == "view"
        assert one.view["engine"] is None
        one.send("pose_joints", positions={"elbow_joint": 0.7, "finger_joint": 0.4})
        frame = other.next(
            "state", lambda frame: one.position("elbow_joint", frame) == 0.7
        )
        assert other.position("finger_joint", frame) == 0.4
        for joint in other.view["robot"]["joints"]:
            if joint["mimics"] == "finger_joint":
                assert abs(other.position(joint["name"], frame)) == 0.4
        other.wait_for("status", lambda s: 0.0 < s["grippers"][0]["opening"] < 0.06)


def test_pages_learn_what_needs_physics() -> None:
    missing = RobotView(assemble()).info.missing
    assert not {"pose_joints", "grip", "reset", "save_pose"} & missing.keys()
    for method in ("move_joints", "emergency_stop", "add_object", "start_recording"):
        assert "no physics" in missing[method]


def test_poses_are_gone_to_at_once_and_saved(view: Panel) -> None:
    with page_at(view.url) as page:
        assert page.request("go_to_pose", name="zero") is None
        page.wait_for_joint("elbow_joint", 0.0)
        page.send("pose_joints", positions={"elbow_joint": 0.7})
        page.wait_for_joint("elbow_joint", 0.7)
        assert page.request("save_pose", name="bent") is None
        assert page.request("reset") is None
        page.wait_for_joint("elbow_joint", 1.5708)
        assert page.request("go_to_pose", name="bent") is None
        page.wait_for_joint("elbow_joint", 0.7)
        assert page.request("delete_pose", name="bent") is None
        gripper = page.view["robot"]["grippers"][0]["name"]
        assert page.request("grip", gripper=gripper, opening=0.0) is None
        page.wait_for_joint("finger_joint", 0.79, within=0.03)


@pytest.mark.parametrize(
    ("positions", "name"),
    [
        ({"elbow": 0.0}, "'elbow_joint'"),
        ({"elbow_joint": 3.2}, "[-3.14159, 3.14159]"),
        ({"right_inner_knuckle_joint": 0.1}, "'finger_joint'"),
        ({"elbow_joint": 0.1, "world_joint": 0.0}, "'world_joint'"),
    ],
)
def test_a_pose_that_cannot_be_is_refused(
    view: Panel, positions: dict[str, float], name: str
) -> None:
    with page_at(view.url) as page:
        page.send("pose_joints", positions=positions)
        reply = page.next("reply")
        assert reply["id"] is None
        assert reply["error"]["type"] == "ModelError"
        assert name in reply["error"]["message"], reply
        assert page.request("reset") is None


def test_what_needs_physics_says_so(view: Panel) -> None:
    with page_at(view.url) as page:
        for method in ("pause", "emergency_stop", "switch_controllers", "read_info"):
            error = page.request(method)
            assert error is not None
            assert error["type"] == "NotOfferedError"
            assert f"'{method}'" in error["message"]
        page.send("steer_joints", controller="arm", positions={})
        assert "'steer_joints'" in page.next("reply")["error"]["message"]
