"""Write one quiz per student: as Moodle XML, and in QTI 1.2 for Canvas and other systems."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from xml.sax.saxutils import escape as escape_xml
from xml.sax.saxutils import quoteattr

from markupsafe import escape

from grader.classroom.pages import format_code
from grader.course.archives import make_zip
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.questions.helpers import sentence_about
from grader.questions.question import Question
from grader.questions.viva import Sheet, viva_folder
from utils.questions.texts import NOTATION

LETTERS = "ABCD"
# XML 1.0 does not allow these characters, not even as references.
_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_QTI_MANIFEST = """\
<?xml version="1.0" encoding="UTF-8"?>
<manifest identifier="questions" xmlns="http://www.imsglobal.org/xsd/imscp_v1p1">
<organizations/>
<resources>
<resource identifier="quiz" type="imsqti_xmlv1p2"><file href="quiz.xml"/></resource>
</resources>
</manifest>
"""


def write_quizzes(course: Course, stage: str, sheets: Sequence[Sheet]) -> Path:
    """Write the quizzes of all students with questions, and return their folder."""
    folder = viva_folder(course, stage) / "quizzes"
    for sheet in sheets:
        if sheet.questions:
            for ending, make in QUIZZES.items():
                write_atomically(make(sheet, stage), folder / f"{sheet.student}.{ending}")
    return folder


def moodle_quiz(sheet: Sheet, stage: str) -> bytes:
    """Return a question bank for Moodle's XML import."""
    category = f"$course$/Questions about code/{stage}/{sheet.student.replace('/', '//')}"
    parts = [
        '<?xml version="1.0" encoding="UTF-8"?>\n<quiz>\n'
        f'<question type="category"><category><text>{_xml(category)}</text></category></question>\n'
    ]
    for number, question in enumerate(sheet.questions, start=1):
        answers = "".join(
            f'<answer fraction="{100 if index == question.key else 0}" format="html">'
            f"<text>{_xml(_choice_html(choice))}</text></answer>\n"
            for index, choice in enumerate(question.choices)
        )
        name = f"{sheet.exercise}, question {number}"
        parts.append(
            f'<question type="multichoice">\n<name><text>{_xml(name)}</text></name>\n'
            f'<questiontext format="html"><text>{_xml(_question_html(sheet, question))}</text>'
            "</questiontext>\n<defaultgrade>0</defaultgrade><single>true</single>"
            "<shuffleanswers>false</shuffleanswers><answernumbering>ABCD</answernumbering>\n"
            f'<generalfeedback format="html"><text>{_xml(str(format_code(question.reason)))}</text>'
            f"</generalfeedback>\n{answers}</question>\n"
        )
    return ("".join(parts) + "</quiz>\n").encode()


def qti_quiz(sheet: Sheet, stage: str) -> bytes:
    """Return a zip with a quiz in QTI 1.2."""
    items = "".join(
        _qti_item(sheet, question, number)
        for number, question in enumerate(sheet.questions, start=1)
    )
    title = quoteattr(_clean(f"Questions about your code, {stage}, {sheet.exercise}"))
    quiz = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<questestinterop xmlns="http://www.imsglobal.org/xsd/ims_qtiasiv1p2">\n'
        f'<assessment ident="quiz" title={title}>\n<section ident="root_section">\n{items}'
        "</section>\n</assessment>\n</questestinterop>\n"
    )
    return make_zip({"imsmanifest.xml": _QTI_MANIFEST.encode(), "quiz.xml": quiz.encode()})


def _qti_item(sheet: Sheet, question: Question, number: int) -> str:
    labels = "".join(
        f'<response_label ident="{LETTERS[index]}"><material><mattext texttype="text/html">'
        f"{_xml(_choice_html(choice))}</mattext></material></response_label>\n"
        for index, choice in enumerate(question.choices)
    )
    return (
        f'<item ident="question{number}" title={quoteattr(f"Question {number}")}>\n'
        "<itemmetadata><qtimetadata><qtimetadatafield><fieldlabel>question_type</fieldlabel>"
        "<fieldentry>multiple_choice_question</fieldentry></qtimetadatafield><qtimetadatafield>"
        "<fieldlabel>points_possible</fieldlabel><fieldentry>0</fieldentry></qtimetadatafield>"
        "</qtimetadata></itemmetadata>\n"
        f'<presentation><material><mattext texttype="text/html">'
        f"{_xml(_question_html(sheet, question))}</mattext></material>\n"
        '<response_lid ident="response1" rcardinality="Single"><render_choice>\n'
        f"{labels}</render_choice></response_lid></presentation>\n"
        '<resprocessing><outcomes><decvar maxvalue="100" minvalue="0" varname="SCORE" '
        'vartype="Decimal"/></outcomes><respcondition continue="No"><conditionvar>'
        f'<varequal respident="response1">{question.right_letter}</varequal></conditionvar>'
        '<setvar action="Set" varname="SCORE">100</setvar></respcondition></resprocessing>\n'
        "</item>\n"
    )


def _question_html(sheet: Sheet, question: Question) -> str:
    code = "\n".join(f"{line.number:>3}  {line.text}" for line in sheet.lines)
    helpers = f"<p>{format_code(sentence_about(sheet.helpers))}</p>" if sheet.helpers else ""
    return (
        f"<p>{NOTATION}</p><p>Your code:</p><pre>{escape(code)}</pre>"
        f"{helpers}<p>{format_code(question.text)}</p><pre>{escape(question.code)}</pre>"
    )


def _choice_html(choice: str) -> str:
    return str(format_code(choice) if "`" in choice else format_code(f"`{choice}`"))


def _xml(text: str) -> str:
    return escape_xml(_clean(text))


def _clean(text: str) -> str:
    """Return a text without characters that XML does not allow."""
    return _NOT_IN_XML.sub("\ufffd", text)


QUIZZES: dict[str, Callable[[Sheet, str], bytes]] = {
    "moodle.xml": moodle_quiz,
    "qti.zip": qti_quiz,
}
"""Functions that write a quiz, by the suffix of the file name."""
