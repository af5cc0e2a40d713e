"""Springs that pull the links of an arm that gives way."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

import tool0
from tool0.description.forward_kinematics import link_pose
from tool0.errors import EngineError, ModelError
from tool0.protocol.arm_motion import StartFreedrive, TakeArm
from tool0.protocol.objects import ClearWrenches, PullLink

WAY = np.array([0.05, -0.08, 0.05])  # [m]
POINT = (0.05, 0.0, 0.1)
"""Beside the axis of the last joint, which has little inertia [m]."""


@pytest.fixture(scope="module")
def pulled() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.fixture
def guided(pulled: tool0.Robot) -> tool0.Robot:
    """Return an arm that gives way."""
    pulled.reset()
    pulled.channel.call(TakeArm(by="a test"))
    pulled.channel.call(StartFreedrive())
    return pulled


def place(robot: tool0.Robot, link: str) -> NDArray[np.float64]:
    """Return where the point of a link is [m]."""
    position = robot.joint_state.position
    return np.array(link_pose(robot.description.model, position, link).apply(POINT))


def spring(link: str, target: NDArray[np.float64], duration: float) -> PullLink:
    x, y, z = target.tolist()
    return PullLink(name=link, point=POINT, target=(x, y, z), duration=duration)


@pytest.mark.slow
@pytest.mark.parametrize("link", ["tool0", "wrist_1_link"])
def test_a_link_goes_where_it_is_pulled_and_stays(
    guided: tool0.Robot, link: str
) -> None:
    target = place(guided, link) + WAY
    guided.channel.call(spring(link, target, duration=2.0))
    ways = []
    for _ in range(20):
        guided.run(0.1)
        ways.append(float(np.linalg.norm(place(guided, link) - target)))
    assert ways[-1] < 3e-3
    assert max(np.diff(ways)) < 2e-3  # it does not swing
    guided.run(1.0)
    assert np.linalg.norm(place(guided, link) - target) < 4e-3


def test_the_spring_ends_by_itself_and_when_it_is_cleared(guided: tool0.Robot) -> None:
    core = guided.simulation.core
    target = place(guided, "tool0") + WAY
    guided.channel.call(spring("tool0", target, duration=0.05))
    guided.run(0.1)
    assert core.pulls.is_idle
    assert core.scene.wrenches.is_idle
    guided.channel.call(spring("tool0", target, duration=1.0))
    guided.run(0.1)
    guided.channel.call(ClearWrenches(name="tool0"))
    assert core.pulls.is_idle
    assert core.scene.wrenches.is_idle


def test_the_force_is_bounded(guided: tool0.Robot) -> None:
    core = guided.simulation.core
    target = place(guided, "tool0") + np.array([0.0, 0.0, 5.0])
    guided.channel.call(spring("tool0", target, duration=1.0))
    guided.run(0.02)
    (force,) = (contact.force for contact in core.scene.wrenches.contacts())
    assert np.linalg.norm(force) == pytest.approx(80.0)


def test_what_cannot_move_is_not_pulled(guided: tool0.Robot) -> None:
    with pytest.raises(EngineError, match="base_link"):
        guided.channel.call(spring("base_link", WAY, duration=1.0))
    with pytest.raises(ModelError, match="tool0"):
        guided.channel.call(spring("tool1", WAY, duration=1.0))
    assert guided.simulation.core.pulls.is_idle
