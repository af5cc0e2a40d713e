"""What several elements have in common: files, command lines, namespaces."""

from __future__ import annotations

import shlex
from xml.dom.minidom import Element

from tool0.lint.launch import grammar
from tool0.lint.launch.load_context import is_file
from tool0.lint.launch.model import Text
from tool0.lint.launch.scope import Scope


def require_file(text: Text, what: str, scope: Scope) -> None:
    """Report a file that is not there."""
    if text.resolved is None or is_file(text.resolved):
        return
    scope.report(
        text.location,
        "missing-file",
        text.resolved,
        f"does not exist, and {what} needs it",
        "correct the path; $(find PACKAGE)/… begins in a package, $(dirname)/… in the "
        "launch file's folder",
    )


def split(text: Text, scope: Scope) -> tuple[str, ...]:
    """Return the words of a command line."""
    if text.resolved is None:
        return ()
    try:
        return tuple(shlex.split(text.resolved))
    except ValueError as error:
        scope.report(
            text.location,
            "bad-command",
            text.resolved.strip()[:40],
            f"is no command line: {error}",
            "close the quotation marks",
        )
        return ()


def namespace_of(element: Element, scope: Scope) -> str | None:
    """Return the namespace that an element's ``ns`` opens, in that of the scope."""
    text = scope.text(element, "ns")
    clears = scope.boolean(element, "clear_params")
    is_node = element.tagName in ("node", "test")
    if clears and not is_node and not (text is not None and text.raw):
        scope.report(
            scope.locate(element),
            "bad-value",
            "clear_params",
            "needs ns beside it, to say which parameters go",
            'write ns="…"',
        )
    if text is None:
        return scope.namespace
    if text.resolved == "":
        scope.report(
            text.location,
            "bad-value",
            "ns",
            "is empty: roslaunch stops here",
            "remove it, or name a namespace",
        )
        return scope.namespace
    if text.resolved is None or scope.namespace is None:
        return None
    return grammar.as_namespace(grammar.join(scope.namespace, text.resolved))
