"""The tutorial of a real arm, on tool0's own UR controller in another process."""

from __future__ import annotations

from pathlib import Path

import pytest
from tutorial import FOLDER, follow


@pytest.mark.flaky(reruns=3)  # three programs in real time on two cores
@pytest.mark.timeout(300)
def test_the_page_can_be_followed_from_its_start_to_its_end(
    runtime_folder: Path,
) -> None:
    follow(FOLDER / "real-arm.md", runtime_folder)
