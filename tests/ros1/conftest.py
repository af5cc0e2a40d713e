"""A real roscore, and robots under it; visible skips where ROS 1 is not installed."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import pytest
from promised import require_engine, require_ros
from ros import Bringup, Ros

HERE = Path(__file__).parent
ROS_MODULES = "rospy|rosgraph|actionlib|genpy|tf2_ros"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Allow ROS its warnings: as errors they would end its threads."""
    for item in items:
        if item.path.is_relative_to(HERE):
            for category in (f"DeprecationWarning:{ROS_MODULES}", "ResourceWarning"):
                item.add_marker(pytest.mark.filterwarnings(f"ignore::{category}"))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show the output of the programs under ROS when a test failed."""
    report = yield
    if report.failed:
        parts = getattr(item, "funcargs", {}).values()
        for ros in (part for part in parts if isinstance(part, Ros)):
            report.sections += ros.outputs().items()
    return report


@pytest.fixture(scope="session")
def ros() -> Iterator[Ros]:
    """Start one roscore for all tests that do not need one to themselves."""
    require_ros()
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="session")
def node(ros: Ros) -> Iterator[ModuleType]:
    """Make this process a node, once, in simulated time and with all messages."""
    from tool0.installation.ros1.messages import import_messages

    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        set_environment(patch, ros)
        import_messages()
        import rospy

        ros.call_master("setParam", "/use_sim_time", True)  # read by init_node alone
        rospy.init_node("test", anonymous=True, disable_signals=True)
    yield rospy
    rospy.signal_shutdown("the tests are over")


@pytest.fixture(scope="module")
def rospy(ros: Ros, node: ModuleType) -> Iterator[ModuleType]:
    """Return rospy, this process being a node under ``ros``."""
    with pytest.MonkeyPatch.context() as patch:
        set_environment(patch, ros)
        yield node
    with warnings.catch_warnings():  # sockets that it never closes, before other tests
        warnings.simplefilter("ignore")
        gc.collect()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run tests with ``bringup`` on the module's ENGINES, unless they name one."""
    marks = metafunc.definition.iter_markers("parametrize")
    if "bringup" in metafunc.fixturenames and "bringup" not in {
        m.args[0] for m in marks
    }:
        engines = getattr(metafunc.module, "ENGINES", ("mujoco",))
        metafunc.parametrize("bringup", engines, indirect=True, scope="module")


@pytest.fixture(scope="module")
def bringup(ros: Ros, request: pytest.FixtureRequest) -> Iterator[Bringup]:
    """Bring a robot up, with the module's OPTIONS, for all its tests."""
    require_engine(request.param)
    options = getattr(request.module, "OPTIONS", ())
    bringup = ros.bring_up("--engine", request.param, *options)
    yield bringup
    bringup.close()


@pytest.fixture
def own_ros() -> Iterator[Ros]:
    """Start a roscore for this test alone, which may end it."""
    require_ros()
    with Ros() as ros:
        yield ros


@pytest.fixture
def masterless() -> Iterator[Ros]:
    """Take a port for a roscore that the test itself starts, or nobody does."""
    require_ros()
    with ExitStack() as exits:
        yield exits.push(Ros())


def set_environment(patch: pytest.MonkeyPatch, ros: Ros) -> None:
    """Connect this process to ``ros``."""
    for name, value in ros.environment.items():
        if name.startswith("ROS_"):
            patch.setenv(name, value)
