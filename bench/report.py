#!/usr/bin/env python3
"""Writes doc/benchmarks.md and its charts from what run_all.py has measured.

    report.py RESULTS DOCUMENT

The charts go into a directory beside DOCUMENT, with its name without the ending.
"""

import argparse
import json
import os

import charts

OPERATIONS = {
    "ping": "void ping()",
    "set_attribute_ul": "SetAttributeValueUL(string, ulong, ulong)",
    "read": "float read()",
    "push": "oneway push(ushort, float)",
    "get_level": "attribute float, get",
    "set_level": "attribute float, set",
    "status": "enum status()",
    "rename_64": "rename(string of 64)",
    "load_256": "load(sequence of 256 octets)",
    "limits": "limits(out float, out float)",
    "user_exception": "convert(ushort), user exception",
    "system_exception": "forbidden(), system exception",
    "attach_nil": "attach(nil)",
    "attach_reference": "attach(object reference)",
}
# What an operation carries, as lists of the marshalling benchmark; a ushort in CDR has 2 octets.
VALUES = {
    "ping": [],
    "set_attribute_ul": ["set_attribute_ul"],
    "read": ["read"],
    "push": ["push"],
    "get_level": ["level"],
    "set_level": ["level"],
    "status": ["status"],
    "rename_64": ["rename_64"],
    "load_256": ["load_256"],
    "limits": ["limits"],
    "user_exception": [2, "user_exception"],
    "system_exception": ["system_exception"],
    "attach_nil": ["attach_nil"],
    "attach_reference": ["attach_reference"],
}
PEERS = {"giop_1_0": "GIOP 1.0", "giop_1_2": "GIOP 1.2", "rtps_best_effort": "RTPS",
         "rtps_reliable": "RTPS reliable"}


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def octets(message, key="octets"):
    return message[key] if message else 0


def both(row, key="octets"):
    return octets(row["request"], key) + octets(row["reply"], key)


def cell(row, key="octets"):
    reply = row["reply"]
    return f"{octets(row['request'], key)} + {octets(reply, key)}" if reply else \
        f"{octets(row['request'], key)}"


def can_cost(row):
    """What request and reply cost on CAN, without Fast DDS's statistics."""
    return [message.get("can_without_statistics", message["can"])
            for message in (row["request"], row["reply"]) if message]


def can(row, key):
    return sum(cost[key] for cost in can_cost(row))


def can_time(row, rate):
    return sum(cost["milliseconds"][rate] for cost in can_cost(row))


def microseconds(nanoseconds):
    value = nanoseconds / 1000
    return f"{value:.2f}" if value < 10 else f"{value:.1f}" if value < 1000 else f"{value:,.0f}"


def yes(reached):
    return "yes" if reached else "**no**"


