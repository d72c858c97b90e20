"""Parts of the pages of a report, by their anchors."""

import re


def part(page, name):
    """The markup of a part of ``report.html`` or ``details.html``; empty if the page has none of this name."""
    opens = rf'<(?:details class="section"|section) id="{re.escape(name)}">'
    found = re.search(rf'{opens}\n(.*?)(?=<details class="section" id=|</section>|</body>)', page, re.DOTALL)
    return found[1] if found else ""
