"""What zsh itself makes of its completion: a shell at a terminal, and the Tab key."""

import shutil
import subprocess
from pathlib import Path

import pytest
from promised import absent

from tool0.cli import OK, main

pytestmark = pytest.mark.slow

SETUP = """\
PROMPT= RPROMPT=
unset zle_bracketed_paste
fpath=({folder} $fpath)
autoload -Uz compinit
compinit -u -D
compadd () {{
    local -a hits
    builtin compadd -O hits "$@"
    print -rl -- $hits >> {found}
    builtin compadd "$@"
}}
completed () {{ print COMPL""ETED; }}
comppostfuncs=(completed)
print REA""DY
"""
"""Of the shell: completions are noted."""
TYPE = """\
zmodload zsh/zpty
zpty inner zsh -f -i
zpty -w inner "source $1"
zpty -r inner text "*READY*"
zpty -n -w inner "$2"$'\\t'
zpty -r inner text "*COMPLETED*"
zpty -d inner
"""
"""A file of commands and a line: types the line and Tab, and waits for the end."""


@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("tool0 bri", ["bringup"]),
        ("/anywhere/bin/tool0 --v", ["--version"]),
        ("tool0 controllers s", ["start", "stop", "switch"]),
        ("tool0 describe --arm ur5 t", ["tree", "table"]),
        ("tool0 bringup --robot 'a b' --no-r", ["--no-realtime", "--no-remote"]),
        ("tool0 log --severity w", ["warning"]),
        ("tool0 log --severity warning --no", ["--no-requests"]),
        ("tool0 completion ", ["bash", "zsh"]),
        ("tool0 check r", ["robot.urdf"]),
        ("tool0 bringup --scene s", ["scene.yaml"]),
    ],
)
def test_zsh_completes(
    line: str,
    completed: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    zsh = shutil.which("zsh")
    if zsh is None:
        absent("zsh", "there is no zsh")
    folder, here, setup, found = (tmp_path / name for name in ("f", "h", "s", "out"))
    folder.mkdir()
    here.mkdir()
    for name in ("robot.urdf", "scene.yaml"):
        (here / name).touch()
    assert main(["completion", "zsh"]) == OK
    (folder / "_tool0").write_text(capsys.readouterr().out, encoding="utf-8")
    setup.write_text(SETUP.format(folder=folder, found=found), encoding="utf-8")
    subprocess.run(
        [zsh, "-f", "-c", TYPE, "zsh", setup, line],
        check=True,
        cwd=here,
        capture_output=True,
        timeout=30.0,
    )
    words = found.read_text(encoding="utf-8").split()
    assert list(dict.fromkeys(words)) == completed  # files come more than once
