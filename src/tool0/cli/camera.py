"""``tool0 camera``: a picture from a running bringup, into a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from tool0.cli.connection import Bringup
from tool0.cli.parsing import parse
from tool0.cli.text import columns
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tool0.api.sensors import CameraHandle
    from tool0.sensing.cameras import CameraImage

_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    parse(camera, command, arguments)
    return 0


def camera(
    name: Annotated[str | None, tyro.conf.Positional] = None,
    *,
    out: Path | None = None,
    depth: Path | None = None,
    as_list: Annotated[bool, tyro.conf.arg(name="list")] = False,
    bringup: Bringup = _DEFAULT,
) -> None:
    """Take a picture, or list the cameras.

    Args:
        name: The camera, such as wrist or scene.
        out: Write the colours into this file, a PNG.
        depth: Write the depth into this file: millimetres as a PNG of 16 bits with 0
            for nothing there, or metres as a .npy of numpy's with infinity for that.
        as_list: List the cameras.
        bringup: Which bringup.
    """
    if as_list == (name is not None):
        raise ConfigError("name a camera, or list them with --list")
    if name is not None and out is None and depth is None:
        raise ConfigError(
            "say where the picture is to go: --out FILE.png, --depth FILE"
        )
    for path, suffixes in ((out, (".png",)), (depth, (".png", ".npy"))):
        if path is not None and path.suffix.lower() not in suffixes:
            raise ConfigError(f"{path}: the name must end in {' or '.join(suffixes)}")
    with bringup.connect() as robot:
        if name is None:
            print(_table(robot.cameras), end="")
            return
        image = robot.camera(name).image()
    _write(image, out, depth)


def _table(cameras: Mapping[str, CameraHandle]) -> str:
    rows = [("camera", "link", "pixels", "field of view", "sees")]
    rows += [
        (
            name,
            item.link or "(none)",
            f"{item.width} x {item.height}",
            f"{math.degrees(item.field_of_view):.0f}°",
            f"{item.near:g} … {item.far:g} m",
        )
        for name, item in ((name, view.camera) for name, view in cameras.items())
    ]
    return columns(rows)


def _write(image: CameraImage, out: Path | None, depth: Path | None) -> None:
    import numpy as np

    from tool0.sensing.cameras import encode_depth, encode_png

    try:
        if out is not None:
            out.write_bytes(encode_png(image.rgb))
        if depth is not None and depth.suffix.lower() == ".npy":
            with depth.open("wb") as file:
                np.save(file, image.depth)
        elif depth is not None:
            depth.write_bytes(encode_depth(image.depth))
    except OSError as error:
        raise ConfigError(f"cannot write {error.filename}: {error.strerror}") from None
    height, width = image.depth.shape
    written = ", ".join(str(path) for path in (out, depth) if path is not None)
    print(f"{written}: {width} x {height}, at t = {image.time:.3f} s")
