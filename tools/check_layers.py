#!/usr/bin/env python3
"""Checks every #include "osteomill/ROOM/..." of src/ against layers.txt, and that each room has a README."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
allowed = {}
for line in (root / "layers.txt").read_text().splitlines():
    if line and not line.startswith("#"):
        room, _, rest = line.partition(":")
        allowed[room] = {room, *rest.split()}

faults = []
for room in sorted(p for p in (root / "src/osteomill").iterdir() if p.is_dir()):
    if room.name not in allowed:
        faults.append(f"{room.name}: not in layers.txt; add the room and what it may include")
        continue
    if not (room / "README.md").exists():
        faults.append(f"{room.name}: no README.md; say what belongs in the room")
    for source in sorted(room.rglob("*.[ch]pp")):
        for number, text in enumerate(source.read_text().splitlines(), 1):
            match = re.match(r'\s*#include "osteomill/(\w+)/', text)
            if match and match[1] not in allowed[room.name]:
                faults.append(f"{source.relative_to(root)}:{number}: {room.name} may not include {match[1]}")
print("\n".join(faults) or "layers hold")
sys.exit(1 if faults else 0)
