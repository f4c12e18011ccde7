#!/usr/bin/env python3
"""Draws the remaining coupling within parts and across gaps, one panel per cloud, from the CSV of
`scripts/benchmark --geodesics`.
  draw_geodesics.py geodesics_gaps.csv PICTURE.png"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = {"auto": "black", "4": "tab:orange", "8": "tab:red", "15": "tab:purple", "25": "tab:blue"}
JITTER = "0.2"  # the rows that are drawn; all are in the file


def draw_cloud(axes, name, rows):
    for form, colour in COLOURS.items():
        mine = [r for r in rows if r["geodesic_exponent"] == form]
        gaps = [float(r["gap"]) for r in mine]
        width = 2.2 if form == "auto" else 1.0
        axes.plot(gaps, [float(r["across"]) for r in mine], color=colour, linewidth=width, marker=".")
        axes.plot(gaps, [float(r["within"]) for r in mine], color=colour, linewidth=width, linestyle=":", marker=".")
    axes.set(title=name, xlabel="gap / spacing", ylabel="share of the coupling left", ylim=(-0.03, 1.03))
    axes.grid(True, alpha=0.3)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        rows = [r for r in csv.DictReader(file) if r["jitter"] == JITTER]
    clouds = list(dict.fromkeys(r["cloud"] for r in rows))
    columns = 4
    lines = -(-len(clouds) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(3.6 * columns, 3.2 * lines), squeeze=False)
    for panel, name in zip(axes.flat, clouds):
        draw_cloud(panel, name, [r for r in rows if r["cloud"] == name])
    for panel in list(axes.flat)[len(clouds):]:
        panel.axis("off")
    handles = [plt.Line2D([], [], color=c, linewidth=2.2 if f == "auto" else 1.0, label=f if f == "auto" else "exponent " + f)
               for f, c in COLOURS.items()]
    handles += [plt.Line2D([], [], color="grey", label="across the gap"),
                plt.Line2D([], [], color="grey", linestyle=":", label="within a part")]
    list(axes.flat)[-1].legend(handles=handles, loc="center")
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
