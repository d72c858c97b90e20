"""Builds the documentation site from the pages that ``zensical.toml`` names.

    uv run --group docs python scripts/make_site.py             writes .site/built; fails on any warning
    uv run --group docs python scripts/make_site.py --serve     shows the site and rebuilds it when a page changes

The site has the shape of the repository, so a link that works in the repository works in the site. The script copies
the pages and the files that they link to, and writes ``llms.txt``, the index for language models.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import site_reference

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / ".site" / "source"
BUILT = ROOT / ".site" / "built"


def navigation() -> list[tuple[str, str, str]]:
    """The section, title and path of every page, in the order of the navigation."""
    rows = []
    for entry in tomllib.loads((ROOT / "zensical.toml").read_text("utf-8"))["project"]["nav"]:
        ((name, inside),) = entry.items()
        pages = [{name: inside}] if isinstance(inside, str) else inside
        rows += [(name, title, path) for page in pages for title, path in page.items()]
    return rows


@cache
def generated() -> dict[str, str]:
    """The pages that are not in the repository, by path."""
    return site_reference.pages()


def text_of(page: str) -> str:
    """A page's Markdown."""
    return generated().get(page) or (ROOT / page).read_text("utf-8")


def prose(text: str) -> str:
    """Markdown without its blocks of code."""
    return re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)


def linked(page: str) -> Iterator[str]:
    """The paths, from the root of the repository, of the files that a page links to or shows."""
    for target in re.findall(r"\]\(([^)\s#]+)[^)]*\)", prose(text_of(page))):
        if not target.startswith(("http:", "https:", "mailto:")):
            yield os.path.normpath(Path(page).parent / target)


def summary(page: str) -> str:
    """The first sentence of a page, without links and marks."""
    paragraphs = prose(text_of(page)).split("\n\n")
    first = next((one for one in paragraphs if re.match(r"[\w`*\[]", one.strip("\n"))), "")
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(first.split()))
    return re.split(r"(?<=[.:]) (?=[A-Z`])", plain)[0].rstrip(":")


def is_directives(page: str) -> bool:
    """Whether the site fills a page with docstrings, so that its Markdown says nothing."""
    return "\n::: " in text_of(page)


def llms_txt() -> str:
    """An index of the site in Markdown, in the form that llmstxt.org proposes."""
    project = tomllib.loads((ROOT / "zensical.toml").read_text("utf-8"))["project"]
    parts = [f"# {project['site_name']}\n\n> {project['site_description']}\n"]
    section = ""
    for name, title, path in navigation():
        heading = "Overview" if name == title else name  # pages without a section
        if heading != section:
            parts.append(f"\n## {heading}\n\n")
        section = heading
        address = path.replace(".md", ".html") if is_directives(path) else path
        parts.append(f"- [{title}]({address}): {summary(path)}\n")
    return "".join(parts)


def staged() -> dict[str, bytes]:
    """What the site is made of, by path: the pages, what they link to, and ``llms.txt``."""
    pages = [path for _, _, path in navigation()]
    links = {(page, path) for page in pages for path in linked(page)}
    lost = [(page, path) for page, path in links if path not in pages and not (ROOT / path).is_file()]
    strays = [(page, path) for page, path in links if path.endswith(".md") and path not in pages]
    wrong = [f"{page} links to {path}, which is no file" for page, path in lost]
    wrong += [f"{page} links to {path}, which is not in the navigation" for page, path in strays]
    if wrong:
        sys.exit("\n".join(sorted(wrong)))
    texts = {path: text_of(path).encode() for path in pages}
    linked_files = {path: (ROOT / path).read_bytes() for _, path in links if path not in texts}
    return {**texts, **linked_files, "llms.txt": llms_txt().encode()}


def stage() -> None:
    """Brings ``.site/source`` up to date; files that did not change are not touched."""
    files = staged()
    for old in [path for path in SOURCE.rglob("*") if path.is_file()]:
        if old.relative_to(SOURCE).as_posix() not in files:
            old.unlink()
    for path, content in files.items():
        there = SOURCE / path
        there.parent.mkdir(parents=True, exist_ok=True)
        if not there.exists() or there.read_bytes() != content:
            there.write_bytes(content)


def build() -> None:
    """Builds the site, and puts every page's Markdown next to it for readers of ``llms.txt``."""
    shutil.rmtree(BUILT, ignore_errors=True)
    done = subprocess.run([sys.executable, "-m", "zensical", "build", "--strict", "--clean"], cwd=ROOT, check=False)
    if done.returncode:
        sys.exit(done.returncode)
    for _, _, page in navigation():
        if not is_directives(page):
            shutil.copyfile(SOURCE / page, BUILT / page)


def serve() -> None:
    """Shows the site until Ctrl-C, and copies pages again once a second if they changed."""
    with subprocess.Popen([sys.executable, "-m", "zensical", "serve"], cwd=ROOT) as server:
        try:
            while server.poll() is None:
                time.sleep(1)
                stage()
        except KeyboardInterrupt:
            server.terminate()


def main() -> None:
    """Builds the site, or serves it."""
    stage()
    if "--serve" in sys.argv[1:]:
        serve()
    else:
        build()


if __name__ == "__main__":
    main()
