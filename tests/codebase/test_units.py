"""The units that compilers read (cpp/units.txt). Two files of one cannot define the same name."""

from fnmatch import fnmatch

from codebase.repository import paths, text

COMPILED = (*paths(".cpp", under="cpp/"), *paths(".cpp", under="tests/core/"))


def units():
    """Seconds, megabytes and files of each unit, in the order of the table."""
    rows = [line.split() for line in text("cpp/units.txt").splitlines() if line[:1].isalpha()]
    return {
        row[0]: (
            float(row[1]),
            float(row[2]),
            [path for path in COMPILED if any(fnmatch(path, pattern) for pattern in row[4:])],
        )
        for row in rows
    }


def test_every_file_is_in_one_unit():
    of_units = [path for _, _, files in units().values() for path in files]
    assert sorted(of_units) == sorted(COMPILED)


def test_the_longest_units_come_first_and_none_is_too_large():
    seconds = [row[0] for row in units().values()]
    assert seconds == sorted(seconds, reverse=True), "run scripts/weigh_units"
    assert len(seconds) <= 32
    assert max(megabytes for _, megabytes, _ in units().values()) <= 1050
