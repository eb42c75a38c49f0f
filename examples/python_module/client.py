#!/usr/bin/python3
"""client.py: prints each state of the machine. client.py STATE: sets the state, and prints the outcome."""

import sys

import musher


def follow(machine: musher.Machine) -> None:
    last = ""
    for status in machine.watch():
        if status.state != last:
            print(status.state, flush=True)
        last = status.state


def set_state(machine: musher.Machine, state: str) -> int:
    try:
        outcome = machine.set(state)
    except musher.Failure as failure:  # refused, undone, or no controller: the reason says what to do
        print(f"client.py: {failure.reason}", file=sys.stderr)
        return 1
    print(f"{outcome.outcome}, the machine is in {outcome.state}")
    return 0


if __name__ == "__main__":
    with musher.Machine("robot.toml") as robot:
        if len(sys.argv) == 2:
            sys.exit(set_state(robot, sys.argv[1]))
        follow(robot)
