"""Several boxes on the page: of what its intervals are, each box alone, and whether effects differ."""

import pytest
from reported import found_in, tables_of

from lockprobe.report.questions.boxes import SECTIONS
from lockprobe.studies.options.studyfile import study


@pytest.fixture(scope="module")
def six(tmp_path_factory):
    boxes = ",".join(f"random-4-{seed}" for seed in (2, 7, 8, 16, 18, 19))
    asked = {"agent": ["cognitive:perseverant", "random"], "p": [0, 0.6], "strategy_trials": 10}
    return found_in(tmp_path_factory.mktemp("six"), study("flips", box=boxes, **asked))


def test_each_box_has_its_share_and_its_change_and_the_change_over_boxes_is_their_mean(six):
    of = {"agent": "cognitive:perseverant", "condition": "flip?p=0.6"}
    names = [one["name"] for one in six.boxes]
    changes = [six.one("success_difference", **of, control="truth", axis="", of=name) for name in names]
    shares = [six.one("success", **of, of=name) for name in names]
    whole = six.one("success_difference", **of, axis="flip rate")
    assert whole.value == pytest.approx(sum(row.value for row in changes) / 6)
    assert six.one("success", **of).value == pytest.approx(sum(row.value for row in shares) / 6)
    assert [row.n for row in changes] == [10] * 6
    assert whole.low < whole.value < whole.high
    between = six.one("success_difference", **of, control="truth", axis="", of="SD between boxes")
    assert (between.clusters, between.n) == (6, 60)
    assert [row[1] for row in tables_of(six)["boxes"][1:7]] == names


def test_where_all_else_holds_at_every_look_the_page_says_that_single_boxes_do_not(six):
    every = six.changed(progress=six.progress.model_copy(update={"every_look": "extended"}))
    said = [" ".join(map(str, part.blocks)) for found in (six, every) for part in SECTIONS[0].show(found)]
    assert ["Numbers of a single box hold for one look" in one for one in said] == [False, True]
