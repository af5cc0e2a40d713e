"""What was written: hashes, in a hidden file of each package.

By them a later run tells a file that it wrote from one that a person has edited.  Each
file has all the hashes that it may have had, so that a run that is cut short counts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Final

NAME: Final = ".tool0-workspace.json"
"""The hidden file."""
_ABOUT: Final = (
    "Written by `tool0 workspace`: by these hashes it knows the files that it wrote "
    "from those that were edited."
)

Record = Mapping[PurePosixPath, frozenset[str]]
"""File, below its package, → SHA-256 of what we may have written there."""


def digest(data: bytes) -> str:
    """Return the SHA-256 of ``data``."""
    return hashlib.sha256(data).hexdigest()


def read_record(package: Path) -> Record:
    """Return the record of a package: empty if there is none that can be read.

    Then every file that is not as we would write it counts as edited.
    """
    try:
        text = (package / NAME).read_text(encoding="utf-8")
        files = json.loads(text)["sha256"]
        return {
            PurePosixPath(name): frozenset(map(str, hashes))
            for name, hashes in files.items()
        }
    except (FileNotFoundError, NotADirectoryError, ValueError, KeyError):
        return {}
    except (AttributeError, TypeError):  # JSON, but none of ours
        return {}


def record_text(record: Record) -> str:
    """Return what the hidden file holds."""
    files = {str(path): sorted(record[path]) for path in sorted(record)}
    return json.dumps({"about": _ABOUT, "sha256": files}, indent=1) + "\n"
