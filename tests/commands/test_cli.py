"""The command line: exit statuses, shapes of the JSON, one-line complaints."""

import json
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import viscache
from codebase.repository import text
from viscache import cli, metrics
from viscache.frame import Frame


@pytest.fixture
def run(capsys):
    """Status, output and complaints of a command line."""

    def run(*words):
        status = cli.main(list(words))
        return status, *capsys.readouterr()

    return run


@pytest.fixture
def pair(tmp_path):
    b = np.random.default_rng(0).random((16, 20, 3)) + 0.1
    Frame(layers={"color": b * 1.1}).save(tmp_path / "a.exr")
    Frame(layers={"color": b}).save(tmp_path / "b.exr")
    return str(tmp_path / "a.exr"), str(tmp_path / "b.exr")


def test_diff_prints_every_metric_as_one_json_object(run, pair, tmp_path):
    png = tmp_path / "d.png"
    status, out, err = run(
        "diff", *pair, "--json", "--png", str(png), "--html", str(tmp_path / "d.html")
    )
    got = json.loads(out)
    assert status == 0 and err == "" and png.read_bytes()[:4] == b"\x89PNG"
    assert set(got) == set(metrics.METRICS)
    assert {"rmse", "rel_mse", "rel_l1", "energy", "flip", "ssim", "max_abs"} < set(got)
    assert got["rel_l1_reflected"] is None  # these files do not say what is emitted
    page = (tmp_path / "d.html").read_text("utf-8")
    assert "<title>a.exr − b.exr</title>" in page
    assert got["rel_l1"] == pytest.approx(0.1, rel=1e-5)
    assert got["energy"] == pytest.approx(0.1, rel=1e-5)


def test_diff_with_limits_is_a_check(run, pair):
    met = ["--limit", "rel_l1<=0.11", "--limit", "ssim>=0.5"]
    status, out, err = run("diff", *pair, "--json", *met)
    assert status == 0 and err == "" and json.loads(out)
    status, out, err = run("diff", *pair, "--json", *met, "--limit", "energy<=0.05")
    assert status == 1 and json.loads(out)["energy"] == pytest.approx(0.1, rel=1e-5)
    assert err == "energy 0.1 must be within ±0.05, 2 times\n"


def test_diff_against_black_prints_null(run, pair, tmp_path):
    Frame(layers={"color": np.zeros((16, 20, 3))}).save(tmp_path / "z.exr")
    _, out, _ = run("diff", pair[0], str(tmp_path / "z.exr"), "--json")
    assert json.loads(out)["rel_l1"] is None


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("", "required: COMMAND"),
        ("rendr", "did you mean 'render'"),
        ("diff no.exr no.exr", "no such file: no.exr"),
        ("diff a.exr", "required: REF.exr"),
        ("diff a.exr b.exr --limit energy>=0.1", "energy<=NUMBER"),
        ("diff a.exr b.exr --limit flop<=1", "did you mean 'flip'"),
        ("render room -o x.gif", "path must end in .exr, .png, .jpg, .jpeg, got"),
        ("render a.obj -o x.exr --exposure 2", "exposure must be left out for"),
        ("render room -o x.exr --size 0x4", "size must be WxH, both >= 1"),
        ("render room -o x.exr --spp 0", "whole number >= 1, got '0'"),
        ("render room -o x.exr --set c_e", "--set must be name=value"),
        ("render room -o x.exr --visibility aqvc --set c_x=1", "unknown parameter 'c_x'"),
        ("render room -o x.exr --visibility vlf --rays bsp", "is short for"),
        (
            "render room -o x.exr --visibility shadow_map --set resolution=0",
            "resolution must be in [1, 16384], got 0",
        ),
        ("render cube_on_plane -o x.exr --visibility vismap", "must have an environment light"),
        ("render room -o x.exr --set n_vpls=1.5", "must be a whole number"),
        ("render room -o x.exr --set vpl_bound=nan", "must be a finite number"),
        ("render room -o x.exr --set robust=maybe", "must be true or false"),
        ("render cube_on_plane -o x.exr --env /", "/: no such file"),
        ("render cube_on_plane -o x.exr --env nan", "must be finite"),
        ("render cube_on_plane -o x.exr --camera 7", "camera must be in [0, 1)"),
        ("info /", "/: is a directory, not a scene file"),
        ("info ''", "a file or a built-in name, got ''"),
        ("sweep none.toml -o out", "no such sweep file"),
        ("sweep / -o out", "must have --over NAME=VALUE,VALUE, got / alone"),
        ("report none", "no such directory"),
        ("report none --format pdf", "--format must come with --plots FOLDER"),
        ("reproduce aqvc-fig9", "unknown figure"),
        ("reproduce aqvc-fig3 --size 0x4", "size must be WxH, both >= 1"),
        ("reproduce vismap-fig5 --size 8x4", "size must be left out for vismap-fig5"),
        ("bench no-such-bench", "unknown bench"),
        ("tune room --error 2", "rel_l1_reflected must lie in (0, 1), got 2"),
        ("tune room --set c_ee=2", "unknown parameter 'c_ee'"),
    ],
)
def test_bad_usage_is_one_line_and_status_2(run, words, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*shlex.split(words))
    assert status == 2 and out == "" and says in err
    assert len(err.strip().splitlines()) == 1 and "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_a_report_says_what_its_directory_must_be_and_what_it_is(run, tmp_path):
    empty, other, file = tmp_path / "empty", tmp_path / "other", tmp_path / "a.exr"
    empty.mkdir(), other.mkdir(), file.touch()
    for name in "abcdefg":
        (other / f"{name}.md").touch()
    for given, says in (
        (empty, "it has no sweep.sqlite and holds nothing"),
        (other, "holds a.md, b.md, c.md, d.md, e.md and 2 more"),
        (file, f"got the file {file}"),
    ):
        status, out, err = run("report", str(given))
        assert status == 2 and out == "" and len(err.strip().splitlines()) == 1
        assert "DIR must be a directory that `viscache sweep FILE.toml -o DIR` filled" in err
        assert says in err and str(given) in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.exr", "empty", "other"]


