"""The packages of a private Gazebo: what apt prints of them, and unpacking."""

import shutil
from pathlib import Path

import pytest
from debian_mirror import build_package
from machine import add_program

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.debian import (
    DebianPackage,
    PrivateApt,
    listed_packages,
    machine_mirrors,
    unpack,
)

DIGEST = "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824"  # of hello
LISTING = f"""\
Reading package lists...
'http://near/debian/pool/a%2bb_1.deb' a+b_1%3a2_amd64.deb 12 SHA256:{DIGEST}
'http://near/debian/pool/c_1.deb' c_1_all.deb 34 MD5Sum:8ad775342ca4fd0adca5a516849b6498
"""


def test_reads_what_apt_would_download() -> None:
    assert listed_packages(LISTING) == [
        DebianPackage("a+b_1%3a2_amd64.deb", 12, DIGEST),
        DebianPackage("c_1_all.deb", 34, ""),
    ]


def test_a_file_is_damaged_if_its_size_alone_is_right(tmp_path: Path) -> None:
    file, package = tmp_path / "x.deb", DebianPackage("x.deb", 5, DIGEST)
    assert not package.is_damaged_in(tmp_path)
    for content, expected in (("hello", False), ("hullo", True), ("hell", False)):
        file.write_text(content)
        assert package.is_damaged_in(tmp_path) is expected


@pytest.mark.parametrize(
    ("output", "named"),
    [
        ("Could not resolve 'near'", "http_proxy"),
        ("connect (111: Connection refused)", "http_proxy"),
        ("404  Not Found [IP: 10.0.0.1 80]", "bullseye"),
        ("The repository 'x' does not have a Release file.", "bullseye"),
        ("GPG error: x: NO_PUBKEY 0E98404D386FA1D9", "/keys.gpg"),
        ("Hash Sum mismatch", "--mirror"),
        ("write error: No space left on device", "1 GB"),
        ("You don't have enough free space in /x", "1 GB"),
        ("something new", "apt-get"),
    ],
)
def test_a_failure_is_explained_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, output: str, named: str
) -> None:
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin")
    add_program(tmp_path / "apt-get", f'echo "E: {output}" >&2; exit 100')
    with pytest.raises(EngineUnavailableError) as error:
        PrivateApt(tmp_path, "http://near/debian", Path("/keys.gpg"), "amd64")
    assert named in str(error.value)
    assert output in str(error.value)


# --- mirrors ---

INDEXES = """\
'http://near/linux/dists/bookworm/InRelease' near_InRelease 0
'http://near/linux/dists/bookworm/main/binary-amd64/Packages.xz' near_Packages 0
'cdrom:[Debian]/dists/bookworm/main/binary-amd64/Packages.xz' cdrom_Packages 0
'http://near/debian-security/dists/b/updates/main/binary-amd64/Packages.xz' s_Packages 0
'https://other/packages/dists/stable/binary-amd64/Packages.xz' other_Packages 0
'http://near/debian/dists/bookworm/main/binary-amd64/Packages.xz' debian_Packages 0
'http://near/debian/dists/bookworm-updates/main/binary-all/Packages.xz' d_Packages 0
"""


def test_the_mirrors_are_those_of_the_machine_s_apt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin")
    add_program(tmp_path / "apt-get", f"cat <<'END'\n{INDEXES}END")
    assert machine_mirrors() == ["http://near/debian", "http://near/linux"]
    add_program(tmp_path / "apt-get", "exit 100")
    assert machine_mirrors() == []


# --- unpacking ---


needs_dpkg = pytest.mark.skipif(
    shutil.which("dpkg-deb") is None, reason="needs dpkg-deb"
)


@needs_dpkg
def test_unpacks_several_into_one_folder_without_what_is_dropped(
    tmp_path: Path,
) -> None:
    packages = [
        build_package(tmp_path, "one", {"usr/lib/x/liba.so": "", "usr/lib/x/a.a": ""}),
        build_package(tmp_path, "two", {"usr/share/doc/news": "", "usr/share/two": ""}),
    ]
    root = tmp_path / "root"
    root.mkdir()
    done: list[float] = []
    unpack(packages, root, lambda _, fraction: done.append(fraction))
    found = {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}
    assert found == {"usr/lib/x/liba.so", "usr/share/two"}
    assert done == sorted(done)
    assert done[-1] == 1.0


@needs_dpkg
def test_a_damaged_package_is_named_and_removed(tmp_path: Path) -> None:
    package = build_package(tmp_path, "one", {"usr/lib/x/liba.so": ""})
    package.write_bytes(package.read_bytes()[:-40])
    with pytest.raises(EngineUnavailableError) as error:
        unpack([package], tmp_path, lambda *_: None)
    assert package.name in str(error.value)
    assert not package.exists()


def test_links_lead_to_what_was_unpacked(tmp_path: Path) -> None:
    (tmp_path / "usr" / "share").mkdir(parents=True)
    (tmp_path / "etc").mkdir()
    (tmp_path / "usr" / "share" / "file").write_text("content")
    inside, outside = tmp_path / "etc" / "inside", tmp_path / "etc" / "outside"
    inside.symlink_to("/usr/share/file")
    outside.symlink_to("/dev/null")
    unpack([], tmp_path, lambda *_: None)
    assert inside.read_text() == "content"
    assert outside.readlink() == Path("/dev/null")
