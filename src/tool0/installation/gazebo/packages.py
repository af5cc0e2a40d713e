"""Which packages of Debian 11 make a private Gazebo, and which parts of them."""

from __future__ import annotations

from typing import Final

RELEASE: Final = "bullseye"
"""Debian 11: the last one with Gazebo 11."""

TRIPLETS: Final = {"amd64": "x86_64-linux-gnu", "arm64": "aarch64-linux-gnu"}
"""Architecture as apt calls it → the folder of its libraries."""

PROGRAMS: Final = ("gazebo", "gazebo-plugin-base")
"""Taken with all that they depend on, but for what follows."""

FROM_HOST: Final = (
    # The host's own, newer ones must be used: what its g++ compiles needs them.
    "libc6",
    "libgcc-s1",
    "libgcc1",
    "libstdc++6",
    "libcrypt1",
    # Programs and scripts of the base system, which the simulator never calls.
    "coreutils",
    "debconf",
    "dpkg",
    "lsb-base",
    "mariadb-common",
    "mysql-common",
    "perl-base",
    "sensible-utils",
    "shared-mime-info",
    "tar",
    "ucf",
    "x11-common",
)
"""Taken for installed: apt then leaves them out, and what only they need."""

FOR_GUI: Final = (
    "libgl1-mesa-dri",
    "libgvc6",
    "libqt5core5a",
    "libqt5dbus5",
    "libqt5gui5",
    "libqt5network5",
    "libqt5opengl5",
    "libqt5svg5",
    "libqt5widgets5",
    "libqtpropertybrowser4",
    "libqwt-qt5-6",
    "libspnav0",
)
"""What gzclient loads and gzserver does not, and the driver that both draw with."""

HEADERS: Final = (
    "libboost1.74-dev",
    "libgazebo-dev",
    "libignition-common-dev",
    "libignition-math-dev",
    "libignition-msgs-dev",
    "libignition-transport-dev",
    "libprotobuf-dev",
    "libsdformat-dev",
    "libtbb-dev",
    "libtinyxml-dev",
    "libtinyxml2-dev",
    "uuid-dev",
)
"""Taken alone: a plugin is compiled with headers and linked with nothing."""

DROPPED: Final = (
    "./usr/share/bug",
    "./usr/share/doc",
    "./usr/share/icons",
    "./usr/share/lintian",
    "./usr/share/locale",
    "./usr/share/man",
    "./usr/lib/*.a",
)
"""Parts of packages that are not unpacked, as patterns for tar."""