class Report:
    def __init__(self, results, directory):
        self.results = results
        self.directory = directory
        self.text = []
        self.bars = []  # (what, bar, figure, reached)

    def add(self, text):
        self.text.append(text)

    def chart(self, name, svg, description):
        with open(os.path.join(self.directory, name), "w", encoding="utf-8") as file:
            file.write(svg)
        folder = os.path.basename(self.directory)
        self.add(f"![{description}]({folder}/{name})")

    def bar(self, what, limit, figure, reached):
        self.bars.append((what, limit, figure, yes(reached)))

    # ---- sizes

    def sizes(self):
        sizes = self.results.get("sizes")
        if not sizes:
            return
        ours = sizes["giop_can"]
        others = sizes["others_over_iso_tp"]
        names = [name for name in PEERS if name in others]
        self.add("## Octets, frames and bits\n\n"
                 "Octets of request + reply. GIOP/CAN is counted without the sequence octet of each "
                 "continuation frame, which has its own column; GIOP was captured between omniORB's client and server, RTPS on "
                 "the loopback interface, as UDP payload. Debian's Fast DDS ends each datagram with a statistics submessage "
                 "of 60 octets; the figures are without it, and in brackets the sum with it. The object key of the GIOP server has two octets, "
                 "as canorb's has. The DDS samples hold the arguments and nothing else, so a pair of them is no call yet: nothing "
                 "says which reply belongs to which request. What a reliable reader acknowledges with, a datagram of its own, is not counted.")
        rows = []
        for name, title in OPERATIONS.items():
            row = [title, cell(ours[name]), both(ours[name], "sequence_octets")]
            for peer in names:
                row.append(cell(others[peer][name]) if not peer.startswith("rtps") else
                           f"{cell(others[peer][name], 'octets_without_statistics')} "
                           f"({both(others[peer][name])})")
            rows.append(row)
        total = ["**all**", f"**{sum(both(ours[n]) for n in OPERATIONS)}**",
                 sum(both(ours[n], "sequence_octets") for n in OPERATIONS)]
        for peer in names:
            key = "octets_without_statistics" if peer.startswith("rtps") else "octets"
            total.append(f"**{sum(both(others[peer][n], key) for n in OPERATIONS)}**")
        rows.append(total)
        self.add(table(["operation", "GIOP/CAN", "sequence octets"] + [PEERS[n] for n in names],
                       rows))
        self.chart("octets.svg", charts.bars(
            "Octets of request and reply", [
                (name, [both(ours[name]), both(others["giop_1_2"][name])] +
                 ([both(others["rtps_best_effort"][name], "octets_without_statistics")]
                  if "rtps_best_effort" in others else []))
                for name in OPERATIONS if name != "load_256"],
            ["GIOP/CAN", "GIOP 1.2"] + (["RTPS"] if "rtps_best_effort" in others else [])),
            "Octets of request and reply for each operation")
        self.can_costs(ours, others, names)
        self.size_bars(ours, others)

    def can_costs(self, ours, others, names):
        self.add("### On a classical CAN bus\n\n"
                 "Frames and bits of request and reply, 3 bits of intermission after each frame. *Bits* are those of the captured octets, with "
                 "their stuff bits; *at most* is the longest that frames of these lengths can be. The others are put into frames by ISO-TP "
                 "(ISO 15765-2), with normal addressing, no padding, one flow control frame and no "
                 "separation time: the least that it can take.")
        rows = []
        for name, title in OPERATIONS.items():
            rows.append([title, can(ours[name], "frames"), can(ours[name], "bits"),
                         can(ours[name], "worst_bits")] +
                        [f"{can_time(ours[name], rate):.2f}" for rate in ("125k", "500k", "1M")] +
                        [f"{can(others[peer][name], 'frames')} / "
                         f"{can(others[peer][name], 'bits')}" for peer in names])
        self.add(table(["operation", "frames", "bits", "at most", "ms at 125 kbit/s",
                        "at 500", "at 1000"] +
                       [f"{PEERS[n]}: frames / bits" for n in names], rows))
        self.chart("can_time.svg", charts.bars(
            "Milliseconds on a bus of 500 kbit/s", [
                (name, [can_time(ours[name], "500k"), can_time(others["giop_1_2"][name], "500k")] +
                 ([can_time(others["rtps_best_effort"][name], "500k")]
                  if "rtps_best_effort" in others else []))
                for name in OPERATIONS if name != "load_256"],
            ["GIOP/CAN", "GIOP 1.2, ISO-TP"] +
            (["RTPS, ISO-TP"] if "rtps_best_effort" in others else [])),
            "Milliseconds on a bus of 500 kbit/s for each operation")
        self.add("### CANopen and Cyphal, calculated\n\n"
                 "Not measured: calculated from the published formats, in the worst case of stuffing. CANopen (CiA 301): a call is an "
                 "SDO write of the parameters and, where there is a result, an SDO read; up to 4 octets expedited, more segmented; a "
                 "oneway call is a PDO. Cyphal/CAN 1.0: a service request and response with 29-bit identifiers. Both know the values' types beforehand, "
                 "as canorb does, and neither has an object behind the node: an index or a port takes its place.")
        rows = []
        for name, title in OPERATIONS.items():
            row = ours[name]
            rows.append([title, f"{can(row, 'frames')} / {can(row, 'worst_bits')}"] +
                        [f"{row[key]['frames']} / {row[key]['worst_bits']}"
                         for key in ("canopen_sdo_calculated", "cyphal_calculated")])
        self.add(table(["operation", "GIOP/CAN: frames / bits at most",
                        "CANopen SDO (calculated)", "Cyphal service (calculated)"], rows))

    def size_bars(self, ours, others):
        giop = others["giop_1_2"]
        part = both(ours["ping"]) / both(giop["ping"])
        self.bar("octets of a void call, request and reply", "1/5 of GIOP 1.2's",
                 f"{both(ours['ping'])} of {both(giop['ping'])}: {part:.3f}", part <= 0.2)
        lists = self.results.get("marshalling", {}).get("lists")
        if not lists:
            return
        rows = []
        worst = (0, "")
        for name, title in OPERATIONS.items():
            mine = both(ours[name], "header_octets") + both(ours[name], "sequence_octets")
            theirs = both(giop[name]) - sum(
                lists[part]["omniorb"]["octets"] if isinstance(part, str) else part
                for part in VALUES[name])
            frames = can(ours[name], "frames")
            rows.append([title, frames, mine, theirs, f"{mine / theirs:.3f}"])
            if frames <= 2:
                worst = max(worst, (mine / theirs, f"{name}: {mine} of {theirs}"))
        self.add("### What is not values\n\n"
                 "Headers and sequence octets of request and reply, against what GIOP 1.2 has around the CDR "
                 "encoding of the same values. An exception's id and members count as values on both sides.")
        self.add(table(["operation", "frames", "GIOP/CAN", "GIOP 1.2", "ratio"], rows))
        self.bar("what is not values, operations of up to two frames",
                 "1/5 of GIOP 1.2's envelope", f"at most {worst[0]:.3f} ({worst[1]})",
                 worst[0] <= 0.2)

    # ---- marshalling

    def marshalling(self):
        found = self.results.get("marshalling")
        if not found:
            return
        method = found["method"]
        self.add("## Encoding and decoding\n\n"
                 "Nanoseconds to encode + decode the argument lists of these operations; the ratio is canorb's sum divided by the faster peer's.\n\n" +
                 "\n".join(f"* {name.replace('_', ' ')}: {method[name]}"
                           for name in ("loop", "canorb", "omniorb", "fast_cdr", "check")))
        rows = []
        for name, values in found["lists"].items():
            row = [name]
            for side in ("canorb", "omniorb", "fast_cdr"):
                one = values[side]
                row.append(f"{one['encode_ns']:.1f} + {one['decode_ns']:.1f}")
            rows.append(row + [f"{values['ratio']:.2f}"])
        self.add(table(["list", "canorb", "omniORB", "Fast CDR", "ratio"], rows))
        self.chart("marshalling.svg", charts.bars(
            "Encode + decode, divided by the faster peer's (1.0: as fast)",
            [(name, [values["ratio"]]) for name, values in found["lists"].items()], ["canorb"],
            marker=1.0), "Ratio of canorb to the faster peer for each list")
        self.add("canorb's integers have a prefix that tells their length, and the shortest form is the only one: a comparison or two that CDR's "
                 "fixed places do not need, which shows in lists of one or two small values, where all three take a few nanoseconds. References are the other loss: canorb makes a "
                 "counted reference that can be called, Fast CDR copies a text.")
        above = {name: values["ratio"] for name, values in found["lists"].items()
                 if values["ratio"] > 1.0}
        self.bar("encode + decode, each list", "the faster peer's: 1.0",
                 "at most 1.0" if not above else
                 ", ".join(f"{name} {ratio:.2f}" for name, ratio in above.items()) +
                 f"; the other {len(found['lists']) - len(above)} at most 1.0", not above)

    # ---- calls

    def calls(self):
        found = self.results.get("calls")
        if not found:
            return
        ours = found
        self.add("## Two-way calls\n\n"
                 "The void call, one after the other, in microseconds. Client and server are threads (*in process*) or processes, pinned "
                 "to one CPU together or to one each; a daemon of canorb shares the server's. Fast DDS sends a sample and "
                 "waits for one back.")
        lines = [
            ("canorb, object of the own node", ours["in_process"]["own_object"], "in process"),
            ("canorb, virtual time, both in one thread", ours["in_process"]["virtual_time"],
             "in process"),
            ("canorb, `local:`", ours["in_process"]["local_one_cpu"], "in process, one CPU"),
            ("canorb, `local:`", ours["in_process"]["local_two_cpus"], "in process, two CPUs"),
            ("canorb, `sim:` unpaced", ours["processes"]["one_cpu"], "one CPU"),
            ("canorb, `sim:` unpaced", ours["processes"]["two_cpus"], "two CPUs"),
        ]
        for title in ("omniORB", "Fast DDS"):
            for key, row in self.results.get(f"calls of {title}", {}).items():
                transport, cpus = key.rsplit("_", 1)
                lines.append((f"{title}, {transport}", {
                    "min_ns": row["min"], "median_ns": row["median"], "p99_ns": row["p99"],
                    "p99_9_ns": row["p99_9"], "per_second": row["calls_per_second"]},
                    f"{cpus} CPU{'s' if cpus == 'two' else ''}"))
        self.add(table(["", "where", "min", "median", "p99", "p99.9", "calls/s"], [
            [title, where] + [microseconds(row[key])
                              for key in ("min_ns", "median_ns", "p99_ns", "p99_9_ns")] +
            [f"{row['per_second']:,.0f}"] for title, row, where in lines]))
        self.chart("calls.svg", charts.bars(
            "Median of a two-way call on one CPU, microseconds",
            [(title.replace("`", ""), [row["median_ns"] / 1000]) for title, row, where in lines
             if "two" not in where], ["median"]), "Medians of two-way calls")
        local = ours["in_process"]["local_one_cpu"]["median_ns"]
        peers = self.results.get("calls of omniORB")
        if peers:
            unix = peers["unix_one"]["median"]
            self.bar("two-way call in process, one CPU",
                     "1/2 of omniORB's on a Unix socket, one CPU",
                     f"{microseconds(local)} us of {microseconds(unix)} us: {local / unix:.2f}",
                     local / unix <= 0.5)
        self.paced(ours["paced"])

    def paced(self, paced):
        self.add("### On the paced bus\n\n"
                 "The void call beside bare frames: two programs without an ORB send each other, through the same daemon, the frames "
                 "that the call consists of. *Wire* is what the two frames take back to back; what a call takes more is software: the daemon, "
                 "two processes and two ORBs.")
        self.add(table(
            ["bit/s", "wire, us", "bare frames, us", "call, us", "calls of bare frames",
             "software, us", "wire's part"], [
                [f"{row['bitrate']:,}", microseconds(row["wire_ns"]),
                 microseconds(row["bare_frames"]["mean_ns"]), microseconds(row["calls"]["mean_ns"]),
                 f"{100 * row['calls_to_bare_frames']:.1f} %", microseconds(row["software_ns"]),
                 f"{100 * row['wire_part_of_call']:.1f} %"] for row in paced["round_trips"]]))
        self.add("Means; the better of three rounds each, by turns. Several clients, each with its "
                 "server, at 1 Mbit/s:")
        self.add(table(["pairs", "bus load", "calls/s"], [
            [row["pairs"], f"{row['load_percent']:.1f} %", f"{row['calls_per_second']:,.0f}"]
            for row in paced["pairs"]]))
        fast = next(row for row in paced["round_trips"] if row["bitrate"] == 1_000_000)
        self.bar("round trips of calls at 1 Mbit/s", "95 % of bare frames'",
                 f"{100 * fast['calls_to_bare_frames']:.1f} %",
                 fast["calls_to_bare_frames"] >= 0.95)
        four = next(row for row in paced["pairs"] if row["pairs"] == 4)
        self.bar("bus load by four pairs at 1 Mbit/s", "98 %", f"{four['load_percent']:.1f} %",
                 four["load_percent"] >= 98)

    # ---- real time

    def real_time(self):
        found = self.results.get("real_time")
        if not found:
            return
        urgent = found["scenarios"]["group_under_load"]
        self.add("## Response time under full load\n\n"
                 f"{urgent['messages']:,} calls of the most urgent group, while other nodes keep the simulated bus of "
                 f"{urgent['bitrate']:,} bit/s {urgent['load_percent']:.1f} % busy, against the worst case of the response time analysis by Davis, "
                 "Burns, Bril and Lukkien (*Controller Area Network (CAN) schedulability analysis: refuted, revisited and revised*, Real-Time Systems 35, "
                 "2007), with their formula for the longest frame.")
        self.add(table(["", "us"], [
            ["shortest", microseconds(urgent["min_ns"])],
            ["median", microseconds(urgent["median_ns"])],
            ["p99", microseconds(urgent["p99_ns"])],
            ["longest", microseconds(urgent["max_ns"])],
            ["bound", microseconds(urgent["bound_ns"])],
            ["above the bound", urgent["exceeded"]]]))
        counts = urgent["histogram"]["counts"]
        bucket = urgent["histogram"]["bucket_ns"] / 1000
        self.chart("response_time.svg", charts.histogram(
            "Response time of the most urgent call, under 100 % load", counts, bucket,
            "microseconds", [("bound", urgent["bound_ns"] / 1000),
                             ("longest seen", urgent["max_ns"] / 1000)]),
            "Histogram of response times")
        self.bar("the most urgent message above its bound", f"0 of {urgent['messages']:,}",
                 urgent["exceeded"], urgent["exceeded"] == 0)
        sets = [(name, found["scenarios"][name]) for name in found["scenarios"]
                if "streams" in found["scenarios"][name]]
        self.add("### Sets of periodic messages\n\n"
                 "Each stream's longest response against its own bound, at 125 kbit/s.")
        self.add(table(["set", "messages", "utilization", "above the bound",
                        "the analysis applies"], [
            [name.replace("_", " "), f"{row['messages']:,}",
             f"{row['utilization_percent']:.1f} %", row["exceeded"],
             "yes" if row["analysis_applies"] else "no"] for name, row in sets]))
        periodic = found["scenarios"]["periodic_set"]["streams"]
        self.add(table(["identifier", "node", "period, ms", "longest, us", "bound, us"], [
            [f"0x{row['identifier']:03X}", row["node"], f"{row['period_ns'] / 1e6:.1f}",
             microseconds(row["max_ns"]), microseconds(row["bound_ns"])] for row in periodic]))
        self.add("**A loss.** The analysis takes it that a node always offers its most urgent message to the bus. An ORB does not: it keeps at most "
                 "`frames_in_controller` frames (by default 2) in the controller, and does not take them back. When these "
                 "are less urgent ones, an urgent message of the same node waits until one of them got through, which under full load of others can be long: that is "
                 "the row with 2 frames. A node with urgent messages beside others raises `frames_in_controller` to the number of its streams, as in the row with 8.")

    # ---- cost

    def cost(self):
        cost = self.results.get("cost")
        if cost:
            self.add("## What it costs\n\nA minimal server after 1,000 void calls; text and data as size(1) "
                     "counts them, of the program and the peer's own libraries. canorb's is linked statically.")
            rows = []
            for name, title in (("canorb", "canorb"), ("omniorb", "omniORB"),
                                ("fastdds", "Fast DDS")):
                row = cost[name]
                rows.append([title, f"{row['text_and_data']:,}",
                             f"{row['peak_memory'] / 2**20:.1f}",
                             f"{row['anonymous_memory'] / 2**20:.1f}"])
            self.add(table(["", "text and data, octets", "peak memory, MiB",
                            "of it not of files, MiB"], rows))
        code = self.results.get("generated_code")
        if code:
            self.add("### Generated code\n\n" + table(
                ["bench/generated_code/gauge.idl", "canorb-idlc", "omniidl", "ratio"],
                [[name, f"{row['canorb']:.0f}", f"{row['omniorb']:.0f}", f"{row['ratio']:.2f}"]
                 for name, row in code.items()]))
        footprint = self.results.get("footprint")
        if footprint:
            self.add("### The engine, without a system below it\n\n"
                     "The layers from `orb/base` to `orb/core` at -Os, without exceptions and RTTI; "
                     "octets, with all functions, called or not.")
            targets = list(footprint)
            names = {"x86_64": "x86-64", "cortex_m4": "Cortex-M4"}
            self.add(table(["layer"] + [f"{names[t]}, text" for t in targets] +
                           [f"{names[t]}, data" for t in targets], [
                [layer] + [f"{footprint[t][layer]['text']:,}" for t in targets] +
                [f"{footprint[t][layer]['data']:,}" for t in targets]
                for layer in footprint[targets[0]]]))
        allocations = self.results.get("allocations")
        if allocations:
            self.add("### Allocations for each call, after start-up\n\n" + table(
                ["call", "caller", "servant", "bus"],
                [[name, f"{row['caller']:.2f}", f"{row['servant']:.2f}", f"{row['bus']:.2f}"]
                 for name, row in allocations.items()]))
        speed = self.results.get("bus_speed")
        if speed:
            self.add("### The simulated bus\n\n" + table(
                ["benchmark/nodes", "times real time", "bits a second"],
                [[row["name"], f"{row['times_real_time']:,.1f}", f"{row['bit/s']:,.0f}"]
                 for row in speed if "times_real_time" in row]))

    # ---- the document

    def document(self):
        for part in (self.sizes, self.marshalling, self.calls, self.real_time, self.cost):
            part()
        machine = self.results["machine"]
        versions = self.results["versions"]
        quick = " **This is a quick run: its figures are rough.**" if self.results["quick"] else ""
        head = [
            "# Benchmarks",
            "<!-- Made by bench/report.py from the results of ./run bench. Not to be edited. -->",
            f"Measured by `./run bench` in {self.results['seconds']['all'] / 60:.0f} minutes on "
            f"{machine['date']}: {machine['cpus']} CPUs of {machine['cpu']}, {machine['memory_gib']} "
            f"GiB, {machine['system']}, Linux {machine['kernel']}; load before it "
            f"{machine['load_before']:.1f}.{quick} Versions: " +
            ", ".join(f"{name} {version}" for name, version in versions.items()) + ".",
            "Absolute times wander with the machine and with the placement of threads, more so on a virtual one; ratios between programs that were measured in "
            "the same run are what to look at. `./run bench` repeats all of it and writes this document anew; "
            "its results, with every captured octet, are `build-release/bench/results.json`. "
            "`./run bench --quick` takes a minute or two.",
            "## Goals\n\n" + table(["", "goal", "measured", "met"],
                                               self.bars),
        ]
        head.append(
            "A goal met is not all there is to know:\n\n"
            "* Between processes canorb is slower than omniORB on a Unix socket, by far: each frame goes through the process that is the bus "
            "(*Two-way calls*). The goal compares threads of one process with two processes.\n"
            "* Each frame after the first has a sequence octet: what is not values is above a fifth of GIOP's in most operations of three frames or more "
            "(*What is not values*).\n"
            "* Cyphal's worst case takes fewer bits for most short calls (*CANopen and Cyphal*): its frames have no object key and no request number.\n"
            "* The most urgent message has its bound as long as its node does not send less urgent ones at the same time with the default of 2 frames in the controller "
            "(*Sets of periodic messages*). Response times are of the simulated bus, in its time: no software delays are in them.\n"
            "* canorb's libraries are linked statically, with only what is used; the peers' are shared, and counted whole (*What it costs*).\n"
            "* canorb is compiled with -O3 and its generated code with it; the peers' libraries are Debian's.")
        skipped = self.results["skipped"]
        if skipped:
            head.append("## Not measured\n\n" + "\n".join(
                f"* {name}: {reason}" for name, reason in skipped.items()))
        return "\n\n".join(head + self.text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results")
    parser.add_argument("document")
    options = parser.parse_args()
    directory = os.path.splitext(options.document)[0]
    os.makedirs(directory, exist_ok=True)
    with open(options.results, encoding="utf-8") as file:
        results = json.load(file)
    text = Report(results, directory).document()
    with open(options.document, "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    main()
