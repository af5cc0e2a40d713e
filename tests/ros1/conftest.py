"""A real roscore, and robots under it.  Where there is none, the tests say so."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from types import ModuleType

import pytest
from promised import require_ros
from ros import Bringup, Ros


@pytest.fixture(scope="session")
def ros() -> Iterator[Ros]:
    """Start one roscore for all tests that do not need one to themselves."""
    require_ros()
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="session")
def rospy(ros: Ros) -> Iterator[ModuleType]:
    """Make this process a node, in simulated time, with all messages importable."""
    from tool0.ros1.messages import import_messages

    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rospy's own
        for name, value in ros.environment.items():
            patch.setenv(name, value)
        import_messages()
        import rospy

        ros.ask("setParam", "/use_sim_time", True)  # read by init_node alone
        rospy.init_node("test", anonymous=True, disable_signals=True)
        yield rospy
        rospy.signal_shutdown("the tests are over")


@pytest.fixture(scope="module")
def bringup(ros: Ros) -> Iterator[Bringup]:
    """Bring the usual robot up, for all tests of a module."""
    bringup = ros.bring_up()
    yield bringup
    bringup.close()


@pytest.fixture
def own_ros() -> Iterator[Ros]:
    """Start a roscore for this test alone, which may end it."""
    require_ros()
    with Ros() as ros:
        yield ros
