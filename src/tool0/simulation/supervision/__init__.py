"""Supervision of tracking errors and contacts, and identification of their causes."""
