"""A Slurm of two nodes on one machine: each node is a network namespace with a host name of its own, so that ranks and
workers talk TCP. Everything vanishes with the process namespace of hosts.enter()."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "chaos"))
import hosts  # noqa: E402
from farm import BIN, wait_for  # noqa: E402

NODES = ("n1", "n2")
CPUS = 2  # of each node, whatever the machine has
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "mpirun")
PATH = f"{os.environ['PATH']}:/usr/sbin:/sbin"

# Preemption requeues at once; a requeued job starts again as soon as its old credential has run out.
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
SchedulerParameters=sched_interval=1
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


class NoSlurm(Exception):
    """Its daemons do not start on this machine."""


class Cluster:
    """with Cluster(directory) as cluster: ... Batch scripts run in `directory`, programs of ours in their path."""

    def __init__(self, directory):
        self.directory = pathlib.Path(directory)

    def __enter__(self):
        self._hosts = hosts.Hosts("head", *NODES)
        self.head, *self.nodes = self._hosts.__enter__()
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
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
                           "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})
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

    def command(self, *command, env=None, timeout=60):
        """What a command on the head, the login node, prints; AssertionError if it fails."""
        done = subprocess.run(["nsenter", "--net=/run/netns/head", *map(str, command)], capture_output=True, text=True,
                              timeout=timeout, cwd=self.directory, env={**os.environ, **(env or {})})
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

    def wait(self, number, *states, timeout=120):
        wait_for(lambda: self.state(number) in states, f"job {number} to be {states}", timeout)
