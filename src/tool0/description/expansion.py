"""Expansion of xacro without ROS, including ``$(find)`` and errors with locations.

The expander is PyPI's ``xacro``.  Outside ROS, this package tries to import ament for
``$(find)``, cannot resolve ``$(dirname)``, writes warnings to stderr, and reads YAML
with the slow pure-Python loader.  While a document is expanded, ``_substituted``
replaces the corresponding functions of xacro. xacro keeps its state in module globals.
Therefore one lock protects every expansion, and all replaced globals are restored
afterwards.
"""

from __future__ import annotations

import functools
import logging
import os
import re
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any, NamedTuple, final
from xml.dom.minidom import Document, Node

from tool0.description.finding import quoted
from tool0.description.packages import find_package, source_path
from tool0.description.xml_source import children, locate, parse_file
from tool0.description.yaml_tree import YamlEntry, read_verbatim
from tool0.errors import ConfigError, DescriptionError, SourceLocation, did_you_mean

logger = logging.getLogger(__name__)

_LOCK = threading.RLock()
_ARGUMENT = re.compile(r"\$\(arg\s+(\w+)\s*\)")
_EXPRESSION = re.compile(r"\$\{([^}]*)\}")


class Expanded(NamedTuple):
    """An expanded xacro file."""

    document: Document
    known: set[str]
    """The arguments that the files declare or read."""
    arguments: Mapping[str, str]
    """Values of the arguments by name: the given value, or the declared default."""


def expand(path: Path, args: Mapping[str, str] | None = None) -> Expanded:
    """Return the xacro file ``path``, expanded with ``args``.

    Attributes of ``<robot>`` may use arguments that have a default; without this
    function, xacro would require a value for these arguments.

    Raises:
        DescriptionError: If the expansion fails, or if no file declares one of the
            arguments.  The error states the file, the line, the macro and the
            includes.
    """
    expanded = _expanded(path, args, _defaults_of_root)
    for name in args or {}:
        if name not in expanded.known:
            hint = did_you_mean(name, expanded.known)
            raise DescriptionError(
                f"no file declares the argument '{name}'{hint}", SourceLocation(path)
            )
    return expanded


def expand_leniently(path: Path, args: Mapping[str, str] | None = None) -> Expanded:
    """Return the xacro file ``path``, expanded with ``args``.

    Arguments that no file declares are ignored, as they are by xacro.

    Raises:
        DescriptionError: If the expansion fails.  The error states the file, the line,
            the macro and the includes.
    """
    return _expanded(path, args, lambda _: {})


def _expanded(
    path: Path,
    args: Mapping[str, str] | None,
    defaults: Callable[[Document], dict[str, str]],
) -> Expanded:
    xacro = _imported()
    start = str(source_path(path.absolute()))
    if not os.path.isfile(start):  # noqa: PTH113  # Path's may raise
        raise DescriptionError(f"there is no file '{path}'; check the path")
    with _LOCK:
        run = _Expansion(xacro)
        with _substituted(xacro, run):
            xacro.init_stacks(start)
            try:
                document = run.parse(None, start)
                given = {**defaults(document), **(args or {})}
                xacro.process_doc(document, mappings=given, verbosity=0)
            except Exception as error:  # any exception of Python code in the file
                raise _describe(xacro, error) from error
    return Expanded(document, run.known, given)  # xacro has added the defaults


def _defaults_of_root(document: Document) -> dict[str, str]:
    """Return the arguments that have a default and are used in ``<robot>`` attributes.

    The elements that declare these arguments are inside ``<robot>``. xacro reads them
    after it has evaluated the attributes of ``<robot>``.
    """
    root = document.documentElement
    if root is None:
        return {}
    used = {
        name
        for _, value in root.attributes.items()
        for name in _ARGUMENT.findall(value)
    }
    return {
        name: arg.getAttribute("default")
        for arg in children(root, "xacro:arg")
        if (name := arg.getAttribute("name")) in used and arg.hasAttribute("default")
    }


@functools.cache
def _imported() -> ModuleType:
    """Return PyPI's xacro, without Python 3.10's warnings about xacro's private names.

    If a ROS installation is sourced, the xacro of that installation, whatever its
    version, comes first in PYTHONPATH.
    """
    before = list(sys.path)
    of_ros = set(os.environ.get("PYTHONPATH", "").split(os.pathsep))
    sys.path.sort(key=of_ros.__contains__)  # stable sort: ROS's folders are last
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            import xacro
    finally:
        sys.path[:] = before
    return xacro  # type: ignore[no-any-return]  # xacro has no type hints


