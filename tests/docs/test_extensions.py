"""The site's own Sphinx extensions. A CI stage builds the site itself."""

import pytest

from codebase.repository import module, sources, text

ROWS, FETCHED = (module(f"docs/_ext/{n}.py") for n in ("missed_rows", "self_contained"))


def test_missed_goals_are_found_with_their_section_and_column():
    page = (
        "## A part: two\n| frame | goal |\n| --- | --- |\n| one | 5: missed |\n| two | 6 |\n\n"
        "| other | |\n| --- | --- |\n| three | missed, just |\n"
    )
    found = [(row.section, row.what, row.words) for row in ROWS.missed(page)]
    assert found == [
        ("A part: two", "one", "goal: 5: missed"),
        ("A part: two", "three", "missed, just"),
    ]
    assert ROWS.anchor("A part: two") == "a-part-two"


def test_the_pages_of_measurements_name_missed_goals():
    pages = sources(".md", under="docs/performance/")
    found = [row for page in pages.values() for row in ROWS.missed(page)]
    assert len(found) >= 10
    assert {"Whole frames", "Rays"} <= {row.section for row in found}


def test_the_summary_repeats_no_missed_goal():
    assert list(ROWS.missed(text("docs/performance.md"))) == []


@pytest.mark.parametrize(
    ("page", "suffix"),
    [
        ('<script src="https://cdn.example/a.js"></script>', ".html"),
        ('<link rel="stylesheet" href="//fonts.example/a.css">', ".html"),
        ('<img src="http://example/a.png">', ".html"),
        ("<style>@import 'https://example/a.css';</style>", ".html"),
        ('<p style="background: url(https://example/a.png)">', ".html"),
        ("@font-face { src: url('https://example/a.woff2') }", ".css"),
    ],
)
def test_what_a_page_fetches_from_elsewhere_is_found(page, suffix):
    assert len(list(FETCHED.outside(page, suffix))) == 1


def test_links_and_local_files_are_not_taken_for_it():
    page = (
        '<a href="https://example.org">x</a><script src="_static/a.js"></script>'
        '<img src="data:image/png;base64,aaaa"><pre>url(https://example.org)</pre>'
    )
    assert list(FETCHED.outside(page, ".html")) == []
    assert list(FETCHED.outside("a { src: url(../a.woff2) }", ".css")) == []
