"""Solved notebooks with made-up outputs, and the lines of solutions that a site must not show."""

import base64
import io
import json
import re

import nbformat
import numpy as np
from nbformat.v4 import new_output
from PIL import Image

from grader.course.lessons import all_lessons, every_lesson, find_lesson
from grader.site import widget_states
from utils.scene3d import Scene, output

LESSON = find_lesson("05_euclidean_clustering")


def picture(colour, kind="PNG"):
    buffer = io.BytesIO()
    Image.new("RGB", (30, 20), colour).save(buffer, kind)
    return base64.b64encode(buffer.getvalue()).decode()


def displayed_output(data, about=None):
    return new_output("display_data", data=data, metadata=about or {})


CALL = {
    "name": "show_level",
    "parameters": [
        {"name": "level", "title": 'level\'s "m"', "values": ["-2.2", "-1.2", "0.6"], "start": 1}
    ],
}


def positions():
    """Yield the outputs of a slider at its initial value and at two other values."""
    own = {"all": [["level (m)", "-1.2"]], "call": CALL}
    yield displayed_output({widget_states.POSITION_TYPE: own})
    yield displayed_output({"image/png": picture("red")}, {"image/png": {"alt": 'In "red"'}})
    for value, colour in (("-2.2", "green"), ("0.6", "blue")):
        yield displayed_output(
            {widget_states.POSITION_TYPE: {"slider": "level (m)", "value": value}}
        )
        yield displayed_output({"image/png": picture(colour)})
        yield new_output("stream", name="stdout", text=f"at {value} <m>\n")


QUESTION = {"question": "How many?", "choices": [], "suffix": " m", "between": [0, 10], "step": 1}
ANSWER = {"question": "How many?", "answer": "7 m", "why": "Because 3 < 4."}


def scene():
    """Return what a cell displays for a 3D scene, as data by MIME type."""
    drawn = Scene("A corner").add_cloud(np.array([[0, 0, 0], [1, 1, 1.0]]))
    return output.bundle_of(drawn, "XY", True, (320, 240), "matplotlib", 'A "corner" in space')


def solved_notebooks():
    """Return each lesson's solved notebook; `LESSON` has artificial outputs of each kind."""
    ran = {lesson: nbformat.read(lesson.solved, as_version=4) for lesson in all_lessons()}
    code = [cell for cell in ran[LESSON].cells if cell.cell_type == "code"]
    code[0].outputs = [new_output("stream", name="stdout", text="Ready: this machine\n")]
    code[1].outputs = [new_output("stream", name="stdout", text="0 of 2\r1 of 2\r2 of 2\n")]
    code[2].outputs = [displayed_output({"image/gif": picture("red", "GIF")})]
    code[3].outputs = [displayed_output({widget_states.QUESTION_TYPE: QUESTION})]
    code[4].outputs = [*positions()]
    code[5].outputs = [
        displayed_output({widget_states.ANSWER_TYPE: ANSWER}),
        displayed_output(scene()),
    ]
    return {lesson: nbformat.writes(notebook).encode() for lesson, notebook in ran.items()}


def secrets():
    """Yield each line of a solution that no released notebook contains."""
    notebooks = "\n".join(
        "".join(cell["source"])
        for lesson in every_lesson()
        for cell in json.loads(lesson.released.read_text("utf-8"))["cells"]
    )
    known = re.sub(r"[`*]", "", notebooks)
    for lesson in every_lesson():
        text = lesson.source.read_text("utf-8")
        for region in re.findall("### BEGIN SOLUTION\n(.*?)### END SOLUTION", text, re.S):
            for line in map(str.strip, region.splitlines()):
                # Short lines may occur in any program, and lines with `# from` contain no code.
                if (
                    len(line) > 15
                    and not line.startswith("# from ")
                    and line.replace("*", "") not in known
                ):
                    yield line
