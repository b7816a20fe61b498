"""What of this project travels to wherever notebooks are judged: all that judging reads."""

from grader.course.paths import PROJECT

TRAVELS = ("grader", "utils", "solutions", "notebooks", "data")
STAYS_AT_HOME = ("__pycache__", "pictures", "variants")


def files_to_judge_with() -> dict[str, bytes]:
    """Content by name, in order."""
    found = {}
    for folder in TRAVELS:
        for path in sorted((PROJECT / folder).rglob("*")):
            name = path.relative_to(PROJECT)
            hidden = any(part.startswith(".") for part in name.parts)
            if path.is_file() and not hidden and not set(STAYS_AT_HOME) & set(name.parts[:-1]):
                found[name.as_posix()] = path.read_bytes()
    return found
