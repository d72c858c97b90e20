"""The documentation site: every page is in its navigation, its links lead somewhere, and it needs no network."""

import asyncio
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from browser import CHROMIUM, needs_a_browser
from playwright.async_api import async_playwright

ROOT = Path(__file__).parents[1]
SITE = runpy.run_path(str(ROOT / "scripts" / "make_site.py"))
NAVIGATION = SITE["navigation"]()
PATHS = [path for _, _, path in NAVIGATION]


def test_every_page_is_in_the_navigation_once():
    assert len({*PATHS}) == len(PATHS)
    assert {path for path in PATHS if path.startswith("docs/")} == {
        f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")
    }


def test_what_pages_link_to_is_part_of_the_site():
    staged = SITE["staged"]()
    assert {path for path in PATHS if path not in staged} == set()
    assert {"docs/example-fig4.png", "docs/results.schema.json", "src/lockprobe/protocols.py"} <= staged.keys()


def test_a_link_to_a_page_that_is_not_in_the_navigation_is_refused(monkeypatch):
    names = SITE["staged"].__globals__
    monkeypatch.setitem(names, "navigation", lambda: [row for row in NAVIGATION if row[2] != "docs/why.md"])
    with pytest.raises(SystemExit, match=r"docs/limits\.md|README\.md links to docs/why\.md, which is not in the nav"):
        SITE["staged"]()


def test_the_index_for_language_models_names_every_page_with_its_first_sentence():
    text = SITE["staged"]()["llms.txt"].decode()
    lines = re.findall(r"^- \[([^\]]+)\]\(([^)]+)\): (.+)$", text, re.MULTILINE)
    assert [(title, path) for title, path, _ in lines] == [(title, path) for _, title, path in NAVIGATION]
    assert re.match(r"# Lockprobe\n\n> A laboratory", text)
    assert {path: said for _, path, said in lines}["docs/statistics.md"] in " ".join(
        (ROOT / "docs/statistics.md").read_text("utf-8").split()
    )


@pytest.fixture(scope="module")
def built():
    """The site as ``.ci/run`` builds it."""
    pytest.importorskip("zensical", reason="the group docs is not installed: the site is not built")
    subprocess.run([sys.executable, str(ROOT / "scripts" / "make_site.py")], check=True, cwd=ROOT)
    return SITE["BUILT"]


def test_the_site_loads_nothing_from_the_network(built):
    pages = sorted(built.rglob("*.html"))
    assert len(pages) == len(PATHS) + 1  # and the page for an address that is not there
    loaded = r"<(?:script|img|iframe|source)[^>]*?src=[\"']?(https?:[^\"' >]+)|<link[^>]*?href=[\"']?(https?:[^\"' >]+)"
    assert {page.name: found for page in pages if (found := re.findall(loaded, page.read_text("utf-8")))} == {}
    for sheet in built.rglob("*.css"):
        assert not re.search(r"url\(\s*[\"']?https?:|@import", sheet.read_text("utf-8"))


@needs_a_browser
def test_search_works_in_pages_that_are_opened_as_files(built):
    async def search():
        asked = []
        async with async_playwright() as player:
            browser = await player.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
            page = await browser.new_page()
            page.on("request", lambda request: asked.append(request.url))
            await page.goto((built / "docs" / "why.html").as_uri())
            await page.keyboard.press("Control+k")
            await page.locator("input[aria-label=Search]").fill("Psych-DS")
            finding = page.locator("a", has_text="People's data as a Psych-DS dataset").first
            await finding.wait_for()
            leads_to = await finding.get_attribute("href")
            await browser.close()
        return asked, leads_to

    asked, leads_to = asyncio.run(search())
    assert "psych-ds.html" in leads_to
    assert {url for url in asked if url.startswith(("http:", "https:"))} == set()
