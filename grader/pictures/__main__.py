"""Draw the pictures anew: ``python -m grader.pictures [05 06 ...]``."""

import importlib
import sys
from collections.abc import Sequence

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image  # noqa: E402

from grader.course.lessons import all_lessons  # noqa: E402
from grader.pictures import hero  # noqa: E402

DOTS_PER_INCH = 110
COLOURS = 128
"""Of a preview: it travels inside its notebook, and half as many bytes look the same."""


def main(numbers: Sequence[str]) -> None:
    """Draw the previews of the lessons with these numbers; or of all, and the README's film."""
    for lesson in all_lessons():
        number = lesson.number
        if numbers and number not in numbers:
            continue
        figure = importlib.import_module(f"grader.pictures.lesson_{number}").draw()
        path = lesson.source.parent / "pictures" / f"{number}_preview.png"
        path.parent.mkdir(exist_ok=True)
        # Without the version of matplotlib in it, the same picture is the same file.
        figure.savefig(path, dpi=DOTS_PER_INCH, metadata={"Software": None})
        plt.close(figure)
        with Image.open(path) as drawn:
            few = drawn.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        few.save(path, optimize=True)
        print(f"drew {path.name}")
    if not numbers:
        print(f"recorded {hero.film().path.name}")


if __name__ == "__main__":
    main(sys.argv[1:])
