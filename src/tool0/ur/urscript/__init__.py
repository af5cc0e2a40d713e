"""URScript: grammar, checker, interpreter and library of a subset of the language."""
