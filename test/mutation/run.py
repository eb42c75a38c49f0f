#!/usr/bin/python3
"""Runs the tests once for each mutant of the decision code and reports which of them no test detects.

Only tests that come by a mutant can notice it, so only those are run, in three stages: the unit
tests, then the random walk, then the simulated robots. The first failure, crash or hang ends it.
Survivors that cannot be noticed are in equivalent.json, each with the reason.
"""
import argparse
import concurrent.futures
import json
import os
import resource
import subprocess
import sys
import time
from collections import Counter

HERE = os.path.dirname(os.path.abspath(__file__))
WALK = "RandomWalk.LeavesEveryActuatorInItsStateAndAnswersEveryRequest"
FAULTS = "*/Scenarios.HoldEveryInvariant/*"
MIXED = "SeededFaultsAmongProtocols.LeaveTheMachineInOneStateAfterTheFaultsEnd"
MEMORY = 2 << 30  # bytes, of one run; a mutant may want more and more


class Runs:
    def __init__(self, options, build):
        self.program = os.path.join(build, "bin/mutation_tests")
        self.folder = os.path.join(build, "test/mutation")
        self.seeds = {WALK: options.walks, FAULTS: options.robots, MIXED: options.robots // 5}
        with open(os.path.join(self.folder, "lifecycle/mutants.json")) as file:
            read = json.load(file)
        self.possible, self.seed, self.mutants = read["possible"], read["seed"], read["mutants"]

    def run(self, tests, mutant=0, seeds=0, limit=60.0, reached=None):
        """(exit code, None for a hang; the output; seconds)"""
        environment = dict(os.environ, MUSHER_MUTANT=str(mutant), MUSHER_SEEDS=str(seeds))
        if reached:
            environment["MUSHER_MUTANTS_REACHED"] = reached
        begun = time.monotonic()
        try:
            end = subprocess.run(
                [self.program, "--gtest_fail_fast", "--gtest_brief=1",
                 "--gtest_filter=" + tests],
                env=environment, timeout=limit, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                errors="replace",
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)))
            return end.returncode, end.stdout, time.monotonic() - begun
        except subprocess.TimeoutExpired:
            return None, "", limit

    def look(self):
        """Which tests come by which mutants, and how long each stage takes without one."""
        self.by, self.stages = {}, []
        path = os.path.join(self.folder, "reached.txt")
        others = "*-Scenarios.*:" + ":".join(self.seeds)
        for tests, seeds in [(others, 0), *self.seeds.items()]:
            code, output, took = self.run(tests, seeds=seeds, limit=600, reached=path)
            if code != 0:
                sys.exit("the tests fail without a mutant:\n" + output[-3000:])
            names = []
            with open(path) as file:
                for line in file:
                    name, _, *numbers = line.split()
                    names.append(name)
                    for number in numbers:
                        self.by.setdefault(int(number), set()).add(name)
            self.stages.append((names, seeds, took))

    def evaluate(self, mutant):
        """How it ends, by which test, and what that says."""
        reaching = self.by.get(mutant["number"], set())
        if not reaching:
            return "survives", "no test comes by it", ""
        for names, seeds, took in self.stages:
            tests = [name for name in names if name in reaching]
            if not tests:
                continue
            code, output, _ = self.run(":".join(tests), mutant["number"], seeds, limit=10 * took + 5)
            if code is None:
                return "hangs", tests[0] if len(tests) == 1 else "one of the tests", ""
            if code != 0:
                failed = [line.split("]")[1].split("(")[0].split(",")[0].strip()
                          for line in output.splitlines() if line.startswith("[  FAILED  ]")]
                return ("fails" if failed else "crashes"), (failed or ["?"])[0], output
        return "survives", f"{len(reaching)} tests come by it", ""


def key(mutant):
    return tuple(" ".join(mutant[k].split()) for k in ("file", "function", "original", "mutated"))


