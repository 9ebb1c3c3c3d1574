"""A headless Chromium, driven over its DevTools protocol by pipe: Python's standard library, no port, no driver.

    with Browser() as browser:
        page = browser.open("http://127.0.0.1:7080/", width=1280, height=800)
        page.click("a[href='#/workers']")
        page.wait("document.title.startsWith('Workers')")
"""

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

PROGRAMS = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome")


def find_chromium():
    """The program of PARALLAX_CHROMIUM or of the path, or None."""
    told = os.environ.get("PARALLAX_CHROMIUM")
    return told if told else next((found for found in map(shutil.which, PROGRAMS) if found), None)


class PageError(AssertionError):
    pass


class Browser:
    def __init__(self, program=None, timeout_s=60, trust_any_certificate=False):
        self.program = program or find_chromium()
        self.trust = ["--ignore-certificate-errors"] if trust_any_certificate else []
        self.timeout_s = timeout_s
        self.number = 0
        self.buffer = b""
        self.events = []

    def __enter__(self):
        self.profile = tempfile.mkdtemp(prefix="parallax-browser-")
        to_read, self.to_write = os.pipe()
        self.to_read, to_write = os.pipe()
        command = [self.program, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                   "--hide-scrollbars", "--disable-background-networking", "--disable-component-update", "--disable-sync",
                   "--remote-debugging-pipe", *self.trust, f"--user-data-dir={self.profile}", "about:blank"]

        def give_pipes():  # DevTools reads descriptor 3 and writes descriptor 4.
            os.setsid()
            spare_read, spare_write = os.dup(to_read), os.dup(to_write)
            os.dup2(spare_read, 3)
            os.dup2(spare_write, 4)

        self.process = subprocess.Popen(command, preexec_fn=give_pipes, close_fds=False, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        return self

    def __exit__(self, *_):
        try:
            os.killpg(self.process.pid, signal.SIGKILL)  # Its own session: it and its children.
        except ProcessLookupError:
            pass
        self.process.wait()
        os.close(self.to_write)
        os.close(self.to_read)
        shutil.rmtree(self.profile, ignore_errors=True)

    def call(self, method, params=None, session=None):
        self.number += 1
        number = self.number
        message = {"id": number, "method": method, "params": params or {}}
        if session:
            message["sessionId"] = session
        os.write(self.to_write, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + self.timeout_s
        while True:
            reply = self._next(end - time.monotonic())
            if reply.get("id") == number:
                if "error" in reply:
                    raise PageError(f"{method}: {reply['error']['message']}")
                return reply["result"]
            self.events.append(reply)

    def _next(self, seconds):
        end = time.monotonic() + seconds
        while b"\0" not in self.buffer:
            left = end - time.monotonic()
            if left <= 0 or not select.select([self.to_read], [], [], left)[0]:
                raise PageError("the browser does not answer")
            piece = os.read(self.to_read, 1 << 16)
            if not piece:
                raise PageError("the browser has ended")
            self.buffer += piece
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def open(self, url, width=1280, height=900, dark=False):
        target = self.call("Target.createTarget", {"url": "about:blank"})["targetId"]
        session = self.call("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        page = Page(self, session, target)
        for domain in ("Page", "Runtime", "Network", "Log"):
            page.call(f"{domain}.enable")
        page.size(width, height)
        page.call("Emulation.setEmulatedMedia",
                  {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        page.call("Page.navigate", {"url": url})
        return page


class Page:
    def __init__(self, browser, session, target):
        self.browser, self.session, self.target = browser, session, target

    def close(self):
        self.browser.call("Target.closeTarget", {"targetId": self.target})

    def call(self, method, params=None):
        return self.browser.call(method, params, self.session)

    def size(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1,
                                                         "mobile": width < 600})

    def value(self, expression):
        result = self.call("Runtime.evaluate", {"expression": expression, "returnByValue": True, "awaitPromise": True})
        if "exceptionDetails" in result:
            raise PageError(f"{expression}: {result['exceptionDetails'].get('exception', {}).get('description', 'failed')}")
        return result["result"].get("value")

    def wait(self, expression, seconds=60):
        """Until the expression is true. Asked again each time the page has drawn."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                value = self.value(expression)
                if value:
                    return value
                self.value("new Promise((done) => setTimeout(done, 30))")
            except PageError as error:  # A document that is on its way has no body yet.
                if not self.is_there():
                    raise error
                time.sleep(0.05)
        raise PageError(f"in {seconds} s it did not come true: {expression}\nthe page says: {self.text()[:1500]}")

    def is_there(self):
        return self.call("Runtime.evaluate", {"expression": "1", "returnByValue": True})["result"].get("value") == 1

    def text(self):
        return self.value("document.body?.innerText") or ""

    def click(self, selector):
        """A real click in the middle of the first element that fits. What arrives meanwhile may push the element aside, so
        that the click misses it; then it is clicked again."""
        quoted = json.dumps(selector)
        self.wait(f"!!document.querySelector({quoted})")
        for _ in range(10):
            place = self.value(f"(() => {{ const e = document.querySelector({quoted}); if (!e) return null; window.clickArrived = false;"
                              " e.addEventListener('click', () => { window.clickArrived = true; }, {once: true, capture: true});"
                              " e.scrollIntoView({block: 'center'}); const b = e.getBoundingClientRect();"
                              " return [b.x + b.width / 2, b.y + b.height / 2]; })()")
            if place is None:  # What lies on it took the click, and led away.
                return
            for kind in ("mousePressed", "mouseReleased"):
                self.call("Input.dispatchMouseEvent", {"type": kind, "x": place[0], "y": place[1], "button": "left",
                                                       "clickCount": 1})
            if self.value("window.clickArrived") is not False:
                return
        raise PageError(f"no click arrived at {selector}")

    def move(self, selector, at_x=0.5, at_y=0.5):
        """The pointer to a place of the element, in shares of its size."""
        x, y = self.value(f"(() => {{ const b = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
                          f" return [b.x + b.width * {at_x}, b.y + b.height * {at_y}]; }})()")
        self.call("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": x, "y": y})

    def key(self, key, code=None, text=None):
        for kind in ("keyDown", "keyUp"):
            event = {"type": kind, "key": key, "code": code or key}
            if text and kind == "keyDown":
                event["text"] = text
            if key == "Tab":
                event["windowsVirtualKeyCode"] = 9
            if key == "Enter":
                event.update(windowsVirtualKeyCode=13, text="\r" if kind == "keyDown" else "")
            self.call("Input.dispatchKeyEvent", event)

    def screenshot(self, path, full=False):
        params = {"format": "png", "captureBeyondViewport": full}
        if full:
            size = self.call("Page.getLayoutMetrics")["cssContentSize"]
            params["clip"] = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("Page.captureScreenshot", params)["data"]))

    def complaints(self):
        """What the browser has complained of: exceptions, refused policies, failed requests."""
        self.value("1")
        found = []
        for event in self.browser.events:
            if event.get("sessionId") != self.session:
                continue
            if event["method"] == "Runtime.exceptionThrown":
                details = event["params"]["exceptionDetails"]
                found.append(details.get("exception", {}).get("description") or details["text"])
            elif event["method"] == "Log.entryAdded" and event["params"]["entry"]["level"] == "error":
                entry = event["params"]["entry"]
                found.append(f"{entry['text']} {entry.get('url', '')}")
            elif event["method"] == "Runtime.consoleAPICalled" and event["params"]["type"] == "error":
                found.append(" ".join(str(a.get("value", a.get("description", ""))) for a in event["params"]["args"]))
        return found
