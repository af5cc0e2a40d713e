import math
from dataclasses import replace
from pathlib import Path

import tool0
from tool0.control.ros1.dialect import ROS1
from tool0.description.model import Joint, JointLimits, JointType
from tool0.panel.simulation_view import SimulationView, controller_infos
from tool0.protocol.channel import backend_of
from tool0.protocol.controllers import ControllerStatus

KIND = "effort_controllers/JointTrajectoryController"
ELBOW = Joint(
    name="elbow",
    type=JointType.REVOLUTE,
    parent="a",
    child="b",
    limits=JointLimits(lower=-1.0, upper=1.0, velocity=1.0, effort=1.0),
)


def why(state: str | None, kind: str = KIND, joint: Joint = ELBOW) -> str | None:
    """Return why a controller of one joint cannot be driven; state None is unloaded."""
    claimed = (("hardware_interface/EffortJointInterface", ("elbow",)),)
    status = ControllerStatus(
        name="it",
        type=kind,
        role=ROS1.role(kind),
        state=state or "",
        is_running=state == "running",
        claimed=claimed,
    )
    loaded = [] if state is None else [status]
    (info,) = controller_infos(
        {"it": kind}, loaded, {"elbow": joint}, {"it": ROS1.role(kind)}
    )
    return info.undrivable


def test_a_running_trajectory_controller_can_be_driven() -> None:
    assert why("running") is None


def test_others_say_why_not() -> None:
    assert why(None) is not None
    assert "initialized" in (why("initialized") or "")
    assert why("running", "joint_state_controller/JointStateController") is not None
    group = "effort_controllers/JointGroupEffortController"
    for state in ("running", None):
        assert "JointGroupEffortController" in (why(state, group) or "")


def test_a_slider_needs_ends_unless_the_joint_turns_on() -> None:
    endless = replace(ELBOW, limits=JointLimits(velocity=1.0, effort=1.0))
    assert "'elbow'" in (why("running", joint=endless) or "")
    assert why("running", joint=replace(endless, type=JointType.CONTINUOUS)) is None


def test_limits_are_those_that_the_controllers_keep(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(
        "joint_limits:\n"
        "  elbow_joint:\n"
        "    has_position_limits: true\n"
        "    min_position: -2.0\n"
        "    max_position: 2.5\n"
        "    has_velocity_limits: true\n"
        "    max_velocity: 1.5\n"
    )
    with tool0.bringup(realtime=False, controllers_file=file) as robot:
        view = SimulationView(backend_of(robot.channel))
        (elbow,) = [
            joint for joint in view.info.robot.joints if joint.name == "elbow_joint"
        ]
        view.close()
    assert (elbow.lower, elbow.upper, elbow.velocity) == (-2.0, 2.5, 1.5)
    assert elbow.effort is not None
    assert math.isfinite(elbow.effort)
