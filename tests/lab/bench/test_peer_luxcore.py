"""LuxCore as a peer: what it is told, and what its frames' time has. A stand-in takes its place."""

import time

import numpy as np
import pytest

from viscache_lab.bench.peer_luxcore import LuxCorePicture

SIDE = 8
BUILD_S = 0.05


class Property:
    def __init__(self, name, value):
        self.name, self.value = name, value


class Properties(dict):
    def Set(self, given):  # noqa: N802
        self[given.name] = given.value


class Scene:
    def __init__(self):
        self.told, self.images, self.meshes = {}, {}, {}

    def Parse(self, properties):  # noqa: N802
        self.told |= properties

    def DefineMesh(self, name, vertices, triangles, *more):  # noqa: N802
        self.meshes[name] = np.array(vertices), np.array(triangles)

    def DefineImageMap(self, name, pixels, gamma, channels, columns, rows):  # noqa: N802
        assert pixels.flags.c_contiguous and pixels.dtype == np.float32 and gamma == 1
        self.images[name] = pixels.reshape(rows, columns, channels).copy()


class Film:
    def GetOutputFloat(self, kind, pixels):  # noqa: N802
        # Its first row is the lowest of the picture
        rows = np.arange(SIDE, dtype=np.float32).repeat(3 * SIDE)
        pixels[:] = rows


class Session:
    def __init__(self, config):
        self.config = config

    def Start(self):  # noqa: N802
        busy(BUILD_S)
        self.updates = 0

    def UpdateStats(self):  # noqa: N802
        self.updates += 1

    def HasDone(self):  # noqa: N802
        return self.updates == 2

    def Stop(self):  # noqa: N802
        pass

    def GetFilm(self):  # noqa: N802
        return Film()


class StandIn:
    """As much of pyluxcore as the peer needs; it remembers what it was told."""

    Property, Properties = Property, Properties

    class FilmOutputType:
        RGB = "RGB"

    def __init__(self):
        self.scenes, self.configs = [], []

    def Scene(self):  # noqa: N802
        self.scenes.append(Scene())
        return self.scenes[-1]

    def RenderConfig(self, properties, scene):  # noqa: N802
        self.configs.append(properties)
        return properties

    def RenderSession(self, config):  # noqa: N802
        return Session(config)


def busy(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


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


def test_a_sky_has_one_path_for_each_sample_that_ends_at_its_second_vertex(folder):
    lux = StandIn()
    LuxCorePicture(lux, folder, cached=False).sky(given(), fields())
    (told,) = lux.configs
    assert told["batch.haltspp"] == 12 and told["path.pathdepth.total"] == 2
    assert told["film.filter.type"] == "NONE"
    assert told["sampler.sobol.adaptive.strength"] == 0


def test_the_picture_has_its_highest_row_first(folder):
    made = LuxCorePicture(StandIn(), folder, cached=False).sky(given(), fields())
    np.testing.assert_array_equal(made["image"][:, 0], np.arange(SIDE)[::-1])


def test_y_up_becomes_z_up_and_the_camera_is_lowered_by_a_row(folder):
    lux = StandIn()
    LuxCorePicture(lux, folder, cached=False).sky(given(), fields())
    (scene,) = lux.scenes
    np.testing.assert_array_equal(scene.meshes["all"][0][2], [0, -3, 2])
    assert scene.told["scene.camera.lookat.orig"] == [0, -5, 1]
    assert scene.told["scene.camera.lookat.target"] == [0, -4, 1]
    assert scene.told["scene.camera.up"] == [0, 0, 1]
    assert scene.told["scene.camera.screenwindow"] == [-1, 1, -1.25, 0.75]


def test_the_sky_is_mirrored_and_turned(folder):
    lux, arrays = StandIn(), given()
    LuxCorePicture(lux, folder, cached=False).sky(arrays, fields())
    np.testing.assert_array_equal(arrays["sky"][0, :, 0] / 3, np.arange(8))
    (scene,) = lux.scenes
    np.testing.assert_array_equal(scene.images["sky"][0, :, 0] / 3, [1, 0, 7, 6, 5, 4, 3, 2])


def test_every_light_has_a_path_for_each_sample(folder):
    lux = StandIn()
    LuxCorePicture(lux, folder, cached=False).points(given(), fields(intensity=0.25))
    (told,), (scene,) = lux.configs, lux.scenes
    assert told["batch.haltspp"] == 6 and told["path.pathdepth.total"] == 1
    assert scene.told["scene.lights.light1.position"] == [4, -6, 5]
    assert scene.told["scene.lights.light1.gain"] == pytest.approx([np.pi] * 3)


def test_caches_are_on_if_asked_for_alone(folder):
    for cached in (False, True):
        lux = StandIn()
        picture = LuxCorePicture(lux, folder, cached=cached)
        picture.sky(given(), fields())
        picture.points(given(), fields(intensity=1))
        enabled = lux.scenes[0].told["scene.lights.sky.visibilitymapcache.enable"]
        assert enabled == cached
        strategies = [told["lightstrategy.type"] for told in lux.configs]
        assert strategies == ["LOG_POWER", "DLS_CACHE" if cached else "LOG_POWER"]


def test_the_scene_is_made_once_and_seeds_differ(folder):
    lux, arrays = StandIn(), given()
    picture = LuxCorePicture(lux, folder, cached=False)
    for seed in (0, 1):
        picture.sky(arrays, fields(seed=seed))
    assert len(lux.scenes) == 1
    assert [told["renderengine.seed"] for told in lux.configs] == [1, 2]


def test_the_build_of_a_cache_is_in_its_time_and_that_of_the_scene_is_not(folder):
    plain = LuxCorePicture(StandIn(), folder, cached=False).sky(given(), fields())
    assert plain["cpu_s"] < BUILD_S and "build_cpu_s" not in plain
    cached = LuxCorePicture(StandIn(), folder, cached=True).sky(given(), fields())
    assert cached["cpu_s"] >= cached["build_cpu_s"] >= BUILD_S
