"""Pages in headless Chromium: each in frames of several widths, measured by a script beside them.
So a page is shown as it is, under its own content security policy, and one start of the browser
measures all pages."""

import html
import json
import re
import shutil
import subprocess

NAMES = ("chromium", "chromium-browser", "google-chrome")
# Lengths of the same edge differ by rounding, pixels.
ROUNDING = 0.6
# Least height of letters in figures, pixels.
LEAST_LETTER = 9
MEASURE = """
const rounding = %(rounding)s, leastLetter = %(letter)s;
function textOf(e) { return e.tagName + " '" + e.textContent.slice(0, 60) + "'"; }
function measure(doc, width) {
  const found = [];
  for (const part of doc.querySelectorAll("details")) part.open = true;
  for (const note of doc.querySelectorAll(".note")) note.style.display = "block";
  if (doc.documentElement.scrollWidth > width)
    found.push("the page is " + doc.documentElement.scrollWidth + " wide");
  for (const e of doc.body.querySelectorAll("*")) {
    const box = e.getBoundingClientRect(), svg = e.ownerSVGElement;
    const room = svg ? svg.getBoundingClientRect() : null;
    if (!svg && !e.parentElement.closest(".scroll, pre") &&
        (box.left < -rounding || box.right > width + rounding))
      found.push(textOf(e) + " from " + box.left + " to " + box.right);
    if (svg && box.width + box.height > 0 &&
        (box.left < room.left - rounding || box.right > room.right + rounding ||
         box.top < room.top - rounding || box.bottom > room.bottom + rounding))
      found.push(textOf(e) + " is cut off by its figure");
    const style = doc.defaultView.getComputedStyle(e);
    if (!svg && e.tagName !== "svg" && ["hidden", "clip"].includes(style.overflowX) &&
        e.scrollWidth > e.clientWidth) found.push(textOf(e) + " is cut off");
    if (e.tagName === "TABLE" && !(e.closest(".scroll") &&
        doc.defaultView.getComputedStyle(e.closest(".scroll")).overflowX === "auto"))
      found.push(textOf(e) + " does not scroll");
  }
  for (const svg of doc.querySelectorAll("svg")) {
    const texts = [...svg.querySelectorAll("text:not(.note)")].map(
      e => [e, e.getBoundingClientRect()]);
    for (const [e, a] of texts) {
      if (13 * svg.getBoundingClientRect().width / svg.viewBox.baseVal.width < leastLetter)
        found.push(textOf(e) + " is too small to read");
      for (const [other, b] of texts)
        if (e !== other && Math.min(a.right, b.right) - Math.max(a.left, b.left) > rounding &&
            Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 4)
          found.push(textOf(e) + " lies over " + textOf(other));
    }
  }
  return found;
}
window.onload = () => {
  const report = {};
  for (const frame of document.querySelectorAll("iframe")) {
    report[frame.name] = measure(frame.contentDocument, frame.clientWidth);
  }
  const figures = [...document.querySelectorAll("iframe")].map(
    f => [f.name, f.contentDocument.querySelectorAll("svg").length]);
  for (const frame of [...document.querySelectorAll("iframe")]) frame.remove();
  document.getElementById("report").textContent = JSON.stringify(
    {found: report, figures: Object.fromEntries(figures)});
};
"""


def browser():
    """The command of a Chromium of this machine."""
    found = [path for path in map(shutil.which, NAMES) if path]
    assert found, "no Chromium: bash .ci/setup test installs it"
    return found[0]


def measured(pages, folder, widths=(400, 1400)):
    """What is wrong with each page at each width, {(name, width): [sentence, ...]}; the number of
    its figures, by the same keys; and the errors of the console."""
    frames = "".join(
        f'<iframe name="{html.escape(name)} {width}" style="width:{width}px;height:900px;border:0" '
        f'srcdoc="{html.escape(text)}"></iframe>' for name, text in pages.items()
        for width in widths)
    host = folder / "pages.html"
    script = MEASURE % {"rounding": ROUNDING, "letter": LEAST_LETTER}
    host.write_text(f'<!DOCTYPE html><html><head><meta charset="utf-8"/></head><body>'
                    f'<pre id="report"></pre><script>{script}</script>{frames}</body></html>')
    done = subprocess.run(
        [browser(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         "--disable-background-networking", f"--user-data-dir={folder / 'profile'}",
         "--enable-logging=stderr", "--window-size=1500,1000", "--virtual-time-budget=20000",
         "--dump-dom", host.as_uri()], capture_output=True, text=True, timeout=300)
    report = re.search(r'<pre id="report">(.*?)</pre>', done.stdout, re.DOTALL)
    assert report and report[1], done.stderr
    answer = json.loads(html.unescape(report[1]))
    keys = {f"{name} {width}": (name, width) for name in pages for width in widths}
    assert set(answer["found"]) == set(keys)
    return ({keys[key]: found for key, found in answer["found"].items()},
            {keys[key]: number for key, number in answer["figures"].items()},
            [line for line in done.stderr.splitlines() if ":CONSOLE" in line])
