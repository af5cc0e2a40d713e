"""Every operation on a running robot: one request, its response and one handler."""
