#!/usr/bin/env python3
"""Opens a report in a headless Chromium, wide and narrow, light and dark, and looks at it as a reader does.

Usage: scripts/report_screenshots.py [runs/compare/report.html] [--out DIR]

Checked at every size: nothing in the console but silence, no request for anything but the page, every figure has a size, nothing is
wider than the screen, and in figures no text overlaps another, is cut off, or is smaller than 10 pixels. With --out, pictures of
the whole page are written there. Exit codes: 0 all is well or no Chromium is there (which is said), 1 something is not.

Chromium is spoken to in its DevTools protocol over a pipe, which needs no library."""
import argparse
import base64
import json
import os
import pathlib
import select
import shutil
import subprocess
import sys
import tempfile
import time

BROWSERS = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"]
SIZES = {"wide": (1280, 900), "narrow": (390, 844)}
SCHEMES = ["light", "dark"]
SMALLEST_TEXT = 10.0
PATIENCE = 60.0

# A phone shows a page that is too wide from farther away, so the width is told and not asked for.
LOOK = """(width => {
  const wrong = [];
  const figures = [...document.querySelectorAll('figure svg')];
  const page = document.documentElement;
  if (figures.length === 0) wrong.push('the page has no figures');
  if (page.scrollWidth > width) wrong.push(`the page is ${page.scrollWidth} pixels wide`);
  for (const e of document.querySelectorAll('main *')) {
    if (!e.closest('.scroll, pre, svg') && e.getBoundingClientRect().right > width + 0.5)
      wrong.push(`<${e.tagName.toLowerCase()}> reaches beyond the screen: ${e.textContent.slice(0, 40)}`);
  }
  for (const svg of figures) {
    const name = svg.getAttribute('aria-label'), frame = svg.getBoundingClientRect();
    if (frame.width < 100 || frame.height < 100) wrong.push(`${name}: ${frame.width} x ${frame.height} pixels`);
    const texts = [...svg.querySelectorAll('text')].map(t => [t.textContent, t.getBoundingClientRect(), t]);
    for (const [text, box, element] of texts) {
      const size = parseFloat(getComputedStyle(element).fontSize) * frame.width / svg.viewBox.baseVal.width;
      if (size < SMALLEST) wrong.push(`${name}: "${text}" is ${size.toFixed(1)} pixels high`);
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
        wrong.push(`${name}: "${text}" is cut off`);
    }
    texts.forEach(([a, p], i) => texts.slice(i + 1).forEach(([b, q]) => {
      const across = Math.min(p.right, q.right) - Math.max(p.left, q.left);
      const down = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
      // Boxes of text have room above and below the letters.
      if (across > 1 && down > 0.3 * Math.min(p.height, q.height)) wrong.push(`${name}: "${a}" and "${b}" overlap`);
    }));
  }
  return JSON.stringify({wrong, height: Math.ceil(page.getBoundingClientRect().height), figures: figures.length});
})(WIDTH)""".replace("SMALLEST", str(SMALLEST_TEXT))


class Browser:
    """A headless Chromium at the other end of a pipe."""

    def __init__(self, program, profile):
        to_browser, self.output = os.pipe()
        self.input, from_browser = os.pipe()

        def connect():
            # Chromium reads commands from descriptor 3 and answers on 4.
            reading, writing = os.dup(to_browser), os.dup(from_browser)
            os.dup2(reading, 3)
            os.dup2(writing, 4)

        command = [program, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
                   "--disable-dev-shm-usage", "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"]
        self.process = subprocess.Popen(command, preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.number, self.rest, self.events = 0, b"", []

    def receive(self, deadline):
        """The next message."""
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.input], [], [], max(0.0, deadline - time.monotonic()))
            part = os.read(self.input, 1 << 16) if ready else b""
            if not part:
                raise RuntimeError("Chromium does not answer")
            self.rest += part
        message, _, self.rest = self.rest.partition(b"\0")
        return json.loads(message)

    def call(self, method, session=None, **parameters):
        """The result of a command; events on the way are kept."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.output, json.dumps(message).encode() + b"\0")
        deadline = time.monotonic() + PATIENCE
        while True:
            answer = self.receive(deadline)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def open(self, session, url):
        """Goes to `url` and waits until it is loaded."""
        self.call("Page.setLifecycleEventsEnabled", session, enabled=True)
        self.events.clear()
        answer = self.call("Page.navigate", session, url=url)
        if "errorText" in answer:
            raise RuntimeError(f"{url}: {answer['errorText']}")
        deadline = time.monotonic() + PATIENCE

        def is_loaded(event):
            told = event.get("params", {})
            return told.get("name") == "load" and told.get("loaderId") == answer["loaderId"]

        while not any(map(is_loaded, self.events)):
            self.events.append(self.receive(deadline))

    def close(self):
        try:
            self.call("Browser.close")
            self.process.wait(10)
        except (RuntimeError, OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()


def complaints(events, url):
    """What a reader would find in the console, and requests for anything but the page."""
    for event in events:
        method, told = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            yield f"exception: {told['exceptionDetails']['text']}"
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
            yield f"console: {told['args']}"
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            yield f"log: {told['entry']['text']}"
        elif method == "Network.requestWillBeSent" and told["request"]["url"] != url:
            address = told["request"]["url"]
            if not address.startswith("data:"):
                yield f"the page asks for {address}"


def look(browser, page, size, scheme, picture):
    """What is wrong with `page` at one size in one colour scheme."""
    url, (width, height) = page.resolve().as_uri(), size
    target = browser.call("Target.createTarget", url="about:blank")["targetId"]
    session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
    for domain in ["Page", "Runtime", "Log", "Network"]:
        browser.call(f"{domain}.enable", session)
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.call("Emulation.setDeviceMetricsOverride", session, **screen)
    browser.call("Emulation.setEmulatedMedia", session, features=[{"name": "prefers-color-scheme", "value": scheme}])
    browser.open(session, url)
    found = json.loads(browser.call("Runtime.evaluate", session, expression=LOOK.replace("WIDTH", str(width)))["result"]["value"])
    wrong = [*complaints(browser.events, url), *found["wrong"]]
    if picture:
        clip = {"x": 0, "y": 0, "width": width, "height": found["height"], "scale": 1}
        shot = browser.call("Page.captureScreenshot", session, format="png", captureBeyondViewport=True, clip=clip)
        picture.write_bytes(base64.b64decode(shot["data"]))
    browser.call("Target.closeTarget", targetId=target)
    return wrong, found["figures"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("page", type=pathlib.Path, nargs="?", default=pathlib.Path("runs/compare/report.html"))
    parser.add_argument("--out", type=pathlib.Path, help="folder for pictures")
    arguments = parser.parse_args()
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        print(f"skipped: no Chromium is installed (none of {', '.join(BROWSERS)})")
        return 0
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
    failed = False
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile)
        try:
            for size, pixels in SIZES.items():
                for scheme in SCHEMES:
                    picture = arguments.out and arguments.out / f"{size}-{scheme}.png"
                    wrong, figures = look(browser, arguments.page, pixels, scheme, picture)
                    failed |= bool(wrong)
                    verdict = "; ".join(wrong) if wrong else f"{figures} figures, nothing wrong"
                    print(f"{size} {scheme}: {verdict}")
        finally:
            browser.close()
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
