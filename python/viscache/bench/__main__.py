"""`python -m viscache.bench NAME|all|list [--quick] [--json]`: the same as `viscache bench`."""

import sys

from viscache.cli import main

if __name__ == "__main__":
    sys.exit(main(["bench", *sys.argv[1:]]))
