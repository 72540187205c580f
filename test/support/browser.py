"""A page in Chromium or Chrome without a screen, by its driver: its values, its requests to a
network, and its complaints."""

import contextlib
import json
import shutil
import tempfile
import time

FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--no-first-run",
         "--disable-dev-shm-usage", "--hide-scrollbars", "--force-device-scale-factor=1")
# A model of Bokeh by its type and, of figures, its title or the label below; the view of a figure.
HELP = """
window.models = type => [...Bokeh.documents[0]._all_models.values()].filter(m => m.type == type);
window.figureOf = name => models('Figure').find(
  m => (m.title && m.title.text == name) || m.left.some(a => a.axis_label == name));
window.viewOf = name => { const find = v => v.model == figureOf(name) ? v :
  (v.child_views || []).reduce((found, c) => found || find(c), null);
  return find([...Bokeh.index.roots][0]); };
window.placeOf = (name, x, y) => { const v = viewOf(name);
  const b = v.canvas_view.el.getBoundingClientRect();
  return [b.left + v.frame.x_scale.compute(x), b.top + v.frame.y_scale.compute(y)]; };
window.all = name => { const found = [], walk = n => { if (n.shadowRoot) walk(n.shadowRoot);
  if (n.classList && n.classList.contains(name)) found.push(n); n.childNodes.forEach(walk); };
  walk(document.body); return found; };
"""


class Missing(Exception):
    """There is no browser or no driver."""


@contextlib.contextmanager
def browser(width=1200, height=1000):
    """A driver of a fresh browser."""
    programs = [shutil.which("chromium") or shutil.which("google-chrome"),
                shutil.which("chromedriver")]
    if not all(programs):
        raise Missing("no chromium and chromedriver: bash .ci/setup page")
    try:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
    except ImportError as error:
        raise Missing(f"{error}: bash .ci/setup page") from None
    options = webdriver.ChromeOptions()
    options.binary_location = programs[0]
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with tempfile.TemporaryDirectory() as profile:
        for flag in (*FLAGS, f"--user-data-dir={profile}", f"--window-size={width},{height}"):
            options.add_argument(flag)
        driver = webdriver.Chrome(options=options, service=Service(programs[1]))
        try:
            # A window is never narrower than 500 pixels, a page may be.
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
            yield driver
        finally:
            driver.quit()


def open_page(driver, path):
    """Opens a page of Bokeh and waits until it is drawn."""
    driver.get("about:blank")
    for kind in ("performance", "browser"):
        driver.get_log(kind)  # of the page that a browser begins with
    driver.get(f"file://{path}")
    wait_for(driver, "return Boolean(window.Bokeh && Bokeh.documents.length && "
                     "[...Bokeh.index.roots].length && Bokeh.documents[0].is_idle)")
    driver.execute_script(HELP)


def wait_for(driver, script, *arguments, seconds=30):
    """What a script returns once it is true."""
    end = time.monotonic() + seconds
    while not (found := driver.execute_script(script, *arguments)):
        if time.monotonic() > end:
            raise TimeoutError(script)
        time.sleep(0.05)
    return found


def requests_of(driver):
    """Addresses that were asked for, but files and data of the page itself."""
    found = []
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] in ("Network.requestWillBeSent", "Network.webSocketCreated"):
            address = message["params"].get("request", message["params"])["url"]
            if not address.startswith(("file:", "data:", "blob:")):
                found.append(address)
    return found


def complaints_of(driver):
    """Messages of the console that are warnings or errors."""
    return [entry["message"] for entry in driver.get_log("browser")
            if entry["level"] in ("WARNING", "SEVERE")]


def point(driver, x, y, click=False):
    """Moves the mouse to a place of the window, in two steps."""
    for place in (x - 1, x):
        driver.execute_cdp_cmd("Input.dispatchMouseEvent", {
            "type": "mouseMoved", "x": place, "y": y})
    for kind in ("mousePressed", "mouseReleased") if click else ():
        driver.execute_cdp_cmd("Input.dispatchMouseEvent", {
            "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1})
