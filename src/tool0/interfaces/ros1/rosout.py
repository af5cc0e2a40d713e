"""What tool0 logs, on /rosout, too."""

from __future__ import annotations

import logging
from typing import final


@final
class RosoutHandler(logging.Handler):
    """Passes warnings and errors on to rospy, which publishes them.

    A program that has not configured its logging goes on to see them on standard error.
    """

    def emit(self, record: logging.LogRecord) -> None:
        """Publish, and print where nobody else would."""
        import rospy

        say = rospy.logerr if record.levelno >= logging.ERROR else rospy.logwarn
        if not rospy.is_shutdown():
            say("%s", record.getMessage())
        if not logging.getLogger().handlers and logging.lastResort is not None:
            logging.lastResort.handle(record)


def forward_to_rosout() -> RosoutHandler:
    """Add the handler to our logger and return it."""
    handler = RosoutHandler(logging.WARNING)
    logging.getLogger("tool0").addHandler(handler)
    return handler