@final
class _Expansion:
    """Replacements for xacro's functions during one expansion."""

    def __init__(self, xacro: ModuleType) -> None:
        self._xacro = xacro
        self.known: set[str] = set()
        """The arguments that the files declare or read."""

    def parse(self, inp: None, filename: str) -> Document:
        """Replace ``xacro.parse`` such that elements have source locations."""
        path = source_path(Path(filename))
        if not path.is_file():
            self._xacro.filestack.pop()  # as xacro does if a file cannot be read
            problem = self._why_no_file(path, is_empty=filename.endswith(os.sep))
            raise self._xacro.XacroException(exc=FileNotFoundError(problem))
        document = parse_file(path)
        for element in document.getElementsByTagName("xacro:arg"):
            self.known.add(element.getAttribute("name"))
        return document

    def substitute(self, text: str) -> str:
        """Replace ``xacro.eval_extension``, the evaluation of ``$(command …)``."""
        match text[2:-1].split():
            case "find", package:
                return str(find_package(package))
            case "arg", name:
                return self._arg(name)
            case "env", name if name in os.environ:
                return os.environ[name]
            case "env", name:
                raise DescriptionError(
                    f"the environment variable '{name}' is not set; "
                    f"set it, or write $(optenv {name} DEFAULT)"
                )
            case ("find" | "arg" | "env") as command, *_:
                raise DescriptionError(f"{text}: '{command}' takes one name")
            case "dirname", *_:
                return str(Path(self._xacro.filestack[-1]).parent)
            case "cwd", *_:
                return str(Path.cwd())
            case "optenv", name, *default:
                return os.environ.get(name, " ".join(default))
            case "eval", *_:
                return self._evaluate(text)
        raise DescriptionError(
            f"{text} is unknown; valid: $(find PACKAGE), $(dirname), $(arg NAME), "
            "$(env NAME), $(optenv NAME DEFAULT), $(eval EXPRESSION), $(cwd)"
        )

    def _arg(self, name: str) -> str:
        self.known.add(name)
        args: dict[str, str] = self._xacro.substitution_args_context["arg"]
        if name in args:
            return args[name]
        hint = did_you_mean(name, set(args))
        raise DescriptionError(
            f"the argument '{name}' has neither value nor default{hint}"
        )

    def _evaluate(self, text: str) -> str:
        from xacro.substitution_args import resolve_args

        context = dict(self._xacro.substitution_args_context)
        self.known.update(name for name in context["arg"] if name in text)
        return str(resolve_args(text, context=context))

    def _why_no_file(self, path: Path, *, is_empty: bool) -> str:
        """Return the reason why a path is not a file, such as an empty argument."""
        if is_empty:
            args: dict[str, str] = self._xacro.substitution_args_context["arg"]
            empty = sorted(name for name, value in args.items() if not value.strip())
            problem = "the name of the file is empty"
            if not empty:
                return problem
            are = "are the arguments" if empty[1:] else "is the argument"
            fix = f"give a file, such as {empty[0]}:=FILE"
            return f"{problem}, and so {are} {quoted(empty)}; {fix}"
        if path.is_dir():
            return f"'{path}' is a folder; give a file in it"
        return f"there is no file '{path}'"

    def load_yaml(self, filename: str) -> Any:  # whatever YAML holds
        """Replace ``xacro.load_yaml``; the C loader is used if it is available."""
        path = source_path(Path(self._xacro.abs_filename_spec(str(filename))))
        if not path.is_file():
            problem = self._why_no_file(path, is_empty=not str(filename).strip())
            raise DescriptionError(f"cannot read the parameters: {problem}")
        return _wrapped(read_parameters(path))


def read_parameters(path: Path) -> YamlEntry:
    """Return a YAML file's content as read by xacro, with units such as ``!degrees``.

    Raises:
        DescriptionError: If the file cannot be read, or is empty.
    """
    units = {
        unit.value.tag: functools.partial(_construct, unit)
        for unit in _imported().ConstructUnits
    }
    try:
        root = read_verbatim(path, units).root
    except ConfigError as error:
        raise DescriptionError(error.message, error.location) from None
    if root.is_null:
        raise DescriptionError("holds no parameters", root.location)
    return root


def _construct(unit: Any, loader: Any, node: Any) -> Any:  # xacro's and PyYAML's
    """Return a number with a unit in SI; raise ValueError if the number is invalid."""
    try:
        return unit.constructor(loader, node)
    except Exception as error:  # xacro evaluates the number as Python code
        raise ValueError(str(error)) from None


@final
class Parameters(dict[str, Any]):
    """A YAML mapping with keys that are also attributes: ``limits.elbow.upper``.

    Access to a missing key raises AttributeError with file, line and the most similar
    key.
    """

    _place = ""  # a class attribute, so that no instance attribute hides a YAML key

    def __getattr__(self, key: str) -> Any:
        try:
            return dict.__getitem__(self, str(key))
        except KeyError:
            hint = did_you_mean(str(key), self)
            raise AttributeError(f"{self._place} has no key '{key}'{hint}") from None

    __getitem__ = __getattr__


def _wrapped(entry: YamlEntry) -> Any:
    """Return a YAML value with its mappings converted to ``Parameters``."""
    if entry.is_list:
        return [_wrapped(item) for item in entry.items]
    if not entry.is_mapping:
        return entry.scalar
    wrapped = Parameters({key: _wrapped(c) for key, c in entry.children.items()})
    name = entry.key.replace("/", ".")
    wrapped._place = f"'{name}' in {entry.location}" if name else str(entry.location)
    return wrapped


