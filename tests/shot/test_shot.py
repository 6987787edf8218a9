"""A picture is known by values: the same in every process and folder, another for every change."""

import dataclasses
import inspect
import json
import os
import pickle
import subprocess
import sys
import threading
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import viscache as vc
from viscache.scene import SceneError
from viscache.shot import tiles
from viscache.shot.identity import by_value
from viscache.shot.shot import ShotArguments, require_same
from viscache.sweeps import work

SIZE = (16, 10)
SKY = vc.Direct(n_area=1, n_environment=2)
EYE = ((3, 2, 3), (0, 0, 0))


def pixels(factor=1.0):
    return factor * np.abs(np.random.default_rng(0).normal(size=(8, 16, 3))).astype(np.float32)


def write_sky(path, factor=1.0):
    vc.Frame(layers={"color": pixels(factor)}).save(path)
    return path


def shot(**changes):
    given = {"scene": "cube_on_plane", "integrator": SKY, "size": SIZE}
    return vc.Shot(**(given | changes))


def picture(**options):
    given = {"visibility": "exact", "size": SIZE, "threads": 1} | options
    return vc.Progressive("cube_on_plane", SKY, **given)


#: Run in two folders: prints keys of shots that hold objects of all kinds; goes on from a state.
ELSEWHERE = """
import json, sys
from dataclasses import dataclass
from pathlib import Path
import numpy as np
import viscache as vc
import own

sky, state, resume = sys.argv[1:4]
pixels = np.abs(np.random.default_rng(0).normal(size=(8, 16, 3)))
scene = vc.scenes.build("cube_on_plane")
cache = vc.VisibilityMapCache(scene)
cache.update(size=(8, 6))
view = vc.look_at((3, 2, 3), (0, 0, 0))
light = vc.Direct(n_area=1, n_environment=2)
given = {"scene": scene, "integrator": light, "size": (16, 10)}
lights = vc.Whitted(vpls=vc.Vpls([(0, 3, 0)], [(0, -1, 0)], [(5, 5, 5)]))
shots = {
    "array": {"env": pixels, "camera": view},
    "file": {"env": sky},
    "sky": {"env": vc.Sky(sun_direction=(0.2, 0.9, 0.3))},
    "maps": {"visibility": vc.VisMaps(cache=cache)},
    "own": {"visibility": own.Own(table=pixels, sees={"b", "a"}, view=view, keep={"scene": scene})},
    "lights": {"integrator": lights, "visibility": "aqvc", "use": vc.Correct(share=0.5)},
}
found = {name: vc.Shot(**(given | more)).key for name, more in shots.items()}
options = {"visibility": "exact", "size": (16, 10), "threads": 1}
image = vc.Progressive(scene, light, env=sky, camera=view, **options)
if resume == "resume":
    image.load(state)
else:
    image.passes(2)
    image.save(state)
    image.passes(1)
found["bytes"] = image.passes(3 - image.n_passes).sha256
found["passes"] = image.n_passes
print(json.dumps(found))
"""
OWN = """
from dataclasses import dataclass
from typing import Any

@dataclass
class Own:
    table: Any
    sees: Any
    view: Any
    keep: Any

    def block(self, eyes, lamps, wanted):
        return wanted if self.table in {"x", "y", "z", 3.5} else ~wanted
"""


def test_keys_and_states_are_the_same_in_another_process_and_folder(tmp_path):
    found, bytes_of_sky = [], write_sky(tmp_path / "sky.exr").read_bytes()
    for name, how in (("first", "begin"), ("second", "resume")):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "own.py").write_text(OWN)
        sky = folder / f"sky of {name}.exr"
        sky.write_bytes(bytes_of_sky)
        path = os.pathsep.join([str(folder), str(Path(vc.__file__).parents[1])])
        env = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": str(len(name))}
        command = [sys.executable, "-c", ELSEWHERE, str(sky), str(tmp_path / "state.npz"), how]
        made = subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True)
        assert made.returncode == 0, made.stderr
        found.append(json.loads(made.stdout))
    assert found[0] == found[1]
    assert len(set(found[0].values())) == len(found[0])
    given = shot(env=pixels().astype(np.float64), camera=vc.look_at(*EYE))
    assert given.with_(scene=vc.scenes.cube_on_plane()).key == given.key == found[0]["array"]


