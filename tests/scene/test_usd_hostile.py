"""USD from anybody: packages stay inside, lengths lie within the file, and nothing ends the process or fills memory."""

from __future__ import annotations

import random
import struct
import zlib
from pathlib import Path

import pytest

import holdfast as hf
from holdfast.base.borders.supervisor import Limits, Supervisor
from holdfast.base.borders.worker import DONE

pxr = pytest.importorskip("pxr", reason="needs usd-core, of the extra usd")
from pxr import Usd  # noqa: E402

CASES = Path(__file__).parents[3] / "shared" / "cases" / "hostile"
API = '"PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysicsCollisionAPI"'
GROUND = 'def Plane "ground" (prepend apiSchemas = ["PhysicsCollisionAPI"])\n{ uniform token axis = "Z"\n}\n'
CUBE = f'def Cube "a" (prepend apiSchemas = [{API}])\n{{ double size = 2\n}}\n'
SCENE = f'#usda 1.0\n(\n defaultPrim = "a"\n metersPerUnit = 1\n upAxis = "Z"\n)\n{GROUND}{CUBE}'
PART = f'#usda 1.0\n(\n defaultPrim = "a"\n)\n{CUBE}'


def load(path: Path) -> hf.Scene:
    return hf.load_scene(path, friction=0.5)


def entry(name: str, content: bytes, at: int) -> bytes:
    """A file in a package: USD wants it at a multiple of 64 bytes."""
    pad = -(at + 30 + len(name)) % 64
    sizes = (zlib.crc32(content), len(content), len(content))
    header = struct.pack("<4sHHHHHIIIHH", b"PK\3\4", 10, 0, 0, 0, 0, *sizes, len(name), pad)
    return header + name.encode() + pad * b"\0" + content


def package(path: Path, **files: str) -> Path:
    """A .usdz of these files (dots as __), which zipfile and USD read."""
    content = b""
    for name, text in files.items():
        content += entry(name.replace("__", "."), text.encode(), len(content))
    path.write_bytes(content + b"PK\5\6" + 18 * b"\0")
    return path


def referring(asset: str) -> str:
    head = f'#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Z"\n)\n{GROUND}'
    return f'{head}def "b" (prepend references = @{asset}@)\n{{\n}}\n'


def test_layers_of_a_package_are_read_from_it(tmp_path: Path) -> None:
    scene = load(package(tmp_path / "s.usdz", s__usda=referring("./part.usda"), part__usda=PART))
    assert scene.body("b").mass is not None


@pytest.mark.parametrize("kind", ["absolute", "above", "current", "expression", "deep"])
def test_a_package_does_not_read_what_lies_outside(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "secret.usda").write_text(PART)
    (tmp_path / "in").mkdir()
    monkeypatch.chdir(tmp_path)  # where USD looks for a name that is no path
    secret = tmp_path / "secret.usda"
    files = {
        "absolute": {"s__usda": referring(str(secret))},
        "above": {"s__usda": referring("../secret.usda")},
        "current": {"s__usda": referring("secret.usda")},
        "expression": {
            "s__usda": referring(f"`'{secret}'`").replace("(\n", "(\n expressionVariables = { string a = 'b' }\n", 1)
        },
        "deep": {"s__usda": referring("./part.usda"), "part__usda": referring(str(secret))},
    }[kind]
    with pytest.raises(hf.errors.SceneError, match=r"s\.usdz.*(is not in the package|is no USD)"):
        load(package(tmp_path / "in" / "s.usdz", **files))


def test_a_scene_does_not_read_through_a_package_what_lies_outside(tmp_path: Path) -> None:
    (tmp_path / "secret.usda").write_text(PART)
    (tmp_path / "in").mkdir()
    package(tmp_path / "in" / "p.usdz", s__usda=referring(str(tmp_path / "secret.usda")))
    (tmp_path / "in" / "s.usda").write_text(referring("./p.usdz"))
    with pytest.raises(hf.errors.SceneError, match="is not in the package"):
        load(tmp_path / "in" / "s.usda")


def test_bytes_that_are_not_utf8_are_told(tmp_path: Path) -> None:
    (tmp_path / "s.usda").write_bytes(SCENE.encode().replace(b"double size", b"doub\xff\xfele size"))
    with pytest.raises(hf.errors.SceneError, match=r"s\.usda: (has bytes that are not UTF-8|is no USD)"):
        load(tmp_path / "s.usda")


@pytest.fixture
def crate(tmp_path: Path) -> bytes:
    (tmp_path / "s.usda").write_text(SCENE)
    Usd.Stage.Open(str(tmp_path / "s.usda")).Export(str(tmp_path / "s.usdc"))
    assert load(tmp_path / "s.usdc").body("a").mass is not None
    return (tmp_path / "s.usdc").read_bytes()


