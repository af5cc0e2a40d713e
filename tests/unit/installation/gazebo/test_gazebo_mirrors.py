from pathlib import Path

from tool0.installation.gazebo.mirrors import likeliest_first, mirrors_in_files

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
