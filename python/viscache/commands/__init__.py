"""The sub-commands of `viscache`, one module each, imported only when they run.

A module has `add_arguments(parser)` and `run(arguments) -> exit status`.
"""
