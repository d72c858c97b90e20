"""A section that fails is left out with its reason, here and in jobs of other processes; elsewhere its error is raised."""

import pytest

from lockprobe.foundation.left_out import LeftOutSection, collecting, leaving_out, of_whom, section, without


def broken():
    raise ZeroDivisionError("division\nby zero")


def doubled(job):
    with of_whom(f"job {job}"):
        return section("Doubling", broken if job == 2 else lambda: 2 * job, lambda: -1)


def test_a_section_is_what_it_makes_and_one_that_fails_is_replaced_and_named():
    with leaving_out() as failed:
        assert section("Loops", lambda: 1, lambda: 2) == 1
        assert section("Loops", broken, lambda: 2) == 2
    assert failed == [LeftOutSection("Loops", "ZeroDivisionError: division by zero")]


def test_a_failure_that_comes_twice_is_named_once():
    with leaving_out() as failed:
        for _ in range(2):
            section("Loops", broken, lambda: None)
    assert len(failed) == 1


def test_where_nobody_collects_an_error_is_raised():
    with pytest.raises(ZeroDivisionError):
        section("Loops", broken, lambda: 2)
    assert list(collecting(map)(doubled, [1, 3])) == [2, 6]


def test_an_interrupt_ends_everything():
    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), leaving_out():
        section("Loops", interrupted, lambda: 2)


def test_what_fails_in_a_job_is_noted_where_jobs_are_given():
    """In another process a job cannot note it here: it is returned with the result."""
    with leaving_out() as failed:
        assert list(collecting(map)(doubled, [1, 2, 3])) == [2, -1, 6]
    assert failed == [LeftOutSection("Doubling of job 2", "ZeroDivisionError: division by zero")]


def test_a_reason_is_one_short_line():
    def long():
        raise ValueError("x" * 1000 + "\n\x1b[2J")

    with leaving_out() as failed:
        section("Loops", long, lambda: None)
    assert len(failed[0].reason) <= 200
    assert failed[0].reason.isprintable()


def test_the_line_on_a_report_names_three_sections_and_counts_the_others():
    many = [LeftOutSection(name, "ValueError: no") for name in "abcde"]
    assert without([]) == ""
    assert without(many) == (
        ", without a (ValueError: no); b (ValueError: no); c (ValueError: no) and 2 more sections, named on the page"
    )
