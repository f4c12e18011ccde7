#!/usr/bin/env python3
"""Checks that the folders below include/deformable_surface and src include only what the table of rooms in
CONTRIBUTING.md allows, that ROS, PCL, assimp and YAML are used in their rooms only, and that no line of a source is too long. No compiler
checks this.
  check_rooms.py [REPOSITORY]    one line for each forbidden include and long line; status 1 if there is any
  check_rooms.py --self-test     shows on made-up files that each rule can fail"""
import os
import re
import tempfile

import repository_check

PARAMETERS = r"(.*/)?\w+_params\.h"  # a file of plain values, which the readers of files may know

# Room: patterns of what it may include of this project, beside itself.
ROOMS = {
    "base": [],
    "linear": [r"base/.*"],
    "geometry": [r"base/.*"],
    "cloud": [r"(base|geometry)/.*"],
    "model": [r"(base|linear|geometry|cloud)/.*", r"contact/friction_anchors\.h"],
    "solve": [r"(base|linear)/.*", r"model/deformable_model\.h"],
    "contact": [r"(base|linear)/.*"],
    "tool": [r"(base|geometry|cloud)/.*"],
    "transfer": [r"(base|geometry|cloud)/.*"],
    "simulation": [r"(base|linear|geometry|cloud|model|solve|contact|tool|transfer)/.*"],
    "io": [r"(base|cloud)/.*", PARAMETERS],
    "ros/convert": [r"(?!ros/).*"],
    "ros/node": [r"(?!ros/).*", r"ros/convert/.*"],
    "ros/simulate": [r"(?!ros/).*", r"ros/convert/.*"],
    "ros/interactive_markers": [r"(?!ros/).*", r"ros/convert/.*"],
}

REGISTRY = "simulation/models/registry.cpp"

LONGEST = 130  # characters of a line

