"""Values of the swept keys: grids, paired lists, and samples of distributions. Samples are reproducible for a plan and seed."""
import itertools
import math
import zlib
from statistics import NormalDist

import numpy as np

from .errors import SweepError

METHODS = ("random", "latin_hypercube", "sobol")
MOST_RUNS = 10 ** 7


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_values(where, values):
    """The values of one key of a grid: a list, or {from, to, steps, scale}."""
    if isinstance(values, list) and values:
        return values
    if isinstance(values, dict) and {"from", "to", "steps"} <= set(values) <= {"from", "to", "steps", "scale"}:
        first, last, steps, scale = values["from"], values["to"], values["steps"], values.get("scale", "linear")
        is_log = scale == "log"
        if (is_number(first) and is_number(last) and isinstance(steps, int) and 2 <= steps <= MOST_RUNS and scale in ("linear", "log") and
                not (is_log and not (first > 0 and last > 0))):
            points = np.geomspace(first, last, steps) if is_log else np.linspace(first, last, steps)
            return [float(value) for value in points]
    accepted = "a list of values, or {from: A, to: B, steps: N} with N of 2 or more, and scale: linear or log (A and B above 0)"
    if isinstance(values, dict) and values and not set(values) & {"from", "to", "steps", "scale"}:
        accepted += "; keys below keys are written as dotted paths, here %s.%s" % (where.rpartition(": ")[2], next(iter(values)))
    raise SweepError("%s: found %s; accepted: %s" % (where, "nothing" if values is None else values, accepted))


class Distribution:
    """Turns numbers between 0 and 1 into values of a key."""

    def __init__(self, where, text):
        kind, of = next(iter(text.items())) if isinstance(text, dict) and len(text) == 1 else (None, None)
        is_pair = isinstance(of, list) and len(of) == 2 and all(is_number(value) for value in of)
        if kind == "uniform" and is_pair and of[0] < of[1]:
            self.find = lambda u: of[0] + u * (of[1] - of[0])
        elif kind == "log_uniform" and is_pair and 0 < of[0] < of[1]:
            self.find = lambda u: of[0] * (of[1] / of[0]) ** u
        elif kind == "normal" and is_pair and of[1] > 0:
            normal = NormalDist(of[0], of[1])
            self.find = lambda u: normal.inv_cdf(min(max(u, 1e-12), 1 - 1e-12))
        elif kind == "integers" and is_pair and all(isinstance(value, int) for value in of) and of[0] <= of[1]:
            self.find = lambda u: min(of[0] + int(u * (of[1] - of[0] + 1)), of[1])
        elif kind == "choice" and isinstance(of, list) and of:
            self.find = lambda u: of[min(int(u * len(of)), len(of) - 1)]
        else:
            raise SweepError("%s: found %s; accepted: uniform: [A, B], log_uniform: [A, B] with 0 < A < B, normal: [MEAN, DEVIATION], "
                             "integers: [A, B], choice: [VALUE, ...]" % (where, text))


def draw(method, samples, seed, keys):
    """(samples x keys) numbers from 0 to 1. With `random`, each key has its own stream. With `random` and `sobol`, a larger number
    of samples begins with the smaller one: an enlarged plan keeps the finished runs."""
    if method == "sobol":
        try:
            from scipy.stats import qmc
        except ImportError:
            raise SweepError("sobol: found no scipy of version 1.7 or newer; accepted: that, or latin_hypercube")
        return qmc.Sobol(len(keys), scramble=True, seed=seed).random_base2(max(0, (samples - 1).bit_length()))[:samples]
    streams = [np.random.default_rng([seed, zlib.crc32(key.encode())]) for key in keys]
    if method == "random":
        return np.stack([stream.random(samples) for stream in streams], axis=1)
    # One sample in each of n equal strata, in an independent random order for each key.
    return np.stack([(np.argsort(stream.random(samples)) + stream.random(samples)) / samples for stream in streams], axis=1)


def read_grid(where, section):
    names = list(section)
    columns = [read_values("%s: %s" % (where, name), section[name]) for name in names]
    return [dict(zip(names, row)) for row in limited_product(columns)]


def read_paired(where, section):
    columns = {name: read_values("%s: %s" % (where, name), values) for name, values in section.items()}
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        raise SweepError("%s: found lists of %s values; accepted: lists of one length" %
                         (where, ", ".join("%d (%s)" % (n, name) for name, n in lengths.items())))
    return [dict(zip(columns, row)) for row in zip(*columns.values())]


def read_samples(method, section):
    accepted = "accepted: samples: N, seed: S and keys: {KEY: DISTRIBUTION}"
    if set(section) - {"samples", "seed", "keys"}:
        raise SweepError("%s: found the key '%s'; %s" % (method, sorted(set(section) - {"samples", "seed", "keys"}, key=str)[0], accepted))
    samples, seed, keys = section.get("samples"), section.get("seed", 1), section.get("keys")
    if not (isinstance(samples, int) and not isinstance(samples, bool) and 1 <= samples <= MOST_RUNS):
        raise SweepError("%s: found samples: %s; accepted: a whole number from 1 to %d" % (method, samples, MOST_RUNS))
    if not (isinstance(seed, int) and not isinstance(seed, bool) and seed >= 0):
        raise SweepError("%s: found seed: %s; accepted: a whole number from 0" % (method, seed))
    if not (isinstance(keys, dict) and keys):
        raise SweepError("%s: found keys: %s; accepted: at least one KEY: DISTRIBUTION" % (method, keys))
    distributions = [Distribution("%s: %s" % (method, name), text) for name, text in keys.items()]
    return [{name: distribution.find(float(u)) for name, distribution, u in zip(keys, distributions, row)}
            for row in draw(method, samples, seed, list(keys))]


def limited_product(columns):
    if math.prod(len(column) for column in columns) > MOST_RUNS:
        raise SweepError("found %g runs; accepted: at most %g" % (math.prod(len(column) for column in columns), MOST_RUNS))
    return itertools.product(*columns)
