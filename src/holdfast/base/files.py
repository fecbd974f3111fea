"""Atomic writing of files: a file appears complete or not at all."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from holdfast.base.errors import HoldfastError, message


def write_atomically(path: str | os.PathLike[str], content: bytes) -> None:
    """Replace the file at ``path`` by ``content`` in one step.

    A failure leaves the old file as it was, and raises HoldfastError.
    """
    target = Path(path)
    temporary = target.with_name(f".{target.name}.{secrets.token_hex(6)}.tmp")
    try:
        try:
            with temporary.open("xb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as cause:
        reason = cause.strerror or str(cause)
        raise HoldfastError(
            message(str(target), f"cannot be written: {reason}", "name a file in a writable folder")
        ) from cause
