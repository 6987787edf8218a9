"""What the repository weighs, as a table or as JSON: `scripts/weight [--json]`.

Lines are all lines of a file; in C++, those that hold nothing but a comment are counted apart.
Rooms and imports are those of `test_python_layers`. Words are those of pages, with their code.
"""

import ast
import json
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from codebase import test_python_layers as layers
from codebase.repository import paths, sources, text

LIBRARY = "python/viscache/"
#: Where the seven calls that take the most are defined.
ENTRY_POINTS = (
    "render",
    "sweep",
    "tune",
    "Progressive",
    "passes_over_time",
    "connections",
    "measure",
)
PARTS = {
    "core": ("cpp/viscache/", (".h", ".cpp", ".inc")),
    "bindings": ("cpp/bindings/", (".h", ".cpp")),
    "python": (LIBRARY, (".py",)),
    "lab": ("python/viscache_lab/", (".py",)),
    "tests": ("tests/", (".py", ".h", ".cpp", ".toml")),
    "scripts": ("scripts/", ("",)),
}
PAGES = {
    "README": ("README.md",),
    "performance": ("docs/performance",),
    "reference": (
        "docs/design.md",
        "docs/deviations.md",
        "docs/papers.md",
        "docs/claims.md",
        "docs/extremes.md",
    ),
    "CHANGELOG": ("CHANGELOG.md",),
    "user pages": ("docs/",),  # all others
}
LONGEST, MOST_BRANCHES = 80, 30


def cpp_lines(source: str) -> tuple[int, int]:
    """Lines, and those that hold nothing but a comment."""
    comments, inside = 0, False
    for line in (line.strip() for line in source.splitlines()):
        inside = inside or line.startswith("/*")
        comments += inside or line.startswith("//")
        inside = inside and not line.endswith("*/")
    return source.count("\n"), comments


def rooms(files: Mapping[str, str]) -> dict[str, int]:
    """Rooms of the library, and pairs of a room and one that it imports."""
    arrows = layers.pairs(files)
    return {
        "rooms": len({room for pair in arrows for room in pair}),
        "imports between rooms": len(arrows),
        "imports that run back up": sum(layers.RANKS[a] < layers.RANKS[b] for a, b in arrows),
        "circles": len(layers.circles(arrows)),
    }


def settings_fields(trees: dict[str, ast.Module]) -> int:
    """Fields of the dataclasses that users give as settings."""

    def is_setting(node: ast.ClassDef) -> bool:
        marks = [ast.unparse(decorator) for decorator in node.decorator_list]
        return any(mark == "setting" or mark.startswith("registered(") for mark in marks)

    return sum(
        isinstance(line, ast.AnnAssign) and "ClassVar" not in ast.unparse(line.annotation)
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and is_setting(node)
        for line in node.body
    )


def parameters(trees: dict[str, ast.Module]) -> dict[str, int]:
    """Parameters of the entry points, without `self`; the keywords of a shot count as one."""
    found = {}
    for path, tree in trees.items():
        for node in tree.body:
            if getattr(node, "name", None) not in ENTRY_POINTS or "/commands/" in path:
                continue
            call = node
            if isinstance(node, ast.ClassDef):
                call = next(
                    n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"
                )
            if isinstance(call, ast.FunctionDef):
                named = [*call.args.posonlyargs, *call.args.args, *call.args.kwonlyargs]
                own = [a for a in named if a.arg != "self"]
                found[node.name] = len(own) + bool(call.args.kwarg)
    return found


BRANCHES = (
    ast.If,
    ast.For,
    ast.While,
    ast.ExceptHandler,
    ast.IfExp,
    ast.comprehension,
    ast.BoolOp,
    ast.match_case,
)


