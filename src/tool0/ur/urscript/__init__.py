"""URScript: grammar, checker, interpreter and library of the supported subset."""
