"""Getting a Gazebo 11 ready to run, and removing what that made."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import ConfigError, EngineUnavailableError
from tool0.installation.gazebo.installation import (
    Installation,
    find_system,
    from_prefix,
    private_prefix,
)
from tool0.installation.gazebo.plugin import (
    bridge_libraries,
    plugin_folder,
    require_compiler,
)
from tool0.installation.gazebo.private import Report, make_prefix
from tool0.installation.gazebo.unpack import size_on_disk
from tool0.user_data import locked

KEYRING: Final = Path("/usr/share/keyrings/debian-archive-keyring.gpg")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Wish:
    """What a person wants installed, and from where."""

    has_client: bool = False
    """Whether gzclient and a driver to draw with shall run, too."""
    is_private: bool = False
    """Whether the system's own Gazebo shall not do."""
    mirror: str | None = None
    """Address of a Debian mirror; None for those of the machine's apt."""
    keyring: Path = KEYRING
    """The keys by which Debian 11 must be signed."""

    def __post_init__(self) -> None:
        if self.mirror is not None and (
            "://" not in self.mirror or len(self.mirror.split()) != 1
        ):
            raise ConfigError(
                "a mirror is an address such as http://host/debian, not "
                f"'{self.mirror}'"
            )
        if len(str(self.keyring).split()) != 1:
            raise ConfigError(
                f"apt takes no keyring with a space in its path: '{self.keyring}'"
            )


def ready(wish: Wish, report: Report) -> Installation:
    """Return a Gazebo that is ready to run, with what we load into it compiled.

    That is the system's, the private one if it is there, or one that is made now.

    Raises:
        EngineUnavailableError: If there can be none, with the reason and the remedy.
    """
    require_compiler()  # before a long download, not after it
    system = None if wish.is_private else find_system()
    installation = system or _private(wish, report)
    report("compiling the bridge to Gazebo", 0.0)
    bridge_libraries(installation)
    report("compiling the bridge to Gazebo", 1.0)
    return installation


def uninstall() -> int:
    """Remove the private prefix, downloads and compiled libraries; return the bytes."""
    freed = 0
    for folder in (private_prefix().parent, plugin_folder()):
        if folder.is_dir():
            with _alone(folder):
                freed += size_on_disk(folder)
                shutil.rmtree(folder)
    return freed


def _private(wish: Wish, report: Report) -> Installation:
    prefix = private_prefix()
    with _alone(prefix.parent):
        present = from_prefix(prefix)
        if present is not None and (present.client or not wish.has_client):
            return present
        return make_prefix(
            prefix,
            has_client=wish.has_client,
            mirror=wish.mirror,
            keyring=wish.keyring.expanduser().absolute(),
            report=report,
        )


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder / "lock", wait=False):
            yield
    except BlockingIOError:
        raise EngineUnavailableError(
            f"another process installs or removes Gazebo in '{folder}'; wait for it"
        ) from None
    except OSError as error:
        raise EngineUnavailableError(
            f"cannot write '{error.filename or folder}': {error.strerror}"
        ) from None
