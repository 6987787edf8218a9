"""What only tests call of the C++ core: `from core import testing`.

The module `testing` is compiled from the sources here, beside this file. VISCACHE_TEST_CORE is
"none" where tests run with another build of viscache: one from a wheel, or with sanitizers.
"""

import os
from importlib.util import find_spec

import pytest

if os.environ.get("VISCACHE_TEST_CORE") == "none":
    pytest.skip("tests/core is not built for this viscache", allow_module_level=True)
if find_spec("core.testing") is None:
    raise ImportError("tests/core is not built: run scripts/test")
