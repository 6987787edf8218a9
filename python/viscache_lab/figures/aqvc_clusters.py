"""Figures 1 and 2 of the quantized cache's paper: which samples share a cell, in false colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.aqvc import eye_keys, hash_keys, resolution_eye
from viscache.shot.connections import trace_eye_points
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panels, images
from viscache_lab.figures.aqvc_runs import Shot, presets
from viscache_lab.figures.bands import aqvc as bands

C_E, FINER_C_E = 16.0, 4.0
SIZE, QUICK_SIZE = (640, 400), (240, 150)
TRIANGLES, QUICK_TRIANGLES = 200_000, 20_000
#: Distance of neighbours, in cells.
APART = 0.1

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True)
class EyeSamples:
    """The surfaces that the camera sees, one sample per pixel."""

    scene: vc.Scene
    position: Floats
    normal: Floats
    density: Floats
    pixel: npt.NDArray[np.int64]

    def keys(self, settings: vc.Aqvc, moved: Floats | None = None) -> npt.NDArray[np.int32]:
        """Cluster keys (N, 8) of the samples, or of displaced points, at the first level of C_E."""
        low, high = self.scene.bounds.astype(float)
        radius = float(np.linalg.norm(high - low) / 2)
        points = self.position if moved is None else self.position + moved
        keys, valid = eye_keys(
            settings,
            ((low + high) / 2).tolist(),
            radius,
            points.astype(np.float32),
            self.normal.astype(np.float32),
            self.resolutions(settings),
        )
        assert valid.all()
        return keys

    def resolutions(self, settings: vc.Aqvc) -> Floats:
        """R of Eq. 7, before it is rounded to a level."""
        low, high = self.scene.bounds.astype(float)
        radius = float(np.linalg.norm(high - low) / 2)
        c_e = np.full(len(self.density), settings.c_e)
        return resolution_eye(self.density, c_e, np.full(len(c_e), radius))


def eye_samples(shot: Shot) -> EyeSamples:
    """The eye samples of a shot."""
    got = trace_eye_points(
        shot.scene, shot.integrator, size=shot.size, spp=shot.spp, camera=shot.camera
    )
    return EyeSamples(
        scene=shot.scene,
        position=np.asarray(got["position"], float),
        normal=np.asarray(got["normal"], float),
        density=np.asarray(got["density"], float),
        pixel=np.asarray(got["pixel"], np.int64),
    )


@FIGURES.add("aqvc-fig2", "cells that follow normals and footprints", sized=True)
def figure2(trial: Trial) -> None:
    """Cells in false colours; whether they follow normals and the footprint of samples."""
    pixels = trial.size or (QUICK_SIZE if trial.quick else SIZE)
    above, aslant = (
        eye_samples(Shot(scene=_plane(), integrator=vc.Direct(), size=pixels, camera=view))
        for view in (0, 1)
    )
    room = Shot(
        scene=vc.scenes.room(triangles=QUICK_TRIANGLES if trial.quick else TRIANGLES),
        integrator=vc.Direct(),
        size=pixels,
    )
    inside = eye_samples(room)
    for preset, settings in presets(C_E).items():
        trial.rows += _plane_rows(preset, above, aslant, settings)
        trial.rows += _normal_rows(preset, inside, settings)
    trial.draw("aqvc-fig2.png", _panels(room, inside), (10.0, 6.5))
    trial.notes.append(
        f"C_E {C_E:g}, {pixels[0]}x{pixels[1]}, one sample per pixel. The plane is seen from "
        "above and aslant; near samples are several times as dense as far ones in the second."
    )


def _plane() -> vc.Scene:
    """A horizontal plane, larger than its cameras see, from above and at an angle."""
    d = vc.SceneDescription()
    corners = [[-40, 0, 40], [40, 0, 40], [40, 0, -40], [-40, 0, -40]]
    d.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material=d.add_material())
    d.add_point_light((0, 9, 0), (1, 1, 1))
    d.add_camera((0, 10, 0), (0, 0, 0), up=(0, 0, -1), fov_deg=20, name="above")
    d.add_camera((0, 6, 10), (0, 0, -1), fov_deg=45, name="aslant")
    return vc.Scene.from_description(d)


class Cells:
    """The groups of samples with the same key."""

    def __init__(self, keys: npt.NDArray[np.int32]) -> None:
        _, first, number, count = np.unique(
            keys, axis=0, return_index=True, return_inverse=True, return_counts=True
        )
        #: One sample of each cell (index), the cell of each sample, the sample count of each cell.
        self.first, self.number, self.count = first, number.reshape(-1), count


def _plane_rows(
    preset: str, above: EyeSamples, aslant: EyeSamples, settings: vc.Aqvc
) -> Iterator[Row]:
    whole, cells = Cells(above.keys(settings)), Cells(aslant.keys(settings))
    # The near and far halves of the cells, by the density of their samples
    density = np.bincount(cells.number, aslant.density) / cells.count
    far = density < np.median(density)
    both = float(cells.count[far].mean() / cells.count[~far].mean())
    yield Row(
        f"{preset}: eye samples per cell of a plane over C_E²",
        float(whole.count.mean()) / settings.c_e**2,
        band=bands.SAMPLES_PER_CELL,
        note=f"{len(whole.count)} cells, those at the picture's edge cut",
    )
    yield Row(
        f"{preset}: samples per cell, the far half over the near half",
        both,
        band=bands.CELLS_FOLLOW_FOOTPRINT,
        note=f"densities {density[~far].mean() / density[far].mean():.1f} to 1",
    )
    yield Row(
        f"{preset}: samples {APART:g} cells apart that share a cell",
        _share_of_neighbours(above, settings),
        band=bands.NEIGHBOURS_SHARE,
    )


def _share_of_neighbours(samples: EyeSamples, settings: vc.Aqvc) -> float:
    """Share of samples with the key of their neighbour in a random direction on the surface."""
    along = np.random.default_rng(0).normal(size=samples.normal.shape)
    along -= (along * samples.normal).sum(axis=1, keepdims=True) * samples.normal
    width = settings.c_e / np.sqrt(samples.density)
    along *= (APART * width / np.linalg.norm(along, axis=1))[:, None]
    same = (samples.keys(settings) == samples.keys(settings, along)).all(axis=1)
    return float(same.mean())


def _normal_rows(preset: str, inside: EyeSamples, settings: vc.Aqvc) -> Iterator[Row]:
    cells = Cells(inside.keys(settings))
    limit = 2 * greatest_angle_deg(settings)
    cosine = (inside.normal * inside.normal[cells.first][cells.number]).sum(axis=1)
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    mixed = np.zeros(len(cells.count), bool)
    mixed[cells.number[angle > limit + 0.1]] = True
    yield Row(
        f"{preset}: cells of a room that mix orientations",
        int(mixed.sum()),
        band=bands.MIXED_NORMALS,
        note=f"of {len(cells.count)}; largest angle {angle.max():.1f}°, bins allow {limit:.1f}°",
    )


def greatest_angle_deg(settings: vc.Aqvc) -> float:
    """The largest angle between a normal and the axis of its bin, over random normals."""
    rng = np.random.default_rng(1)
    n = rng.normal(size=(200_000, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    keys = EyeSamples(
        scene=_plane(),
        position=0 * n,
        normal=n,
        density=np.ones(len(n)),
        pixel=np.zeros(len(n), np.int64),
    ).keys(settings)
    axis = 2.0 * keys[:, 1:4] / settings.core().c_n - 1
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    return float(np.degrees(np.arccos(np.clip((axis * n).sum(axis=1), -1, 1))).max())


def false_colors(
    samples: EyeSamples, keys: npt.NDArray[np.int32], shape: tuple[int, int]
) -> Floats:
    """(H, W, 3): a colour per cell from the hash of its key; black where no surface is visible."""
    mixed = hash_keys(keys)[:, 0]
    image = np.zeros((shape[0] * shape[1], 3))
    channels = [(mixed >> shift & 0xFF) / 255.0 for shift in (0, 8, 16)]
    image[samples.pixel] = 0.1 + 0.9 * np.stack(channels, axis=1)
    return image.reshape(*shape, 3)


def _panels(room: Shot, inside: EyeSamples) -> Panels:
    shape = (room.size[1], room.size[0])
    cells = {}
    for preset, c_e in (("default", C_E), ("default", FINER_C_E), ("paper", C_E)):
        keys = inside.keys(presets(c_e)[preset])
        cells[f"cells, {preset}, C_E {c_e:g}"] = false_colors(inside, keys, shape)
    panels = images({"the room": room.frame()}) + images(cells, 1.0)
    return [panels[:2], panels[2:]]
