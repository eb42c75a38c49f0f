#!/usr/bin/env python3
"""What a user's source pays for a header of Musher: its lines after the preprocessor.

    header_budget_test.py COMPILER INCLUDE_FOLDER

A header that grows past its budget has probably included a library that belongs in a .cpp file. Lines without
spaces and comments, GCC 12, of which the standard library's <string>, <vector> and <functional> alone are 30,000.
None of them may lead to a header of the inside, which would be installed with it.
"""
import re
import subprocess
import sys

BUDGET_LINES = {
    "base/result.hpp": 24_000,
    "base/log.hpp": 24_000,
    "base/toml/document.hpp": 27_000,
    "base/time.hpp": 34_000,
    "lifecycle/state.hpp": 33_000,
    "lifecycle/config/config.hpp": 63_000,
    "behavior/fsm/machine.hpp": 63_000,
    "behavior/tree/tree.hpp": 74_000,
    "transport/node.hpp": 72_000,
    "transport/dds/dds_node.hpp": 72_000,
    "actuator/machine_actuator.hpp": 73_000,
    "controller/machine_controller.hpp": 73_000,
    "application/fsm_actuator.hpp": 73_000,
    "application/skill_actuator.hpp": 74_000,
    "application/tree_actuator.hpp": 83_000,
    "simulation/actuator_fault_test.hpp": 81_000,
}


# Nothing of these is for a robot's project: the inside of the controller and of an actuator, the simulated robot.
INSIDE = re.compile(r"/musher/(controller/(journal|process|shell|storage)/|cli/|view/|ota/|"
                    r"actuator/(actuator_shell|callback_harness|worker)|"
                    r"simulation/(checker|injection|module_under_test|processes|robot|scenario|search)\.)")


def preprocessed(header, compiler, folders):
    """Its lines of code, and the files of Musher that it includes."""
    source = f'#include "musher/{header}"\n'
    run = subprocess.run([compiler, "-std=c++20", "-E", *("-I" + folder for folder in folders), "-x", "c++", "-"], input=source,
                         capture_output=True, text=True, check=True)
    lines = run.stdout.splitlines()
    files = {line.split('"')[1] for line in lines if line.startswith("# ") and "/musher/" in line}
    return sum(1 for line in lines if line.strip() and not line.startswith("#")), files


def main():
    compiler, *folders = sys.argv[1:]
    version = subprocess.run([compiler, "-dumpversion"], capture_output=True, text=True, check=True).stdout.strip()
    is_limited = version.split(".")[0] == "12"
    if not is_limited:
        print(f"the budgets are of GCC 12's standard library; this is {version}: only what is included is checked")
    exceeded = 0
    for header, budget in BUDGET_LINES.items():
        lines, files = preprocessed(header, compiler, folders)
        print(f"{lines:7,} of {budget:7,} lines: {header}")
        if is_limited and lines > budget:
            exceeded += 1
            print(f"{header}: {lines:,} lines after the preprocessor, its budget is {budget:,}: "
                  "include the new library in a .cpp file", file=sys.stderr)
        for file in sorted(filter(INSIDE.search, files)):
            exceeded += 1
            print(f"{header}: includes {file}, which is not for a robot's project: put it behind a pointer",
                  file=sys.stderr)
    return 1 if exceeded else 0


sys.exit(main())
