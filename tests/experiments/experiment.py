"""What the experiments share: building, rendering with parray-mpi, tables and plots."""

import argparse
import csv
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"
BIN = BUILD / "bin"
SCENE = ROOT / "scenes" / "one-weekend-1600.json"


def arguments(description, name):
    """A parser with the options that all experiments have."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=BUILD / "experiments" / name,
                        metavar="DIR", help="where tables and plots go (default: %(default)s)")
    parser.add_argument("--full", action="store_true",
                        help="the report's size, 1200 x 800 pixels with 500 samples: takes long")
    return parser


def build(*targets):
    subprocess.run(["cmake", "--preset", "release"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "--preset", "release", "--target", *targets], cwd=ROOT,
                   check=True, stdout=subprocess.DEVNULL)


def mpi_environment():
    return dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")


def render(directory, name, ranks, *options, scene=SCENE):
    """Renders with parray-mpi; returns the report. The picture is directory/name.exr."""
    directory.mkdir(parents=True, exist_ok=True)
    report = directory / f"{name}.json"
    command = ["mpirun", "-n", ranks, "--oversubscribe", BIN / "parray-mpi", scene, "-o",
               directory / f"{name}.exr", "--report", report, "--quiet", *options]
    done = subprocess.run([str(word) for word in command], env=mpi_environment(),
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr.strip()}")
    return json.loads(report.read_text())


def interleaved(rounds, variants, measure):
    """Medians of measure(variant) over rounds in which the variants take turns, so that a machine
    whose speed drifts drifts for all."""
    values = {variant: [] for variant in variants}
    for _ in range(rounds):
        for variant in variants:
            values[variant].append(measure(variant))
    return {variant: statistics.median(of) for variant, of in values.items()}


def row_report(directory, rounds=3, spp=50):
    """A report whose mpi.row_seconds are the least of some renders on one thread: what else the
    machine does takes time, and never gives any."""
    reports = [render(directory, "rows", 1, "--row-seconds", "--threads", 1, "--width", 1200,
                      "--height", 800, "--spp", spp) for _ in range(rounds)]
    report = reports[0]
    report["mpi"]["row_seconds"] = [
        min(rows) for rows in zip(*(r["mpi"]["row_seconds"] for r in reports))]
    report["seconds"]["build"] = min(r["seconds"]["build"] for r in reports)
    path = directory / "rows.json"
    path.write_text(json.dumps(report))
    return path


def simulate(rows, *options, **named):
    """Lines of simulate_mpi as dictionaries; named(option_name=value) become options."""
    command = [BIN / "simulate_mpi", "--rows", rows, *options]
    for name, value in named.items():
        command += ["--" + name.replace("_", "-"), value]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr.strip())
    return list(csv.DictReader(done.stdout.splitlines()))


def write_table(directory, name, header, rows):
    """directory/name.csv and .md; the latter is printed, too."""
    directory.mkdir(parents=True, exist_ok=True)
    with open(directory / f"{name}.csv", "w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in [header, *rows]]
    lines.insert(1, "|" + "---|" * len(header))
    (directory / f"{name}.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines) + "\n")


def plot(directory, name, commands):
    """directory/name.svg by gnuplot, whose working directory is `directory`."""
    if shutil.which("gnuplot") is None:
        print(f"no plot {name}.svg: gnuplot is missing (apt-get install gnuplot-nox)")
        return
    setup = (f"set terminal svg size 640,400 font 'sans,12' background rgb 'white'\n"
             f"set output '{name}.svg'\nset datafile separator ','\nset grid\n")
    subprocess.run(["gnuplot"], input=setup + commands, text=True, cwd=directory, check=True)
    print(f"wrote {directory / name}.svg")
