"""The zoos: how many files, of what; both renderers read Mitsuba's, formulas judge exporters'."""

import math
import re
from collections import Counter
from dataclasses import replace
from itertools import product
from xml.etree import ElementTree

import numpy as np
import pytest

from viscache_lab.parity import exporters, renderers, zoo

#: Surface and light plugins that Mitsuba 3 documents and RGB files use.
MATERIALS = {
    "diffuse", "plastic", "roughplastic", "conductor", "roughconductor", "dielectric",
    "thindielectric", "roughdielectric", "mask", "twosided", "principled", "bumpmap", "normalmap",
    "blendbsdf", "null",
}  # fmt: skip
SHAPES = ("rectangle", "disk", "cube", "sphere", "cylinder", "obj", "ply", "serialized")
TRANSFORMS = (
    "plain", "rotated", "long-axis", "half", "stretched", "tall", "sheared", "mirror-x",
    "mirror-y", "mirror-z", "mirror-all", "mirror-rotated", "lookat",
)  # fmt: skip
LIGHTS = {"area", "point", "spot", "directional", "constant", "envmap", "sunsky"}


@pytest.fixture(scope="module")
def texts():
    return {case.name: case.text for case in zoo.cases()}


def test_there_are_more_than_300_scenes_with_names_of_their_own(texts):
    cases = zoo.cases()
    assert len(texts) == len(cases) == len({case.file for case in cases}) > 300
    assert len(set(texts.values())) == len(texts)


def test_every_shape_stands_under_every_transform(texts):
    for kind, shape, transform in product(("shape", "emitter"), SHAPES, TRANSFORMS):
        assert f"{kind}/{shape}-{transform}" in texts


def test_every_kind_of_material_and_light_is_there(texts):
    kinds = Counter(kind for text in texts.values() for kind in re.findall(r'type="(\w+)"', text))
    assert set(kinds) >= MATERIALS | LIGHTS | {"bitmap", "checkerboard", "orthographic", "thinlens"}


def test_the_quick_sample_has_each_group_and_few_scenes():
    full, quick = zoo.cases(), zoo.cases(quick=True)
    assert {case.group for case in quick} >= {case.group for case in full} - {"uv", "normals"}
    assert 40 <= len(quick) <= 100


def test_files_are_well_formed_and_name_files_that_are_there(tmp_path):
    paths = zoo.write(tmp_path, zoo.cases())
    for path in paths.values():
        scene = ElementTree.parse(path).getroot()
        assert not "".join(scene.itertext()).strip(), "a piece that the table does not have"
        for element in scene.iter("string"):
            if element.get("name") == "filename":
                assert (tmp_path / str(element.get("value"))).is_file(), path.name


@pytest.mark.slow
@pytest.mark.mitsuba
def test_both_renderers_load_the_quick_sample(tmp_path):
    if reason := renderers.missing():
        pytest.skip(reason)
    paths = zoo.write(tmp_path, zoo.cases(quick=True))
    refused = []
    with renderers.mitsuba() as mi:
        for name, path in paths.items():
            for loaded in (renderers.load_viscache(path), renderers.load_mitsuba(mi, path)):
                refused += [] if loaded.render is not None else [(name, loaded.warnings)]
    assert refused == []


def verdicts(folder, rows):
    paths = exporters.write(folder, rows)
    return [exporters.judge_row(row, paths[row.name]) for row in rows]


def row_named(name):
    (row,) = [row for row in exporters.rows() if row.name == name]
    return row


def test_each_format_has_60_exporters_files_that_differ():
    rows = exporters.rows()
    counts = Counter(row.name.partition("/")[0] for row in rows)
    assert set(counts) == {"gltf", "pbrt3", "pbrt4", "obj", "ply"} and min(counts.values()) >= 60
    stems = [re.sub(r"[\w-]+\.mtl", "a.mtl", str([*row.files.values()])) for row in rows]
    assert len({row.name for row in rows}) == len(rows)
    twice = Counter(zip(stems, (row.feature in ("light", "camera") for row in rows), strict=True))
    assert [stem for stem, count in twice.items() if count > 1] == []


def test_the_quick_sample_has_each_feature_of_each_format_once():
    kinds = [(row.name.partition("/")[0], row.feature) for row in exporters.rows(quick=True)]
    full = {(row.name.partition("/")[0], row.feature) for row in exporters.rows()}
    assert set(kinds) == full and len(kinds) == len(full)


@pytest.mark.parametrize(
    ("kind", "count"), [("gltf", 179), ("pbrt3", 147), ("pbrt4", 164), ("obj", 146), ("ply", 111)]
)
def test_as_many_exporters_files_agree_and_no_others_differ_without_a_warning(
    tmp_path, kind, count
):
    found = verdicts(tmp_path, [row for row in exporters.rows() if row.name.startswith(kind)])
    missed = [(r.name, r.why, r.about) for r in found if r.silent_miss]
    assert missed == []
    assert sum(r.verdict == "agrees" for r in found) >= count


@pytest.mark.parametrize(
    "name, right, verdict",
    [
        ("obj/kd-rgb", ".8,.6,.4", "agrees"),
        ("obj/kd-rgb", ".8,.6,.41", "differs"),
        ("obj/kd-rgb", "said", "differs"),
        ("obj/map_kd-plain", "B A D C", "differs"),
        ("obj/map_kd-missing", "A B C D", "warned"),
        ("obj/map_kd-missing", ".502886", "warned though right"),
        ("obj/face-word", ".5", "not loaded"),
        ("pbrt3/light-point", "lit 2.6", "differs"),
    ],
)
def test_a_file_is_judged_by_what_is_right(tmp_path, name, right, verdict):
    (found,) = verdicts(tmp_path, [replace(row_named(name), right=right)])
    assert found.verdict == verdict
    assert found.about.endswith(f"; right: {right}")


def test_what_is_right_has_its_closed_forms():
    assert exporters.expected(".5").shape == (16, 16, 3)
    assert exporters.expected("3 A B 3 3 C D 3").shape == (16, 32, 3)
    top = exporters.expected(".1 .2 .3 .4")[0, :, 0]
    assert top[0] == np.float32(0.1) and top[-1] == np.float32(0.2)
    # A white furnace, and a metal that is almost a mirror
    assert exporters.furnace(0.5, 0, 1, 0, 0) == pytest.approx(0.5, rel=1e-6)
    assert exporters.furnace(0.8, 1, 0.1) == pytest.approx(exporters.BRIGHT * 0.8, rel=0.01)
    # Under a lamp far away, and under one that covers the sky
    assert exporters.lamp(1, 0.01, 10) == pytest.approx(0.5 * 0.02**2 / 100 / math.pi, rel=1e-3)
    assert exporters.lamp(1, 1e4, 1) == pytest.approx(0.5, rel=1e-3)
