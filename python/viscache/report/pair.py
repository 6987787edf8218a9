"""A page with two pictures: the report's difference viewer for any image and its reference."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import metrics
from viscache.frame import Frame
from viscache.report import assemble, pictures
from viscache.report.assemble import write_page
from viscache.report.embed import Packer
from viscache.report.pictures import MAX_WIDTH_PX
from viscache.settings.checks import require

Picture = Frame | npt.NDArray[np.floating[Any]]


def write_difference(
    image: Picture,
    reference: Picture,
    path: str | os.PathLike[str],
    *,
    name: str = "picture",
    reference_name: str = "reference",
    facts: Mapping[str, str] | None = None,
    flip_map: bool = True,
    width: int = MAX_WIDTH_PX,
) -> Path:
    """Write the difference viewer of two pictures as one HTML file.

    Parameters
    ----------
    image, reference : Frame or (H, W, 1 or 3) array
        Scene-linear pictures of equal size.
    path : path
        The HTML file.
    name, reference_name : str
        Their names on the page.
    facts : mapping of str to str, optional
        More rows at the head of the page.
    flip_map : bool
        Include a FLIP map, which takes seconds.
    width : int >= 1
        Maximum width; wider pictures are shown as means over pixels.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ValueError
        The sizes differ, `width` is below 1, or pixels are not numbers.

    Examples
    --------
    >>> import tempfile, viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> one, other = (vc.render(scene, vc.Direct(), size=(32, 24), seed=s) for s in (0, 1))
    >>> page = vc.report.write_difference(one, other, tempfile.mkdtemp() + "/page.html")
    >>> page.name
    'page.html'
    """
    require(width >= 1, "width must be >= 1", width)
    pixels, base = (_pixels(picture) for picture in (image, reference))
    # Frames have the layers that some metrics need
    sides = [p if isinstance(p, Frame) else _pixels(p) for p in (image, reference)]
    values = metrics.compare(*sides)
    setting: dict[str, Any] = {
        "id": "s0",
        "text": name,
        "values": {},
        "parameters": getattr(image, "parameters", {}),
        "sha256": getattr(image, "sha256", None),
        "cells": {k: None if v is None else [v, 0.0] for k, v in values.items()},
    }
    height, full = base.shape[:2]
    model: dict[str, Any] = {
        "names": [],
        "columns": list(values),
        "settings": [setting],
        "pictures": {},
        "size": [full, height],
    }
    Packer(model, 1, width).add(setting, pixels, base, "reference")
    if flip_map:
        setting["flip"] = pictures.flip_map(pixels, base, width)
    title = html.escape(f"{name} − {reference_name}")
    texts = {
        "TITLE": title,
        "HEADING": title,
        "SUBTITLE": "A picture and its reference",
        "FACTS": assemble.facts(
            _facts(image, reference, (full, height), name, reference_name) | dict(facts or {})
        ),
        "PLOTS": "",
        "TABLE_HEADING": "Errors",
        "NOTES": "",
    }
    target = Path(path)
    write_page(target, model, texts)
    return target


def _pixels(picture: Picture) -> npt.NDArray[np.float64]:
    pixels = np.asarray(getattr(picture, "image", picture), dtype=np.float64)
    return pixels[:, :, None] if pixels.ndim == 2 else pixels


def _facts(
    image: Picture, reference: Picture, size: tuple[int, int], name: str, reference_name: str
) -> dict[str, str]:
    facts = {"Picture": name, "Reference": reference_name, "Size": f"{size[0]}×{size[1]}"}
    for words, picture in (("Made by", image), ("Reference by", reference)):
        made = getattr(picture, "provenance", {})
        if made:
            facts[words] = ", ".join(f"{k} {v}" for k, v in made.items() if k != "date")
    return facts
