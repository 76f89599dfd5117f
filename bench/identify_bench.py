#!/usr/bin/env python3
"""The identification benchmark with SciPy's time for the same record: the chain as a laboratory's script has it, on whole
arrays: line through the idle ends, filter, moving level, revolutions from the tachometer, bins, variable projection by
fminsearch. The same forces within a few standard errors, or it ends here."""
import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy import optimize, signal

RATE, FLUTES, RADIUS, HELIX, DEPTH, FEED, BINS = 8000.0, 4, 3.175e-3, 0.52, 5e-3, 20e-6, 96
PITCH = 2 * np.pi / FLUTES
SECTIONS = signal.butter(4, 1000.0, fs=RATE, output="sos")


def columns(angle, x, y, phase, slices=24):
    """Forces of the six unit coefficients, 3 n x 6: half immersion, down, run-out (x, y), mid-points of slices."""
    z = (np.arange(slices) + 0.5) * DEPTH / slices
    lag = z * np.tan(HELIX) / RADIUS
    flute = PITCH * np.arange(FLUTES)
    deviation = x * np.cos(flute[:, None] + lag) + y * np.sin(flute[:, None] + lag)
    theta = (angle - phase)[:, None, None] - flute[:, None] - lag
    s, c = np.sin(theta), np.cos(theta)
    h = np.full(theta.shape, np.inf)
    for before in range(1, FLUTES + 1):
        other = np.roll(deviation, before, axis=0)
        h = np.minimum(h, before * FEED * s + deviation - other)
    cut = (s > 0) & (c < 0) & (h > 0)
    width = DEPTH / slices
    blocks = []
    for value in (np.where(cut, h, 0.0) * width, cut * width):
        for fx, fy, fz in ((-c, s, 0 * c), (-s, -c, 0 * c), (0 * c, 0 * c, 1 + 0 * c)):
            blocks.append(np.concatenate([(value * f).sum(axis=(1, 2)) for f in (fx, fy, fz)]))
    return np.array(blocks).T


def chain(record):
    force, tacho = record[:, :3].copy(), record[:, 3]
    window = 400
    power = ((force - force[:8000].mean(axis=0)) ** 2).sum(axis=1)
    total = np.concatenate([[0.0], np.cumsum(power)])
    level = np.sqrt((total[window:] - total[:-window]) / window)
    inside = np.flatnonzero(level > 0.5 * (np.median(level) + level.min()))
    begin, end = inside[0] + window, inside[-1]
    ends = np.array([force[:begin - 2 * window].mean(axis=0), force[end + 2 * window:].mean(axis=0)])
    places = np.array([0.5 * begin, 0.5 * (end + len(force))])
    t = np.arange(len(force))
    force -= ends[0] + np.outer((t - places[0]) / (places[1] - places[0]), ends[1] - ends[0])
    force = signal.sosfiltfilt(SECTIONS, force, axis=0)
    rise = np.flatnonzero((tacho[:-1] < 0) & (tacho[1:] >= 0))
    pulse = rise - tacho[rise] / (tacho[rise + 1] - tacho[rise])
    angle = np.interp(t, pulse, 2 * np.pi * np.arange(len(pulse)))
    speed = 2 * np.pi * RATE / np.diff(pulse).mean()
    force, angle = force[begin:end], angle[begin:end]
    turn = np.floor(angle / (2 * np.pi)).astype(int)
    turn -= turn[0]
    whole = (turn > 0) & (turn < turn[-1])
    force, angle, turn = force[whole], angle[whole] % (2 * np.pi), turn[whole]
    bins = (angle / (2 * np.pi) * BINS).astype(int)
    count = np.bincount(bins, minlength=BINS)
    place = np.bincount(bins, angle, BINS) / count
    mean = np.array([np.bincount(bins, f, BINS) / count for f in force.T])
    group = (turn - 1) * 64 // turn.max()
    cell = group * BINS + bins
    cells = np.bincount(cell, minlength=64 * BINS)
    each = np.concatenate([(np.bincount(cell, f, 64 * BINS) / cells).reshape(64, BINS) for f in force.T], axis=1)

    harmonics = np.arange(21)
    _, response = signal.sosfreqz(SECTIONS, harmonics * speed / (2 * np.pi), fs=RATE)
    gains = np.abs(response) ** 2 * np.sinc(harmonics / BINS)
    fine = 2 * np.pi * np.arange(168) / 168
    cosines = np.cos((place[:, None] - fine)[:, :, None] * harmonics)
    kernel = (cosines * (gains * np.where(harmonics == 0, 1, 2))).sum(axis=2) / 168
    values = mean.ravel()

    def model(u):
        a = columns(fine, u[0] * FEED, u[1] * FEED, u[2])
        return np.vstack([kernel @ a[i * 168:(i + 1) * 168] for i in range(3)])

    def solve(u):
        a = model(u)
        scale = np.linalg.norm(a, axis=0)
        return a, np.linalg.lstsq(a / scale, values, rcond=None)[0] / scale

    def residual(u):
        a, k = solve(u)
        return values - a @ k

    starts = [np.array([0.0, 0.0, p]) for p in PITCH * np.arange(24) / 24]
    def cost(u):
        return (residual(u) ** 2).sum()

    starts.sort(key=cost)
    starts = [p + [0.4 * np.cos(d), 0.4 * np.sin(d), 0.0] for p in starts[:3] for d in np.pi / 4 * np.arange(8)] + starts[:3]
    starts.sort(key=cost)
    # Slices come and go with the unknowns, so derivatives are of no use; fminsearch, as a MATLAB script would.
    fits = [optimize.minimize(cost, u, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-6}) for u in starts[:3]]
    u = min(fits, key=lambda f: f.fun).x
    a, k = solve(u)
    step = 1e-4
    outer = np.array([(model(u + step * e) - model(u - step * e)) @ k / (2 * step) for e in np.eye(3)]).T
    jacobian = np.hstack([a, outer])
    scale = np.linalg.norm(jacobian, axis=0)
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
    scatter = inverse @ (each - each.mean(axis=0)).T
    error = np.sqrt((scatter ** 2).sum(axis=1) / (64 * 63))
    return np.concatenate([k, u * [FEED, FEED, 1.0]]), error * np.array(6 * [1.0] + [FEED, FEED, 1.0])


with tempfile.TemporaryDirectory() as folder:
    file = os.path.join(folder, "record")
    subprocess.run([sys.argv[1], "--record", file], check=True)
    data = np.fromfile(file).reshape(-1, 4)
ours = [line.split() for line in
        subprocess.run([sys.argv[1], "--estimates"], check=True, capture_output=True, text=True).stdout.splitlines()]
seconds = []
for _ in range(2):
    begin = time.perf_counter()
    theirs, error = chain(data)
    seconds.append(time.perf_counter() - begin)
# Mid-points of 24 slices and other ends of the idle parts: a hundredth, and a few standard errors.
for (name, value, _), there, spread in zip(ours, theirs, error):
    assert abs(float(value) - there) < 0.01 * abs(there) + 5 * spread, (name, value, there, spread)
document = json.loads(subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True).stdout)
for figure in document["figures"]:
    if figure.get("baseline") == "scipy":
        figure["baseline_value"] = round(min(seconds), 3)
        figure["ratio"] = round(min(seconds) / figure["value"], 3)
print(json.dumps(document))
