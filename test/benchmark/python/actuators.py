"""A switch of a machine whose actuators are in Python, beside one whose actuators are in C++; their callbacks do nothing.

    actuators.py [COUNT] [SWITCHES]

Both machines are up, and are switched in turn. Prints medians and quartiles of a switch as its client sees it, and of
the slowest actuator's callback as the controller does. $PATH has `musher` and `benchmark_actuator`.
"""

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import musher

PROGRAM = """
import sys
import musher

class Idle(musher.Actuator):
    def on_state(self, state: str) -> None: pass

musher.run(Idle(sys.argv[1]))
"""
STATES = '["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]'


def write_config(folder, kind, count):
    names = [f"{kind}_{i}" for i in range(count)]
    command = {"python": [sys.executable, os.path.join(folder, "idle.py")],
               "cpp": [shutil.which("benchmark_actuator")]}[kind]
    with open(os.path.join(folder, "idle.py"), "w", encoding="utf-8") as file:
        file.write(PROGRAM)
    text = (f'[controller]\nname = "{kind}"\nnamespace = "{kind}"\nstate_dir = "{kind}_state"\nstates = {STATES}\n'
            f"actuators = {names}\ndefault_time = 60000\ndefault_state = \"Uninitialized\"\n".replace("'", '"'))
    for name in names:
        text += (f"[actuator.{name}]\nstates = {STATES}\ntimes = [60000, 9000, 9000, 9000, 9000]\ncritical = true\n"
                 f"command = {command + [name]}\n".replace("'", '"'))
    path = os.path.join(folder, f"{kind}.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def row(name, values):
    quartiles = statistics.quantiles(values, n=4)
    return f"{name}: {quartiles[1]:.2f} ms ({quartiles[0]:.2f} to {quartiles[2]:.2f}), longest {max(values):.1f}"


def main():
    count, switches = (int(given or default) for given, default in zip((sys.argv[1:] + ["", ""])[:2], ("10", "100")))
    folder = tempfile.mkdtemp(prefix="musher-benchmark-")
    launchers, machines = [], {}
    try:
        for kind in ("cpp", "python"):
            config = write_config(folder, kind, count)
            with open(os.path.join(folder, f"{kind}.err"), "w", encoding="utf-8") as err:
                launchers.append(subprocess.Popen(["musher", "up", config], stdout=err, stderr=err))
            machines[kind] = musher.Machine(config)
            machines[kind].wait_until("Active", 120)
        took = {kind: [] for kind in machines}
        slowest = {kind: [] for kind in machines}
        for i in range(switches):
            for kind, machine in machines.items():
                begun = time.monotonic()
                outcome = machine.set("LowPower" if i % 2 == 0 else "Active")
                took[kind].append((time.monotonic() - begun) * 1e3)
                slowest[kind].append(max(one.duration_ms for one in outcome.actuators))
        for kind in machines:
            print(row(f"{count} actuators in {kind}, a switch", took[kind]))
            print(row("    its slowest actuator", slowest[kind]))
        ratios = [python / cpp for python, cpp in zip(took["python"], took["cpp"])]
        quartiles = statistics.quantiles(ratios, n=4)
        print(f"python / cpp: {quartiles[1]:.2f} ({quartiles[0]:.2f} to {quartiles[2]:.2f})")
    finally:
        for kind, machine in machines.items():
            subprocess.run(["musher", "--namespace", kind, "down"], stdout=subprocess.DEVNULL, check=False)
            machine.close()
        for launcher in launchers:
            try:
                launcher.wait(30)
            except subprocess.TimeoutExpired:
                launcher.terminate()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
