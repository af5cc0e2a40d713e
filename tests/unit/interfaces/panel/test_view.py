"""The page of ``tool0 view``: no physics, joints stand where they are put."""

from collections.abc import Iterator

import pytest
from page import page_at

from tool0.description.catalogue import assemble
from tool0.interfaces.panel.server import Panel
from tool0.interfaces.panel.source import ViewSource

pytestmark = pytest.mark.slow


@pytest.fixture
def view() -> Iterator[Panel]:
    with Panel(ViewSource(assemble(), ground=-0.1)) as panel:
        yield panel


def test_joints_stand_where_a_page_puts_them_for_every_page(view: Panel) -> None:
    with page_at(view.url) as one, page_at(view.url) as other:
        assert one.hello["mode"] == "view"
        assert one.hello["engine"] is None
        one.send("pose_joints", positions={"elbow_joint": 0.7, "finger_joint": 0.4})
        frame = other.next(
            "frame", lambda frame: one.position("elbow_joint", frame) == 0.7
        )
        assert other.position("finger_joint", frame) == 0.4
        for joint in other.hello["robot"]["joints"]:
            if joint["mimics"] == "finger_joint":
                assert abs(other.position(joint["name"], frame)) == 0.4
        other.see("status", lambda s: 0.0 < s["grippers"][0]["opening"] < 0.06)


def test_poses_are_gone_to_at_once_and_saved(view: Panel) -> None:
    with page_at(view.url) as page:
        assert page.ask("go_to_pose", name="zero") is None
        page.wait_for_joint("elbow_joint", 0.0)
        page.send("pose_joints", positions={"elbow_joint": 0.7})
        page.wait_for_joint("elbow_joint", 0.7)
        assert page.ask("save_pose", name="bent") is None
        assert page.ask("reset") is None
        page.wait_for_joint("elbow_joint", 1.5708)
        assert page.ask("go_to_pose", name="bent") is None
        page.wait_for_joint("elbow_joint", 0.7)
        assert page.ask("delete_pose", name="bent") is None
        gripper = page.hello["robot"]["grippers"][0]["name"]
        assert page.ask("grip", gripper=gripper, opening=0.0) is None
        page.wait_for_joint("finger_joint", 0.79, within=0.03)


@pytest.mark.parametrize(
    ("positions", "why"),
    [
        ({"elbow": 0.0}, "did you mean 'elbow_joint'"),
        ({"elbow_joint": 3.2}, "its limits are [-3.14159, 3.14159]"),
        ({"right_inner_knuckle_joint": 0.1}, "follows 'finger_joint'"),
        ({"elbow_joint": 0.1, "world_joint": 0.0}, "joint"),
    ],
)
def test_a_pose_that_cannot_be_is_refused(
    view: Panel, positions: dict[str, float], why: str
) -> None:
    with page_at(view.url) as page:
        page.send("pose_joints", positions=positions)
        reply = page.next("reply")
        assert reply["id"] is None
        assert why in reply["error"]["message"], reply
        assert page.ask("reset") is None


def test_what_needs_physics_says_so(view: Panel) -> None:
    with page_at(view.url) as page:
        for kind, fields in (
            ("pause", {}),
            ("emergency_stop", {"engaged": True}),
            ("switch_controllers", {}),
        ):
            error = page.ask(kind, **fields)
            assert error is not None
            assert (
                f"no physics and no controllers, so it cannot do '{kind}'"
                in (error["message"])
            )
        page.send("steer", controller="eff_joint_traj_controller", positions={})
        assert "no physics" in page.next("reply")["error"]["message"]
