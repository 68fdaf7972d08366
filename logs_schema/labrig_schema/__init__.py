"""The messages of the log, generated from the .proto files beside this module.

Versions: `VERSION` is written into every log. A change that old readers can live with (a new field, a new
topic) keeps it; one that they cannot adds 1 to it and a function to `labrig.log`'s migrations, which bring
what an older log says of itself up to date when it is read. Field numbers are never used again.
"""

VERSION = 1

__all__ = ["VERSION"]
