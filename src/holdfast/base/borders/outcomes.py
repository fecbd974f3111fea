"""The outcomes of a scene, and the kinds of messages between a worker and its supervisor."""

from __future__ import annotations

READY, PART, DONE = "ready", "part", "done"  # messages of a worker, beside the outcomes below
ANSWERED, ERROR, TIME, MEMORY, CRASH = "answered", "error", "time", "memory", "crash"  # outcomes of a scene
OUTCOMES = (ANSWERED, ERROR, TIME, MEMORY, CRASH)
MEGABYTE = 1 << 20  # bytes
