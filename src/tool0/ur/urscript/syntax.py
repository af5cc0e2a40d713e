"""The syntax tree of a URScript program.

Chains of operators are stored in one node, so a long sum does not become a deep tree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

from tool0.ur.urscript_errors import Place

Constant: TypeAlias = bool | int | float | str

INT_RANGE: Final = range(-(2**31), 2**31)
"""Range of URScript's 32-bit integers."""
MAX_TEXT: Final = 1023
"""Maximum length of a string [bytes], which is the same as on a real robot."""


@final
@dataclass(frozen=True, slots=True)
class Literals:
    """A number, a string, True or False."""

    at: Place
    value: Constant


@final
@dataclass(frozen=True, slots=True)
class Name:
    """A variable."""

    at: Place
    name: str


@final
@dataclass(frozen=True, slots=True)
class ListOf:
    """``[a, b, …]``."""

    at: Place
    items: tuple[Expression, ...]


@final
@dataclass(frozen=True, slots=True)
class PoseOf:
    """``p[x, y, z, rx, ry, rz]``."""

    at: Place
    items: tuple[Expression, ...]


@final
@dataclass(frozen=True, slots=True)
class StructOf:
    """``struct(name = value, …)``."""

    at: Place
    names: tuple[str, ...]
    values: tuple[Expression, ...]


@final
@dataclass(frozen=True, slots=True)
class MemberName:
    """The name of a struct's member, used as an index."""

    at: Place
    name: str


@final
@dataclass(frozen=True, slots=True)
class Index:
    """``base[i][j]``, ``base[i, j]`` or ``base.member``."""

    at: Place
    base: Expression
    indexes: tuple[Expression, ...]


@final
@dataclass(frozen=True, slots=True)
class Method:
    """``base.name(arguments)``."""

    at: Place
    base: Expression
    name: str
    arguments: tuple[Expression, ...]


@final
@dataclass(frozen=True, slots=True)
class Unary:
    """``-a``, ``+a`` or ``not a``."""

    at: Place
    operator: str
    operand: Expression


@final
@dataclass(frozen=True, slots=True)
class Operand:
    """An additional operand of a chain, with the operator before it."""

    at: Place
    """Location of the operator."""
    operator: str
    value: Expression


@final
@dataclass(frozen=True, slots=True)
class Chain:
    """``first op a op b …`` with operators of equal precedence, from left to right."""

    at: Place
    first: Expression
    rest: tuple[Operand, ...]


@final
@dataclass(frozen=True, slots=True)
class Argument:
    """``value`` or ``name = value``."""

    at: Place
    name: str | None
    value: Expression


@final
@dataclass(frozen=True, slots=True)
class Call:
    """``name(arguments)``."""

    at: Place
    name: str
    arguments: tuple[Argument, ...]


@final
@dataclass(frozen=True, slots=True)
class Run:
    """``run name()``, which starts a thread and returns its handle."""

    at: Place
    name: str


@final
@dataclass(frozen=True, slots=True)
class Join:
    """``join handle``, which waits for a thread and returns its result."""

    at: Place
    handle: Expression


Expression: TypeAlias = (
    Literals
    | Name
    | ListOf
    | PoseOf
    | StructOf
    | MemberName
    | Index
    | Method
    | Unary
    | Chain
    | Call
    | Run
    | Join
)


@final
@dataclass(frozen=True, slots=True)
class Assign:
    """``[local | global] name[i].member = value``."""

    at: Place
    scope: Literal["local", "global"] | None
    name: str
    indexes: tuple[Expression, ...]
    value: Expression


@final
@dataclass(frozen=True, slots=True)
class Evaluate:
    """An expression as a statement."""

    at: Place
    value: Expression


@final
@dataclass(frozen=True, slots=True)
class If:
    """``if … elif … else … end``."""

    at: Place
    branches: tuple[tuple[Expression, Block], ...]
    otherwise: Block


@final
@dataclass(frozen=True, slots=True)
class While:
    """``while … end``."""

    at: Place
    condition: Expression
    body: Block


@final
@dataclass(frozen=True, slots=True)
class Return:
    """``return [value]``."""

    at: Place
    value: Expression | None


@final
@dataclass(frozen=True, slots=True)
class Kill:
    """``kill handle``."""

    at: Place
    handle: Expression


Keyword: TypeAlias = Literal[
    "break", "continue", "halt", "pause", "pass", "enter_critical", "exit_critical"
]


@final
@dataclass(frozen=True, slots=True)
class Simple:
    """A statement that consists of one word."""

    at: Place
    keyword: Keyword


@final
@dataclass(frozen=True, slots=True)
class Parameter:
    """``name`` or ``name = default``."""

    at: Place
    name: str
    default: Expression | None


@final
@dataclass(frozen=True, slots=True)
class Definition:
    """``def``, ``sec`` or ``thread``."""

    at: Place
    kind: Literal["def", "sec", "thread"]
    name: str
    parameters: tuple[Parameter, ...]
    body: Block


Statement: TypeAlias = (
    Assign | Evaluate | If | While | Return | Kill | Simple | Definition
)
Block: TypeAlias = tuple[Statement, ...]
