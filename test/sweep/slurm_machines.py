"""A Slurm cluster on one machine, for tests: a controller and nodes in network namespaces. Each slurmd has its own mount, process and
name namespaces, because two of Debian's do not run side by side otherwise. The machine itself is not changed."""
import os
import shutil
import subprocess
import time

PATIENCE = 60.0  # s
CONTROL = "10.79.0.1"
PREFIX = "sw%d_" % os.getpid()
CONFIGURATION = """
ClusterName=sweep
SlurmctldHost=control(%(control)s)
AuthType=auth/munge
AuthInfo=socket=%(folder)s/munge.socket
CryptoType=crypto/munge
SlurmUser=root
StateSaveLocation=%(folder)s/state
SlurmctldPidFile=%(folder)s/slurmctld.pid
SlurmctldLogFile=%(folder)s/slurmctld.log
SlurmdSpoolDir=%(folder)s/spool.%%n
SlurmdPidFile=%(folder)s/slurmd.%%n.pid
SlurmdLogFile=%(folder)s/slurmd.%%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
%(nodes)s
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Missing(Exception):
    """Says why this machine cannot make such a cluster."""


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    if done.returncode != 0:
        raise Missing("%s: %s" % (" ".join(command), " ".join(done.stdout.split()) or "status %d" % done.returncode))
    return done.stdout


class SlurmMachines:
    """with SlurmMachines(folder, nodes) as machines: machines.command(...) runs on the controller."""

    def __init__(self, folder, nodes=2):
        self.folder, self.nodes, self.processes = folder, ["node%d" % (i + 1) for i in range(nodes)], []
        self.addresses = dict([("control", CONTROL)] + [(node, "10.79.0.%d" % (i + 2)) for i, node in enumerate(self.nodes)])

    def __enter__(self):
        for program in ("slurmctld", "slurmd", "sbatch", "munged", "ip", "unshare"):
            if not shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin:/sbin"):
                raise Missing("there is no %s" % program)
        try:
            self.build_network()
            self.start_slurm()
        except BaseException:
            self.__exit__()
            raise
        return self

    def build_network(self):
        run("ip", "netns", "add", PREFIX + "switch")
        switch = ["ip", "-n", PREFIX + "switch", "link"]
        run(*switch, "add", "bridge", "type", "bridge")
        run(*switch, "set", "bridge", "up")
        for host, address in self.addresses.items():
            run("ip", "netns", "add", PREFIX + host)
            run(*switch, "add", "to_" + host, "type", "veth", "peer", "name", "net", "netns", PREFIX + host)
            run(*switch, "set", "to_" + host, "master", "bridge", "up")
            run("ip", "-n", PREFIX + host, "address", "add", address + "/24", "dev", "net")
            for name in ("lo", "net"):
                run("ip", "-n", PREFIX + host, "link", "set", name, "up")
            run("ip", "netns", "exec", PREFIX + host, "true")

    def start_slurm(self):
        os.chmod(self.folder, 0o755)
        for name in ["state"] + ["spool." + node for node in self.nodes]:
            os.makedirs(os.path.join(self.folder, name))
        nodes = "\n".join("NodeName=%s NodeAddr=%s CPUs=1 State=UNKNOWN" % (node, self.addresses[node]) for node in self.nodes)
        self.write("slurm.conf", CONFIGURATION % {"control": CONTROL, "folder": self.folder, "nodes": nodes})
        self.write("cgroup.conf", "CgroupPlugin=cgroup/v1\n")
        self.write("hosts", "127.0.0.1 localhost\n" + "".join("%s %s\n" % (address, host) for host, address in self.addresses.items()))
        with open(self.path("munge.key"), "wb") as stream:
            stream.write(os.urandom(64))
        os.chmod(self.path("munge.key"), 0o600)
        self.start("munged", "--foreground", "--force", "--socket", self.path("munge.socket"), "--key-file", self.path("munge.key"),
                   "--pid-file", self.path("munge.pid"), "--log-file", self.path("munge.log"), "--seed-file", self.path("munge.seed"))
        self.await_that("munged", lambda: os.path.exists(self.path("munge.socket")))
        self.start(*self.on("control"), "slurmctld", "-D", "-f", self.path("slurm.conf"))
        for node in self.nodes:
            self.start(*self.on(node), "slurmd", "-D", "-f", self.path("slurm.conf"), "-N", node)
        self.await_that("idle nodes", lambda: self.command("sinfo", "-h", "-t", "idle", "-o", "%D").strip() == str(len(self.nodes)))

    def on(self, host):
        """The words before a command that run it on a host, with its own name, hosts file and control groups."""
        # The shell stays as the first process, which reaps orphaned processes of jobs.
        inner = "hostname %s; mount --bind %s /etc/hosts; mount -t tmpfs none /sys/fs/cgroup; \"$@\"; exit $?" % (host, self.path("hosts"))
        return ["ip", "netns", "exec", PREFIX + host, "unshare", "--mount", "--uts", "--pid", "--fork", "--kill-child", "--mount-proc",
                "sh", "-c", inner, "sh"]

    def environment(self):
        return dict(os.environ, SLURM_CONF=self.path("slurm.conf"), PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")

    def command(self, *words):
        return subprocess.run(self.on("control") + list(words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                              env=self.environment()).stdout

    def start(self, *command):
        self.processes.append(subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=self.environment()))

    def await_that(self, what, condition):
        begin = time.monotonic()
        while not condition():
            if time.monotonic() - begin > PATIENCE:
                raise Missing("in %g s there was not: %s" % (PATIENCE, what))
            time.sleep(0.2)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w") as stream:
            stream.write(text)

    def __exit__(self, *error):
        for process in reversed(self.processes):
            process.kill()
            process.wait()
        for host in ["switch"] + list(self.addresses):
            try:
                subprocess.run(["ip", "netns", "delete", PREFIX + host], stderr=subprocess.DEVNULL)
            except OSError:
                return
