"""Entry point of the commands ``tool0`` and ``python -m tool0``."""

import signal
import sys


def main() -> int:
    """Run the command line of this process and return its exit status."""
    # By default, Python prints a KeyboardInterrupt traceback on Ctrl-C during an import
    # or at exit.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from tool0.cli import edge, main

    edge.open_standard_streams()
    return main()


if __name__ == "__main__":
    sys.exit(main())
