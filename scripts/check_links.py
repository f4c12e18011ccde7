#!/usr/bin/env python3
"""Checks that every relative link of the pages (*.md in the repository's folder and below docs) leads to a file of the repository and,
with an anchor, to a heading of that page. No renderer says this: a dead link just does nothing.
  check_links.py [REPOSITORY]    one line for each dead link, with its file and line; status 1 if there is any
  check_links.py --self-test     shows on made-up pages that each rule can fail"""
import glob
import os
import re
import tempfile

import repository_check

LINK = re.compile(r"\]\(([^)\s]+)\)")
FENCE = re.compile(r"\s*(```|~~~)")


def read_lines(path):
    """(number, line) of every line of a page that lies in no block of code."""
    fenced = False
    with open(path, encoding="utf-8") as stream:
        for number, line in enumerate(stream, 1):
            if FENCE.match(line):
                fenced = not fenced
            elif not fenced:
                yield number, line


def find_anchors(path):
    """The anchors that a viewer of Markdown gives to the headings of a page; equal ones are numbered from the second on."""
    counts, anchors = {}, set()
    for _, line in read_lines(path):
        match = re.match(r"#+ +(.*)", line)
        if not match:
            continue
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match.group(1)).strip().lower()
        anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        count = counts.get(anchor, 0)
        anchors.add("%s-%d" % (anchor, count) if count else anchor)
        counts[anchor] = count + 1
    return anchors


def check_link(repository, page, link):
    """What is wrong with a link on a page, or nothing."""
    file, _, anchor = link.partition("#")
    target = os.path.normpath(os.path.join(os.path.dirname(page), file)) if file else page
    path = os.path.join(repository, target)
    if target.startswith("..") or os.path.isabs(file):
        return "found a link out of the repository; accepted: a relative link to a file of it"
    if not os.path.exists(path):
        return "found no such file; accepted: a file or folder of the repository"
    if anchor and not (target.endswith(".md") and anchor in find_anchors(path)):
        return "found no such heading; accepted: the anchor of a heading of that page"
    return None


def check_tree(repository):
    """Sentences, one for each dead link, and the number of links read."""
    problems, count = [], 0
    found = glob.glob(os.path.join(repository, "*.md")) + glob.glob(os.path.join(repository, "docs", "**", "*.md"), recursive=True)
    for path in sorted(found):
        page = os.path.relpath(path, repository).replace(os.sep, "/")
        for number, line in read_lines(path):
            for link in LINK.findall(re.sub(r"`[^`]*`", "", line)):
                if re.match(r"\w+:", link):
                    continue
                count += 1
                rule = check_link(repository, page, link)
                if rule:
                    problems.append("%s:%d: %s: %s" % (page, number, link, rule))
    return problems, count


def test_self():
    """Each made-up line of docs/a.md and whether its link is dead. Returns the cases judged wrongly."""
    dead, alive = 1, 0
    cases = [
        ("[b](b.md)", alive),
        ("![b](images/b.png)", dead),
        ("[b](B.md)", dead),
        ("[b](../docs/b.md#two-words)", alive),
        ("[b](b.md#two-words-1)", alive),
        ("[b](b.md#two-words-2)", dead),
        ("[b](b.md#not-a-heading)", dead),
        ("[b](b.md#a-link-x_y)", alive),
        ("[the text\nends here](c.md)", dead),
        ("[a](#own)", alive),
        ("[a](#other)", dead),
        ("[folder](..)", alive),
        ("[folder](../..)", dead),
        ("[file](/etc/passwd)", dead),
        ("[site](https://example.org/c.md#c)", alive),
        ("`[](c.md)`", alive),
        ("```\n[c](c.md)\n```", alive),
    ]
    wrong = []
    for text, expected in cases:
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "docs"))
            with open(os.path.join(folder, "docs", "a.md"), "w") as stream:
                stream.write("# Own\n%s\n" % text)
            with open(os.path.join(folder, "docs", "b.md"), "w") as stream:
                stream.write("# Two words\n## Two words\n### [A link](a.md): `x_y`\n```\n# Not a heading\n```\n")
            problems, _ = check_tree(folder)
            if len(problems) != expected:
                wrong.append("%s: %s" % (text, problems))
    return wrong, len(cases)


if __name__ == "__main__":
    repository_check.run(check_tree, test_self, "no link found")
