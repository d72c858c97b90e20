"""``python -m lockprobe`` is the ``lockprobe`` command."""

import sys

if __name__ == "__main__":
    if not sys.flags.safe_path:
        del sys.path[0]  # the working directory
    from lockprobe.cli import main

    main()
