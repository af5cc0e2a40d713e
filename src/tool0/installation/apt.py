"""Reads apt's progress, and finds the causes of its failures, for both installers."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Final

from tool0.installation.child_process import last_lines

ProgressCallback = Callable[[str, float], None]
"""Function that is called with the current activity and the completed fraction (0 to
1)."""

_OUTPUT_BY_CAUSE: Final = {
    "disk full": "no space left|enough free space|write error",
    "unreachable": "could not (resolve|connect)|cannot initiate the connection"
    "|connection (failed|refused|timed out)|failure resolving|no route to host"
    "|network is unreachable|unable to connect",
    "unsigned": "no_pubkey|not signed|gpg error|signature|expkeysig",
    "wrong content": "hash sum mismatch|unexpected size|hashes of expected",
    "no package": "404|does not have a release file|unable to locate package"
    "|has no installation candidate",
    "locked": "could not get lock",
    "broken": "unmet dependencies|broken packages|dpkg was interrupted",
}
"""Pattern of apt's output, by cause.  The first pattern that matches applies."""
_COMPLAINTS: Final = ("E:", "Err:", "W:")


def explain_failure(
    output: str, explanations: Mapping[str, str], *, otherwise: str
) -> str:
    """Return the reason why apt failed, and apt's last error messages.

    Args:
        output: The output of apt.
        explanations: Explanations by cause.  The causes are the keys of
            ``_OUTPUT_BY_CAUSE``.
        otherwise: The explanation that is used if no cause matches.
    """
    fitting = (
        explanations[cause]
        for cause, pattern in _OUTPUT_BY_CAUSE.items()
        if cause in explanations and re.search(pattern, output, re.IGNORECASE)
    )
    lines = output.splitlines()
    shown = [line for line in lines if line.startswith(_COMPLAINTS)] or lines
    printed = last_lines("\n".join(shown))
    return f"{next(fitting, otherwise)}. apt printed:\n{printed}"
