"""Exit codes of the commands; 0 is success."""

FAILED = 1  # an episode failed, a pass rate is too low, or a replay differs
BAD_INPUT = 2  # or a full disk
ERROR = 3  # an episode broke off, or the program did
INTERRUPTED = 130  # as after Ctrl-C in a shell