@dataclasses.dataclass
class Own:
    """An oracle that holds something."""

    held: Any = 1

    def block(self, eyes, lamps, wanted):
        return wanted


class Other(Own):
    """The same fields and other code."""

    def block(self, eyes, lamps, wanted):
        return ~wanted & wanted


class Slots:
    """Not a dataclass, and its attribute has no place among `vars`."""

    __slots__ = ("held",)

    def __init__(self, held):
        self.held = held

    def block(self, eyes, lamps, wanted):
        return wanted


def maps(size):
    cache = vc.VisibilityMapCache("cube_on_plane")
    cache.update(size=size)
    return vc.VisMaps(cache=cache)


#: What changes a picture: two values each, and the part that must differ.
CHANGES = [
    ("scene", "cube_on_plane", "slits", "scene"),
    ("integrator", "direct", "ao", "integrator.name"),
    ("integrator", vc.Direct(n_area=2), vc.Direct(n_area=3), "integrator.n_area"),
    ("visibility", "exact", "aqvc", "visibility.name"),
    ("visibility", vc.Aqvc(c_e=8), vc.Aqvc(c_e=9), "visibility.c_e"),
    ("visibility", Own(1), Own(2), "visibility.held"),
    ("visibility", Own(np.arange(3)), Own(np.arange(3) + 1), "visibility.held"),
    ("visibility", Own(partial(max, 1)), Own(partial(max, 2)), "visibility.held"),
    ("visibility", Own([len]), Own([max]), "visibility.held"),
    ("visibility", Own(maps((8, 6))), Own(maps((48, 32))), "visibility.held.cache"),
    ("visibility", Own({1: 2}), Own({1: 3}), "visibility.held.1"),
    ("visibility", Own({1: 2}), Own({"1.0": 2}), "visibility.held.1"),
    ("visibility", Own(np.array(["a"], object)), Own(np.array(["b"], object)), "visibility.held"),
    ("visibility", Own(Slots(1)), Own(Slots(2)), "visibility.held"),
    ("visibility", Slots(1), Slots(2), "visibility.state"),
    ("visibility", Own(), Other(), "visibility.name"),
    ("visibility", maps((8, 6)), maps((48, 32)), "visibility.cache"),
    ("rays", "embree", "bsp", "rays.name"),
    ("use", None, "correct", "use"),
    ("use", vc.Correct(share=0.5), vc.Correct(share=0.25), "use.share"),
    ("size", (16, 10), (10, 16), "size"),
    ("spp", 1, 2, "spp"),
    ("seed", 0, 1, "seed"),
    ("camera", vc.look_at(*EYE), vc.look_at((3, 2, 4), (0, 0, 0)), "camera.origin"),
    ("camera", None, vc.look_at(*EYE, fov_deg=20), "camera"),
    ("env", None, 1.0, "env"),
    ("env", 1.0, (1.0, 1.0, 0.5), "env"),
    ("env", pixels(), pixels(2), "env"),
    ("env", pixels().reshape(16, 8, 3), pixels(), "env"),
    ("env", vc.Sky(turbidity=2), vc.Sky(turbidity=3), "env.turbidity"),
]


@pytest.mark.parametrize(("field", "one", "other", "part"), CHANGES)
def test_every_change_has_another_key_and_is_named(field, one, other, part):
    visibility = "aqvc" if field == "use" else "exact"
    first = shot(visibility=visibility).with_(**{field: one})
    second = first.with_(**{field: other})
    assert first.key != second.key == shot(**{"visibility": visibility, field: other}).key
    assert first.key == second.with_(**{field: one}).key
    with pytest.raises(ValueError, match=rf"^{part}[.\w]* must be .* in both, got "):
        require_same(first.parts, second.parts, "in both")


def test_what_is_the_same_picture_has_the_same_key(tmp_path):
    scene = vc.scenes.build("stairs")
    view = scene.cameras[0]
    same = [
        shot(scene=scene, visibility="aqvc"),
        shot(scene="stairs", visibility=vc.Aqvc(), rays="embree", use="replace", threads=2),
        *(shot(scene=scene, visibility="aqvc", camera=c) for c in (0, view.name, view)),
    ]
    assert len({s.key for s in same}) == 1
    sky, copied = write_sky(tmp_path / "a.exr"), tmp_path / "b.exr"
    copied.write_bytes(sky.read_bytes())
    assert len({shot(env=env).key for env in (sky, str(sky), copied)}) == 1
    assert shot(env=0.5).key == shot(env=[0.5, 0.5, 0.5]).key
    renamed = vc.look_at(*EYE)
    renamed.name = "mine"
    assert shot(camera=renamed).key == shot(camera=vc.look_at(*EYE)).key