@contextmanager
def _substituted(xacro: ModuleType, run: _Expansion) -> Iterator[None]:
    """Replace xacro's ROS-dependent parts with ``run`` while the context is active."""
    replacements = {
        "eval_extension": run.substitute,
        "parse": run.parse,
        "load_yaml": run.load_yaml,
        "safe_eval": _safe_eval(xacro),
        "eval_text": _eval_text(xacro),
        "warning": _log("warning", logger.warning),
        "error": _log("error", logger.error),
        "message": _log("message", logger.info),
        "print_location": lambda: None,
    }
    state = ("filestack", "macrostack", "all_includes", "verbosity", "_global_symbols")
    saved = {name: getattr(xacro, name) for name in (*replacements, *state)}
    context = dict(xacro.substitution_args_context)
    try:
        for name, function in replacements.items():
            setattr(xacro, name, function)
        xacro.all_includes = []  # type: ignore[attr-defined]
        xacro._global_symbols = xacro.create_global_symbols()  # type: ignore[attr-defined]
        yield
    finally:
        for name, value in saved.items():
            setattr(xacro, name, value)
        xacro.substitution_args_context.clear()
        xacro.substitution_args_context.update(context)


def _log(name: str, write: Callable[..., None]) -> Callable[..., None]:
    def report(*args: object, **_: object) -> None:
        write("xacro: %s", " ".join(map(str, args)))

    report.__name__ = name  # name by which expressions in xacro call the function
    return report


@functools.lru_cache(maxsize=4096)
def _compile(expression: str) -> Any:  # a code object
    return compile(expression, "<expression>", "eval")


def _safe_eval(xacro: ModuleType) -> Callable[..., Any]:
    """Return ``xacro.safe_eval`` with cached compilation.

    For example, ``${prefix}`` is evaluated about a hundred times per robot.
    """

    def safe_eval(
        expression: str, symbols: dict[str, Any], local: Any = None
    ) -> object:
        code = _compile(expression.strip())
        hidden = [name for name in code.co_names if name.startswith("__")]
        if hidden:
            raise xacro.XacroException(f"names such as {hidden[0]} are not allowed")
        symbols.update(__builtins__={})  # hides Python's builtins, as xacro does
        return eval(code, symbols, local)

    return safe_eval


def _eval_text(xacro: ModuleType) -> Callable[[str, Any], Any]:
    """Return ``xacro.eval_text`` with a fast path around its lexer.

    Text without ``$``, or with only plain ``${…}``, is evaluated here.  Any other text
    is evaluated by xacro.
    """
    original: Callable[[str, Any], Any] = xacro.eval_text
    compiled = _safe_eval(xacro)

    def evaluate(expression: str, symbols: Any) -> Any:
        try:
            return compiled(expression, symbols)
        except Exception as error:  # any exception of Python code in the file
            suffix = f"when evaluating expression '{expression}'"
            raise xacro.XacroException(exc=error, suffix=suffix) from error

    def eval_text(text: str, symbols: Any) -> Any:
        if text and "$" not in text:
            return text
        # literals have even indices, expressions have odd indices
        parts = _EXPRESSION.split(text)
        if len(parts) < 3 or any("$" in part for part in parts):
            return original(text, symbols)
        parts[1::2] = [evaluate(part, symbols) for part in parts[1::2]]
        if len(parts) == 3 and not parts[0] and not parts[2]:
            return parts[1]  # a single expression keeps its type
        return "".join(map(str, parts))

    return eval_text


def _describe(xacro: ModuleType, error: Exception) -> DescriptionError:
    """Return ``error`` as a DescriptionError with location, macros and includes."""
    cause: object = error
    while isinstance(cause, xacro.XacroException) and cause.exc is not None:
        cause = cause.exc
    location = _failing_line(xacro, error.__traceback__)
    if isinstance(cause, DescriptionError):
        message, location = cause.message, cause.location or location
    elif isinstance(cause, RecursionError):
        message = "a macro or property calls itself endlessly"
    else:
        message = " ".join(str(error).split()) or repr(error)
        message = message.replace(" (<expression>, line 1)", "")
    if location is None:
        location = SourceLocation(Path(xacro.filestack[-1]))
    return DescriptionError(message + _stacks(xacro), location)


def _failing_line(
    xacro: ModuleType, traceback: TracebackType | None
) -> SourceLocation | None:
    """Return the location of the innermost element that xacro was processing."""
    found = None
    while traceback is not None:
        frame = traceback.tb_frame
        if frame.f_globals is vars(xacro):
            for name in ("node", "elt"):
                node = frame.f_locals.get(name)
                if isinstance(node, Node):
                    found = locate(node) or found
        traceback = traceback.tb_next
    return found


def _stacks(xacro: ModuleType) -> str:
    lines = [
        f"\n  in macro '{macro.body.getAttribute('name')}', {locate(macro.body)}"
        for macro in reversed(xacro.macrostack[-5:])
    ]
    lines += [f"\n  included from {file}" for file in reversed(xacro.filestack[:-1])]
    return "".join(lines)
