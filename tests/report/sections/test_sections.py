"""Sections of packages: they join the report, one that is broken leaves it whole, and verification runs none."""

import sys

import pytest
import strangers
from builders import small_study, write_study

from lockprobe.foundation.left_out import leaving_out
from lockprobe.foundation.plugins import no_foreign_code
from lockprobe.report.pages import PAGES, page_of, parts_of, tables_of
from lockprobe.report.results import results
from lockprobe.report.rows import Results
from lockprobe.report.sections import all_sections, own_sections
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report
from lockprobe.testing import check_section

PACKAGE = "strange-things 0.3"

TEXT = '''
"""How many trials there are, in dozens."""

from lockprobe.report.section import Caption, Figure, Heading, Part, Section, Table, Text
from markupsafe import Markup
from lockprobe.report.rows import Estimate, Fact, Finding


def rows(study):
    yield from [cell.estimate("strange.dozens", len(cell.trials) / 12, unit="dozens") for cell in study.cells]
    yield Finding(section="strange.dozens", kind="answer", text="They are counted.", judges=False)


def cells(found):
    return [["agent", "dozens"]] + [[row.agent, f"{row.value:.2f}"] for row in found.where("strange.dozens")]


def draw(found):
    from matplotlib.figure import Figure
    return Figure()


def show(found):
    yield Part("Dozens", found.answer_of("strange.dozens"), [TABLE, FIGURE])
    yield Part("More dozens", "", [Heading("Nothing")], name="strange.more-dozens")


TABLE = Table("strange.dozens", cells)
FIGURE = Figure("strange.dozens-drawn", "Nothing", Caption("An empty sheet."), draw="strange:draw")
GIVEN = {"name": "strange.dozens", "title": "Dozens", "rows": rows, "show": show, "tables": (TABLE,), "figures": (FIGURE,)}
SECTION = Section(**GIVEN, after="speed")
# the end
'''


