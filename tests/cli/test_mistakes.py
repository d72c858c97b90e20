"""A mistake of whoever types a command is one line that says what was asked and what exists, and makes no file."""

import shlex
from dataclasses import replace

import pytest
from builders import small_study, write_study

MISTAKES = """
run flip | no study is called 'flip' (did you mean 'flips'?); there are: flips, modalities, why
run flips --trials 0 | trials: got 0, expected at least 1
run none.toml | none.toml: cannot be read (No such file or directory)
status nowhere | nowhere: no study.json here; is it the directory of a study?
report nowhere | nowhere: no study
loops none.txt | none.txt: cannot be read (No such file or directory)
fly | No such command 'fly'.
box chain-4 | No such command 'chain-4' of lockprobe box; there are check, list, show, generate
run flips --trials ten | Invalid value for '--trials': expected a whole number
run flips --workers 0 | Invalid value for '--workers': expected at least 1
run flips --budget x | Invalid value for '--budget': expected a number
serve --port 80000 | Invalid value for '--port': expected at most 65535
power what | no study is called 'what'
power nowhere.toml | cannot be read
power --success 0.2,x | numbers separated by commas
power --success 0.2,0.7 | a share from 0 to 1 for each of 7 conditions
power --success 0.2,1.7 --p 0,0.4 | got '0.2,1.7'
power --p 0,0.4 | success: got '', expected a share from 0 to 1 for each of 2 conditions: truth; flip?p=0.4
power --trials 1 | numbers of at least 2
power --trials nan | whole numbers
power --trials 1e300 | whole numbers
power --condition nudge --success 0.2,nan | each of 2 conditions: truth; nudge
power --agent random --p 0 --success 0.2 | a control and another condition
power why --people --success 0.4,0.6 | --people cannot be combined with why
power --people --condition nudge | --people cannot be combined with --condition
power --people --success 0.4 | two or more shares
power --people --success 0.4,0.6 --persons 19 | persons: got [19], expected numbers of at least 20
power --boxes-each 2 | power cannot be combined with --boxes-each
power --over-boxes 5 --persons 40 | --over-boxes cannot be combined with --persons
power --over-boxes 2 --success 0.2,0.4 | boxes: got [2], expected numbers of at least 5
run flips --until soon --agent random | until: got 'soon', expected decided, ±10
run flips --until 60 --agent random | until: got '60', expected decided, ±10 or another number of points, from 1 to 50
run flips --until decided --agent participant | until: got 'decided', expected none with people
run flips --condition 'trembel?p=0.1' --agent random | no intervention is called 'trembel' (did you mean 'tremble'?)
run flips --sweep 'tremble?p=0.1' --agent random | expected several values of a dose
run flips --condition rgb --agent random | a plant with a camera
run flips --condition python:nowhere:Nothing --agent random | python:nowhere:Nothing
run flips --condition lies= --agent random | condition: got 'lies=', expected NAME=SPEC, for example lies=flip?p=0.4
run flips --condition =nudge --agent random | condition: got '=nudge', expected NAME=SPEC
run flips --condition flip --agent random | got 'flip', expected one that does something; without p= it is the truth
run flips --condition x=nudge --condition y=nudge --agent random | another condition than x, which is the same
run flips --p 0,0.4 --condition 'x=flip?p=0.4' --agent random | expected another condition than flip?p=0.4, which is the same
serve --port 0 | study: got None
serve '' --port 0 | study: got ''
serve flips --p 2 --port 0 | p: got 2.0
serve flips --texts xx --port 0 | no language is called 'xx'
serve flips --texts none.toml --port 0 | cannot be read
serve flips --people none.toml --port 0 | cannot be read
serve flips --people 999999999999999999999999999999 --port 0 | participants:
serve flips --people a.toml --people b.toml --port 0 | one file, one number, or one of each
serve flips --join-code 'a b' --port 0 | join_code
serve flips --condition 'flip?p=0.4 + history?last=3' --port 0 | got 'history?last=3', expected what is told
serve flips --condition hypothesis --port 0 | the page asks for a joint and what the last action did
serve flips --condition nudge --texts de --port 0 | texts: got 'de', expected English ones with nudge
serve flips --host 0.0.0.0 --port 0 | give --public-url
serve flips --host 'no such' --port 0 | host: got 'no such'
serve flips --public-url ftp://a --port 0 | public-url
serve flips --allow-host a:1 --port 0 | allow-host
serve . --port 0 | no study.json here
mcp flips --out S | outside of the working directory
mcp flips --agent-name 'a b' | mcp:NAME with at most 64
mcp flips --plant manual | a plant that asks nothing at the terminal
mcp flips --condition history | a client keeps its conversation itself
mcp flips --agent random | No such option: --agent
play --box nothing | no box is called 'nothing'
play --p 2 | p: got 2.0, expected a number from 0 to 1
play --p 0,0.4 | expected one for one trial
box show chan-4 | no box is called 'chan-4' (did you mean 'chain-4'
box show random-9-1 | random-N-SEED with N from 2 to 8
box show none.toml | none.toml: cannot be read
box show --out x.pdf | in .svg, .png or .xml
box show --arm --out x.svg | --arm: got True, expected --out FILE.xml with it
box generate --family chain | no family is called 'chain'
box generate --family random | random-2 to random-8
list measures nowhere | nowhere: no study.json here
import @/S nowhere | nowhere: no study.db here
import @/S @/S | a directory other than DIR
import @/S @/empty | empty: no study.db here; is it the directory of a study?
export @/S --out '' | .: not a regular file
export @/S --out .. | ..: not a regular file
export @/S --table records | --format: got 'csv', expected jsonl, because a record is a JSON object
export @/S --format frames | --out: got None, expected a directory for the pictures
export @/S --trial x | --trial: got 'x', expected --format frames with it
export @/S --format parquet --out - | --out: got None, expected a file to write, because parquet is not text
replay @/S nothing | no trial is called 'nothing'
replay @/S flips/random/truth --out a.avi | a name that ends in .gif
replay @/S flips/random/truth --out no/a.gif | its directory does not exist
report @/S --agent random | --agent and --out cannot be combined with one study
report @/S @/other --paper | cannot be combined with several studies
report @/S none | none: no study.json here
report @/S @/S | given twice
report @/S @/longer | max_steps is 9, not 20
report @/S @/other --agent nobody | no agent of these studies is called 'nobody'
report @/S @/other --out @/S/report.html | belongs to the study
report @/S @/other --out none/page.html | cannot be written
"""
"""A command as typed | what the line holds."""


@pytest.fixture(scope="module")
def there(tmp_path_factory):
    """Studies to which commands refer."""
    root, study = tmp_path_factory.mktemp("there"), small_study(trials=1, repetitions=1)
    write_study(root / "S", study)
    for name, change in {"other": {"seed": 3}, "longer": {"max_steps": 9}}.items():
        write_study(root / name, replace(study, **change), [])
    (root / "empty").mkdir()
    return str(root)


@pytest.mark.parametrize("row", MISTAKES.strip().split("\n"))
def test_a_mistake_is_one_line_and_makes_no_file(lockprobe, tmp_path, monkeypatch, there, row):
    monkeypatch.chdir(tmp_path)
    command, _, said = row.partition(" | ")
    status, out, error = lockprobe(*(word.replace("@", there) for word in shlex.split(command)))
    assert (status, out, error.count("\n"), list(tmp_path.iterdir())) == (2, "", 1, [])
    assert error.startswith("lockprobe: ")
    assert said in error
