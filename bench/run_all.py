#!/usr/bin/env python3
"""Runs every benchmark and puts what they tell into one JSON file.

    run_all.py PROGRAMS RESULTS [--quick] [--no-cross]

PROGRAMS is the directory with the built programs, RESULTS the file to write. Progress is told on
the standard error. A part that cannot be measured here is in the results under "skipped", with the
reason; exit code 1 says that one failed.
"""

import argparse
import contextlib
import datetime
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
SKIPPED = 77
LONGEST = 600  # s, for one program
PACKAGES = ["libomniorb4-2", "omniidl", "libfastrtps2.9", "libfastcdr1", "g++-12"]


class Failed(Exception):
    pass


class Skipped(Exception):
    pass


class Bench:
    def __init__(self, options):
        self.options = options
        self.begin = time.monotonic()
        self.results = {"seconds": {}, "skipped": {}}
        self.failures = []

    def say(self, text):
        elapsed = time.monotonic() - self.begin
        print(f"[{elapsed:5.0f} s] {text}", file=sys.stderr, flush=True)

    def run(self, command, **options):
        """What a program prints; its own messages go to the standard error."""
        # A group of its own, so that what it has started ends with it.
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True,
                              **options) as process:
            try:
                output, _ = process.communicate(timeout=LONGEST)
            except BaseException as reason:
                for number in (signal.SIGTERM, signal.SIGKILL):
                    with contextlib.suppress(ProcessLookupError):
                        os.killpg(process.pid, number)
                    with contextlib.suppress(subprocess.TimeoutExpired):
                        process.wait(5)
                if isinstance(reason, subprocess.TimeoutExpired):
                    raise Failed(f"{command[0]} took longer than {LONGEST} s") from None
                raise
        if process.returncode == SKIPPED:
            raise Skipped(output.strip() or "see above")
        if process.returncode == 1 and output.startswith("{"):
            self.failures.append(os.path.basename(command[0]))  # it has measured, and is not content
        elif process.returncode != 0:
            raise Failed(f"{' '.join(command)} ended with exit code {process.returncode}")
        return output

    def program(self, name, *arguments, quick=True):
        command = [os.path.join(self.options.programs, name), *arguments]
        if quick and self.options.quick:
            command.append("--quick")
        return json.loads(self.run(command))

    def part(self, name, measure):
        """A part of the results, timed, that does not keep the others from being measured."""
        self.say(name)
        started = time.monotonic()
        try:
            self.results[name] = measure()
        except Skipped as reason:
            self.results["skipped"][name] = str(reason)
            self.say(f"{name}: SKIPPED: {reason}")
        except (Failed, OSError, ValueError, LookupError, TypeError, AttributeError) as reason:
            self.failures.append(name)
            self.results["skipped"][name] = f"failed: {reason}"
            self.say(f"{name}: FAILED: {reason}")
        self.results["seconds"][name] = round(time.monotonic() - started, 1)


def text_of(path):
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except OSError:
        return ""


def machine():
    cpu = re.search(r"^model name\s*:\s*(.*)$", text_of("/proc/cpuinfo"), re.M)
    memory = re.search(r"^MemTotal:\s*(\d+)", text_of("/proc/meminfo"), re.M)
    system = re.search(r'^PRETTY_NAME="(.*)"', text_of("/etc/os-release"), re.M)
    return {
        "cpu": cpu.group(1) if cpu else platform.machine(),
        "cpus": len(os.sched_getaffinity(0)),
        "memory_gib": round(int(memory.group(1)) / 2**20, 1) if memory else None,
        "kernel": platform.release(),
        "system": system.group(1) if system else platform.system(),
        "load_before": os.getloadavg()[0],
        "date": datetime.date.today().isoformat(),
    }


def versions():
    found = {}
    for package in PACKAGES:
        asked = subprocess.run(["dpkg-query", "-W", "-f=${Version}", package],
                               capture_output=True, text=True, check=False)
        if asked.returncode == 0:
            found[package] = asked.stdout
    commit = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"],
                            capture_output=True, text=True, check=False)
    found["canorb"] = commit.stdout.strip() or "unknown"
    return found


def sizes(bench):
    omniorb = bench.program("peer_omniorb", "sizes")
    peers = {name: omniorb[name]["operations"] for name in ("giop_1_0", "giop_1_2")}
    captured = None
    try:
        captured = bench.program("peer_fastdds", "sizes")
    except Skipped as reason:
        bench.results["skipped"]["sizes of Fast DDS"] = str(reason)
    if captured:
        for name in ("best_effort", "reliable"):
            peers[f"rtps_{name}"] = captured[name]["operations"]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(peers, file)
        file.flush()
        result = bench.program("sizes", "--peers", file.name, quick=False)
    result["first_call_extra"] = {name: omniorb[name]["first_call_extra"]
                                  for name in ("giop_1_0", "giop_1_2")}
    return result