def test_too_little_memory_is_one_line(run, tmp_path, monkeypatch):
    def full(*_, **__):
        raise MemoryError("std::bad_alloc")

    monkeypatch.setattr(viscache, "render", full)
    status, out, err = run("render", "cube_on_plane", "-o", str(tmp_path / "x.exr"))
    assert status == 2 and out == ""
    assert "not enough memory" in err and len(err.strip().splitlines()) == 1


def test_debug_gives_the_traceback(tmp_path):
    with pytest.raises(FileNotFoundError):
        cli.main(["diff", "--debug", str(tmp_path / "no.exr"), "no.exr"])


def test_ctrl_c_gives_130_and_keeps_what_was_finished(run, fake_vc, tmp_path):
    file = tmp_path / "a.toml"
    text = 'scene = "room"\nsize = [16, 12]\nmetrics = ["rel_l1"]\n[over]\nc_e = [2, 4, 8]\n'
    file.write_text(text)
    out = str(tmp_path / "out")
    fake_vc.STOP[:] = [2]
    status, _, err = run("sweep", str(file), "-o", out)
    assert status == 130 and "Traceback" not in err
    assert len((tmp_path / "out" / "table.csv").read_text().splitlines()) == 2
    fake_vc.STOP.clear()
    status, text, _ = run("sweep", str(file), "-o", out, "--json")
    assert status == 0 and json.loads(text)["sizes"]["c_e"] == 3
    assert len(fake_vc.CALLS) == 4
    status, text, _ = run("report", out)
    assert status == 0 and Path(text.strip()).read_text("utf-8").startswith("<!doctype html>")
    words = shlex.split("--flip-maps 0 --format pdf --format svg --json")
    status, text, _ = run("report", out, "--plots", f"{out}/figures", *words)
    drawn = [Path(p) for p in json.loads(text)["plots"]]
    assert [p.name for p in drawn] == [
        f"trade-{c}.{k}" for c in ("total_s", "rays") for k in ("pdf", "svg")
    ]
    assert all(p.stat().st_size > 2000 for p in drawn)


def test_lists_name_what_there_is(run):
    status, out, _ = run("reproduce", "list")
    assert status == 0 and "aqvc-fig3 (shadow edges" in out
    status, out, _ = run("bench", "list", "--json")
    names = [b["bench"] for b in json.loads(out)["benches"]]
    assert status == 0 and {"rays", "aqvc-frame", "loading"} <= set(names)


