"""Repetition of tests that disturb a job while it runs, for machines on which the job is over too early."""

import functools
import sys


class JobOverTooEarly(AssertionError):
    """A job was over before a test could disturb it: this machine is faster, or its disk slower, than was measured."""


def again_with_longer_jobs(test):
    """Repeats a test of a class with make_longer() while its jobs are over too early."""
    @functools.wraps(test)
    def repeated(self):
        for _ in range(4):
            try:
                return test(self)
            except JobOverTooEarly as reason:
                print("again with a longer job:", reason, file=sys.stderr)
                self.make_longer()
        return test(self)

    return repeated