def long_in_python(path: str, tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if not isinstance(node, ast.FunctionDef):
            continue
        doc = node.body[0] if ast.get_docstring(node) is not None else None
        first = doc.end_lineno + 1 if doc else node.body[0].lineno
        lines = node.end_lineno - first + 1
        branches = sum(isinstance(n, BRANCHES) for n in ast.walk(node))
        if lines > LONGEST or branches > MOST_BRANCHES:
            yield f"{path}: {node.name}, {lines} lines, {branches} branches"


def long_in_cpp(path: str, source: str) -> Iterator[str]:
    """Functions of formatted code: from a line that opens one to the `}` that stands below it."""
    lines = source.splitlines()
    start, depth, name = -1, "", ""
    for number, line in enumerate(lines):
        indent = re.match(" *", line)[0]
        if start < 0:
            ends = line.rstrip().endswith("{") and ("(" in line or ")" in line)
            if (
                ends
                and len(indent) in (0, 4)
                and not re.match(
                    r" *(namespace|struct|class|enum|union|if|for|while|switch|else|do)\b", line
                )
            ):
                start, depth, name = number, indent, line.strip()
        elif line.startswith(f"{depth}}}") and not line.startswith(f"{depth} "):
            body = [cut for cut in lines[start : number + 1] if not cut.strip().startswith("//")]
            branches = sum(
                len(re.findall(r"\b(?:if|for|while|case|catch)\b|\?(?=[ \n])|&&|\|\|", cut))
                for cut in body
            )
            if len(body) > LONGEST or branches > MOST_BRANCHES:
                yield f"{path}: {name[:60]}, {len(body)} lines, {branches} branches"
            start = -1


def words(pages: list[str]) -> dict[str, int]:
    counts = dict.fromkeys(PAGES, 0)
    for path in pages:
        if path.endswith((".md", ".rst")) and path.startswith(("README", "CHANGELOG", "docs/")):
            section = next(name for name, starts in PAGES.items() if path.startswith(starts))
            counts[section] += len(text(path).split())
    return counts


def weigh() -> dict[str, object]:
    """Everything that the limits name, and the functions that are too long."""
    every = paths()
    lines = {}
    comments = in_all = 0
    for part, (under, ends) in PARTS.items():
        lines[part] = 0
        for path in (p for p in every if p.startswith(under) and p.endswith(ends)):
            if path.startswith("cpp/"):
                here, said = cpp_lines(text(path))
                comments, in_all = comments + said, in_all + here
                lines[part] += here - said
            else:
                lines[part] += text(path).count("\n")
    library = sources(".py", under=LIBRARY)
    trees = {path: ast.parse(text) for path, text in library.items()}
    units = [line.split() for line in text("cpp/units.txt").splitlines() if line[:1].isalpha()]
    units = [unit for unit in units if not unit[0].startswith("testing")]
    virtuals = re.findall(
        r"virtual .*?\b(~?\w+)\(",
        text("cpp/viscache/visibility/oracle.h").partition("class VisibilityOracle")[2],
    )
    overrides = re.compile(
        rf"\b(?:{'|'.join(v for v in virtuals if v[0] != '~')})\([^;{{]*\boverride\b", re.S
    )
    cpp = {
        path: text(path)
        for path in every
        if path.startswith("cpp/") and path.endswith((".h", ".cpp", ".inc"))
    }
    long = [text for path, source in cpp.items() for text in long_in_cpp(path, source)]
    long += [text for path, tree in trees.items() for text in long_in_python(path, tree)]
    given = parameters(trees)
    return {
        "library, lines": lines["core"] + lines["bindings"] + lines["python"],
        **{f"{part}, lines": count for part, count in lines.items()},
        "C++ comments, lines per 1000": round(1000 * comments / in_all),
        **rooms(library),
        "units": len(units),
        "units, CPU s": round(sum(float(unit[1]) for unit in units)),
        "parameters of entry points": sum(given.values()),
        "settings fields": settings_fields(trees),
        "virtuals of VisibilityOracle": len(virtuals),
        "overrides of them": sum(len(overrides.findall(source)) for source in cpp.values()),
        "long functions": len(long),
        **{f"{section}, words": count for section, count in words(every).items()},
        "which": {"long functions": long, "parameters": given},
    }


def main() -> None:
    found = weigh()
    if "--json" in sys.argv[1:]:
        print(json.dumps(found, indent=1))
        return
    which = found.pop("which")
    for name, value in found.items():
        print(f"{name:32} {value:>8,}")
    print("\n".join(which["long functions"]), file=sys.stderr)


if __name__ == "__main__":
    main()
