"""Robots in ROS 2, and a client; visible skips where ROS 2 is not installed."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from promised import require_engine
from ros import Bringup
from ros2_client import Client
from ros2_domain import Domain

HERE = Path(__file__).parent


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show the output of the programs in ROS 2 when a test failed."""
    report = yield
    if report.failed:
        parts = getattr(item, "funcargs", {}).values()
        for domain in (part for part in parts if isinstance(part, Domain)):
            report.sections += domain.outputs().items()
    return report


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run tests with ``bringup`` on the module's ENGINES, unless they name one."""
    marks = metafunc.definition.iter_markers("parametrize")
    if "bringup" in metafunc.fixturenames and "bringup" not in {
        m.args[0] for m in marks
    }:
        engines = getattr(metafunc.module, "ENGINES", ("mujoco",))
        metafunc.parametrize("bringup", engines, indirect=True, scope="module")


@pytest.fixture(scope="module")
def domain() -> Iterator[Domain]:
    """Take a domain for the module's robots."""
    with Domain() as domain:
        yield domain


@pytest.fixture(scope="module")
def client(domain: Domain) -> Iterator[Client]:
    """Start a client, which serves all tests of the module."""
    client = domain.client()
    yield client
    client.close()


@pytest.fixture(scope="module")
def bringup(
    domain: Domain, client: Client, request: pytest.FixtureRequest
) -> Iterator[Bringup]:
    """Bring a robot up, with the module's OPTIONS, for all its tests.

    The client starts meanwhile.
    """
    require_engine(request.param)
    options = getattr(request.module, "OPTIONS", ())
    bringup = domain.bring_up("--engine", request.param, *options)
    yield bringup
    bringup.close()


@pytest.fixture
def own_domain() -> Iterator[Domain]:
    """Take a domain for this test alone."""
    with Domain() as domain:
        yield domain
