"""From a visibility setting to the source of a frame's oracles."""

from __future__ import annotations

from typing import Any

from viscache import _core
from viscache.oracles import written
from viscache.oracles.correct import CERTAIN, Correct
from viscache.oracles.learned import unlearnt
from viscache.settings.rays import Rays, is_robust
from viscache.settings.source_context import SourceContext
from viscache.settings.visibility import Aqvc, Exact, NeePlusPlus, VisMaps


def oracle_source(visibility: Any, use: Any, context: SourceContext) -> _core.OracleSource:
    """What makes the oracles of one frame: built in or written in Python, corrected if asked."""
    if isinstance(visibility, NeePlusPlus) and use not in (None, "replace"):
        given = use if isinstance(use, Correct) else Correct()
        certain = None if given.certain == "auto" else given.certain
        return visibility.corrected(context, given.share, certain)
    if written.is_written(visibility):
        source = written.source(visibility, context)
    else:
        source = visibility.source(context)
    if use in (None, "replace") or isinstance(visibility, VisMaps):
        return source
    correct = use if isinstance(use, Correct) else Correct()
    return _core.ResidualSource(
        context.scene,
        context.caster,
        source,
        share=correct.share,
        certain=CERTAIN if correct.certain == "auto" else correct.certain,
        seed=context.seed,
        lasting_seed=context.lasting_seed,
        octaves=context.octaves or unlearnt(),
    )


def shafts_for(scene: Any, visibility: Any, rays: Rays) -> _core.ShaftScene | None:
    """The triangles of a scene for shafts, or None where packets of rays answer."""
    uses = isinstance(visibility, Aqvc) or (
        isinstance(visibility, Exact) and visibility.engine != "packets"
    )
    if not uses or not is_robust(rays):
        return None
    shafts: _core.ShaftScene = scene.shafts()
    return shafts


def parameters_of(visibility: Any) -> dict[str, Any]:
    """Names and values of a visibility setting."""
    if written.is_written(visibility):
        return written.parameters(visibility)
    values: dict[str, Any] = visibility.parameters()
    return values
