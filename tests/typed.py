"""A command as typed, in a process of its own."""

import forked


def typed(*arguments, **settings):
    """Runs ``lockprobe`` to its end: exit status, output and errors; the directory and so on are ``forked.run``'s."""
    return forked.run(arguments, **settings)
