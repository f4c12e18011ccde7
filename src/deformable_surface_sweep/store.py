"""Results on disk. Files are stored under the hash of their content. Results are lines of journals, one journal per writing sweep.
So two sweeps can share a folder, and a killed sweep leaves all finished results.
  OUT/runs/*.jsonl       a line per run: its name (identity.py), status, sentence, numbers, names of its files
  OUT/files/ab/ab12...   clouds, frames and bags"""
import json
import os
import socket
import tempfile
import time

from .errors import SweepError

SYNC_PERIOD = 1.0  # s: finished runs of this duration may be lost in a power failure
UNWRITABLE = "%s: cannot be written (%s); accepted: a folder with room on its disk"


class Store:
    def __init__(self, out):
        self.out = out
        self.journal = None
        self.synced = 0.0
        try:
            for name in ("runs", "files"):
                os.makedirs(os.path.join(out, name), exist_ok=True)
        except OSError as error:
            raise SweepError("--out: found '%s', which cannot be made (%s); accepted: a folder" % (out, error.strerror))

    def read(self):
        """{name of a run: its record} of all sweeps so far. A line cut off by a kill is ignored."""
        records = {}
        folder = os.path.join(self.out, "runs")
        for name in sorted(os.listdir(folder)):
            if not name.endswith(".jsonl"):
                continue
            with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as stream:
                for line in stream:
                    try:
                        record = json.loads(line)
                        records[record["run"]] = record
                    except (ValueError, KeyError, TypeError):
                        continue
        return records

    def add(self, run, result):
        """Keeps the result of a run and returns its record: files first, so that all files named in a record exist."""
        files = {column: [self.keep_file(name, data) for name, data in items] for column, items in result.files.items()}
        record = {"run": run, "status": result.status, "problem": result.problem, "values": result.values, "files": files,
                  "hash": result.hash, "seconds": round(result.seconds, 4)}
        try:
            if self.journal is None:
                handle, _ = tempfile.mkstemp(prefix="%s-%s-" % (time.strftime("%Y%m%dT%H%M%S"), socket.gethostname()), suffix=".jsonl",
                                             dir=os.path.join(self.out, "runs"))
                self.journal = open(handle, "w", encoding="utf-8")
            self.journal.write(json.dumps(record) + "\n")
            self.journal.flush()
            if time.monotonic() > self.synced + SYNC_PERIOD:
                self.sync()
        except OSError as error:
            raise SweepError(UNWRITABLE % (self.out, error.strerror))
        return record

    def sync(self):
        os.fsync(self.journal.fileno())
        self.synced = time.monotonic()

    def close(self):
        if self.journal is None:
            return
        try:
            self.sync()
            self.journal.close()
        except OSError as error:
            raise SweepError(UNWRITABLE % (self.out, error.strerror))
        finally:
            self.journal = None

    def keep_file(self, name, data):
        inner = os.path.join("files", name[:2], name)
        path = os.path.join(self.out, inner)
        if not os.path.exists(path):
            write_whole(path, data)
        return inner


def write_whole(path, data):
    """Writes a file atomically: it exists completely or not at all, also with concurrent writers or a kill."""
    try:
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        handle, temporary = tempfile.mkstemp(prefix=".", suffix=".partial", dir=os.path.dirname(path) or ".")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            os.chmod(temporary, 0o644)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise SweepError(UNWRITABLE % (path, error.strerror))
