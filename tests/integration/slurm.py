"""A Slurm of two nodes on one machine: each node is a network namespace with a host name of its own, so that ranks and
workers talk TCP. Everything vanishes with the process namespace of hosts.enter()."""

import getpass
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "chaos"))
import hosts  # noqa: E402
from farm import BIN, wait_for  # noqa: E402

NODES = ("n1", "n2")
CPUS = 2  # of each node, whatever the machine has
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "mpirun")
PATH = f"{os.environ['PATH']}:/usr/sbin:/sbin"

# A requeued job starts again when its old credential has run out.
CONFIGURATION = """
ClusterName=parray
SlurmctldHost=head({head})
SlurmctldPort=6817
AuthType=auth/munge
AuthInfo=cred_expire=5
SlurmUser=root
StateSaveLocation={directory}/controller
SlurmdSpoolDir={directory}/spool.%n
TmpFS={directory}/tmp.%n
SlurmctldPidFile={directory}/controller.pid
SlurmdPidFile={directory}/%n.pid
SlurmctldLogFile={directory}/controller.log
SlurmdLogFile={directory}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,sched_min_interval=100000
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
KillWait=10
InactiveLimit=0
MinJobAge=300
{nodes}
PartitionName=low Nodes=ALL Default=YES PriorityTier=1 GraceTime=0
PartitionName=high Nodes=ALL PriorityTier=10 PreemptMode=OFF
"""


def why_not():
    """Why there can be no Slurm here; empty if there can."""
    missing = [program for program in PROGRAMS if not shutil.which(program, path=PATH)]
    if missing:
        return "missing: " + ", ".join(missing)
    return "" if hosts.permitted() else "network namespaces are not permitted"


def last_lines(directory):
    """What the daemons said last, a line each."""
    said = {path.stem: path.read_text(errors="replace").splitlines() for path in directory.glob("*.log")}
    return "; ".join(f"{name}: {lines[-1]}" for name, lines in said.items() if lines)


class Cluster:
    """with Cluster(directory) as cluster: ... Batch scripts run in `directory`, programs of ours in their path."""

    def __init__(self, directory):
        self.directory = pathlib.Path(directory)

    def __enter__(self):
        self._hosts = hosts.Hosts("head", *NODES)
        self.head, *self.nodes = self._hosts.__enter__()
        try:
            self._start()
        except (AssertionError, OSError, subprocess.SubprocessError) as error:
            said = last_lines(self.directory / "slurm")
            self._end()
            raise unittest.SkipTest(f"Slurm does not start: {error}; {said}") from None
        return self

    def __exit__(self, *_):
        self.command("scancel", "--user", getpass.getuser())
        wait_for(lambda: not self.command("squeue", "--noheader"), "all jobs to end")
        self._end()

    def _end(self):
        subprocess.run(["umount", "--lazy", "/etc/hosts"], capture_output=True)
        self._hosts.__exit__()

    def _start(self):
        system = self.directory / "slurm"
        (system / "controller").mkdir(parents=True)
        every = [self.head, *self.nodes]
        names = system / "hosts"
        names.write_text("127.0.0.1 localhost\n" + "".join(f"{host.address} {host.name}\n" for host in every))
        subprocess.run(["mount", "--bind", names, "/etc/hosts"], check=True)  # of this mount namespace
        nodes = "\n".join(f"NodeName={node.name} NodeAddr={node.address} CPUs={CPUS}" for node in self.nodes)
        configuration = system / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(head=self.head.address, directory=system, nodes=nodes))
        os.environ.update({"SLURM_CONF": str(configuration), "PATH": f"{BIN}:{PATH}",
                           "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                           "ASAN_OPTIONS": "detect_leaks=0"})  # as in mpi.py
        self._start_munge()
        self._daemon(self.head, "slurmctld")
        for node in self.nodes:
            for own in ("spool", "tmp"):
                (system / f"{own}.{node.name}").mkdir()
            self._daemon(node, "slurmd")
        wait_for(lambda: self._nodes_are("idle"), "both nodes", timeout=30)

    def _start_munge(self):
        """At its usual place, as /run is one of this namespace's own."""
        run = pathlib.Path("/run/munge")
        run.mkdir(mode=0o755)
        key = run / "key"
        key.touch(0o600)
        key.write_bytes(os.urandom(128))
        self.head.start("/usr/sbin/munged", "--foreground", "--key-file", key, "--seed-file", run / "seed",
                        "--log-file", run / "log", "--pid-file", run / "pid")
        wait_for((run / "munge.socket.2").exists, "munged", timeout=10)

    def _daemon(self, host, program):
        self._as(host, program, "-D")

    def _as(self, host, *command):
        """Under the host's own name, as a machine has it."""
        host.start("/usr/bin/unshare", "--uts", "sh", "-c", f'hostname {host.name} && exec "$@"', "sh", *command)

    def run(self, *command, env=None, timeout=300):
        """A finished command of the head, the login node."""
        return subprocess.run(["nsenter", "--net=/run/netns/head", *map(str, command)], capture_output=True, text=True,
                              timeout=timeout, cwd=self.directory, env={**os.environ, **(env or {})})

    def command(self, *command, env=None):
        """What a command prints; AssertionError if it fails."""
        done = self.run(*command, env=env)
        assert done.returncode == 0, f"{command}: status {done.returncode}\n{done.stdout}{done.stderr}"
        return done.stdout

    def _nodes_are(self, state):
        return self.command("sinfo", "--noheader", "--Node", "--partition=low", "--format=%t").split() == [
            state] * len(NODES)

    def submit(self, *arguments, env=None):
        """The number of a batch job."""
        return int(self.command("sbatch", "--parsable", *arguments, env=env))

    def job(self, number):
        """Slurm's facts of a job, by name."""
        return dict(re.findall(r"(\S+?)=(\S*)", self.command("scontrol", "--oneliner", "show", "job", number)))

    def state(self, number):
        return self.job(number)["JobState"]

    def wait(self, number, *states, timeout=300):
        wait_for(lambda: self.state(number) in states, f"job {number} to be {states}", timeout)
