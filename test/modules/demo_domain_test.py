#!/usr/bin/env python3
"""Tests that scripts/demo takes a DDS domain without processes of this host, and keeps it.

    demo_domain_test.py SCRIPTS_DEMO
"""
import re
import socket
import subprocess
import sys

DISCOVERY_PORT = 7400
PORTS_PER_DOMAIN = 250

root = sys.argv[1].rpartition("/scripts/")[0]
with open(sys.argv[1], encoding="utf-8") as script:
    text = script.read()
lock_domain = re.search(r"^lock_domain\(\) \{.*?^\}", text, re.M | re.S).group()
lcm_urls = re.search(r"^lcm_urls\(\) \{.*?^\}", text, re.M | re.S).group()


class Demo:
    """A shell that takes a domain as a demo does, and lives until its input ends."""

    def __init__(self, first):
        self.process = subprocess.Popen(
            ["bash", "-c", f"root='{root}'\n{lock_domain}\nlock_domain {first}\necho \"$domain\"\nread -r"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.domain = int(self.process.stdout.readline())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.communicate("\n", timeout=30)


def occupy(domain):
    """A socket such as a participant of the domain has."""
    occupied = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    occupied.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    occupied.bind(("", DISCOVERY_PORT + PORTS_PER_DOMAIN * domain))
    return occupied


def hold(name, begin, end):
    """Takes the name of a test, or of a robot, in a domain in which there is none yet."""
    for domain in range(50, 100):
        try:
            name.bind(f"\0musher/{begin}{domain}{end}")
            return domain
        except OSError:
            pass
    raise AssertionError("no domain is free")


with Demo(40) as demo:
    first = demo.domain
    with Demo(first) as other:
        assert other.domain != first, f"domain {first} has a demo, and was taken"
with occupy(first):
    with Demo(first) as demo:
        second = demo.domain
        assert second != first, f"domain {first} is in use, and was taken"
for begin, end, holder in ("musher-test-domain/", "", "test"), ("", "//musher/controller", "robot"):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as name:
        used = hold(name, begin, end)
        with Demo(used) as demo:
            assert demo.domain != used, f"domain {used} has a {holder}, and was taken"
with Demo(100) as demo:
    assert 1 <= demo.domain <= 100

# LCM's own library receives all that is sent to its port, whatever the group.
ports = []
for domain in range(1, 101):
    urls = subprocess.run(["bash", "-c", f"{lcm_urls}\nlcm_urls {domain}"], stdout=subprocess.PIPE, text=True,
                          check=True).stdout
    ports += re.findall(rf'^\w+_url = "udpm://239\.254\.77\.{domain}:(\d+)"$', urls, re.M)
assert len(ports) == len(set(ports)) == 300, "two demos have the same port of LCM"
