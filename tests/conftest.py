"""Tests say the same whoever starts them."""

import fcntl
import gc
import os
import pickle
import signal
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import forked
import pytest
from _pytest.doctest import DoctestModule
from hypothesis import settings

# Advice for a missing package is that for pip, also under ``uv run``.
os.environ.pop("UV_RUN_RECURSION_DEPTH", None)

# A job in the background ignores Ctrl-C, and so would the commands that tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# How long an example takes says how busy the machine is.
settings.register_profile("any machine", deadline=None, database=None, max_examples=40)
settings.load_profile("any machine")

# Several workers share the cores: threads of each that wait for more work by spinning only take them away.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Providers in tests are on loopback, without TLS: a client need not read all certificates of the machine, twice.
os.environ["SSL_CERT_FILE"] = str(Path(__file__).with_name("certificate.pem"))

gc.disable()  # until all is collected

ROOMS = Path(__file__).parent

QUICK = ("boxes", "foundation", "interventions", "trial")
"""Rooms of logic alone: no server, no browser, no model, no simulation. ``pytest -m quick`` runs these."""


SLOW = {
    "test_a_kernel_plays_what_the_policy_plays": (),
    "test_a_kernel_runs_the_first_notebook": (),
    "test_a_kernel_with_a_backend_that_is_not_there_runs_the_lesson": (),
    "test_a_model_that_is_asked_and_one_that_is_not_leave_each_others_trials_alone": (),
    "test_a_quotation_holds": ("all four readings, 0.5 among them",),
    "test_a_simulated_plant_gives_the_same_on_one_process_and_on_two": (),
    "test_a_strategy_at_the_page_plays_as_without_it": ("six joints", "clicks", "touch, outcomes only, unasked"),
    "test_a_modality_more_changes_no_p_value_of_another": (),
    "test_an_agent_with_rare_long_trials_is_not_called_faster": ("100-100-0.022", "100-60-0.037", "20-30-0.05"),
    "test_characters_are_helped_hurt_and_both": (),
    "test_counted_numbers_give_the_exact_distribution": (
        "human-inspired-chain-4-0.3-independent",
        "human-inspired?lapse=0.2-reset-0.5-outcome-only",
    ),
    "test_each_command_prints_what_the_answer_sheet_shows": (),
    "test_equivalence_is_wrong_in_at_most_five_percent": ("0.2-30", "0.1-29", "0.05-30"),
    "test_every_condition_is_shown_as_it_acts": (),
    "test_every_decision_is_what_the_model_itself_replied": (),
    "test_every_number_of_an_answer_was_printed_before": (),
    "test_every_part_of_it_changes_the_picture_and_no_luck_of_depth": (),
    "test_every_scene_on_a_phone_and_read_aloud": ("German", "eight joints", "pictures"),
    "test_tests_that_we_conclude_from_keep_their_error_rate": (),
    "test_the_first_study": (),
    "test_the_sentences_and_figures_of_the_answer_sheet_are_in_the_reports": (),
    "test_every_text_is_large_enough_inside_and_touches_no_other": ("strategies", "hostile names", "thirty p"),
    "test_forks_estimate_the_exact_effect_of_one_lie": (),
    "test_gymnasium_finds_nothing_to_say_against_the_physical_box": (),
    "test_it_detects_in_the_trials_of_a_study_what_the_report_detects": (),
    "test_it_tells_which_agents_rise_which_fall_and_which_do_both": (),
    "test_killed_at_random_moments_forks_are_not_lost_and_nothing_is_asked_twice": (),
    "test_killed_at_random_moments_it_decides_the_same_and_buys_nothing_twice": (),
    "test_many_browsers_at_once_and_the_server_is_killed_meanwhile": (),
    "test_no_interval_of_the_differences_leaves_out_the_truth": (),
    "test_of_ten_agents_some_verdict_is_false_in_at_most_5_percent_of_studies": ("a change of the margin",),
    "test_no_command_runs_what_a_directory_or_a_file_names": ("replay-plant",),
    "test_several_processes_change_no_byte": (),
    "test_shares_cover_the_truth_and_no_effect_is_found_where_there_is_none": (
        "failures break-2000",
        "successes break-2000",
        "opposed-2000",
        "failures break everywhere-2000",
    ),
    "test_the_same_seed_gives_the_same_record_whatever_was_played_before": (),
    "test_the_user_s_settings_change_no_byte_of_any_figure": (),
    "test_trials_of_the_loop_come_to_the_same": (),
    "test_two_worker_processes_write_the_records_of_one": (),
    "test_very_many_take_part_at_once": (),
    "test_what_is_odd_comes_to_the_same_in_the_loop": (
        "truth",
        "flip?p=0.4",
        "distract?p=0.4&luck=flip",
        "distract?p=0.4",
        "correction?p=0.4",
        "drop?p=0.4&luck=flip",
    ),
    "test_what_a_blind_agent_may_still_heed_is_bounded": (
        "False-0.05",
        "False-0.02",
        "True-0.02",
        "False-0.3",
        "True-0.2",
        "False-0.2",
    ),
    "test_what_was_said_of_the_size_of_requests_holds_for_the_models_own_count": (),
    "test_where_plants_have_cameras_only_so_many_trials_are_held": (),
}
"""Tests that hold at length, or by simulation, what shorter ones hold too: each with its slow cases, or with all."""


