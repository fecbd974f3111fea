"""The live view and the page of a map in a browser without a screen; skipped where playwright or Chromium are missing.

pip install 'holdfast-robotics[live]' playwright     # and a Chromium of the system
pytest -m slow tests/live/test_in_browser.py
"""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from PIL import Image

import holdfast as hf
from bench.scenes.real_pallets import pallet, pallets
from holdfast.drawing import colours
from holdfast.drawing.colours import Kind
from holdfast.engines.verdict import Status
from holdfast.geometry.triangles import first_hit

pytestmark = pytest.mark.slow

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
SOFTWARE = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SOFTWARE += ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]
SIZE = (1400, 850)
NOTICE = "button[aria-label=Close], .mantine-Notification-closeButton"  # of viser's, that there is no graphics card
KINDS = {Status.INFINITE: Kind.ENDLESS, Status.UNSTABLE: Kind.FALLS, Status.UNDECIDED: Kind.UNDECIDED}
PATIENCE = 60_000  # [ms]


@pytest.fixture
def page() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright, to drive a browser")
    if CHROMIUM is None:
        pytest.skip("needs Chromium, which is not installed")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE)
        one = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        one.hosts, one.said = set(), []
        one.on("request", lambda request: one.hosts.add(urlsplit(request.url).hostname))
        one.on("websocket", lambda socket: one.hosts.add(urlsplit(socket.url).hostname))
        one.on("pageerror", lambda error: one.said.append(str(error)))
        yield one
        browser.close()


@pytest.fixture
def found() -> hf.answers.RobustnessMap:
    return hf.robustness_map(hf.shipped_scene("tabletop"), engine="graph", spacing=0.02)


def test_colours_are_those_of_the_legend_and_nothing_is_asked_of_others(
    page: Any, found: hf.answers.RobustnessMap
) -> None:
    pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")
    with hf.view(found, engine="graph", browser=False) as live:
        page.goto(live.url)
        page.get_by_text("largest push [N]").wait_for(timeout=PATIENCE)
        page.wait_for_timeout(4000)  # the picture follows the words
        check_colours(page, live)
        assert page.hosts - {None} == {"127.0.0.1"}, "blobs have no host"
        assert page.said == []


def check_colours(page: Any, live: hf.answers.LiveView) -> None:
    """Compare at least 20 points of the picture with the scale of the legend: within 2 %."""
    if page.locator(NOTICE).count():
        page.locator(NOTICE).first.click()
        page.wait_for_timeout(1000)
    (client,) = live._window.server.get_clients().values()
    for _ in range(20):  # until no portion of the map came in between
        found = live._window.model.map
        page.wait_for_timeout(1500)
        pixels = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")) / 255.0
        if live._window.model.map is found:
            break
    assert found is not None
    kinds = [KINDS.get(status, Kind.FORCE) for status in found.status]
    expected = colours.colours(colours.scale_of(found.force), found.force, np.array(kinds))
    shown = seen(found, pixels, client.camera)
    assert len(shown) >= 20
    for number, colour in shown[:20]:
        assert np.abs(colour - expected[number]).max() < 0.02


def seen(found: hf.answers.RobustnessMap, pixels: np.ndarray, camera: Any) -> list[tuple[int, np.ndarray]]:
    """The points of a map that are seen away from edges and from borders of cells, with their colours."""
    eye = np.array(camera.position)
    surfaces = [body.surface_world for body in found.assembly.bodies]
    starts = np.cumsum([0, *(len(one.vertices) for one in surfaces)])
    vertices = np.concatenate([one.vertices for one in surfaces])
    faces = np.concatenate([one.faces + start for one, start in zip(surfaces, starts, strict=False)])
    shown = []
    for number in np.random.default_rng(5).permutation(len(found.force)):
        x, y = on_screen(camera, found.points[number])
        hit = first_hit(vertices, faces, eye, found.points[number] - eye)
        if not (20 < x < 980 and 20 < y < SIZE[1] - 20) or hit is None or abs(hit.distance - 1) > 1e-3:
            continue
        block = pixels[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].reshape(-1, 3)
        if np.ptp(block, axis=0).max() < 0.02:
            shown.append((int(number), block[4]))
    return shown


def on_screen(camera: Any, point: np.ndarray) -> tuple[float, float]:
    """Where a point (3,) [m] of the world is seen [px]; the picture is left of the panel."""
    turned = pytest.importorskip("viser.transforms").SO3(np.array(camera.wxyz)).as_matrix()
    wide, high = camera.image_width, camera.image_height
    focal = high / 2 / np.tan(camera.fov / 2)
    right, down, away = (point - np.array(camera.position)) @ turned
    return wide / 2 + focal * right / away, high / 2 + focal * down / away


