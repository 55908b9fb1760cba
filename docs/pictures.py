"""Draw what README and documentation show: python docs/pictures.py; needs chromium and node, as the tests of the page do."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

HERE = Path(__file__).parent
PICTURES, BROWSER = HERE / "pictures", HERE.parent / "page"
HOTLAP = [sys.executable, "-m", "hotlap"]
TUNED = ("tune", "qualifier-20", "--first-guess", "default", "--seed", "0")
SCREEN = 1440, 920  # pixels of the page that are shown


def draw(folder: Path) -> None:
    """A study, its film, and its page on a desk and on a phone."""
    study = folder / "study"
    subprocess.run([*HOTLAP, *TUNED, "--out", str(study)], check=True)
    subprocess.run([*HOTLAP, "report", str(study), "--video", str(PICTURES / "lap.gif")], check=True)
    subprocess.run(["node", "browser/study.mjs", str(study / "report.html"), str(folder / "shots")], cwd=BROWSER, check=True)
    with Image.open(folder / "shots" / "desktop.png") as picture:
        picture.crop((0, 0, *SCREEN)).save(PICTURES / "report.png", optimize=True)
    with Image.open(folder / "shots" / "phone.png") as picture:
        picture.crop((0, 0, picture.width, 2 * picture.width)).save(PICTURES / "report-phone.png", optimize=True)


if __name__ == "__main__":
    PICTURES.mkdir(exist_ok=True)
    with TemporaryDirectory() as name:
        draw(Path(name))
