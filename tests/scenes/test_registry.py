"""Scenes from text, and what is said about bad text."""

import re
import typing

import pytest

from viscache import scenes
from viscache.scenes.registry import parse


def test_every_scene_of_the_specification_is_there():
    wanted = "random_triangles bumpy_spheres cornell_box room apartment conference hairball"
    wanted += " courtyard window_room cube_on_plane stairs slats slits thin_wall"
    wanted += " garden mushrooms dynamics garage classroom_like church"
    assert sorted(scenes.SCENES) == sorted(wanted.split())
    for info in scenes.SCENES.values():
        assert info.description
        assert getattr(scenes, info.name) is info.function


def test_text_becomes_arguments_of_the_signatures_types():
    info, arguments = parse("room?triangles=200_000&lights=24&panels=true&specular=0")
    assert info.name == "room"
    assert arguments == {"triangles": 200_000, "lights": 24, "panels": True, "specular": False}
    assert parse("random_triangles?edge=2e-2&triangles=1e3")[1] == {"edge": 0.02, "triangles": 1000}
    assert parse("cornell_box")[1] == {}


def test_a_built_scene_knows_what_it_was_made_from():
    assert scenes.build("random_triangles?triangles=50").spec == "random_triangles?triangles=50"
    assert scenes.cornell_box().spec == "cornell_box"
    assert scenes.random_triangles(40, seed=2).spec == "random_triangles?triangles=40&seed=2"


def test_defaults_are_listed():
    assert scenes.SCENES["room"].parameters == {
        "triangles": 200_000,
        "lights": 24,
        "panels": False,
        "specular": False,
    }


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("rom", "unknown scene 'rom'; did you mean 'room'?"),
        ("xyz", "unknown scene 'xyz'; known: "),
        ("room?triangle=5", "room has no parameter 'triangle'; did you mean 'triangles'?"),
        ("cornell_box?q=1", "cornell_box has no parameter 'q'; there are none"),
        ("room?triangles=3", "triangles must be >= 100, got 3"),
        ("room?triangles=many", "triangles must be a whole number, got 'many'"),
        ("room?triangles=inf", "triangles must be a whole number, got 'inf'"),
        ("room?triangles=1.5", "triangles must be a whole number, got '1.5'"),
        ("room?panels=maybe", "panels must be true or false, got 'maybe'"),
        ("room?lights=-1", "lights must be >= 0, got -1"),
        ("room?lights", "lights must have a value"),
        ("room?lights=1&lights=2", "lights must be given once"),
        ("thin_wall?thickness=nan", "thickness must be > 0 and < 1, got nan"),
        ("cube_on_plane?size=inf", "size must be <= 1,000,000,000, got inf"),
        ("slits?count=1e30", "count must be <= 10,000, got 1000000000000000019884624838656"),
    ],
)
def test_bad_text_is_refused_and_the_message_helps(spec, message):
    with pytest.raises(ValueError, match="^" + re.escape(message)):
        scenes.build(spec)


def numbers(info):
    """Name and type of the parameters that are numbers."""
    found = {}
    for name, hint in typing.get_type_hints(info.builder).items():
        kinds = set(typing.get_args(hint) or (hint,)) & {int, float}
        if name != "return" and kinds:
            found[name] = kinds.pop()
    return found


@pytest.mark.parametrize("name", scenes.SCENES)
def test_every_number_has_a_range_and_what_lies_beyond_is_refused(name):
    info = scenes.SCENES[name]
    assert set(info.ranges) == set(numbers(info))
    for parameter, kind in numbers(info).items():
        limits = info.ranges[parameter]
        default = info.parameters[parameter]
        assert default is None or limits.low <= default <= limits.high
        beyond = kind(limits.low) - 1, kind(limits.high) + 1, kind(limits.high) * 10**30
        for value in beyond:
            with pytest.raises(ValueError, match=f"^{parameter} must be "):
                info.function(**{parameter: value})
        for value in ("3", True, 1.5 if kind is int else 1j):
            with pytest.raises(ValueError, match=f"^{parameter} must be a"):
                info.function(**{parameter: value})


COUNTED_IN_PYTHON = {"bumpy_spheres": "spheres", "room": "lights", "slats": "count"}
COUNTED_IN_PYTHON |= {"slits": "count", "stairs": "steps"}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "parameter"), COUNTED_IN_PYTHON.items())
def test_the_largest_counts_end(name, parameter):
    info = scenes.SCENES[name]
    scene = info.function(**{parameter: int(info.ranges[parameter].high)})
    assert scene.triangles > 0
