from pathlib import Path

import pytest

from tool0.installation.gazebo.apt import Package, is_whole, listed
from tool0.installation.gazebo.apt_failures import explained

DIGEST = "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824"  # of hello
LISTING = f"""\
Reading package lists...
'http://near/debian/pool/a%2bb_1.deb' a+b_1%3a2_amd64.deb 12 SHA256:{DIGEST}
'http://near/debian/pool/c_1.deb' c_1_all.deb 34 MD5Sum:8ad775342ca4fd0adca5a516849b6498
"""


def test_reads_what_apt_would_download() -> None:
    assert listed(LISTING) == [
        Package("a+b_1%3a2_amd64.deb", 12, DIGEST),
        Package("c_1_all.deb", 34, ""),
    ]


@pytest.mark.parametrize(
    ("content", "expected"), [("hello", True), ("hullo", False), ("hell", False)]
)
def test_a_file_counts_if_all_of_it_is_right(
    tmp_path: Path, content: str, expected: bool
) -> None:
    file = tmp_path / "x.deb"
    assert not is_whole(file, Package("x.deb", 5, DIGEST))
    file.write_text(content)
    assert is_whole(file, Package("x.deb", 5, DIGEST)) == expected


@pytest.mark.parametrize(
    ("said", "meaning"),
    [
        ("Could not resolve 'near'", "cannot be reached"),
        ("connect (111: Connection refused)", "cannot be reached"),
        ("404  Not Found [IP: 10.0.0.1 80]", "no Debian 11"),
        ("The repository 'x' does not have a Release file.", "no Debian 11"),
        ("GPG error: x: NO_PUBKEY 0E98404D386FA1D9", "not signed by a key of"),
        ("Hash Sum mismatch", "not what Debian signed"),
        ("write error: No space left on device", "disk is full"),
        ("You don't have enough free space in /x", "disk is full"),
        ("something new", "apt-get failed"),
    ],
)
def test_says_what_a_failure_means(said: str, meaning: str) -> None:
    message = str(explained(f"E: {said}\n", "http://near/debian", Path("/keys.gpg")))
    assert meaning in message
    assert said in message
