"""Files that Mitsuba 3 and viscache load and render alike, by blocks of pixels and by energy."""

import numpy as np
import pytest

import viscache as vc
from viscache_lab.parity import renderers, zoo
from viscache_lab.parity.judge import Effort, judge

mi = pytest.importorskip("mitsuba", reason="needs the package mitsuba")

BLOCK, FRAMES, SPP = 16, 4, 32
VIEW = """<sensor type="perspective"><float name="fov" value="50"/>
<transform name="to_world"><lookat origin="0,3,6" target="0,0.5,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/>
<rfilter type="box"/></film></sensor>"""
FLOOR = """<shape type="rectangle"><transform name="to_world"><scale value="5"/>
<rotate x="1" angle="-90"/></transform><bsdf type="diffuse"/></shape>"""


def write(folder, body):
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{VIEW}{FLOOR}{body}</scene>')
    return path


def of_viscache(path):
    scene = vc.load_scene(path)
    return [vc.render(scene, vc.Direct(), spp=SPP, seed=s).image for s in range(FRAMES)]


def of_mitsuba(path):
    mi.set_variant("scalar_rgb")
    scene, direct = mi.load_file(str(path)), mi.load_dict({"type": "direct"})
    return [np.array(mi.render(scene, integrator=direct, spp=SPP, seed=s)) for s in range(FRAMES)]


def blocks(frames):
    """Means of blocks (frames, rows, columns, 3)."""
    a = np.asarray(frames, np.float64)
    n, height, width, _ = a.shape
    return a.reshape(n, height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((2, 4))


def agreement(ours, theirs):
    """Share of the blocks within 3σ + 1 %."""
    mine, other = blocks(ours), blocks(theirs)
    sigma = np.sqrt((mine.var(0, ddof=1) + other.var(0, ddof=1)) / FRAMES)
    a, b = mine.mean(0), other.mean(0)
    return float(np.mean(np.abs(a - b) <= 3 * sigma + 0.01 * np.maximum(b, 1e-4)))


#: Sides of lamps, normals, cones, textures, cameras and materials; `viscache bench parity` judges
#: the other scenes of the zoo, too.
ZOO = """
emitter/rectangle-plain emitter/rectangle-mirror-x emitter/rectangle-flip-normals
emitter/cube-mirror-rotated emitter/disk-mirror-y emitter/sphere-rotated emitter/cylinder-plain
emitter/cylinder-flip-normals emitter/ply-mirror-x normals/ply-smooth-mirror-x
normals/ply-computed-plain light/spot-default light/spot-50-45 light/spot-20-20 light/area-picture
light/area-picture-disk texture/bitmap-nearest texture/bitmap-repeat-mixed
texture/bitmap-mirror-mixed texture/bitmap-clamp-mixed texture/checkerboard-mixed uv/sphere-turned
camera/principal--0.1-0.15 camera/crop-16-8-40-48 camera/orthographic-wide
material/plastic-picture-lamp material/plastic-nonlinear-ior1.5-sky material/plastic-ior1.5-point
material/roughplastic-nonlinear-ior1.5-alpha0.2-lamp material/conductor-Au-lamp
material/roughconductor-beckmann-lamp material/roughconductor-given-lamp
material/conductor-tinted-sky material/mask-0.25-lamp material/mask-picture-lamp

"""


@pytest.fixture(scope="module")
def quiet_mitsuba():
    with renderers.mitsuba() as module:
        yield module


@pytest.mark.slow
@pytest.mark.mitsuba
@pytest.mark.parametrize("name", ZOO.split())
def test_a_scene_of_the_zoo_looks_as_in_mitsuba(tmp_path, quiet_mitsuba, name):
    (case,) = (case for case in zoo.cases() if case.name == name)
    path = zoo.write(tmp_path, [case])[name]
    judged = judge(quiet_mitsuba, name, path, effort=Effort(most=24))
    assert judged.verdict == "agrees", judged.why
    # Power: a block that differs by so much would be found
    assert judged.compared is not None and judged.compared.power < 0.1
