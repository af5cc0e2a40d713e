"""The mirrors that the machine's own apt configuration names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from tool0.installation.gazebo.host_tools import run_host

_LINE = re.compile(r"^\s*deb\s+(?:\[[^\]]*\]\s*)?(\S+)\s+\S+\s+(.*)$", re.MULTILINE)
_SCHEMES = ("http:", "https:", "file:", "ftp:", "mirror")


def machine_mirrors() -> list[str]:
    """Return those that may hold Debian, the most likely first; perhaps none."""
    answer = run_host(
        [
            "apt-get",
            "indextargets",
            "--format",
            "$(REPO_URI)|$(ORIGIN)|$(COMPONENT)",
            "Created-By: Packages",
        ]
    )
    rows = [line.split("|") for line in answer.stdout.splitlines()]
    found = [(uri, origin) for uri, origin, part in rows if part == "main"]
    if not found:  # apt could not say: its lists or its files are not as it wants
        found = [(uri, "") for uri in mirrors_in_files(Path("/etc/apt"))]
    return likeliest_first(found)


def likeliest_first(found: list[tuple[str, str]]) -> list[str]:
    """Return the addresses once each: Debian's own first, no security archive.

    Args:
        found: Addresses, each with the origin that its index states, if it is known.
    """

    def rank(item: tuple[str, str]) -> tuple[bool, bool]:
        uri, origin = item
        return origin != "Debian", not uri.rstrip("/").endswith("/debian")

    usable = [
        (uri.rstrip("/"), origin)
        for uri, origin in found
        if uri.startswith(_SCHEMES) and "security" not in uri
    ]
    return list(dict.fromkeys(uri for uri, _ in sorted(usable, key=rank)))


def mirrors_in_files(folder: Path) -> list[str]:
    """Return the addresses in apt's own files, of sources that have a part ``main``."""
    parts = folder / "sources.list.d"
    found: list[str] = []
    for file in (folder / "sources.list", *sorted(parts.glob("*.list"))):
        found += [
            uri for uri, words in _LINE.findall(_text(file)) if "main" in words.split()
        ]
    for file in sorted(parts.glob("*.sources")):
        for fields in _stanzas(_text(file)):
            on = fields.get("enabled", "yes") not in ("no", "false", "0")
            types, main = fields.get("types", "").split(), fields.get("components", "")
            if on and "deb" in types and "main" in main.split():
                found += fields.get("uris", "").split()
    return list(dict.fromkeys(found))


def _stanzas(text: str) -> Iterator[dict[str, str]]:
    """Yield the fields of each paragraph of a deb822 file, names in small letters."""
    fields: dict[str, str] = {}
    name = ""
    for line in [*text.splitlines(), ""]:
        if line.startswith("#"):
            continue
        if not line.strip():
            if fields:
                yield fields
            fields, name = {}, ""
        elif line[0].isspace():
            if name:
                fields[name] += f" {line.strip()}"
        else:
            key, _, value = line.partition(":")
            name = key.strip().lower()
            fields[name] = value.strip()


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
