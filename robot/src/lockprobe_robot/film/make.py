"""``lockprobe replay --out``: a film of a trial of a study, played again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.spec import Spec
from lockprobe.studies.records.directory import read_study
from lockprobe.trial.record import Trial
from lockprobe_robot.film.replay import STAND_IN, WITHOUT_ARM, Film, film_trial, plan_of

_NO_MOTION = "A force pushed the model: the film shows it before and after each attempt."


def make_film(directory: Path, trial: Trial, path: Path, *, speed: int, tell: Callable[[str], None]) -> Film:
    """Film a trial of a study.

    Args:
        directory: The study's directory.
        trial: The record.
        path: The film: ``.gif``, ``.mp4``, or a directory for the pictures.
        speed: Speed-up of a robot's motion, a factor of 1 to 16.
        tell: Called with one line after every step that is played again.

    Raises:
        UserMistake: If the trial cannot be filmed here.
        TrialFault: If it breaks when it is played again.
    """
    study = read_study(directory)
    plan = plan_of(study, trial)
    film = film_trial(trial, plan, path, speed=speed, tell=tell)
    if "model" in Spec.parse(film.plant, "plant").options:
        return replace(film, note=_NO_MOTION)
    if film.plant not in (STAND_IN, WITHOUT_ARM) or plan.plant == film.plant:
        return film
    why = "The trial was played without physics" if plan.plant == "symbolic" else f"{plan.plant} has no film"
    arm = "an arm" if film.plant == STAND_IN else "a force, as the arm does not reach all handles,"
    return replace(film, note=f"{why}; the film shows {arm} at work on a twin.")
