# SPDX-License-Identifier: BSD-3-Clause
"""Checks that dist/report.html was built from the sources in web/, refers to nothing on the net, and
carries the licences of what is in it."""
import hashlib
import pathlib
import re
import sys

here = pathlib.Path(__file__).parent
web = here / "web"
page = (here / "dist/report.html").read_text()
faults = []

# The same sum as web/vite.config.js puts into the page.
total = hashlib.sha256()
files = sorted(str(p.relative_to(web)) for p in web.rglob("*") if p.is_file() and "node_modules" not in p.parts)
for name in files:
    total.update(f"{name}\n{hashlib.sha256((web / name).read_bytes()).hexdigest()}\n".encode())
if total.hexdigest() not in page:
    faults.append("dist/report.html is older than web/: run `npm ci && npm run build` in apps/report/web")

for place in ("<!--title-->", "<!--data-->"):
    if page.count(place) != 1:
        faults.append(f"dist/report.html has {page.count(place)} places {place}, must have one")

# Name spaces of SVG and XHTML are names, not addresses.
for address in sorted(set(re.findall(r"(?:https?|wss?|ftp):/?/[^\s\"'`<>)]*", page))):
    if not re.match(r"http://www\.w3\.org/(1999|2000)/", address):
        faults.append(f"dist/report.html has an address: {address}")
for tag in re.findall(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=[^>]*>", page.split("<script", 1)[0]):
    if "data:" not in tag:
        faults.append(f"dist/report.html loads something: {tag}")

for name in ("three", "uplot"):
    if not re.search(rf"^{name} [\d.]+\n\n(The MIT License|MIT License|The MIT)", page, re.M | re.I):
        faults.append(f"dist/report.html does not carry the licence of {name}")

print("\n".join(faults) or "the page belongs to its sources")
sys.exit(1 if faults else 0)
