"""LuxCore as a peer: what it is told, and what its frames' time has. A stand-in takes its place."""

import time
from unittest.mock import Mock

import numpy as np
import pytest

from viscache_lab.bench.peer_luxcore import LuxCorePicture

SIDE = 8
BUILD_S = 0.05


class Properties(dict):
    def Set(self, given):  # noqa: N802
        self.update([given])


def busy(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


@pytest.fixture
def lux():
    """As much of pyluxcore as the peer needs; it remembers what it was told."""
    session = Mock(spec=["Start", "UpdateStats", "HasDone", "Stop", "GetFilm"])
    made = Mock(spec=["Scene", "RenderConfig", "RenderSession", "FilmOutputType"])
    made.Property, made.Properties = lambda *named: named, Properties
    made.Scene.return_value = Mock(spec=["Parse", "DefineMesh", "DefineImageMap"])
    made.RenderSession.return_value = session
    session.Start.side_effect = lambda: busy(BUILD_S)
    session.HasDone.side_effect = lambda: (
        session.UpdateStats.call_count == 2 * made.RenderSession.call_count
    )
    # Its first row is the lowest of the picture
    rows = np.arange(SIDE, dtype=np.float32).repeat(3 * SIDE)
    film = Mock(spec=["GetOutputFloat"])
    film.GetOutputFloat.side_effect = lambda kind, pixels: np.copyto(pixels, rows)
    session.GetFilm.return_value = film
    return made


def configs(lux):
    """The settings of every frame."""
    return [call.args[0] for call in lux.RenderConfig.call_args_list]


def parsed(lux):
    """The properties of the one scene."""
    lux.Scene.assert_called_once()
    return lux.Scene.return_value.Parse.call_args.args[0]


@pytest.fixture
def folder(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 3]], np.float32)
    np.savez(tmp_path / "scene.npz", vertices=vertices, triangles=np.uint32([[0, 1, 2]]))
    return tmp_path


def given():
    axes = np.array([[0, 1, 5], [0, 0, -1], [1, 0, 0], [0, 1, 0]], np.float64)
    sky = np.arange(2 * 8 * 3, dtype=np.float32).reshape(2, 8, 3)
    return {"camera": axes, "sky": sky, "lights": np.array([[1, 2, 3], [4, 5, 6]], np.float32)}


def fields(**more):
    return {"spp": 3, "samples": 4, "seed": 9, "side": SIDE, "fov_rad": 1.0, "albedo": 0.5} | more


def test_a_sky_has_one_path_for_each_sample_that_ends_at_its_second_vertex(lux, folder):
    arrays = given()
    made = LuxCorePicture(lux, folder, cached=False).sky(arrays, fields())
    (told,) = configs(lux)
    assert told["batch.haltspp"] == 12 and told["path.pathdepth.total"] == 2
    assert told["film.filter.type"] == "NONE"
    assert told["sampler.sobol.adaptive.strength"] == 0
    # The highest row of the picture comes first
    np.testing.assert_array_equal(made["image"][:, 0], np.arange(SIDE)[::-1])
    # Y up becomes z up, and the camera is lowered by a row
    scene = lux.Scene.return_value
    assert scene.DefineMesh.call_args.args[1][2] == (0, -3, 2)
    expected = {
        "lookat.orig": [0, -5, 1],
        "lookat.target": [0, -4, 1],
        "up": [0, 0, 1],
        "screenwindow": [-1, 1, -1.25, 0.75],
    }
    assert {name: parsed(lux)[f"scene.camera.{name}"] for name in expected} == expected
    # The sky is mirrored and turned
    np.testing.assert_array_equal(arrays["sky"][0, :, 0] / 3, np.arange(8))
    _, pixels, *layout = scene.DefineImageMap.call_args.args
    assert layout == [1, 3, 8, 2]
    assert pixels.flags.c_contiguous and pixels.dtype == np.float32
    np.testing.assert_array_equal(pixels[0, :, 0] / 3, [1, 0, 7, 6, 5, 4, 3, 2])


def test_every_light_has_a_path_for_each_sample(lux, folder):
    LuxCorePicture(lux, folder, cached=False).points(given(), fields(intensity=0.25))
    (told,) = configs(lux)
    assert told["batch.haltspp"] == 6 and told["path.pathdepth.total"] == 1
    assert parsed(lux)["scene.lights.light1.position"] == [4, -6, 5]
    assert parsed(lux)["scene.lights.light1.gain"] == pytest.approx([np.pi] * 3)


@pytest.mark.parametrize("cached", [False, True])
def test_caches_are_on_and_their_build_is_timed_if_asked_for_alone(lux, folder, cached):
    picture = LuxCorePicture(lux, folder, cached=cached)
    made = picture.sky(given(), fields())
    enabled = parsed(lux)["scene.lights.sky.visibilitymapcache.enable"]
    assert enabled == cached == ("build_cpu_s" in made)
    if cached:
        assert made["cpu_s"] >= made["build_cpu_s"] >= BUILD_S
    else:
        assert made["cpu_s"] < BUILD_S
    picture.points(given(), fields(intensity=1))
    strategies = [told["lightstrategy.type"] for told in configs(lux)]
    assert strategies == ["LOG_POWER", "DLS_CACHE" if cached else "LOG_POWER"]


def test_the_scene_is_made_once_and_seeds_differ(lux, folder):
    picture = LuxCorePicture(lux, folder, cached=False)
    arrays = given()
    for seed in (0, 1):
        picture.sky(arrays, fields(seed=seed))
    assert parsed(lux)
    assert [told["renderengine.seed"] for told in configs(lux)] == [1, 2]
