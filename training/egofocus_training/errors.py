"""The one exception of the training programs: what, where, what to do, and an exit code."""
import sys

USAGE = 2  # wrong command line
FILE = 3  # a file is missing, or cannot be read or written
BAD_FILE = 4  # a file is truncated or not what its name says
CONFIGURATION = 5  # a config that makes no sense, or a checkpoint of another network
DIVERGED = 8  # the loss is no longer a number


class TrainingError(Exception):
    """One line for people: "where: what. What to do". Comes through from a worker process as it is."""

    def __init__(self, exit_code, where, what):
        super().__init__(f"{where}: {what}")
        self.exit_code, self.where, self.what = exit_code, str(where), what

    def __reduce__(self):
        return TrainingError, (self.exit_code, self.where, self.what)


def run(main):
    """Runs a program's main(); a TrainingError becomes one line on stderr and its exit code."""
    try:
        sys.exit(main())
    except TrainingError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)
