"""What apt's failures mean for a person, and what would help."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.host_tools import last_lines

_FULL: Final = ("no space left", "enough free space", "write error")
_UNSIGNED: Final = ("no_pubkey", "not signed", "gpg error", "signature", "expkeysig")
_FORGED: Final = ("hash sum mismatch", "unexpected size", "hashes of expected file")
_ABSENT: Final = ("404", "does not have a release file", "unable to locate package")
_UNREACHABLE: Final = (
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
)


def explained(output: str, mirror: str, keyring: Path) -> EngineUnavailableError:
    """Return the error that says what went wrong, and how to go on.

    Args:
        output: All that apt said.
        mirror: The mirror that it asked.
        keyring: The keys that it trusted.
    """
    said = output.lower()
    if any(words in said for words in _FULL):
        what = "the disk is full; free some space (a GUI needs 1 GB), then run it again"
    elif any(words in said for words in _UNREACHABLE):
        what = (
            f"the mirror {mirror} cannot be reached: is there a network, or a proxy to "
            "be set in http_proxy or apt.conf? Another mirror: --mirror URL"
        )
    elif any(words in said for words in _UNSIGNED):
        what = (
            f"what {mirror} gives is not signed by a key of {keyring}; upgrade "
            "debian-archive-keyring, or name other keys: --keyring FILE"
        )
    elif any(words in said for words in _FORGED):
        what = (
            f"what {mirror} gives is not what Debian signed; try again later, or "
            "another mirror: --mirror URL"
        )
    elif any(words in said for words in _ABSENT):
        what = (
            f"the mirror {mirror} has no Debian 11 (bullseye); name one that has, "
            "such as an archive of old releases: --mirror URL"
        )
    else:
        what = "apt-get failed; run it again to go on from here"
    return EngineUnavailableError(f"{what}. apt said:\n{last_lines(output)}")
