#!/usr/bin/env python3
"""Checks the lists of cmake/installed_headers.cmake: the public headers and those that they include are exactly the installed ones, and
docs/cpp_api.md describes exactly the public ones. No compiler checks this: in the source tree
every header is found.
  check_headers.py [REPOSITORY]    one line for each header that is wrong; status 1 if there is any
  check_headers.py --self-test     shows on made-up headers that each rule can fail"""
import os
import re

import repository_check

INCLUDE = re.compile(r'^\s*#\s*include\s*"deformable_surface/([^"]+)"', re.MULTILINE)
LISTED = "listed in cmake/installed_headers.cmake"


def find_problems(public, included, described, includes):
    """Sentences, one for each header that is wrong. `includes`: header -> headers of the project that it includes."""
    reached, waiting, problems = set(), list(public), []
    while waiting:
        header = waiting.pop()
        if header in reached:
            continue
        reached.add(header)
        if header not in includes:
            problems.append("%s: found no such header; accepted: one below include/deformable_surface" % header)
        waiting += includes.get(header, [])
    for header in sorted(reached - public - included):
        by = sorted(other for other in reached if header in includes.get(other, []))
        problems.append("%s: found an internal header that %s includes; accepted: one %s" % (header, by[0], LISTED))
    for header in sorted(included - reached):
        problems.append("%s: found in included_headers, but no public header includes it; accepted: an internal header" % header)
    for header in sorted(public & included):
        problems.append("%s: found in both lists; accepted: one of them" % header)
    for header in sorted(public - described):
        problems.append("%s: found no row in docs/cpp_api.md; accepted: a row for each public header" % header)
    for header in sorted(described - public):
        problems.append("%s: found in docs/cpp_api.md; accepted: public headers %s" % (header, LISTED))
    return problems


def read_list(text, name):
    return set(re.search(r"set\(%s\s+([^)]*)\)" % name, text).group(1).split())


def read_repository(repository):
    def read(*path):
        with open(os.path.join(repository, *path), encoding="utf-8") as stream:
            return stream.read()

    root = os.path.join(repository, "include", "deformable_surface")
    headers = [os.path.relpath(os.path.join(folder, name), root) for folder, _, names in os.walk(root) for name in names]
    includes = {header: INCLUDE.findall(read("include", "deformable_surface", header)) for header in headers}
    lists = read("cmake", "installed_headers.cmake")
    described = set(re.findall(r"^\| `([\w/]+\.h)`", read("docs", "cpp_api.md"), re.MULTILINE))
    return read_list(lists, "public_headers"), read_list(lists, "included_headers"), described, includes


def test_self():
    """Each made-up set of headers and how many problems it has. Returns the cases judged wrongly."""
    includes = {"a.h": ["b.h"], "b.h": [], "c.h": []}
    cases = [
        ({"a.h"}, {"b.h"}, {"a.h"}, 0),
        ({"a.h"}, set(), {"a.h"}, 1),            # b.h is internal
        ({"a.h"}, {"b.h", "c.h"}, {"a.h"}, 1),   # nothing includes c.h
        ({"a.h", "b.h"}, {"b.h"}, {"a.h", "b.h"}, 1),
        ({"a.h"}, {"b.h"}, set(), 1),            # a.h is not described
        ({"a.h"}, {"b.h"}, {"a.h", "b.h"}, 1),   # b.h is, but is not public
        ({"d.h"}, set(), {"d.h"}, 1),            # there is no d.h
    ]
    wrong = []
    for public, included, described, expected in cases:
        found = find_problems(public, included, described, includes)
        if len(found) != expected:
            wrong.append("%s, %s, %s: %s" % (public, included, described, found))
    return wrong, len(cases)


def check_tree(repository):
    public, included, described, includes = read_repository(repository)
    return find_problems(public, included, described, includes), len(public | included)


if __name__ == "__main__":
    repository_check.run(check_tree, test_self, "no header found")
