#!/usr/bin/env python3
"""Makes the SYNTHETIC tables of this folder: no bone was cut for them. Seed 2002, Python's own generator.

The components are of the size that Plaskos 2002 prints for novices and experts (chapter 3): standard
deviations of 0.32 and 0.99 deg (varus/valgus) and 0.65 and 1.22 deg (flexion/extension) for milling and sawing,
a sagittal bias of 1.35 deg for sawing with open guides, times of 80, 215 and 100 s.
"""
import csv
import math
import pathlib
import random

random.seed(2002)
here = pathlib.Path(__file__).parent
normal = random.gauss

rows, number = [], 0
for who in ["A", "B", "C", "D", "E", "F", "G", "H"]:
    expert = who in "GH"
    own_vv, own_fe, own_time = normal(0, 0.15), normal(0, 0.35), math.exp(normal(0, 0.1))
    for technique in ["milling", "sawing"]:
        mill = technique == "milling"
        if who == "H" and not mill:
            continue  # H did not saw: a missing cell
        skew_vv, skew_fe = normal(0, 0.1), normal(0, 0.3)  # operator by technique
        for i in range(8 if mill else 7):
            number += 1
            specimen = f"S{(number * 7) % 20 + 1:02d}"
            cut = "PT" if i % 2 == 0 else "DF"
            move_vv = normal(0, 0.33 if mill else 0.39)
            move_fe = normal(0, 0.21 if mill else 0.24)
            sd_vv, sd_fe = (0.30, 0.62) if mill else (0.85 if not expert else 0.45, 1.18)
            vv = own_vv + skew_vv + 0.45 * move_vv + normal(0, sd_vv)
            fe = own_fe + skew_fe + (-0.1 if mill else 1.35) + 0.9 * move_fe + normal(0, sd_fe)
            seconds = own_time * (80 if expert else 215 if mill else 100) * math.exp(normal(0, 0.22))
            volume = (10735 if mill else 4370) * math.exp(normal(0, 0.12))
            lost = number in (17, 44, 71)  # the reference frame was disturbed
            rows.append({
                "cut_id": f"C{number:03d}", "operator": who, "group": "expert" if expert else "novice",
                "technique": technique, "guide": "open", "cut": cut, "specimen": specimen,
                "varus_valgus_deg": f"{vv:.2f}", "flexion_extension_deg": f"{fe:.2f}",
                "guide_movement_varus_valgus_deg": "" if lost else f"{move_vv:.2f}",
                "guide_movement_flexion_extension_deg": "" if lost else f"{move_fe:.2f}",
                "time_s": f"{seconds:.0f}", "removed_volume_mm3": f"{volume:.0f}"})


def write(name, rows, remark):
    with open(here / name, "w", newline="") as file:
        file.write(f"# SYNTHETIC: {remark}; made by synthesise.py, seed 2002. No bone was cut for it.\n")
        table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


write("milling_and_sawing.csv", rows, "eight operators mill and saw")


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def tilted(frame, about_x, about_y):
    """Normal of a plane turned about the frame's x, then about its fixed y (degrees)."""
    a, b = math.radians(about_x), math.radians(about_y)
    n = (math.cos(a) * math.sin(b), -math.sin(a), math.cos(a) * math.cos(b))
    return [sum(n[k] * frame[k][i] for k in range(3)) for i in range(3)]


poses, points = [], []
for i in range(6):
    side = "right" if i % 2 == 0 else "left"
    z = unit([normal(0, 0.05), normal(0, 0.05), 1])
    x = unit([a - sum(p * q for p, q in zip([1, 0.1, 0], z)) * b for a, b in zip([1, 0.1, 0], z)])
    frame = [x, cross(z, x), z]
    about_x, about_y = normal(0, 0.4), normal(0.5, 0.7)
    after = tilted(frame, normal(0, 0.2), normal(0, 0.2))
    pose = {"cut_id": f"T{i + 1}", "operator": "A", "cut_kind": "proximal-tibia", "side": side}
    for stem, v in (("guide_n", z), ("guide_e", x), ("guide_after_n", after)):
        pose.update({stem + axis: f"{c:.6f}" for axis, c in zip("xyz", v)})
    poses.append(pose)
    n = tilted(frame, about_x, about_y)
    u = unit(cross([0, 1, 0], n))
    v = cross(n, u)
    for p in range(8):
        for q in range(5):
            s, t = (p - 3.5) * 9, (q - 2) * 9
            h = normal(0, 0.08) + 0.15 * (1 - (s / 32) ** 2)  # roughness and a slight crown
            points.append({"cut_id": f"T{i + 1}", "surface": "cut",
                           **{f"{axis}_mm": f"{s * u[k] + t * v[k] + h * n[k]:.3f}" for k, axis in enumerate("xyz")}})
write("tracker_guides.csv", poses, "guide planes of six tibial cuts")
write("tracker_points.csv", points, "points digitised on the six cut surfaces")

placements = []
for i in range(30):
    n = tilted([[1, 0, 0], [0, 1, 0], [0, 0, 1]], normal(0.3, 0.075), normal(-0.2, 0.125))
    placements.append({"cut_kind": "proximal-tibia", "side": "right", "guide_nx": 0, "guide_ny": 0, "guide_nz": 1,
                       "guide_ex": 1, "guide_ey": 0, "guide_ez": 0,
                       **{f"cut_n{axis}": f"{c:.6f}" for axis, c in zip("xyz", n)}})
write("tracker_placements.csv", placements, "one cut, the dummy implant placed 30 times")
