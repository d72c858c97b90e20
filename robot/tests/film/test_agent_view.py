"""What an agent saw, out of the pictures that a study keeps."""

from dataclasses import replace

import numpy as np
import pytest
from lockprobe_robot.film.agent_view import film_seen
from lockprobe_robot.film.caption import HEIGHT, WIDTH
from painted import painted_twins
from PIL import Image

from lockprobe import run_trial
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.testing import ScriptedAgent


@pytest.fixture
def trial(monkeypatch, tmp_path):
    painted_twins(monkeypatch)
    return run_trial(
        agent=ScriptedAgent(joints=(3, 2, 1, 0)), plant="fast-twin?width=320&height=240", modality="rgbd", shuffle="never",
        pictures=tmp_path / "pictures",
    )  # fmt: skip


def test_it_shows_every_picture_that_was_shown_beside_its_depth(trial, tmp_path):
    film = film_seen(trial, tmp_path / "pictures", tmp_path / "film")
    shown = [np.asarray(Image.open(one)) for one in sorted(film.path.iterdir())]
    assert trial.solved
    assert len(shown) == film.pictures == 5
    assert {one.shape for one in shown} == {(240 + HEIGHT, WIDTH, 3)}
    names = [trial.opening_pictures, *(step.pictures for step in trial.steps)]
    for one, kinds in zip(shown, names, strict=True):
        colours = np.asarray(Image.open(tmp_path / "pictures" / kinds["rgb"]))
        assert (one[:240, :320] == colours).all()
        assert (one[:240, 320:] == np.asarray(Image.open(tmp_path / "pictures" / kinds["depth"]).convert("RGB"))).all()


def test_what_is_not_there_is_said_in_one_line(trial, tmp_path):
    out = tmp_path / "a.gif"
    with pytest.raises(BadValue, match="expected one in which pictures were seen"):
        film_seen(replace(trial, opening_pictures={}), tmp_path / "pictures", out)
    with pytest.raises(BadFile, match="cannot be read"):
        film_seen(trial, tmp_path, out)
    stray = replace(trial, opening_pictures={"rgb": "../../etc/passwd"})
    with pytest.raises(BadFile, match="no name of a picture"):
        film_seen(stray, tmp_path / "pictures", out)
    assert not out.exists()
