"""The parts of LDraw that are boxes with studs: their sizes by number, and their masses."""

from __future__ import annotations

import re
from typing import NamedTuple

# Parts by kind and height [LDU]: number, and studs along z and x, as "Brick 2 x 4" is 3001. The origin is in the middle
# of the top, y points down. Letters behind a number, and patterns, do not change the shape.
TABLE = {
    ("brick", 24): "3005:1x1 3004:1x2 3622:1x3 3010:1x4 3009:1x6 3008:1x8 6111:1x10 6112:1x12 2465:1x16 3003:2x2 "
    "3002:2x3 3001:2x4 2456:2x6 44237:2x6 3007:2x8 3006:2x10 2356:4x6 6212:4x10 4202:4x12 4201:8x8 4204:8x16 733:10x10",
    ("brick", 48): "3245:1x2 39266:1x5",
    ("brick", 72): "14716:1x1 22886:1x2 49311:1x4 30145:2x2 30144:2x4 6213:2x6",
    ("brick", 120): "2454:1x2 3755:1x3 3754:1x6",
    ("plate", 8): "3024:1x1 3023:1x2 3623:1x3 3710:1x4 78329:1x5 3666:1x6 3460:1x8 4477:1x10 60479:1x12 3022:2x2 "
    "3021:2x3 3020:2x4 3795:2x6 3034:2x8 3832:2x10 2445:2x12 91988:2x14 4282:2x16 11212:3x3 3031:4x4 3032:4x6 3035:4x8 "
    "3030:4x10 3029:4x12 3958:6x6 3036:6x8 3033:6x10 3028:6x12 3456:6x14 3027:6x16 3026:6x24 41539:8x8 92438:8x16 "
    "91405:16x16",
    (
        "tile",
        8,
    ): "3070:1x1 3069:1x2 63864:1x3 2431:1x4 6636:1x6 4162:1x8 3068:2x2 26603:2x3 87079:2x4 69729:2x6 1751:4x4",
    ("baseplate", 4): "3865:8x16 3497:8x24 3867:16x16 3334:16x24 3857:16x32 3645:24x40 3811:32x32 4186:48x48",
}
ABS = 1.05e-6  # [kg/mm³]
# Of a hollow brick: its top and its walls if one stud wide or wider [mm], a stud [mm³], and the cross sections of what
# is below it between two studs and between four [mm²]. Masses by them are within 4 % of eight that StableLego lists
TOP, NARROW_WALL, WIDE_WALL, STUD, PIN, TUBE = 1.0, 1.5, 1.2, 25.0, 8.0, 15.2


class BrickPart(NamedTuple):
    """A part by its kind, its number of studs along z and x, and its height [LDU]."""

    kind: str
    deep: int
    wide: int
    height: int

    def mass(self) -> float:
        """Return the mass [kg] of its top, its walls, its studs and the tubes or pins below."""
        x, z, inside = 8 * self.wide - 0.2, 8 * self.deep - 0.2, 0.4 * self.height - TOP
        wall, below = NARROW_WALL, PIN * (self.wide - 1)
        if self.deep > 1:
            wall, below = WIDE_WALL, TUBE * (self.wide - 1) * (self.deep - 1)
        studs = 0 if self.kind == "tile" else STUD * self.wide * self.deep
        return ABS * (TOP * x * z + (2 * wall * (x + z - 2 * wall) + below) * inside + studs)


PARTS = {
    number: BrickPart(kind, int(deep), int(wide), height)
    for (kind, height), text in TABLE.items()
    for number, deep, wide in re.findall(r"(\d+):(\d+)x(\d+)", text)
}


def part_of(name: str) -> BrickPart | None:
    """Return the part of a file such as "3001.dat"; None if its shape is not known."""
    number = re.fullmatch(r"(\d+)[a-z]?(?:p\w*)?\.dat", name)
    return PARTS.get(number[1]) if number else None
