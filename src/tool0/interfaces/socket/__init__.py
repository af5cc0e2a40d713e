"""Another process drives a running bringup: JSON lines over a Unix socket.

One line is one request, ``{"id": 1, "method": "sim.step", "params": {"count": 5}}``,
and gets one answer, ``{"id": 1, "result": …}`` or ``{"id": 1, "error": {"type": …,
"message": …}}``.  The first request is ``hello``.  Answers may arrive out of order:
``goal.wait`` is answered when the goal ends.  ``methods.py`` lists the methods.
"""
