"""Work in a child process, within bounds."""

import os
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
    with pytest.raises(ConfigError, match=r"a\.yaml:7: bad 7") as error:
        run_limited(refuse, 7)
    assert error.value.location == SourceLocation(Path("a.yaml"), 7)


def test_what_never_ends_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TIMEOUT", 0.2)
    before = children(os.getpid())
    with pytest.raises(ResourceLimitError, match=r"longer than 0\.2 s"):
        run_limited(pow, 10, 10**10)
    assert children(os.getpid()) == before


def test_what_eats_all_memory_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MEMORY", 64 << 20)
    with pytest.raises(ResourceLimitError, match="more than 64 MiB"):
        run_limited(bytes, 1 << 30)


def test_a_crash_is_told() -> None:
    with pytest.raises(ResourceLimitError, match="crashed"):
        run_limited(os.abort)


def test_an_error_that_cannot_be_sent_is_told_by_its_text() -> None:
    def fail() -> None:
        class Strange(Exception):  # noqa: N818  # nobody catches it by its name
            pass

        raise Strange("quite")

    with pytest.raises(ResourceLimitError, match="Strange: quite"):
        run_limited(fail)
