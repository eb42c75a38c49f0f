#!/usr/bin/env python3
"""Tests that scripts/demo takes a DDS domain without processes of this host."""
import re
import socket
import subprocess
import sys

DISCOVERY_PORT = 7400
PORTS_PER_DOMAIN = 250


def free_domain(first):
    with open(sys.argv[1], encoding="utf-8") as script:
        function = re.search(r"^free_domain\(\) \{.*?^\}", script.read(), re.M | re.S).group()
    done = subprocess.run(["bash", "-c", f"{function}\nfree_domain {first}"],
                          capture_output=True, text=True, check=True)
    return int(done.stdout)


def occupy(domain):
    """A socket such as a participant of the domain has."""
    occupied = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    occupied.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    occupied.bind(("", DISCOVERY_PORT + PORTS_PER_DOMAIN * domain))
    return occupied


first = free_domain(40)
with occupy(first):
    second = free_domain(first)
    assert second != first, f"domain {first} is in use, and was taken"
    with occupy(second):
        third = free_domain(first)
        assert third not in (first, second), f"domain {third} is in use, and was taken"
assert 1 <= free_domain(100) <= 100
