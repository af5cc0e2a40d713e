"""A real robot as the backend of its clients."""
