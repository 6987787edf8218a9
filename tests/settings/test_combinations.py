"""One table says what does not combine: it is refused, and docs/limits.md prints it."""

from pathlib import Path

import pytest

import viscache as vc
from viscache.settings import combinations
from viscache.settings.combinations import RULES, Request

LIMITS = Path(__file__).parents[2] / "docs" / "limits.md"


class Own:
    def block(self, eyes, lamps, wanted):
        return eyes.trace(lamps, wanted)


#: One request that breaks each rule, in their order.
BROKEN = [
    {"integrator": vc.Bdpt(), "visibility": vc.VisMaps()},
    {"integrator": vc.Direct(environment="shared"), "visibility": vc.VisMaps()},
    {"integrator": vc.Direct(n_environment=0), "visibility": vc.VisMaps()},
    {"visibility": vc.VisMaps(alpha="loo")},
    {"integrator": vc.Bdpt(), "visibility": vc.ShadowMap()},
    {"visibility": vc.Aqvc(paper=vc.PaperForm(storage="shared"))},
    {"integrator": vc.Direct(environment="product"), "visibility": Own()},
    {"integrator": vc.Direct(passes=2)},
    {"integrator": vc.AmbientOcclusion(n_samples=33, directions="shared"), "rays": vc.Bsp()},
    {"integrator": vc.AmbientOcclusion(n_samples=33, directions="shared"), "visibility": vc.Aqvc()},
    {"visibility": vc.Exact(sky_engine="auto"), "rays": vc.Bsp()},
    {"visibility": vc.Exact(sky_engine="auto"), "integrator": vc.Bdpt()},
    {"visibility": vc.Exact(engine="shafts"), "rays": vc.Bsp()},
    {"keep": True},
    {"keep": True, "keeps_voxels": True},
    {"keep": True, "visibility": vc.Aqvc(), "integrator": vc.Bdpt()},
    {"keep": True, "keeps_rows": True, "visibility": vc.Aqvc(preset="paper")},
    {"first_sample": 1, "integrator": vc.Bdpt()},
    {"keep": True, "visibility": vc.Aqvc(), "parts": 2},
    {"parts": 2, "visibility": vc.ShadowMap()},
    {"parts": 2, "integrator": vc.Bdpt()},
    {"parts": 2, "visibility": vc.Aqvc(paper=vc.PaperForm(storage="paper_tiles"))},
    {"parts": 2, "batch": True},
    {"audit": vc.AuditPixels()},
    {"audit": vc.AuditPixels(), "visibility": vc.Aqvc(), "use": "correct"},
    {"audit": vc.AuditPixels(), "visibility": vc.Aqvc(), "integrator": vc.Bdpt()},
    {
        "audit": vc.AuditPixels(),
        "visibility": vc.ShadowMap(),
        "integrator": vc.Direct(environment="product"),
    },
    {"audit": vc.AuditQueries(), "visibility": vc.NeePlusPlus()},
]


@pytest.mark.parametrize("number", range(len(RULES)), ids=[rule.must[:50] for rule in RULES])
def test_each_rule_is_the_one_that_is_broken(number):
    whole = {
        "integrator": vc.Direct(),
        "rays": vc.Embree(),
        "visibility": vc.Exact(),
    }
    request = Request(**whole | BROKEN[number])
    broken = [i for i, rule in enumerate(RULES) if rule.refused(request)]
    assert broken == [number]
    with pytest.raises(ValueError, match="must") as caught:
        combinations.check(request)
    assert str(caught.value).startswith(RULES[number].must + ", got ")


def test_there_is_a_request_for_each_rule():
    assert len(BROKEN) == len(RULES)


@pytest.mark.parametrize(
    "integrator", [vc.Direct(), vc.Whitted(), vc.AmbientOcclusion(), vc.Bdpt()]
)
@pytest.mark.parametrize("use", [None, "correct"])
@pytest.mark.parametrize("visibility", [vc.Exact(), vc.Aqvc(), vc.NeePlusPlus(), Own()])
def test_every_integrator_works_with_every_oracle(integrator, visibility, use):
    combinations.check(
        Request(integrator=integrator, rays=vc.Embree(), visibility=visibility, use=use)
    )
    frame = vc.render(
        vc.scenes.cube_on_plane(), integrator, visibility=visibility, use=use, size=(8, 6)
    )
    assert frame.counters["queries"] >= 0


def test_the_limits_page_prints_the_table():
    assert combinations.table() in LIMITS.read_text(encoding="utf-8")
