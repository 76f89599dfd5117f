#!/usr/bin/env python3
"""The stability benchmark with NumPy's time for the same map: semi-discretisation with the whole monodromy matrix, all
depths of a speed at once. It is timed on every tenth speed and scaled, as it takes minutes."""
import json
import subprocess
import sys
import time

import numpy as np

F, ZETA, MASS, KT, KN, FLUTES, STEPS = 922.0, 0.011, 0.03993, 6e8, 2e8, 2, 40
OMEGA = 2 * np.pi * F


def integral(theta):
    """Integral of one edge's directional matrix from 0, for theta in one turn, the cut on 0 ... pi/2."""
    t = np.clip(theta, 0.0, np.pi / 2)
    sc, ss, cc = np.sin(t) ** 2 / 2, t / 2 - np.sin(2 * t) / 4, t / 2 + np.sin(2 * t) / 4
    return np.array([[-KT * sc - KN * ss, -KT * cc - KN * sc], [KT * ss - KN * sc, KT * sc - KN * cc]])


def exponential(a, terms=18):
    """exp and the first two phi functions of a stack of small matrices, by Taylor series."""
    one = np.broadcast_to(np.eye(a.shape[-1]), a.shape)
    phi2 = one
    for k in range(terms, 0, -1):
        phi2 = one + a @ phi2 / (k + 2)
    phi2 = phi2 / 2
    phi1 = one + a @ phi2
    return one + a @ phi1, phi1, phi2


def radii(rpm, depths):
    """Spectral radii of all depths at one speed."""
    dt = 60.0 / (rpm * FLUTES) / STEPS
    free = np.zeros((4, 4))
    free[:2, 2:] = OMEGA * np.eye(2)
    free[2:, :2] = -OMEGA * np.eye(2)
    free[2:, 2:] = -2 * ZETA * OMEGA * np.eye(2)
    width = np.pi / STEPS
    n = 4 + 2 * STEPS
    state = np.broadcast_to(np.eye(4, n), (len(depths), 4, n)).copy()
    rows = []
    for i in range(STEPS):
        w = depths[:, None, None] * (integral((i + 1) * width) - integral(i * width)) / width
        bw = np.zeros((len(depths), 4, 2))
        bw[:, 2:, :] = w / (MASS * OMEGA) * dt
        a = np.broadcast_to(free * dt, (len(depths), 4, 4)).copy()
        a[:, :, :2] += bw
        e, phi1, phi2 = exponential(a)
        new, both = -phi2 @ bw, -phi1 @ bw
        old = both - new
        rows.append(state[:, :2, :].copy())
        advanced = e @ state
        advanced[:, :, 4 + 2 * i:6 + 2 * i] += old
        if i + 1 < STEPS:
            advanced[:, :, 6 + 2 * i:8 + 2 * i] += new
        else:
            advanced += new @ rows[0]
        state = advanced
    return np.abs(np.linalg.eigvals(np.concatenate([state] + rows, axis=1))).max(axis=1)


depths = 0.05e-3 * np.arange(1, 101)
theirs = np.array([radii(rpm, np.array([1e-3]))[0] for rpm in (5000.0, 12300.0, 24900.0)])
ours = np.array(subprocess.run([sys.argv[1], "--radii"], check=True, capture_output=True, text=True).stdout.split(), float)
assert np.allclose(ours, theirs, rtol=1e-5), (ours, theirs)
begin = time.perf_counter()
for rpm in 5000.0 + 1000.0 * np.arange(20):
    radii(rpm, depths)
baseline = 10 * (time.perf_counter() - begin)
document = json.loads(subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True).stdout)
for figure in document["figures"]:
    if figure.get("baseline") == "numpy":
        figure["baseline_value"] = round(baseline, 3)
        figure["ratio"] = round(baseline / figure["value"], 3)
print(json.dumps(document))
