"""Models of Canvas and Moodle that export marks to a file and import them from a file.

The models repeat the rules of `gradebook_exporter.rb`, `gradebook_importer.rb`,
`assignfeedback_offline` and `csv_import_reader` in Python. They share no code with the exporters,
so a harmful file has the same effect here as on the real platform.
"""

import csv
import io
import re
from dataclasses import dataclass, field

NEVER_GRADED = 0


@dataclass
class CanvasStudent:
    id: int
    name: str  # "Last, First", as in Canvas's files
    sis_id: str = ""
    login: str = ""
    section: str = "A"


@dataclass
class Canvas:
    """A course in Canvas.

    `scores` maps (student ID, assignment ID) to a number or "EX". `assigned` maps an assignment ID
    to its students, unless all students have the assignment.
    """

    students: list
    assignments: dict  # ID: [title, points]
    scores: dict = field(default_factory=dict)
    assigned: dict = field(default_factory=dict)
    notes: dict = field(default_factory=dict)  # text in a custom column, by student ID
    separator: str = ","
    decimal_mark: str = "."
    marked: bool = False  # whether files begin with a byte order mark
    sis: bool = True
    first_and_last: bool = False
    manual: bool = False  # whether assignments are posted manually

    def number(self, value):
        return "" if value is None else f"{value:.2f}".replace(".", self.decimal_mark)

    def export(self):
        file = io.StringIO()
        table = csv.writer(file, delimiter=self.separator, lineterminator="\n")
        names = ["LastName", "FirstName"] if self.first_and_last else ["Student"]
        people = [*names, "ID", *["SIS User ID"] * self.sis, "SIS Login ID", "Section"]
        titles = [f"{title} ({id})" for id, (title, _) in self.assignments.items()]
        table.writerow([*people, "Notes", *titles, "Current Score", "Final Score"])
        blank = [""] * (len(people) - 1)
        if self.manual:
            row = ["Manual Posting" for _ in titles]
            table.writerow(["", *blank, "", *row, "", ""])
        points = [self.number(points) for _, points in self.assignments.values()]
        table.writerow(["    Points Possible", *blank, "", *points, "(read only)", "(read only)"])
        for student in self.students:
            cells = [self.cell(student.id, id) for id in self.assignments]
            table.writerow(
                [
                    *self.names(student),
                    student.id,
                    *[student.sis_id] * self.sis,
                    student.login,
                    student.section,
                    self.notes.get(student.id, ""),
                    *cells,
                    "88.10",
                    "70.00",
                ]
            )
        return (("\ufeff" if self.marked else "") + file.getvalue()).encode()

    def names(self, student):
        name = student.name
        if self.first_and_last:
            return name.split(", ", 1)
        return [f'="{name}"' if re.match(r"\s*=", name) else name]

    def cell(self, student, assignment):
        if not self.has(student, assignment):
            return "N/A"
        score = self.scores.get((student, assignment))
        return score if score == "EX" else self.number(score)

    def has(self, student, assignment):
        return student in self.assigned.get(assignment, {student})

    def import_(self, content):
        """Change the gradebook as Canvas does after a file is uploaded and saved."""
        text = content.decode()
        lines = text.splitlines()[:3]
        widths = {}
        for separator in ";,":
            counts = [len(next(csv.reader([line], delimiter=separator))) for line in lines]
            widths[separator] = counts[0] if len(set(counts)) == 1 else 0
        separator = ";" if widths[";"] > widths[","] else ","
        kept = "\n".join(line for line in text.split("\n") if not re.fullmatch("[;, ]+", line))
        head, *rows = csv.reader(io.StringIO(kept), delimiter=separator)
        rows = [[self.converted(cell) for cell in row] for row in rows]
        head[0] = head[0].removeprefix("\ufeff")
        assert head[0] in ("Student", "LastName") and "Section" in head, "Invalid header row"
        last = head.index("Section")
        places = {}
        for place, title in enumerate(head):
            if place <= last or title == "Notes" or re.search("(Current|Final) Score", title):
                continue
            found = re.fullmatch(r"(.*)\s\((\d+)\)", title)
            assert found and int(found[2]) in self.assignments, f"a new assignment {title!r}"
            places[int(found[2])] = place
        for row in rows:
            if "Points Possible" in row[0]:
                for id, place in places.items():
                    self.assignments[id][1] = float(row[place])
            elif any(not re.fullmatch(r"\s*(Muted|Manual Posting.*)?\s*", cell) for cell in row):
                self.import_row(head, row, places)

    def import_row(self, head, row, places):
        cells = dict(zip(head, row, strict=True))
        found = [student for student in self.students if cells["ID"] == str(student.id)]
        found = found or [
            student for student in self.students if cells["SIS Login ID"] == student.login
        ]
        assert found, f"a new student {row[0]!r}"
        if "Notes" in head:
            self.notes[found[0].id] = cells["Notes"]
        for id, place in places.items():
            if not self.has(found[0].id, id):
                continue
            cell = row[place].strip()
            if cell == "":
                self.scores.pop((found[0].id, id), None)
            elif cell.upper() == "EX":
                self.scores[found[0].id, id] = "EX"
            else:
                self.scores[found[0].id, id] = float(cell)

    @staticmethod
    def converted(cell):
        if not re.fullmatch(r"-?[0-9.,]+%?", cell):
            return cell
        *whole, last = re.split("[,.]", cell)
        return f"{''.join(whole)}.{last}" if whole else last


