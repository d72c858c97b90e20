"""Writes ``MODULES.md``: every module of both distributions with the first sentence of its docstring.

    python scripts/list_modules.py [--check]

``--check`` writes nothing; the exit status says whether the page is up to date.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCES = (ROOT / "src" / "lockprobe", ROOT / "robot" / "src" / "lockprobe_robot")
PAGE = ROOT / "MODULES.md"

HEAD = """# Modules

Every module with the first sentence of its docstring. `python scripts/list_modules.py` writes this page.
[ARCHITECTURE.md](ARCHITECTURE.md) shows how the packages stand on each other.
"""


def first_sentence(path: Path) -> str:
    """The first sentence of a module's docstring, on one line."""
    text = ast.get_docstring(ast.parse(path.read_text("utf-8"))) or ""
    paragraph = re.sub(r"\s+", " ", text.split("\n\n")[0]).strip()
    sentence = re.split(r"(?<=[a-z`)\]0-9])[.;:] (?=[A-Z`])", paragraph)[0]
    return re.sub(r":(?:mod|class|func|meth|attr):`~?([^`]*)`", r"`\1`", sentence).replace("``", "`").rstrip(".:")


def page() -> str:
    """The whole page in Markdown."""
    return "".join([HEAD, *(part for source in SOURCES for part in _of_package(source))])


def _of_package(source: Path) -> Iterator[str]:
    files = sorted(source.rglob("*.py"), key=lambda path: (path.parent.as_posix(), path.name))
    for folder, inside in groupby(files, key=lambda path: path.parent):
        name = folder.relative_to(source.parent).as_posix()
        yield f"\n## {name}\n\n{first_sentence(folder / '__init__.py')}.\n"
        rows = [path for path in inside if path.name not in ("__init__.py", "__main__.py")]
        if rows:
            yield "\n" + "".join(f"- `{path.name}`: {first_sentence(path)}\n" for path in rows)


def main() -> int:
    """Writes the page, or checks it."""
    if "--check" in sys.argv[1:]:
        return int(not PAGE.exists() or PAGE.read_text("utf-8") != page())
    PAGE.write_text(page(), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
