"""States as connections send them: the fields that a reader wants, and no others."""

from typing import get_args

import msgspec
import pytest

import tool0
from tool0.protocol.codec import encode
from tool0.protocol.state import ArmSample, JointSetpoint, Snapshot
from tool0.protocol.state_message import (
    SNAPSHOT_FIELDS,
    StateField,
    StateMask,
    StateMessage,
    snapshot_of,
    state_message,
)

ALWAYS = {"time", "tick", "missed", "scene_number"}


@pytest.fixture(scope="module")
def snapshot() -> Snapshot:
    with tool0.bringup(realtime=False, scene="table_and_cubes") as robot:
        robot.simulation.subscribe(
            with_commands=True, with_arms=True, with_contacts=True
        )
        robot.move_joints({"elbow_joint": 1.4})
        robot.run(0.1)
        return robot.snapshot


def sent(message: StateMessage) -> StateMessage:
    """Return a message as another process reads it."""
    return msgspec.json.decode(encode(message), type=StateMessage)


def test_a_reader_can_choose_every_field_but_those_that_always_come() -> None:
    assert {*get_args(StateField), *ALWAYS} == {*StateMessage.__struct_fields__}
    assert set(SNAPSHOT_FIELDS) < set(get_args(StateField))


@pytest.mark.parametrize("field", get_args(StateField))
def test_what_is_not_wanted_is_absent(snapshot: Snapshot, field: StateField) -> None:
    message = sent(state_message(snapshot, StateMask((field,))))
    found = {
        name
        for name in StateMessage.__struct_fields__
        if getattr(message, name) is not msgspec.UNSET
    }
    assert found == {"time", "tick", "missed", field}


def test_a_snapshot_has_what_was_wanted_of_it(snapshot: Snapshot) -> None:
    found = snapshot_of(sent(state_message(snapshot, StateMask(get_args(StateField)))))
    for name in ("joint_names", "position", "command", "contacts", "objects"):
        assert getattr(found, name) == getattr(snapshot, name)
    assert found.setpoints() == snapshot.setpoints()
    assert found.setpoints()["elbow_joint"] != JointSetpoint(0.0, 0.0, 0.0)
    none = snapshot_of(sent(state_message(snapshot, StateMask(("is_paused",)))))
    assert (none.position, none.controllers, none.arms) == ((), (), {})


def test_arms_have_the_setpoint_of_their_controller(snapshot: Snapshot) -> None:
    mask = StateMask(("arms", "wrenches", "motions"))
    message = sent(state_message(snapshot, mask))
    arm: ArmSample = message.arms["arm"]
    setpoints = snapshot.setpoints()
    desired = [setpoints[name].position for name in snapshot.arms["arm"].joint_names]
    assert arm.setpoint.positions == pytest.approx(desired, abs=0.01)
    assert any(arm.setpoint.velocities)
    assert message.wrenches == {"arm": arm.wrench}
    assert "eff_joint_traj_controller" in message.motions
    assert state_message(snapshot, StateMask(("arms",), arms=["absent"])).arms == {}