def sections(crate: bytes) -> dict[str, tuple[int, int]]:
    """Where the numbers of each section stand: its own place in the contents, and its first number."""
    contents = struct.unpack_from("<q", crate, 16)[0]
    count = struct.unpack_from("<Q", crate, contents)[0]
    places = [contents + 8 + 32 * k for k in range(count)]
    return {
        crate[at : at + 16].rstrip(b"\0").decode(): (at + 16, struct.unpack_from("<q", crate, at + 16)[0])
        for at in places
    }


@pytest.mark.parametrize("name", ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"])
@pytest.mark.parametrize("what", ["begin", "length", "values"])
def test_lengths_beyond_the_file_are_told_before_memory_is_taken(
    name: str, what: str, crate: bytes, tmp_path: Path
) -> None:
    place, inside = sections(crate)[name]
    at = {"begin": place, "length": place + 8, "values": inside}[what]
    content = bytearray(crate)
    content[at : at + 8] = struct.pack("<Q", 1 << 36)
    (tmp_path / "m.usdc").write_bytes(content)
    with pytest.raises(
        hf.errors.SceneError, match=r"m\.usdc: (states a length beyond its end|its section '\w+' states)"
    ):
        load(tmp_path / "m.usdc")


def test_a_list_that_is_longer_than_its_file_is_told(tmp_path: Path) -> None:
    """USD would take memory for as many values as the file says."""
    corners = "int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]"
    counts = "int[] faceVertexCounts = [3, 3, 3, 3]"
    points = "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]"
    mesh = f'def Mesh "m" (prepend apiSchemas = [{API}])\n{{ {corners}\n {counts}\n {points}\n}}\n'
    (tmp_path / "s.usda").write_text(SCENE + mesh)
    Usd.Stage.Open(str(tmp_path / "s.usda")).Export(str(tmp_path / "s.usdc"))
    assert load(tmp_path / "s.usdc").body("m").mass is not None
    content = (tmp_path / "s.usdc").read_bytes()
    for known, length in ((struct.pack("<Q4i", 12, 0, 2, 1, 0), 12), (struct.pack("<Q4i", 4, 3, 3, 3, 3), 4)):
        assert content.count(known) == 1
        for more in (1 << 37, 1 << 60, len(content)):
            changed = known.replace(struct.pack("<Q", length), struct.pack("<Q", more), 1)
            (tmp_path / "m.usdc").write_bytes(content.replace(known, changed))
            with pytest.raises(hf.errors.SceneError, match=rf"m\.usdc: states {more:,} values in"):
                load(tmp_path / "m.usdc")


def test_a_contents_of_too_many_sections_is_told(crate: bytes, tmp_path: Path) -> None:
    contents = struct.unpack_from("<q", crate, 16)[0]
    for at, number in ((contents, 117_178_119), (16, 1 << 40), (16, -1), (16, len(crate) - 3)):
        content = bytearray(crate)
        content[at : at + 8] = struct.pack("<q", number)
        (tmp_path / "m.usdc").write_bytes(content)
        with pytest.raises(hf.errors.SceneError, match="states a length beyond its end"):
            load(tmp_path / "m.usdc")


def test_the_case_with_one_flipped_length() -> None:
    if not CASES.exists():
        pytest.skip("needs the hostile cases, which are not here")
    with pytest.raises(hf.errors.SceneError, match=r"s\.usdc\]: states a length beyond its end: 3,749,699,808 bytes"):
        load(CASES / "case_900308.usdz")


def test_a_package_with_a_length_beyond_its_end_is_told(tmp_path: Path) -> None:
    path = package(tmp_path / "s.usdz", s__usda=SCENE)
    content = bytearray(path.read_bytes())
    for at in (18, 22, 8):  # both lengths, and that it is packed
        broken = bytearray(content)
        broken[at : at + 2] = b"\xff\xff"
        path.write_bytes(broken)
        with pytest.raises(
            hf.errors.SceneError, match=r"s\.usdz.*(states a length beyond|is packed, encrypted or without)"
        ):
            load(path)


def test_flipped_bytes_end_no_process(crate: bytes, tmp_path: Path) -> None:
    """About one in a hundred makes a layer that names what it does not hold, on which USD aborts."""
    rng = random.Random(4826)
    names = []
    for k in range(200):
        content = bytearray(crate)
        for _ in range(rng.choice((1, 1, 2, 4))):
            at = rng.randrange(len(content))
            content[at] = rng.choice((0, 255, rng.randrange(256), content[at] ^ (1 << rng.randrange(8))))
        (tmp_path / f"{k}.usdc").write_bytes(content)
        names.append(str(tmp_path / f"{k}.usdc"))
    with Supervisor(
        "test_usd_hostile:tried", limits=Limits(60, 1500), folders=[str(Path(__file__).parent)]
    ) as supervisor:
        for name in names:
            reply = supervisor.ask(name)
            assert reply.outcome == DONE, f"{name}: {reply.problem}"
            assert reply.peak < 1500


def tried(name: str, tell: object) -> str:
    try:
        load(Path(name))
    except hf.HoldfastError as error:
        return str(error)
    return ""