def test_a_body_is_dragged_by_the_arrows_and_taken_back(page: Any) -> None:
    """The first half of the slab's arrow along x is grabbed and drawn along: it moves along x alone."""
    pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")
    with hf.view(hf.shipped_scene("table"), engine="limit", spacing=0.05, browser=False) as live:
        window = live._window
        page.goto(live.url)
        page.get_by_text("largest push [N]").wait_for(timeout=PATIENCE)
        page.get_by_role("tab", name="Edit").click()
        page.get_by_label("drag it in the picture").click()
        while window.gizmo._node is None or not window.gizmo._node.visible:
            page.wait_for_timeout(200)
        page.wait_for_timeout(3000)
        name, given = window.controls.body, window.model.assembly
        (client,) = window.server.get_clients().values()
        home, along = np.array(window.gizmo._node.position), np.array([window.gizmo._node.scale, 0.0, 0.0])
        start, end = (np.array(on_screen(client.camera, home + share * along)) for share in (0.75, 0.95))
        page.mouse.move(*start)
        page.wait_for_timeout(1000)
        page.mouse.down()
        for share in np.linspace(0.0, 1.0, 6):
            page.mouse.move(*(start + share * (end - start)))
            page.wait_for_timeout(400)
        assert name in window.gizmo.held
        assert window.model.assembly is given, "nothing is asked before the body is let go"
        page.mouse.up()
        while window.model.assembly is given or window.model.verdict is None:
            page.wait_for_timeout(200)
        moved = window.model.assembly.scene.body(name).pose - given.scene.body(name).pose
        assert 0.1 * along[0] < moved[0, 3] < 0.3 * along[0]
        np.testing.assert_allclose(np.delete(moved.ravel(), 3), 0.0, atol=1e-12)
        page.get_by_text("undo").click()
        while window.model.assembly is not given:
            page.wait_for_timeout(200)
        assert page.said == []


def test_a_click_is_answered_and_the_motion_is_played(page: Any) -> None:
    pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")
    with hf.view(hf.shipped_scene("table"), engine="graph", spacing=0.02, browser=False) as live:
        page.goto(live.url)
        page.get_by_text("largest push [N]").wait_for(timeout=PATIENCE)
        page.wait_for_timeout(4000)
        for x in range(400, 900, 100):  # the table is somewhere in the middle
            page.mouse.click(x, 420)
            page.wait_for_timeout(1500)
            if page.get_by_text("R =").count():
                break
        assert page.get_by_text("R =").count()
        before = page.screenshot()
        page.get_by_role("checkbox").first.click()
        page.wait_for_timeout(900)
        assert page.screenshot() != before
        moving = live._window._frames[live._window.model.mechanism.moving[0]]  # type: ignore[union-attr]
        page.get_by_role("checkbox").first.click()
        page.wait_for_timeout(500)
        assert tuple(moving.position) == (0.0, 0.0, 0.0)


def test_on_a_pallet_all_boxes_have_colours_soon_and_a_click_goes_first(page: Any) -> None:
    pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")
    boxes = next((boxes for boxes in pallets() if len(boxes) == 40), None)
    if boxes is None:
        pytest.skip("needs the pallets beside the checkout")
    with hf.view(pallet(boxes), browser=False) as live:
        model = live._window.model
        page.goto(live.url)
        page.get_by_text("engine compliant (contacts at rest)").wait_for(timeout=PATIENCE)
        while model.map is None or len(model.map.cells) < 40:
            page.wait_for_timeout(500)
        check_colours(page, live)
        known = model.portions
        page.mouse.click(520, 420)
        page.get_by_text("R =").wait_for(timeout=PATIENCE)
        assert not model.mapped, "the click did not wait for the map"
        assert model.portions is known, "and the map goes on"
        assert page.said == []


def test_the_page_of_a_map_tells_the_push_under_the_pointer(
    page: Any, found: hf.answers.RobustnessMap, tmp_path: Path
) -> None:
    found.save_html(tmp_path / "map.html")
    page.goto((tmp_path / "map.html").as_uri())
    page.wait_for_timeout(3000)
    told = set()
    for x in range(450, 1300, 85):
        for y in range(200, 800, 75):
            page.mouse.move(x, y)
            page.wait_for_timeout(60)
            told.add(page.locator("#hover").inner_text().split("\n")[0])
    assert len({text.split(" at ")[0] for text in told if " at " in text}) >= 3, "bodies"
    assert "largest push [N]" in page.locator("#scale").inner_text()
    assert page.locator("ol li").count() == len(found.weakest_of_each_body()[:5])
    assert page.hosts <= {None, ""}
    assert page.said == []
