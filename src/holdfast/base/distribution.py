"""The name of holdfast on package indexes, and the commands that install it with an extra."""

DISTRIBUTION = "holdfast-robotics"  # what pip installs; what Python imports, and the command, are called holdfast


def installing(extra: str) -> str:
    """Return the command that installs holdfast with an extra, as remedies say it."""
    return f"pip install '{DISTRIBUTION}[{extra}]'"
