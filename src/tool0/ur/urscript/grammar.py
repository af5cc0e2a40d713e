"""The grammar of URScript for lark, and the parser that is generated from it.

Blocks end with ``end``; indentation has no meaning. A new line ends a statement, except
inside brackets. The operators, in order of increasing precedence, are ``or``, ``xor``,
``and``, ``not``, comparisons, ``+ -``, ``* / %``, signs and indexes (URScript manual
5.x, section "Numbers, Variables, and Types").
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from lark import Lark

GRAMMAR: Final = r"""
start: _statement*
_statement: _simple _NL | if_ _NL | while_ _NL | definition _NL
_simple: assign | evaluate | return_ | kill | keyword

assign: [SCOPE] expression EQUAL expression
evaluate: expression
return_: RETURN [expression]
kill: KILL expression
keyword: BREAK | CONTINUE | HALT | PAUSE | ENTER_CRITICAL | EXIT_CRITICAL

block: _statement*
if_: IF _condition block (_ELIF _condition block)* [_ELSE _COLON _NL block] _END
while_: WHILE _condition block _END
_condition: expression _COLON _NL
definition: DEFINE NAME _OPEN [parameters] _CLOSE _COLON _NL block _END
parameters: parameter ("," parameter)*
parameter: NAME [EQUAL expression]

?expression: exclusive (OR exclusive)*
?exclusive: conjunction (XOR conjunction)*
?conjunction: negation (AND negation)*
?negation: comparison | NOT negation -> not_
?comparison: sum (COMPARE sum)*
?sum: product (SIGN product)*
?product: signed (FACTOR signed)*
?signed: indexed | SIGN signed -> sign
?indexed: atom | element | member | method
element: indexed LIST_OPEN _items "]"
member: indexed DOT NAME
method: indexed DOT NAME _OPEN [_items] _CLOSE
_items: expression ("," expression)*
?atom: literal | name | call | list_ | run | join | _OPEN expression _CLOSE
literal: INTEGER | FLOAT | STRING | TRUE | FALSE
name: NAME
call: NAME _OPEN [_arguments] _CLOSE
_arguments: argument ("," argument)*
argument: expression [EQUAL expression]
list_: LIST_OPEN [_items] "]"
run: RUN NAME _OPEN _CLOSE
join: JOIN indexed

BREAK: "break"
CONTINUE: "continue"
HALT: "halt"
PAUSE: "pause"
ENTER_CRITICAL: "enter_critical"
EXIT_CRITICAL: "exit_critical"
RETURN: "return"
KILL: "kill"
RUN: "run"
JOIN: "join"
IF: "if"
_ELIF: "elif"
_ELSE: "else"
WHILE: "while"
_END: "end"
DEFINE.2: /(def|sec|thread)\b/
SCOPE.2: /(local|global)\b/
OR: "or"
XOR: "xor"
AND: "and"
NOT.2: /not\b|!(?!=)/
TRUE: "True"
FALSE: "False"
NAME: /[A-Za-z_][A-Za-z0-9_]{0,199}/
FLOAT.2: /([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+/
INTEGER: /[0-9]+/
STRING: /"[^"\n]*"/
COMPARE: "==" | "!=" | "<=" | ">=" | "<" | ">"
EQUAL: "="
SIGN: "+" | "-"
DOT: "."
FACTOR: "*" | "/" | "%"
LIST_OPEN: "["
_OPEN: "("
_CLOSE: ")"
_COLON: ":"
_NL: /\n/
COMMENT: /#[^\n]*/
LABEL: /\$[ \t]*[0-9]+[^\n]*/
BLANK: /[ \t\f]+/
%ignore COMMENT
%ignore LABEL
%ignore BLANK
"""


@cache
def parser() -> Lark:
    """Return the parser, which returns trees of the nodes in ``syntax``."""
    from lark import Lark

    from tool0.ur.urscript.layout import Layout
    from tool0.ur.urscript.trees import Trees

    return Lark(
        GRAMMAR,
        parser="lalr",
        lexer="basic",
        postlex=Layout(),
        transformer=Trees(),
        maybe_placeholders=True,
    )
