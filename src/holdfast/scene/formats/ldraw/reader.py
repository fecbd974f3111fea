"""Reads LDraw models (.ldr, .mpd): bricks, plates, tiles and baseplates, which hold each other by their studs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked_number
from holdfast.base.errors import SceneError, located, message
from holdfast.base.ranges import FORCE, PLACE
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.ldraw.brick_parts import BrickPart, part_of
from holdfast.scene.formats.links import checked_fixed, on_the_floor, scene_of, unique, with_floor
from holdfast.scene.formats.named_meshes import Numbers, Weights
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

LDU, PITCH = 4e-4, 20  # [m] the unit of LDraw, and how many of it are between two studs
MOST_PLACEMENTS = 100_000  # of parts and submodels; contact detection would take hours for more
MOST_STUDS = 1_000_000  # of all parts: some hundred bytes each
DEEPEST = 40  # submodels within each other
NEAR = 0.5  # [LDU] up to which a stud is in an underside: models are rounded to less
STRAIGHT = 1e-3  # [-] by which a turn may be off: LDraw writes three to six digits
# [N] per stud in an underside one stud wide, and in a wider one: between what the builds that StableLego labels (Liu et
# al. 2024, doi:10.1109/LRA.2024.3414281) need so that each stands or falls as it does: 2.74 to 2.97 and 1.64 to 1.80
NARROW_STUD, WIDE_STUD = 2.85, 1.7
MOST_PULL = 500  # times the weight of all: `assemble` refuses a pair of bodies that pulls 1,000 times as much
MU = 0.3  # [-] friction of bricks where none is given: low for ABS on ABS
Z_UP = np.array([(1.0, 0, 0), (0, 0, 1), (0, -1, 0)])  # turns axes of LDraw to those of the scene


class _Placed(NamedTuple):
    """A part, and the turn (3, 3) and place (3,) [LDU] of its frame in that of the model."""

    part: BrickPart
    turn: Float
    place: Float

    def studs(self) -> Float:
        """Return (n, 3) the places of its studs, or of those that a tile would have."""
        x, z = (PITCH * (np.arange(count) - (count - 1) / 2) for count in (self.part.wide, self.part.deep))
        return np.array(self.place + np.array([(a, 0, b) for a in x for b in z]) @ self.turn.T)


def read(
    source: Source,
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    stud: float | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of a model: a box for each part, named by kind and size; baseplates and ``fixed`` never move.

    A stud in the underside of another part resists being pulled out by ``stud`` [N]. For it, ``friction`` and ``mass``
    [kg] or ``density`` [kg/m³] values are taken that the notes name. If nothing is fixed, or with ``floor``, the model
    is moved onto the half space below z = 0. Submodels are placed; colours and steps do not matter; no other file is
    read. Raises SceneError for parts that are not among ``PARTS``, and for malformed lines, with their numbers.
    """
    where, parts = str(source.path), list(_Model(source).parts())
    names = unique(f"{part.kind} {part.deep}x{part.wide}" for part, _, _ in parts)
    weights, fixed_names = Weights(mass, density, names), checked_fixed(fixed, names, "part")
    bodies, pose = [], np.eye(4)
    for name, (part, turn, place) in zip(names, parts, strict=True):
        still = part.kind == "baseplate" or name in fixed_names
        pose[:3, :3], pose[:3, 3] = Z_UP @ turn @ Z_UP.T, LDU * Z_UP @ (place + turn[:, 1] * part.height / 2)
        size = LDU * np.array([PITCH * part.wide, PITCH * part.deep, part.height])
        weight = (None, None) if still else weights.of(name, last=(part.mass(), None))
        with located(f"{where}: {quoted(name)}"):
            bodies.append(Body(name, Box(size), *weight, pose=pose, fixed=still))
    most = MOST_PULL * float(np.linalg.norm(gravity)) * sum(body.mass or 0.0 for body in bodies)
    tension, notes = _tension(parts, names, stud, most)
    notes += [f"friction of parts is taken as {MU:g}"] * (friction is None)
    notes += ["masses are taken as those of hollow bricks of ABS"] * (mass is None and density is None)
    table = friction if isinstance(friction, Friction) else Friction(MU if friction is None else friction)
    table = replace(table, tension={**tension, **table.tension})
    floor = floor or not any(body.fixed for body in bodies)
    scene = scene_of(with_floor(bodies, floor, where, ""), table, gravity, source.path.stem, notes)
    return on_the_floor(scene) if floor else scene


