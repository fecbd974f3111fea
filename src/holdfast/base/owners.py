"""Whose files are: what is run unseen must belong to the user or to root, and nobody else may write it."""

from __future__ import annotations

import os
import stat
from pathlib import Path

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class NotOursError(Exception):
    """A file is not ours alone."""


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
    """Return why one of ``count`` folders, up from ``folder``, is not ours alone, with its path; "" if all are."""
    for path in (folder, *folder.parents)[count - 1 :: -1]:
        try:
            reason = why_not_ours(path.stat())
        except OSError:  # it is not there yet, or cannot be read: nothing comes from it
            continue
        if reason:
            return f"{path} {reason}"
    return ""


def read_ours(path: Path) -> bytes:
    """Return the content of a file; raise NotOursError if it is not ours alone. What is looked at is what is read."""
    with path.open("rb") as stream:
        reason = why_not_ours(os.fstat(stream.fileno()))
        if reason:
            raise NotOursError(f"{path} {reason}")
        return stream.read()
