"""Runs a list of runs on a Dask cluster. Only a few batches per worker are submitted at a time, so that neither the scheduler nor
the client holds all future runs. Each result is passed on as it arrives."""
import collections
import hashlib
import math
import queue
import time
import warnings

from .errors import SweepError
from .simulator import Result
from .worker import keep_value, run_batch

BATCH_TIME = 0.25     # s of one worker per batch: much longer than scheduling takes, and little is lost with a worker
MOST_IN_BATCH = 200
MOST_SENT = 64        # inputs kept for further runs: a batch has a few, and a plan may have thousands
BATCHES_A_WORKER = 3  # one running, one waiting at the worker, one being sent
PATIENCE = 30.0       # s without a scheduler
LOSS = "lost the scheduler; finished runs are kept, and the same command goes on with the others"
MOST_ATTEMPTS = 5     # of a batch that workers refuse

# Versions of a worker. Also for workers without this package: hence no function of it.
DESCRIBE = ("__import__('importlib.util').util.find_spec('deformable_surface_sweep') is not None and "
            "__import__('deformable_surface_sweep.worker', fromlist=['worker']).describe_version(%r)")

Run = collections.namedtuple("Run", "name assignments files")
Run.__doc__ = """name: its hash; assignments: KEY=VALUE; files: {KEY: name of an input}."""


