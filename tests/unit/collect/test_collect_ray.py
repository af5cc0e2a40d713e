"""Collections with a real Ray on this machine."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from data_sets import RIGS, collecting, content, kill_one, rows, wait_for_rows
from fake_tasks import WALK, Homeward
from processes import Watch, descendants, listening
from raises_naming import raises_naming

from tool0.collect import Progress, collect, ray_workers
from tool0.errors import CollectError, ConfigError, TransportError

pytestmark = pytest.mark.slow

N = 60
TIMEOUT = 30.0
"""For what takes a moment on a busy machine [wall s]."""


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """Start a Ray, whose episodes take a while; return its address."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(RIGS))
        patch.setenv("TOOL0_TEST_PACE", "0.1")
        with ray_workers.own_cluster(2) as address:
            patch.undo()
            yield address


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Collect the same episodes without Ray."""
    folder = tmp_path_factory.mktemp("reference") / "walk"
    collect(WALK, N, folder, workers=1, policy=Homeward)
    return content(folder)


def test_a_killed_worker_and_a_killed_driver_lose_nothing(
    cluster: str, reference: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "walk"
    with collecting(folder, N, "--ray", cluster, "--workers", "2") as driver:
        wait_for_rows(driver, folder, 1)
        driver.kill()
    assert 0 < len(rows(folder)) < N
    killed: list[Progress] = []

    def kill(progress: Progress) -> None:
        if progress.rate and not killed:
            kill_one("ray::Worker")
            killed.append(progress)

    collect(WALK, N, folder, ray=cluster, workers=2, policy=Homeward, progress=kill)
    assert killed[0].n_episodes < N
    assert content(folder) == reference


def test_machines_with_other_programs_are_refused(
    cluster: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ray_workers, "programs", lambda: {"mujoco": "0.1"})
    with raises_naming(CollectError, "mujoco", '"0.1"', "would not be the same"):
        collect(WALK, 3, tmp_path / "walk", ray=cluster, policy=Homeward)


def test_its_own_ray_listens_to_this_machine_and_ends_with_a_killed_driver(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "walk"
    with collecting(folder, 1000, "--ray", "local", "--workers", "1") as driver:
        wait_for_rows(driver, folder, 1)
        started = descendants(driver.pid)
        for pid in (driver.pid, *started):
            for addresses in listening(pid).values():
                assert addresses <= LOOPBACK
        watch = Watch(started)
        driver.kill()
        assert watch.all_ended(TIMEOUT)


def test_a_ray_that_is_slow_to_start_is_not_called_broken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert ray_workers._START_TIMEOUT >= 120.0
    monkeypatch.setattr(ray_workers, "_START_TIMEOUT", 0.1)
    with (
        raises_naming(TransportError, "has not started within", "busy machine"),
        ray_workers.own_cluster(1),
    ):
        pass


LOOPBACK = {"0100007F", "0000000000000000FFFF00000100007F"}


@pytest.mark.parametrize(
    "wrong", ["nowhere", "ray://127.0.0.1:10001", "127.0.0.1:", ":6379", "auto"]
)
def test_what_is_no_address_is_refused(wrong: str, tmp_path: Path) -> None:
    with raises_naming(ConfigError, f"'{wrong}'", "HOST:PORT"):
        collect(WALK, 3, tmp_path / "walk", ray=wrong, policy=Homeward)


def test_a_cluster_that_cannot_be_reached_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{listener.getsockname()[1]}"
        with raises_naming(TransportError, address, "refused"):
            collect(WALK, 3, tmp_path / "walk", ray=address, policy=Homeward)
        listener.listen()
        monkeypatch.setattr(ray_workers, "_ANSWER_TIMEOUT", 2.0)
        with raises_naming(TransportError, address, "does not answer"):
            collect(WALK, 3, tmp_path / "walk", ray=address, policy=Homeward)


def test_without_ray_it_is_told_what_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with raises_naming(ConfigError, "'.[ray]'"):
        collect(WALK, 3, tmp_path / "walk", ray="local", policy=Homeward)
