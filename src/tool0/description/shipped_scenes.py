"""The scenes that come with tool0, by name."""

from __future__ import annotations

from pathlib import Path

from tool0.errors import ConfigError, did_you_mean

FOLDER = Path(__file__).resolve().parent.parent / "scenes"


def shipped_scenes() -> dict[str, Path]:
    """Return the file of each scene that comes along, by its name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.yaml"))}


def scene_path(given: Path | str) -> Path:
    """Return the file that is meant: a person's own, or that of a shipped scene.

    Args:
        given: A path, or a name without folder and suffix.  A file of that very name
            comes first.

    Raises:
        ConfigError: If it is only a name, and there is neither.
    """
    path = Path(given).expanduser()
    if path.suffix or path.name != str(given) or path.is_file():
        return path
    shipped = shipped_scenes()
    if path.name not in shipped:
        raise ConfigError(
            f"no scene '{path.name}'{did_you_mean(path.name, list(shipped))}; name a "
            f"YAML file, or one that comes along: {', '.join(shipped)}"
        )
    return shipped[path.name]
