"""`--until`: a run on a slow machine ends in time and says what it left out."""

import os
import subprocess
import sys
import time

from codebase.repository import ROOT

ONE = "tests/math/test_isa.py::test_an_unknown_variant_is_refused"


def test_tests_that_begin_later_are_skipped_by_name():
    until = ["--until", str(int(time.time()) - 1)]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *until, ONE]
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(command, cwd=ROOT, env=alone, capture_output=True, text=True)
    assert "1 skipped" in done.stdout and "no time is left on this machine" in done.stdout
