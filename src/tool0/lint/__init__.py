"""What makes such set-ups fail, found in a person's files before they are run."""
