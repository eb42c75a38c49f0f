"""scripts/proof: what is done is kept and continued, and what was found is reported."""

import importlib.machinery
import importlib.util
import json
import pathlib
import tempfile
import unittest
from unittest import mock

SCRIPT = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts/proof"
LOADER = importlib.machinery.SourceFileLoader("proof", str(SCRIPT))
proof = importlib.util.module_from_spec(importlib.util.spec_from_loader("proof", LOADER))
LOADER.exec_module(proof)


class Programs:
    """Fakes of the programs that scripts/proof runs: they find what the test says."""

    def __init__(self):
        self.calls, self.output, self.code = [], {"musher": '{"result": "proved"}'}, {}
        self.faults_failed = 0

    def __call__(self, words, environment):
        name = pathlib.Path(words[0]).name
        self.calls.append((name, words[1:], environment))
        if name == "fault_injection" and name not in self.code:
            report = pathlib.Path(words[words.index("--report") + 1])
            report.mkdir(parents=True)
            count = int(words[words.index("--faults") + 1])
            (report / "report.json").write_text(json.dumps({"count": count, "failed": self.faults_failed}))
        return self.code.get(name, 0), self.output.get(name, "")

    def of(self, name):
        return [call for call in self.calls if call[0] == name]


class ProofOfARelease(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.programs = Programs()

    def proof_of(self, commit, **more):
        return proof.Proof(self.folder.name, commit, self.programs, jobs=1, **more)

    def first_seeds(self):
        return [int(call[2]["MUSHER_FIRST"]) for call in self.programs.of("simulation_test")]

    def test_seeds_continue_where_the_last_run_ended(self):
        self.proof_of("a").seeds()
        firsts = self.first_seeds()
        self.assertEqual(firsts[0], 1)
        self.assertEqual(len(firsts), proof.AIMS["seeds"] // proof.SEEDS_OF_STEP)
        self.proof_of("a").seeds()
        self.assertEqual(self.first_seeds(), firsts, "all were done")
        self.proof_of("b").seeds()
        self.assertEqual(self.first_seeds()[len(firsts)], 1, "another commit")

    def test_nothing_begins_after_the_deadline(self):
        late = self.proof_of("a", deadline=0)
        for part in proof.PARTS:
            getattr(late, part)()
        self.assertEqual(self.programs.calls, [])

    @mock.patch.dict(proof.AIMS, seeds=proof.SEEDS_OF_STEP)
    def test_seeds_that_violate_an_invariant_are_listed_once(self):
        self.programs.code["simulation_test"] = 1
        self.programs.output["simulation_test"] = "replay with: MUSHER_SEED=17 …\nMUSHER_SEED=17 MUSHER_ONLY=3\n"
        one = self.proof_of("a")
        one.seeds()
        self.assertEqual(one.violations(), ["seed 17 violates an invariant"])

    def test_a_program_without_a_result_counts_as_not_run(self):
        for name in ("simulation_test", "fault_injection", "fuzz"):
            self.programs.code[name] = -11
        self.programs.output["musher"] = ""
        one = self.proof_of("a")
        for part in proof.PARTS:
            getattr(one, part)()
        self.assertEqual(len(one.without_result), len(proof.CONFIGS) + 4)
        self.assertEqual(one.violations(), [])
        figures = one.figures()
        self.assertEqual([figures[key] for key in ("seeds", "faults", "mutants_percent", "fuzz_cpu_hours")], [0] * 4)
        self.programs.code.clear()
        again = self.proof_of("a")
        again.seeds()
        again.faults()
        self.assertEqual(again.figures()["seeds"], proof.AIMS["seeds"])
        self.assertEqual(again.figures()["faults"], proof.AIMS["faults"])

    def test_faults_add_up_with_another_seed_for_each_step(self):
        self.programs.faults_failed = 1
        one = self.proof_of("a")
        one.faults()
        seeds = [words[words.index("--seed") + 1] for _, words, _ in self.programs.of("fault_injection")]
        self.assertEqual(len(set(seeds)), proof.AIMS["faults"] // proof.FAULTS_OF_STEP)
        self.assertEqual(one.violations(), ["10 of 1000 injected faults failed"])

    def test_hours_of_fuzzing_add_up_over_commits(self):
        self.proof_of("a").fuzz()
        hours = self.proof_of("b").figures()["fuzz_cpu_hours"]
        self.assertGreaterEqual(hours, proof.AIMS["fuzz"])
        self.assertLess(hours, proof.AIMS["fuzz"] + 1)

    def test_a_fuzzer_that_has_failed_runs_again_with_another_commit(self):
        targets = sorted(path.name for path in (proof.TREE / "test/fuzz/corpus").iterdir())
        self.programs.code["fuzz"] = 1
        self.programs.output["fuzz"] = "".join(f"scripts/fuzz: {name} has failed; see …\n" for name in targets)
        one = self.proof_of("a")
        one.fuzz()
        self.assertEqual(sorted(one.state["fuzz"]["failed"]), targets, "each once")
        self.assertEqual(one.figures()["fuzz_cpu_hours"], 0)
        self.assertEqual(self.proof_of("b").violations(), [])

    def test_the_report_has_the_figures_before(self):
        docs = pathlib.Path(self.folder.name) / "docs"
        one = self.proof_of("a")
        one.report(docs)
        one.seeds()
        one.report(docs)
        text = (docs / "report.md").read_text()
        self.assertIn("| simulated scenarios | 1000000 | 1,000,000 | yes | 0 |", text)
        self.assertIn("| injected faults, real processes | 0 | 1,000 | no | 0 |", text)
        self.assertIn("No violation was found.", text)
        self.assertEqual(len((docs / "figures.csv").read_text().splitlines()), 3)

    def test_configs_that_were_not_tried_are_not_proved(self):
        one = self.proof_of("a")
        one.state["configs"] = {proof.CONFIGS[0].stem: "proved"}
        one.report(self.folder.name)
        self.assertIn(f"| 1 of {len(proof.CONFIGS)} | all | no |",
                      (pathlib.Path(self.folder.name) / "report.md").read_text())

    def test_a_report_is_of_the_commit_that_was_run(self):
        one = self.proof_of("a")
        one.seeds()
        self.assertEqual(self.proof_of(None).figures(), one.figures())

    def test_the_score_of_the_mutants_is_that_of_their_summary(self):
        summary = {"possible": 9, "seed": 1, "mutants": 9, "score_percent": 91.5}
        self.programs.output["mutate"] = "12 survives: a.cpp:3\n" + json.dumps(summary) + "\n"
        one = self.proof_of("a")
        one.mutants()
        self.assertEqual(one.figures()["mutants_percent"], 91.5)


if __name__ == "__main__":
    unittest.main()
