"""The recorded session of these tests."""

from __future__ import annotations

import pytest
from recording_session import Session, record_session


@pytest.fixture(scope="session")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return record_session(tmp_path_factory.mktemp("recording") / "session.mcap")
