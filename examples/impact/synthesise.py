#!/usr/bin/env python3
"""Writes the synthetic hammer blows beside it: one mode (922 Hz, damping ratio 0.011, modal mass 0.03993 kg) struck by
half-sines of 0.4 ms, sampled at 12.5 kHz, behind an anti-aliasing
filter, with noise of 0.5 N and 0.05 um. Seed 5; no measurement."""
import numpy as np

frequency, damping, mass, rate, count = 922.0, 0.011, 0.03993, 12500.0, 4000
random = np.random.default_rng(5)
time = np.arange(count) / rate
omega = 2 * np.pi * frequency
damped = omega * np.sqrt(1 - damping**2)
# The blow is resolved 16 times finer than the samples, so that its shape is not part of the error.
fine = np.arange(16 * count) / (16 * rate)
impulse = np.exp(-damping * omega * fine) * np.sin(damped * fine) / (mass * damped)
for blow, peak in enumerate((180.0, 220.0, 200.0), 1):
    phase = (fine - 5e-3) / 0.4e-3
    force = np.where((phase > 0) & (phase < 1), peak * np.sin(np.pi * np.clip(phase, 0, 1)), 0.0)
    spectrum = np.fft.rfft(force, 2 * fine.size) * np.fft.rfft(impulse, 2 * fine.size)
    displacement = np.fft.irfft(spectrum)[: fine.size] / (16 * rate)
    # The same anti-aliasing filter on both channels, as a data logger has.
    keep = 1 / (1 + (np.fft.rfftfreq(2 * fine.size, 1 / (16 * rate)) / 4000) ** 16)
    force, displacement = (np.fft.irfft(keep * np.fft.rfft(x, 2 * fine.size))[: fine.size] for x in (force, displacement))
    table = np.column_stack([time, force[::16] + random.normal(0, 0.5, count),
                             1e6 * displacement[::16] + random.normal(0, 0.05, count)])
    np.savetxt(f"blow_{blow}.csv", table, fmt=["%.6f", "%.2f", "%.3f"], delimiter=",", comments="",
               header="time_s,force_n,displacement_um")

# A frequency response normal to the feed, as an analyser exports it: two modes (780 and 960 Hz) and 0.005 um/N of noise.
lines = np.arange(100.0, 2000.0, 3.125)
response = sum(1e3 / stiffness / (1 - (lines / mode) ** 2 + 2j * ratio * lines / mode)
               for mode, ratio, stiffness in ((780.0, 0.02, 1500.0), (960.0, 0.025, 6000.0)))
noise = random.normal(0, 0.005, (2, lines.size))
np.savetxt("response_y.csv", np.column_stack([lines, response.real + noise[0], response.imag + noise[1]]),
           fmt=["%.3f", "%.4f", "%.4f"], delimiter=",", comments="", header="frequency_hz,real_um_per_n,imaginary_um_per_n")
