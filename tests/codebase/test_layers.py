"""The layer rule of docs/design.md, checked by scanning #include lines."""

import re
from pathlib import PurePosixPath

import pytest

from codebase.repository import sources

# A folder may include itself and folders of lower rank, so methods never include each other.
RANKS = {
    "math": 0,
    "sampling": 1,
    "scene": 2,
    "formats": 3,
    "visibility": 3,
    "casters": 4,
    "shafts": 4,
    "oracles": 4,
    "aqvc": 5,
    "vlf": 5,
    "vismap": 5,
    "correlation": 5,
    "render": 6,
}
# Rooms that nothing in the core includes: a scene does not know where it came from.
FOR_BINDINGS = ("formats",)
# One header hides Embree's versions, for the two casters that use it; another fills the packets of
# the first.
EMBREE_HOME = "cpp/viscache/casters/embree_caster.cpp"
EMBREE_BOXES = "cpp/viscache/casters/watertight_caster.cpp"
EMBREE_PACKETS = "cpp/viscache/casters/embree_packets.h"
EMBREE_VERSIONS = "cpp/viscache/casters/embree.h"
EMBREE_INCLUDED_BY = {
    EMBREE_PACKETS: (EMBREE_HOME,),
    EMBREE_VERSIONS: (EMBREE_PACKETS, EMBREE_BOXES),
}
# Bindings of the package, and of what only tests call.
BINDINGS = ("cpp/bindings/", "tests/core/")
INCLUDE = re.compile(r"""^\s*#\s*include\s*(["<])([^">]+)[">]""", re.M)


def violations(files):
    for path, text in files.items():
        parts = PurePosixPath(path).parts
        folder = parts[2] if parts[:2] == ("cpp", "viscache") else None
        if folder is not None and (folder not in RANKS or len(parts) != 4):
            yield f"{path}: folders of the core are {', '.join(RANKS)}, one level deep"
            continue
        for quote, included in INCLUDE.findall(text):
            outside = PurePosixPath(included).parts
            if re.search(r"^embree\d*/|rtcore", included):
                if path != EMBREE_VERSIONS:
                    yield f"{path}: only {EMBREE_HOME} includes Embree, got {included}"
            elif path not in EMBREE_INCLUDED_BY.get(f"cpp/{included}", (path,)):
                yield f"{path}: only {EMBREE_HOME} includes Embree, got {included}"
            if re.search(r"^pybind11/|^Python\.h$", included) and not path.startswith(BINDINGS):
                yield f"{path}: only {' and '.join(BINDINGS)} include pybind11, got {included}"
            if folder is None:
                continue
            if outside[0] == "viscache":
                target = outside[1]
                if target not in RANKS:
                    yield f"{path}: there is no folder {target}"
                elif target != folder and (
                    RANKS[target] >= RANKS[folder] or target in FOR_BINDINGS
                ):
                    yield f"{path}: {folder} must not include {target}, got {included}"
            elif quote == '"' and not included.endswith(".inc"):  # a body compiled once per ISA
                yield f'{path}: own headers are included as "viscache/<folder>/…", got {included}'


def test_the_core_keeps_its_layers():
    files = sources(".h", ".cpp", under="cpp/") | sources(".h", ".cpp", under="tests/core/")
    for folder in ("cpp/viscache/", *BINDINGS):
        assert any(path.startswith(folder) for path in files)
    assert list(violations(files)) == []


@pytest.mark.parametrize(
    ("path", "line", "expected"),
    [
        ("cpp/viscache/math/a.h", '#include "viscache/scene/b.h"', "math must not include scene"),
        ("cpp/viscache/aqvc/a.h", '#  include "viscache/vlf/b.h"', "aqvc must not include vlf"),
        ("cpp/viscache/render/a.h", '#include "viscache/formats/b.h"', "must not include formats"),
        ("cpp/viscache/utils/a.h", "", "folders of the core are"),
        ("cpp/viscache/math/deep/a.h", "", "one level deep"),
        ("cpp/viscache/math/a.h", '#include "vec.h"', "own headers are included as"),
        ("cpp/viscache/render/a.cpp", "#include <embree3/rtcore.h>", "only cpp/viscache/casters"),
        ("cpp/viscache/render/a.h", '#include "viscache/casters/embree.h"', "includes Embree"),
        (EMBREE_HOME, '#include "viscache/casters/embree.h"', "includes Embree"),
        (EMBREE_BOXES, '#include "viscache/casters/embree_packets.h"', "includes Embree"),
        (
            "cpp/viscache/vlf/a.cpp",
            '#include "viscache/casters/embree_packets.h"',
            "includes Embree",
        ),
        ("cpp/viscache/math/a.h", "#include <pybind11/numpy.h>", "only cpp/bindings"),
        ("tests/cpp/a.cpp", "#include <pybind11/numpy.h>", "only cpp/bindings"),
        ("tests/cpp/a.cpp", "#include <embree4/rtcore.h>", "includes Embree"),
        ("cpp/viscache/math/a.h", '#include "viscache/utils/b.h"', "there is no folder utils"),
        # Allowed
        ("cpp/viscache/render/a.cpp", '#include "viscache/aqvc/b.h"', None),
        ("cpp/viscache/aqvc/a.cpp", '#include "viscache/aqvc/b.h"', None),
        ("cpp/viscache/aqvc/a.cpp", '#include "viscache/oracles/b.h"', None),
        ("cpp/bindings/bind_a.cpp", '#include "viscache/formats/b.h"', None),
        (EMBREE_HOME, '#include "viscache/casters/embree_packets.h"', None),
        (EMBREE_PACKETS, '#include "viscache/casters/embree.h"', None),
        (EMBREE_BOXES, '#include "viscache/casters/embree.h"', None),
        (EMBREE_VERSIONS, "#include <embree4/rtcore.h>", None),
        ("cpp/bindings/bind_a.cpp", "#include <pybind11/pybind11.h>", None),
        ("tests/core/bind_a.cpp", "#include <pybind11/pybind11.h>", None),
        ("cpp/viscache/math/a.h", "#include <vector>", None),
    ],
)
def test_a_broken_rule_is_found_and_nothing_else(path, line, expected):
    found = list(violations({path: line + "\n"}))
    assert len(found) == (expected is not None)
    assert all(expected in says for says in found)
