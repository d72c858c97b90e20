"""What agents saw: the page shows the pictures that are there, small, and says so where none is."""

import base64

import numpy as np
from builders import modality_study, write_study
from page_parts import part
from reported import found_in

from lockprobe.report.page import Page
from lockprobe.report.questions.trials import embedded
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
    assert page.count("data:image/png;base64,") == 6
    assert len(page) < 3_000_000


def test_pictures_for_agents_are_shown_with_what_was_told_and_a_page_without_files_says_why(
    tmp_path, modal, picture_names
):
    found = found_in(tmp_path, modality_study(trials=2), [trial for trial in modal if trial.trial <= 2])
    kinds = [(fact.name, fact.text) for fact in found.facts if fact.name in ("rgb", "depth", "depth16")]
    names = [picture_names[i] for i in (0, 1, 0, 2, 1, 4)]  # those that only the record needs are left out
    assert kinds == list(zip(("rgb", "rgb", "rgb", "depth", "rgb", "depth"), names, strict=True))
    shown = part(Page(found=found, photographs={name: f"data:{name}" for name in picture_names}).text(), "seen")
    assert shown.count("Told: “”") == 4
    assert shown.count("<img src=") == 6
    assert f'<img src="data:{picture_names[2]}" alt="The box before the first step">' in shown
    assert "After step 1: revolute-left did not move." in shown
    missing = "No pictures are shown: the files, or the package pillow, are missing."
    assert missing in part(Page(found=found).text(), "seen")
    assert missing not in shown


def shown_small(directory, pixels, kind="rgb", name=f"{1:020x}.png"):
    """A picture as a page would show it; None if it shows none."""
    (directory / "pictures").mkdir(exist_ok=True)
    (directory / "pictures" / name).write_bytes(to_png(pixels) if pixels is not None else b"torn")
    facts = [Fact(about="seen rgb 1", name=kind, text=name)]
    found = embedded(directory, Results.model_construct(facts=facts)).get(name)
    return found and from_png(base64.b64decode(found.partition(",")[2]))


def test_colours_are_averaged_and_depth_gets_no_new_codes(tmp_path):
    """Codes of depth that alternate: their mean would be that of another depth."""
    even = np.full((301, 700, 3), 9, np.uint8)
    even[:, ::3] = 12
    small = shown_small(tmp_path, even)
    assert small.shape == (100, 233, 3)
    assert (small == 10).all()
    pixels = np.zeros((480, 640, 3), np.uint8)
    pixels[..., 0], pixels[..., 2] = 4, 248
    pixels[::2, ::3, 0], pixels[::2, ::3, 2] = 8, 0
    small = shown_small(tmp_path, pixels, "depth")
    assert small.shape == (240, 320, 3)
    assert {tuple(code) for code in small.reshape(-1, 3).tolist()} <= {(4, 0, 248), (8, 0, 0)}
    assert shown_small(tmp_path, pixels[..., 0], "depth").shape == (240, 320)
