"""Selects the pictures of a sweep for its page and packs them with `pictures`."""

from __future__ import annotations

from typing import Any

from viscache.base import tonemap
from viscache.base.progress import Progress, step_bar
from viscache.metrics import FLIP_PIXELS_PER_DEGREE
from viscache.report import pictures
from viscache.report.pictures import FloatImage
from viscache.sweeps.flip_maps import flip_map_of
from viscache.sweeps.store import Store
from viscache.sweeps.swept import pareto

#: Default maximum number of FLIP maps, because each takes seconds.
MOST_FLIP_MAPS = 24


class Packer:
    """Packs pictures into the model of a page, all at the exposure of the first reference.

    So they can also be compared with each other. The number of settings, `count`, and the size
    determine whether errors are rounded.
    """

    def __init__(self, model: dict[str, Any], count: int, width: int) -> None:
        self.model, self.count, self.width = model, count, width
        self.exposure: float | None = None
        self._references: dict[str, pictures.Codes] = {}

    def add(
        self, setting: dict[str, Any], image: FloatImage, reference: FloatImage, key: str
    ) -> None:
        """Add the picture of a setting, relative to the reference with this key."""
        if self.exposure is None:
            self.exposure = tonemap.display_exposure(reference)
            self._describe(reference)
        if key not in self._references:
            self._references[key] = self._codes(reference)
            self.model["pictures"][key] = pictures.pack_reference(self._references[key])
        packed = pictures.pack_difference(
            self._codes(image), self._references[key], self.model["step"]
        )
        setting |= {"reference": key, "difference": packed}

    def _codes(self, image: FloatImage) -> pictures.Codes:
        assert self.exposure is not None
        small = pictures.shrunk(pictures.three_channels(image), self.width)
        return pictures.codes(small, self.exposure)

    def _describe(self, reference: FloatImage) -> None:
        """The data with which the page unpacks pictures and names their values."""
        height, width = pictures.shrunk(reference[:, :, :1], self.width).shape[:2]
        exact = self.count * width * height <= pictures.MOST_EXACT_PIXELS
        self.model |= {
            "frame": {"width": width, "height": height},
            "step": 1 if exact else pictures.COARSE_STEP,
            "white": 1.0 / (self.exposure or 1.0),
            "colors": pictures.scales(),
            "flip_ppd": FLIP_PIXELS_PER_DEGREE,
        }


def add_pictures(
    model: dict[str, Any],
    store: Store,
    flip_maps: int,
    width: int,
    progress: Progress,
) -> None:
    """Add reference, picture and FLIP map of the first repeat of each setting to the page's model.

    FLIP maps are those that the sweep kept, and others are made and kept; Pareto-optimal settings
    come first. Progress counts packed settings.
    """
    points = {tuple(p["index"][:-1]): p for p in store.definition()["points"] if p["repeat"] == 0}
    mapped = {s["id"] for s in _best_first(model)[:flip_maps]}
    finished = []
    for setting in model["settings"]:
        point = points.get(tuple(setting["index"]))
        if point and store.get(point["key"]) and store.get(point["paired"]):
            finished.append((setting, point))
    packer = Packer(model, len(finished), width)
    with step_bar(progress, len(finished), unit="picture") as step:
        for setting, point in finished:
            frame, reference = store.frame(point["key"]), store.frame(point["paired"])
            packer.add(setting, frame.image, reference.image, point["paired"])
            setting["seed"] = point["seed"]
            setting |= {"parameters": frame.parameters, "sha256": frame.sha256}
            if setting["id"] in mapped:
                found = flip_map_of(frame, reference, store.directory)
                if found is not None:
                    setting["flip"] = pictures.pack_flip(found.errors / 255.0, found.mean, width)
            step()


def _best_first(model: dict[str, Any]) -> list[dict[str, Any]]:
    """The settings, Pareto-optimal ones (error against time or rays) first."""
    metric, settings = model["metrics"][0], model["settings"]
    best: set[tuple[str, tuple[float, float]]] = set()

    def place(setting: dict[str, Any], cost: str) -> tuple[str, tuple[float, float]] | None:
        x, y = setting["cells"].get(cost), setting["cells"].get(metric)
        return (cost, (x[0], y[0])) if x and y else None

    for cost in ("total_s", "rays"):
        places = [p for s in settings if (p := place(s, cost))]
        best |= {(cost, point) for point in pareto([point for _, point in places])}
    return sorted(settings, key=lambda s: not {place(s, c) for c in ("total_s", "rays")} & best)
