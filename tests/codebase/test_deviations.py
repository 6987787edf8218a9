"""docs/deviations.md and the comments `// Differs (A5):` name the same rows."""

import re
from collections import Counter

from codebase.repository import sources, text

PAGE = "docs/deviations.md"
ROW = re.compile(r"^\| ([AVM]\d+) \|", re.M)
MARK = re.compile(r"// Differs\b(?: \((\w+)\))?")


def unknown_marks(marks, rows):
    """`file: what is wrong` of comments without a row's name, or with one that is not there."""
    return [f"{path}: Differs ({row})" for path, row in marks if row not in rows]


def marks():
    code = sources(".h", ".cpp", under="cpp/")
    return [(path, row) for path, content in code.items() for row in MARK.findall(content)]


def test_every_line_that_differs_names_a_row():
    found = marks()
    assert len(found) >= 29
    assert unknown_marks(found, set(ROW.findall(text(PAGE)))) == []


def test_a_comment_without_a_row_is_noticed():
    assert unknown_marks([("a.h", ""), ("b.h", "A1"), ("c.h", "A999")], {"A1"}) == [
        "a.h: Differs ()",
        "c.h: Differs (A999)",
    ]


def test_rows_have_names_of_their_own():
    assert [row for row, n in Counter(ROW.findall(text(PAGE))).items() if n > 1] == []
