"""Find calls in the code of the checks, for tests of messages."""

import ast

from grader.course.paths import PROJECT

FAILURES = ("CheckFailed", "WrongForm", "AnswerTooLarge")
FILES_WITH_CHECKS = [
    path
    for pattern in ("utils/checks/**/*.py", "solutions/**/hidden_tests.py")
    for path in sorted(PROJECT.glob(pattern))
    if path.name != "failures.py"
]


def calls_of(names):
    """Yield the place and the arguments of each call to `names` in the code of the checks."""
    for path in FILES_WITH_CHECKS:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in names:
                yield f"{path.name}:{node.lineno}", node.args
