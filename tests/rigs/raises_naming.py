"""Errors by their type and by the names and values that they show."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def raises_naming(
    kind: type[BaseException], *shown: str
) -> Iterator[pytest.ExceptionInfo[BaseException]]:
    """Expect an error of ``kind`` whose text holds each of ``shown``."""
    with pytest.raises(kind) as error:
        yield error
    text = str(error.value)
    assert all(part in text for part in shown), text
