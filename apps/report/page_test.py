# SPDX-License-Identifier: BSD-3-Clause
"""Opens the reports that osteomill_report_sample writes in a browser, from disk, and uses them."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tools"))
from browser import Browser  # noqa: E402

SAMPLE, CHROMIUM = sys.argv.pop(), sys.argv.pop()


class ReportPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        subprocess.run([SAMPLE, cls.folder.name], check=True, stdout=subprocess.DEVNULL)
        cls.browser = Browser(CHROMIUM).__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.folder.cleanup()

    def look(self, name, browser, **how):
        page = browser.open(f"file://{self.folder.name}/{name}.html", **how)
        page.wait("document.documentElement.dataset.ready || document.documentElement.dataset.error")
        self.assertIsNone(page.evaluate("document.documentElement.dataset.error"))
        return page

    def open(self, name, **how):
        page = self.look(name, self.browser, **how)
        self.addCleanup(self.leave, page)
        return page

    def leave(self, page):
        page.close()
        self.assertEqual(page.complaints, [])
        self.assertEqual([r for r in page.requests if not r.startswith(("file:", "data:"))], [])

    def test_opens_from_disk_without_the_net_and_without_complaints(self):
        for name in ("two_runs", "one_run", "sections", "long_signals"):
            with self.subTest(name):
                page = self.open(name)
                self.assertEqual(page.evaluate("document.title"), page.evaluate("document.querySelector('h1').textContent"))
                self.assertGreater(page.evaluate("document.querySelectorAll('.u-wrap canvas').length"), 0)

    def test_shows_table_headline_notes_and_case(self):
        page = self.open("two_runs")
        self.assertEqual(page.evaluate("document.querySelectorAll('.summary tbody tr').length"), 2)
        self.assertIn("Adaptive feed", page.evaluate("document.querySelector('.headline').textContent"))
        self.assertIn("not a medical device", page.evaluate("document.querySelector('.notes').textContent"))
        # Markup within the data stays text.
        self.assertIn("</script><b>", page.evaluate("document.querySelector('.case code').textContent"))

    def test_switches_runs(self):
        page = self.open("two_runs")
        before = page.evaluate("osteomill.player.end")
        page.click(".runs label:nth-of-type(2)")
        self.assertEqual(page.evaluate("document.documentElement.dataset.run"), "adaptive")
        self.assertEqual(page.evaluate("document.querySelector('tr[aria-current] th').textContent"), "adaptive")
        self.assertNotEqual(page.evaluate("osteomill.player.end"), before)

    def test_scrubbing_moves_the_cutter_the_readings_and_the_material(self):
        page = self.open("two_runs")
        place = page.evaluate("osteomill.drawn().cutter")
        page.click(".scrub")  # its middle is the middle of the run
        half = page.evaluate("osteomill.player.end / 2")
        self.assertAlmostEqual(page.evaluate("osteomill.player.time"), half, delta=0.1)
        moved = page.evaluate("osteomill.drawn().cutter")
        # Constant feed over 50 mm: half of the time is half of the way.
        self.assertAlmostEqual(place[0] - moved[0], 25, delta=0.5)
        self.assertEqual(page.evaluate("document.querySelector('.strip output').textContent"), "cancellous")
        self.assertEqual(page.evaluate("document.querySelectorAll('.legend output')[1].textContent"), "4.80")
        self.assertFalse(page.evaluate("document.querySelector('.playhead').hidden"))

    def test_pointing_at_a_chart_shows_that_time_and_clicking_stays_there(self):
        page = self.open("two_runs")
        x, y, width, _ = page.centre(".u-over")
        end = page.evaluate("osteomill.player.end")
        page.mouse("mouseMoved", x - width / 4, y)
        page.wait("osteomill.player.pointed !== null")
        self.assertAlmostEqual(page.evaluate("osteomill.player.pointed"), end / 4, delta=0.01 * end)
        self.assertEqual(page.evaluate("osteomill.player.time"), end)
        page.click(".u-over", dx=-0.25)
        self.assertAlmostEqual(page.evaluate("osteomill.player.time"), end / 4, delta=0.01 * end)
        page.mouse("mouseMoved", 5, 5)
        page.wait("osteomill.player.pointed === null")

    def test_dragging_zooms_all_charts_and_the_button_shows_all_again(self):
        page = self.open("two_runs")
        button = "document.querySelector('.charts .tools button')"
        self.assertTrue(page.evaluate(f"{button}.hidden"))
        before = page.evaluate("osteomill.zoom()")
        page.drag(".u-over", 150, 0)
        page.wait(f"!{button}.hidden")
        ranges = page.evaluate("osteomill.zoom()")
        self.assertEqual(len({tuple(r) for r in ranges}), 1)
        self.assertLess(ranges[0][1] - ranges[0][0], 0.5 * (before[0][1] - before[0][0]))
        page.click(".charts .tools button")
        page.wait(f"{button}.hidden")
        self.assertEqual(page.evaluate("osteomill.zoom()"), before)

    def test_plays_to_the_end_and_stops(self):
        page = self.open("two_runs")
        page.evaluate("osteomill.player.seek(osteomill.player.end - 0.4)")
        page.click(".play")
        self.assertEqual(page.evaluate("document.querySelector('.play').ariaLabel"), "Pause")
        page.wait("!osteomill.player.playing")
        self.assertEqual(page.evaluate("osteomill.player.time"), page.evaluate("osteomill.player.end"))

    def test_the_stock_is_shown_before_as_cut_and_after(self):
        page = self.open("two_runs")
        picture = "document.querySelector('.scene-frame canvas').toDataURL()"
        page.evaluate("osteomill.player.seek(8)")
        shown = {}
        for i, name in enumerate(("before", "now", "after"), 1):
            page.click(f".scene-tools .row:first-child label:nth-of-type({i})")
            page.wait(f"osteomill.drawn().stage === '{name}'")
            page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            shown[name] = page.evaluate(picture)
        self.assertEqual(len(set(shown.values())), 3)

    def test_the_view_turns_by_mouse_and_by_keys(self):
        page = self.open("two_runs")
        before = page.evaluate("osteomill.drawn().camera")
        page.drag(".scene-frame canvas", 80, 30)
        turned = page.evaluate("osteomill.drawn().camera")
        self.assertNotEqual(before, turned)
        page.evaluate("document.querySelector('.scene-frame canvas').focus()")
        page.key("ArrowLeft")
        self.assertNotEqual(turned, page.evaluate("osteomill.drawn().camera"))

    def test_fits_narrow_screens_and_follows_the_dark_scheme(self):
        for name in ("two_runs", "sections"):
            page = self.open(name, width=390, height=844, scheme="dark")
            self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), 390)
            red = page.evaluate("Number(getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0])")
            self.assertLess(red, 60)
            page.click("header .tools button")  # from the system's colours to light ones
            red = page.evaluate("Number(getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0])")
            self.assertGreater(red, 200)

    def test_prints(self):
        page = self.open("two_runs", scheme="dark")
        with tempfile.NamedTemporaryFile(suffix=".pdf") as file:
            page.pdf(file.name)
            self.assertTrue(pathlib.Path(file.name).read_bytes().startswith(b"%PDF"))

    def test_without_webgl_the_embedded_picture_stands_in(self):
        with Browser(CHROMIUM, flags=["--disable-3d-apis"]) as browser:
            page = self.look("two_runs", browser)
            self.assertIn("no WebGL", page.evaluate("document.querySelector('.scene').textContent"))
            self.assertTrue(page.evaluate("document.querySelector('.scene-frame img').src.startsWith('data:image/')"))
            page.click(".runs label:nth-of-type(2)")
            self.assertEqual(page.evaluate("document.documentElement.dataset.run"), "adaptive")

    def test_every_control_has_a_name(self):
        page = self.open("two_runs")
        nameless = page.evaluate("""[...document.querySelectorAll('button, input, select, canvas, img')].filter(e =>
            !(e.ariaLabel || e.title || e.alt || e.textContent.trim() || e.labels?.[0]?.textContent.trim() ||
              e.closest('[role=img]'))).map(e => e.outerHTML.slice(0, 80))""")
        self.assertEqual(nameless, [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
