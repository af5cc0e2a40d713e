"""Work in a child process, within bounds."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import children

from tool0.errors import ConfigError, SourceLocation
from tool0.lint import resource_limits as module
from tool0.lint.resource_limits import ResourceLimitError, run_limited


def refuse(value: int) -> None:
    raise ConfigError(f"bad {value}", SourceLocation(Path("a.yaml"), value))


def test_the_answer_comes_back() -> None:
    assert run_limited(sorted, [3, 1, 2], reverse=True) == [3, 2, 1]


def test_an_error_comes_back_with_its_place() -> None:
    with pytest.raises(ConfigError) as error:
        run_limited(refuse, 7)
    assert error.value.location == SourceLocation(Path("a.yaml"), 7)


def test_what_never_ends_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TIMEOUT", 0.2)
    before = children(os.getpid())
    with pytest.raises(ResourceLimitError) as error:
        run_limited(pow, 10, 10**10)
    assert "0.2 s" in str(error.value)
    assert children(os.getpid()) == before


def fail() -> None:
    class Unpicklable(Exception):  # noqa: N818  # nobody catches it by its name
        pass

    raise Unpicklable("quite")


@pytest.mark.parametrize(
    ("work", "named"),
    [
        (lambda: bytes(1 << 30), "64 MiB"),
        (os.abort, "SIGABRT"),
        (fail, "Unpicklable: quite"),
    ],
)
def test_memory_crashes_and_errors_that_cannot_be_sent_are_named(
    monkeypatch: pytest.MonkeyPatch, work: Callable[[], object], named: str
) -> None:
    monkeypatch.setattr(module, "MEMORY", 64 << 20)
    with pytest.raises(ResourceLimitError) as error:
        run_limited(work)
    assert named in str(error.value)
