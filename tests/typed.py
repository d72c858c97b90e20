"""A command as typed, in a process of its own or in this one."""

import forked
from typer.testing import CliRunner

from lockprobe.cli import build


def typed(*arguments, **settings):
    """Runs ``lockprobe`` to its end: exit status, output and errors; the directory and so on are ``forked.run``'s."""
    return forked.run(arguments, **settings)


def in_process(*words, stdin=""):
    """Runs ``lockprobe`` here; a mistake is raised instead of printed."""
    said = [str(word) for word in words]
    done = CliRunner().invoke(build(said[:1]), said, input=stdin)
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done