def load_equivalent():
    with open(os.path.join(HERE, "equivalent.json")) as file:
        entries = json.load(file)
    gone = [f"{e['file']} {e['function']}: {e['original']}" for e in entries if not exists(e)]
    if gone:
        sys.exit("equivalent.json: no such place any more; correct or remove it:\n" +
                 "\n".join(gone))
    return {key(e): e["reason"] for e in entries}


def exists(entry):
    try:
        with open(os.path.join(HERE, "..", "..", entry["file"])) as file:
            text = "".join(file.read().split())
    except FileNotFoundError:
        return False
    return f"{entry['function']}(" in text and "".join(entry["original"].split()) in text


def report(runs, results, equivalent, path):
    ends = Counter(r["end"] for r in results)
    same = [r for r in results if r["end"] == "survives" and r["reason"]]
    left = [r for r in results if r["end"] == "survives" and not r["reason"]]
    killed = len(results) - ends["survives"]
    score = 100.0 * killed / max(1, len(results) - len(same))
    summary = {"possible": runs.possible, "seed": runs.seed, "mutants": len(results),
               "killed": killed, "equivalent": len(same), "survivors": len(left),
               "score_percent": round(score, 1),
               "raw_score_percent": round(100.0 * killed / max(1, len(results)), 1)}
    with open(path + ".json", "w") as file:
        json.dump({"summary": summary, "results": results}, file, indent=1)
    with open(path + ".md", "w") as file:
        say = lambda text="": print(text, file=file)
        say("# Mutants of the decision code\n")
        say(f"{len(results)} of {runs.possible} possible ones, drawn by seed {runs.seed}: {killed} "
            f"noticed ({ends['fails']} by a failing test, {ends['crashes']} by a crash, "
            f"{ends['hangs']} by a hang), {len(same)} that change nothing, {len(left)} survivors. "
            f"Score: **{score:.1f} %** of those that change something.\n")
        say("| file | mutants | noticed | change nothing | survivors |\n|---|---|---|---|---|")
        for name in sorted({r["file"] for r in results}):
            of = [r for r in results if r["file"] == name]
            say(f"| {name} | {len(of)} | {sum(r['end'] != 'survives' for r in of)} "
                f"| {sum(r in same for r in of)} | {sum(r in left for r in of)} |")
        for title, some in (("Survivors", left), ("Change nothing", same)):
            say(f"\n## {title}\n")
            for r in some:
                was, becomes = (" ".join(r[k].split()) for k in ("original", "mutated"))
                say(f"- {r['number']}: {r['file']}:{r['line']} `{r['function']}`, {r['kind']}: "
                    f"`{was}` → `{becomes or '(nothing)'}`; {r['reason'] or r['by']}")
    return summary


def main():
    parser = argparse.ArgumentParser(prog="scripts/mutate", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument("--walks", type=int, default=100, help="seeds of the random walk")
    parser.add_argument("--robots", type=int, default=50, help="seeds of the simulated robots")
    parser.add_argument("--only", default="", help="numbers of mutants, with commas")
    options = parser.parse_args()
    runs = Runs(options, os.path.join(os.path.dirname(os.path.dirname(HERE)), "build/dev"))
    runs.look()
    equivalent = load_equivalent()
    only = {int(n) for n in options.only.split(",") if n}
    mutants = [m for m in runs.mutants if not only or m["number"] in only]
    results = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for mutant, (end, by, output) in zip(mutants, pool.map(runs.evaluate, mutants)):
            reason = equivalent.get(key(mutant), "") if end == "survives" else ""
            results.append(dict(mutant, end=end, by=by, reason=reason))
            if only or (end == "survives" and not reason):
                print(f"{mutant['number']} {end}: {mutant['file']}:{mutant['line']} "
                      f"{mutant['original']!r} → {mutant['mutated']!r} ({by})", flush=True)
            if only:
                print(output[-3000:])
    name = "report" if not only else "report_of_some"
    summary = report(runs, results, equivalent, os.path.join(runs.folder, name))
    print(json.dumps(summary))
    return 1 if summary["survivors"] else 0


if __name__ == "__main__":
    sys.exit(main())
