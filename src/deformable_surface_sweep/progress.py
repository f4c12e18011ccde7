"""Progress of a sweep: runs done, failed and remaining, rate and remaining time. One updated line at a terminal, otherwise a line
now and then."""
import sys
import time


def describe_time(seconds):
    if seconds < 100:
        return "%.0f s" % seconds
    if seconds < 6000:
        return "%.0f min" % (seconds / 60)
    return "%.1f h" % (seconds / 3600)


def describe_bytes(count):
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000 or unit == "GB":
            return "%.3g %s" % (count, unit)
        count /= 1000


class Progress:
    def __init__(self, total, done, stream=sys.stderr, quiet=False):
        self.total, self.done, self.fresh, self.counts = total, done, 0, {}
        self.stream, self.quiet = stream, quiet
        self.is_terminal = stream.isatty()
        self.begun = self.told = time.monotonic()

    def add(self, status):
        self.done += 1
        self.fresh += 1
        if status != "done":
            self.counts[status] = self.counts.get(status, 0) + 1
        if time.monotonic() - self.told >= (0.2 if self.is_terminal else 10.0):
            self.tell()

    def describe(self):
        taken = time.monotonic() - self.begun
        rate = self.fresh / taken if taken > 0 else 0.0
        text = "%d of %d runs" % (self.done, self.total)
        if self.fresh:
            text += ", %.3g a second, %s left" % (rate, describe_time((self.total - self.done) / rate))
        for status in sorted(self.counts):
            text += ", %d %s" % (self.counts[status], status)
        return text

    def describe_end(self, problems):
        """problems: those of the runs without a result, in this and earlier sweeps."""
        return "all %d runs are done" % self.total if not problems else "%d of %d runs are done, %d are not, the first: %s" % (
            self.total - len(problems), self.total, len(problems), problems[0])

    def tell(self):
        self.told = time.monotonic()
        if not self.quiet:
            self.stream.write(("\r\033[K%s" if self.is_terminal else "sweep: %s\n") % self.describe())
            self.stream.flush()

    def say(self, line):
        """Prints a separate line."""
        if not self.quiet:
            self.stream.write(("\r\033[K" if self.is_terminal else "") + "sweep: %s\n" % line)
            self.stream.flush()

    def finish(self):
        if self.is_terminal and not self.quiet:
            self.stream.write("\r\033[K")
