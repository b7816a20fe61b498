"""Reading the roster, and finding people by id, name, e-mail or login."""

import unicodedata

import pytest

from grader.course.paths import Course
from grader.course.roster import Person, Roster, RosterError, read_roster

CLASS = (
    "id,first_name,last_name,email,section,lms_id,github\n"
    "yan,Yan,Yip,yan@x.edu,A,126,yanyip\n"
    '"mary jane",Mary Jane,"O\'Neil, Jr",mj@x.edu,B,131,\n'
    "björn,Björn,Müller,bm@x.edu,A,140,bm-42\n"
    "anna,Anna,Schmidt,as@x.edu,,141,\n"
    "anna2,Anna,Schmidt,as2@x.edu,,142,\n"
    "126,Zoe,,z@x.edu,,150,\n"
)


@pytest.fixture
def course(tmp_path):
    return Course(tmp_path)


def read(course, text):
    content = text if isinstance(text, bytes) else text.encode()
    (course.root / "roster.csv").write_bytes(content)
    return read_roster(course)


def test_there_is_no_roster_without_a_file(course):
    assert read_roster(course) is None


def test_people_are_read_in_the_order_of_the_file(course):
    people = read(course, CLASS).people
    assert [person.id for person in people] == [
        "yan",
        "mary jane",
        "björn",
        "anna",
        "anna2",
        "126",
    ]
    assert people[0] == Person("yan", "Yan", "Yip", "yan@x.edu", "A", "126", "yanyip")
    assert (people[1].last_name, people[1].name) == ("O'Neil, Jr", "Mary Jane O'Neil, Jr")
    assert people[5].name == "Zoe"
    assert Person("solo").name == "solo"


@pytest.mark.parametrize(
    ("text", "people"),
    [
        ("id\nb\na\n", [Person("b"), Person("a")]),
        ("email;ID;Last Name\nq@x;b;Yip, Jr\n", [Person("b", "", "Yip, Jr", "q@x")]),
        ("id\tsection\nb\tB 2\n", [Person("b", section="B 2")]),
        ("\ufeffid,lms_user_id\r\nb,77\r\n", [Person("b", lms_id="77")]),
        (
            "id,Notes,github\n b ,late?,gh\n\n,,\nc\n",
            [
                Person("b", github="gh", additional_cells=(("Notes", "late?"),)),
                Person("c", additional_cells=(("Notes", ""),)),
            ],
        ),
        ('id,first_name\nb,"Two\nlines"\nc,C\n', [Person("b", "Two\nlines"), Person("c", "C")]),
        (unicodedata.normalize("NFD", "id\nbjörn\n"), [Person("björn")]),
        ("id,last_name\nb,Müller\n".encode("utf-16"), [Person("b", last_name="Müller")]),
        ("id\tsection\rb\tB\rc\tC", [Person("b", section="B"), Person("c", section="C")]),
        ("id,first_name\nanna,Anna,\nbo,Bo,,\n", [Person("anna", "Anna"), Person("bo", "Bo")]),
    ],
)
def test_tables_from_spreadsheets_and_nbgrader_are_read(course, text, people):
    assert list(read(course, text).people) == people


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the first line must name the columns, each once, such as id,first_name,"),
        ("name,email\nb,c\n", "Only id is required."),
        ("id,lms_id,lms_user_id\n", "each once"),
        (
            "id,last_name\nb,O'Neil, Jr\n",
            "line 2: there are 3 values for 2 columns. If a value contains",
        ),
        ("id,email\nb,c\n,d\n", "line 3: the id is missing."),
        ("id\nb\nc\nb\n", "line 4: line 2 has the same id, b. Correct or remove one"),
        ("id,email\nb,q@x\nc,Q@X\n", "line 3: line 2 has the same email, Q@X."),
        ("id,lms_id\nb,7\nc,\nd,7\n", "line 4: line 2 has the same lms_id, 7."),
        ("id\n../b\n", "line 2: '../b' cannot be the name of a folder."),
        ("id\n.b\n", "cannot be the name of a folder"),
        ("id\na\0b\n", "line 2"),
        ("id,first_name\nb," + "x" * 129 + "\n", "first_name is longer than 128 characters"),
        ('id,first_name\nb,"Yan\nc,C\n', "Is a quotation mark missing?"),
        (
            "id,last_name\nb,Müller\n".encode("cp1252"),
            "is not encoded in UTF-8. Save it again from your spreadsheet",
        ),
    ],
)
def test_an_invalid_roster_is_reported_with_line_and_remedy(course, text, message):
    with pytest.raises(RosterError) as trouble:
        read(course, text)
    assert message in str(trouble.value) and str(trouble.value).startswith("roster.csv")


def test_two_ids_may_differ_only_in_case(course):
    roster = read(course, "id\nyan\nYan\n")
    assert roster.person("Yan").id == roster.owner_of("Yan").id == "Yan"
    assert roster.owner_of("YAN") is None and len(roster.find_people("YAN")) == 2


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("yan", ["yan"]),
        ("yan ", ["yan"]),
        ("YAN", ["yan"]),
        ("Mary  Jane", ["mary jane"]),
        (unicodedata.normalize("NFD", "björn"), ["björn"]),
        ("Yan@X.edu", ["yan"]),
        ("YanYip", ["yan"]),
        ("yan yip", ["yan"]),
        ("Yip, Yan", ["yan"]),
        ("yipyan", ["yan"]),
        ("O'Neil, Jr, Mary Jane", ["mary jane"]),
        ("oneiljrmaryjane", ["mary jane"]),
        ("müllerbjörn", ["björn"]),
        ("131", ["mary jane"]),
        ("126", ["126"]),  # an id takes precedence over an lms_id
        ("Schmidt, Anna", ["anna", "anna2"]),
        ("bm42", []),  # a login must match exactly
        ("ghost", []),
        ("", []),
        (" ", []),
        (",", []),
    ],
)
def test_people_are_found_by_id_name_email_or_login(course, text, ids):
    assert [person.id for person in read(course, CLASS).find_people(text)] == ids


@pytest.mark.parametrize(
    ("folder", "id"),
    [
        ("yan", "yan"),
        ("yan ", "yan"),
        ("YAN", "yan"),
        ("131", None),
        ("Yan Yip", None),
        ("x", None),
    ],
)
def test_only_an_id_identifies_the_owner_of_a_folder(course, folder, id):
    owner = read(course, CLASS).owner_of(folder)
    assert (owner and owner.id) == id


def test_an_empty_roster_matches_no_person():
    assert Roster(()).find_people("") == () and Roster(()).person("a") is None


def test_other_columns_are_kept_with_their_titles(course):
    roster = read(course, "Matriculation No.,ID,EMAIL,, Group ,group\n007,b,b@x,z,1,=2\n8,c\n")
    titles = ("Matriculation No.", "Group", "group")
    assert [dict(person.additional_cells) for person in roster.people] == [
        dict(zip(titles, ("007", "1", "=2"), strict=True)),
        dict(zip(titles, ("8", "", ""), strict=True)),
    ]
    assert [person.email for person in roster.people] == ["b@x", ""]
    assert read(course, "id,github\nb,gh\n").people[0].additional_cells == ()


def test_sections_are_found_regardless_of_case_and_blanks(course):
    roster = read(course, "id,section\nb,Group  1\nc,\nd,group 1\ne,Group 10\n")
    assert [person.id for person in roster.people_in_section(" GROUP 1")] == ["b", "d"]
    assert roster.people_in_section("Group") == roster.people_in_section("") == ()
