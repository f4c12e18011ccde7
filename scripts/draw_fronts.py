#!/usr/bin/env python3
"""Draws run time against error, one panel a scene, from the CSV of `scripts/benchmark --accuracy`.
  draw_fronts.py accuracy.csv PICTURE.png [PREFIX]
PREFIX: only scenes whose names begin so."""
import csv
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = {"verlet": "tab:blue", "symplectic_euler": "tab:cyan", "explicit_euler": "tab:grey", "implicit": "tab:red",
           "static": "tab:green", "default": "black"}


def draw_scene(axes, name, rows):
    sound = [r for r in rows if r["state"] == "sound"]
    errors = [float(r["total_rms"]) for r in sound if float(r["total_rms"]) > 0.0]
    # The truth itself has no error; it stands at the left edge. What is not sound stands at the right one.
    left, right = min(errors) / 3.0, max(errors) * 3.0
    largest = max(int(r["points"]) for r in rows)
    for method, colour in COLOURS.items():
        for r in rows:
            if r["method"] != method:
                continue
            is_sound = r["state"] == "sound"
            error = max(float(r["total_rms"]), left) if is_sound else right
            size = 10.0 + 60.0 * int(r["points"]) / largest
            axes.scatter(error, float(r["cpu_s"]), s=220 if method == "default" else size,
                         marker="*" if method == "default" else "o", edgecolors=colour,
                         facecolors=colour if is_sound else "none", alpha=0.8)
            if method == "default" and math.isfinite(float(r["limit_s"])) and is_sound:
                axes.plot([error / 2.0, error * 2.0], [float(r["limit_s"])] * 2, color="black", linewidth=2.0)
    # What is on the front within the noise of times is marked so in the table; the line is that of the least times.
    front = []
    for error, seconds in sorted((max(float(r["total_rms"]), left), float(r["cpu_s"])) for r in rows if r["front"] == "yes"):
        if not front or seconds < front[-1][1]:
            front.append((error, seconds))
    axes.plot([e for e, _ in front], [t for _, t in front], color="black", linewidth=0.8, drawstyle="steps-post")
    axes.set(xscale="log", yscale="log", title=name, xlabel="error, m rms over the cloud", ylabel="processor s of the run")
    axes.grid(True, which="major", alpha=0.3)


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    prefix = "".join(sys.argv[3:])
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        rows = [r for r in csv.DictReader(file) if r["scene"].startswith(prefix)]
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    if not scenes:
        sys.exit("draw_fronts.py: %s: no scene whose name begins with '%s'" % (sys.argv[1], prefix))
    columns, lines = min(3, len(scenes)), -(-len(scenes) // 3)
    height = 4.0 * lines + 0.6  # inches, the legend with it
    figure, axes = plt.subplots(lines, columns, figsize=(4.2 * columns, height), squeeze=False)
    for panel, scene in zip(axes.flat, scenes):
        draw_scene(panel, scene, [r for r in rows if r["scene"] == scene])
    for panel in axes.flat[len(scenes):]:
        panel.set_axis_off()
    used = [m for m in COLOURS if any(r["method"] == m for r in rows)]
    handles = [plt.Line2D([], [], linestyle="", marker="*" if m == "default" else "o", color=COLOURS[m], label=m) for m in used]
    handles.append(plt.Line2D([], [], linestyle="", marker="o", color="grey", markerfacecolor="none", label="not sound"))
    handles.append(plt.Line2D([], [], color="black", linewidth=0.8, label="front"))
    handles.append(plt.Line2D([], [], color="black", linewidth=2.0, label="limit of arithmetic, default"))
    figure.legend(handles=handles, loc="lower center", ncol=4)
    figure.tight_layout(rect=(0, 0.6 / height, 1, 1))
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
