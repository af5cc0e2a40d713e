"""The grammar, checker, interpreter and library of a subset of URScript."""
