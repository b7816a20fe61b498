"""Record the films on the pages of lessons: ``python -m grader.course.films [05 09 ...]``.

A lesson with a film has a ``film.py`` with a function `record`, which gets an empty folder and
returns the path of a film. This program makes a small MP4 of it, and a picture for readers who have
not started the film. ``film.toml`` contains the description and the place on the page.
"""

import importlib
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from grader.course.lessons import all_lessons
from grader.course.previews import reduce_colours

FILM, POSTER = "film.mp4", "film.png"
QUALITY = 30  # of H.264, from 0 (no loss) to 51; small letters are still legible
POSTER_SECOND = 2


def main(numbers: Sequence[str]) -> None:
    """Record the films of the numbered lessons; without numbers, of all lessons."""
    for lesson in all_lessons():
        if (numbers and lesson.number not in numbers) or not (lesson.folder / "film.py").exists():
            continue
        module = importlib.import_module(f"solutions.{lesson.stage}.{lesson.name}.film")
        with tempfile.TemporaryDirectory() as folder:
            recorded = module.record(Path(folder))
            encode(recorded, lesson.folder / FILM, lesson.folder / POSTER)
        print(f"recorded {lesson.name}/{FILM}")


def encode(recorded: Path, film: Path, poster: Path) -> None:
    """Write a film as a small MP4, and one of its pictures as PNG."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error"]
    # Browsers play only this pixel format, and start earlier if the index comes first in the file.
    options = ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    codec = ["-c:v", "libx264", "-preset", "veryslow", "-crf", str(QUALITY), "-threads", "1"]
    subprocess.run([*command, "-i", recorded, "-an", *codec, *options, film], check=True)
    place = ["-ss", str(POSTER_SECOND), "-i", film, "-frames:v", "1"]
    subprocess.run([*command, *place, poster], check=True)
    reduce_colours(poster)


if __name__ == "__main__":
    main(sys.argv[1:])
