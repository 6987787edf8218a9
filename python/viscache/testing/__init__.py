"""Assertions about pictures for tests, and exact frames that tests share.

`import viscache as vc`; `vc.testing` works with any test runner. With pytest, the plugin
`pytest_viscache` adds the fixture `viscache_exact`, and a test that fails leaves a page with both
pictures (docs/howto/pytest.md).
"""

from viscache.sweeps.exact_frames import ExactFrames
from viscache.testing.close import assert_close
from viscache.testing.failure import PictureError
from viscache.testing.unbiased import Bias, assert_unbiased

__all__ = ["Bias", "ExactFrames", "PictureError", "assert_close", "assert_unbiased"]
