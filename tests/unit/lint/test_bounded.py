"""Files are read in a child process, with limits."""

import pytest

from tool0.lint import bounded as module
from tool0.lint.bounded import OutOfBoundsError, bounded


def test_arguments_go_to_the_child_and_its_result_comes_back() -> None:
    assert bounded(sorted, [3, 1, 2], reverse=True) == [3, 2, 1]


def test_what_exceeds_the_limits_is_out_of_bounds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "TIMEOUT", 0.2)
    with pytest.raises(OutOfBoundsError) as error:
        bounded(pow, 10, 10**10)
    assert "0.2 s" in str(error.value)
    monkeypatch.undo()
    monkeypatch.setattr(module, "MEMORY", 64 << 20)
    with pytest.raises(OutOfBoundsError) as error:
        bounded(bytes, 1 << 30)
    assert "64 MiB" in str(error.value)
