"""Build archives as Canvas and Moodle do, according to their source code.

Canvas: ``lib/content_zipper.rb`` and ``Attachment.make_unique_filename``. Moodle:
``mod/assign/classes/downloader.php`` and ``clean_filename``, and ``gradingtable.php`` for the
worksheet.
"""

import csv
import io
import json
import re
import zipfile

from grader.course.lessons import find_lesson

SIX, SEVEN, EIGHT, NINE = (
    "06_filter_ground",
    "07_filter_by_distance",
    "08_bounding_boxes",
    "09_filter_clusters",
)
STAGE3 = (SIX, SEVEN, EIGHT, NINE)


def notebook(lesson=SIX, text="x = 1", named=True):
    """Return the bytes of a notebook with a student's text in its only code cell."""
    metadata = {"lidar_obstacle_lab": {"lesson": lesson}} if named else {}
    cell = {"cell_type": "code", "metadata": {}, "source": text, "outputs": []}
    content = {"cells": [cell], "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content).encode()


def released(lesson=SIX):
    """Return the bytes of a lesson's released notebook."""
    return find_lesson(lesson).released.read_bytes()


def zipped(files, when=(2026, 10, 12, 9, 0, 0)):
    """Return the bytes of a zip with these files: (name, bytes) or (name, bytes, time)."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data, *time in files:
            info = zipfile.ZipInfo("x", time[0] if time else when)
            info.filename = name  # set here, because ZipInfo() truncates names at a NUL character
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, data)
    return file.getvalue()


def canvas_prefix(sortable_name, user, late=False, anonymous=""):
    """Return the prefix that Canvas puts before the name of each submitted file."""
    name = re.sub(r"_(\d+)_", r"\1", sortable_name).lower()
    parts = [None if anonymous else name, "LATE" if late else None, anonymous or str(user)]
    return re.sub(r"[^\w]", "", "_".join(part for part in parts if part))


def canvas_files(sortable_name, user, attachments, late=False, anonymous=""):
    """Return the files of a submission; an attachment is (ID, name, content)."""
    prefix = canvas_prefix(sortable_name, user, late, anonymous and f"anon_{anonymous}")
    shown = re.compile(r'[\x00/\\:*?"<>|]+')
    return [
        (f"{prefix}_{number}_{shown.sub('_', name)}", data) for number, name, data in attachments
    ]


def moodle_files(name, number, files, folders=True, plugin="file"):
    """Return the files of a participant or of a team; a file is (path, content)."""
    prefix = name.replace("_", " ") + (f"_{number}" if number else "")
    prefix = re.sub(r"[\\/:*?\"<>|]", "", f"{prefix}_assignsubmission_{plugin}")
    divider = "/" if folders else "_"
    return [(f"{prefix}{divider}{path}", data) for path, data in files]


MOODLE_TITLES = {
    "en": (
        "Identifier,Full name,ID number,Email address,Status,Grade,Maximum Grade,"
        "Grade can be changed,Last modified (submission),Last modified (grade),Feedback comments"
    ),
    "de": (
        "ID,Vollständiger Name,ID-Nummer,E-Mail-Adresse,Status,Bewertung,Bestwertung,"
        "Bewertung kann geändert werden,Zuletzt geändert (Abgabe),Zuletzt geändert (Bewertung),"
        "Feedback als Kommentar"
    ),
}
PARTICIPANT = {"en": "Participant ", "de": "Teilnehmer/in"}


def worksheet(people, language="en"):
    """Return Moodle's grading worksheet; a person is (number, name, ID number, e-mail, time)."""
    file = io.StringIO()
    table = csv.writer(file, quoting=csv.QUOTE_ALL)
    table.writerow(MOODLE_TITLES[language].split(","))
    for number, name, id_number, email, time in people:
        participant = PARTICIPANT[language] + str(number)
        marks = ["Submitted for grading", "", "100.00", "Yes", time, "-", ""]
        table.writerow([participant, name, id_number, email, *marks])
    return "\ufeff" + file.getvalue()
