"""``python -m holdfast``: the command line."""

from holdfast.cli.main import run

run()
