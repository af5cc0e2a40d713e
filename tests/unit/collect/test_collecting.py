"""Collections with processes of this machine: nothing changes what is collected."""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from pathlib import Path

import fake_tasks
import numpy as np
import pytest
from data_sets import collecting, content, kill_one, rows, wait_for_rows
from fake_tasks import PICTURES, WALK, Homeward
from processes import Watch, descendants
from raises_naming import raises_naming

from tool0.collect import Manifest, Progress, collect
from tool0.collect.settings import episode_seed
from tool0.errors import CollectError, ConfigError

pytestmark = pytest.mark.slow

N = 60
TIMEOUT = 20.0
"""For what takes a moment on a busy machine [wall s]."""


def collected(folder: Path, n: int = N, **options: object) -> Manifest:
    return collect(WALK, n, folder, **{"workers": 1, "policy": Homeward, **options})  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Collect by one worker with one copy."""
    folder = tmp_path_factory.mktemp("reference") / "walk"
    manifest = collected(folder, copies=1)
    assert manifest.n_episodes == N
    assert manifest.is_complete
    assert 0 < manifest.n_succeeded < N
    return content(folder)


def test_workers_and_copies_make_no_difference(
    reference: dict[str, str], tmp_path: Path
) -> None:
    collected(tmp_path / "walk", workers=2, copies=5)
    assert content(tmp_path / "walk") == reference


def test_more_episodes_continue_the_same_data_set(
    reference: dict[str, str], tmp_path: Path
) -> None:
    collected(tmp_path / "walk", 17)
    assert collected(tmp_path / "walk").n_episodes == N
    assert content(tmp_path / "walk") == reference


def test_a_complete_data_set_stays_as_it_is(tmp_path: Path) -> None:
    first = collected(tmp_path / "walk", 3)
    before = content(tmp_path / "walk")
    calls: list[Progress] = []
    assert collected(tmp_path / "walk", 3, progress=calls.append) == first
    assert content(tmp_path / "walk") == before
    assert calls == []


def test_a_killed_worker_is_replaced(
    reference: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TOOL0_TEST_PACE", "0.1")
    killed: list[Progress] = []

    def kill(progress: Progress) -> None:
        if progress.n_episodes and not killed:
            kill_one("tool0.collect.local_worker")
            killed.append(progress)

    collected(tmp_path / "walk", workers=2, progress=kill)
    assert killed[0].n_episodes < N
    assert content(tmp_path / "walk") == reference


def test_after_the_driver_was_killed_the_same_command_continues(
    reference: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "walk"
    with collecting(folder, N, "--workers", "2") as driver:
        wait_for_rows(driver, folder, 1)
        watch = Watch(descendants(driver.pid))
        driver.kill()
        assert watch.all_ended(TIMEOUT)
    before = rows(folder)
    assert 0 < len(before) < N
    (folder / "data/chunk-000/episode_000059.parquet.part").write_bytes(b"part")
    with (folder / "episodes.jsonl").open("a") as log:
        log.write('{"episode_index": ')  # as a power failure leaves it
    with collecting(folder, N, "--workers", "2", pace=0.0) as driver:
        _, said = driver.communicate(timeout=60)
        assert driver.returncode == 0, said
    assert rows(folder)[: len(before)] == before
    assert content(folder) == reference


def test_ctrl_c_ends_cleanly(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    with collecting(folder, 1000) as driver:
        wait_for_rows(driver, folder, 1)
        watch = Watch(descendants(driver.pid))
        driver.send_signal(signal.SIGINT)
        _, said = driver.communicate(timeout=60)
    assert driver.returncode == 130
    assert said == "interrupted: the same command continues\n"
    assert watch.all_ended(TIMEOUT)
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["collected"] == len(rows(folder)) > 0
    assert not manifest["complete"]


@pytest.mark.parametrize("largest", [3000, 6000])  # an episode, or the rows of some
def test_a_full_disk_loses_nothing(
    largest: int, reference: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "walk"
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest, limits[1]))
    try:
        with raises_naming(CollectError, str(folder), "File too large", "continues"):
            collected(folder)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    n = len(rows(folder))
    assert (n > 0) == (largest > 3000)
    assert json.loads((folder / "manifest.json").read_text())["collected"] == n
    assert (folder / "episodes.jsonl").read_text().count("\n") == n
    assert len(list((folder / "data").glob("*/*"))) == n
    collected(folder)
    assert content(folder) == reference


def test_other_parameters_need_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "walk"
    collected(folder, 3)
    before = content(folder)
    with raises_naming(ConfigError, "seed 0 instead of 1", "another folder"):
        collected(folder, 3, seed=1)
    with raises_naming(ConfigError, "fake_tasks:Homeward", "fake_tasks:deadly"):
        collected(folder, 3, policy=fake_tasks.deadly)
    with raises_naming(ConfigError, "format"):
        collected(folder, 3, format="lerobot")
    with raises_naming(ConfigError, "options"):
        collected(folder, 3, options={"max_episode_steps": 9})
    with raises_naming(ConfigError, "has 3 episodes, more than 2"):
        collected(folder, 2)
    theirs = (folder / "manifest.json").read_text().replace('"numpy": "', '"numpy": "0')
    (folder / "manifest.json").write_text(theirs)
    with raises_naming(ConfigError, "numpy", "would not be the same"):
        collected(folder, 3)
    (folder / "manifest.json").write_text("[]")
    with raises_naming(ConfigError, "manifest.json", "no manifest"):
        collected(folder, 3)
    del before["manifest.json"]
    assert before.items() <= content(folder).items()


def test_a_folder_with_other_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "letters.txt").write_text("dear")
    with raises_naming(ConfigError, "letters.txt", "new folder"):
        collected(tmp_path)
    with raises_naming(ConfigError, "letters.txt", "File exists"):
        collected(tmp_path / "letters.txt")
    assert content(tmp_path).keys() == {"letters.txt"}


def test_two_collections_do_not_share_a_folder(tmp_path: Path) -> None:
    def second(_: Progress) -> None:
        with raises_naming(ConfigError, "another process"):
            collected(tmp_path / "walk", 3)

    assert collected(tmp_path / "walk", 3, progress=second).is_complete


def test_an_episode_that_was_removed_is_missed(tmp_path: Path) -> None:
    collected(tmp_path / "walk", 3)
    (tmp_path / "walk/data/chunk-000/episode_000001.parquet").unlink()
    with raises_naming(CollectError, "episode_000001.parquet", "missing"):
        collected(tmp_path / "walk", 5)


@pytest.mark.parametrize("line", ["[]", "{", '{"length": 3}', "\udcff"])
def test_a_damaged_index_is_told(line: str, tmp_path: Path) -> None:
    collected(tmp_path / "walk", 3)
    index = tmp_path / "walk/episodes.jsonl"
    first, _, third = index.read_bytes().splitlines(keepends=True)
    damaged = line.encode("utf-8", "surrogateescape") + b"\n"
    index.write_bytes(first + damaged + third)
    with raises_naming(CollectError, "episodes.jsonl, line 2", "damaged"):
        collected(tmp_path / "walk", 5)


def test_what_a_policy_does_wrong_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    seed = episode_seed(0, 0)
    with raises_naming(
        CollectError, "fake_tasks.py", f"ValueError: no action for {seed}"
    ):
        collected(folder, policy=fake_tasks.failing)
    with raises_naming(CollectError, str(seed), "shape (2,)"):
        collected(tmp_path / "other", policy=fake_tasks.malformed)


def test_a_policy_that_kills_its_worker_ends_the_collection(tmp_path: Path) -> None:
    with raises_naming(CollectError, "3 workers", "episodes 0 to 1", "signal 9"):
        collected(tmp_path / "walk", 2, policy=fake_tasks.deadly)


@pytest.mark.parametrize(
    ("wrong", "shown"),
    [
        ({"n": 0}, "episodes must be 1 or more"),
        ({"workers": 0}, "workers must be 1 or more"),
        ({"copies": 0}, "copies must be 1 or more"),
        ({"seed": -1}, "seed must be"),
        ({"format": "parket"}, "did you mean 'parquet'"),
        ({"options": {"x": np.zeros(2)}}, "options"),
        ({"policy": "fake_tasks"}, "module:name"),
        ({"policy": "fake_tasks:Homewart"}, "did you mean 'Homeward'"),
        ({"policy": "no_such_module:f"}, "no_such_module"),
        ({"policy": "no_such_file.py:f"}, "No such file"),
        ({"policy": lambda seed: None}, "top level"),
    ],
)
def test_wrong_parameters_change_nothing(
    wrong: dict[str, object], shown: str, tmp_path: Path
) -> None:
    with raises_naming(ConfigError, shown):
        collected(tmp_path / "walk", **wrong)  # type: ignore[arg-type]
    assert not any(tmp_path.iterdir())


def test_a_policy_may_be_in_a_file_that_does_not_change(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("def still(seed):\n    return lambda observation: [0.0, 0.0]\n")
    folder = tmp_path / "walk"
    collected(folder, 2, policy=f"{file}:still")
    moved = file.rename(tmp_path / "moved.py")
    collected(folder, 3, policy=f"{moved}:still")
    moved.write_text(moved.read_text().replace("0.0", "0.1"))
    with raises_naming(ConfigError, "still@sha256"):
        collected(folder, 4, policy=f"{moved}:still")


def test_seeds_are_apart_and_follow_from_base_and_index() -> None:
    seeds = [episode_seed(base, index) for base in range(30) for index in range(300)]
    assert len({*seeds}) == len(seeds)
    assert all(0 <= seed < 1 << 63 for seed in seeds)
    assert episode_seed(3, 4) == episode_seed(3, 4)


def test_images_are_png(tmp_path: Path) -> None:
    import pyarrow.parquet as pq

    collect(PICTURES, 1, tmp_path / "p", workers=1, policy=Homeward)
    table = pq.read_table(tmp_path / "p/data/chunk-000/episode_000000.parquet")
    images = table["observation.rgb"].to_pylist()
    assert all(image["bytes"].startswith(b"\x89PNG") for image in images)
    assert os.environ.get("TOOL0_TEST_PACE") is None


@pytest.mark.parametrize("module", ["gymnasium", "pyarrow"])
def test_what_is_not_installed_is_named(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with raises_naming(ConfigError, module, "'.[collect]'"):
        collected(tmp_path / "walk")


def test_a_worker_that_does_not_start_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text("raise SystemExit('no more')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with raises_naming(CollectError, "a worker did not start", "no more"):
        collected(tmp_path / "walk")
