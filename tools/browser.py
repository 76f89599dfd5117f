# SPDX-License-Identifier: BSD-3-Clause
"""Drives a headless chromium through its debugging pipe: enough to test a page, nothing to install.

    with Browser() as browser:
        page = browser.open("file:///tmp/report.html", width=1280, height=900)
        page.wait("document.documentElement.dataset.ready === 'true'")
        page.evaluate("document.title")
        page.screenshot("/tmp/report.png")
"""
import base64
import json
import os
import pathlib
import select
import shutil
import signal
import subprocess
import tempfile
import time

# Swiftshader draws WebGL without a graphics card; the rest keeps the browser from calling home.
FLAGS = """--headless --no-sandbox --disable-gpu --enable-unsafe-swiftshader --disable-quic --no-first-run
    --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage
    --hide-scrollbars --remote-debugging-pipe""".split()


class Failed(Exception):
    pass


class Browser:
    def __init__(self, program=None, flags=(), patience_s=120):
        program = program or next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
        self.patience_s = patience_s
        self.folder = tempfile.mkdtemp(prefix="osteomill-browser-")
        to_read, self.to = os.pipe()
        self.back, from_write = os.pipe()

        def pipes():  # the browser reads from 3 and writes to 4
            os.setsid()
            os.dup2(to_read, 103)
            os.dup2(from_write, 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        self.process = subprocess.Popen(
            [program, *FLAGS, *flags, f"--user-data-dir={self.folder}", "about:blank"], preexec_fn=pipes,
            close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, "HOME": self.folder})
        os.close(to_read)
        os.close(from_write)
        self.rest = b""
        self.number = 0
        self.pages = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.send("Browser.close")
            self.process.wait(20)
        except (Failed, subprocess.TimeoutExpired, OSError):
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        os.close(self.to)
        os.close(self.back)
        shutil.rmtree(self.folder, ignore_errors=True)

    def send(self, method, session=None, **parameters):
        """Sends a command and returns its result; what happens meanwhile goes to the pages' records."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + self.patience_s
        while True:
            answer = self.receive(end)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise Failed(f"{method}: {answer['error']['message']}")
                return answer["result"]
            page = self.pages.get(answer.get("sessionId"))
            if page and "method" in answer:
                page.happened(answer["method"], answer["params"])

    def receive(self, end):
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.back], [], [], max(end - time.monotonic(), 0))
            piece = os.read(self.back, 1 << 20) if ready else b""
            if not piece:
                raise Failed("the browser does not answer" if not ready else "the browser has ended")
            self.rest += piece
        first, _, self.rest = self.rest.partition(b"\0")
        return json.loads(first)

    def open(self, address, width=1280, height=900, scheme="light"):
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        page = self.pages[session] = Page(self, session, target)
        for domain in ("Page", "Runtime", "Log", "Network"):
            page.send(f"{domain}.enable")
        page.resize(width, height)
        page.scheme(scheme)
        page.send("Page.navigate", url=address)
        page.wait("location.href !== 'about:blank' && document.readyState === 'complete'")
        return page


class Page:
    def __init__(self, browser, session, target):
        self.browser, self.session, self.target = browser, session, target
        self.complaints = []  # errors and warnings of the console, exceptions
        self.requests = []  # every address that was asked for

    def send(self, method, **parameters):
        return self.browser.send(method, self.session, **parameters)

    def close(self):
        self.browser.send("Target.closeTarget", targetId=self.target)

    def happened(self, method, what):
        if method == "Runtime.exceptionThrown":
            details = what["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(a.get("value", a.get("description"))) for a in what["args"]))
        elif method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            if "GL Driver Message (OpenGL, Performance" not in what["entry"]["text"]:  # the picture was read back
                self.complaints.append(what["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(what["request"]["url"])

    def resize(self, width, height):
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def scheme(self, name):
        self.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": name}])

    def evaluate(self, expression):
        result = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise Failed(f"{expression}: {result['exceptionDetails'].get('exception', {}).get('description')}")
        return result["result"].get("value")

    def wait(self, expression):
        end = time.monotonic() + self.browser.patience_s
        while not (value := self.evaluate(expression)):
            if time.monotonic() > end:
                raise Failed(f"still not so: {expression}\n" + "\n".join(self.complaints))
            time.sleep(0.05)
        return value

    def centre(self, selector):
        """Brings an element into view and returns its middle."""
        return self.evaluate(f"""(() => {{
            const element = document.querySelector({json.dumps(selector)})
            element.scrollIntoView({{ block: 'center', behavior: 'instant' }})
            const box = element.getBoundingClientRect()
            return [box.x + box.width / 2, box.y + box.height / 2, box.width, box.height]
        }})()""")

    def mouse(self, kind, x, y, button="none", clicks=0, **more):
        held = {"left": 1, "right": 2}.get(button, 0)
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=clicks, buttons=held,
                  **more)

    def click(self, selector, dx=0.0, dy=0.0):
        """Clicks an element; dx, dy are shares of its size away from its middle."""
        x, y, width, height = self.centre(selector)
        x, y = x + dx * width, y + dy * height
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, "left", 1)
        self.mouse("mouseReleased", x, y, "left", 1)

    def drag(self, selector, dx, dy, button="left", start=(0.0, 0.0)):
        """Drags by dx, dy pixels from the middle of an element, or from a share of its size away."""
        x, y, width, height = self.centre(selector)
        x, y = x + start[0] * width, y + start[1] * height
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, button, 1)
        for step in range(1, 6):
            self.mouse("mouseMoved", x + dx * step / 5, y + dy * step / 5, button)
        self.mouse("mouseReleased", x + dx, y + dy, button, 1)

    def key(self, name):
        for kind in ("keyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key=name, code=name)

    def screenshot(self, path, whole=False):
        picture = self.send("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        pathlib.Path(path).write_bytes(base64.b64decode(picture["data"]))

    def pdf(self, path):
        document = self.send("Page.printToPDF", printBackground=True, paperWidth=8.27, paperHeight=11.69)
        pathlib.Path(path).write_bytes(base64.b64decode(document["data"]))
