#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the plan chooses, beside what a sweep found: choices.py BUILD SWEEP [OUT.json]

SWEEP is a folder that `strata sweep` completed on this machine, with the same cache. Of its first case
it measures, interleaved, each in a process of its own with the camera turned by a degree a frame:

* the plan without any option, beside the sweep's fastest exact configurations;
* --tolerance 1/255, beside the sweep's cheapest configurations whose certificate is below it;
* --budget, for several shares of the fastest exact time, which is measured anew before each: whether it is
  met within 15 % after at most ten frames, by all of them and by those with the setting that most of the last
  plan's last frames had, and what is certified with that, beside the best that the sweep knows for so much time. Those of
  its configurations that nothing else beats in both time and certificate the five around the budget, three of
  them below it, if there are as many, are measured again for that, right after, in two rounds, interleaved with what the plan ended with: as much as that is slower or faster then than
  it was in the sequence (`pace`), so are they. Null where none of them is in time in both rounds, itself without
  those 15 %: the budget may be more than the device can meet.

What the processors lost to other machines on the same host, where Linux says so, is the share `stolen`: what
is measured while that is more than 2 % is measured again, up to ten times, and the least disturbed is taken.
A budget whose `pace` is 1.2 or more, or its inverse, is asked for again, up to three times: `doubted` has those.

Prints JSON; the ratios are what counts.
"""
import json
import os
import shlex
import statistics
import subprocess
import sys
import tempfile

TOLERANCE = 0.00392
ROUNDS, FRAMES, WARMUP = 4, 6, 2
BEST = 4  # configurations beside the plan's: the sweep's own order rests on few frames
BUDGET_FRAMES, SETTLED, LAST = 28, 10, 8
SHARES = (1.3, 0.9, 0.8, 0.7, 0.6, 0.5, 0.35, 0.25)
WITHIN = 1.15
STOLEN, TRIES = 0.02, 10
PACE, BUDGETS = 1.2, 3
BELOW, ABOVE = 3, 2  # points around a budget


def processors():
    """Ticks that were worked, and that were stolen, since the machine started; zeros where nobody tells."""
    try:
        with open("/proc/stat") as file:
            ticks = [int(word) for word in file.readline().split()[1:9]]
    except OSError:
        return 0, 0
    return ticks[0] + ticks[1] + ticks[2], ticks[7]


def undisturbed(measure):
    """What measure() gives while little is stolen, and the share that was."""
    best = None
    for _ in range(TRIES):
        before = processors()
        result = measure()
        worked, stolen = (after - earlier for after, earlier in zip(processors(), before))
        share = stolen / (worked + stolen) if stolen else 0.0
        if best is None or share < best[1]:
            best = result, share
        if share <= STOLEN:
            break
    return best


class Strata:
    def __init__(self, build, folder):
        self.program = os.path.join(build, "bin", "strata")
        self.folder = folder

    def render(self, command, *more, turn=True):
        """The account of a rendering; the command is the sweep's, without its output."""
        account, picture = (os.path.join(self.folder, name) for name in ("account.json", "out.exr"))
        line = [self.program] + command + list(more) + ["--account", account, "-o", picture]
        if turn:
            line += ["--set", "frame.turn=1"]
        done = subprocess.run(line, capture_output=True, text=True)
        if done.returncode not in (0, 3):
            raise SystemExit(f"{shlex.join(line)}\n{done.stderr}")
        with open(account) as file:
            return json.load(file) | {"status": done.returncode}

    def times(self, command):
        frames = undisturbed(lambda: self.render(command, "--repeat", str(FRAMES + WARMUP))["frames"])[0]
        return [f["ms"] for f in frames[WARMUP:]]


def command_of(configuration):
    words = shlex.split(configuration["command"])
    at = words.index("-o")
    return words[1:at] + words[at + 2:]


def chosen(account):
    return " + ".join(t["technique"] + "".join(f" {k}={v}" for k, v in sorted(t["settings"].items()))
                      for t in account["plan"])


def race(strata, commands, rounds=ROUNDS):
    """Median milliseconds of each command, interleaved."""
    times = {name: [] for name in commands}
    for i in range(rounds):
        names = list(commands) if i % 2 == 0 else list(commands)[::-1]
        for name in names:
            times[name] += strata.times(commands[name])
    return {name: statistics.median(values) for name, values in times.items()}


def beside(strata, own, candidates):
    commands = {"own": own} | {c["name"]: command_of(c) for c in candidates}
    ms = race(strata, commands)
    fastest = min((n for n in ms if n != "own"), key=ms.get)
    return {"own_ms": ms["own"], "ms": {n: v for n, v in ms.items() if n != "own"}, "fastest": fastest,
            "ratio": ms["own"] / ms[fastest]}


def largest_bound(account):
    bound = account["bound"]
    return bound["max"] if bound and bound["max"] is not None else None


def front(certified):
    """What nothing else beats in both time and certificate, fastest first."""
    points, least = [], float("inf")
    for c in sorted(certified, key=lambda c: (c["ms"], c["bound"]["max"])):
        if c["bound"]["max"] < least:
            points.append(c)
            least = c["bound"]["max"]
    return points


