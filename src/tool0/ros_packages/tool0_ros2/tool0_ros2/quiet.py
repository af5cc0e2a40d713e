"""Suppresses unnecessary C output on standard error."""

import contextlib
import os
import re
import tempfile
from collections.abc import Iterator

_OF_LOG = re.compile(rb"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[")


@contextlib.contextmanager
def only_log_lines() -> Iterator[None]:
    """Drop the output of C code on standard error, but keep log lines.

    When a service or an action is created with messages that were generated without
    CMake, the middleware prints dozens of lines about an error that the middleware
    handles.
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
