"""What is wrong with a plan or with the machines, in sentences for the user. A file of its own because every other file raises it."""


class SweepError(Exception):
    """Each problem is one line: what was found, what is accepted."""

    def __init__(self, *problems):
        super().__init__("; ".join(problems))
        self.problems = problems
