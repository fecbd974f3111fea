"""Inputs that do on purpose what a trial may do by mistake: a drill for the keeper."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np

import holdfast as hf
from fuzz import trials
from fuzz.outcome import Ending, Outcome


def tried(item: dict[str, Any]) -> Outcome:
    """Do what the input says, and tell how it ended as a trial would."""
    trials.TRIALS["drill"] = drilled
    return trials.tried({"kind": "drill", **item})


def drilled(item: dict[str, Any], folder: object) -> Outcome:
    match item["do"]:
        case "loop":
            while True:
                time.sleep(0.01)
        case "die":
            os._exit(7)
        case "raise":
            raise ValueError("not on purpose")
        case "tell":
            raise hf.errors.SceneError("on purpose")
        case "tell badly":
            raise hf.errors.SceneError("body '\x1b[31m': is red")
        case "hide":
            try:
                np.ones(int(item["bytes"]) // 8)
            except MemoryError as cause:
                raise hf.errors.GeometryError("cannot be read") from cause
        case "take":
            np.ones(int(item["bytes"]) // 8)
        case "warn":
            np.float64(1) / np.float64(0)
    return Outcome(Ending.OK)
