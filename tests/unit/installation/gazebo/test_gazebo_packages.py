import shutil
import subprocess
from pathlib import Path

import pytest

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.packages import (
    make_links_relative,
    size_on_disk,
    unpack,
)

needs_dpkg = pytest.mark.skipif(
    shutil.which("dpkg-deb") is None, reason="needs dpkg-deb"
)


def build(folder: Path, name: str, *files: str) -> Path:
    root = folder / name
    (root / "DEBIAN").mkdir(parents=True)
    (root / "DEBIAN" / "control").write_text(
        f"Package: {name}\nVersion: 1\nArchitecture: all\n"
        "Maintainer: nobody <nobody@localhost>\nDescription: x\n"
    )
    for file in files:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).write_text(name)
    package = folder / f"{name}.deb"
    command = ["dpkg-deb", "--build", str(root), str(package)]
    subprocess.run(command, check=True, capture_output=True)
    return package


@needs_dpkg
def test_unpacks_several_into_one_folder_without_what_is_dropped(
    tmp_path: Path,
) -> None:
    packages = [
        build(tmp_path, "one", "usr/lib/x/liba.so", "usr/lib/x/liba.a"),
        build(tmp_path, "two", "usr/share/doc/two/news", "usr/share/two/data"),
    ]
    root = tmp_path / "root"
    root.mkdir()
    sizes: list[int] = []
    unpack(packages, root, sizes.append)
    found = {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}
    assert found == {"usr/lib/x/liba.so", "usr/share/two/data"}
    assert sum(sizes) == sum(package.stat().st_size for package in packages)


@needs_dpkg
def test_a_damaged_package_is_named_and_removed(tmp_path: Path) -> None:
    package = build(tmp_path, "one", "usr/lib/x/liba.so")
    package.write_bytes(package.read_bytes()[:-40])
    with pytest.raises(EngineUnavailableError) as error:
        unpack([package], tmp_path, lambda _: None)
    assert "one.deb" in str(error.value)
    assert not package.exists()


def test_links_lead_to_what_was_unpacked(tmp_path: Path) -> None:
    (tmp_path / "usr" / "share").mkdir(parents=True)
    (tmp_path / "etc").mkdir()
    (tmp_path / "usr" / "share" / "file").write_text("content")
    inside, outside = tmp_path / "etc" / "inside", tmp_path / "etc" / "outside"
    inside.symlink_to("/usr/share/file")
    outside.symlink_to("/dev/null")
    make_links_relative(tmp_path)
    assert inside.read_text() == "content"
    assert outside.readlink() == Path("/dev/null")


def test_a_file_of_two_names_is_counted_once(tmp_path: Path) -> None:
    (tmp_path / "one").write_bytes(b"x" * 100_000)
    once = size_on_disk(tmp_path)
    (tmp_path / "two").hardlink_to(tmp_path / "one")
    assert size_on_disk(tmp_path) == once >= 100_000
