"""`cached_property` as Python has it from 3.12 on.

In Python 3.11 all instances of a class share one lock, so that the operators of two meshes would be computed
one after the other. Here threads that ask one instance at the same time may each compute the value.
"""

import sys

if sys.version_info >= (3, 12):
    from functools import cached_property
else:
    class cached_property:
        """A method whose value is computed once for each instance and kept there."""

        def __init__(self, make):
            self.make, self.__doc__ = make, make.__doc__

        def __set_name__(self, owner, name: str):
            self.name = name

        def __get__(self, instance, owner=None):
            if instance is None:
                return self
            kept = instance.__dict__
            if self.name not in kept:
                kept[self.name] = self.make(instance)
            return kept[self.name]

__all__ = ["cached_property"]
