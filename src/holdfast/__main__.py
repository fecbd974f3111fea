"""The command line: ``holdfast`` and ``python -m holdfast``."""

import os
import signal
from types import FrameType


def _stop(_: int, __: FrameType | None) -> None:
    """End the process as ``cli/stopping.py`` does, which is not imported yet, nor has anything been begun."""
    os.write(2, b"stopped: by the user\n")
    os._exit(130)


def main() -> None:
    """Run the command line; imports take a second, in which the user may lose patience, too."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else somebody else stops, or nobody does
        signal.signal(signal.SIGINT, _stop)
    from holdfast.cli.stopping import stoppable

    signal.signal(signal.SIGINT, before)
    with stoppable(process=True):
        from holdfast.cli.main import run

        run()


if __name__ == "__main__":
    main()
