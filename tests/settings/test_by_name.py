"""Settings by name: those within settings go by their bare names, too."""

import json

import pytest

import viscache as vc
from viscache.settings import by_name

CHOSEN = {
    "integrator": vc.Direct(),
    "rays": vc.Embree(),
    "visibility": vc.Aqvc(),
}


@pytest.mark.parametrize("name", ["hash", "paper.hash", "visibility.hash", "visibility.paper.hash"])
def test_every_name_of_a_parameter_reaches_it(name):
    assert by_name.owner(name, CHOSEN) == ("visibility", "hash")
    made = by_name.assign(CHOSEN, [f"{name}=scheme1", "c_e=8"])["visibility"]
    assert made == vc.Aqvc(c_e=8, paper=vc.PaperForm(hash="scheme1"))


@pytest.mark.parametrize(
    "spec",
    [
        {"name": "aqvc", "preset": "paper", "hash": "scheme1"},
        {"name": "aqvc", "preset": "paper", "paper": {"hash": "scheme1"}},
        {"name": "aqvc", "preset": "paper", "paper.hash": "scheme1"},
    ],
    ids=str,
)
def test_a_table_may_nest_them_or_not(spec):
    made = by_name.make("visibility", spec)
    assert made == vc.Aqvc(preset="paper", paper=vc.PaperForm(hash="scheme1"))
    assert (made.paper.form, made.paper.hash) == ("pairs", "scheme1")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("hsh", "visibility Aqvc has no parameter 'hsh'; did you mean 'hash'"),
        ("paper.hsh", "PaperForm has no parameter 'hsh'; did you mean 'hash'"),
        ("c_nn", "visibility Aqvc has no parameter 'c_nn'; did you mean 'c_n'"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest_one(name, message):
    with pytest.raises(ValueError, match=message):
        by_name.replaced(vc.Aqvc(), {name: 1}, "visibility")
    if "." in name:
        with pytest.raises(ValueError, match=message):
            by_name.owner(name, CHOSEN)
    with pytest.raises(ValueError, match=r"'lamp\.hash' must start with one of integrator, rays"):
        by_name.owner("lamp.hash", CHOSEN)


@pytest.mark.parametrize(
    "settings",
    [
        vc.Aqvc(),
        vc.Aqvc(preset="fast", c_e=7, c_e_groups={"point": 3.0}),
        vc.Aqvc(preset="as_printed", c_z=4.0, paper=vc.PaperForm(digest_bits=9, batch=0)),
    ],
    ids=str,
)
def test_a_description_makes_the_settings_again_and_leaves_the_preset_its_part(settings):
    described = by_name.described("visibility", settings)
    assert "c_n" not in described and "form" not in described
    again = by_name.make("visibility", json.loads(json.dumps(described)))
    assert again == settings and again.resolved() == settings.resolved()
    assert again.for_frame_table().resolved() == settings.for_frame_table().resolved()


def test_a_sweep_reaches_what_the_papers_form_has_by_both_names(tmp_path):
    scene = vc.scenes.cube_on_plane()
    table = vc.sweep(
        scene,
        vc.Direct(),
        visibility=vc.Aqvc(preset="paper", c_e=8, table_bytes=400),
        over={"digest_bits": [1, 31], "paper.hash": ["scheme1", "scheme2"]},
        size=(32, 20),
        metrics=["rel_l1"],
        directory=tmp_path,
    )
    errors = table.rel_l1.mean("repeat")
    assert set(errors.dims) == {"digest_bits", "hash"}
    plain = errors.sel(digest_bits=31, hash="scheme2")
    assert float(errors.sel(digest_bits=1, hash="scheme2")) > float(plain)