STANDARD = r"[a-z_0-9]+|([a-z]mmintrin|unistd|fcntl|sched)\.h|sys/\w+\.h"  # C++, the compiler's intrinsics, POSIX
# What comes from outside, and the files that may include it, as patterns of paths without include/deformable_surface or src.
OUTSIDE = [
    (STANDARD, r".*"),
    (r"Eigen/.*", r".*"),
    (r"yaml-cpp/.*", r"io/.*"),
    (r"(pcl|boost)/.*", r"io/(point_files|cloud_filters|quiet_pcl)\w*\..*"),
    (r"assimp/.*", r"io/mesh_files\.cpp"),
    (r".*", r"ros/.*"),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def find_room(path):
    """The room that a file lies in, as in "cloud" for "cloud/rings.cpp" and "ros/node" for "ros/node/inbox.h", or nothing."""
    parts = path.split("/")[:-1]
    return next((room for room in ("/".join(parts[:2]), "/".join(parts[:1])) if room in ROOMS), None)


def find_model(path):
    """The model in whose folder a file lies, below model or simulation/models, or nothing."""
    match = re.match(r"(?:model|simulation/models)/(\w+)/", path)
    return match.group(1) if match else None


def check_models(path, inner):
    """Each model sees itself alone, and only the registry sees them all; parameters are seen by everyone."""
    theirs = find_model(inner)
    if theirs in (None, find_model(path)) or path == REGISTRY or re.fullmatch(PARAMETERS, inner):
        return None
    return "a model is seen from its own folders and from the registry only"


def check_include(path, bracket, target, beside):
    """The rule that the include breaks, or nothing. `path` is the including file within its tree, as in "cloud/rings.cpp";
    `beside` says whether the target exists next to it."""
    prefix = "deformable_surface/"
    room = find_room(path)
    inner = target[len(prefix):] if target.startswith(prefix) else ""
    if beside and bracket == '"' and (target.startswith("../") or path == REGISTRY):
        inner = os.path.normpath(os.path.join(os.path.dirname(path), target))
    if not find_room(inner):
        if bracket == '"' and beside:
            return None if "/" not in target else "a file beside it is included by its bare name"
        if any(re.fullmatch(what, target) and re.fullmatch(who, path) for what, who in OUTSIDE):
            return None
        return "%s may not include this from outside the project" % room
    if not inner.startswith(room + "/") and not any(re.fullmatch(pattern, inner) for pattern in ROOMS[room]):
        return "%s may not include this" % room
    return check_models(path, inner)


def check_tree(repository):
    """Sentences, one for each forbidden include and each long line, and the number of files read."""
    problems, count = [], 0
    for top in ("include/deformable_surface", "src", "test", "benchmark"):
        in_rooms = top in ("include/deformable_surface", "src")
        base = os.path.join(repository, top)
        for folder, folders, names in os.walk(base):
            folders.sort()
            for name in sorted(names):
                if not name.endswith((".h", ".cpp")):
                    continue
                file = os.path.join(folder, name)
                path = os.path.relpath(file, base).replace(os.sep, "/")
                count += 1
                if in_rooms and not find_room(path):
                    problems.append("%s/%s: found a file in no room; accepted: %s" % (top, path, ", ".join(ROOMS)))
                    continue
                with open(file, encoding="utf-8") as stream:
                    for number, line in enumerate(stream, 1):
                        length = len(line.rstrip("\n"))
                        if length > LONGEST:
                            problems.append("%s/%s:%d: %d characters; accepted: %d" % (top, path, number, length, LONGEST))
                        match = INCLUDE.match(line) if in_rooms else None
                        if not match:
                            continue
                        beside = os.path.isfile(os.path.join(folder, match.group(2)))
                        rule = check_include(path, match.group(1), match.group(2), beside)
                        if rule:
                            problems.append("%s/%s:%d: %s: %s" % (top, path, number, match.group(2), rule))
    return problems, count


def test_self():
    """Each made-up file with an include and whether it is allowed. Returns the cases judged wrongly."""
    ours, refused, allowed = '"deformable_surface/%s"', False, True
    cases = [
        ("src/base/a.cpp", "<vector>", allowed),
        ("src/base/a.cpp", "<Eigen/Core>", allowed),
        ("src/base/b.cpp", ours % "cloud/kd_tree.h", refused),
        ("src/base/c.cpp", "<ros/ros.h>", refused),
        ("src/linear/a.cpp", ours % "base/simd.h", allowed),
        ("src/linear/b.cpp", ours % "geometry/region.h", refused),
        ("src/base/e.cpp", ours % "linear/lanczos.h", refused),
        ("src/cloud/e.cpp", ours % "linear/lanczos.h", refused),
        ("src/cloud/a.cpp", ours % "geometry/region.h", allowed),
        ("src/cloud/b.cpp", "<pcl/point_cloud.h>", refused),
        ("src/cloud/c.cpp", ours % "simulation/simulation.h", refused),
        ("src/cloud/d.cpp", "<boost/any.hpp>", refused),
        ("src/model/x/a.cpp", ours % "model/x/b.h", allowed),
        ("src/model/x/c.cpp", ours % "model/y/b.h", refused),
        ("src/model/d.cpp", ours % "model/x/b.h", refused),
        ("src/model/x/e.cpp", ours % "model/params.h", allowed),
        ("src/solve/a.cpp", ours % "model/deformable_model.h", allowed),
        ("src/solve/d.cpp", ours % "linear/lanczos.h", allowed),
        ("src/solve/b.cpp", ours % "model/x/b.h", refused),
        ("src/solve/c.cpp", ours % "cloud/kd_tree.h", refused),
        ("src/transfer/a.cpp", ours % "model/deformable_model.h", refused),
        ("src/simulation/a.cpp", ours % "model/x/b.h", refused),
        ("src/simulation/a.cpp", ours % "model/x/b_params.h", allowed),
        ("src/simulation/models/x/a.cpp", ours % "model/x/b.h", allowed),
        ("src/simulation/models/x/a.cpp", ours % "model/y/b.h", refused),
        ("src/simulation/models/x/a.cpp", ours % "simulation/b.h", allowed),
        ("src/simulation/models/registry.cpp", ours % "model/x/b.h", allowed),
        ("src/ros/node/f.cpp", ours % "model/x/b.h", refused),
        ("src/simulation/b.cpp", ours % "io/scene.h", refused),
        ("src/io/scene.cpp", "<yaml-cpp/yaml.h>", allowed),
        ("src/simulation/c.cpp", "<yaml-cpp/yaml.h>", refused),
        ("src/io/scene.h", ours % "simulation/scene_params.h", allowed),
        ("src/io/shapes.h", ours % "simulation/simulation.h", refused),
        ("src/io/point_files.cpp", "<pcl/io/pcd_io.h>", allowed),
        ("src/io/scene_pcl.cpp", "<pcl/io/pcd_io.h>", refused),
        ("src/ros/node/a.cpp", "<tf2_ros/buffer.h>", allowed),
        ("src/ros/node/b.cpp", ours % "Tool.h", allowed),
        ("src/ros/node/c.cpp", ours % "ros/convert/frames.h", allowed),
        ("src/ros/node/d.cpp", ours % "ros/node/surface_node.h", allowed),
        ("src/ros/node/e.cpp", ours % "simulation/simulation.h", allowed),
        ("src/ros/convert/a.cpp", ours % "ros/node/surface_node.h", refused),
        ("src/ros/simulate/a.cpp", ours % "ros/node/surface_node.h", refused),
        ("src/ros/simulate/b.cpp", ours % "ros/convert/frames.h", allowed),
        ("src/ros/interactive_markers/a.cpp", ours % "ros/convert/text_place.h", allowed),
        ("src/ros/interactive_markers/b.cpp", ours % "ros/node/message_pool.h", refused),
        ("src/ros/a.cpp", "<rosbag/bag.h>", refused),
        ("src/simulate.cpp", "<rosbag/bag.h>", refused),
        ("src/tool/a.cpp", "<tf2/LinearMath/Vector3.h>", refused),
        ("src/tool/b.cpp", ours % "Tool.h", refused),
        ("src/attic/a.cpp", "<vector>", refused),
        ("src/base/d.cpp", "<vector>  " + "//" * LONGEST, refused),
        ("test/base/a.cpp", "<vector>  " + "//" * LONGEST, refused),
        ("test/base/b.cpp", ours % "ros/convert/encode.h", allowed),
        ("include/deformable_surface/base/a.h", ours % "cloud/rings.h", refused),
    ]
    wrong = []
    for path, include, expected in cases:
        with tempfile.TemporaryDirectory() as folder:
            os.makedirs(os.path.join(folder, os.path.dirname(path)))
            with open(os.path.join(folder, path), "w") as stream:
                stream.write("#pragma once\n  #  include %s // why\n" % include)
            problems, _ = check_tree(folder)
            if (not problems) != expected:
                wrong.append("%s with %s should be %s" % (path, include, "allowed" if expected else "refused"))
    return wrong, len(cases)


if __name__ == "__main__":
    repository_check.run(check_tree, test_self, "no source file found")
