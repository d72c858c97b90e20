"""``python -m lockprobe`` is the ``lockprobe`` command."""

from lockprobe.cli import main

if __name__ == "__main__":
    main()
