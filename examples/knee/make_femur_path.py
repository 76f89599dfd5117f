#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes femur.cl: the five cuts of a femoral component (generic family, size 3), each milled with the end of a 7 mm cutter
that stands on the cut's plane, in passes from side to side, two levels deep. Plane of the cuts: x distal, y anterior, as in
docs/guide/robot.md; work frame: z distal, y anterior."""
import math
import pathlib

AP = 45 + 2 * 20 / 6  # mm, size 3 of 7
ORIGIN_Z = -8.0  # of the distal cut in the work frame
RADIUS, STEP, LEVELS = 3.5, 5.0, (4.0, 0.0)
SIDE, CLEAR = 48.0, 25.0  # half the length of a pass; off the plane while the tool turns over

tilt = math.radians(5)
anterior = (-0.27 * AP, 0.52 * AP)
posterior = (-0.23 * AP, -0.48 * AP)
corners = [
    (anterior[0] - 0.55 * AP * math.cos(tilt), anterior[1] + 0.55 * AP * math.sin(tilt)), anterior,
    (0, 0.25 * AP), (0, -0.25 * AP), posterior, (posterior[0] - 0.30 * AP, posterior[1])
]

lines = ["PARTNO FIVE CUTS OF A FEMORAL COMPONENT", "UNITS/MM", "MULTAX", "SPINDL/20000,RPM,CLW"]


def place(x, across, out, cut, kind="GOTO"):
    """Tip at x to the side, `across` along the cut from its first corner, `out` off its plane."""
    (x0, y0), (x1, y1) = corners[cut], corners[cut + 1]
    length = math.hypot(x1 - x0, y1 - y0)
    along = ((x1 - x0) / length, (y1 - y0) / length)
    normal = (-along[1], along[0])  # out of the bone that stays
    distal = x0 + across * along[0] + out * normal[0]
    front = y0 + across * along[1] + out * normal[1]
    lines.append(f"{kind}/{x:.4f},{front:.4f},{ORIGIN_Z + distal:.4f},0,{normal[1]:.9f},{normal[0]:.9f}")


first = True
for cut in (2, 0, 4, 1, 3):  # distal, anterior, posterior, the chamfers
    length = math.dist(corners[cut], corners[cut + 1])
    # The proximal ends of the anterior and the posterior cut keep a radius.
    begin = RADIUS if cut == 0 else 0.0
    end = length - RADIUS if cut == 4 else length
    passes = max(2, math.ceil((end - begin) / STEP) + 1)
    side = -SIDE
    if not first:
        lines.append("RAPID")
    place(side, begin, CLEAR, cut, "FROM" if first else "GOTO")
    first = False
    for level in LEVELS:
        for k in range(passes):
            across = begin + (end - begin) * k / (passes - 1)
            lines.append("RAPID")
            place(side, across, level, cut)
            lines.append("FEDRAT/900,MMPM")
            side = -side
            place(side, across, level, cut)
    lines.append("RAPID")
    place(side, end, CLEAR, cut)
    if side > 0:
        lines.append("RAPID")
        place(-SIDE, end, CLEAR, cut)
lines.append("FINI")
pathlib.Path(__file__).with_name("femur.cl").write_text("\n".join(lines) + "\n")
