"""C++ statements do one thing: no `a = b, c = d;`."""

import re

import pytest

from codebase.repository import sources

#: Folders that are free of statements joined by commas.
FOLDERS = ["cpp", "tests/core", "tests/cpp"]

#: Comments, strings, characters and preprocessor lines.
QUIET = re.compile(
    r"""//[^\n]*|/\*.*?\*/|R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+'"""
    r"""|^[ \t]*\#(?:\\\n|[^\n])*""",
    re.DOTALL | re.MULTILINE,
)
#: What may stand before a statement, once parentheses are empty.
PREFIX = re.compile(
    r"\s*(?:(?:if|for|while|switch)(?: constexpr)?\s*\(\s*\)|else\b|do\b"
    r"|(?:case\b[^:?]*|\w+)(?<!:):(?!:))"
)
#: How a declaration starts, once template arguments are gone: a type and a name, `auto [a, b]`.
DECLARATION = re.compile(
    r"(?!return\b|throw\b)(?:[^=,]*\w[\s*&]+\w|(?:const\s+)?auto\b|decltype\b)"
)
TEMPLATE_ARGUMENTS = re.compile(r"<[^<>;]*>")
#: What continues an expression after a closing brace.
GOES_ON = re.compile(r"\s*(?:[;,.)\](?:=/|<>%^]|-(?!-)|\+(?!\+))")


def emptied(source: str) -> str:
    """The source without comments and strings; every line stays where it is."""
    return QUIET.sub(
        lambda found: "0" * (found[0][0] in "\"'R") + "\n" * found[0].count("\n"), source
    )


def statements(source: str) -> list[tuple[int, str]]:
    """(last line, text without what is in brackets) of the statements that end in a semicolon."""
    source = emptied(source)
    found: list[tuple[int, str]] = []
    open_brackets: list[tuple[str, str]] = []  # the bracket and the text before it
    text = ""
    line = 1
    for position, letter in enumerate(source):
        line += letter == "\n"
        if letter in "([{":
            open_brackets.append((letter, text + letter))
            text = ""
        elif letter in ")]}" and open_brackets:
            text = open_brackets.pop()[1] + letter
            if letter == "}" and not GOES_ON.match(source, position + 1):
                text = ""
        elif letter == ";" and (not open_brackets or open_brackets[-1][0] == "{"):
            found.append((line, text))
            text = ""
        else:
            text += letter
    return found


def is_joined(statement: str) -> bool:
    """Whether a statement is several expressions with commas between them."""
    while prefix := PREFIX.match(statement):
        statement = statement[prefix.end() :]
    while (bare := TEMPLATE_ARGUMENTS.sub("", statement)) != statement:
        statement = bare
    return "," in statement and not DECLARATION.match(statement.strip())


def joined(source: str) -> list[int]:
    """Lines that statements joined by commas end on."""
    return [line for line, statement in statements(source) if is_joined(statement)]


def test_no_statement_is_joined_by_commas() -> None:
    files = {
        path: source
        for folder in FOLDERS
        for path, source in sources(".h", ".cpp", ".inc", under=folder).items()
    }
    assert sum(len(statements(source)) for source in files.values()) > 500
    found = {path: lines for path, source in files.items() if (lines := joined(source))}
    assert found == {}, "one statement each, with braces where an if or a for has several"


@pytest.mark.parametrize(
    "statement",
    [
        "a = b, c = d;",
        "for (int i = 0; i < n; ++i) sum += v[i], ++count;",
        "if (x) a.b = f(1, 2), c[i] = {3, 4};",
        "else p->x = 1,\n    p->y = 2;",
        "case kOne: a = 1, b = 2;",
        "require(a, 3), require(b, 4);",
        "return n = count, true;",
        'call([&](int i) { s = "x", t = i; }, 1);',
    ],
)
def test_a_joined_statement_is_found(statement: str) -> None:
    assert len(joined("void f() {\n" + statement + "\n}\n")) == 1


@pytest.mark.parametrize(
    "statement",
    [
        "const float a = 1, b = 2;",
        "std::map<int, float> a, b{1, 2};",
        "const Vec3 *a = x, *b = y;",
        "auto [a, b] = pair(1, 2);",
        "for (a = 0, b = 1; a < n; ++a, ++b) f(a, b);",
        "const int v = s.empty() ? f(a, b) : g<int, 2>(c, d);",
        "f(a, b)[1] = {2, 3};",
        "// a = b, c = d;",
        's = "a = 1, b = 2;";',
        "enum class E { kA = 1, kB = 2 };",
        "struct S { S(int a) : a_(a), b_{2} {} int a_, b_; };",
        "const uint64_t n = 1'000, m = '\\'';",
    ],
)
def test_other_commas_are_left_alone(statement: str) -> None:
    assert joined("void f() {\n" + statement + "\n}\n") == []
