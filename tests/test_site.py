"""The documentation site: every page is in its navigation, its links lead somewhere, and it needs no network."""

import asyncio
import re
from pathlib import Path

import make_site
import pytest
import site_reference
from browser import CHROMIUM, needs_a_browser
from playwright.async_api import async_playwright

import lockprobe
from lockprobe.cli import every_command

ROOT = Path(__file__).parents[1]
NAVIGATION = make_site.navigation()
PATHS = [path for _, _, path in NAVIGATION]


def test_every_page_is_in_the_navigation_once():
    assert len({*PATHS}) == len(PATHS)
    folders = ("docs", "robot/docs")
    pages = {f"{folder}/{page.name}" for folder in folders for page in (ROOT / folder).glob("*.md")}
    assert {path for path in PATHS if path.startswith(folders)} == pages


def test_what_pages_link_to_is_part_of_the_site():
    staged = make_site.staged()
    assert {path for path in PATHS if path not in staged} == set()
    assert {
        "docs/example-fig4.png",
        "docs/results.schema.json",
        "src/lockprobe/trial/protocols.py",
    } <= staged.keys()


def test_a_link_to_a_page_that_is_not_in_the_navigation_is_refused(monkeypatch):
    monkeypatch.setattr(make_site, "navigation", lambda: [row for row in NAVIGATION if row[2] != "docs/why.md"])
    with pytest.raises(SystemExit, match=r"docs/limits\.md|README\.md links to docs/why\.md, which is not in the nav"):
        make_site.staged()


def test_the_index_for_language_models_names_every_page_with_its_first_sentence():
    text = make_site.staged()["llms.txt"].decode()
    lines = re.findall(r"^- \[([^\]]+)\]\(([^)]+)\): (.+)$", text, re.MULTILINE)
    assert [(title, path.replace(".html", ".md")) for title, path, _ in lines] == [row[1:] for row in NAVIGATION]
    assert re.match(r"# Lockprobe\n\n> A laboratory", text)
    assert {path: said for _, path, said in lines}["docs/statistics.md"] in " ".join(
        (ROOT / "docs/statistics.md").read_text("utf-8").split()
    )


def test_the_page_on_citing_says_what_the_citation_file_says():
    """Title by title and name by name; the file is not parsed as YAML, which nothing else here needs."""
    cited = (ROOT / "CITATION.cff").read_text("utf-8")
    page = (ROOT / "docs" / "cite.md").read_text("utf-8")
    titles = re.findall(r'title: "(.*)"', cited)
    assert re.findall(r"title +. \{(.*)\}", page.replace("{LLMs}", "LLMs")) == titles
    people = re.findall(r"family-names: (\S+)\s+given-names: (\S+)", cited)
    assert f"author = {{{' and '.join(', '.join(one) for one in people)}}}" in page
    (license_,) = re.findall(r"^license: (.*)$", cited, re.MULTILINE)
    assert f"{{Version VERSION, {license_}}}" in page
    assert not re.search(r"^version:", cited, re.MULTILINE)  # a checkout has no number that a file could hold


def test_the_page_on_citing_has_the_entries_that_a_study_writes():
    template = (ROOT / "src/lockprobe/report/templates/references.bib").read_text("utf-8")
    (shown,) = re.findall(
        r"^```bibtex\n(.*?)^```$", (ROOT / "docs" / "cite.md").read_text("utf-8"), re.DOTALL | re.MULTILINE
    )
    assert shown == template[: len(shown)]
    assert re.findall(r"^@\w+\{(.*),$", shown, re.MULTILINE) == ["lockprobe", "zenkri-brock"]


def test_every_public_name_and_every_command_is_in_the_reference():
    listed = [name for names in site_reference.NAMES.values() for name in names.split()]
    assert sorted(listed) == sorted({*lockprobe.__all__} - {"__version__"})
    page = make_site.generated()["reference/commands.md"]
    assert re.findall(r"^## lockprobe (\S+)$", page, re.MULTILINE) == every_command()
    sections = dict(re.findall(r"^## lockprobe (\S+)$(.*?)(?=^## )", page, re.MULTILINE | re.DOTALL))
    assert re.findall(r"^\| (\w[\w ]*) \| meaning \|$", sections["run"], re.MULTILINE) == [
        "Arguments", "Options", "The study", "Reports and conditions", "Running", "Hosted models"]  # fmt: skip
    assert "whose --help explains them](#lockprobe-run): `--box, --p, " in sections["serve"]
    assert "| `--length <int range>` | Length of the trial in steps (20). [0&lt;=x&lt;=10000] |" in page


@pytest.fixture(scope="module")
def built():
    """The site as ``.ci/run`` built it a minute ago."""
    pages = {
        page.relative_to(make_site.BUILT).with_suffix(".md").as_posix() for page in make_site.BUILT.rglob("*.html")
    }
    if not {path.replace("README.md", "index.md") for path in PATHS} <= pages:
        pytest.skip("the site is not built: uv run --group docs python scripts/make_site.py")
    return make_site.BUILT


def test_the_site_loads_nothing_from_the_network(built):
    pages = sorted(built.rglob("*.html"))
    assert len(pages) == len(PATHS) + 1  # and the page for an address that is not there
    loaded = r"<(?:script|img|iframe|source)[^>]*?src=[\"']?(https?:[^\"' >]+)|<link[^>]*?href=[\"']?(https?:[^\"' >]+)"
    assert {page.name: found for page in pages if (found := re.findall(loaded, page.read_text("utf-8")))} == {}
    for sheet in built.rglob("*.css"):
        assert not re.search(r"url\(\s*[\"']?https?:|@import", sheet.read_text("utf-8"))


def test_what_the_index_for_language_models_names_is_there(built):
    named = re.findall(r"\]\(([^)]+)\): ", (built / "llms.txt").read_text("utf-8"))
    assert len(named) == len(PATHS)
    assert {name for name in named if not (built / name).is_file()} == set()


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