def test_a_wrong_answer_of_a_bench_is_status_1_and_a_missed_goal_is_not(run, monkeypatch):
    from viscache_lab import bench

    figure = {"name": "x vs y", "value": 1.0, "unit": "s", "baseline": "y", "ratio": 0.5, "goal": 2}
    figure |= {"holds": False, "low": 0.4, "high": 0.6}
    machine = {"processor": "p", "cores": 1}
    answer = {"what": "same hits", "value": 1.0, "limit": 0.0}

    def made(name, quick=False, **_):
        holds = name == "right"
        return {
            "bench": name,
            "machine": machine,
            "figures": [figure],
            "answers_checked": True,
            "answers_hold": holds,
            "answers": [{**answer, "holds": holds}],
            "skipped": [],
        }

    monkeypatch.setattr(bench, "run_bench", made)
    assert run("bench", "right")[0] == 0
    status, out, _ = run("bench", "no", "--json")
    assert status == 1 and json.loads(out)["answers_hold"] is False


def test_another_package_can_add_a_command(run, tmp_path, monkeypatch):
    info = tmp_path / "bakery-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: bakery\nVersion: 1.0\n")
    entries = "[viscache.commands]\nbake = bakery\nburn = ashes\nscenes = bakery\n"
    (info / "entry_points.txt").write_text(entries)
    (tmp_path / "bakery.py").write_text(
        '"""Light of a scene, baked."""\n\n'
        "def add_arguments(parser):\n    parser.add_argument('scene')\n\n"
        "def run(arguments):\n    print('baked', arguments.scene)\n    return 1\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    cli._added.cache_clear()
    try:
        assert run("bake", "room") == (1, "baked room\n", "")
        assert re.search(r"bake +light of a scene, baked\n", run("--help")[1])
        assert "Light of a scene, baked.\n" in run("bake", "--help")[1]
        assert "did you mean 'bake'" in run("bakke")[2]
        said = run("burn", "room")
        assert said[0] == 2 and "command 'burn' must load, got No module named 'ash" in said[2]
        assert "burn " in run("--help")[1]  # and all others are listed
        status, out, _ = run("scenes")  # our own command stays
        assert status == 0 and "baked" not in out
    finally:
        cli._added.cache_clear()


def test_commands_of_the_lab_are_found_in_place_as_installed():
    project, here = text("pyproject.toml"), text("python/viscache.dist-info/entry_points.txt")
    entries = project.partition('[project.entry-points."viscache.commands"]\n')[2].partition("\n\n")
    assert here == "[viscache.commands]\n" + entries[0].replace('"', "") + "\n"
    assert {"bench", "demo", "doctor", "reproduce"} <= set(cli._added())
    assert '"python/viscache_lab"' in project


@pytest.mark.parametrize("name", ["bench", "extremes", "figures", "parity"])
def test_modules_that_left_the_library_name_their_place(name):
    with pytest.raises(ModuleNotFoundError, match=f"is viscache_lab.{name} now"):
        exec(f"from viscache import {name}")
    assert not hasattr(viscache, "no_such_name")


def test_help_needs_no_heavy_imports():
    code = (
        "import sys\nfrom viscache import cli\nassert cli.main(['render', '--help']) == 0\n"
        "print(*[m for m in ('matplotlib', 'xarray', 'skimage', 'pandas') if m in sys.modules],"
        " file=sys.stderr)"
    )
    path = str(Path(viscache.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={"PYTHONPATH": path, "PATH": ""},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "--visibility" in done.stdout and done.stderr.strip() == ""


CUBE = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"


def test_render_writes_the_picture_its_json_describes(run, tmp_path):
    (tmp_path / "m.obj").write_text(CUBE)
    out = tmp_path / "o.exr"
    words = shlex.split(
        "--integrator ao --visibility aqvc --set c_e=4 --set integrator.n_samples=8"
    )
    words += ["--size", "24x16", "--json"]
    status, text, _ = run("render", str(tmp_path / "m.obj"), "-o", str(out), *words)
    assert status == 0
    got = json.loads(text)
    assert {"counters", "timings", "parameters", "sha256", "warnings"} <= set(got)
    assert {"queries", "rays", "ray_reduction"} <= set(got["counters"])
    assert {"total_s", "visibility_s", "shading_s"} <= set(got["timings"])
    assert got["parameters"]["visibility"]["c_e"] == 4
    frame = Frame.load(out)
    assert frame.sha256 == got["sha256"] and frame.size == (24, 16)


def test_render_writes_pictures_to_look_at(run, tmp_path):
    out = tmp_path / "o.png"
    words = ["render", "slits", "-o", str(out), "--integrator", "direct", "--size", "24x16"]
    assert run(*words)[0] == 0
    plain = out.read_bytes()
    assert plain.startswith(b"\x89PNG")
    assert run(*words, "--exposure", "0.01")[0] == 0
    assert out.read_bytes() != plain


def test_a_camera_is_named_by_index_too_and_env_takes_a_number(run, tmp_path):
    words = ["-o", str(tmp_path / "o.exr"), "--integrator", "direct", "--size", "8x5", "--json"]
    status, text, _ = run(
        "render", "room?triangles=2000&lights=0", "--camera", "1", "--env", "0.5", *words
    )
    got = json.loads(text)
    assert status == 0 and got["parameters"]["camera"] == "corner"
    assert "environment" in got["counters"]["groups"] and got["warnings"] == []


def test_ctrl_c_while_rendering_ends_with_130_and_without_a_file(tmp_path):
    # A shell's background jobs ignore Ctrl-C; the command must not inherit that
    code = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from viscache import cli, metrics
print(flush=True)
sys.exit(cli.main())
"""
    words = shlex.split("render room?triangles=2000 --size 1280x800 --spp 64 -o")
    words.append(str(tmp_path / "o.exr"))
    with subprocess.Popen(
        [sys.executable, "-c", code, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        process.stdout.readline()
        time.sleep(0.7)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 130
        assert process.stderr.read().strip() == "viscache: interrupted; what was finished is kept"
    assert list(tmp_path.iterdir()) == []


def test_info_prints_the_share_of_coplanar_triangles_and_that_there_is_no_light(run, tmp_path):
    quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 1\n"
    (tmp_path / "m.obj").write_text(quad + "f 1 2 3\nf 1 3 4\nf 5 6 7\n")
    status, text, _ = run("info", str(tmp_path / "m.obj"))
    assert status == 0
    assert re.search(r"^coplanar_share +66\.7%$", text, re.M)
    assert re.search(r"^memory +.* MiB", text, re.M)
    assert "warning: the scene has no light; give it one with env=" in text
    status, text, _ = run("info", str(tmp_path / "m.obj"), "--json")
    assert json.loads(text)["coplanar_share"] == pytest.approx(2 / 3)


def test_the_coplanar_share_weighs_a_mesh_by_how_often_it_is_placed():
    import viscache as vc

    d = vc.SceneDescription()
    quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    d.add_mesh(quad, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), in_world=False)
    d.add_mesh(quad[:3], np.array([[0, 1, 2]], np.uint32))
    for x in range(3):
        to_world = np.eye(4)
        to_world[0, 3] = 2 * x
        d.add_instance([0], to_world)
    assert vc.Scene.from_description(d).coplanar_share == pytest.approx(6 / 7)


def test_doctor_is_well_here(run):
    status, text, _ = run("doctor", "--json")
    got = json.loads(text)
    assert status == 0 and got["ok"], got["checks"]
    assert len(got["checks"]) >= 5 and all(c["holds"] for c in got["checks"])
    assert got["isa"]["active"] and got["versions"]["embree"][0].isdigit()


def test_doctor_reports_a_broken_build_with_status_1(run, monkeypatch):
    inverted = viscache.Scene.visible
    monkeypatch.setattr(viscache.Scene, "visible", lambda s, x, y: ~inverted(s, x, y))
    status, text, _ = run("doctor", "--json")
    failed = [c["name"] for c in json.loads(text)["checks"] if not c["holds"]]
    assert status == 1 and failed == ["visible() agrees with plane geometry"]


def test_scenes_lists_every_built_in_scene_with_its_parameters(run):
    status, text, _ = run("scenes", "--json")
    got = json.loads(text)
    assert status == 0 and "triangles" in got["room"]["parameters"]
    status, text, _ = run("scenes")
    assert status == 0 and all(f"{name}: " in text for name in got)
