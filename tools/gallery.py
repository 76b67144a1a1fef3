"""Run the code of the gallery of figures, and draw what it makes: docs/gallery.md → docs/pictures/gallery-*.

    python tools/gallery.py                     # all of them
    python tools/gallery.py --check             # status 1 where one can no longer be made or differs clearly

The blocks run in their order in a folder that holds ``sample_data`` alone. What stands in ``figure``, or in
``drawing``, after a block is the picture that follows it. Figures are drawn by plotly's own program in Chromium.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import plotly.offline
import plotly.utils
from diagrams import on_white, same
from PIL import Image
from playwright.sync_api import Page, sync_playwright
from screenshots import CHROMIUM, LARGEST, PICTURES, difference, written

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "gallery.md"
WIDTH, HEIGHT = 860, 380  # [px]
BLOCK = re.compile(r"```python\n(?P<code>.*?)```(?:\s*!\[[^\]]*\]\(pictures/(?P<picture>[\w.-]+)\))?", re.DOTALL)
_PLACE = '<div id="around" style="padding:10px;background:white"><div id="figure"></div></div>'
_DRAW = """async ([figure, height]) => {
    const place = document.getElementById("figure")
    await Plotly.newPlot(place, figure.data, {...figure.layout, paper_bgcolor: "white", plot_bgcolor: "white", height},
        {staticPlot: true})
}"""


def made() -> Iterator[tuple[str, Any]]:
    """Run the page's code; yield the name of each picture and the figure or the drawing that it shows."""
    space: dict[str, Any] = {}
    for block in BLOCK.finditer(PAGE.read_text(encoding="utf-8")):
        space.pop("figure", None)
        space.pop("drawing", None)
        exec(compile(block["code"], str(PAGE), "exec"), space)
        if block["picture"]:
            yield block["picture"], space["drawing"] if block["picture"].endswith(".svg") else space["figure"]


@contextmanager
def sample_folder() -> Iterator[None]:
    """Work in a folder that holds the sample data alone."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "sample_data", Path(folder) / "sample_data")
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def drawn(page: Page, figure: Any) -> bytes:
    """Return a figure as a small PNG."""
    spec = json.loads(json.dumps(figure.checked().to_plotly_json(), cls=plotly.utils.PlotlyJSONEncoder))
    height = spec["layout"].get("height") or HEIGHT
    page.evaluate("height => document.getElementById('figure').style.height = `${height}px`", height)
    page.evaluate(_DRAW, [spec, height])
    return written(Image.open(io.BytesIO(page.locator("#around").screenshot())).convert("RGB"))


def main() -> int:
    """Draw the gallery's pictures, or check those that are kept."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="compare with those that are kept, and write none")
    options = parser.parse_args()
    faults = {}
    with sample_folder(), sync_playwright() as driver:
        executable = next((path for path in CHROMIUM if Path(path).is_file()), shutil.which("chromium"))
        browser = driver.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDTH, "height": 900})
        page.set_content(f'<!DOCTYPE html><body style="margin:0;font-family:sans-serif">{_PLACE}</body>')
        page.add_script_tag(content=plotly.offline.get_plotlyjs())
        for name, result in made():
            content = on_white(result).encode() if name.endswith(".svg") else drawn(page, result)
            kept = PICTURES / name
            if len(content) > LARGEST:
                faults[name] = f"it has {len(content)} bytes, where {LARGEST} are allowed"
            if not options.check:
                kept.write_bytes(content)
                print(name, f"{len(content) / 1000:.0f} kB")
            elif said := _apart(content, kept):
                faults[name] = said
        browser.close()
    for name, said in faults.items():
        print(f"{name}: {said}", file=sys.stderr)
    return 1 if faults else 0


def _apart(content: bytes, kept: Path) -> str:
    """Say in which way a picture differs clearly from the one that is kept."""
    if not kept.is_file():
        return "it is not kept"
    if kept.suffix == ".svg":
        return "" if same(content.decode(), kept.read_text(encoding="utf-8")) else "it is not what is drawn today"
    with Image.open(io.BytesIO(content)) as new, Image.open(kept) as old:
        return difference(new, old)


if __name__ == "__main__":
    sys.exit(main())
