"""Area lights are chosen by what they can contribute, and the picture's mean stays the same."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from core import testing
from render.mitsuba_frames import SIZE, area_layers, assert_same, ours, theirs
from render.mitsuba_scene import Model, quad
from render.test_mitsuba import BODIES
from render.ztest import compare
from viscache.testing.student import blocks

WAYS = ("each", "tree")


class Lights:
    """Random triangles, some of them two-sided, and spheres: the scene and its shapes."""

    def __init__(self, seed, triangles=24, spheres=5, largest=2.0):
        random = np.random.default_rng(seed)
        spread = 10 ** random.uniform(-1, 1)
        centers = random.normal(size=(triangles, 1, 3)) * spread
        sizes = largest * 10 ** random.uniform(-2.3, 0, (triangles, 1, 1))
        self.corners = (centers + random.normal(size=(triangles, 3, 3)) * sizes).astype(np.float32)
        if seed % 3 == 0:  # all in one plane
            self.corners[..., 1] = np.float32(0.25)
        self.radiance = 10 ** random.uniform(-3, 3, triangles)
        self.two_sided = random.random(triangles) < 0.3
        self.center = (random.normal(size=(spheres, 3)) * spread).astype(np.float32)
        self.radius = (largest * 10 ** random.uniform(-2.3, -0.3, spheres)).astype(np.float32)
        d = vc.SceneDescription()
        d.add_material()
        for t, watts, both in zip(self.corners, self.radiance, self.two_sided, strict=True):
            d.add_mesh(
                t, np.array([[0, 1, 2]]), emission=(watts, watts, watts), emits_two_sided=bool(both)
            )
        for c, r in zip(self.center, self.radius, strict=True):
            d.add_sphere_light(tuple(map(float, c)), float(r), (1, 1, 1))
        self.scene = vc.Scene.from_description(d)
        n = 40
        self.x = (random.normal(size=(n, 3)) * spread * 1.5).astype(np.float32)
        # Half of the points lie beside an emitter, at any distance from it
        near = self.corners[random.integers(0, triangles, n // 2)]
        along = random.dirichlet((1, 1, 1), n // 2)[:, :, None]
        off = random.normal(size=(n // 2, 3)) * 10 ** random.uniform(-4, 0, (n // 2, 1))
        self.x[: n // 2] = (near * along).sum(axis=1) + off
        normals = random.normal(size=(n, 3))
        normals[::4] = np.eye(3)[random.integers(0, 3, len(normals[::4]))]
        self.n = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)

    def light(self, samples=400):
        """Brute-force irradiance (points, lights): means over points of each light's surface."""
        random = np.random.default_rng(1)
        bary = random.dirichlet((1, 1, 1), samples)
        corners = self.corners.astype(float)
        edges = corners[:, 1:] - corners[:, :1]
        cross = np.cross(edges[:, 0], edges[:, 1])
        double_area = np.linalg.norm(cross, axis=1)
        normal = cross / double_area[:, None]
        on = np.einsum("sk,tkd->tsd", bary, corners)
        triangles = self._irradiance(on, normal[:, None], self.two_sided[:, None])
        triangles *= self.radiance * double_area / 2
        ways = random.normal(size=(samples, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        on = self.center[:, None] + ways * self.radius[:, None, None].astype(float)
        spheres = self._irradiance(on, np.broadcast_to(ways, on.shape), np.zeros((1, 1), bool))
        spheres *= 4 * np.pi * self.radius.astype(float) ** 2
        outside = np.linalg.norm(self.x[:, None] - self.center, axis=-1) > self.radius
        return np.concatenate([triangles, spheres * outside], axis=1)

    def _irradiance(self, on, normal, two_sided):
        """Mean over points (lights, samples, 3) of cos·cos/d²; (receivers, lights)."""
        out = []
        for x, n in zip(self.x.astype(float), self.n.astype(float), strict=True):
            d = on - x
            d2 = np.maximum((d**2).sum(-1), 1e-300)
            wi = d / np.sqrt(d2)[..., None]
            cos_y = -(wi * normal).sum(-1)
            cos_y = np.where(two_sided, np.abs(cos_y), np.maximum(cos_y, 0))
            out.append((np.maximum(wi @ n, 0) * cos_y / d2).mean(axis=-1))
        return np.array(out)


def chosen(lights, way, i, u):
    """Lights and probabilities at point i for numbers u, a multiple of 50."""
    rows = u.reshape(-1, 50)
    points, normals = (np.broadcast_to(v[i], (len(rows), 3)) for v in (lights.x, lights.n))
    light, pmf = testing.choose_light(lights.scene._core, way, points, normals, rows)
    return light.ravel(), pmf.ravel()


def told(lights, way, i, n=None):
    """Probabilities at point i, or with another normal there."""
    normal = lights.n[i] if n is None else n
    pmf = testing.light_probabilities(lights.scene._core, way, lights.x[i][None], normal[None])
    return np.asarray(pmf[0])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(6))
def test_every_light_that_contributes_can_be_chosen(way, seed):
    lights = Lights(seed)
    pmf = testing.light_probabilities(lights.scene._core, way, lights.x, lights.n)
    light = lights.light()
    seen = light > 1e-9 * light.max(axis=1, keepdims=True)
    assert seen.sum() > 100
    assert (pmf[seen] > 0).all()
    if way == "each":
        # Lights that cannot contribute are not chosen, where rounding is out of the question
        assert (pmf == 0).mean() > 0.2
        assert (pmf[~seen] > 0).mean() < 0.3
    # A choice that looks at the wrong light misses some
    assert (np.roll(pmf, 1, axis=1)[seen] == 0).any()


@pytest.mark.parametrize(("way", "largest", "share"), [("each", 2.0, 0.02), ("tree", 0.05, 0.5)])
def test_estimates_follow_the_light(way, largest, share):
    """Variance of one sample without shadows, against that of a choice by power."""
    spread = {"power": [], way: []}
    for seed in range(5):
        lights = Lights(seed, largest=largest)
        light = lights.light()
        total = light.sum(axis=1)
        core = lights.scene._core
        for pmf, found in (
            (testing.shares_of_power(core)[None], spread["power"]),
            (testing.light_probabilities(core, way, lights.x, lights.n), spread[way]),
        ):
            second = np.divide(light**2, pmf, where=light > 0, out=np.zeros_like(light)).sum(axis=1)
            found += list(second[total > 0] / total[total > 0] ** 2 - 1)
    assert np.median(spread[way]) < share * np.median(spread["power"])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", [1, 3, 4])
def test_probabilities_are_those_of_the_numbers(way, seed):
    """Each light gets an interval of u as long as its probability; what is left over gets none."""
    lights, told_apart = Lights(seed), 0
    u = (np.arange(20000) + 0.5) / 20000
    for i in range(10):
        here = told(lights, way, i)
        light, pmf = chosen(lights, way, i, np.random.default_rng(i).permutation(u))
        np.testing.assert_allclose(pmf[light >= 0], here[light[light >= 0]], rtol=1e-9)
        share = np.bincount(light[light >= 0], minlength=len(here)) / len(u)
        np.testing.assert_allclose(share, here, atol=1.01e-4)
        assert here.sum() <= 1 + 1e-12
        # Negative control: the probabilities of another receiver
        other = told(lights, way, i, np.roll(lights.n, 1, axis=0)[i])
        told_apart += np.abs(share - other).max() > 1e-2
    assert told_apart > 5


def lamps(count):
    """Small quads of many powers around the bodies, some turned, and a sphere."""
    random = np.random.default_rng(count)
    parts = []
    for i in range(count):
        corner = random.uniform((-2.5, 0.3, -2.5), (2.5, 2.5, 1.5))
        a, b = random.normal(size=(2, 3)) * 0.15
        watts = 20 * 30 ** random.random() / count
        colour = tuple(map(float, random.uniform(0.3, 1, 3) * watts * 8))
        quad_ = quad(tuple(corner), tuple(a), tuple(b), emission=colour)
        parts.append(quad_.reversed() if i % 2 else quad_)
    ceiling = quad((-0.5, 2.6, -0.5), (1, 0, 0), (0, 0, 1), emission=(1.5, 1.2, 1))
    return Model((*BODIES, ceiling, *parts))


@pytest.mark.mitsuba
@pytest.mark.stat
@pytest.mark.slow
def test_many_area_lights_are_mitsubas(mi, tmp_path):
    """Noise has heavy tails at the lamps, on both sides: means of 4 × 4 pixels are compared.

    One percent of the energy would need far more frames; three are seen.
    """
    model, direct = lamps(60), vc.Direct(n_area=4)
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), spp=32)
    assert_same(ours(model.to_viscache(), direct, spp=32), reference, edge=4, power=0.03)
    dropped = replace(model, parts=model.parts[:-1]).to_viscache()
    wrong = blocks(ours(dropped, direct, spp=32, seeds=16), 4)
    assert not compare(wrong, blocks(reference, 4), edge=2).same


@pytest.mark.stat
def test_both_choices_have_the_same_mean():
    scene = lamps(60).to_viscache()
    by_one = area_layers(scene, vc.Direct(n_area=512, centred=True), first=100)
    by_tree = area_layers(scene, vc.Direct(n_area=2, centred=True), spp=128)
    assert compare(by_tree, by_one).same
    assert not compare(0.96 * by_tree, by_one).same
