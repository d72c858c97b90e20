"""Parts of the page of a report, by their anchors."""

import re


def part(page, name):
    """The markup of a part of ``report.html``; empty if the page has none of this name."""
    opens = rf'<details class="q" id="{re.escape(name)}">'
    found = re.search(rf'{opens}\n(.*?)(?=<details class="q" id=|</section>|</body>)', page, re.DOTALL)
    return found[1] if found else ""
