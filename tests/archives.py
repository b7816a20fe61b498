"""Build archives as learning platforms do.

Canvas: ``lib/content_zipper.rb`` and ``Attachment.make_unique_filename``. Moodle:
``mod/assign/classes/downloader.php`` and ``clean_filename``, and ``gradingtable.php`` for the
worksheet. Moodle before 2022: ``download_submissions`` in ``mod/assign/locallib.php``. ILIAS:
``ilExSubmission::getDirectoryNameFromUserData``. The other platforms: scripts that read their
downloads.
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


def released_notebook(lesson=SIX):
    """Return the bytes of a lesson's released notebook."""
    return find_lesson(lesson).released.read_bytes()


def make_zip(files, when=(2026, 10, 12, 9, 0, 0)):
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


def moodle_files(name, number, files, folders=True, plugin="file", old=False, team=""):
    """Return the files of a participant or of a team; a file is (path, content).

    With `old`, names are those of versions before 2022, in which `team` is the team of a person.
    """
    name = f"{team}-{name}" if team else name
    prefix = name.replace("_", " ") + (f"_{number}" if number else "")
    prefix = re.sub(r"[\\/:*?\"<>|]", "", f"{prefix}_assignsubmission_{plugin}")
    divider = ("_/" if old else "/") if folders else "_"
    return [(f"{prefix}{divider}{path}", data) for path, data in files]


def blackboard_files(login, time, files, title="LiDAR 20Lab"):
    """Return the files of an attempt at a time such as ``2026-10-12-23-10-00``."""
    attempt = f"{title}_{login}_attempt_{time}"
    about = f"Name: ({login})\nAssignment: {title}\n".encode()
    return [(f"{attempt}.txt", about)] + [(f"{attempt}_{name}", data) for name, data in files]


def brightspace_files(name, number, time, files, folders=True):
    """Return the files of an attempt at a time such as ``12 October, 2026 1110 PM``."""
    divider = "/" if folders else " - "
    return [(f"{number}-678901 - {name} - {time}{divider}{file}", data) for file, data in files]


def gradescope_files(submissions, root="assignment_7_export/"):
    """Return an export; a submission is (number, [(name, number, e-mail)], time, files)."""
    text, exported = "---\n", []
    for number, submitters, time, files in submissions:
        text += f"submission_{number}:\n  :submitters:\n"
        for name, sid, email in submitters:
            text += f"  - :name: {name}\n    :sid: {sid}\n    :email: {email}\n"
        text += f"  :created_at: {time}\n  :score: 10.0\n"
        exported += [(f"{root}submission_{number}/{path}", data) for path, data in files]
    return [*exported, (f"{root}submission_metadata.yml", text.encode())]


def ilias_files(last, first, login, number, files, title="Blatt 3", team=""):
    """Return the files of a student; `team` is the number of a team."""
    folder = f"{title}/Abgaben/" + (f"Team {team}/" if team else "")
    return [(f"{folder}{last}_{first}_{login}_{number}/{name}", data) for name, data in files]


def sakai_files(name, login, files, title="Lab (week 3)", folders=True):
    """Return the files of a student, and the files that Sakai adds."""
    divider = "/" if folders else "_"
    person = f"{title}/{name}({login}){divider}"
    return [
        (f"{person}timestamp.txt", b"20261012211000000"),
        (f"{person}feedbackText.html", b"<p>"),
        *((f"{person}Submission attachment(s){divider}{file}", data) for file, data in files),
    ]


def prairielearn_files(uid, submission, files, root="Homework3/"):
    """Return the files of a submission to a question."""
    return [(f"{root}{uid}_1_lidar_lab_1_{submission}_{name}", data) for name, data in files]


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
