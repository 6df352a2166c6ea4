"""Shared by tests of messages: key, value and reason, in any words. The C++ tests have says.h."""

import re


def says(pattern):
    """A regular expression of the parts of `pattern`, which " ... " separates, in their order."""
    return ".*".join(re.escape(part) for part in pattern.split(" ... "))
