"""Ownership of files: code is loaded only from files that belong to the user or root and that nobody else can write."""

from __future__ import annotations

import os
import stat
from pathlib import Path

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class NotOursError(Exception):
    """A file belongs to, or can be written by, somebody else than the user or root."""


def why_not_ours(found: os.stat_result) -> str:
    """Return why a file or folder may hold what somebody else put there, or "" if only this user or root can."""
    if not hasattr(os, "geteuid"):  # Windows, where a user's cache folder is closed to others
        return ""
    if found.st_uid not in (0, os.geteuid()):
        return f"belongs to user {found.st_uid}"
    if found.st_mode & OTHERS_WRITE:
        return f"may be written by others (mode {stat.S_IMODE(found.st_mode):o})"
    return ""


def why_not_our_folders(folder: Path, count: int) -> str:
    """Return which of ``folder`` and its parents somebody else could write to, and why; "" if none.

    ``count`` is the number of folders that are checked, ``folder`` included.
    """
    for path in (folder, *folder.parents)[count - 1 :: -1]:
        try:
            reason = why_not_ours(path.stat())
        except OSError:  # it does not exist yet or cannot be read, so nothing is loaded from it
            continue
        if reason:
            return f"{path} {reason}"
    return ""


def read_ours(path: Path) -> bytes:
    """Return the content of a file; raise NotOursError if somebody else could have written it.

    The open file is checked, so it cannot be exchanged between check and reading.
    """
    with path.open("rb") as stream:
        reason = why_not_ours(os.fstat(stream.fileno()))
        if reason:
            raise NotOursError(f"{path} {reason}")
        return stream.read()