def _is_slow(item):
    name, _, case = item.name.partition("[")
    return name in SLOW and (not SLOW[name] or case.removesuffix("]") in SLOW[name])


@cache
def _is_quick(path):
    return path.is_relative_to(ROOMS) and path.relative_to(ROOMS).parts[:1] in [(room,) for room in QUICK]


def pytest_configure(config):
    """Before workers start: one interpreter imports what commands need, for all of them, while they collect."""
    if (
        getattr(config.option, "numprocesses", None)
        and config.option.markexpr != "quick"
        and forked.SHARED not in os.environ
    ):
        forked.share()


def pytest_ignore_collect(collection_path, config):
    """Modules of the package are imported for their examples, if they hold any.

    Where only quick tests are asked for, nothing else is imported: that takes longer than they do.
    """
    if not collection_path.is_file():
        return None
    if config.option.markexpr == "quick" and not _is_quick(collection_path):
        return True
    if collection_path.suffix == ".py" and not collection_path.is_relative_to(ROOMS):
        return ">>>" not in collection_path.read_text("utf-8") or None
    return None


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """In a fresh clone one worker compiles all modules and the others wait: each would take twenty seconds for them."""
    compiled = ROOMS / "__pycache__"
    with ExitStack() as alone:
        if "PYTEST_XDIST_WORKER" in os.environ and compiled.is_dir():
            fcntl.flock(alone.enter_context((compiled / "collecting.lock").open("w")), fcntl.LOCK_EX)
            if any(compiled.glob("test_*.pyc")):
                alone.close()
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path):
    """Docstrings of tests hold no examples: only those of the package are looked through."""
    found = yield
    return [part for part in found if not (isinstance(part, DoctestModule) and file_path.is_relative_to(ROOMS))]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Tests in a browser come first: they mostly wait, and at the end nothing else would be left to do meanwhile."""
    items.sort(key=lambda item: not item.path.is_relative_to(ROOMS / "people" / "web"))
    for item in items:
        if _is_quick(item.path):
            item.add_marker(pytest.mark.quick)
        if _is_slow(item):
            item.add_marker(pytest.mark.slow)


def pytest_collection_finish():
    """What was imported and collected stays to the end: the collector need not look through it again and again."""
    gc.collect()
    gc.freeze()
    gc.enable()
    gc.set_threshold(50_000, 20, 20)  # thousands of trials are made here, and few objects in circles


@pytest.fixture(scope="session")
def once(tmp_path_factory):
    """``once(name, make)``: what ``make`` gives, made by the first of all workers that asks for this name."""
    shelf = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        shelf = shelf.parent  # the folder of the whole run

    def had(name, make):
        kept = shelf / f"{name}.pickle"
        with kept.with_suffix(".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not kept.exists():
                kept.write_bytes(pickle.dumps(make()))
        return pickle.loads(kept.read_bytes())

    return had