@dataclass
class MoodleStudent:
    number: int
    name: str
    email: str = ""
    id_number: str = ""
    status: str = "Submitted for grading"


ENGLISH = {
    "recordid": "Identifier",
    "fullname": "Full name",
    "email": "Email address",
    "idnumber": "ID number",
    "status": "Status",
    "grade": "Grade",
    "maxgrade": "Maximum grade",
    "workflow": "Marking workflow state",
    "gradecanbechanged": "Grade can be changed",
    "lastmodifiedsubmission": "Last modified (submission)",
    "lastmodifiedgrade": "Last modified (grade)",
    "comments": "Feedback comments",
    "hiddenuser": "Participant ",
    "yes": "Yes",
    "no": "No",
}
GERMAN = {
    "recordid": "ID",
    "fullname": "Vollständiger Name",
    "email": "E-Mail-Adresse",
    "idnumber": "ID-Nummer",
    "status": "Status",
    "grade": "Bewertung",
    "maxgrade": "Bestwertung",
    "workflow": "Status im Bewertungsworkflow",
    "gradecanbechanged": "Bewertung kann geändert werden",
    "lastmodifiedsubmission": "Zuletzt geändert (Abgabe)",
    "lastmodifiedgrade": "Zuletzt geändert (Bewertung)",
    "comments": "Feedback als Kommentar",
    "hiddenuser": "Teilnehmer/in",
    "yes": "Ja",
    "no": "Nein",
}


@dataclass
class Moodle:
    """An assignment in Moodle; `grades` and `comments` are keyed by participant number."""

    students: list
    most: float
    grades: dict = field(default_factory=dict)
    comments: dict = field(default_factory=dict)
    graded_at: dict = field(default_factory=dict)  # minutes, by participant number
    locked: set = field(default_factory=set)
    words: dict = field(default_factory=lambda: ENGLISH)
    decimal_mark: str = "."
    blind: bool = False
    workflow: bool = False
    skipped: list = field(default_factory=list)

    def number(self, value):
        return "" if value is None else f"{value:.2f}".replace(".", self.decimal_mark)

    def columns(self):
        kinds = ["recordid", "fullname", "email", "idnumber", "status", "grade", "maxgrade"]
        kinds = [kind for kind in kinds if not self.blind or kind not in kinds[1:4]]
        kinds += ["workflow"] * self.workflow
        kinds += ["gradecanbechanged", "lastmodifiedsubmission", "lastmodifiedgrade", "comments"]
        return kinds

    def export(self):
        file = io.StringIO()
        table = csv.writer(file, lineterminator="\n")
        table.writerow([self.words[kind] for kind in self.columns()])
        for student in self.students:
            at = self.graded_at.get(student.number)
            cells = {
                "recordid": f"{self.words['hiddenuser']}{student.number}",
                "fullname": student.name,
                "email": student.email,
                "idnumber": student.id_number,
                "status": student.status,
                "grade": self.number(self.grades.get(student.number)),
                "maxgrade": self.number(self.most),
                "workflow": "In marking",
                "gradecanbechanged": self.words["no" if student.number in self.locked else "yes"],
                "lastmodifiedsubmission": "Monday, 12 October 2026, 18:00",
                "lastmodifiedgrade": "-" if at is None else f"minute {at}",
                "comments": self.comments.get(student.number, ""),
            }
            table.writerow([cells[kind] for kind in self.columns()])
        return file.getvalue().encode("utf-8-sig")

    def import_(self, content, ignore_modified=False):
        """Change the grades as Moodle does after a worksheet is uploaded and confirmed."""
        head, *rows = csv.reader(io.StringIO(content.decode("utf-8-sig")))
        places = {
            kind: head.index(self.words[kind]) for kind in self.columns() if kind != "workflow"
        }
        for row in rows:
            assert len(row) == len(head), "csvweirdcolumns"
            number = int(row[places["recordid"]][len(self.words["hiddenuser"]) :])
            if number not in [student.number for student in self.students]:
                continue
            time = re.fullmatch(r"minute (\d+)", row[places["lastmodifiedgrade"]])
            stale = (
                self.graded_at.get(number, NEVER_GRADED)
                > (int(time[1]) if time else NEVER_GRADED) + 1
            )
            grade = self.unformatted(row[places["grade"]])
            if (
                grade is None
                or grade < 0
                or (stale and not ignore_modified)
                or number in self.locked
                or grade > self.most
            ):
                self.skipped.append(number)
            else:
                self.grades[number] = grade
            if ignore_modified or not stale:
                self.comments[number] = row[places["comments"]]

    def unformatted(self, text):
        text = text.strip().replace(" ", "").replace(self.decimal_mark, ".")
        if not text:
            return None
        return float(re.match(r"-?\d*\.?\d*", text)[0] or 0)  # PHP reads "8,5" as 8
