"""Figures of success by step show the curves, areas and reference values of the results."""

from itertools import pairwise

import pytest
from drawn import bars, labelled, lines, published, shades, staircases

from lockprobe.report.figures.success_by_step import success_curves, success_curves_by_p, success_curves_corrected
from lockprobe.report.rows import Condition, Design


def curves_of(course):
    return [cell.curve("success_by_step") for cell in course.cells]


def without(found, condition):
    """The results without a condition."""
    kept = {kind: [row for row in getattr(found, kind) if row.condition != condition] for kind in ("rows", "curves")}
    return found.changed(**kept)


def test_staircases_are_the_success_curves_without_bands(typical):
    (axes,) = success_curves(typical).axes
    for course, line in zip(typical.courses(), staircases(axes), strict=True):
        assert line.get_label() == course.agent
        assert tuple(line.get_ydata()[:-1]) == curves_of(course)[0].value
        assert tuple(line.get_xdata()[:-1]) == tuple(range(21))
        assert line.get_ydata()[-1] == line.get_ydata()[-2]
    assert not axes.collections
    assert "true reports; n = 30 trials" in axes.get_title(loc="left")


def test_the_papers_steps_are_hollow_stars(typical):
    assert published(*success_curves(typical).axes) == ([(9.0, 0.8), (11.0, 0.8), (15.0, 0.8)], ["the paper"])


def test_agents_with_different_numbers_of_trials_keep_the_stars(typical):
    first = curves_of(typical.courses()[0])[0]
    fewer = [one.model_copy(update={"n": 7}) if one is first else one for one in typical.curves]
    (axes,) = success_curves(typical.changed(curves=fewer)).axes
    assert len(published(axes)[0]) == 3
    assert f"{first.agent},\n$p$ = 0, n = 7" in [line.get_label() for line in staircases(axes)]


def test_without_the_lowest_p_there_are_no_stars(typical):
    (axes,) = success_curves(without(typical, "truth")).axes
    assert published(axes) == ([], [])
    assert "flip rate 0.1" in axes.get_title(loc="left")
    first = curves_of(typical.courses()[0])[0]  # one agent alone without p = 0
    (axes,) = success_curves(typical.changed(curves=[one for one in typical.curves if one is not first])).axes
    assert published(axes) == ([], [])


def test_curves_stand_beside_the_exact_ones(typical):
    axes, _ = success_curves_corrected(typical).axes
    exact = [typical.curve("success_by_step", of=of) for of in ("uniform", "no-repeat")]
    drawn = [tuple(line.get_ydata()[:-1]) for line in staircases(axes)]
    assert drawn == [one.value for one in (*(curves_of(course)[0] for course in typical.courses()), *exact)]
    assert [line.get_linestyle() for line in staircases(axes)[-2:]] == [":", "--"]
    assert labelled(axes, "shortest plan: 4 steps")[0] == [4, 4]
    (band,) = shades(axes)
    curve, *_ = curves_of(typical.courses()[0])
    assert band >= set(enumerate(curve.low)) | set(enumerate(curve.high))


def test_without_references_there_are_curves_alone(typical):
    agents = typical.changed(
        rows=[row for row in typical.rows if row.quantity not in {"optimum", "relative_area"}],
        curves=[curve for curve in typical.curves if curve.agent],
    )
    (axes,) = success_curves_corrected(agents).axes
    assert len(lines(axes)) == len(staircases(axes)) == len(typical.courses())


def test_areas_between_chance_and_the_shortest_plan(typical):
    _, axes = success_curves_corrected(typical).axes
    found = [course.cells[0].get("relative_area") for course in typical.courses()]
    places, *numbers = zip(*bars(axes, across=True), strict=True)
    assert numbers == [pytest.approx([getattr(one, end) for one in found]) for end in ("value", "low", "high")]
    assert sorted(places) == list(places)
    assert [x.tolist() for x, _ in lines(axes)[4:]] == [[0, 0], [1, 1]] * 4
    assert [text.get_text() for text in axes.texts][::2] == [course.agent for course in typical.courses()]
    assert f"{found[0].value:.2f} [" in axes.texts[1].get_text()
    low, high = axes.get_xlim()
    assert low < min(0, *(relative.low for relative in found))
    assert high > max(1, *(relative.high for relative in found))


def test_a_curve_for_every_p(typical, model):
    (axes,) = success_curves_by_p(typical).axes
    assert [tuple(line.get_ydata()[:-1]) for line in staircases(axes)] == [curve.value for curve in curves_of(model)]
    names = {text.get_text(): text.get_position()[1] for text in axes.texts}
    assert set(names) == {f"$p$ = {cell.p:g}" for cell in model.cells}
    assert all(b - a > 0.079 for a, b in pairwise(sorted(names.values())))


def test_the_clearest_contrast_has_bands(typical, model):
    (axes,) = success_curves_by_p(typical).axes
    clearest = model.get("clearest_success_difference").doses["flip.p"]
    banded = [cell.curve("success_by_step") for cell in model.cells if cell.p in {0, clearest}]
    assert len(banded) == len(shades(axes)) == 2
    for band, curve in zip(shades(axes), banded, strict=True):
        assert band >= set(enumerate(curve.high)) | set(enumerate(curve.low))


def test_of_many_p_only_those_that_matter_are_named(studies):
    found = studies["thirty p"]
    axes, *_ = success_curves_by_p(found).axes
    assert len(staircases(axes)) == 30
    clearest = found.courses()[0].get("clearest_success_difference").doses["flip.p"]
    assert sorted(text.get_text() for text in axes.texts) == [f"$p$ = {p:g}" for p in (0, clearest, 1)]


@pytest.mark.parametrize("count", [13, 200])
def test_any_number_of_p_can_be_drawn(typical, model, count):
    names = {f"p{i}": i / count for i in range(count)}
    trials, curve = model.cells[0].get("trials"), model.cells[0].curve("success_by_step")
    many = typical.changed(
        rows=[trials.model_copy(update={"condition": name}) for name in names],
        curves=[curve.model_copy(update={"condition": name}) for name in names],
        design=Design(
            conditions=[Condition(name=name, modality=model.modality, p=p) for name, p in names.items()],
            players=[model.player],
        ),
    )
    figure = success_curves_by_p(many)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    assert axes.get_position().width > 0.4
    assert len(staircases(axes)) == count


def test_a_blind_agent_has_one_curve(studies):
    (place,) = (i for i, course in enumerate(studies["strategies"].courses()) if course.agent == "random")
    axes = success_curves_by_p(studies["strategies"]).axes[place]
    assert len(staircases(axes)) == 1
    assert [text.get_text() for text in axes.texts] == ["all $p$"]


def test_what_there_is_nothing_of_is_not_drawn(studies):
    for case, drawn in (("one p", [True, True, False]), ("errors", [False] * 3)):
        made = [draw(studies[case]) for draw in (success_curves, success_curves_corrected, success_curves_by_p)]
        assert [figure is not None for figure in made] == drawn
