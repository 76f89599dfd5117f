#!/usr/bin/env python3
"""osteomill force and reproduce as a script sees them: keys, streams, exit status. force_test.py PROGRAM SOURCE"""
import json
import pathlib
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])

CASE = """
[cutter]
shape = "cylindrical"
diameter_mm = 6.35
flutes = 4
helix_deg = 30
rake_deg = 10
[bone]
law = "log"
orientation = "hankinson"
orientation_exponent = 2
[bone.tangential]
at_0_deg  = { k1 = 0.42083, k2 = 0.58122, k3 = -0.06584 }
at_90_deg = { k1 = 0.27242, k2 = 0.66537, k3 = -0.08710 }
[bone.radial]
at_0_deg  = { k1 = 0.62379, k2 = 0.43160, k3 = -0.20553 }
at_90_deg = { k1 = 0.64731, k2 = 0.17764, k3 = -0.06681 }
[bone.lateral]
any_deg   = { k1 = -0.19495, k2 = 0.61971, k3 = -0.07352 }
[cut]
spindle_speed_rpm = 5000
feed_rate_mm_per_min = 130
axial_depth_mm = 8.0
immersion = "slot"
radial_depth_mm = 3.175
"""


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == status, f"{arguments}: status {done.returncode}, not {status}\n{done.stderr}"
    return done


def document(*arguments):
    return json.loads(run(*arguments, "--format", "json").stdout)


with tempfile.TemporaryDirectory() as folder:
    case = pathlib.Path(folder, "case.toml")
    case.write_text(CASE)
    # A result that nobody gets is a failure of the world, small as it may be.
    with open("/dev/full", "w") as full:
        lost = subprocess.run([PROGRAM, "force", str(case), "--format", "json"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert lost.returncode == 5 and "standard output" in lost.stderr, lost

    cut = document("force", case)
    # Plaskos 2006, table 3.5, last column of tool C, to 1 %.
    for axis, printed in {"x": -58.2, "y": 53.7, "z": -21.9}.items():
        assert abs(cut["mean_force_n"][axis] / printed - 1) < 0.01, cut["mean_force_n"]
    assert set(cut["peak_force_n"]) == {"x", "y", "z", "resultant"}
    for key in ("mean_torque_nmm", "mean_power_w", "removal_rate_mm3_per_s", "feed_per_tooth_mm", "warnings"):
        assert key in cut, key
    turn = cut["revolution"]
    assert len(turn["angle_deg"]) == len(turn["force_n"]["x"]) == 360
    assert abs(sum(turn["force_n"]["y"]) / 360 / cut["mean_force_n"]["y"] - 1) < 1e-3
    assert abs(cut["feed_per_tooth_mm"] - 0.0065) < 1e-12

    # The text says the same, and one that asks for csv gets it.
    assert "-58.18" in run("force", case).stdout
    assert run("force", case, "--format", "csv").stdout.startswith('"force on the cutter, N",')

    curve = document("force", case, "--over", "feed_per_tooth_mm=0.001:0.0065:3")
    assert [round(p["feed_per_tooth_mm"], 6) for p in curve["points"]] == [0.001, 0.00375, 0.0065]
    assert abs(curve["points"][2]["mean_force_n"]["x"] - cut["mean_force_n"]["x"]) < 1e-9
    assert curve["over"] == "cut.feed_per_tooth_mm"

    # The energy is all somewhere, and the curve may grow by factors.
    assert abs(sum(cut["heat_w"].values()) / cut["mean_power_w"] - 1) < 1e-9, cut["heat_w"]
    assert len(cut["flutes"]) == 4 and len(cut["revolution"]["bending_moment_nmm"]) == 360
    curve = document("force", case, "--over", "feed_per_tooth_mm=0.001:0.1:3:log")
    assert [round(p["feed_per_tooth_mm"], 9) for p in curve["points"]] == [0.001, 0.01, 0.1]
    curve = document("force", case, "--over", "cutter.flutes=2:4:3")
    assert [p["flutes"] for p in curve["points"]] == [2, 3, 4]

    for override, name in {"cut.feed_rate_mm_per_min=-1": "feed_rate_mm_per_min",
                           "cutter.flutes=0": "cutter.flutes",
                           "cut.immersion=sideways": "cut.immersion",
                           "cut.axial_depth_mm=500": "cut.axial_depth_mm",
                           "cutter.use=nothing": "cutter.use",
                           "cut.feed_rate=3": "feed_rate_mm_per_min",
                           "cut.spindle_speed_rad_per_s=5000": "spindle_speed_rad_per_s",
                           "cut.feed_per_tooth_um=3": "feed_per_tooth_um",
                           "bone.use=nowhere.toml": "nowhere.toml"}.items():
        done = run("force", case, "--set", override, "--format", "json", status=2)
        assert done.stdout == "" and name in done.stderr, (override, done.stderr)
    run("force", case, "--over", "speed=1:2:3", status=2)
    run("force", case, "--over", "feed_per_tooth_mm=0:1:3:log", status=2)
    run("force", case, "--over", "feed_per_tooth_mm=1:nan:3", status=2)
    run("force", pathlib.Path(folder, "none.toml"), status=2)

    for example in ("slot_force", "ramp_force", "run_out_force", "engagement_force"):
        assert document("force", SOURCE / "examples" / f"{example}.toml")["mean_power_w"] > 0

    shapes = document("force", SOURCE / "examples" / "cutter_shapes.toml")["runs"]
    assert len(shapes) == 6 and all(one["mean_power_w"] > 0 for one in shapes)
    fast, slow = document("force", SOURCE / "examples" / "tested_rakes.toml")["runs"]
    assert any("between rakes of 0 and 10 deg" in text for text in fast["warnings"]), fast["warnings"]
    assert any("100 rpm or less" in text for text in slow["warnings"]), slow["warnings"]

    # Orthogonal cuts to a bone that the next command takes.
    fit = document("fit", SOURCE / "examples" / "fit_law.toml", "-o", pathlib.Path(folder, "fit"))
    radial = next(f for f in fit["fits"] if f["component"] == "radial" and f["direction_deg"] == 0)
    assert radial["better"] == "log" and len(radial["speed_effects"]) == 3, radial
    own = pathlib.Path(folder, "own.toml")
    own.write_text(CASE.split("[bone]")[0] + '[bone]\nuse = "fit/bone.toml"\n[cut]' + CASE.split("[cut]")[1])
    ours = document("force", own)["mean_force_n"]
    # 5 % scatter of four cuts a point, six or seven points a law: some per cent.
    assert all(abs(ours[axis] / cut["mean_force_n"][axis] - 1) < 0.1 for axis in "xyz"), ours
    run("fit", case, status=2)

    # A run directory's case runs again to the same numbers.
    run("force", case, "-o", pathlib.Path(folder, "run"))
    again = document("force", pathlib.Path(folder, "run", "run.json"))
    assert again["mean_force_n"] == cut["mean_force_n"]
    assert pathlib.Path(folder, "run", "revolution.png").stat().st_size > 10000

entries = document("reproduce")["entries"]
# A miss has its reason; the tables' predicted means do not miss.
assert all(entry["pass"] or entry["reason"] for entry in entries)
assert all(entry["pass"] for entry in entries if "predicted means" in entry["entry"])
run("reproduce", "nobody", status=2)
