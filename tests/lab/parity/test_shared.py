"""Scenes of others: what is prepared for Mitsuba 3 shows the same scene."""

import numpy as np
import pytest

from viscache_lab.parity import renderers, shared
from viscache_lab.parity.shared import shared_scenes

#: A floor and a cube under a clear sky with y up, as Mitsuba 0.6 has it.
OLD_SKY = """<scene version="0.6.0"><sensor type="perspective"><float name="fov" value="50"/>
<transform name="toWorld"><lookAt origin="0,3,6" target="0,0.5,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film>
</sensor><shape type="rectangle"><transform name="toWorld"><scale value="5"/>
<rotate x="1" angle="-90"/></transform></shape><shape type="cube"><transform name="toWorld">
<scale value="0.5"/><translate y="0.5"/></transform><bsdf type="plastic">
<float name="intIOR" value="1.4"/></bsdf></shape><emitter type="sunsky">
<vector name="sunDirection" x="-0.8" y="0.5" z="-0.3"/><float name="sunScale" value="0.2"/>
</emitter></scene>"""


def prepared(folder, monkeypatch, text=OLD_SKY):
    """The prepared file of a scene of others."""
    (folder / "others/old").mkdir(parents=True, exist_ok=True)
    (folder / "others/old/scene.xml").write_text(text)
    monkeypatch.setenv("VISCACHE_SCENES", str(folder / "others"))
    (scene,) = shared_scenes(folder / "made", only="shared/old")
    return scene.path


def mean_picture(loaded):
    """Mean of a small picture."""
    assert loaded.render is not None, loaded.warnings
    return float(np.mean(loaded.render(8, 0)))


@pytest.mark.slow
@pytest.mark.mitsuba
def test_the_sky_of_an_old_file_stands_upright_in_mitsuba_3(tmp_path, monkeypatch):
    if reason := renderers.missing():
        pytest.skip(reason)
    path = prepared(tmp_path, monkeypatch)
    ours = mean_picture(renderers.load_viscache(path, 1))
    with renderers.mitsuba(threads=1) as mi:
        theirs = mean_picture(renderers.load_mitsuba(mi, path))
        # Power: as it stands in the file, the sun of Mitsuba 3 is below the horizon
        monkeypatch.setattr(shared, "_turn_skies", lambda _: None)
        path = prepared(tmp_path, monkeypatch)
        black = mean_picture(renderers.load_mitsuba(mi, path))
    assert theirs > 0.02
    assert ours == pytest.approx(theirs, rel=0.02)
    assert black < 1e-6
