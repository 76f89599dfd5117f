#!/usr/bin/env python3
"""Writes src/osteomill/identify/filtfilt_reference.inc: what SciPy makes of a short signal.

  filtfilt_reference.py > src/osteomill/identify/filtfilt_reference.inc

The numbers are committed, so that the tests need no SciPy; this script says where they come from and makes them again.
Low-pass filters up to order 4 are what `filtfilt` makes of them. The others are run as second-order sections by
`sosfiltfilt`: their polynomials lose digits, by how much is said on standard error.
"""
import sys

import numpy
import scipy
from scipy import signal

RATE = 8000.0
CASES = [(1, 400.0, "low"), (2, 1000.0, "low"), (4, 250.0, "low"), (9, 1666.0, "low"), (6, 150.0, "low"),
         (3, 20.0, "high"), (4, 30.0, "high")]
SAMPLES = 400


def record():
    """A repeating force with an entry, an offset and fixed noise: all numbers from integer arithmetic."""
    t = numpy.arange(SAMPLES)
    state, noise = 12345, []
    for _ in range(SAMPLES):
        state = (1103515245 * state + 12345) % 2**31
        noise.append(state / 2**31 - 0.5)
    return 3.0 + (t > 120) * (10.0 + 4.0 * numpy.sin(2 * numpy.pi * t / 48.0)) + numpy.array(noise)


def row(values):
    return ",\n    ".join(", ".join(f"{v:.17g}" for v in values[i:i + 4]) for i in range(0, len(values), 4))


def main():
    x = record()
    print("// SPDX-License-Identifier: BSD-3-Clause")
    print(f"// Made by tools/filtfilt_reference.py with SciPy {scipy.__version__}, NumPy {numpy.__version__}.")
    print(f"constexpr double kRate = {RATE};")
    print(f"const std::vector<double> kSignal = {{\n    {row(x)}}};")
    print("const std::vector<Reference> kReferences = {")
    for order, cutoff, kind in CASES:
        sos = signal.butter(order, cutoff, kind, fs=RATE, output="sos")
        y = signal.sosfiltfilt(sos, x)
        b, a = signal.butter(order, cutoff, kind, fs=RATE)
        direct = signal.filtfilt(b, a, x)
        print(f"order {order} {kind} {cutoff:g} Hz: filtfilt and sosfiltfilt differ by {abs(direct - y).max():.1e}",
              file=sys.stderr)
        if order <= 4 and kind == "low":
            y = direct
        print(f"    {{{order}, {cutoff}, Pass::{kind},\n     {{{row(y)}}}}},")
    print("};")


if __name__ == "__main__":
    main()
