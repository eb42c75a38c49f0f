"""A DDS domain for a test in Python, locked as domain.hpp does."""

import os
import socket


def lock_domain() -> "tuple[int, socket.socket]":
    """A domain of this process, for as long as the socket lives."""
    for offset in range(10_000):
        domain = 1 + (os.getpid() + offset) % 101
        name = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            name.bind(f"\0musher/musher-test-domain/{domain}")
        except OSError:
            name.close()
            continue
        with open("/proc/net/unix", encoding="utf-8") as table:
            if f" @musher/{domain}/" not in table.read():
                return domain, name
        name.close()
    raise RuntimeError("no DDS domain is free")
