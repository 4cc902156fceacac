"""Picture of a result page, light and dark.

`python docs/extensions/page_pictures.py PAGE.html NAME [HEIGHT]`.

Writes docs/_static/page_NAME_light.png and page_NAME_dark.png, 1000 px wide with 160 colours, by a headless Chromium
(`chromium` on the path, or as CHROMIUM says).
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

STATIC = Path(__file__).resolve().parents[1] / "_static"
WIDTH, HEIGHT, COLOURS = 1000, 700, 160
MARGIN = 100  # px below the picture, which the window leaves black
THEMES = {"light": [], "dark": ["--blink-settings=preferredColorScheme=0"]}
FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=20000"]


def take(page: Path, name: str, height: int = HEIGHT) -> None:
    """Write both pictures of the top of a page."""
    for theme, options in THEMES.items():
        target = STATIC / f"page_{name}_{theme}.png"
        with tempfile.TemporaryDirectory() as profile:
            size = [f"--window-size={WIDTH},{height + MARGIN}", f"--user-data-dir={profile}", f"--screenshot={target}"]
            command = [os.environ.get("CHROMIUM", "chromium"), *FLAGS, *options, *size, page.resolve().as_uri()]
            subprocess.run(command, check=True, capture_output=True, timeout=120)
        with Image.open(target) as picture:
            small = picture.convert("RGB").crop((0, 0, WIDTH, height)).quantize(COLOURS)
        small.save(target, optimize=True)


if __name__ == "__main__":
    take(Path(sys.argv[1]), sys.argv[2], *map(int, sys.argv[3:]))
