"""`viscache sweep SCENE --over ...`: the sweep of a file, without the file."""

import pytest
import xarray

from viscache import cli

SCENE = "cube_on_plane"
SHORT = ["--size", "12x8", "--integrator", "whitted", "--set", "n_vpls=4", "--set", "c_z=2.5"]
SHORT += ["--env", "0.5", "--threads", "1", "--camera", "0"]


def test_a_scene_is_swept_as_a_file_would_be(tmp_path, capsys):
    at = tmp_path / "by_options"
    over = ["--over", "c_e=4,8", "--over", "c_n=2,4", "--repeats", "2"]
    assert cli.main(["sweep", SCENE, *over, *SHORT, "-o", str(at)]) == 0
    file = tmp_path / "sweep.toml"
    file.write_text(
        f'scene = "{SCENE}"\nsize = [12, 8]\nrepeats = 2\nenv = 0.5\nthreads = 1\ncamera = "0"\n'
        'integrator = {name = "whitted", n_vpls = 4}\nvisibility = {name = "aqvc", c_z = 2.5}\n'
        "[over]\nc_e = [4, 8]\nc_n = [2, 4]\n"
    )
    assert cli.main(["sweep", str(file), "-o", str(tmp_path / "by_file")]) == 0
    capsys.readouterr()
    by_options, by_file = (
        xarray.load_dataset(tmp_path / d / "table.nc", engine="h5netcdf")
        for d in ("by_options", "by_file")
    )
    assert dict(by_options.sizes) == {"c_e": 2, "c_n": 2, "repeat": 2, "group": 3}
    for name in ("rel_l1", "rays", "queries"):
        assert by_options[name].equals(by_file[name])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ([SCENE], "a sweep of a scene must have --over NAME=VALUE,VALUE, got cube_on_plane alone"),
        ([SCENE, "--over", "c_e"], "--over must be NAME=VALUE,VALUE, got 'c_e'"),
        ([SCENE, "--over", "c_e=1", "--over", "c_e=2"], "--over must name c_e once"),
        ([SCENE, "--over", "c_ee=1,2"], "did you mean 'c_e'?"),
        (["some.toml", "--spp", "2"], "--spp must come with a scene; some.toml has it as a key"),
        (["some.toml"], "no such sweep file: some.toml"),
    ],
)
def test_what_is_wrong_is_one_line(given, said, tmp_path, capsys):
    assert cli.main(["sweep", *given, "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
