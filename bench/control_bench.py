#!/usr/bin/env python3
"""The real-time part of the control loop: control_bench.py PROGRAM [SECONDS]. Its wake-ups are measured while cyclictest
(Debian's rt-tests) measures those of the system beside it: same priority, same period, same seconds. Without it or
without real-time rights there is no baseline."""
import json
import os
import shutil
import subprocess
import sys
import tempfile

program, seconds = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 10.0


def figures(*arguments):
    return json.loads(subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout)["figures"]


def cyclictest():
    """The system's wake-ups in the background; None where it cannot be measured."""
    path = shutil.which("cyclictest") or "/usr/bin/cyclictest"
    if not os.access(path, os.X_OK):
        return None
    return subprocess.Popen([path, "--mlockall", "--priority=80", "--interval=1000", "--quiet", "--threads=1",
                             f"--duration={max(1, int(seconds))}s"],
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


def largest(process):
    """From its line `T: 0 ( 123) P:80 I:1000 C: 10000 Min: 2 Act: 5 Avg: 6 Max: 55`, us."""
    if process is None:
        return None
    text = process.communicate(timeout=seconds + 30)[0]
    return float(text.split("Max:")[1].split()[0]) if process.returncode == 0 and "Max:" in text else None


result = figures("step")
system = cyclictest()
ours = figures("jitter", str(seconds))
baseline = largest(system)
for figure in ours:
    if figure["name"] == "jitter" and baseline:
        figure.update(baseline="cyclictest", baseline_value=baseline, ratio=round(baseline / figure["value"], 4))
result += ours
with tempfile.TemporaryDirectory() as folder:
    result += figures("ingest", str(min(seconds, 5.0)), os.path.join(folder, "ingest.h5"))
print(json.dumps({"figures": result}, indent=2))
