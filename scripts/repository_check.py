"""What the programs check_*.py do with their arguments and results."""
import os
import sys


def run(check_tree, test_self, nothing):
    """check_tree(repository) and test_self() return the problems and the number of what was checked; nothing: what to say if
    none was. Ends the program with status 1 if there is a problem."""
    if sys.argv[1:] == ["--self-test"]:
        problems, count = test_self()
    elif len(sys.argv) <= 2 and not sys.argv[-1].startswith("-"):
        here = os.path.dirname(os.path.realpath(__file__))
        problems, count = check_tree(sys.argv[1] if len(sys.argv) == 2 else os.path.dirname(here))
        if count == 0:
            problems = ["%s; give the repository's folder" % nothing]
    else:
        sys.exit("usage: %s [REPOSITORY | --self-test]" % os.path.basename(sys.argv[0]))
    for problem in problems:
        print(problem)
    print("%d checked, %d wrong" % (count, len(problems)))
    sys.exit(1 if problems else 0)
