from itertools import pairwise

import pytest
from raises_naming import raises_naming
from toy_robot import DT, ToyRobot

from tool0.control.publish_rate import PublishRate
from tool0.control.ros1.joint_state import PublishedJointState
from tool0.errors import ConfigError

TYPE = "type: joint_state_controller/JointStateController"


def controller(options: str):
    robot = ToyRobot(f"js: {{{TYPE}, {options}}}")
    robot.start("js")
    return robot


def message(robot: ToyRobot) -> PublishedJointState:
    state, names = robot.state, robot.hardware.joint_names
    spec = robot.manager.spec("js")
    return spec.message(names, state.position, state.velocity, state.effort)


def test_publishes_the_joints_with_a_transmission_and_claims_none() -> None:
    robot = controller("publish_rate: 125")
    robot.position = [9.0, 1.0, 2.0, 3.0]
    published = message(robot)
    assert published.names == ("hip", "slide", "wheel")
    assert published.position == (1.0, 2.0, 3.0)
    assert robot.manager.status("js").claimed == ()
    robot.tick()
    assert robot.hardware.command == [0.0] * 4


def test_joints_choose_and_order() -> None:
    robot = controller("publish_rate: 125, joints: [wheel, idle]")
    robot.velocity = [9.0, 1.0, 2.0, 3.0]
    assert message(robot).velocity == (3.0, 9.0)


def test_extra_joints_follow_and_keep_their_values_even_as_integers() -> None:
    robot = controller(
        "publish_rate: 1, extra_joints: [{name: x, position: 1, effort: 2.5},"
        " {name: hip, position: 7}]"
    )
    published = message(robot)
    assert published.names == ("hip", "slide", "wheel", "x")
    assert published.position[-1] == 1.0
    assert published.velocity[-1] == 0.0
    assert published.effort[-1] == 2.5


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ("joints: [hip]", "'publish_rate'"),
        ("publish_rate: 1, joints: [wheal]", "'wheel'"),
    ],
)
def test_wrong_parameters_are_errors(options: str, named: str) -> None:
    with raises_naming(ConfigError, named) as error:
        controller(options)
    assert error.value.location.line == 1


@pytest.mark.parametrize("rate", [125.0, 100.0, 30.0, 1000.0])
def test_is_due_as_often_as_the_rate_says(rate: float) -> None:
    gate = PublishRate(rate)
    due = [k for k in range(3000) if gate.is_due(k * DT)]
    assert due[0] == 0
    assert len(due) == pytest.approx(3.0 * rate, abs=1)
    gaps = [b - a for a, b in pairwise(due)]
    assert max(gaps) - min(gaps) <= 1


@pytest.mark.parametrize(
    ("rate", "times", "due"),
    [
        (0.0, (0.0, 1.0), ()),
        (-1.0, (0.0, 1.0), ()),
        (1.0, (10.0, 0.0, 0.5), (10.0, 0.0)),  # time starts anew
        (125.0, (0.0, 0.032, 0.032, 0.04, 0.04, 0.048), (0.0, 0.032, 0.04, 0.048)),
    ],
)
def test_each_instant_is_due_once(
    rate: float, times: tuple[float, ...], due: tuple[float, ...]
) -> None:
    gate = PublishRate(rate)
    assert tuple(time for time in times if gate.is_due(time)) == due


def test_what_was_missed_is_caught_up_unless_nothing_ran() -> None:
    def due(start: float) -> int:
        gate = PublishRate(10.0)
        gate.is_due(0.0)
        return sum(gate.is_due(start + 0.008 * k) for k in range(25))

    assert due(0.4) == 3 + 2  # 0.2 s are two periods
    assert due(60.0) == 1 + 1
