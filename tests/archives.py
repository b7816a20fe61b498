"""Archives as learning platforms write them, made up from the rules of their sources.

Canvas: ``lib/content_zipper.rb``, ``Attachment.make_unique_filename``. Moodle:
``mod/assign/classes/downloader.php``, ``clean_filename``; of the worksheet ``gradingtable.php``.
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
    """A notebook of a lesson, with something that somebody wrote."""
    metadata = {"lidar_obstacle_lab": {"lesson": lesson}} if named else {}
    cell = {"cell_type": "code", "metadata": {}, "source": text, "outputs": []}
    content = {"cells": [cell], "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content).encode()


def released(lesson=SIX):
    """A notebook as it was handed out."""
    return find_lesson(lesson).released.read_bytes()


def zipped(files, when=(2026, 10, 12, 9, 0, 0)):
    """A zip of (name, bytes) or (name, bytes, time)."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data, *time in files:
            info = zipfile.ZipInfo("x", time[0] if time else when)
            info.filename = name  # as it is: ZipInfo itself would cut names at NUL
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, data)
    return file.getvalue()


def canvas_prefix(sortable_name, user, late=False, anonymous=""):
    """What Canvas writes before each file of a submission."""
    name = re.sub(r"_(\d+)_", r"\1", sortable_name).lower()
    parts = [None if anonymous else name, "LATE" if late else None, anonymous or str(user)]
    return re.sub(r"[^\w]", "", "_".join(part for part in parts if part))


def canvas_files(sortable_name, user, attachments, late=False, anonymous=""):
    """Files of a submission: of each attachment its id, name and content."""
    prefix = canvas_prefix(sortable_name, user, late, anonymous and f"anon_{anonymous}")
    shown = re.compile(r'[\x00/\\:*?"<>|]+')
    return [
        (f"{prefix}_{number}_{shown.sub('_', name)}", data) for number, name, data in attachments
    ]


def moodle_files(name, number, files, folders=True, plugin="file"):
    """Files of a participant, or of a team: of each its path and content."""
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
    """Moodle's grading worksheet: of each their number, name, id number, e-mail and time."""
    file = io.StringIO()
    table = csv.writer(file, quoting=csv.QUOTE_ALL)
    table.writerow(MOODLE_TITLES[language].split(","))
    for number, name, id_number, email, time in people:
        who = PARTICIPANT[language] + str(number)
        marks = ["Submitted for grading", "", "100.00", "Yes", time, "-", ""]
        table.writerow([who, name, id_number, email, *marks])
    return "\ufeff" + file.getvalue()
