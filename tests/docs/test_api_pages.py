"""Every public name has a line in the list and a page with its signature, and most have an example that runs."""

from __future__ import annotations

import doctest
import importlib.util
import inspect
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

import holdfast as hf

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
MODULES = ("holdfast", "holdfast.sets", "holdfast.answers", "holdfast.errors", "holdfast.readers", "holdfast.plugins")
STUBS = {name: ROOT / "src" / "holdfast" / f"{name.partition('.')[2] or '__init__'}.pyi" for name in MODULES}
NAMES = [
    f"{module}.{name}"
    for module, stub in STUBS.items()
    for name in re.findall(r"^from holdfast\.\S+ import \w+ as (\w+)", stub.read_text(encoding="utf-8"), re.MULTILINE)
]
WITH_DOCTEST = [name for name in NAMES if name.count(".") == 1 and ">>>" in str(getattr(hf, name[9:]).__doc__)]
WITHOUT = 45  # the most public names without an example: fields of answers, errors, what engines are told


@pytest.fixture(scope="module")
def api() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "docs" / "_site"))
        patch.syspath_prepend(str(ROOT / "tools"))
        import api_pages

        yield api_pages
        sys.modules.pop("api_pages")


def test_every_public_name_has_one_line(api: Any) -> None:
    rows = re.findall(r"^\| \[`(\w+)`\]\(/files/api/([\w.]+)\.rst\) \| (.+) \|$", api.with_lines(PAGE), re.MULTILINE)
    assert sorted(page for _, page, _ in rows) == sorted(NAMES)
    for name, page, line in rows:
        assert page.endswith(f".{name}")
        assert line.endswith("."), f"{page}: {line}"


def test_every_public_name_has_a_page_that_is_in_the_contents(api: Any) -> None:
    contents = api.with_lines(PAGE).partition("```{toctree}")[2].splitlines()
    for name in NAMES:
        assert f"/files/api/{name}" in contents
        page = api.page_of(name)
        assert page.startswith(f"{name.rpartition('.')[2]}\n==")
        assert re.search(rf"^\.\. auto(class|function|data):: {re.escape(name)}$", page, re.MULTILINE)


def test_parameters_have_their_units(api: Any) -> None:
    assert "   * - ``points``\n        - m\n" in api.page_of("holdfast.robustness")
    assert "   * - ``acceleration``\n        - m/s²\n" in api.page_of("holdfast.load_factor")


def test_most_names_have_an_example_and_all_of_the_front_page(api: Any) -> None:
    shown = {*api.examples(), *WITH_DOCTEST}
    assert [name for name in NAMES if name.count(".") == 1 and name not in shown] == []
    assert len({*NAMES} - shown) <= WITHOUT, sorted({*NAMES} - shown)


def test_a_page_leads_to_pages_that_name_it(api: Any) -> None:
    assert "howto/transport" in [page for page, _ in api.mentions("holdfast.sets.inertial_loads")]
    assert ":doc:`Drive a base without losing what stands on it </howto/transport>`" in api.page_of(
        "holdfast.sets.inertial_loads"
    )


def test_an_example_is_what_its_page_shows_and_lacks_no_name(api: Any, tmp_path: Path) -> None:
    """The page runs whole in test_snippets.py; here it is cut, and ruff finds what is missing."""
    for name, example in api.examples().items():
        said = (ROOT / "docs" / f"{example.page}.md").read_text(encoding="utf-8")
        assert f"# {example.heading}\n" in said.replace("`", "")
        assert all(line in said for line in example.code.splitlines()), name
        (tmp_path / f"{name}.py").write_text(example.code, encoding="utf-8")
        if name not in WITH_DOCTEST:
            assert textwrap.indent(f"{example.code}\n", "      ") in api.page_of(name)
    undefined = ["check", "--isolated", "--select", "F821", str(tmp_path)]
    found = subprocess.run([sys.executable, "-m", "ruff", *undefined], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout


def test_statements_of_earlier_snippets_come_along_if_they_are_needed(api: Any) -> None:
    code = api.examples()["holdfast.sets.safe_time_scale"].code
    assert code.startswith("import numpy as np\nimport holdfast as hf\n\nload = ")
    assert "limits = " not in code
    values: dict[str, Any] = {}
    exec(compile(code, "example", "exec"), values)
    assert values["scale"] == pytest.approx((0.9 * 5.78 / 4.0) ** 0.5, rel=1e-3), "5.78 m/s² along x, as the page says"


@pytest.mark.parametrize("name", WITH_DOCTEST)
def test_examples_in_docstrings_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    value = getattr(hf, name[9:])
    if "import trimesh" in value.__doc__ and importlib.util.find_spec("trimesh") is None:
        pytest.skip("needs trimesh")
    monkeypatch.chdir(tmp_path)
    found = doctest.DocTestParser().get_doctest(inspect.getdoc(value) or "", {"hf": hf}, name, None, None)
    assert doctest.DocTestRunner().run(found).failed == 0
