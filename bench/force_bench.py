#!/usr/bin/env python3
"""The force benchmark with NumPy's time for the same revolution: 360 x 100 x 4 edge elements, log law, Hankinson."""
import json
import subprocess
import sys
import time

import numpy as np

LAWS = {"t0": (0.42083, 0.58122, -0.06584), "t90": (0.27242, 0.66537, -0.08710),
        "r0": (0.62379, 0.43160, -0.20553), "r90": (0.64731, 0.17764, -0.06681),
        "l": (-0.19495, 0.61971, -0.07352)}


def revolution(feed_um=6.5, depth=8.0, radius=3.175, helix=np.radians(30), flutes=4, slices=100, steps=360):
    """Forces at each step, N: the algorithm of sliced_revolution.hpp on whole arrays."""
    step = np.arange(steps) * 2 * np.pi / steps
    lag = (np.arange(slices) + 0.5) * depth / slices * np.tan(helix) / radius
    flute = np.arange(flutes) * 2 * np.pi / flutes
    psi = step[:, None, None] - flute[None, :, None] - lag[None, None, :]
    sine, cosine = np.sin(psi), np.cos(psi)
    cuts = sine > 0
    l = np.log10(feed_um * np.where(cuts, sine, 1.0))

    def law(name):
        k1, k2, k3 = LAWS[name]
        return np.where(cuts, 10.0 ** ((k3 * l + k2) * l + k1), 0.0)

    def hankinson(along, across):
        f0, f90 = law(along), law(across)
        return np.where(cuts, f0 * f90 / np.where(cuts, f0 * sine**2 + f90 * cosine**2, 1.0), 0.0)

    tangential, radial, lateral = hankinson("t0", "t90"), hankinson("r0", "r90"), law("l")
    width = depth / slices
    x = width * (-tangential * cosine - radial * sine).sum(axis=(1, 2))
    y = width * (tangential * sine - radial * cosine).sum(axis=(1, 2))
    z = -width * lateral.sum(axis=(1, 2))
    return x, y, z


x, y, z = revolution()
# The printed means of the case, to 1 %: both sides compute the same thing.
assert abs(x.mean() + 58.2) < 0.6 and abs(y.mean() - 53.7) < 0.6 and abs(z.mean() + 21.9) < 0.3
times = []
for _ in range(7):
    begin = time.perf_counter()
    revolution()
    times.append(time.perf_counter() - begin)
document = json.loads(subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True).stdout)
for figure in document["figures"]:
    if figure.get("baseline") == "numpy":
        figure["baseline_value"] = round(min(times) * 1e3, 4)
        figure["ratio"] = round(figure["baseline_value"] / figure["value"], 3)
print(json.dumps(document))
