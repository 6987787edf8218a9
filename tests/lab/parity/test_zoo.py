"""The zoo: how many scenes, of what, and that both renderers read them."""

import re
from collections import Counter
from xml.etree import ElementTree

import pytest

from viscache_lab.parity import renderers, zoo
from viscache_lab.parity.zoo.surfaces import SHAPES, TRANSFORMS

#: Surface and light plugins that Mitsuba 3 documents and RGB files use.
MATERIALS = {
    "diffuse", "plastic", "roughplastic", "conductor", "roughconductor", "dielectric",
    "thindielectric", "roughdielectric", "mask", "twosided", "principled", "bumpmap", "normalmap",
    "blendbsdf", "null",
}  # fmt: skip
LIGHTS = {"area", "point", "spot", "directional", "constant", "envmap", "sunsky"}


@pytest.fixture(scope="module")
def texts():
    return {case.name: case.text() for case in zoo.cases()}


def test_there_are_more_than_300_scenes_with_names_of_their_own(texts):
    cases = zoo.cases()
    assert len(texts) == len(cases) == len({case.file for case in cases}) > 300
    assert len(set(texts.values())) == len(texts)


def test_every_shape_stands_under_every_transform(texts):
    assert {f"shape/{s}-{t}" for s in SHAPES for t in TRANSFORMS} <= set(texts)
    assert {f"emitter/{s}-{t}" for s in SHAPES for t in TRANSFORMS} <= set(texts)
    assert {"mirror-x", "mirror-y", "mirror-z", "sheared", "stretched", "half"} <= set(TRANSFORMS)


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
        for element in ElementTree.parse(path).iter("string"):
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
