"""Installing for real, from a tiny mirror: apt, gpg, dpkg-deb and tar all take part."""

import fcntl
from pathlib import Path

import pytest
from debian_mirror import CAN_BE_MADE, VERSION, Mirror, make_mirror
from machine import add_program

from tool0.errors import ConfigError, EngineUnavailableError
from tool0.installation.gazebo.install import (
    install_gazebo,
    uninstall_gazebo,
)
from tool0.installation.gazebo.installation import GazeboInstallation, private_prefix

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not CAN_BE_MADE, reason="needs apt-get, dpkg-deb and gpg"),
]


@pytest.fixture(scope="module")
def mirror(tmp_path_factory: pytest.TempPathFactory) -> Mirror:
    return make_mirror(tmp_path_factory.mktemp("debian"))


@pytest.fixture(autouse=True)
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in for g++: a plugin is not what is tested here."""
    script = 'for last; do :; done; echo made > "$last"'
    program = add_program(tmp_path / "fake-g++", script)
    monkeypatch.setenv("CXX", str(program))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("TOOL0_GAZEBO", raising=False)


def install(
    mirror: Mirror, *, gui: bool = False
) -> tuple[GazeboInstallation, list[str]]:
    said: list[str] = []
    made = install_gazebo(
        lambda activity, _: said.append(activity),
        has_client=gui,
        is_private=True,
        mirror=mirror.address,
        keyring=mirror.keyring,
    )
    return made, list(dict.fromkeys(said))


def refusal(mirror: Mirror) -> str:
    """Return why it cannot be installed."""
    with pytest.raises(EngineUnavailableError) as error:
        install(mirror)
    return str(error.value)


def test_makes_a_prefix_that_runs_and_removes_it(
    mirror: Mirror, tmp_path: Path
) -> None:
    made, said = install(mirror)
    prefix = private_prefix()
    assert (made.version, made.prefix, made.client) == (VERSION, prefix, None)
    assert made.server == prefix / "usr" / "bin" / f"gzserver-{VERSION}"
    assert made.server.is_file()
    assert {path.name for path in prefix.parent.iterdir()} == {"prefix", "lock"}
    assert not (prefix / "usr" / "share" / "doc").exists()
    assert (prefix / "usr" / "share" / "libtbb-dev").is_dir()
    assert said[0] == "reading the list of packages"
    assert said[-1] == "compiling the bridge to Gazebo"
    assert any((tmp_path / "cache").rglob("*.so"))
    assert uninstall_gazebo() > 0
    assert not prefix.parent.exists()
    assert not any((tmp_path / "cache").rglob("*.so"))
    assert uninstall_gazebo() == 0


def test_what_only_the_window_needs_is_taken_on_demand(mirror: Mirror) -> None:
    qt = private_prefix() / "usr" / "share" / "libqt5core5a"
    install(mirror)
    assert not qt.exists()
    made, _ = install(mirror, gui=True)
    assert qt.exists()
    assert made.client is not None
    _, said = install(mirror)  # the larger one will do
    assert said == ["compiling the bridge to Gazebo"]


def test_what_was_downloaded_is_used_unless_it_is_damaged(mirror: Mirror) -> None:
    debs = private_prefix().with_name("work") / "debs"
    debs.mkdir(parents=True)
    names = ("libtbb-dev", "libboost1.74-dev", "gazebo")
    whole, cut, wrong = (debs / f"{name}_1%3a11.1.0-6_all.deb" for name in names)
    whole.write_bytes(mirror.package(names[0]).read_bytes())
    cut.write_bytes(mirror.package(names[1]).read_bytes()[:100])
    content = bytearray(mirror.package(names[2]).read_bytes())
    content[-10] ^= 1
    wrong.write_bytes(content)
    install(mirror)
    share = private_prefix() / "usr" / "share"
    assert all((share / name).is_dir() for name in names[:2])


def test_an_unsigned_mirror_is_refused(tmp_path: Path) -> None:
    unsigned = make_mirror(tmp_path, signed=False)
    assert str(unsigned.keyring) in refusal(unsigned)
    assert not private_prefix().exists()


def test_a_package_of_other_content_is_refused(mirror: Mirror, tmp_path: Path) -> None:
    forged = make_mirror(tmp_path)
    package = forged.package("gazebo")
    content = bytearray(package.read_bytes())
    content[-10] ^= 1
    package.write_bytes(content)
    assert forged.address in refusal(forged)
    assert not private_prefix().exists()
    made, _ = install(mirror)  # and what is right goes on from there
    assert made.server.is_file()


def test_what_is_missing_is_named_before_anything_is_fetched(
    mirror: Mirror, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong, keys = tmp_path / "empty", tmp_path / "none.gpg"
    wrong.mkdir()
    assert "--mirror" in refusal(Mirror(wrong, mirror.keyring))
    assert str(keys) in refusal(Mirror(mirror.folder, keys))
    uninstall_gazebo()
    monkeypatch.setenv("CXX", "no-such-compiler")
    assert "apt install g++" in refusal(mirror)
    assert not private_prefix().parent.exists()


def test_two_at_once_do_not_disturb_each_other(mirror: Mirror) -> None:
    folder = private_prefix().parent
    folder.mkdir(parents=True)
    with (folder / "lock").open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        assert str(folder) in refusal(mirror)
        with pytest.raises(EngineUnavailableError):
            uninstall_gazebo()


@pytest.mark.parametrize("mirror", ["debian.org", "http://a b", ""])
def test_a_mirror_must_be_an_address(mirror: str) -> None:
    with pytest.raises(ConfigError):
        install_gazebo(lambda *_: None, mirror=mirror)
