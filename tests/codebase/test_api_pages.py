"""The API pages show every public name, and docstrings describe existing parameters."""

import importlib
import inspect
import re
from functools import cached_property

import pytest

import viscache
from codebase.repository import sources

#: Modules whose public names are for users; `viscache.__all__` besides.
MODULES = (
    "viscache.aqvc",
    "viscache.correlation",
    "viscache.correlation.pairs",
    "viscache.correlation.plots",
    "viscache_lab.figures",
    "viscache.metrics",
    "viscache.notebook",
    "viscache.passes.over_time",
    "viscache.plots",
    "viscache.report",
    "viscache.scenes",
    "viscache.sweeps.designs",
    "viscache.sweeps.tune",
    "viscache.metrics.temporal",
    "viscache.testing",
    "viscache.shot.tiles",
    "viscache.metrics.variance",
    "viscache.vismap",
    "viscache.vlf",
    "viscache.base.workers",
)
DIRECTIVE = re.compile(r"^\.\. auto(\w+):: (\S+)$|^\.\. currentmodule:: (\S+)$", re.M)


def module(name):
    # Not by attribute: `viscache.tune` is also a function
    return importlib.import_module(name)


def public(name):
    """Public names of a module: its `__all__`, or what it defines."""
    found = module(name)
    names = getattr(found, "__all__", None) or [
        n
        for n, value in vars(found).items()
        if not n.startswith("_") and getattr(value, "__module__", "") == name
    ]
    return {n: getattr(found, n) for n in names if n != "__version__"}


def resolved(dotted):
    """What an autodoc directive finds by a dotted name."""
    parts = dotted.split(".")
    for split in range(len(parts) - 1, 0, -1):
        try:
            value = module(".".join(parts[:split]))
            for part in parts[split:]:
                value = getattr(value, part)
            return value
        except (ImportError, AttributeError):
            continue
    raise LookupError(dotted)


def shown(pages):
    """Everything that the pages show, by the last part of its name."""
    found = []
    for page, text in pages.items():
        current = ""
        for match in DIRECTIVE.finditer(text):
            kind, name, moved_to = match.groups()
            if moved_to:
                current = moved_to
            elif kind == "module":
                found.append((name, module(name)))
            else:
                for candidate in (name, f"{current}.{name}"):
                    try:
                        found.append((name.split(".")[-1], resolved(candidate)))
                        break
                    except LookupError:
                        continue
                else:
                    raise AssertionError(f"{page} shows {name}, which there is not")
    return found


@pytest.fixture(scope="module")
def everything():
    pages = sources(".rst", under="docs/api/")
    assert len(pages) >= 9
    return shown(pages)


@pytest.mark.parametrize("name", ["viscache", *MODULES])
def test_every_public_name_is_on_a_page(name, everything):
    missing = [
        n
        for n, value in public(name).items()
        if not inspect.ismodule(value)
        and not any(value is one and n == told for told, one in everything)
    ]
    assert missing == []


def test_every_public_module_of_the_package_is_among_those_looked_at():
    # Loads them; `names` has what is loaded
    listed = {v.__name__ for n, v in public("viscache").items() if inspect.ismodule(v)}
    names = {v.__name__ for v in vars(viscache).values() if inspect.ismodule(v)}
    assert listed <= names and listed <= set(MODULES)


def test_a_name_that_no_page_shows_is_found():
    page = ".. currentmodule:: viscache\n\n.. autofunction:: render\n"
    assert shown({"page": page}) == [("render", viscache.render)]
    with pytest.raises(AssertionError, match="there is not"):
        shown({"page": page + ".. autofunction:: rendre\n"})


def documented(value):
    """A function, or a class with its public methods and properties."""
    yield getattr(value, "__name__", ""), value
    for name, member in vars(value).items() if inspect.isclass(value) else ():
        plain = getattr(member, "__func__", member)
        if name.startswith("_") or not (
            inspect.isroutine(plain) or isinstance(plain, property | cached_property)
        ):
            continue
        yield f"{value.__name__}.{name}", plain


def parameters(doc):
    """Names in the section Parameters of a numpy docstring."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=\n\n\w+\n-+\n|\Z)", doc, re.S | re.M)
    lines = section[1].splitlines() if section else []
    heads = [line.split(" : ")[0] for line in lines if line and not line.startswith(" ")]
    return [name.strip().lstrip("*") for head in heads for name in head.split(",")]


def api():
    values = [v for name in ("viscache", *MODULES) for v in public(name).values()]
    kept = [v for v in values if inspect.isclass(v) or inspect.isroutine(v)]
    return sorted({name: v for value in kept for name, v in documented(value)}.items())


def is_documented(name, value):
    """Whether it has a docstring of its own; a dataclass without one shows its signature."""
    doc = (inspect.getdoc(value) or "").strip()
    return doc != "" and not doc.startswith(f"{name}(")


def test_public_names_methods_and_properties_have_docstrings():
    assert [name for name, value in api() if not is_documented(name, value)] == []
    assert is_documented("render", viscache.render) and not is_documented("f", lambda: None)


def test_docstrings_tell_of_parameters_that_there_are():
    found, wrong = 0, []
    for name, value in api():
        told = parameters(inspect.getdoc(value) or "")
        if told and (inspect.isclass(value) or inspect.isroutine(value)):
            found += 1
            known = inspect.signature(value).parameters
            wrong += [f"{name}: {one}" for one in told if one not in known and one != "..."]
    assert found > 60 and wrong == []


def test_functions_with_told_parameters_tell_of_all():
    wrong = []
    for name, value in api():
        told = parameters(inspect.getdoc(value) or "")
        if told and "..." not in told and inspect.isroutine(value):
            known = [p for p in inspect.signature(value).parameters if p not in ("self", "cls")]
            wrong += [f"{name}: {one}" for one in known if one not in told]
    assert wrong == []


def test_a_wrong_parameter_is_found():
    assert parameters(
        "Do.\n\nParameters\n----------\na, b : int\n    Both.\n**c\n\nReturns\n-------\nint\n"
    ) == ["a", "b", "c"]
