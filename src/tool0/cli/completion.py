"""``tool0 completion``: a script that completes commands, options and choices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final, Literal

from tool0.cli import COMMANDS, form_and_readers
from tool0.cli.parameters import Option, Parameter, Readers, parameters_of

Table = dict[str, list[str]]
"""Start of a command line → the words that can follow; empty where file names can
follow.

A key is a command with its subcommand.  For the command's options, the key has the
suffix `` -``; for the values of an option, it has the option as a suffix.
"""


def completion(
    shell: Annotated[Literal["bash", "zsh"], Option(is_positional=True)],
) -> None:
    """Print a script that completes commands, options and choices in a shell.

    The script is static, so that completion does not start tool0.  Write the script
    again after an update of tool0.  For bash, write the script to
    ~/.local/share/bash-completion/completions/tool0.  For zsh, write it to a file named
    _tool0 in a folder of $fpath.

    Args:
        shell: The shell that will execute the script.
    """
    cases = "\n".join(
        f"    '{words}') echo '{' '.join(following)}' ;;"
        for words, following in table().items()
    )
    print(_SCRIPT[shell].replace("CANDIDATES", _CANDIDATES.replace("CASES", cases)))


def table() -> Table:
    """Return the words that can follow each command, from the commands' signatures."""
    found: Table = {"": [*COMMANDS, "--help", "--version"]}
    for command in COMMANDS:
        form, readers = form_and_readers(command)
        if isinstance(form, Mapping):
            found[command] = list(form)
            for name, function in form.items():
                found |= _following(f"{command} {name}", function, readers)
        else:
            found |= _following(command, form, readers)
    return found


def _following(words: str, form: Callable[..., Any], readers: Readers) -> Table:
    parameters = list(parameters_of(form, readers))
    arguments = [item for item in parameters if item.option.is_positional]
    options = [item for item in parameters if not item.option.is_positional]
    flags = [flag for item in options for flag in item.flags] + ["--help"]
    choices = [choice for item in arguments for choice in _choices(item)]
    valued = (item for item in options if item.reader is not None)
    return {
        words: choices if arguments else flags,
        f"{words} -": flags,
        **{f"{words} {item.flag}": _choices(item) for item in valued},
    }


def _choices(item: Parameter) -> list[str]:
    return [] if item.reader is None else list(item.reader.choices)


_CANDIDATES: Final = """\
_tool0_following() {
    case "$1" in
CASES
    *) return 1 ;;
    esac
}

# Print what the last of the words can be.
_tool0_candidates() {
    local command= option=
    while [ $# -gt 1 ]; do
        case "$1" in
        -*) option="$1" ;;
        *)
            option=
            if _tool0_following "${command:+$command }$1" > /dev/null; then
                command="${command:+$command }$1"
            elif [ -z "$command" ]; then
                return 1
            fi
            ;;
        esac
        shift
    done
    case "$1" in
    -*) _tool0_following "${command:+$command -}" ;;
    *) _tool0_following "$command $option" || _tool0_following "$command" ;;
    esac
}
"""
"""Shell functions that find the candidates, written in POSIX shell with ``local``."""

_BASH: Final = """\
# Completion of tool0 for bash, written by `tool0 completion bash`.

CANDIDATES
_tool0() {
    local candidates
    candidates="$(_tool0_candidates "${COMP_WORDS[@]:1:COMP_CWORD}")"
    COMPREPLY=($(compgen -W "$candidates" -- "${COMP_WORDS[COMP_CWORD]}"))
}

complete -o default -F _tool0 tool0"""

_ZSH: Final = """\
#compdef tool0
# Completion of tool0 for zsh, written by `tool0 completion zsh`.

CANDIDATES
_tool0() {
    local -a candidates
    candidates=($(_tool0_candidates "${(@)words[2,CURRENT]}"))
    if (( $#candidates )); then
        compadd -a candidates
    else
        _files
    fi
}

if [ "${funcstack[1]}" = _tool0 ]; then
    _tool0 "$@"
else
    compdef _tool0 tool0
fi"""

_SCRIPT: Final = {"bash": _BASH, "zsh": _ZSH}
