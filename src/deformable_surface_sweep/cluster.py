"""The machines of a sweep: processes of this machine, an existing Dask scheduler, or workers started by Slurm."""
import contextlib
import logging
import os
import shlex
import subprocess
import sys
import tempfile

from .errors import SweepError

THREADS_A_PROCESS = 8  # a run takes a few milliseconds of Python, one thread at a time

# Dask's frequent monitoring of itself would take more time than short runs.
SELDOM = {"distributed.worker.profile.interval": "1s", "distributed.worker.profile.cycle": "100s", "distributed.admin.tick.interval": "1s",
          "distributed.admin.system-monitor.interval": "5s", "distributed.worker.memory.monitor-interval": "5s"}


def find_versions():
    """Versions of the software that runs the sweep."""
    try:
        import dask
        import distributed
    except ImportError as error:
        raise SweepError("found no Dask for %s (%s); accepted: a Python with it, in Debian and Ubuntu the package python3-distributed" %
                         (sys.executable, error))
    return {"python": sys.version.split()[0], "dask": dask.__version__, "distributed": distributed.__version__}


@contextlib.contextmanager
def open_cluster(scheduler="", scheduler_file="", slurm=None, workers=0):
    """A Dask client, and whether its workers see this machine's files. Closes on exit whatever it started."""
    import dask
    from distributed import Client, LocalCluster
    # Workers come and go; the sweep itself reports it where it matters.
    logging.disable(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        # Otherwise the workers would put their files into the current folder.
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="sweep_workers_"))
        dask.config.set({"distributed.comm.timeouts.connect": "10s", "temporary-directory": folder, **SELDOM})
        if scheduler or scheduler_file:
            where = scheduler or scheduler_file
            if scheduler_file and not os.path.exists(scheduler_file):
                raise SweepError("--scheduler-file: found no file '%s'; accepted: that of a running dask-scheduler" % scheduler_file)
            try:
                client = Client(scheduler or None, scheduler_file=scheduler_file or None, timeout=10)
            except (OSError, ValueError, TimeoutError) as error:
                raise SweepError("found no scheduler at %s (%s); accepted: the address of a running dask-scheduler, as in "
                                 "tcp://HOST:8786" % (where, " ".join(str(error).split()) or type(error).__name__))
            stack.callback(client.close)
            yield client, False
            return
        count = workers or len(os.sched_getaffinity(0))
        if slurm is None:
            # Threads of one process suffice, as they wait for simulations. A process each would take seconds to start.
            processes = next(n for n in range(-(-count // THREADS_A_PROCESS), count + 1) if count % n == 0)
            options = {"n_workers": processes, "threads_per_worker": count // processes, "processes": processes > 1}
        else:
            options = {"n_workers": 0, "processes": True, "host": find_host()}
        options.update(memory_limit=0, dashboard_address="127.0.0.1:0", worker_dashboard_address="127.0.0.1:0")
        cluster = stack.enter_context(LocalCluster(**options))
        client = stack.enter_context(Client(cluster))
        if slurm is not None:
            job = start_slurm(slurm, count, cluster.scheduler_address)
            stack.callback(subprocess.run, ["scancel", job], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        yield client, slurm is None


def find_host():
    """The name by which other machines reach this one."""
    return os.uname().nodename


def start_slurm(options, count, address):
    """Submits an array of workers that join the scheduler; returns the job."""
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard", "--memory-limit", "0",
              "--death-timeout", "60"]
    command = ["sbatch", "--parsable", "--array=0-%d" % (count - 1), "--job-name=sweep", "--output=/dev/null"] + shlex.split(options)
    try:
        done = subprocess.run(command + ["--wrap", " ".join(shlex.quote(word) for word in worker)], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True)
    except OSError as error:
        raise SweepError("--slurm: sbatch cannot be run (%s); accepted: a machine that submits jobs to Slurm" % error.strerror)
    if done.returncode != 0:
        raise SweepError("--slurm: sbatch refused the job: %s" % " ".join(done.stderr.split()))
    return done.stdout.strip().split(";")[0]