def around(points, ms):
    """Of a front the points next to a time, in the sweep's own pace."""
    at = sum(c["ms"] <= ms for c in points)
    return [c for c in points[max(at - BELOW, 0):at + ABOVE] if c["ms"] <= 2 * ms]


def settings_of(account, value):
    """With `value` for what the budget turns."""
    turned = account["budget"]["technique"], account["budget"]["knob"]
    used = ["--use", ",".join(t["technique"] for t in account["plan"] if t["stage"] != "draws")]
    for t in account["plan"]:
        for knob, set_to in t["settings"].items():
            now = int(value) if value and (t["technique"], knob) == turned else set_to
            used += ["--set", f"{t['technique']}.{knob}={now}"]
    return used


def budget(strata, own, reference, share, points):
    """A sequence of frames with a budget, and what the sweep's points take right after it, in its pace."""
    def frames_within():
        ms = share * statistics.median(strata.times(reference) + strata.times(reference))
        return ms, strata.render(own + ["--budget", f"{ms:.4g}"], "--repeat", str(BUDGET_FRAMES))

    (asked, account), stolen = undisturbed(frames_within)
    course = account["budget"]["frames"]
    frames = [f["ms"] for f in course]
    ended_with = [f for f in course[-LAST:] if f["plan"] == course[-1]["plan"]]
    value = statistics.mode(f["value"] for f in ended_with)
    last = statistics.median([f["ms"] for f in ended_with if f["value"] == value and f["judged"]] or frames[-1:])
    settled = max(statistics.median(frames[SETTLED:]), last)
    ended = own + settings_of(account, value)
    commands, rounds = [("ended", ended)] + [(c["name"], command_of(c)) for c in points], []
    for order in commands, commands[::-1]:
        ms = race(strata, dict(order), 1)
        slower = last / ms["ended"]
        rounds.append({name: slower * t for name, t in ms.items()} | {"ended": ms["ended"]})
    pace = last / statistics.mean(r.pop("ended") for r in rounds)
    ms = {name: [r[name] for r in rounds] for name in rounds[0]}
    within = [c for c in points if max(ms[c["name"]]) <= asked]
    best = min(within, key=lambda c: c["bound"]["max"], default=None)
    bound = largest_bound(strata.render(ended, "--bound", os.path.join(strata.folder, "b.exr"), turn=False))
    return {"share": share, "asked_ms": asked, "frames_ms": frames, "settled_ms": settled,
            "of_budget": settled / asked, "met": settled <= WITHIN * asked,
            "plans": account["budget"]["plans"], "course": [[f["plan"], f["value"]] for f in course], "chosen": chosen(account), "value": value, "certified": bound,
            "stolen": stolen, "pace": pace, "points_ms": ms,
            "sweep_knows": best and {"name": best["name"], "ms": max(ms[best["name"]]),
                                     "certified": best["bound"]["max"]},
            "of_best": bound / best["bound"]["max"] if bound and best else None}


def believed(strata, own, reference, share, points):
    doubted = []
    while True:
        one = budget(strata, own, reference, share, points)
        if 1 / PACE < one["pace"] < PACE or len(doubted) + 1 == BUDGETS:
            return one | {"doubted": doubted}
        doubted.append({"pace": one["pace"], "of_budget": one["of_budget"], "certified": one["certified"]})


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit("usage: choices.py BUILD SWEEP [OUT.json]")
    with open(os.path.join(sys.argv[2], "results.json")) as file:
        results = json.load(file)
    one = results["cases"][0]
    measured = [c for c in one["configurations"] if c["state"] == "measured"]
    own = command_of(next(c for c in measured if not c["use"]))
    named = [c for c in measured if c["use"] and "floor" not in c["use"].split(",")]
    exact = sorted((c for c in named if c["exact"]), key=lambda c: c["ms"])
    certified = [c for c in named if c["bound"] and c["bound"]["max"] is not None]
    within = sorted((c for c in certified if c["bound"]["max"] <= TOLERANCE), key=lambda c: c["ms"])
    with tempfile.TemporaryDirectory() as folder:
        strata = Strata(sys.argv[1], folder)
        plan = beside(strata, own, exact[:BEST])
        plan["chosen"] = chosen(strata.render(own))
        tolerated = own + ["--tolerance", str(TOLERANCE)]
        tolerance = beside(strata, tolerated, within[:BEST])
        account = strata.render(tolerated, turn=False)
        tolerance |= {"chosen": chosen(account), "status": account["status"], "certified": largest_bound(account)}
        reference = command_of(next(c for c in exact if c["name"] == plan["fastest"]))
        points = front(certified)
        budgets = [believed(strata, own, reference, share, around(points, share * exact[0]["ms"]))
                   for share in SHARES if points and points[0]["ms"] <= share * exact[0]["ms"]]
    text = json.dumps({"scene": one["scene"], "size": one["size"], "device": results["device"], "plan": plan,
                       "tolerance": tolerance, "budgets": budgets}, indent=1)
    print(text)
    if len(sys.argv) == 4:
        with open(sys.argv[3], "w") as file:
            file.write(text + "\n")


if __name__ == "__main__":
    main()
