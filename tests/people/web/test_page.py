"""What a participant's browser loads: built from `page/`, small, and asking nobody but its own server."""

import gzip
import hashlib
import json
import re
from importlib import resources
from pathlib import Path

import pytest

import lockprobe.people.web
from lockprobe import people
from lockprobe.people.experiment import read_words

STATIC = Path(str(resources.files(lockprobe.people.web))) / "static"
PAGE = Path(__file__).parents[3] / "page"
BUILT = ("LICENSES.txt", "icon.svg", "index.html", "page.css", "page.js")
LOADED = ("index.html", "page.css", "page.js", "icon.svg")


def fingerprint(page):
    """As `page/build.mjs` takes it: SHA-256 over names and contents, each ended by a zero byte."""
    files = (file for at in ("src", "licenses") for file in (page / at).rglob("*"))
    names = [file.relative_to(page).as_posix() for file in files if file.is_file()]
    names += ["build.mjs", "package.json", "package-lock.json"]
    digest = hashlib.sha256()
    for name in sorted(names):
        digest.update(name.encode() + b"\0" + (page / name).read_bytes() + b"\0")
    return digest.hexdigest()[:12]


def test_the_built_page_is_that_of_the_sources_edited_by_nobody_and_below_200_kilobytes():
    made = json.loads((STATIC / "page.json").read_text())
    again = "the page was changed and not built: cd page && npm ci --ignore-scripts && npm run build"
    assert made["version"] == fingerprint(PAGE), again
    assert made["files"] == {name: hashlib.sha256((STATIC / name).read_bytes()).hexdigest() for name in BUILT}
    assert sum(len(gzip.compress((STATIC / name).read_bytes(), 6)) for name in LOADED) < 200_000


@pytest.mark.parametrize("name", LOADED)
def test_nothing_is_asked_of_another_host(name):
    text = (STATIC / name).read_text()
    urls = set(re.findall(r"(?:[a-z][a-z0-9+.-]*:)?//[\w.-]+\.[a-z]{2,}[^\s\"'`)]*", text, re.IGNORECASE))
    spoken_of = r"https?://(www\.w3\.org/|(www\.)?jspsych\.org|doi\.org/|joss\.theoj\.org/)"
    assert [url for url in urls if not re.match(spoken_of, url)] == []
    loads = re.findall(
        r"(?:src|href|action|data-src)\s*=\s*[\"']?(?:https?:)?//|url\(\s*[\"']?(?:https?:)?//|@import", text
    )
    assert loads == []


def test_every_text_that_is_used_is_in_the_texts_and_every_text_is_used():
    server = (Path(people.__file__).parent / "scenes.py").read_text("utf-8")
    page = "\n".join(source.read_text() for source in (PAGE / "src").rglob("*.js"))
    known = read_words("en").page
    unused = [name for name in known if not re.search(rf'\.{name}\b|"{name}"', page + server)]
    assert unused == []
    used = set(re.findall(r"words(?:\.page)?\.([a-z_]+)\b", page))
    known = {*known, "page", "language", "direction", "title", "js"}
    assert used - known == set()


def test_packages_are_known_by_what_is_in_them_and_their_licences_are_beside_the_bundle():
    lock, text = json.loads((PAGE / "package-lock.json").read_text()), (STATIC / "LICENSES.txt").read_text()
    packages = {name.removeprefix("node_modules/"): package for name, package in lock["packages"].items() if name}
    assert packages
    for name, package in packages.items():
        assert "resolved" not in package
        assert package["integrity"].startswith("sha512-")
        bundled = not package.get("dev") and name != "type-fest"  # types alone
        assert not bundled or f"{name} {package['version']} (" in text
