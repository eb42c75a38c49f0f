#!/usr/bin/env python3
"""Measures a robot of three computers, which are roots of Debian that boot with their own systemd and sshd in containers.

Needs root, systemd-nspawn, mmdebstrap and ssh, as scripts/demo computers does. Prints a Markdown table.

  test/benchmark/hosts/measure_hosts.py build/release/bin [PART ...]   parts: start, exit, watch, failover; default: all

MUSHER_BOARD_ROOT=FOLDER keeps the root of Debian for the next run.
"""

import glob
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

HOSTS = {"brain": "10.77.8.1", "motion": "10.77.8.2", "vision": "10.77.8.3"}
STATES = '["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]'
DOMAIN = "93"


def run(*words, check=True, **more):
    done = subprocess.run(words, capture_output=True, text=True, **more)
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: {done.stdout}{done.stderr}")
    return done


def until(what, holds, limit_s=90.0):
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        value = holds()
        if value:
            return value
        time.sleep(0.02)
    raise RuntimeError(f"not within {limit_s} s: {what}")


def quantile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


class Computers:
    def __init__(self, programs):
        self.programs = os.path.realpath(programs)
        self.scratch = tempfile.mkdtemp(prefix="musher-hosts-")
        self.kept = os.environ.get("MUSHER_BOARD_ROOT")
        self.debian = self.kept or f"{self.scratch}/root"
        self.machine = f"{self.scratch}/machine"  # where each computer has its own folder
        os.makedirs(self.machine)
        self.holders, self.nspawn, self.init = {}, {}, {}

    def close(self):
        for host in list(self.nspawn):
            self.power_off(host)
        for holder in self.holders.values():
            holder.kill()
            holder.wait()
        shutil.rmtree(self.scratch)

    def make_debian(self):
        if not os.path.exists(f"{self.debian}/etc/ssh"):
            run("mmdebstrap", "--quiet", "--variant=apt", "--include=systemd,systemd-sysv,dbus,openssh-server,iproute2",
                "bookworm", self.debian)
        for program in ("musher", "musher-exec"):
            for line in run("ldd", f"{self.programs}/{program}").stdout.splitlines():
                library = line.split()[2] if "=> /" in line else ""
                if library and not os.path.exists(self.debian + library):
                    run("cp", "--parents", "-L", library, self.debian)
        key = f"{self.scratch}/key"
        run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", key)
        os.makedirs(f"{self.debian}/root/.ssh", mode=0o700, exist_ok=True)
        shutil.copy(f"{key}.pub", f"{self.debian}/root/.ssh/authorized_keys")
        with open(f"{self.debian}/etc/ssh/ssh_host_ed25519_key.pub", encoding="utf-8") as public:
            text = ",".join(HOSTS.values()) + " " + public.read()
        for host in HOSTS:
            folder = f"{self.scratch}/disk-{host}"
            os.makedirs(folder)
            shutil.copy(key, folder)
            with open(f"{folder}/known_hosts", "w", encoding="utf-8") as known:
                known.write(text)

    def make_networks(self):
        for name in ["switch", *HOSTS]:
            self.holders[name] = subprocess.Popen(["unshare", "--net", "tail", "-f", "/dev/null"])
            pid, own = self.holders[name].pid, os.readlink("/proc/self/ns/net")
            until("a network", lambda pid=pid: os.readlink(f"/proc/{pid}/ns/net") != own)
        self.ip("switch", "link", "add", "wires", "type", "bridge")
        self.ip("switch", "link", "set", "wires", "up")
        for host, address in HOSTS.items():
            self.ip("switch", "link", "add", host, "type", "veth", "peer", "name", "eth0", "netns",
                    str(self.holders[host].pid))
            self.ip("switch", "link", "set", host, "master", "wires", "up")
            self.ip(host, "link", "set", "lo", "up")
            self.ip(host, "address", "add", f"{address}/24", "dev", "eth0")
            self.ip(host, "link", "set", "eth0", "up")

    def ip(self, name, *words):
        run("nsenter", "--target", str(self.holders[name].pid), "--net", "ip", *words)

    def boot(self, host):
        self.nspawn[host] = subprocess.Popen(
            ["systemd-nspawn", "--quiet", f"--directory={self.debian}", "--volatile=overlay", "--boot", "--register=no",
             "--keep-unit", f"--machine={host}", f"--network-namespace-path=/proc/{self.holders[host].pid}/ns/net",
             f"--bind={self.scratch}/disk-{host}:{self.machine}", f"--bind-ro={self.programs}"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def await_host(self, host):
        until(f"{host} boots", lambda: self.on(host, "true").returncode == 0)
        pid = self.nspawn[host].pid

        def first_process():
            with open(f"/proc/{pid}/task/{pid}/children", encoding="utf-8") as children:
                return children.read().split()
        self.init[host] = until("its first process", first_process)[0]

    def power_off(self, host):
        pid = self.nspawn[host].pid
        children = run("cat", f"/proc/{pid}/task/{pid}/children", check=False).stdout.split()
        for one in {*children, self.init.pop(host, "")} - {""}:
            try:
                os.kill(int(one), signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.nspawn.pop(host).wait()

    # By ssh, from the brain's network.
    def on(self, host, command):
        return run("nsenter", "--target", str(self.holders["brain"].pid), "--net", "ssh", "-xT", "-o", "BatchMode=yes",
                   "-o", "ConnectTimeout=2", "-o", f"UserKnownHostsFile={self.scratch}/disk-brain/known_hosts", "-i",
                   f"{self.scratch}/key", "-l", "root", HOSTS[host], "--", command, check=False)

    def musher(self, host, *words, check=True):
        return run("nsenter", "--target", self.init[host], "--net", "--pid", "--mount", "--uts", "--ipc", "--root",
                   "--wd", "--", "env", "MUSHER_TRANSPORT=lan", f"ROS_DOMAIN_ID={DOMAIN}", f"{self.programs}/musher",
                   *words, check=check)

    # `place`: the host of the n-th actuator; None: a child of the controller. Without a state of before.
    def write(self, count, place, head="", more=""):
        names = [f"a{n}" for n in range(count)]
        actuators = ", ".join(f'"{name}"' for name in names)
        text = (f'[controller]\nname = "robot"\nactuators = [{actuators}]\nstates = {STATES}\ndefault_time = 2000\n'
                f'state_dir = "state"\n{head}[transport]\nprofile = "lan"\ninterfaces = ["eth0"]\n')
        hosts = [place(n) for n in range(count)]
        for host in [one for one in HOSTS if one in hosts]:
            text += (f'[host.{host}]\naddress = "{HOSTS[host]}"\nuser = "root"\nkey = "key"\n'
                     f'known_hosts = "known_hosts"\n')
        for name, host in zip(names, hosts):
            text += (f'[actuator.{name}]\nstates = {STATES}\ntimes = [20000, 5000, 5000, 5000, 5000]\n'
                     f'command = ["{self.programs}/musher-exec", "{self.machine}/idle.toml"]\n{more}')
            if host:
                text += f'host = "{host}"\n'
        for host in HOSTS:
            folder = f"{self.scratch}/disk-{host}"
            shutil.rmtree(f"{folder}/state", ignore_errors=True)
            with open(f"{folder}/robot.toml", "w", encoding="utf-8") as config:
                config.write(text)
            with open(f"{folder}/idle.toml", "w", encoding="utf-8") as module:
                module.write('[state.LowPower]\nrun = ["true"]\n')

    def status(self, host="brain"):
        done = self.musher(host, "status", "--json", check=False)
        return json.loads(done.stdout) if done.returncode == 0 else None

    def history(self, host="brain"):
        return json.loads(self.musher(host, "history", "--json", "--lines", "0", "--journal",
                                      f"{self.machine}/state/journal.sqlite").stdout)["entries"]

    def all_active(self, host="brain"):
        status = self.status(host)
        return status and all(one["state"] == "Active" and one["presence"] == "present" and not one["degraded"]
                              for one in status["actuators"].values())

    def up(self):
        begun = time.monotonic()
        self.musher("brain", "up", "--detach", f"{self.machine}/robot.toml")
        until("all are Active", self.all_active)
        return time.monotonic() - begun

    def down(self, host="brain"):
        self.musher(host, "down", check=False)
        until("the controller ends", lambda: self.status(host) is None)


def at_ns(entry):
    return int(run("date", "-d", entry["time"], "+%s%N").stdout)


def over_three(n):
    return list(HOSTS)[n % 3]


def of_others(n):
    return [None, "motion", "vision"][n % 3]


def measure_start(computers):
    for count in (8, 32):
        taken = {"one": [], "units": [], "three": []}
        reached = []
        for _ in range(5):
            for kind, place, head in (("one", lambda n: None, ""), ("units", lambda n: None, 'units = "always"\n'),
                                      ("three", of_others, "")):
                computers.write(count, place, head)
                computers.up()
                entries = computers.history()
                begun = next(at_ns(one) for one in entries if one["event"] == "controller_started")
                usable = next(at_ns(one) for one in entries if one["event"] == "machine_usable")
                taken[kind].append((usable - begun) / 1e6)
                if kind == "three":
                    reached += [min(at_ns(one) for one in entries if f"started on host {host}" in one["message"]) / 1e6 -
                                begun / 1e6 for host in ("motion", "vision")]
                computers.down()
        middle = {kind: statistics.median(values) for kind, values in taken.items()}
        print(f"| {count} actuators, from the controller's start to Active: children of one host; its units; over three "
              f"hosts, ms (of the last: lowest – highest) | {middle['one']:.0f}; {middle['units']:.0f}; "
              f"{middle['three']:.0f} ({min(taken['three']):.0f} – {max(taken['three']):.0f}) |")
        print(f"| … from the controller's start to the first process of another host (ssh, D-Bus, its start), ms "
              f"| {statistics.median(reached):.0f} ({min(reached):.0f} – {max(reached):.0f}) |", flush=True)


def measure_exit(computers, kills=200):
    computers.write(2, lambda n: [None, "vision"][n],
                    more="restart_delay_ms = 1\nrestart_growth = 1.0\nrestart_limit = 1000\n")
    computers.up()
    killed = {}
    for _ in range(kills):
        pid = computers.status()["actuators"]["a1"]["pid"]
        killed[pid] = int(computers.on("vision", f"date +%s%N; kill -KILL {pid}").stdout)

        def is_back(before=pid):
            one = computers.status()["actuators"]["a1"]
            return one["pid"] not in (None, before) and one["state"] == "Active"
        until("it is back", is_back)
    delays = []
    for entry in computers.history():
        for pid, when in killed.items():
            if entry["message"] == f"a1's process {pid} ended: killed by SIGKILL":
                delays.append((at_ns(entry) - when) / 1e6)
    computers.down()
    print(f"| kill -9 on another host → its exit is recorded, {len(delays)} kills: p50, p99, most, ms | "
          f"{quantile(delays, 0.5):.1f}, {quantile(delays, 0.99):.1f}, {max(delays):.1f} |", flush=True)


def cpu_and_memory(pid):
    with open(f"/proc/{pid}/stat", encoding="utf-8") as stat:
        words = stat.read().rsplit(")", 1)[1].split()
    with open(f"/proc/{pid}/smaps_rollup", encoding="utf-8") as rollup:
        pss = next(int(line.split()[1]) for line in rollup if line.startswith("Pss:"))
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK"), pss / 1024


def processes_of(computers, host, names):
    found = []
    own = os.readlink(f"/proc/{computers.init[host]}/ns/pid")
    for comm in glob.glob("/proc/[0-9]*/comm"):
        try:
            pid = comm.split("/")[2]
            with open(comm, encoding="utf-8") as file:
                if file.read().strip() in names and os.readlink(f"/proc/{pid}/ns/pid") == own:
                    found.append(pid)
        except OSError:
            pass
    return found


def measure_watch(computers, seconds=60):
    for what, place in (("children of one host", lambda n: None), ("over three hosts", of_others)):
        computers.write(8, place)
        computers.up()
        time.sleep(5)  # until the start has been written
        groups = {"controller": processes_of(computers, "brain", {"musher"}),
                  "ssh beside it": processes_of(computers, "brain", {"ssh"}),
                  "systemd, D-Bus and sshd of vision": processes_of(
                      computers, "vision", {"systemd", "dbus-daemon", "sshd", "systemd-stdio-b"})}
        before = {group: [cpu_and_memory(pid) for pid in pids] for group, pids in groups.items()}
        time.sleep(seconds)
        after = {group: [cpu_and_memory(pid) for pid in pids] for group, pids in groups.items()}
        texts = []
        for group, pids in groups.items():
            used = sum(now[0] - then[0] for now, then in zip(after[group], before[group]))
            texts.append(f"{group} ({len(pids)}): {100 * used / seconds:.2f} %, "
                         f"{sum(now[1] for now in after[group]):.1f} MB")
        print(f"| 8 actuators at rest, {what}, for {seconds} s: CPU of a core, memory (PSS) | {'; '.join(texts)} |",
              flush=True)
        computers.down()


def measure_failover(computers, rounds=8):
    leads, usable, done = [], [], []
    for _ in range(rounds):
        computers.write(9, over_three, 'failover_ms = 3000\nunits = "always"\n')
        computers.up()
        computers.musher("motion", "up", "--standby", "--detach", f"{computers.machine}/robot.toml")
        until("it stands by", lambda: "a controller leads" in
              ((computers.status("motion") or {}).get("standby") or {}).get("why_not_leading", ""))
        time.sleep(2)
        cut = time.time_ns()
        computers.power_off("brain")
        log = f"{computers.scratch}/disk-motion/state/controller.log"

        def has_begun():
            with open(log, encoding="utf-8") as text:
                return "controller started" in text.read()
        until("the standby leads", has_begun)
        result = computers.musher("motion", "set", "LowPower", "--json", check=False)
        done.append(((time.time_ns() - cut) / 1e6, json.loads(result.stdout).get("outcome")))
        until("the machine is adopted",
              lambda: any(one["event"] == "machine_adopted" for one in computers.history("motion")))
        entries = computers.history("motion")
        leads.append((next(at_ns(one) for one in entries if one["event"] == "controller_started") - cut) / 1e6)
        usable.append((next(at_ns(one) for one in entries if one["event"] == "machine_adopted") - cut) / 1e6)
        computers.down("motion")
        computers.boot("brain")
        computers.await_host("brain")
    print(f"| power of the controller's host cut → the standby begins; has adopted the machine; a switch that is "
          f"requested at once is done, failover_ms = 3000, {rounds} cuts: median (lowest – highest), s | " +
          "; ".join(f"{statistics.median(values) / 1e3:.2f} ({min(values) / 1e3:.2f} – {max(values) / 1e3:.2f})"
                    for values in (leads, usable, [one[0] for one in done])) +
          f"; refused: {sum(one[1] in (None, 'refused') for one in done)} |", flush=True)


def main():
    parts = {"start": measure_start, "exit": measure_exit, "watch": measure_watch, "failover": measure_failover}
    if len(sys.argv) < 2 or not set(sys.argv[2:]) <= set(parts):
        sys.exit(__doc__)
    computers = Computers(sys.argv[1])
    try:
        computers.make_debian()
        computers.make_networks()
        for host in HOSTS:
            computers.boot(host)
        for host in HOSTS:
            computers.await_host(host)
        print("| what | figure |\n|---|---|", flush=True)
        for part in sys.argv[2:] or parts:
            parts[part](computers)
    finally:
        computers.close()


if __name__ == "__main__":
    main()
