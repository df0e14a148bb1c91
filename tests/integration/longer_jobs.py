"""Repetition of tests that disturb a job while it runs, for machines on which the job is over too early."""

import functools
import sys


class JobOverTooEarly(AssertionError):
    """A job was over before a test could disturb it: this machine is faster, or its disk slower, than was measured."""


class LongerJobs:
    """First base of a class with tests that disturb jobs of the length `longer`."""

    longer = 1  # factor for the lengths of jobs
    growth = 2  # of `longer` in each repetition

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.take_jobs()

    @classmethod
    def take_jobs(cls):
        """Takes what depends on `longer`."""

    def make_longer(self):
        type(self).longer *= self.growth
        self.take_jobs()
        self.setUp()


def again_with_longer_jobs(test):
    """Repeats a test of LongerJobs while its jobs are over too early."""
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
