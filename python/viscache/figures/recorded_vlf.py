"""Full runs of the visibility field's figures, rows as the figures name them."""

from __future__ import annotations

from viscache.figures import vlf_bands as bands
from viscache.figures.outcome import Band
from viscache.figures.recorded_value import Missing, Recorded, Run


def _run(figure: str, frame: str) -> Run:
    return Run(figure=figure, date="2026-11-25", machine="C", frame=frame)


def _of(figure: str, what: str, band: Band, written: str) -> Recorded:
    return Recorded(figure=figure, what=what, band=band, written=written)


#: Other work ran on the machine.
RUNS = (
    _run("vlf-fig1", "random edges over a grid, no frame"),
    _run("vlf-fig2", "random chords of the scene’s ball, 128² tiles"),
    _run("vlf-fig3", "random chords, depth 3"),
    _run("vlf-fig4", "512×512"),
    _run("vlf-fig6", "70 frames of 256×256, one thread, CPU seconds"),
    _run("vlf-fig7", "256×256"),
    _run("vlf-fig8", "256×256, 513 shared directions"),
    _run("vlf-tab1", "256×256, 513 directions, one thread, CPU seconds"),
    _run("vlf-x1", "random chords, one thread, CPU seconds"),
)

RECORDED = (
    _of("vlf-fig1", "share of touched tiles a DDA misses", bands.DDA_MISSES, "0.226"),
    _of("vlf-fig1", "touched tiles the supercover misses", bands.SUPERCOVER_ERRORS, "0"),
    _of("vlf-fig1", "tiles it lists that the edge does not touch", bands.SUPERCOVER_ERRORS, "0"),
    _of("vlf-fig2", "tiles of a ray along the axis", bands.ALIGNED_TILES, "1"),
    _of("vlf-fig3", "tiles whose leaves the two walks visit differently", bands.WALKS_DIFFER, "0"),
    _of("vlf-fig3", "share of the leaves that are visited", bands.GREY_LEAVES, "0.153"),
    _of("vlf-fig4", "triangles, left", bands.RANDOM_TRIANGLES[9000], "9000"),
    _of("vlf-fig4", "triangles, right", bands.RANDOM_TRIANGLES[16000], "16000"),
    _of(
        "vlf-fig6",
        "OpenGL-like: speed-up of VLF-RT over CRT, median",
        bands.WALK_SPEEDUP["OpenGL-like"],
        "1.07",
    ),
    _of(
        "vlf-fig6",
        "Whitted: speed-up of VLF-RT over CRT, median",
        bands.WALK_SPEEDUP["Whitted"],
        "0.973",
    ),
    _of("vlf-fig7", "triangles", bands.CLASSROOM_TRIANGLES, "51208"),
    _of("vlf-fig7", "point lights", bands.CLASSROOM_LIGHTS, "4"),
    _of(
        "vlf-fig8", "mean of the free directions, church over cow", bands.CLOSED_IS_DARKER, "0.171"
    ),
    _of("vlf-tab1", "cow: speed-up of VLF-RT over CRT", bands.OCCLUSION_SPEEDUP, "1.53"),
    _of("vlf-tab1", "scorpion: speed-up of VLF-RT over CRT", bands.OCCLUSION_SPEEDUP, "1.31"),
    _of("vlf-tab1", "bugatti: speed-up of VLF-RT over CRT", bands.OCCLUSION_SPEEDUP, "1.1"),
    _of("vlf-tab1", "church: speed-up of VLF-RT over CRT", bands.OCCLUSION_SPEEDUP, "1.61"),
    _of("vlf-tab1", "tugboat: speed-up of VLF-RT over CRT", bands.OCCLUSION_SPEEDUP, "0.924"),
    _of(
        "vlf-tab1", "speed-up at 34K over that at 5.8K triangles", bands.OCCLUSION_DECLINE, "0.606"
    ),
    _of("vlf-x1", "rays per second, 2049 directions over 513", bands.FINER_IS_FASTER, "0.921"),
)

MISSING = (
    Missing(
        figure="vlf-fig5",
        band=bands.RANDOM_SPEEDUP,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vlf-fig5",
        band=bands.RANDOM_GROWTH,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vlf-fig5",
        band=bands.RANDOM_STEPS,
        reason="not run again since the rules were written",
    ),
)
