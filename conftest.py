"""Fixtures and hooks that all tests of the project share."""

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
from tests.prerequisites import RECORDINGS, require_sandbox

MEMORY = Path("/dev/shm")
ENOUGH = 2**31  # bytes


def pytest_configure(config):
    """Configure the run before the tests are collected.

    - Keep temporary files in memory, because gradebooks would wait for the disk.
    - Enable Ctrl-C, which some tests send. A process that a script starts in the background
      ignores it.
    - Prevent Hypothesis from failing a test because the machine is busy.
    """
    hypothesis.settings.register_profile(
        "any speed", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
    )
    hypothesis.settings.load_profile("any speed")
    if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > ENOUGH:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_collection(session):
    """Collect the tests without garbage collection, and exclude the collected objects from it.

    Garbage collection used to take a third of the time for collecting, and a tenth of the tests'.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()
        gc.set_threshold(20_000)


@pytest.fixture(autouse=True, scope="session")
def shared_statement_cache():
    """Share SQLAlchemy's compiled SQL statements among all gradebooks of a process.

    Otherwise each gradebook compiles them again, because SQLAlchemy has one cache per engine.
    """
    create_engine, engines = nbgrader.api.create_engine, {}

    def create_sharing_engine(*arguments, **options):
        engine = create_engine(*arguments, **options)
        first = engines.setdefault(engine.dialect.name, engine)
        engine.dialect = engine.pool._dialect = first.dialect
        engine._compiled_cache = first._compiled_cache
        return engine

    nbgrader.api.create_engine = create_sharing_engine
    yield
    nbgrader.api.create_engine = create_engine


def pytest_unconfigure(config):
    """List the reasons for skipped tests below the summary."""
    reporter = config.pluginmanager.getplugin("terminalreporter")
    if reporter is None:  # a worker of pytest-xdist
        return
    reasons = Counter(report.longrepr[2] for report in reporter.stats.get("skipped", ()))
    if reasons:
        reporter.write_line("Skipped, because this is missing:")
    for reason, count in reasons.most_common():
        reporter.write_line(f"{count:6}  {reason.removeprefix('Skipped: ')}")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """Use one more process than there are processors, because many tests spend time waiting."""
    return len(os.sched_getaffinity(0)) + 1


@pytest.fixture(scope="session")
def sandbox():
    """Return the sandbox for tests: bubblewrap, or a plain process if it is not available."""
    if os.environ.get("REQUIRE_SANDBOX") == "1":
        return require_sandbox()
    try:
        return choose_sandbox()
    except SandboxUnavailable:
        return SANDBOXES["process"]


@pytest.fixture(scope="session")
def real_clouds():
    """Return the folder of real recordings, which the environment variable REAL_CLOUDS names."""
    folder = os.environ.get("REAL_CLOUDS")
    if not folder:
        pytest.skip(RECORDINGS)
    return Path(folder)


@pytest.fixture
def reading_without_fork(monkeypatch):
    """Read submitted files in this process, because a fork of a large test process takes 60 ms.

    `test_reader_process` tests the separate process, and the tests of the commands use it.
    """
    monkeypatch.delattr(os, "fork")


@pytest.fixture(autouse=True)
def no_open_figures():
    """Close the figures of earlier tests, because some tests count open figures."""
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(autouse=True)
def unchanged_recursion_limit():
    """Restore the recursion limit, which answers that run in this process may raise."""
    before = sys.getrecursionlimit()
    yield
    sys.setrecursionlimit(before)


# Tests with many cases or a long run time, and the beginnings of some case IDs. `make test` runs
# only the cases with these beginnings, and `make proof` runs all. Other tests always run in full.
A_FEW_OF_MANY = {
    "test_a_file_name_in_another_platforms_style_changes_neither_owner_nor_format": (
        "Canvas-Sakai",
        "Moodle-Sakai",
        "PrairieLearn-Sakai",
        "Sakai without folders-Blackboard",
    ),
    "test_strange_boxes_do_not_make_the_grader_fail": ("around the camera", "corners", "infinite"),
    "test_the_skeleton_of_a_new_lesson_is_complete": (),
    "test_commands_of_nbgrader_give_the_same_scores_without_hidden_tests": (),
    "test_a_course_on_another_subject_is_built_released_judged_and_graded": (),
    "test_workers_started_by_hand_give_the_same_gradebook": (),
    "test_a_demo_of_all_stages_has_every_lesson": (),
    "test_the_car_with_true_boxes_stops_for_a_child_and_drives_on": (),
    "test_nbgrader_can_import_the_roster": (),
    "test_an_answer_with_two_errors_keeps_only_the_points_of_its_checks": (),
    "test_a_recorded_notebook_shows_data_instead_of_widgets": (),
    "test_a_bad_cell_does_not_affect_the_other_exercise": (),
    "test_a_faulty_check_is_not_a_wrong_answer": (),
    "test_a_failing_check_stops_only_a_solved_notebook": (),
    "test_packages_that_check_accepts_can_be_imported_by_the_judge": (),
    "test_every_source_of_right_helpers_is_in_the_key": (),
    "test_a_hanging_test_is_named": (),
    "test_no_box_is_on_empty_road": (),
    "test_each_fault_of_the_checks_is_reported_once": (),
    "test_a_deleted_gradebook_is_written_again": (),
    "test_workers_end_with_their_parent_process": (),
    "test_exit_codes_are_not_shown": (),
    "test_sharing_the_processor_does_not_cost_time": (),
    "test_sleep_counts_towards_the_limit_but_waiting_for_a_processor_does_not": (),
    "test_a_call_that_the_wall_clock_stops_is_starved": (),
    "test_calls_have_more_time_if_waiting_times_are_unknown": (),
    "test_a_folder_name_that_is_not_text_does_not_stop_grading": (),
    "test_the_working_folder_does_not_change_a_verdict": (),
    "test_mistakes_in_the_exercise_itself_still_lose_points": (),
    "test_both_of_two_wrong_helpers_are_named": (),
    "test_a_right_helper_is_not_blamed": (),
    "test_endless_cells_cost_one_time_limit": (),
    "test_many_quick_calls_share_one_budget": (),
    "test_a_wrong_function_that_is_slow_gets_no_more_time_than_one_that_hangs": (),
    "test_an_untouched_notebook_earns_nothing": ("01", "04", "12"),
    "test_the_replay_of_a_wrong_answer_marks_the_wrong_step": ("euclidean_clustering-",),
    "test_the_solution_earns_everything_with_four_more_seeds": ("01",),
    "test_no_cheap_answer_earns_more_than_a_tenth": ("01",),
    "test_a_partly_right_answer_earns_part_of_the_points": (),
    "test_no_cheap_answer_is_one_edit_from_a_right_one": (),
    "test_an_edit_of_a_right_answer_loses_points_or_is_equivalent": (),
    "test_few_answers_lose_more_than_three_fifths_for_one_edit": (),
    "test_known_mistakes_of_cheap_answers_are_marked_as_cheap": (),
    "test_an_endless_loop_does_not_need_a_process_for_each_edit": (),
    "test_a_slip_in_the_students_own_helper_is_a_slip": (),
    "test_a_slip_earns_the_share_that_a_teacher_would_give": ("line_through",),
    "test_code_that_delays_the_class_costs_one_time_limit": ("stops",),
    "test_a_notebook_of_sleeping_functions_has_one_budget": (),
    "test_no_bits_reach_another_notebook": (
        "locks files",
        "loads pages, which the receiver reads w",
    ),
    "test_a_cell_is_read_in_linear_time": ("brackets-", "blank lines"),
    "test_a_file_is_read_in_linear_time": ("brackets", "blank lines", "quotation"),
    "test_no_visible_function_answers_an_exercise": (),
    "test_answers_that_are_far_too_large_earn_almost_nothing": ("three thousand",),
    "test_huge_or_strange_answers_are_judged_in_time": (
        "a dict",
        "an integer with thirty",
        "infin",
    ),
    "test_overwriting_every_argument_earns_almost_nothing": ("08",),
    "test_a_huge_answer_is_refused_quickly": (
        "a dict",
        "a la",
        "boxes",
        "dig",
        "dim",
        "many",
        "ne",
    ),
    "test_a_function_that_overwrites_its_arguments_loses_only_that_check": ("01", "08", "09"),
    "test_a_random_answer_earns_no_more_than_its_wrong_version": (),
    "test_answers_from_elsewhere_earn_almost_nothing": (
        "the points in a box, from utils.b",
        "the reference solution, from",
    ),
    "test_changing_arguments_to_fit_an_answer_earns_almost_nothing": (
        "changes the target",
        "empties",
    ),
    "test_changes_to_given_code_have_no_effect": ("a given class that is replaced by name",),
    "test_attacks_on_the_judge_earn_almost_nothing": ("replaces", "disables", "returns a list"),
    "test_a_failing_cell_does_not_reveal_another_notebooks_secret": (
        "in the message",
        "in a name",
        "in a module that is missing",
        "in a line",
    ),
    "test_an_answer_does_not_reveal_another_notebooks_secret": ("in values", "in the type"),
    "test_a_different_answer_in_the_second_run_gains_nothing": (),
    "test_the_caller_of_a_wrong_function_can_also_be_repaired": (),
    "test_a_wrong_loop_stays_wrong_with_right_helpers": (),
    "test_visible_checks_run_before_hidden_tests": ("02", "08", "12"),
    "test_no_environment_variable_changes_a_verdict": ("PYTEST_ADDOPTS=-k",),
    "test_connected_components_are_allowed_in_lesson_10": (),
    "test_a_detector_made_of_the_lessons_functions_earns_everything": (),
    "test_messages_of_hidden_tests_contain_no_words_of_the_student": ("01", "08"),
    "test_a_local_cluster_grades_with_processes": (),
    "test_unsuitable_workers_are_refused_and_listed": (),
    "test_an_exercise_that_calls_a_wrong_helper_keeps_its_points": ("line_through-the",),
    "test_types_do_not_reveal_hidden_input": ("08",),
    "test_the_references_process_a_real_frame": (),
    "test_real_frames_survive_every_encoding": (),
    "test_reports_wait_for_a_person_and_keep_their_marks": (),
    "test_a_run_killed_in_the_middle_loses_nothing": (),
    "test_a_run_survives_the_loss_of_a_worker": (),
    "test_a_killed_run_is_completed_by_the_same_command": (),
    "test_the_same_command_resumes_a_stopped_or_killed_run": (),
    "test_nothing_is_judged_twice_after_the_loss_of_the_scheduler": (),
    "test_a_course_runs_from_release_to_export": (),
    "test_the_demo_grades_its_class": (),
    "test_a_full_disk_is_reported_and_loses_nothing": ("3",),
    "test_clouds_of_every_size_are_drawn": ("some not finite",),
    "test_exercises_of_solved_lessons_work": ("01", "06"),
    "test_every_file_that_is_read_while_judging_is_in_the_key": ("09",),
    "test_every_imported_module_is_in_the_key": ("03", "12"),
    "test_a_right_loop_earns_everything_with_wrong_helpers": (),
    "test_notebooks_written_again_have_the_same_bytes": (),
    "test_the_gradebook_may_be_on_a_server": (),
    "test_many_files_with_any_content_are_read_or_refused": (),
    "test_many_recordings_with_any_content_are_read_or_refused": (),
    "test_a_solved_notebook_runs_and_agrees_with_the_stored_answers": (),
    "test_an_untouched_notebook_runs_to_the_end": (),
    "test_every_cell_below_a_wrong_answer_runs_to_the_end": (),
    "test_a_right_answer_to_a_lesson_shows_no_banner": (),
    "test_all_modules_that_a_lesson_allows_can_be_imported": (),
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
    "test_waiting_for_threads_or_children_that_lack_a_processor_does_not_count_as_sleep": (),
    "test_at_least_a_hundred_attacks_exist": (),
    "test_a_call_that_is_too_slow_is_stopped_on_a_busy_machine_and_not_starved": (),
    "test_a_search_for_neighbours_earns_everything_in_lesson_05": ("scikit-learn's tree]", "SciPy"),
    "test_a_browser_executes_none_of_the_commands": (),
    "test_a_verdict_is_shown_in_linear_time": (
        "brackets]",
        "spaces in",
        "environments]",
        "formulas without",
    ),
    "test_many_cells_are_prepared_in_linear_time": ("kinds1",),
    "test_markdown_is_read_in_linear_time": ("brackets]", "colours", "fences", "tags", "quotes"),
    "test_feedback_does_not_reveal_hidden_input": (
        "in the cause",
        "in the name of an exception]",
        "in terminal commands",
        "in a key",
        "in an assertion",
    ),
    "test_new_work_never_gets_the_time_of_old_work_if_a_run_is_stopped": ("the grader-T",),
    "test_a_missing_capability_is_reported": ("sys_chroot", "setuid"),
    "test_privileged_actions_are_refused": (
        "becomes root]",
        "lists",
        "mounts",
        "opens a socket]",
        "changes the root",
    ),
    "test_a_hostile_notebook_affects_only_its_author": ("brackets", "ifs", "long"),
    "test_hidden_input_does_not_reveal_a_seed": ("02", "03", "05", "08"),
    "test_the_class_is_graded_despite_a_costly_file": (),
    "test_the_largest_file_needs_little_memory": ("<lambda>1",),
    "test_strange_student_names_are_harmless": (
        "a name that is not UTF-8",
        "HTML",
        "a parent folder",
        "two",
    ),
    "test_forbidden_code_is_not_in_memory_after_libraries_import_it": ("05",),
    "test_the_whole_page_of_a_hostile_notebook_is_harmless": ("markdown",),
    "test_twenty_thousand_cells_that_define_the_exercise_get_a_verdict": (),
    "test_a_forbidden_module_inside_a_library_is_refused_in_lesson_05": ("a name in a library]",),
    "test_right_boxes_over_wrong_axes_earn_everything": ("ascending",),
    "test_other_wrong_axes_do_not_cost_points_for_the_boxes": ("not centred",),
    "test_dates_are_the_same_on_a_database_server": (),
    "test_a_browser_fetches_nothing_for_a_page_and_draws_its_formulas": (),
    "test_slightly_wrong_answers_lose_points": ("3-",),
    "test_the_largest_cloud_is_transferred_as_a_list_of_rows": (),
    "test_principal_axes_make_the_curve_fall": (),
    "test_naive_squares_cover_road_and_the_ego_car": (),
    "test_at_seven_tenths_no_road_user_is_torn_and_a_moving_car_is_joined": (),
    "test_listing_pairs_is_faster_than_querying_and_joining": (),
    "test_statements_about_the_two_sweeps_are_true": (),
    "test_adding_a_lesson_takes_only_a_folder_and_a_module_of_checks": (),
    "test_missing_workers_are_reported": (),
    "test_nbgrader_does_not_enter_a_submission_replaced_after_judging": (),
    "test_processor_time_of_orphaned_grandchildren_counts": (),
    "test_plain_nbgrader_still_grades_with_the_visible_checks": (),
    "test_a_dead_worker_costs_one_retry_of_one_notebook": ("1",),
    "test_the_score_is_the_same_as_on_the_command_line": ("False",),
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
    "test_a_cell_that_breaks_parsers_does_not_affect_other_cells": (
        "ninety",
        "a string without",
        "a hund",
        "an f",
        "an enormous power",
        "a misplaced keyword",
    ),
    "test_an_invalid_reply_stops_the_student": (
        "sends a",
        "sends half",
        "stops",
        "kills",
        "replaces",
    ),
    "test_deceptive_values_arrive_as_plain_data": (
        "a list",
        "an object that claims to be an array",
    ),
    "test_strange_failures_get_a_short_message": (
        "a huge",
        "an exception with",
        "SystemExit",
        "endless",
    ),
    "test_forbidden_modules_are_not_in_memory": ("forbidden0", "forbidden3"),
    "test_the_kernel_memory_of_empty_files_counts_towards_the_limit": (
        "300,000 empty files in /dev",
    ),
    "test_processor_time_of_unreaped_children_counts": ("with signal", "with an"),
    "test_an_exercise_costs_the_class_no_more_than_promised": ("spends",),
    "test_a_process_killed_for_lack_of_memory_during_a_search_is_starved": ("diagnosis",),
    "test_deviations_that_cost_no_points_get_notes": ("labels of another type-05", "nothing-10"),
    "test_only_lessons_that_differ_from_the_release_are_registered_again": ("p", "one"),
    "test_a_change_invalidates_only_the_verdicts_that_depend_on_it": ("grader", "solutions/stage1"),
    "test_changing_an_argument_fails_only_that_check": ("match", "ransac", "crop", "get"),
    "test_a_broken_promise_fails_only_its_check": (
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
    "test_the_courses_answer_gets_two_questions_that_do_not_show_it_on_the_site": (
        "01",
        "06",
        "08",
    ),
    "test_a_fixed_level_leaves_road_on_a_climbing_street": (),
    "test_statements_about_people_in_full_view_are_true": (),
    "test_no_method_is_reliable_for_cyclists": (),
    "test_headings_of_a_stream_jump_and_can_be_unwrapped": (),
    "test_a_car_counts_as_torn_when_it_lost_a_single_point": (),
    "test_one_of_the_two_errors_always_remains": (),
    "test_the_lorry_wins_twice_in_ten_frames": (),
    "test_the_answer_about_msac_is_right": (),
    "test_attacks_fail_without_a_required_sandbox": ("1-",),
    "test_code_that_changes_the_observer_cannot_inject_markup": (
        "answer_observer.read_answer",
        "answer_observer.evaluate",
    ),
    "test_figures_appear_whatever_backend_the_environment_names": ("TkAgg",),
    "test_wrong_boxes_keep_their_own_mistake": (),
    "test_a_slip_in_an_unbuilt_source_has_no_effect": (),
    "test_objects_on_random_streets_do_not_overlap": ("1",),
}


# Modules whose tests all run in one process, so that expensive fixtures are created only once.
# Modules with the same value share a process.
TOGETHER = {
    **{name: name for name in ("test_build", "test_scenes", "test_hermetic", "test_markdown")},
    "test_chroot": "folders for a root",
    **dict.fromkeys(("test_standalone", "test_site", "test_release"), "standalone notebooks"),
    "test_requirements": "standalone notebooks",  # searches for all imports, like test_release
}


# Maps the name of each lesson, and of each of its exercises, to the name of the lesson.
LESSONS = {
    key: lesson.name
    for lesson in every_lesson()
    for key in (lesson.name, *(exercise.name for exercise in lesson.machine_graded))
}


@pytest.hookimpl(tryfirst=True)
def pytest_itemcollected(item):
    """Mark the tests that only `make proof` runs, and the tests that share a process.

    This hook runs first, so that the markers exist when pytest selects tests by marker. The tests
    of a lesson share a process, because each process has to create scenes and right answers.
    """
    begins = A_FEW_OF_MANY.get(getattr(item, "originalname", None))
    if begins is not None and not item.name.partition("[")[2].startswith(begins):
        item.add_marker(pytest.mark.proof)
    if group := TOGETHER.get(item.path.stem) or _lesson_of(item):
        item.add_marker(pytest.mark.xdist_group(group))


# The slowest modules. They start first, so that all processes finish at about the same time.
LONGEST = (
    *("test_colab", "test_notebooks", "test_cluster", "test_grade", "test_site", "test_course"),
    *("test_text", "test_judge", "test_cheap_answers"),
)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """Sort the tests by run time, the slowest modules first."""
    names = [item.path.stem for item in items]
    order = {name: LONGEST.index(name) if name in LONGEST else len(LONGEST) for name in names}
    # Start with the later lessons, because they use larger clouds.
    items.sort(key=lambda item: (order[item.path.stem], -_number(item)))


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """End the run when a process dies in a test, for example after a timeout.

    Otherwise pytest-xdist would run that test in the next process and lose that process as well, or
    wait forever.
    """
    if error:
        node.config.pluginmanager.getplugin("dsession").triggershutdown()


def _lesson_of(item):
    """Return the lesson that a test belongs to, according to its folder or its parameters."""
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
    """Run each test that has an argument `lesson` once for each lesson of the course."""
    if "lesson" in metafunc.fixturenames:
        metafunc.parametrize("lesson", COURSE, ids=lambda lesson: lesson.name)
