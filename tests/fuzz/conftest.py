"""The frame of all fuzzers."""

import pytest

from fuzz import campaign


@pytest.fixture
def fuzz(pytestconfig, tmp_path):
    """Runs a target as the options say, and fails with what no user may meet."""
    option = pytestconfig.getoption

    def run(target, name):
        counts, bad = campaign.run(
            target,
            name,
            tmp_path,
            seconds=option("--fuzz-seconds"),
            cases=option("--fuzz-cases"),
            first=option("--fuzz-seed"),
        )
        print(f"{name}: {sum(counts.values())} cases, {dict(counts)}")
        assert not bad, "\n".join(bad)
        return counts

    return run
