"""Descriptions of the library's functions: names, parameters and implementations."""

from __future__ import annotations

import inspect
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, final, get_type_hints

from tool0.ur.urscript.kinds import Kind
from tool0.ur.urscript.values import Value, to_text

NO_DEFAULT: Final = object()
_THREAD: Final = "thread"
_SITE: Final = "site"

# Any: the arguments have the types to which the kinds convert the values.
Implementation: TypeAlias = Callable[..., Value] | Callable[..., Awaitable[Value]]


@final
@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a library function."""

    name: str
    kind: Kind
    # Any: the default value of the implementation's parameter.
    default: Any

    @property
    def is_required(self) -> bool:
        """Whether the parameter has no default."""
        return self.default is NO_DEFAULT

    @property
    def text(self) -> str:
        """Text of the parameter in a signature; ``[name]`` if the default is None."""
        if self.is_required:
            return self.name
        if self.default is None:
            return f"[{self.name}]"
        if isinstance(self.default, str):
            return f'{self.name}="{self.default}"'
        return f"{self.name}={to_text(self.default)}"


@final
@dataclass(frozen=True, slots=True)
class Function:
    """A function of the library."""

    name: str
    parameters: tuple[Parameter, ...]
    call: Implementation
    is_async: bool
    takes_thread: bool
    """Whether the first argument is the calling thread."""
    takes_site: bool
    """Whether the first argument is the location of the call. Only coroutine functions
    can receive the location of the call."""
    is_physical: bool
    """Whether the function takes robot time; if it does, secondary programs must not
    call it."""
    cost: int = 0
    """Number of additional statements that are charged for a call. Each additional
    statement stands for 4 µs of processor time."""

    @property
    def signature(self) -> str:
        """Signature in the style of UR's manual, such as ``movej(q, a=1.4, …)``."""
        return f"{self.name}({', '.join(item.text for item in self.parameters)})"


def function(
    call: Implementation,
    name: str | None = None,
    *,
    physical: bool = False,
    cost: int = 0,
) -> Function:
    """Return a library function that is described by the annotations of ``call``."""
    hints = get_type_hints(call, include_extras=True)
    parameters = []
    takes_thread = takes_site = False
    for item in inspect.signature(call).parameters.values():
        if item.name in {_THREAD, _SITE}:
            takes_thread = item.name == _THREAD
            takes_site = not takes_thread
            continue
        is_required = item.default is inspect.Parameter.empty
        default = NO_DEFAULT if is_required else item.default
        kind = _kind_of(hints[item.name])
        parameters.append(Parameter(item.name.rstrip("_"), kind, default))
    return Function(
        name or call.__name__.strip("_"),
        tuple(parameters),
        call,
        inspect.iscoroutinefunction(call),
        takes_thread,
        takes_site,
        physical,
        cost,
    )


# Any: an annotation.
def _kind_of(hint: Any) -> Kind:
    for part in (hint, *getattr(hint, "__args__", ())):
        for extra in getattr(part, "__metadata__", ()):
            if isinstance(extra, Kind):
                return extra
    raise TypeError(f"{hint} has no kind")
