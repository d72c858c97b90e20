"""What a class or function says of itself, also under ``python -OO``, which drops docstrings: then from its source."""

from __future__ import annotations

import sys
from inspect import cleandoc, getsource, isclass, isroutine


def docstring(thing: object) -> str:
    """The docstring of a class, a function or an object's class; empty without one, or where it has no source."""
    kept = isroutine(thing) and thing.__doc__  # of C, or set; what a class has then was made up by dataclass
    if sys.flags.optimize < 2 or kept:
        return cleandoc(thing.__doc__ or "")
    import ast
    from textwrap import dedent

    kind = thing if isclass(thing) or isroutine(thing) else type(thing)
    try:
        return ast.get_docstring(ast.parse(dedent(getsource(kind))).body[0]) or ""  # type: ignore[arg-type]
    except (OSError, SyntaxError, TypeError):
        return ""


def first_line(thing: object) -> str:
    """The first line of a docstring."""
    return docstring(thing).partition("\n")[0]
