"""Problems of a plan or of the machines, in sentences for the user. Every other file raises this error."""


class SweepError(Exception):
    """Each problem is one line: what was found, what is accepted."""

    def __init__(self, *problems):
        super().__init__("; ".join(problems))
        self.problems = problems
