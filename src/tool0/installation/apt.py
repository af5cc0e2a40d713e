"""apt's progress and the causes of its failures, for both installers."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Final

from tool0.installation.child_process import last_lines

ProgressCallback = Callable[[str, float], None]
"""Called with the current activity and the completed fraction, 0 to 1."""

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
"""Cause → pattern of apt's output; the first match applies."""
_COMPLAINTS: Final = ("E:", "Err:", "W:")


def explain_failure(
    output: str, explanations: Mapping[str, str], *, otherwise: str
) -> str:
    """Return why apt failed, and its last error messages.

    Args:
        output: Output of apt.
        explanations: Explanations by cause, the keys of the table above.
        otherwise: Explanation if no cause matches.
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
