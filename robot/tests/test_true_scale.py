"""A sheet on paper has its size in millimetres."""

import re

import numpy as np
import pytest
from lockprobe_robot.true_scale import A3, A4, RULER, draw_ruler, larger_than, sheet, true_scale_file


def svg_sides(file):
    return [float(re.search(rf'<svg[^>]* {side}="([\d.]+)mm"', file.decode())[1]) for side in ("width", "height")]


def test_both_forms_have_the_size_of_the_sheet():
    figure, _ = sheet(123.4, 56.7)
    assert svg_sides(true_scale_file(figure, "svg")) == [123.4, 56.7]
    page = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", true_scale_file(figure, "pdf"))
    np.testing.assert_allclose([float(side) * 25.4 / 72 for side in page.groups()], [123.4, 56.7], atol=0.01)


@pytest.mark.parametrize(("upright", "end"), [(False, (20 + RULER, 30)), (True, (20, 30 + RULER))])
def test_the_ruler_is_100_mm_in_both_directions(upright, end):
    figure, axes = sheet(200, 200)
    draw_ruler(axes, 20, 30, upright=upright)
    (line,) = (line for line in axes.lines if line.get_gid() == "ruler")
    on_paper = axes.transData.transform(line.get_xydata()) / figure.dpi * 25.4
    np.testing.assert_allclose(on_paper, [(20, 30), end], atol=1e-6)


def test_paper_may_be_turned():
    assert not larger_than(A4, A3)
    assert not larger_than((297, 420), A3)
    assert not larger_than(A3, A3)
    assert larger_than((421, 100), A3)
    assert larger_than((298, 298), A3)
