"""Standard error without complaints of C code about nothing."""

import contextlib
import os
import re
import tempfile
from collections.abc import Iterator

_OF_LOG = re.compile(rb"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[")


@contextlib.contextmanager
def only_log_lines() -> Iterator[None]:
    """Drop the output of C code on standard error, except lines of the log.

    While a service or an action is made of messages that were generated without CMake,
    the middleware prints an error that it has handled itself, in tens of lines.
    """
    kept = os.dup(2)
    with tempfile.TemporaryFile() as written:
        os.dup2(written.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            written.seek(0)
            for line in written:
                if _OF_LOG.match(line):
                    os.write(2, line)