def test_what_says_nothing_of_its_value_is_refused_until_it_does():
    loop = []
    loop.append(loop)
    for held in (threading.Lock(), loop, {"a": [threading.Lock()]}):
        with pytest.raises(ValueError, match=r"visibility\.held.* must be known by its value"):
            _ = shot(visibility=Own(held)).key
        own = Own(held)
        own.content_hash = "1"  # type: ignore[attr-defined]
        other = dataclasses.replace(own)
        other.content_hash = "2"  # type: ignore[attr-defined]
        assert shot(visibility=own).key != shot(visibility=other).key
    # Addresses of objects are no value
    values = [by_value(np.array([1, "a", None], object), "held") for _ in range(2)]
    assert values[0] == values[1] and "0x" not in str(values)


@pytest.mark.parametrize(
    ("one", "other", "part"),
    [
        ({"env": pixels()}, {"env": pixels(2)}, "env"),
        ({"camera": vc.look_at(*EYE)}, {"camera": vc.look_at((3, 2, 4), (0, 0, 0))}, "camera"),
        ({"visibility": Own(1)}, {"visibility": Own(2)}, "visibility"),
    ],
)
def test_passes_of_another_picture_are_refused(tmp_path, one, other, part):
    first, second = picture(**one), picture(**other, first_pass=4)
    first.passes(1)
    first.save(tmp_path / "state.npz")
    want = second.passes(1).sha256
    with pytest.raises(ValueError, match=rf"{part}[.\w]* must be .* as in .*state.npz, got"):
        second.load(tmp_path / "state.npz")
    with pytest.raises(ValueError, match=rf"{part}[.\w]* must be .* in both, got"):
        second.merge(first)
    assert second.frame.sha256 == want


def test_all_passes_have_the_sky_and_the_camera_of_the_first(tmp_path):
    sky, array, view = write_sky(tmp_path / "sky.exr"), pixels(), vc.look_at(*EYE)
    given = [sky, array]
    pictures = [picture(env=env, camera=view) for env in given]
    want = [p.passes(1).sha256 for p in pictures]
    wanted = picture(env=pixels(), camera=vc.look_at(*EYE)).passes(3).sha256
    write_sky(sky, 2)
    array *= 2
    view.fov_rad = 0.2
    assert [p.passes(2).sha256 for p in pictures] == 2 * [wanted]
    pictures[0].save(tmp_path / "state.npz")
    for changed in given:
        other = picture(env=changed, camera=vc.look_at(*EYE))
        assert other.passes(1).sha256 not in want
        with pytest.raises(ValueError, match="env must be"):
            other.load(tmp_path / "state.npz")
    with pytest.raises(SceneError, match="no such file"):
        picture(env=tmp_path / "absent.exr")


def test_a_sky_that_changes_during_a_sweep_is_refused(tmp_path):
    planned = shot(env=str(write_sky(tmp_path / "sky.exr")))
    assert planned.parts["env"].startswith("file sha256 ")
    write_sky(tmp_path / "sky.exr", 2)
    with pytest.raises(ValueError, match=r"env must be .* as when the work began, got"):
        work.render_task(planned)


def test_parts_of_another_picture_are_not_merged(tmp_path):
    def part(number, **options):
        given = {"size": (150, 40)} | options
        return tiles.render_in_worker(shot(**given), (number, 2))

    sky = write_sky(tmp_path / "sky.exr")
    first = part(0, env=sky)
    assert tiles.merge([first, part(1, env=sky, threads=1)]).image.any()
    others = {r"camera\.origin": {"camera": vc.look_at(*EYE)}, "seed": {"seed": 1}, "env": {}}
    for name, other in others.items():
        if name == "env":
            write_sky(sky, 2)
        with pytest.raises(ValueError, match=rf"{name} must be .* in all parts, got"):
            tiles.merge([first, part(1, env=sky, **other)])


