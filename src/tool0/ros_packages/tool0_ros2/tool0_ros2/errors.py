"""Errors of connections."""


class TransportError(Exception):
    """There is no bring-up of this name, or its socket cannot be trusted."""
