"""Without Gymnasium, the import says what to install."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import sys
sys.modules["gymnasium"] = None
import tool0
try:
    import tool0.gym
except tool0.GymUnavailableError as error:
    assert isinstance(error, ImportError)
    print(error)
"""


def test_the_message_names_the_extra() -> None:
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, check=True
    )
    assert "pip install '.[gym]'" in done.stdout