def install(directory, monkeypatch, text=TEXT, points=None):
    directory.mkdir()
    strangers.install(directory, monkeypatch, text=text, points=points or {"sections": {"dozens": "SECTION"}})


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study with a report without packages."""
    directory = write_study(tmp_path_factory.mktemp("strange") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    write_report(directory)
    return directory


def whole(found):
    """What a package may not change: answer, numbers, and parts of the page."""
    with leaving_out():
        parts = [part.name for part in parts_of(found, "report") if not part.source]
    return found.answer, [row for row in found.rows if not row.source], parts


@pytest.fixture(scope="module")
def alone(study):
    """The same without packages."""
    return whole(results(study))


def test_it_stands_after_the_section_it_names_and_its_rows_name_the_package(tmp_path, monkeypatch, study, alone):
    install(tmp_path / "package", monkeypatch)
    page = write_report(study).read_text("utf-8")
    found = Results.model_validate_json((study / "results.json").read_bytes())
    assert whole(found) == alone
    names = [part.name for part in parts_of(found, "report")]
    assert names[names.index("speed") :][:3] == ["speed", "strange.dozens", "strange.more-dozens"]
    part = page.partition('id="speed"')[2].partition('id="strange.dozens"')[2].partition('id="optimal_actions"')[0]
    assert "They are counted." in part
    assert "An empty sheet." in part
    assert part.count("0.25</td>") == len(found.where("strange.dozens")) == 2
    assert {row.source for row in (*found.rows, *found.findings)} == {"", PACKAGE}
    assert (study / "tables" / "strange.dozens.csv").read_text().splitlines()[1] == "random,0.25"
    assert (study / "figures" / "strange.dozens-drawn.svg").exists()


@pytest.mark.parametrize("after", ["", "nothing"])
def test_without_a_place_it_stands_at_the_end(tmp_path, monkeypatch, after):
    install(tmp_path / "package", monkeypatch, TEXT.replace('"speed"', f'"{after}"'))
    assert [one.name for one in all_sections()] == [*(one.name for one in own_sections()), "strange.dozens"]
    assert all_sections()[-1].source == PACKAGE
    with no_foreign_code():
        assert all_sections() == own_sections()


def test_verification_runs_none_of_its_code_and_counts_what_it_left(tmp_path, monkeypatch, study):
    install(tmp_path / "package", monkeypatch)
    write_report(study)
    monkeypatch.delitem(sys.modules, "strange")
    checks = {check.name: check for check in verify(study)}
    assert "strange" not in sys.modules
    assert all(check.holds for check in checks.values()), checks
    assert checks["results"].said.endswith(f"; 3 of its rows are not checked: they come from {PACKAGE}")
    assert checks["report"].said.endswith(
        f"; 2 parts of report.html are not checked: they come from {PACKAGE}; not checked, as they have names of "
        "packages: figures/strange.dozens-drawn, tables/strange.dozens"
    )
    path = study / "claims.html"  # no package adds to this page
    path.write_text(path.read_text("utf-8") + "<!-- a section of another package -->x<!-- its end -->\n", "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    assert failed.failed == ("claims.html",)


def _added(study, row):
    write_report(study)
    path = study / "results.json"
    path.write_text(path.read_text("utf-8").replace(' "rows": [\n', f' "rows": [\n  {row},\n'), "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    return failed


def test_what_has_a_name_of_ours_is_checked_whoever_is_said_to_have_made_it(study):
    made_up = '{"quantity": "success", "agent": "random", "condition": "truth", "value": 0.99, "source": "some 1.0"}'
    assert _added(study, made_up).failed == ("rows: success of some 1.0 has a name of Lockprobe's rows",)


def test_a_column_without_a_value_and_two_values_of_a_name_are_named(study):
    write_report(study)
    path = study / "results.json"
    text = path.read_text("utf-8")
    path.write_text(text.replace('"quantity": "success",', '"quantity": "success", "family": null,', 1), "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    assert "family None written, None computed" in failed.failed[0]
    path.write_text(text.replace('"quantity": "success",', '"quantity": "success", "value": 0.99,', 1), "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    assert failed.said == "results.json is damaged (two values of value)"


def test_a_row_that_names_no_package_is_checked(study):
    """Who makes numbers up may call them those of a measure, but not of Lockprobe."""
    made_up = '{"quantity": "measures.made_up", "value": 1}'
    assert _added(study, made_up).failed == ("rows: measures.made_up is no row of this report",)


WRONG = {
    "its module raises": ("raise OSError('no such thing')", "Section dozens", "(OSError: no such thing)"),
    "it is not there": ("del SECTION", "Section dozens", "(AttributeError: module 'strange' has no attribute 'SECTION')"),
    "it is no section": ("SECTION = dict", "Section dozens", "(TypeError: type, not a Section)"),
    "it has the name of another": ('SECTION = Section(name="speed", title="Speed")', "Section dozens", "unlike 'speed')"),
    "it has the name of measures": ('SECTION = Section(name="measures.x", title="x")', "Section dozens",
                                    "not with measures., unlike measures.x)"),
    "its table has the name of another": ('SECTION = Section(**GIVEN | {"tables": (Table("grids", cells),)})',
                                          "Section dozens", "unlike 'grids')"),
    "its table has the name of another package": (
        'SECTION = Section(**GIVEN | {"tables": (Table("other.dozens", cells),)})', "Section dozens",
        "begin alike, and not with measures., unlike other.dozens)"),
    "its rows raise": ("def rows(study): raise SystemExit('enough')", "Dozens", "(SystemExit: enough)"),
    "its rows are none": ("def rows(study): yield {'quantity': 'dozens'}", "Dozens", "(TypeError: dict, not a row of lockprobe.report.rows)"),
    "its row was made without checks": ("def rows(study): yield Fact.model_construct(about='a', name='b', text=object())",
                                        "Dozens", "(PydanticSerializationError"),
    "its row is no JSON": ("def rows(study): yield Estimate(quantity='strange.dozens', doses={'a': float('nan')})",
                           "Dozens", "(ValueError: Out of range float values are not JSON compliant"),
    "its table has a path for a name": ('SECTION = Section(**GIVEN | {"tables": (Table("../strange.dozens", cells),)})',
                                        "Section dozens", "unlike '../strange.dozens')"),
    "its part has no heading": ("def show(found): return [Part(['x'], '', [])]", "Dozens", "not a Part whose heading"),
    "its figure has the name of another": (
        "def show(found): return [Part('x', '', [Figure('grid-1', 'alt', Caption('c'), f'{__name__}:draw')])]",
        "Dozens", "unlike 'grid-1')"),
    "its part hides the page": ("def show(found): return [Part('Dozens', '', [Text(Markup('<style>p {}</style>'))])]",
                                "Dozens", "ValueError: markup of this part reaches beyond it"),
    "its block is none": ("def show(found): return [Part('x', '', ['y'])]", "Dozens", "(TypeError: str, not a block"),
    "its figure ends the process": ("def draw(found): raise SystemExit('enough')", "Figure strange.dozens-drawn",
                                    "SystemExit: enough"),
    "its rows are alike": ("def rows(study): yield from [study.cells[0].estimate('strange.dozens')] * 2", "Dozens",
                           "ValueError: two rows are of strange.dozens"),
    "its number is called as another": ("def rows(study): yield study.cells[0].estimate('success', 1.0)", "Dozens",
                                        "(ValueError: its quantities and facts begin with strange., unlike 'success')"),
    "its number is called as one of other studies": (
        "def rows(study): yield study.cells[0].estimate('success_in_grid', 1.0)", "Dozens",
        "(ValueError: its quantities and facts begin with strange., unlike 'success_in_grid')"),
    "its number is called as a measure": ("def rows(study): yield study.cells[0].estimate('measures.untold', 1.0)",
                                          "Dozens", "begin with strange., unlike 'measures.untold')"),
    "its fact is about an agent": ("def rows(study): yield Fact(about='random', name='x', text='y')", "Dozens",
                                   "(ValueError: its quantities and facts begin with strange., unlike 'random')"),
    "its sentence is one of another": ("def rows(study): yield Finding(section='grids', kind='answer', text='!')",
                                       "Dozens", "(ValueError: its rows are of the section strange.dozens, not of 'grids')"),
    "its part raises": ("def show(found): 1 / 0", "Dozens", "(ZeroDivisionError: division by zero)"),
    "its table is no text": ('def cells(found): return [["agent", "dozens"], ["random", 1]]', "Table strange.dozens",
                             "TypeError: expected 2 cells of text in every row of table strange.dozens, not ['random', 1]"),
    "its figure cannot be drawn": ("def draw(found): 1 / 0", "Figure strange.dozens-drawn", "ZeroDivisionError: division by"),
}  # fmt: skip
"""What is wrong -> a function instead of that of the module, or lines at its end; what is left out, and why."""


@pytest.mark.parametrize("wrong", WRONG)
def test_a_broken_one_leaves_the_report_whole_and_is_named(tmp_path, monkeypatch, study, alone, drawn, wrong):
    text, name, reason = WRONG[wrong]
    place = "TABLE =" if text.startswith("def ") else "# the end"
    install(tmp_path / "package", monkeypatch, TEXT.replace(place, f"{text}\n\n{place}"))
    told = []
    with drawn("strange.dozens-drawn"):
        page = write_report(study, left_out=told.append).read_text("utf-8")
    assert {(one.section, one.source) for one in told} == {(name, PACKAGE)}
    assert reason in told[0].reason
    found = Results.model_validate_json((study / "results.json").read_bytes())
    assert [(one.section, one.reason) for one in found.sections_left_out] == [(name, told[0].reason)]
    assert f"<li>{name} (" in page
    assert whole(found) == alone
    assert all(check.holds for check in verify(study))


def test_a_measure_with_the_name_of_a_number_of_lockprobe_is_told_apart(tmp_path, monkeypatch, study, alone):
    install(tmp_path / "package", monkeypatch, strangers.WORKING, {"measures": {"steps": "untold"}})
    write_report(study)
    found = Results.model_validate_json((study / "results.json").read_bytes())
    assert found.sections_left_out == ()
    assert [row.quantity for row in found.measures] == ["measures.steps"] * 2
    assert whole(found) == alone
    assert all(check.holds for check in verify(study))


def test_no_row_of_a_package_enters_what_lockprobe_shows(study):
    """Not even one that has the name of a row of ours, in the file of somebody who made it up."""
    found = results(study)
    doubled = found.with_rows(
        again
        for kind in (found.rows, found.curves, found.findings, found.facts, found.exhibits)
        for row in kind
        for again in (row.model_copy(update={"source": "strange", "text": "made up", "value": 0.5}), row)
    )
    assert len(doubled.rows) == 2 * len(found.rows) > 100
    assert tables_of(doubled) == tables_of(found)
    for page in PAGES:
        if parts_of(found, page):
            assert page_of(page, doubled) == page_of(page, found)


def test_no_name_of_lockprobe_has_a_point(study):
    """So none can be that of a package, whose names all have one."""
    found = results(study)
    names = [name for one in own_sections() for name in one.names]
    names += [part.name for page in PAGES for part in parts_of(found, page)]
    names += [row.quantity for row in (*found.rows, *found.curves)] + [row.section for row in found.findings]
    assert len({*names}) > 100
    assert not [name for name in names if "." in name]


FAULTS = {
    "names of packages are like latecomer.silence, unlike 'speed'": {"name": "speed"},
    "strange.dozens: its rows change":
        {"rows": lambda study, calls=[]: calls.append(1) or [study.cells[0].estimate("strange.d", len(calls))]},
    "strange.dozens: its quantities and facts begin with strange., unlike 'success'":
        {"rows": lambda study: [cell.estimate("success", 1.0) for cell in study.cells]},
    "strange.dozens shows nothing of any study": {"show": lambda found: ()},
}  # fmt: skip


@pytest.mark.parametrize("said", FAULTS)
def test_the_contract_says_what_is_wrong(tmp_path, monkeypatch, said):
    install(tmp_path / "package", monkeypatch)
    import strange

    check_section(strange.SECTION)
    with pytest.raises(AssertionError, match=said):
        check_section(strange.Section(**strange.GIVEN | FAULTS[said]))
