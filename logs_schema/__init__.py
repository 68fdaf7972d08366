"""The messages of the log, generated from the .proto files beside this module."""
