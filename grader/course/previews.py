"""Draw the preview pictures of the lessons: ``python -m grader.course.previews [05 06 ...]``.

Each of the course's lessons has a ``preview.py`` with a function `draw` that returns a figure.
"""

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image  # noqa: E402

from grader.course.lessons import every_lesson  # noqa: E402

DOTS_PER_INCH = 110
# Every notebook contains its preview. Reducing the colours to this number halves the size of the
# file without a visible difference.
PALETTE_SIZE = 128


def main(numbers: Sequence[str]) -> None:
    """Draw the previews of the numbered lessons; without numbers, of all lessons."""
    for lesson in every_lesson():
        if numbers and lesson.number not in numbers:
            continue
        preview = f"solutions.{lesson.stage}.{lesson.name}.preview"
        figure = importlib.import_module(preview).draw()
        path = lesson.folder / f"{lesson.number}_preview.png"
        # The file does not contain matplotlib's version, so that it changes only with the picture.
        figure.savefig(path, dpi=DOTS_PER_INCH, metadata={"Software": None})
        plt.close(figure)
        reduce_colours(path)
        print(f"drew {path.name}")


def reduce_colours(path: Path) -> None:
    """Reduce the colours of a picture to a palette, which makes its file smaller."""
    with Image.open(path) as drawn:
        reduced = drawn.convert("RGB").quantize(PALETTE_SIZE, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)


if __name__ == "__main__":
    main(sys.argv[1:])
