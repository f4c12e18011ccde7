#!/usr/bin/env python3
"""Draws what share of the machine's arithmetic and bandwidth each stage reaches, from the CSV of `scripts/benchmark --scale`.
  draw_roofline.py scale_roofline.csv PICTURE.png"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

MARKERS = "osD^v*P"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    peak, memory, near = (float(rows[0][name]) for name in ("peak_Gop_per_s", "memory_GB_per_s", "near_GB_per_s"))
    figure, axes = plt.subplots(figsize=(7.5, 5.0))
    intensity = np.logspace(-1.3, 1.3, 100)
    axes.plot(intensity, np.minimum(peak, memory * intensity), color="black", label="memory (triad), %.0f GB/s" % memory)
    axes.plot(intensity, np.minimum(peak, near * intensity), color="grey", linestyle="--", label="the core's own cache, %.0f GB/s" % near)
    axes.text(intensity[-1], peak * 1.05, "%.0f Gop/s, doubles" % peak, ha="right", fontsize=8)
    sizes = sorted({int(r["points"]) for r in rows})
    colours = plt.get_cmap("viridis")
    for marker, stage in zip(MARKERS, dict.fromkeys(r["stage"] for r in rows)):
        mine = [r for r in rows if r["stage"] == stage]
        exponents = [np.log10(int(r["points"])) for r in mine]
        axes.scatter([float(r["operations_per_byte"]) for r in mine], [float(r["Gop_per_s"]) for r in mine], marker=marker, s=45,
                     c=exponents, cmap=colours, vmin=np.log10(sizes[0]), vmax=np.log10(sizes[-1]), edgecolors="black", linewidths=0.5)
        axes.scatter([], [], marker=marker, color="white", edgecolors="black", label=stage)
    scale = plt.cm.ScalarMappable(cmap=colours, norm=plt.Normalize(np.log10(sizes[0]), np.log10(sizes[-1])))
    figure.colorbar(scale, ax=axes, label="log10 of the points")
    axes.set(xscale="log", yscale="log", xlabel="operations per byte", ylabel="operations, 1e9/s", title="Stages on one thread")
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(True, which="both", alpha=0.2)
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
