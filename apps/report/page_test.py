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

    def open(self, name, **how):
        page = (how.pop("browser", None) or self.browser).open(f"file://{self.folder.name}/{name}.html", **how)
        page.wait("document.documentElement.dataset.ready || document.documentElement.dataset.error")
        self.assertIsNone(page.evaluate("document.documentElement.dataset.error"))
        self.addCleanup(lambda: self.assertEqual(page.complaints, []))
        self.addCleanup(lambda: self.assertEqual([r for r in page.requests if not r.startswith(("file:", "data:"))], []))
        return page

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


if __name__ == "__main__":
    unittest.main(verbosity=2)
