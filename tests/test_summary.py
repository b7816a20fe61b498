"""The summary of `check`: what is shown of failures, their causes, hints and known mistakes."""

import numpy as np
import pytest

from grader.judging.messages import shareable_outcome
from tests.artificial_checks import declare, forget_declarations, output_of
from utils.checks import check, core, diagnosis, display
from utils.checks.assertions import CheckFailed, WrongForm, as_labels, precondition
from utils.checks.core import ChecksFailed, note_check, run_check
from utils.checks.diagnosis import Mistake, declare_mistakes, diagnose
from utils.checks.failures import NotYet
from utils.checks.line_hint import Line
from utils.checks.outcomes import Check, Outcome
from utils.checks.summary import summarise


@pytest.fixture
def declarations(monkeypatch):
    forget_declarations(monkeypatch)


def test_a_stub_prints_one_line_and_raises(declarations, capsys):
    for title in ("one", "two", "three"):
        declare(title)(lambda double: double(1))

    def double(number):
        raise NotImplementedError

    shown = output_of(double, capsys)
    assert shown.count("\n") == 1 and shown.startswith("[not started] double is not")
    assert "Hint" not in shown


def test_a_stub_is_named_and_not_its_caller(declarations, capsys):
    declare("one")(lambda double: double(1))
    namespace = {}
    exec(
        "def half(number):\n    raise NotImplementedError\n"
        "def double(number):\n    return 4 * half(number)\n",
        namespace,
    )
    assert "double calls half, which is not written yet" in output_of(namespace["double"], capsys)


def test_one_cause_is_shown_once_without_hints(declarations, capsys):
    for title in ("one", "two", "three"):
        declare(title)(lambda double: double(1))

    def double(number):
        return number.shape

    shown = output_of(double, capsys)
    assert shown.count("'int' object has no attribute 'shape'") == 1
    assert shown.count("for the same reason") == 2
    assert "return number.shape" in shown, "the student's line"
    assert "Hint" not in shown


def test_a_second_cause_is_shown_without_its_hint(declarations, capsys):
    @declare("one")
    def first(double):
        raise CheckFailed("The first is wrong.")

    @declare("two")
    def second(double):
        raise CheckFailed("The second is wrong.")

    declare("three")(lambda double: None)
    shown = output_of(lambda number: 0, capsys)
    assert "Hint of one." in shown and "Hint of two." not in shown
    assert "The second is wrong." in shown and "[passed] three" in shown
    assert shown.index("The first") < shown.index("The second") < shown.index("three")


def test_a_check_that_needs_a_failed_check_waits(declarations, capsys):
    @declare("doubles")
    def doubles(double):
        if double(2) != 4:
            raise CheckFailed("2 does not give 4.")

    @declare("also doubles halves")
    def halves(double):
        with precondition("whole numbers are doubled"):
            doubles(double)
        if double(0.5) != 1:
            raise CheckFailed("A half does not give 1.")

    shown = output_of(lambda number: 3, capsys)
    assert "[waiting] also doubles halves" in shown and "A half" not in shown
    shown = output_of(lambda number: int(number) * 2, capsys)
    assert "A half" in shown and "waiting" not in shown


def test_a_wrong_form_does_not_make_other_checks_wait():
    with pytest.raises(WrongForm), precondition("anything"):
        as_labels(None, 3)


def test_notes_cost_no_points_and_are_shown_after_success(declarations, capsys):
    declare("one")(lambda double: None)

    @note_check("double", title="Whole numbers stay whole", why="Later cells count with them.")
    def whole(double):
        if not isinstance(double(2), int):
            raise CheckFailed("It is a float.")

    check(lambda number: 2.0 * number, "double")
    assert "[note] Whole numbers stay whole: It is a float. Later cells" in capsys.readouterr().out
    check(lambda number: 2 * number, "double")
    assert "note" not in capsys.readouterr().out


CASES = ((np.array([1.0, 2.0]),), (np.array([3.0, 0.0]),), (np.array([0.0, 0.0]),))


def test_a_mistake_is_shown_only_if_it_explains_every_answer(declarations):
    declare_mistakes(
        "double",
        Mistake("It is squared.", lambda right, x: x**2),
        Mistake("Nothing is done.", lambda right, x: x),
        cases=CASES,
        right=lambda x: 2 * x,
    )
    assert diagnose("double", lambda x: x * x).description == "It is squared."
    assert diagnose("double", lambda x: x).description == "Nothing is done."
    assert diagnose("double", lambda x: 2 * x) is None, "a right answer has no mistake"
    assert diagnose("double", lambda x: x * x if x[0] == 1 else 0 * x) is None
    assert diagnose("double", lambda x: None) is None
    assert diagnose("double", lambda x: 1 / 0) is None
    assert diagnose("another", lambda x: x) is None


def test_a_mistake_needs_two_cases_and_no_competing_mistake(declarations):
    squared = Mistake("It is squared.", lambda right, x: x**2)
    rival = Mistake("It is multiplied by itself.", lambda right, x: x * x)
    declare_mistakes("double", squared, rival, cases=CASES, right=lambda x: 2 * x)
    assert diagnose("double", lambda x: x * x) is None
    declare_mistakes("double", squared, cases=CASES[1:], right=lambda x: 2 * x)
    assert diagnose("double", lambda x: x * x) is None, "a single case may agree by chance"


