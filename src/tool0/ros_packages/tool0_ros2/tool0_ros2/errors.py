"""Errors of the connection to a bring-up."""


class TransportError(Exception):
    """Raised if a bring-up is not found, or if its socket cannot be trusted."""
