"""A film says what it does not show."""

from types import SimpleNamespace

import pytest
from lockprobe_robot.film import make
from lockprobe_robot.film.replay import Film
from mjcf_models import OWN


@pytest.mark.parametrize(
    ("played", "shown", "note"),
    [
        ("twin", "twin", ""),
        ("fast-twin", "fast-twin", ""),
        (
            "symbolic",
            "twin",
            "The trial was played without physics; the film shows an arm at work on a twin.",
        ),
        (
            "python:a:B",
            "fast-twin",
            "python:a:B has no film; the film shows a force, as the arm does not reach all handles, at work on a twin.",
        ),
        (f"twin?model={OWN}", None, make._NO_MOTION),
        (f"twin?force=20&model={OWN}", None, make._NO_MOTION),
    ],
)
def test_what_a_film_shows_in_the_place_of_a_plant_is_said(played, shown, note, tmp_path, monkeypatch):
    film = Film(path=tmp_path, pictures=1, plant=shown or played, differs=None)
    monkeypatch.setattr(make, "read_study", lambda directory: None)
    monkeypatch.setattr(make, "plan_of", lambda study, trial: SimpleNamespace(plant=played))
    monkeypatch.setattr(make, "film_trial", lambda *given, **named: film)
    assert make.make_film(tmp_path, None, tmp_path / "a.gif", speed=1, tell=print).note == note
