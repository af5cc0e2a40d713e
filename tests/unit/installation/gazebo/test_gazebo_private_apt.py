from pathlib import Path

import pytest

from tool0.installation.gazebo.private_apt import (
    DebianPackage,
    download_failure,
    likeliest_first,
    listed_packages,
    mirrors_in_files,
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


@pytest.mark.parametrize(
    ("content", "expected"), [("hello", True), ("hullo", False), ("hell", False)]
)
def test_a_file_counts_if_all_of_it_is_right(
    tmp_path: Path, content: str, expected: bool
) -> None:
    file, package = tmp_path / "x.deb", DebianPackage("x.deb", 5, DIGEST)
    assert not package.is_complete_in(tmp_path)
    file.write_text(content)
    assert package.is_complete_in(tmp_path) == expected


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
def test_a_failure_is_explained_with_a_remedy(output: str, named: str) -> None:
    error = download_failure(f"E: {output}\n", "http://near/debian", Path("/keys.gpg"))
    assert named in str(error)
    assert output in str(error)


# --- mirrors ---

ONE_LINE = """\
# deb http://commented/debian bookworm main
deb [arch=amd64 signed-by=/usr/share/keyrings/x.gpg] http://one/debian bookworm main
deb-src http://source/debian bookworm main
 deb   http://two/debian/   bookworm-updates   contrib main
deb http://three/debian bookworm contrib
"""
DEB822 = """\
Types: deb deb-src
# a comment
URIs: http://four/debian
  http://five/debian
Suites: bookworm bookworm-updates
Components: main

Enabled: no
Types: deb
URIs: http://six/debian
Suites: bookworm
Components: main

Types: deb-src
URIs: http://seven/debian
Suites: bookworm
Components: main
"""


def test_reads_both_kinds_of_files(tmp_path: Path) -> None:
    parts = tmp_path / "sources.list.d"
    parts.mkdir()
    (tmp_path / "sources.list").write_text(ONE_LINE)
    (parts / "debian.sources").write_text(DEB822)
    (parts / "disabled.list.save").write_text("deb http://eight/debian x main")
    assert mirrors_in_files(tmp_path) == [
        "http://one/debian",
        "http://two/debian/",
        "http://four/debian",
        "http://five/debian",
    ]


def test_no_files_no_mirrors(tmp_path: Path) -> None:
    assert mirrors_in_files(tmp_path) == []


def test_debian_s_own_come_first_and_once() -> None:
    found = [
        ("https://other/packages", "Other"),
        ("cdrom:[Debian]/", "Debian"),
        ("http://near/linux/", "Debian"),
        ("http://near/debian/", "Debian"),
        ("http://near/debian", "Debian"),
        ("http://near/debian-security", "Debian"),
    ]
    assert likeliest_first(found) == [
        "http://near/debian",
        "http://near/linux",
        "https://other/packages",
    ]


def test_without_an_origin_the_name_tells() -> None:
    found = [("https://other/packages", ""), ("http://near/debian", "")]
    assert likeliest_first(found)[0] == "http://near/debian"
