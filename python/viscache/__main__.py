"""`python -m viscache` is `viscache`."""

import sys

from viscache.cli import main

sys.exit(main())
