"""Network namespaces as hosts, connected by a bridge. Links can be slow, down, or drop everything.

A script calls enter() first. It then continues in its own mount, network and process namespaces, which end with it in
any case. Needs iproute2 and util-linux, and root or user namespaces."""

import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import BIN  # noqa: E402

INSIDE = "PARRAY_HOSTS_INSIDE"
NETWORK = "10.77.0."


def permitted():
    return os.environ.get(INSIDE) == "1"


def enter():
    """Starts the script again in namespaces. Returns in the namespaces, or if they are not permitted."""
    if INSIDE in os.environ:
        return
    prefix = ["unshare", "--mount", "--net", "--pid", "--fork", "--kill-child", "--mount-proc"]
    if os.geteuid() != 0:
        prefix += ["--user", "--map-root-user"]
    probe = "mount -t tmpfs tmpfs /run && ip link add b0 type bridge && ip link add v0 type veth peer name v1"
    try:
        able = subprocess.run([*prefix, "sh", "-c", probe], capture_output=True).returncode == 0
    except OSError:
        able = False
    os.environ[INSIDE] = "1" if able else "0"
    if able:
        done = subprocess.run([*prefix, sys.executable, *sys.argv])
        sys.exit(done.returncode)


def ip(*arguments):
    subprocess.run(["ip", *map(str, arguments)], check=True, capture_output=True)


def local_addresses(count):
    """Returns `count` addresses of this host that are not loopback addresses. For a coordinator, each address is another
machine. Call it only after enter() and if permitted()."""
    ip("link", "set", "lo", "up")
    addresses = [f"{NETWORK}{number}" for number in range(1, count + 1)]
    for address in addresses:
        ip("address", "add", f"{address}/32", "dev", "lo")
    return addresses


class Host:
    def __init__(self, name, number, directory):
        self.name = name
        self.address = f"{NETWORK}{number}"
        self.directory = directory
        self.processes = []
        self._boot()

    def _boot(self):
        ip("netns", "add", self.name)
        ip("link", "add", self.name, "type", "veth", "peer", "name", "eth0", "netns", self.name)
        ip("link", "set", self.name, "master", "bridge", "up")
        self._ip("address", "add", f"{self.address}/24", "dev", "eth0")
        self._ip("link", "set", "eth0", "up")
        self._ip("link", "set", "lo", "up")

    def _ip(self, *arguments):
        ip("-n", self.name, *arguments)

    def _command(self, program, arguments):
        return ["nsenter", f"--net=/run/netns/{self.name}", BIN / program, *map(str, arguments)]

    def start(self, program, *arguments, stdout=subprocess.DEVNULL):
        log = self.directory / f"{self.name}-{len(self.processes)}-{pathlib.Path(program).name}.log"
        with log.open("w") as stderr:
            process = subprocess.Popen(self._command(program, arguments), stdout=stdout, stderr=stderr, text=True)
        process.log = log
        self.processes.append(process)
        return process

    def run(self, program, *arguments, timeout=120):
        return subprocess.run(self._command(program, arguments), capture_output=True, text=True, timeout=timeout)

    def link(self, up):
        ip("link", "set", self.name, "up" if up else "down")

    def blackhole(self, on):
        """Makes all packets to and from this host disappear without an error, as in a failed switch, or ends this."""
        subprocess.run(["bridge", "link", "set", "dev", self.name, "state", "0" if on else "3"], check=True)

    def limit(self, rate):
        """Limits the rate in both directions, such as 1mbit; None: no limit."""
        for where in (["-n", self.name, "qdisc", "replace", "dev", "eth0"], ["qdisc", "replace", "dev", self.name]):
            how = ["tbf", "rate", rate, "burst", "16kb", "latency", "200ms"] if rate else ["noqueue"]
            subprocess.run(["tc", *where, "root", *how], check=True, capture_output=True)

    def pull_the_plug(self):
        """Kills all processes after the link is down, so that no process sends a last message."""
        ip("link", "del", self.name)
        for process in self.processes:
            process.kill()
            process.wait()

    def reboot(self):
        self.pull_the_plug()
        ip("netns", "del", self.name)
        self._boot()


class Hosts:
    """with Hosts("head", "left", "right") as (head, left, right): ..."""

    def __init__(self, *names):
        self.names = names

    def __enter__(self):
        self._directory = tempfile.TemporaryDirectory(prefix="parray-hosts-")
        directory = pathlib.Path(self._directory.name)
        subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run"], check=True)  # where ip keeps the names
        ip("link", "add", "bridge", "type", "bridge")
        ip("link", "set", "bridge", "up")
        self.hosts = [Host(name, number, directory) for number, name in enumerate(self.names, 1)]
        return self.hosts

    def __exit__(self, *_):
        for host in self.hosts:
            for process in host.processes:
                process.kill()
                process.wait()
                if process.stdout:
                    process.stdout.close()
            ip("link", "del", host.name)  # a namespace's own end of it may outlive its name for a while
            ip("netns", "del", host.name)
        ip("link", "del", "bridge")
        subprocess.run(["umount", "--lazy", "/run"], check=True)
        self._directory.cleanup()

