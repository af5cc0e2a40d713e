"""The garbage collector of a process that drives a robot."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from tool0.installation import garbage


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    threshold = gc.get_threshold()
    yield
    gc.unfreeze()
    gc.set_threshold(*threshold)
    gc.enable()


def test_nothing_is_collected_at_the_start_and_little_later() -> None:
    threshold, frozen = gc.get_threshold(), gc.get_freeze_count()
    with garbage.starting():
        assert not gc.isenabled()
        garbage.started()
        assert gc.isenabled()
        assert gc.get_freeze_count() > frozen
        assert gc.get_threshold()[0] == garbage.THRESHOLD
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
    assert gc.get_threshold() == threshold


def test_a_start_that_fails_restores_everything() -> None:
    threshold = gc.get_threshold()
    with pytest.raises(ValueError, match="wrong"), garbage.starting():
        raise ValueError("wrong")
    assert gc.isenabled()
    assert gc.get_threshold() == threshold


def test_what_exists_in_a_program_of_somebody_is_left_alone() -> None:
    threshold = gc.get_threshold()
    there = [[] for _ in range(1000)]
    garbage.leave_alone()
    assert gc.get_freeze_count() > len(there)
    assert gc.get_threshold() == threshold
