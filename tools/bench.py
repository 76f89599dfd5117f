#!/usr/bin/env python3
"""Runs benchmarks: tools/bench.py BUILD [NAME...] [--format table|json]. Without a name it lists and runs all."""
import argparse
import json
import os
import pathlib
import platform
import re
import subprocess
import sys

parser = argparse.ArgumentParser(prog="./run bench", description="benchmarks, each beside its baseline")
parser.add_argument("build")
parser.add_argument("names", nargs="*", help="which ones; all when none is named")
parser.add_argument("--format", choices=["table", "json"], default="table")
arguments = parser.parse_args()

sources = pathlib.Path(__file__).resolve().parent.parent / "bench"
programs = {p.name.removeprefix("osteomill_").removesuffix("_bench"): p
            for p in sorted(pathlib.Path(arguments.build, "bench").glob("osteomill_*_bench")) if os.access(p, os.X_OK)}
unknown = [name for name in arguments.names if name not in programs]
if unknown:
    print(f"error: no benchmark {', '.join(unknown)}; known: {' '.join(programs)}", file=sys.stderr)
    sys.exit(2)
if not arguments.names:
    print("benchmarks:", " ".join(programs), file=sys.stderr)



def google_figures(document):
    """Figures of a Google Benchmark: rates where it counts them, otherwise the time of a run."""
    for run in document["benchmarks"]:
        name = re.sub(r"(?<=\d)_(?=\d)", ".", run["name"]).replace("/", "-").replace("_", "-")
        rates = {key: value for key, value in run.items() if key.endswith("/s")}
        for key, value in rates.items():
            yield {"name": name, "value": value, "unit": key}
        if not rates:
            yield {"name": name, "value": run["real_time"], "unit": run["time_unit"]}


figures = []
for name in arguments.names or programs:
    script = sources / f"{name}_bench.py"
    # Debian's Python, which has Debian's NumPy; another may stand first on the path.
    command = (["/usr/bin/python3", str(script), str(programs[name])] if script.exists()
               else [str(programs[name]), "--benchmark_format=json"])
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(done.stdout + done.stderr, file=sys.stderr)
        print(f"error: the benchmark {name} failed with status {done.returncode}", file=sys.stderr)
        sys.exit(5)
    document = json.loads(done.stdout)
    for figure in document["figures"] if "figures" in document else google_figures(document):
        figures.append({"benchmark": name, **figure})


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


machine = {"processor": processor(), "cores": os.cpu_count(), "load_1min": round(os.getloadavg()[0], 2),
           "system": platform.platform()}
if arguments.format == "json":
    print(json.dumps({"figures": figures, "machine": machine}, indent=2))
    sys.exit(0)
rows = [("benchmark", "figure", "value", "unit", "baseline", "its value", "times better")]
for f in figures:
    has = "baseline" in f
    rows.append((f["benchmark"], f["name"], f"{f['value']:.4g}", f["unit"], f.get("baseline", ""),
                 f"{f['baseline_value']:.4g}" if has else "", f"{f['ratio']:.3g}" if has else ""))
widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
for row in rows:
    print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
print(f"\n{machine['processor']}, {machine['cores']} cores, load {machine['load_1min']}")
