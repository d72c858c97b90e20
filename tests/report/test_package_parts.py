"""Parts of packages: what is taken out of a page that is verified, and what is not."""

import pytest

from lockprobe.report.package_parts import stays_within, without_packages

PART = (
    "<!-- a section of another package -->\n"
    '<details class="section" id="strange.dozens">\n<summary><h2>Dozens</h2></summary>\n'
    '<p class="by">From the package strange 0.3, not from Lockprobe.</p>\n<p>24 &lt; 25</p>\n</details>\n<!-- its end -->\n'
)
BEFORE = '<html><head></head><body>\n\n<details class="section" id="speed">\n<p>Ours.</p>\n</details>\n\n'
AFTER = '\n<details class="section" id="limits">\n</details>\n\n</body>\n</html>'


def stripped(page):
    text, sources = without_packages(page.encode())
    return text.decode(), sources


@pytest.mark.parametrize("parts", [1, 2])
def test_a_part_between_sections_is_taken_out_and_its_package_named(parts):
    page = BEFORE + PART * parts + AFTER
    text, sources = stripped(page)
    assert sources == ["strange 0.3"] * parts
    assert text == BEFORE + AFTER
    assert stripped(BEFORE + PART + "\n</body>\n</html>") == (BEFORE + "\n</body>\n</html>", ["strange 0.3"])


BEYOND = {
    "a style": "<style>body > * { display: none }</style>",
    "an attribute of style": '<p style="position: fixed">x</p>',
    "a script": "<script>1</script>",
    "what it would run": '<p onclick="x()">x</p>',
    "another base": '<base href="https://example.org/">',
    "the end of its own element": '</details><p>ours</p><details class="section" id="x">',
    "the beginning of a comment": "<!-- ",
    "the end of its marker": "<!-- its end -->\n<p>ours</p>",
    "an element without an end": "<div>",
    "a tag without an end": "<p",
    "a declaration": "<!DOCTYPE html>",
    "an instruction": "<?php ?>",
    "an element that ends itself": "<div/>",
    "a frame": "<iframe></iframe>",
}


@pytest.mark.parametrize("markup", BEYOND.values(), ids=BEYOND)
def test_a_part_that_reaches_beyond_itself_is_no_part(markup):
    assert not stays_within(markup)
    page = BEFORE + PART.replace("<p>24 &lt; 25</p>", markup) + AFTER
    assert stripped(page) == (page, [])


@pytest.mark.parametrize(
    "page",
    {
        "in the head": BEFORE.replace("</head>", f"{PART}</head>") + AFTER,
        "within a section of ours": BEFORE.replace("<p>Ours.", f"{PART}<p>Ours.") + AFTER,
        "without whose it is": BEFORE
        + PART.replace('<p class="by">From the package strange 0.3', "<p>From me")
        + AFTER,
        "before a paragraph": BEFORE + PART + "<p>Ours.</p>" + AFTER,
    }.values(),
)
def test_a_part_elsewhere_or_without_a_name_stays(page):
    assert stripped(page) == (page, [])


def test_bytes_that_are_no_text_stay():
    page = (BEFORE + PART + AFTER).encode().replace(b"Ours", b"\xff")
    assert without_packages(page)[0] == (BEFORE + AFTER).encode().replace(b"Ours", b"\xff")