def _tension(
    parts: Sequence[_Placed], names: Sequence[str], stud: float | None, most: float
) -> tuple[dict[tuple[str, str], float], list[str]]:
    """Return the tension [Pa] of pairs of parts, each at most ``most`` [N] in all, and notes on it."""
    from scipy.spatial import cKDTree  # only here, as it takes a tenth of a second

    wide = WIDE_STUD if stud is None else checked_number(stud, "stud", minimum=0, within=FORCE)
    narrow = NARROW_STUD if stud is None else wide
    grids = [each.studs() for each in parts]
    owners = np.repeat(np.arange(len(parts)), [len(grid) for grid in grids])
    tops = np.vstack(grids)
    undersides = tops + np.array([turn[:, 1] * part.height for part, turn, _ in parts])[owners]
    nearest = np.atleast_1d(cKDTree(undersides).query(tops, distance_upper_bound=NEAR)[1])
    met = nearest < len(tops)
    tension, turned, weaker = dict[tuple[str, str], float](), 0, 0
    for (low, high), count in Counter(zip(owners[met].tolist(), owners[nearest[met]].tolist(), strict=True)).items():
        below, above = parts[low], parts[high]
        if below.part.kind == "tile" or above.part.kind == "baseplate":
            continue
        relative = below.turn.T @ above.turn
        if relative[1, 1] < 1 - STRAIGHT or np.abs(relative[0]).max() < 1 - STRAIGHT:
            turned += 1
            continue
        pull = count * (narrow if above.part.deep == 1 else wide)
        weaker += pull > most
        tension[names[low], names[high]] = min(pull, most) / (count * (PITCH * LDU) ** 2)
    notes = [f"studs hold {len(tension)} pairs of parts, each stud {wide:g} N, {narrow:g} N below parts one stud wide"]
    notes += [f"studs hold nothing in {turned} pairs: they are upside down or turned by no quarter"] * (turned > 0)
    notes += [f"studs hold less in {weaker} pairs: {MOST_PULL} times the weight of all parts"] * (weaker > 0)
    return tension, notes


class _Model:
    """The lines of a file that place parts, by the name of the submodel in which they are."""

    def __init__(self, source: Source) -> None:
        self.where, self.placements, self.studs, self.unknown = str(source.path), 0, 0, set[str]()
        lines: list[tuple[int, list[str]]] = []
        self.files = {"": lines}
        for number, line in enumerate(source.text.splitlines(), 1):
            words = line.split(None, 14)
            if words[:2] == ["0", "FILE"]:
                name = _file_name(" ".join(words[2:]))
                if name in self.files:
                    raise SceneError(message(f"{self.where}:{number}", f"{quoted(name)} stands twice", "keep one"))
                lines = self.files[name] = []
            elif words[:2] == ["0", "NOFILE"]:
                lines = []
            elif words[:1] == ["1"]:
                lines.append((number, words))

    def parts(self) -> Iterator[_Placed]:
        """Yield the parts of the first file; raises SceneError, with all their names, if some are unknown."""
        main = next((name for name, lines in self.files.items() if name or lines), "")
        yield from self._within((main,), np.eye(3), np.zeros(3))
        if self.unknown or not self.studs:
            problem = f"has parts of unknown shape: {listed(sorted(self.unknown))}" if self.unknown else "has no parts"
            raise SceneError(message(self.where, problem, "needs plain bricks, plates, tiles and baseplates"))

    def _within(self, path: tuple[str, ...], turn: Float, place: Float) -> Iterator[_Placed]:
        """Yield the parts of the last submodel of a path, whose frame is given in that of the model."""
        for number, words in self.files[path[-1]]:
            here, self.placements = f"{self.where}:{number}", self.placements + 1
            if self.placements > MOST_PLACEMENTS or self.studs > MOST_STUDS or len(path) > DEEPEST:
                limits = f"{MOST_PLACEMENTS:,} parts, {MOST_STUDS:,} studs, {DEEPEST} submodels within each other"
                raise SceneError(message(here, "is one too many", f"the limits are {limits}"))
            if len(words) < 15:
                raise SceneError(message(here, "is too short", "needs 1, a colour, 12 numbers and a file"))
            with located(here):
                numbers = [_number(word) for word in words[2:14]]
            own = np.array(numbers[3:]).reshape(3, 3)
            left, stretch, right = np.linalg.svd(own)
            if np.abs(stretch - 1).max() > STRAIGHT:
                raise SceneError(message(here, "scales or shears what it places", "needs a turn, or a mirror"))
            its_turn, its_place, name = turn @ left @ right, place + turn @ numbers[:3], _file_name(words[14])
            if name in path:
                raise SceneError(message(here, f"{quoted(name)} is within itself", "take it out"))
            part = part_of(name)
            if name in self.files:
                yield from self._within((*path, name), its_turn, its_place)
            elif part is not None:
                self.studs += part.deep * part.wide
                mirrored = np.diag([np.sign(np.linalg.det(its_turn)), 1, 1])  # every part is its own mirror image
                yield _Placed(part, its_turn @ mirrored, its_place)
            else:
                self.unknown.add(name)


def _file_name(text: str) -> str:
    return text.strip().lower().replace("\\", "/")


def _number(word: str) -> float:
    with suppress(ValueError):
        return checked_number(float(word), "number", within=PLACE)
    raise SceneError(message("number", f"is {quoted(word)}", "needs a number, with a point for decimals"))


LDRAW = Format("LDraw model", (".ldr", ".mpd"), read=read)
