"""What classes and functions say of themselves is said under every option of Python."""

import subprocess
import sys

LISTS = ("list agents", "list plants", "list interventions", "list measures", "run --help", "box --help", "--help")
ALL = f"""
import sys
from lockprobe.cli import main
from lockprobe.foundation.docstrings import docstring, first_line
from own import Twice, half

for line in {LISTS}:
    sys.argv = ["lockprobe", *line.split()]
    try: main()
    except SystemExit: pass
print(([docstring(one) for one in (Twice, Twice(1), half, len, lambda: 1)], first_line(Twice)))
"""
OWN = '''
from dataclasses import dataclass

@dataclass
class Twice:
    """Doubled.

    By two.
    """

    n: int

def half():
    "Halved."
'''


def test_lists_help_and_a_stranger_s_words_are_there_where_python_drops_docstrings(tmp_path):
    (tmp_path / "own.py").write_text(OWN, "utf-8")
    plain, without = (
        subprocess.run([sys.executable, *option, "-c", ALL], cwd=tmp_path, capture_output=True, text=True, check=True)
        for option in ([], ["-OO"])
    )
    assert plain.stdout.splitlines()[-1].startswith("(['Doubled.\\n\\nBy two.', 'Doubled.\\n\\nBy two.', 'Halved.', ")
    assert without.stdout == plain.stdout
