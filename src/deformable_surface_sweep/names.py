"""Unknown names in a plan: keys of the scene, columns, quantities, tools. They are refused before anything is run.
In contrast, a value that is wrong in one run may be valid in another."""
import re

from .errors import SweepError
from .reduce import check_names
from .simulator import Simulator

PATIENCE = 60.0  # s


def check_plan(sweep):
    """Checks the first run with the program, without running it."""
    plan = sweep.plan
    simulator = Simulator(sweep.program)
    try:
        said, columns = simulator.check(*sweep.describe_for_program(sweep.runs[0]), PATIENCE)
    finally:
        simulator.close()
    problems = [problem for problem in (translate(line, plan.fixed.keys() | set(plan.varied)) for line in said) if problem]
    if problems:
        raise SweepError(*problems)
    if columns:
        check_names("keep: statistics", plan.keep.statistics, columns)
    # A bag may bring tools and pins of any name.
    if not plan.bag:
        check_names("keep: wrenches", sorted({name.rpartition(".")[0] for name in plan.keep.wrenches}), sorted(sweep.reactions))


def translate(line, keys):
    """The program's sentence in terms of the plan; nothing if it is about values, or the scene."""
    if line.startswith("--measure: "):
        return "keep: measure: " + line[len("--measure: "):]
    path, is_unknown, rest = line.partition(": unknown key; ")
    if is_unknown and any((to_path(key) + ".").startswith(path + ".") for key in keys):
        return "found the key '%s' in the plan, which scenes have not; %s" % (path, rest)
    return ""


def to_path(key):
    """A dotted path with list items as `simulate` names them: name[index]."""
    return re.sub(r"\.(\d+)", r"[\1]", key)


def find_reactions(document):
    """The ids that occur in the wrench file of a scene."""
    tools, pins = ((document.get(name) or []) for name in ("tools", "pins"))
    yield from (tool["id"] for tool in tools if isinstance(tool, dict) and isinstance(tool.get("id"), str))
    yield from ("pins[%d]" % i for i in range(len(pins)))
