"""What agents saw: the page shows the pictures that are there, and says so where none is."""

import pytest
from builders import modality_study, small_study, write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers


@pytest.fixture
def found(tmp_path, modal):
    trials = [trial for trial in modal if trial.trial <= 2]
    return results_of(study_numbers(open_study(write_study(tmp_path / "study", modality_study(trials=2), trials))))


def test_pictures_of_each_modality_are_shown_with_what_was_told(found, picture_names):
    page = page_of("report", found, photographs={name: f"data:{name}" for name in picture_names})
    assert page.count("Told: “”") == 4
    assert page.count("<img src=") == 6
    assert f'<img src="data:{picture_names[2]}" alt="The box before the first step">' in page
    assert "After step 1: revolute-left did not move." in page
    assert "No pictures are shown" not in page


def test_without_their_files_the_page_says_why_there_are_none(found):
    page = page_of("report", found)
    assert "No pictures are shown: the files, or the package pillow, are missing." in page
    assert "With pictures, “told” is what they show." in page_of("details", found)


def test_nothing_is_said_where_no_agent_saw_pictures(tmp_path):
    path = write_study(tmp_path / "study", small_study(["random"], (0.0,), 1, 2))
    found = results_of(study_numbers(open_study(path)))
    assert '<details class="section" id="seen">' not in page_of("report", found)
    assert "With pictures" not in page_of("details", found)
