"""The packages of package-lock.json run with the Node.js of Debian 12, which is 18.

  packages_test.py PACKAGE_LOCK
"""

import json
import re
import sys

DEBIANS_NODE = 18
# Plain JavaScript that says it needs more; the tests that use it pass with 18.
RUN_WITH_IT = {"node_modules/@foxglove/rosmsg2-serialization"}


def oldest(engines):
    """The lowest major version that a range like ">=18" or ">= 14 || ^12" accepts; 0: any."""
    return min((int(number) for number in re.findall(r"(\d+)(?:\.\d+)*", engines.replace(" ", ""))), default=0)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        packages = json.load(file)["packages"]
    needs = {name: package.get("engines", {}).get("node", "") for name, package in packages.items()}
    too_new = [f"{name} needs Node.js {node}" for name, node in needs.items() 
               if oldest(node) > DEBIANS_NODE and name not in RUN_WITH_IT]
    print("\n".join(too_new) or f"{len(needs)} packages run with Node.js {DEBIANS_NODE}")
    return 1 if too_new else 0


sys.exit(main())