def latencies(bench, program, transports):
    result = {}
    enough = len(os.sched_getaffinity(0)) > 1
    for transport in transports:
        for cpus in ("one", "two") if enough else ("one",):
            bench.say(f"  {program}, {transport}, {cpus} CPU{'s' if cpus == 'two' else ''}")
            result[f"{transport}_{cpus}"] = bench.program(
                program, "latency", "--transport", transport, "--cpus", cpus)
    return result


def table(text, columns):
    """The rows of a text table: a name that may have blanks, then so many numbers."""
    rows = {}
    number = r"\s+(-?\d+(?:\.\d+)?)"
    for line in text.splitlines():
        row = re.match(rf"^(\S.*?){number * columns}\s*$", line)
        if row:
            rows[row.group(1)] = [float(value) for value in row.groups()[1:]]
    return rows


def footprint(bench):
    command = [os.path.join(HERE, "footprint", "measure.sh")]
    if bench.options.no_cross:
        command.append("--no-cross")
    result = {}
    target = None
    for line in bench.run(command).splitlines():
        if line.endswith("bss"):
            target = "cortex_m4" if line.startswith("Cortex") else "x86_64"
            result[target] = {}
        elif target:
            name, text, data, bss = line.split()
            result[target][name] = {"text": int(text), "data": int(data), "bss": int(bss)}
    if not result:
        raise Failed("footprint/measure.sh has printed no table")
    return result


def generated_code(bench):
    idlc = os.path.join(os.path.dirname(os.path.dirname(bench.options.programs)), "bin",
                        "canorb-idlc")
    command = [os.path.join(HERE, "generated_code", "compare.sh"), idlc, ROOT,
               os.path.join(ROOT, "orb", "include")]
    rows = table(bench.run(command), 3)
    return {name: {"canorb": row[0], "omniorb": row[1], "ratio": row[2]}
            for name, row in rows.items()}


def allocations(bench):
    output = bench.run([os.path.join(bench.options.programs, "allocations")])
    rows = table(output, 3)
    return {name: {"caller": row[0], "servant": row[1], "bus": row[2]}
            for name, row in rows.items()}


def bus_speed(bench):
    seconds = "0.1" if bench.options.quick else "0.5"
    output = bench.run([os.path.join(bench.options.programs, "bus_speed"),
                        "--benchmark_format=json", f"--benchmark_min_time={seconds}"])
    return [{key: value for key, value in row.items()
             if isinstance(value, (int, float)) or key == "name"}
            for row in json.loads(output)["benchmarks"]]


def cost(bench):
    return {
        "canorb": bench.program("calls", "--only", "cost")["cost"],
        "omniorb": bench.program("peer_omniorb", "cost"),
        "fastdds": bench.program("peer_fastdds", "cost"),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", help="directory of the built programs")
    parser.add_argument("results", help="JSON file to write")
    parser.add_argument("--quick", action="store_true", help="two minutes in place of five or more")
    parser.add_argument("--no-cross", action="store_true", help="nothing for a Cortex-M4")
    options = parser.parse_args()
    options.programs = os.path.abspath(options.programs)
    if not shutil.which("size"):
        parser.error("size(1) is missing: install binutils")

    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    signal.signal(signal.SIGHUP, lambda *_: sys.exit(129))
    bench = Bench(options)
    bench.results["quick"] = options.quick
    bench.results["machine"] = machine()
    bench.results["versions"] = versions()
    bench.part("sizes", lambda: sizes(bench))
    bench.part("marshalling", lambda: bench.program("marshalling"))
    # The two that are compared, next to each other.
    bench.part("calls of omniORB", lambda: latencies(bench, "peer_omniorb", ("unix", "tcp")))
    bench.part("calls", lambda: bench.program("calls"))
    bench.part("calls of Fast DDS", lambda: latencies(bench, "peer_fastdds", ("shm", "udp")))
    bench.part("cost", lambda: cost(bench))
    bench.part("allocations", lambda: allocations(bench))
    bench.part("generated_code", lambda: generated_code(bench))
    bench.part("bus_speed", lambda: bus_speed(bench))
    if options.quick:
        options.no_cross = True
    bench.part("footprint", lambda: footprint(bench))
    bench.part("real_time", lambda: bench.program("response_time"))
    bench.results["seconds"]["all"] = round(time.monotonic() - bench.begin, 1)

    with open(options.results, "w", encoding="utf-8") as file:
        json.dump(bench.results, file, indent=1)
        file.write("\n")
    bench.say(f"results in {os.path.relpath(options.results)}")
    if bench.failures:
        sys.exit(f"failed: {', '.join(bench.failures)}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
