"""Pictures of pages (`--html`) as a browser shows them, to be looked at: on a phone and on a desk,
light and dark. What a machine can check of them is in test/regression/test_browser.py.

    python tools/look_at_pages.py EXE [SCENE ...]    # writes build/pages/NAME-WIDTH-MODE.png
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
from browser import browser
SCENES = ("data/examples/thesis.scene", "data/examples/position_56.scene",
          "data/examples/effects/ten_minutes.scene", "data/examples/effects/cycle.scene",
          "data/examples/summits/press.scene", "data/examples/summits/press_samples.scene")
WIDTHS = {400: 3000, 1400: 3000}
# What Chromium calls its colour schemes.
MODES = {"light": 1, "dark": 0}


def main():
    folder = ROOT / "build/pages"
    folder.mkdir(parents=True, exist_ok=True)
    for scene in sys.argv[2:] or SCENES:
        page = folder / f"{Path(scene).stem}.html"
        subprocess.run([sys.argv[1], "solve", scene, "--quiet", "--html", page], cwd=ROOT,
                       check=True, stderr=subprocess.DEVNULL)
        for width, height in WIDTHS.items():
            for mode, number in MODES.items():
                picture = page.with_name(f"{page.stem}-{width}-{mode}.png")
                subprocess.run([browser(), "--headless", "--no-sandbox", "--disable-gpu",
                                "--disable-background-networking", "--hide-scrollbars",
                                f"--blink-settings=preferredColorScheme={number}",
                                f"--window-size={width},{height}", f"--screenshot={picture}",
                                page.as_uri()], check=True, timeout=100, capture_output=True)
                print(picture.relative_to(ROOT))


if __name__ == "__main__":
    main()
