"""What both installers share of apt: progress, and the causes of its failures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final, Literal

ProgressCallback = Callable[[str, float], None]
"""Called with the current activity, and how much of it is done, from 0 to 1."""

FailureCause = Literal[
    "disk full",
    "unreachable",
    "unsigned",
    "wrong content",
    "no package",
    "locked",
    "broken",
]

_OUTPUT_BY_CAUSE: Final[dict[FailureCause, tuple[str, ...]]] = {
    "disk full": ("no space left", "enough free space", "write error"),
    "unreachable": (
        "could not resolve",
        "could not connect",
        "cannot initiate the connection",
        "connection failed",
        "connection refused",
        "connection timed out",
        "failure resolving",
        "no route to host",
        "network is unreachable",
        "unable to connect",
    ),
    "unsigned": ("no_pubkey", "not signed", "gpg error", "signature", "expkeysig"),
    "wrong content": ("hash sum mismatch", "unexpected size", "hashes of expected"),
    "no package": (
        "404",
        "does not have a release file",
        "unable to locate package",
        "has no installation candidate",
    ),
    "locked": ("could not get lock",),
    "broken": ("unmet dependencies", "broken packages", "dpkg was interrupted"),
}
"""Cause → what apt prints then, in small letters; the first that matches counts."""


def explain_failure(
    output: str, explanations: Mapping[FailureCause, str]
) -> str | None:
    """Return the explanation of why apt failed, by what it printed.

    Args:
        output: What apt printed.
        explanations: Those to choose from.
    """
    text = output.lower()
    for cause, phrases in _OUTPUT_BY_CAUSE.items():
        if cause in explanations and any(phrase in text for phrase in phrases):
            return explanations[cause]
    return None