def test_a_shot_travels_with_its_parts():
    """Workers compare what they open with what the sweep began with."""
    given = shot(visibility="aqvc", env=pixels(), camera=vc.look_at(*EYE), threads=2)
    for sent in (given, given.opened_by("slits"), given.with_(seed=3)):
        back = pickle.loads(pickle.dumps(sent))
        assert back.parts == sent.parts and back.threads == 2
        assert back.seed == sent.seed and back.scene == sent.scene
    with pytest.raises(ValueError, match="scene slits is not the one the work began with"):
        work.render_task(given.opened_by("slits"))


def test_a_shot_is_a_value(tmp_path):
    made = vc.Shot("cube_on_plane", "direct?n_area=1&n_environment=2", size=SIZE, threads=2)
    assert made == shot() and hash(made) == hash(shot()) and len({made, shot(), shot(seed=1)}) == 2
    assert made != shot(seed=1) and made != "cube_on_plane"
    assert repr(shot(seed=3)) == (
        "Shot('cube_on_plane', Direct(n_area=1, n_environment=2), size=(16, 10), seed=3)"
    )
    assert repr(vc.Shot("slits")) == "Shot('slits')"
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.seed = 1  # type: ignore[misc]
    again = pickle.loads(pickle.dumps(made))
    assert type(again) is vc.Shot and again == made and again.threads == 2


def test_what_changes_after_a_shot_was_made_does_not_change_it():
    view, sky = vc.look_at(*EYE), pixels()
    made = shot(camera=view, env=sky)
    view.view_height, sky[:] = 9.0, 0
    assert made.key == shot(camera=vc.look_at(*EYE), env=pixels()).key


def test_calls_of_a_shot_are_those_of_the_package():
    room = vc.Shot("room?triangles=2000", "whitted?n_vpls=16", size=(32, 20), seed=3)
    given = ("room?triangles=2000", vc.Whitted(n_vpls=16))
    usual = {"size": (32, 20), "seed": 3}
    assert room.render().sha256 == vc.render(*given, **usual).sha256
    cached = room.render(visibility="aqvc?c_e=8", spp=2, audit="pixels")
    again = vc.render(*given, visibility=vc.Aqvc(c_e=8), spp=2, audit="pixels", **usual)
    assert cached.sha256 == again.sha256 and "audit" in cached.counters
    assert room.with_(visibility="aqvc").render().sha256 == room.render(visibility="aqvc").sha256
    swept = room.sweep(over={"C_E": [4, 8]}, repeats=2)
    assert (swept.sizes["c_e"], swept.sizes["repeat"]) == (2, 2)
    assert "Aqvc" in str(room.tune(rel_l1=0.2).visibility)
    picture = room.passes(2)
    assert picture.n_passes == 2 and picture.visibility != vc.Exact()
    picture.passes(1)
    same = vc.Progressive(*given, **usual).passes(3)
    assert picture.frame.sha256 == same.sha256
    asked = room.with_(visibility="aqvc").connections()
    assert asked.frame(asked.answers("exact")).sha256 == room.render().sha256
    with pytest.raises(TypeError, match="render has no parameter 'sed'"):
        room.render(sed=3)


def test_every_call_lists_the_arguments_of_a_shot():
    names = [f.name for f in dataclasses.fields(vc.Shot)]
    assert names[2:] == list(ShotArguments.__annotations__)
    calls = [vc.render, vc.sweep, vc.tune, vc.Progressive, vc.connections, vc.tiles.render]
    for call in [*calls, vc.passes_over_time, vc.testing.ExactFrames.__call__]:
        listed = inspect.signature(call).parameters
        assert set(names) - set(listed) <= {"visibility", "use", "rays"}, call
        assert not [p for p in listed.values() if p.kind is p.VAR_KEYWORD], call


@pytest.mark.parametrize("text", ["aqvc?", "aqvc?c_e", "aqvc?c_e=8&c_e=9", "aqvc?=8"])
def test_settings_in_words_that_are_none_are_refused(text):
    with pytest.raises(ValueError, match=r"must be a name, then \?parameter=value"):
        shot(visibility=text)


def test_none_is_the_default_of_each_call():
    given = {"size": SIZE, "visibility": None}
    assert isinstance(vc.Progressive("cube_on_plane", SKY, **given).visibility, vc.Aqvc)
    swept = vc.sweep("cube_on_plane", SKY, over={"c_e": [4]}, **given)
    assert "aqvc" in swept.attrs["visibility"]
    assert vc.render("cube_on_plane", SKY, **given).parameters["visibility"]["name"] == "Exact"
