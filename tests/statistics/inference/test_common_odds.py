"""The common odds ratio of several tables: statsmodels' wherever it is defined."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from statsmodels.stats.contingency_tables import StratifiedTable

from lockprobe.statistics.inference.common_odds import CommonOdds, common_odds

counts = st.lists(st.tuples(*[st.integers(0, 30)] * 4).filter(any), min_size=1, max_size=12)


def tables(rows):
    """Tables of shape (2, 2, strata) from rows of four counts."""
    return np.array(rows, dtype=float).T.reshape(2, 2, -1)


@given(counts)
def test_ratio_and_error_are_those_of_statsmodels(rows):
    found = common_odds(tables(rows))
    products = [(a * d, b * c) for a, b, c, d in rows]
    if not any(crossed for _, crossed in products):
        assert found is None
    elif not any(across for across, _ in products):
        assert found == CommonOdds(ratio=0.0, log_error=None)
    else:
        library = StratifiedTable(tables(rows))
        assert found.ratio == pytest.approx(library.oddsratio_pooled, rel=1e-12)
        assert found.log_error == pytest.approx(library.logodds_pooled_se, rel=1e-12)


@given(counts)
def test_turned_tables_have_the_inverse_ratio_and_the_same_error(rows):
    found, turned = common_odds(tables(rows)), common_odds(tables(rows)[::-1])
    if found and turned and found.ratio and turned.ratio:
        assert found.ratio * turned.ratio == pytest.approx(1)
        assert found.log_error == pytest.approx(turned.log_error)


def test_one_table_has_the_error_of_woolf():
    found = common_odds(tables([(3, 7, 12, 5)]))
    assert found.ratio == pytest.approx(3 * 5 / (7 * 12))
    assert found.log_error**2 == pytest.approx(1 / 3 + 1 / 7 + 1 / 12 + 1 / 5)


def test_without_a_table_there_is_no_ratio():
    assert common_odds(np.zeros((2, 2, 0))) is None