def test_a_mistake_does_not_explain_an_exception(declarations, capsys):
    """The mistake explains all wrong answers, but not an exception for an empty array."""
    declare_mistakes(
        "double",
        Mistake("It is squared.", lambda right, x: x**2),
        cases=CASES,
        right=lambda x: 2 * x,
    )

    @declare("nothing")
    def nothing(double):
        double(np.array([]))

    @declare("doubles")
    def doubles(double):
        raise CheckFailed("1 does not give 2.")

    def double(x):
        return x**2 if len(x) else x[0]

    assert diagnose("double", double).description == "It is squared."
    shown = output_of(double, capsys)
    assert "IndexError" in shown and "squared" not in shown


def test_a_function_that_changes_its_arguments_does_not_change_cases(declarations):
    declare_mistakes(
        "double", Mistake("Zero.", lambda right, x: 0 * x), cases=CASES, right=lambda x: 2 * x
    )

    def double(x):
        x *= 0
        return x

    for _ in range(2):
        assert diagnose("double", double).description == "Zero."


def test_a_mistake_is_shown_in_place_of_the_hint(declarations, capsys):
    declare_mistakes(
        "double",
        Mistake("It is squared.", lambda right, x: x**2, "Multiply by 2."),
        cases=CASES,
        right=lambda x: 2 * x,
    )

    @declare("doubles")
    def doubles(double):
        if (double(np.array([1.0, 3.0])) != [2, 6]).any():
            raise CheckFailed("1 and 3 do not give 2 and 6.")

    shown = output_of(lambda x: x**2, capsys)
    assert "What your code does: It is squared." in shown and "Hint: Multiply by 2." in shown
    assert "Hint of doubles" not in shown


def test_every_known_mistake_predicts_its_own_answers(lesson):
    """Each mistake predicts answers that neither the solution nor another mistake gives."""
    for exercise in lesson.machine_graded:
        core.checks_of(exercise.name)  # importing the checks declares the mistakes
        known = diagnosis._KNOWN.get(exercise.name)
        if known is None or known.call is not diagnosis._plain_call:
            continue  # only kept answers test mistakes that define their own calls
        for mistake in known.mistakes:

            def function(*case, mistake=mistake, known=known):
                return mistake.predict(known.right(*case), *case)

            assert diagnose(exercise.name, function) is mistake, mistake.description
        assert diagnose(exercise.name, known.right) is None


class Hostile:
    """An answer that raises an exception in every operation."""

    def _refuse(self, *anything):
        raise RuntimeError("no")

    __eq__ = __iter__ = __len__ = __getitem__ = __array__ = __float__ = __bool__ = _refuse
    __hash__ = None


STRANGE = (
    *(Hostile(), [Hostile()], object, "text", {}, {1: 2}, set(), (), [None, 1], [[1], [2, 3]]),
    *(10**400, [10**30], float("inf"), True, [[[[1]]]], np.zeros((2, 3, 4)), np.full(3, np.nan)),
)


@pytest.mark.parametrize("number", range(len(STRANGE)))
def test_unusual_answers_are_harmless_and_have_no_known_cause(lesson, number):
    for exercise in lesson.machine_graded:
        core.checks_of(exercise.name)

        def function(*anything, **more):
            return STRANGE[number]

        assert diagnose(exercise.name, function) is None


def test_a_wrong_helper_of_the_same_lesson_is_named(capsys):
    namespace = {"__name__": "__main__"}
    exec(
        "import numpy as np\n"
        "def line_through(first, second):\n    return 1.0, 2.0, 3.0\n"
        "def point_line_distance(points, line):\n    return np.zeros(len(points))\n"
        "def ransac_line(points, max_iterations=100, distance_tolerance=0.1, rng=None):\n"
        "    return line_through(0, 1), point_line_distance(points, None) < 1\n",
        namespace,
    )
    with pytest.raises(ChecksFailed):
        check(namespace["ransac_line"])
    assert "which this function calls, fails its own checks" in capsys.readouterr().out


def test_a_summary_in_a_notebook_folds_and_colours():
    failed = core.Check("first", "double", "one", "hint")
    same = core.Check("second", "double", "two", "hint")
    failure = WrongForm("<b>None</b>")
    html = display.as_html(summarise([Outcome(failed, failure), Outcome(same, failure)]))
    assert "<details><summary>1 more check fails for the same reason" in html
    assert "&lt;b&gt;None" in html and "<b>None" not in html


def test_failures_fixed_by_one_edit_have_one_cause():
    """If one edit fixes all failures, all but the first have the same reason."""
    outcomes = [
        Outcome(core.Check(name, "double", name, "hint", run=print), CheckFailed(f"{name} fails"))
        for name in ("first", "second", "third")
    ]
    assert summarise(outcomes).others == tuple(outcomes[1:])
    for about in ({"line_hint": Line(3, "return x")}, {"one_mistake": True}):
        story = summarise(outcomes, **about)
        assert (story.first, story.same, story.others) == (outcomes[0], tuple(outcomes[1:]), ())


def test_a_precondition_is_shown_if_no_other_check_fails():
    def sorts_and_collects(cloud):
        good = np.isfinite(cloud[:, :3]).all(axis=1) & (cloud[:, :3] != 0).any(axis=1)
        return np.unique(cloud[good], axis=0)

    checks = core.checks_of("drop_invalid")
    outcomes = [run_check(declared, sorts_and_collects) for declared in checks]
    assert [type(each.failure) for each in outcomes if each.failure] == [NotYet]
    story = summarise(outcomes)
    assert "This check waits" not in story.first.failure.message
    assert story.first.failure.is_about_the_check and not story.waiting
    # The judge shows only the precondition of a hidden test.
    hidden = Check("test_all", "drop_invalid", "All", "")
    shared = shareable_outcome(
        Outcome(hidden, NotYet("it works", CheckFailed("7"))), is_public=False
    )
    assert shared.failure.reason is None
