#!/usr/bin/env python3
"""Makes the SYNTHETIC force records of this folder: no bone was cut for them. Seed 2023, Python's own generator.

  examples/records/synthesise.py [OSTEOMILL]      the program; otherwise ./run osteomill

The forces of one revolution come from `osteomill force` with the linear law and the run-out below, so the coefficients that
`osteomill identify` has to give back are known. On top: entry and exit in 0.1 s each (a straight ramp, not a geometry), a bone
whose hardness varies by 2 % along the cut, white noise of 0.3 N, an offset that drifts, and a dynamometer under the bone whose
x points against the feed and whose z points down. Two records are laid out like a DynoWare export, the others as tables.
"""
import csv
import json
import math
import pathlib
import random
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = sys.argv[1:] or [str(HERE.parent.parent / "run"), "osteomill"]
RATE, IDLE, RAMP, PLATEAU = 2000, 0.15, 0.1, 0.6
SPEED_RPM = 3012.0  # the table says 3000: the spindle turned a little faster
DYNOWARE = {3, 4}

CASE = """
[cutter]
shape = "cylindrical"
diameter_mm = 6
flutes = 2
helix_deg = 30
run_out = {{ offset_um = 4 }}

[bone]
law = "linear"
[bone.tangential]
any_deg = {{ k = 180, edge = 4.0 }}
[bone.radial]
any_deg = {{ k = 95, edge = 5.5 }}
[bone.lateral]
any_deg = {{ k = 60, edge = 1.2 }}

[cut]
spindle_speed_rpm = 3000
feed_per_tooth_mm = {feed}
axial_depth_mm = {depth}
immersion = "slot"
"""


def revolution(feed, depth):
    case = HERE / "case_of_one_record.toml"
    case.write_text(CASE.format(feed=feed, depth=depth))
    done = subprocess.run([*PROGRAM, "force", str(case), "--format", "json"], capture_output=True, text=True, check=True)
    case.unlink()
    document = json.loads(done.stdout)
    return [document["revolution"]["force_n"][axis] for axis in "xyz"], document["mean_force_n"]


def record(force):
    """Rows of time and the dynamometer's x, y, z in N, and the pulse in V."""
    out, hardness, start = [], 0.0, random.random()
    offset = [random.uniform(-8, 8) for _ in "xyz"]
    drift = [random.uniform(-2, 2) for _ in "xyz"]
    end = IDLE + RAMP + PLATEAU + RAMP
    for i in range(round((end + IDLE) * RATE)):
        t = i / RATE
        share = max(0.0, min(1.0, (t - IDLE) / RAMP, (end - t) / RAMP))
        turns = start + SPEED_RPM / 60.0 * t
        angle = (turns % 1.0) * 360.0
        memory = math.exp(-1.0 / (0.05 * RATE))  # 50 ms
        hardness = memory * hardness + math.sqrt(1 - memory * memory) * random.gauss(0, 0.02)
        on_tool = []
        for axis in force:
            low, rest = int(angle), angle - int(angle)
            value = axis[low % 360] + rest * (axis[(low + 1) % 360] - axis[low % 360])
            on_tool.append(share * (1 + hardness) * value)
        on_bone = [-value for value in on_tool]
        sensor = [-on_bone[0], on_bone[1], -on_bone[2]]
        row = [s + o + d * t + random.gauss(0, 0.3) for s, o, d in zip(sensor, offset, drift)]
        # A flank of a twentieth of a turn that crosses the middle where the angle is 0.
        phase = (turns + 0.025) % 1.0
        pulse = 5.0 * (phase / 0.05 if phase < 0.05 else 1.0 if phase < 0.2 else 0.0)
        out.append([f"{t:.4f}", *(f"{v:.2f}" for v in row), f"{pulse:.2f}"])
    return out


def write(name, rows, number):
    if number in DYNOWARE:
        head = [["Kistler DynoWare, laid out like its export; SYNTHETIC"], ["Sampling rate [Hz]:", f"{RATE:.6f}"],
                ["Measuring time [s]:", f"{len(rows) / RATE:.6f}"], [], ["Time", "Fx", "Fy", "Fz", "Tacho"],
                ["s", "N", "N", "N", "V"]]
        separator = "\t"
    else:
        head = [["# SYNTHETIC: made by synthesise.py"], ["time_s", "Fx [N]", "Fy [N]", "Fz [N]", "Tacho [V]"]]
        separator = ","
    (HERE / name).write_text("".join(separator.join(row) + "\n" for row in head + rows))


def main():
    random.seed(2023)
    table = [["name", "group", "axial_depth_mm", "feed_per_tooth_um", "spindle_speed_rpm", "record"]]
    number = 0
    for group, depth in [("bone 1", 1.0), ("bone 2", 2.0)]:
        for feed in [0.02, 0.05, 0.1]:
            number += 1
            force, mean = revolution(feed, depth)
            name = f"slot_{number}.{'txt' if number in DYNOWARE else 'csv'}"
            write(name, record(force), number)
            table.append([f"slot {number}", group, depth, round(feed * 1000), 3000, name])
            print(name, *(f"{axis} {value:.3f} N" for axis, value in mean.items()))
    with open(HERE / "table.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
