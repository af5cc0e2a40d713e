"""Errors of the connection to a bring-up."""


class TransportError(Exception):
    """Raised if there is no such bring-up, or if its socket cannot be trusted."""
