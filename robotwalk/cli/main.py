"""The `robotwalk` command: its exit codes, and errors as one sentence each."""

import sys

from robotwalk.cli.output import abandon_stdout, complain
from robotwalk.errors import ConfigError, RobotwalkError


def main() -> None:
    """Run one command and exit with its code."""
    sys.exit(_run(sys.argv[1:]))


def _run(words: list[str]) -> int:
    try:
        if words[:1] in (["stop"], ["clear"]):
            from robotwalk.cli.stop import main as stop  # for which nobody wants to wait

            return stop(words)
        return _run_app()
    except ConfigError as error:
        # Each line begins with file:line:column, for editors to jump there.
        sys.stderr.write(f"{error}\n")
        return error.exit_code
    except RobotwalkError as error:
        complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        # Whoever read our output has had enough of it.
        abandon_stdout()
        return 1


def _run_app() -> int:
    from cyclopts import CycloptsError

    from robotwalk.cli.app import app

    try:
        return app(exit_on_error=False, print_error=False, result_action="return_value") or 0
    except CycloptsError as error:
        complain(str(error).strip())
        return 2
