"""What agents saw: the page shows the pictures that are there, small, and says so where none is."""

import base64

import numpy as np
from builders import modality_study, small_study, write_study
from reported import found_in

from lockprobe.report.page import page_of
from lockprobe.report.questions.seen import embedded
from lockprobe.report.rows import Fact, Results
from lockprobe.report.write import write_report
from lockprobe.trial.pictures.png import from_png, to_png


def test_the_report_holds_small_copies_of_the_pictures(tmp_path, modal, picture_names):
    path = write_study(tmp_path / "study", modality_study(), modal)
    (path / "pictures").mkdir()
    rng = np.random.default_rng(0)
    for name in picture_names[:6]:
        shape = (480, 640) if name in (picture_names[3], picture_names[5]) else (480, 640, 3)
        kind = np.uint16 if len(shape) == 2 else np.uint8
        (path / "pictures" / name).write_bytes(to_png(rng.integers(0, 255, shape).astype(kind)))
    page = write_report(path).read_text("utf-8")
    assert "The higher the fidelity of what viewer sees, the later or more rarely it solves" in page
    assert page.count("data:image/png;base64,") == 6
    assert len(page) < 3_000_000
    assert "Success and false reports" not in page


def test_pictures_are_shown_with_what_was_told_and_without_their_files_the_page_says_why(
    tmp_path, modal, picture_names
):
    found = found_in(tmp_path, modality_study(trials=2), [trial for trial in modal if trial.trial <= 2])
    page = page_of(found, photographs={name: f"data:{name}" for name in picture_names})
    assert page.count("Told: “”") == 4
    assert page.count("<img src=") == 6
    assert f'<img src="data:{picture_names[2]}" alt="The box before the first step">' in page
    assert "After step 1: revolute-left did not move." in page
    assert "No pictures are shown" not in page
    without = page_of(found)
    assert "No pictures are shown: the files, or the package pillow, are missing." in without


def test_nothing_is_said_where_no_agent_saw_pictures(tmp_path):
    found = found_in(tmp_path, small_study(["random"], (0.0,), 1, 2))
    assert '<details class="section" id="seen">' not in page_of(found)
    assert "With pictures" not in page_of(found)


def saw(*files):
    """Results in which a picture of each of these kinds and names was seen."""
    facts = [Fact(about=f"seen rgb {i}", name=kind, text=name) for i, (kind, name) in enumerate(files, 1)]
    return Results.model_construct(facts=facts)


def shown_small(directory, name, kind, pixels):
    """A picture as a page would show it."""
    (directory / "pictures").mkdir(exist_ok=True)
    (directory / "pictures" / name).write_bytes(to_png(pixels))
    found = embedded(directory, saw((kind, name)))
    assert list(found) == [name]
    return from_png(base64.b64decode(found[name].partition(",")[2]))


def test_no_picture_is_shown_that_only_the_record_needs(tmp_path, modal, picture_names):
    shown = [fact for fact in found_in(tmp_path, modality_study(), modal).facts if fact.about.startswith("seen ")]
    found = {fact.about: {one.name: one.text for one in shown if one.about == fact.about} for fact in shown}
    assert list(found) == ["seen rgb", "seen rgb 1", "seen rgb 2", "seen rgbd", "seen rgbd 1", "seen rgbd 2"]
    assert found["seen rgb"] == {"trial": modal[0].key}
    assert found["seen rgb 2"]["when"] == "after step 1: revolute-left did not move"
    names = [picture_names[i] for i in (0, 1, 0, 2, 1, 4)]
    kinds = ("rgb", "rgb", "rgb", "depth", "rgb", "depth")
    pictures = [(fact.name, fact.text) for fact in shown if fact.name in kinds]
    assert pictures == list(zip(kinds, names, strict=True))


def test_pictures_that_are_lost_or_lie_elsewhere_are_left_out(tmp_path, picture_names):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "secret.png").write_bytes(to_png(np.zeros((8, 8), np.uint8)))
    (tmp_path / "pictures" / picture_names[1]).write_bytes(b"torn")
    found = saw(*(("rgb", name) for name in ("../secret.png", *picture_names[:2])))
    assert embedded(tmp_path, found) == {}


def test_colours_are_made_small_by_averaging(tmp_path, picture_names):
    even = np.full((301, 700, 3), 9, np.uint8)
    even[:, ::3] = 12
    small = shown_small(tmp_path, picture_names[0], "rgb", even)
    assert small.shape == (100, 233, 3)
    assert (small == 10).all()


def test_depth_is_made_small_without_making_new_codes(tmp_path, picture_names):
    """Codes of depth that alternate: their mean would be that of another depth."""
    pixels = np.zeros((480, 640, 3), np.uint8)
    pixels[..., 0], pixels[..., 2] = 4, 248
    pixels[::2, ::3, 0], pixels[::2, ::3, 2] = 8, 0
    small = shown_small(tmp_path, picture_names[2], "depth", pixels)
    assert small.shape == (240, 320, 3)
    assert {tuple(code) for code in small.reshape(-1, 3).tolist()} <= {(4, 0, 248), (8, 0, 0)}
    grey = shown_small(tmp_path, picture_names[2], "depth", pixels[..., 0])
    assert grey.shape == (240, 320)