class Engine:
    """job: the values shared by all runs (worker.py). inputs: {name: path} of their files. shares_files: whether workers see
    these paths. say: takes a line for the user. batch: the function of a worker, like run_batch()."""

    def __init__(self, client, job, inputs, shares_files, say, batch=run_batch):
        self.client, self.job, self.inputs, self.shares_files, self.say, self.batch = client, job, inputs, shares_files, say, batch
        self.job_key = hashlib.sha256(repr(sorted(job.items())).encode()).hexdigest()[:16]
        self.ended = queue.Queue()
        self.under_way = {}     # future -> (runs, attempts)
        self.sent = collections.OrderedDict()  # key -> the future that holds a value, in the order of last use
        self.refused = {}       # address of a refused worker -> the reason
        self.good = []          # addresses of accepted workers
        self.slots, self.asked = 0, -math.inf
        self.seconds, self.counted = 0.0, 0

    def run(self, todo, take):
        """take(name, result) for each run of todo, in the order of completion."""
        waiting = collections.deque((run, 0) for run in todo)
        last = time.monotonic()
        while waiting or self.under_way:
            self.count_slots()
            while waiting and len(self.under_way) < BATCHES_A_WORKER * self.slots:
                self.submit(waiting)
            try:
                ended = [self.ended.get(timeout=1.0)]
                last = time.monotonic()
            except queue.Empty:
                last = self.check(last)
                continue
            while not self.ended.empty():
                ended.append(self.ended.get())
            for name, result in self.collect(ended, waiting):
                take(name, result)

    def count_slots(self):
        """Number of threads of the workers that may run this sweep; updated once a second."""
        if time.monotonic() - self.asked < 1.0:
            return
        self.asked = time.monotonic()
        try:
            threads = self.client.nthreads()
            self.examine(sorted(set(threads) - set(self.refused) - set(self.good)))
        except (OSError, TimeoutError, ValueError):
            # A dead worker that the scheduler still lists is no reason to end.
            if self.client.status != "running":
                raise SweepError(LOSS)
            return
        self.slots = sum(count for worker, count in threads.items() if worker not in self.refused)
        if threads and not self.slots:
            raise SweepError("found no worker that can run this; " + "; ".join(sorted(set(self.refused.values()))))

    def examine(self, workers):
        """Asks new workers for their versions."""
        answers = self.client.run(eval, DESCRIBE % self.job["program"], workers=workers) if workers else {}
        for worker, answer in answers.items():
            version, problem = answer or ("", "found no package deformable_surface_sweep; "
                                          "accepted: workers started after `source setup.bash` of deformable_surface")
            if version == self.job["version"]:
                self.good.append(worker)
                continue
            self.refused[worker] = problem or ("found simulate of another build, %s; accepted: that of this sweep, %s" %
                                               (version, self.job["version"]))
            self.say("worker %s is not used: %s" % (worker, self.refused[worker]))

    def submit(self, waiting):
        typical = self.seconds / self.counted if self.counted else math.inf
        size = max(1, min(int(BATCH_TIME / max(typical, 1e-6)), len(waiting) // (2 * self.slots), MOST_IN_BATCH))
        batch = [waiting.popleft() for _ in range(size if waiting[0][1] == 0 else 1)]
        runs, attempts = [run for run, _ in batch], batch[0][1]
        names = {self.job["scene"], self.job["bag"], *(name for run in runs for name in run.files.values())} - {""}
        inputs = {name: self.send(name) for name in names}
        key = "sweep-%s-%s" % (self.job_key, hashlib.sha256(" ".join([run.name for run in runs] + [str(attempts)]).encode()).hexdigest()[:32])
        future = self.client.submit(self.batch, self.send_job(), [(run.assignments, run.files) for run in runs], inputs, key=key,
                                    workers=self.allowed())
        self.under_way[future] = (runs, attempts)
        future.add_done_callback(self.ended.put)

    def allowed(self):
        """The workers for a task; None: any."""
        return self.good if self.refused else None

    def send_job(self):
        return self.send_value("sweep-job-" + self.job_key, lambda: self.job)

    def send(self, name):
        """A path, or the future of a file's bytes, which is sent to each worker once."""
        if self.shares_files:
            return self.inputs[name]
        return self.send_value("sweep-input-" + name, lambda: read_bytes(self.inputs[name]))

    def send_value(self, key, make):
        if key not in self.sent:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # the warning about its size
                self.sent[key] = self.client.submit(keep_value, make(), key=key, workers=self.allowed())
        self.sent.move_to_end(key)
        # The cluster keeps a released value as long as a batch needs it.
        while len(self.sent) > MOST_SENT:
            self.sent.popitem(last=False)
        return self.sent[key]

    def collect(self, ended, waiting):
        """(name, result) of the finished batches; the runs of failed ones wait again."""
        for future in ended:
            runs, attempts = self.under_way.pop(future)
            try:
                results = future.result(timeout=PATIENCE)
            except Exception as error:  # of the cluster, whose kinds differ from version to version
                yield from self.follow_failure(runs, attempts, error, waiting)
                continue
            self.seconds += sum(result.seconds for result in results)
            self.counted += len(results)
            yield from ((run.name, result) for run, result in zip(runs, results))

    def follow_failure(self, runs, attempts, error, waiting):
        if self.client.status != "running":
            raise SweepError(LOSS)
        is_killed = type(error).__name__ == "KilledWorker"
        if is_killed and len(runs) == 1 and attempts > 0:
            yield runs[0].name, Result("lost", "its worker died again and again", {}, {}, "", 0.0)
            return
        if attempts >= MOST_ATTEMPTS:
            raise SweepError("found a cluster that does not run batches (%s: %s); accepted: workers of this Python and Dask" %
                             (type(error).__name__, " ".join(str(error).split())))
        if not is_killed:
            self.asked = -math.inf
            self.sent = collections.OrderedDict(item for item in self.sent.items() if item[1].status != "error")
        waiting.extendleft((run, attempts + 1) for run in reversed(runs))

    def check(self, last):
        """Called while no result arrives: reports a lack of workers, and ends the sweep after a while without a scheduler. Returns the
        time from which that is counted."""
        if self.client.status == "running":
            if not self.slots and time.monotonic() - last > 10.0:
                self.say("waiting for workers")
                return time.monotonic()
            return last
        if time.monotonic() - last > PATIENCE:
            raise SweepError(LOSS)
        return last


def read_bytes(path):
    with open(path, "rb") as stream:
        return stream.read()
