"""Which pictures of a sweep its page carries, packed by `pictures`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from viscache import tonemap
from viscache.metrics import FLIP_PIXELS_PER_DEGREE
from viscache.report import pictures
from viscache.store import Store
from viscache.swept import pareto

#: FLIP takes seconds a picture: by default no more than so many maps are made.
MOST_FLIP_MAPS = 24


def add_pictures(model: dict[str, Any], store: Store, flip_maps: int = MOST_FLIP_MAPS) -> None:
    """Adds reference, picture and FLIP map of each setting's first repeat to the page's model.

    All pictures of a page have one exposure, that of the first reference: they can be compared
    with each other too. FLIP maps go to the settings that nothing beats first.
    """
    points = {tuple(p["index"][:-1]): p for p in store.definition()["points"] if p["repeat"] == 0}
    mapped = {s["id"] for s in _best_first(model)[:flip_maps]}
    finished = []
    for setting in model["settings"]:
        point = points.get(tuple(setting["index"]))
        if point and store.get(point["key"]) and store.get(point["paired"]):
            finished.append((setting, point))
    exposure: float | None = None
    references: dict[str, pictures.Codes] = {}
    for setting, point in finished:
        frame, reference = store.frame(point["key"]), store.frame(point["paired"])
        if exposure is None:
            exposure = tonemap.display_exposure(reference.image)
            _describe(model, reference.size, len(finished), exposure)
        if point["paired"] not in references:
            packed = _codes(reference.image, exposure)
            references[point["paired"]] = packed
            model["pictures"][point["paired"]] = pictures.pack_reference(packed)
        codes, base = _codes(frame.image, exposure), references[point["paired"]]
        setting |= {
            "reference": point["paired"],
            "difference": pictures.pack_difference(codes, base, model["step"]),
            "seed": point["seed"],
            "parameters": frame.parameters,
            "sha256": frame.sha256,
        }
        if setting["id"] in mapped:
            setting["flip"] = pictures.flip_map(frame.image, reference.image)


def _codes(image: pictures.FloatImage, exposure: float) -> pictures.Codes:
    return pictures.codes(pictures.shrunk(pictures.three_channels(image)), exposure)


def _describe(model: dict[str, Any], size: Sequence[int], count: int, exposure: float) -> None:
    """What the page must know to unpack pictures and to name their values."""
    width = min(size[0], pictures.MAX_WIDTH_PX)
    height = size[1] if width == size[0] else max(1, round(size[1] * width / size[0]))
    exact = count * width * height <= pictures.MOST_EXACT_PIXELS
    model |= {
        "frame": {"width": width, "height": height},
        "step": 1 if exact else pictures.COARSE_STEP,
        "white": 1.0 / exposure,
        "colors": pictures.scales(),
        "flip_ppd": FLIP_PIXELS_PER_DEGREE,
    }


def _best_first(model: dict[str, Any]) -> list[dict[str, Any]]:
    """The settings, those first that no other beats in error and time or rays."""
    metric, settings = model["metrics"][0], model["settings"]
    best: set[tuple[str, tuple[float, float]]] = set()

    def place(setting: dict[str, Any], cost: str) -> tuple[str, tuple[float, float]] | None:
        x, y = setting["cells"].get(cost), setting["cells"].get(metric)
        return (cost, (x[0], y[0])) if x and y else None

    for cost in ("total_s", "rays"):
        places = [p for s in settings if (p := place(s, cost))]
        best |= {(cost, point) for point in pareto([point for _, point in places])}
    return sorted(settings, key=lambda s: not {place(s, c) for c in ("total_s", "rays")} & best)
