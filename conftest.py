"""Fixtures and hooks that the project's tests share."""

import gc
import os
import shutil
import signal
import sys
from collections import Counter
from pathlib import Path

import hypothesis
import nbgrader.api
import pytest

from grader.course.lessons import Lesson, every_lesson
from grader.sandbox import SANDBOXES, SandboxUnavailable, choose_sandbox
from tests.course_lessons import COURSE
from tests.prerequisites import RECORDINGS, demand_sandbox

MEMORY = Path("/dev/shm")
ENOUGH = 2**31  # bytes


def pytest_configure(config):
    """Put temporary files into memory, because gradebooks wait for the disk, and enable Ctrl-C.

    Some tests press Ctrl-C, which a process ignores if a script started it in the background.
    Hypothesis must not fail a test because the machine is busy.
    """
    hypothesis.settings.register_profile(
        "any speed", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
    )
    hypothesis.settings.load_profile("any speed")
    if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > ENOUGH:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish(session):
    """Exclude the collected tests from garbage collection, which took a tenth of the run."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000)


@pytest.fixture(autouse=True, scope="session")
def one_cache_of_statements():
    """Share the SQL statements that SQLAlchemy has compiled among all gradebooks of a process.

    SQLAlchemy caches them per engine, and each gradebook has its own engine.
    """
    create_engine, engines = nbgrader.api.create_engine, {}

    def create_engine_with_shared_cache(*arguments, **options):
        engine = create_engine(*arguments, **options)
        first = engines.setdefault(engine.dialect.name, engine)
        engine.dialect = engine.pool._dialect = first.dialect
        engine._compiled_cache = first._compiled_cache
        return engine

    nbgrader.api.create_engine = create_engine_with_shared_cache
    yield
    nbgrader.api.create_engine = create_engine


def pytest_unconfigure(config):
    """List below the summary what skipped tests need."""
    reporter = config.pluginmanager.getplugin("terminalreporter")
    if reporter is None:  # a worker of pytest-xdist
        return
    reasons = Counter(report.longrepr[2] for report in reporter.stats.get("skipped", ()))
    if reasons:
        reporter.write_line("Skipped, because these are missing:")
    for reason, count in reasons.most_common():
        reporter.write_line(f"{count:6}  {reason.removeprefix('Skipped: ')}")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """Start one process more than there are processors, as many tests wait for something."""
    return len(os.sched_getaffinity(0)) + 1


@pytest.fixture(scope="session")
def sandbox():
    """Sandbox that runs code in tests: bubblewrap, or a plain process if it is not available."""
    if os.environ.get("REQUIRE_SANDBOX") == "1":
        return demand_sandbox()
    try:
        return choose_sandbox()
    except SandboxUnavailable:
        return SANDBOXES["process"]


@pytest.fixture(scope="session")
def real_clouds():
    """Folder of real recordings, from REAL_CLOUDS; without it, tests that need it are skipped."""
    folder = os.environ.get("REAL_CLOUDS")
    if not folder:
        pytest.skip(RECORDINGS)
    return Path(folder)


@pytest.fixture(autouse=True)
def no_earlier_figures():
    """Close the figures of earlier tests, as some tests count open figures."""
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(autouse=True)
def unchanged_recursion_limit():
    """Restore the recursion limit, which stored answers run in this process may raise."""
    before = sys.getrecursionlimit()
    yield
    sys.setrecursionlimit(before)


# Tests with many parameters or a long run time. `make test` runs only the cases whose parameters
# begin with one of these texts; `make proof` runs all. Other tests run in both.
A_FEW_OF_MANY = {
    "test_solution_earns_everything_on_four_more_seeds": ("01",),
    "test_no_cheap_answer_earns_more_than_a_tenth": ("01",),
    "test_what_is_right_in_part_earns_its_part": (),
    "test_no_cheap_answer_is_one_edit_from_a_right_one": (),
    "test_an_edit_of_a_right_answer_loses_points_or_is_equivalent": (),
    "test_few_answers_lose_more_than_three_fifths_for_one_edit": (),
    "test_a_mistake_that_a_cheap_answer_makes_says_so": (),
    "test_an_endless_loop_does_not_need_a_process_for_each_edit": (),
    "test_a_slip_in_the_students_own_helper_is_a_slip": (),
    "test_a_slip_earns_the_share_that_a_teacher_would_give": ("line_through",),
    "test_keeps_the_class_waiting": ("stops",),
    "test_a_notebook_that_sleeps_everywhere_has_one_budget": (),
    "test_tells_another_notebook": ("locks files", "reads pages into memory, and asks for"),
    "test_a_cell_is_looked_at_once": ("brackets-", "blank lines"),
    "test_a_file_is_looked_at_once": ("brackets", "blank lines", "quotation"),
    "test_hands_in_everything_that_is_shown_as_the_answer_to_everything": ("08",),
    "test_claims_more_than_any_answer_has": ("three thousand",),
    "test_claims_something_huge_or_strange": ("a dict", "a number of thirty", "infin"),
    "test_spoils_every_argument_of_every_call": ("08",),
    "test_a_huge_claim_is_refused_at_once": ("a dict", "a la", "boxes", "dig", "dim", "many", "ne"),
    "test_a_function_that_ruins_its_arguments_loses_nothing_but_that": ("01", "08", "09"),
    "test_a_random_answer_earns_no_more_than_its_wrong_half": (),
    "test_takes_the_answer_from_somewhere": ("the points in a box, from the b", "the reference,"),
    "test_makes_the_question_fit_its_answer": ("finds nothing", "empties"),
    "test_changes_what_the_lesson_gives": ("a given class that is changed by name",),
    "test_reaches_for_the_judge": ("takes", "makes", "equals"),
    "test_tells_a_neighbours_secret_by_a_cell_that_fails": (
        "in the words",
        "in a name",
        "in a module that is missing",
        "in a line",
    ),
    "test_tells_a_neighbours_secret_by_an_answer": ("in values", "in a type"),
    "test_whoever_answers_otherwise_the_second_time_gains_nothing": (),
    "test_the_caller_of_a_wrong_function_can_also_be_repaired": (),
    "test_a_wrong_loop_stays_wrong_with_right_helpers": (),
    "test_what_shows_students_words_is_asked_before_any_hidden_question": ("02", "08", "12"),
    "test_no_variable_changes_a_verdict": ("PYTEST_ADDOPTS=-k",),
    "test_connected_components_are_allowed_in_10": (),
    "test_a_detector_made_of_the_lessons_functions_earns_everything": (),
    "test_messages_of_hidden_tests_hold_no_word_of_the_student": ("01", "08"),
    "test_a_local_cluster_of_processes": (),
    "test_unfit_workers_are_refused_and_named": (),
    "test_what_calls_a_wrong_helper_keeps_its_points": ("line_through-the",),
    "test_tells_in_other_lessons": ("08",),
    "test_the_references_process_a_real_frame": (),
    "test_real_frames_survive_every_encoding": (),
    "test_reports_wait_for_a_person_and_keep_their_marks": (),
    "test_a_run_killed_in_the_middle_loses_nothing": (),
    "test_a_worker_is_killed_and_another_joins_later": (),
    "test_killed_at_many_moments_the_same_command_ends_the_same": (),
    "test_stopped_or_killed_the_same_command_goes_on": (),
    "test_the_scheduler_is_lost_and_nothing_is_judged_twice": (),
    "test_a_course_from_release_to_export": (),
    "test_demo_grades_its_class": (),
    "test_a_full_disk_is_named_and_loses_nothing": ("3",),
    "test_clouds_of_every_size_are_drawn": ("some not finite",),
    "test_exercises_of_solved_lessons_work": ("01", "06"),
    "test_every_file_that_is_read_while_judging_is_in_the_key": ("09",),
    "test_every_imported_module_is_in_the_key": ("03", "12"),
    "test_a_right_loop_earns_everything_with_wrong_helpers": (),
    "test_notebooks_written_again_have_the_same_bytes": (),
    "test_a_gradebook_on_a_server": (),
    "test_many_files_of_any_content": (),
    "test_many_recordings_of_any_content": (),
    "test_a_solved_notebook_runs_and_agrees_with_the_stored_answers": (),
    "test_an_untouched_notebook_runs_to_the_end": (),
    "test_every_cell_below_a_wrong_answer_comes_to_its_end": (),
    "test_a_right_answer_to_a_lesson_shows_no_banner": (),
    "test_everything_that_a_lesson_allows_can_be_imported": (),
    "test_right_classes_earn_everything_in_the_judge": (
        "private helpers that call each other-in the cell",
        "a nested class for nodes, which do the work-in a new",
        "a subclass of the lesson's class-in the cell",
        "methods attached later-instead",
    ),
    "test_right_classes_pass_in_the_notebook": (
        "private helpers that call each other-instead",
        "data classes with a count and a cached property-in the cell",
    ),
    "test_a_verdict_adds_up": ("08",),
    "test_who_shares_the_processor_has_as_much_of_it_as_another": ("3",),
    "test_who_waits_for_threads_or_children_that_wait_for_a_processor_does_not_sleep": (),
    "test_at_least_a_hundred_attacks_exist": (),
    "test_who_works_too_long_is_given_up_on_a_crowded_machine_and_not_called_starved": (),
    "test_a_search_for_neighbours_earns_everything_in_05": ("scikit-learn's tree]", "SciPy"),
    "test_a_browser_obeys_none_of_them": (),
    "test_a_verdict_is_looked_at_once": (
        "brackets]",
        "spaces in",
        "environments]",
        "formulas that",
    ),
    "test_many_cells_are_looked_at_once": ("kinds1",),
    "test_markdown_is_looked_at_once": ("brackets]", "colours", "fences", "tags", "quotes"),
    "test_tells_a_hidden_question": (
        "in the cause",
        "in the name of an exception]",
        "with commands",
        "in a key",
        "in an assertion",
    ),
    "test_stopped_anywhere_new_work_never_has_the_time_of_old_work": ("us-T",),
    "test_refuses_without_the_right": ("sys_chroot", "setuid"),
    "test_has_no_right": ("becomes root]", "looks", "mounts", "makes a socket]", "makes a root"),
    "test_a_hostile_notebook_affects_only_its_author": ("brackets", "ifs", "long"),
    "test_nothing_that_crosses_tells_what_another_question_is_drawn_from": ("02", "03", "05", "08"),
    "test_the_class_goes_on": ("grader.lms",),
    "test_the_largest_file_is_read_or_refused_in_little_memory": ("<lambda>1",),
    "test_calls_itself_something_strange": ("not UTF-8", "markup of the web", "a folder", "two"),
    "test_nothing_of_it_is_in_memory_after_libraries_have_imported_it": ("05",),
    "test_whole_page_of_a_hostile_notebook_obeys_nothing": ("markdown",),
    "test_twenty_thousand_cells_that_all_define_the_exercise": (),
    "test_a_forbidden_module_inside_a_library_is_refused_in_05": ("a name in a library]",),
    "test_right_boxes_over_wrong_axes_earn_everything": ("ascending",),
    "test_every_known_mistake_runs_within_seconds": ("some",),
    "test_other_wrong_axes_cost_the_boxes_nothing": ("not centred",),
    "test_on_a_server_dates_are_the_same": (),
    "test_a_browser_fetches_nothing_for_a_page_and_draws_its_formulas": (),
    "test_slightly_wrong_answers_lose_points": ("3-",),
    "test_the_largest_cloud_crosses_as_a_list_of_rows": (),
    "test_principal_axes_are_what_makes_the_curve_fall": (),
    "test_naive_squares_are_many_on_road_and_on_the_own_car": (),
    "test_what_six_tenths_gain_is_one_stray_point": (),
    "test_the_list_of_all_pairs_against_the_tree": (),
    "test_what_the_two_sweeps_say": (),
    "test_a_lesson_is_added_with_a_folder_and_a_module_of_checks": (),
    "test_nobody_works": (),
    "test_nbgrader_does_not_enter_a_submission_replaced_after_judging": (),
    "test_a_processor_cannot_be_hidden_in_children_of_children_that_are_gone": (),
    "test_plain_nbgrader_still_grades_with_the_visible_checks": (),
    "test_a_dead_worker_costs_one_retry_of_one_notebook": ("1",),
    "test_a_hanging_test_is_named": ("2",),
    "test_judges_as_at_home": ("False",),
    "test_standard_error_stays_empty_and_the_environment_unchanged": ("]",),
    "test_cheap_detectors_earn_hardly_any_points": ("no boxes",),
    "test_every_figure_uses_and_returns_the_given_axes": (
        "from_above",
        "clusters]",
        "boxes]",
        "no boxes",
        "plane_model, None",
        "kd_tree, empty",
        "histogram, NaN",
        "label_confusion]",
    ),
    "test_small_figures_open_one_new_figure": ("graph]", "boxes, flat", "kd_tree, large", "comp"),
    "test_plotting_modules_load_no_heavy_package_except_matplotlib": ("utils.plots", "utils.drive"),
    "test_a_cell_made_to_break_parsers": ("ninety", "a text", "a hund", "an f", "a power", "a key"),
    "test_breaks_off_the_conversation": ("sends a", "sends half", "stops", "kills", "becomes"),
    "test_returns_a_value_that_lies": ("that is", "of a type"),
    "test_fails_in_a_strange_way": ("a huge", "an exception with", "the end", "endless"),
    "test_what_is_forbidden_is_not_in_memory_either": ("forbidden0", "forbidden3"),
    "test_fills_the_kernels_memory_with_empty_files": ("300,000 empty files in /dev",),
    "test_a_processor_cannot_be_hidden_in_children_that_nobody_reaps": ("by a word", "at an"),
    "test_deviations_that_cost_no_points_are_notes": ("labels of another type-05", "nothing-10"),
    "test_only_lessons_that_differ_from_the_release_are_registered_again": ("p", "one"),
    "test_a_change_invalidates_only_the_verdicts_that_depend_on_it": ("grader", "solutions/stage1"),
    "test_who_writes_into_an_argument_loses_that_check": ("match", "ransac", "crop", "get"),
    "test_who_breaks_a_promise_loses_that_check": (
        "match",
        "ransac",
        "euclidean_clustering ",
        "get",
    ),
    "test_wrong_answers_are_flagged_only_if_one_is_an_edit_of_the_other": (
        "crop",
        "insert",
        "ransac",
    ),
    "test_independent_answers_are_not_flagged": ("detect", "search", "voxel"),
    "test_objects_on_random_streets_do_not_overlap": ("1",),
}


# Modules that run in one process, because each process makes their costly fixtures once. Modules
# with the same value share a process.
TOGETHER = {
    **{name: name for name in ("test_build", "test_scenes", "test_hermetic", "test_markdown")},
    "test_chroot": "folders for a root",
    **dict.fromkeys(("test_standalone", "test_site", "test_release"), "standalone notebooks"),
    "test_requirements": "standalone notebooks",  # like test_release, it searches for all imports
}


# The name of a lesson by its own name and by the names of its exercises.
LESSONS = {
    key: lesson.name
    for lesson in every_lesson()
    for key in (lesson.name, *(exercise.name for exercise in lesson.machine_graded))
}


@pytest.hookimpl(tryfirst=True)
def pytest_itemcollected(item):
    """Mark the tests that only `make proof` runs and those that share a process.

    The hook runs first, so that pytest's selection by markers sees these markers. Each process
    makes scenes, right answers and notebooks once.
    """
    begins = A_FEW_OF_MANY.get(getattr(item, "originalname", None))
    if begins is not None and not item.name.partition("[")[2].startswith(begins):
        item.add_marker(pytest.mark.proof)
    if group := TOGETHER.get(item.path.stem) or _lesson_of(item):
        item.add_marker(pytest.mark.xdist_group(group))


# The slowest modules start first, so that all processes finish at about the same time.
LONGEST = (
    *("test_colab", "test_notebooks", "test_cluster", "test_grade", "test_site", "test_course"),
    *("test_text", "test_judge", "test_cheap_answers"),
)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """Sort the tests by run time, the slowest modules first."""
    names = [item.path.stem for item in items]
    order = {name: LONGEST.index(name) if name in LONGEST else len(LONGEST) for name in names}
    # Later lessons work on larger clouds.
    items.sort(key=lambda item: (order[item.path.stem], -_number(item)))


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """End the run when a process dies in a test, for example because the test hangs.

    Otherwise pytest-xdist would give the test to the next process and also lose that process, or
    wait forever.
    """
    if error:
        node.config.pluginmanager.getplugin("dsession").triggershutdown()


def _lesson_of(item):
    """Return the name of the lesson that a test is about, from its folder or its parameters."""
    if item.path.parent.name in LESSONS:
        return item.path.parent.name
    values = getattr(item, "callspec", None) and item.callspec.params.values()
    for value in values or ():
        if isinstance(value, Lesson):
            return value.name
        if isinstance(value, str) and value in LESSONS:
            return LESSONS[value]
    return None


def _number(item):
    group = item.get_closest_marker("xdist_group")
    return int(group.args[0][:2]) if group and group.args[0][0].isdigit() else 0


def pytest_generate_tests(metafunc):
    """Run a test that takes `lesson` once for each lesson of the course."""
    if "lesson" in metafunc.fixturenames:
        metafunc.parametrize("lesson", COURSE, ids=lambda lesson: lesson.name)
