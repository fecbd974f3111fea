"""The command line: ``holdfast`` and ``python -m holdfast``."""

from __future__ import annotations

from holdfast.cli.stopping import stoppable


def main() -> None:
    """Run the command line; imports take a second, in which the user may lose patience, too."""
    with stoppable(process=True):
        from holdfast.cli.main import run

        run()


if __name__ == "__main__":
    main()
