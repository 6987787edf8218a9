"""What only tests call of the C++ core: `from core import testing`.

The module `testing` is compiled from the sources here, beside this file. VISCACHE_TEST_CORE names the folder
of another build, or is "none" where tests run with a viscache that was installed from a wheel.
"""

import os
from importlib.util import find_spec

import pytest

folder = os.environ.get("VISCACHE_TEST_CORE", "")
if folder == "none":
    pytest.skip("tests/core is not built for this viscache", allow_module_level=True)
if folder:
    __path__.insert(0, folder)
if find_spec("core.testing") is None:
    raise ImportError("tests/core is not built: run scripts/test")
