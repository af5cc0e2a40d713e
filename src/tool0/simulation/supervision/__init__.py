"""Supervises whether joints follow and arms touch only allowed things; finds causes."""
