"""Sub-commands of `viscache`, which finds them as entry points of `viscache.commands`."""
